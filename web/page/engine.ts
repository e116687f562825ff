// SPDX-License-Identifier: Apache-2.0
/// <reference types="vite/client" />
// Gives jobs to the worker, and can end it: WebAssembly cannot be interrupted in any other way.

import type { Answer, JobName, Jobs, Request, Start } from "./protocol.ts";
import LibraryWorker from "./worker.ts?worker&inline";

/** A job that was cancelled, and jobs that waited behind it, fail with this. */
export class Cancelled extends Error {
  constructor() {
    super("cancelled");
    this.name = "Cancelled";
  }
}

interface Waiting {
  job: JobName;
  resolve(result: unknown): void;
  reject(error: Error): void;
}

export class Engine {
  /** Called when a worker starts without any model or lattice. */
  onRestart: () => void = () => {};
  /** Called with the part of a job that is done, 0 to 1. */
  onProgress: (job: JobName, done: number) => void = () => {};
  /** Called when the first job begins to wait, and when no job is left. */
  onBusy: (job: JobName | null) => void = () => {};

  private readonly module: Promise<WebAssembly.Module>;
  private worker: Worker;
  private readonly waiting = new Map<number, Waiting>();
  private lastId = 0;

  constructor(wasm: Promise<Uint8Array>) {
    this.module = wasm.then((bytes) => WebAssembly.compile(bytes as BufferSource));
    this.worker = this.start();
  }

  private start(): Worker {
    const worker = new LibraryWorker();
    worker.addEventListener("message", ({ data }: MessageEvent<Answer>) => this.receive(data));
    worker.addEventListener("error", (event) => this.fail(new Error(event.message)));
    this.module.then(
      (module) => worker.postMessage({ module } satisfies Start),
      () => {}, // run() reports it.
    );
    return worker;
  }

  /** Does a job after the jobs before it. */
  run<Name extends JobName>(
    job: Name,
    ...values: Parameters<Jobs[Name]>
  ): Promise<ReturnType<Jobs[Name]>> {
    const id = ++this.lastId;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { job, resolve: resolve as (result: unknown) => void, reject });
      if (this.waiting.size === 1) this.onBusy(job);
      this.worker.postMessage({ id, job, values } satisfies Request<Name>);
      this.module.catch((error) => this.fail(error));
    });
  }

  /** Cancels all jobs, which fail with Cancelled. */
  cancel(): void {
    this.worker.terminate();
    this.worker = this.start();
    this.onRestart();
    this.fail(new Cancelled());
  }

  private receive(answer: Answer): void {
    const waiting = this.waiting.get(answer.id);
    if (!waiting) return;
    if ("progress" in answer) {
      this.onProgress(waiting.job, answer.progress);
      return;
    }
    this.waiting.delete(answer.id);
    const [next] = this.waiting.values();
    this.onBusy(next?.job ?? null);
    if ("error" in answer) waiting.reject(new Error(answer.error));
    else waiting.resolve(answer.result);
  }

  private fail(error: Error): void {
    const all = [...this.waiting.values()];
    this.waiting.clear();
    this.onBusy(null);
    for (const each of all) each.reject(error);
  }
}
