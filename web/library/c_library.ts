// SPDX-License-Identifier: Apache-2.0
// Calls the C interface: what classes over it have in common.

import { EspalierError, longAt, Scope, textAt, type CFunction, type Core } from "./memory.ts";

export interface Progress {
  /** number of stages that have ended */
  stage: number;
  /** number of items of this stage that are done, of `count` */
  done: number;
  count: number;
}

/** The functions of the C interface. */
export class CLibrary {
  readonly version: string;

  /** @internal */
  constructor(readonly core: Core) {
    this.version = textAt(core, this.function("espalier_version")());
  }

  /** A function of the C interface by its name. */
  function(name: string): CFunction {
    const found = (this.core as unknown as Record<string, CFunction>)[`_${name}`];
    if (!found) throw new Error(`the library has no function ${name}`);
    return found;
  }

  /** Calls a C function that returns a status.
   * @throws EspalierError with the message of the library
   */
  call(name: string, ...values: (number | bigint)[]): void {
    const status = this.function(name)(...values);
    if (status !== 0)
      throw new EspalierError(status, textAt(this.core, this.function("espalier_last_error")()));
  }

  /** Runs `use` with temporary memory. */
  scoped<T>(use: (scope: Scope) => T): T {
    const scope = new Scope(this.core);
    try {
      return use(scope);
    } finally {
      scope.free();
    }
  }

  /** Calls a C function whose last parameter receives a new object, and returns its address. */
  create(name: string, ...values: (number | bigint)[]): number {
    return this.scoped((scope) => {
      const out = scope.allocate(4);
      this.call(name, ...values, out);
      return this.core.HEAP32[out / 4];
    });
  }

  /** @internal @param kind of the object; "" frees memory of malloc() */
  destroy(kind: string, pointer: number): void {
    if (kind === "") this.core._free(pointer);
    else this.function(`espalier_${kind}_destroy`)(pointer);
  }

  /** Writes a file by `write`, which gets a path, and returns its bytes. */
  file(extension: string, write: (path: string) => void): Uint8Array {
    const path = `/result${extension}`;
    write(path);
    const bytes = this.core.FS.readFile(path);
    this.core.FS.unlink(path);
    return bytes;
  }

  /** Makes a file for `read`, which gets its path. Messages of the library name the file as `name`. */
  withFile<T>(name: string, bytes: Uint8Array, read: (path: string) => T): T {
    const path = name.replaceAll("/", "_");
    this.core.FS.writeFile(path, bytes);
    try {
      return read(path);
    } finally {
      this.core.FS.unlink(path);
    }
  }

  /** Runs `work`, and reports its progress.
   *
   * @param report returns false to cancel: `work` then throws an error for which isCancelled() holds
   * @param milliseconds least time between two reports
   */
  withProgress<T>(report: (progress: Progress) => boolean, work: () => T, milliseconds = 50): T {
    const callback = this.core.addFunction((_user, at) => {
      const [stage, done, count] = [0, 8, 16].map((offset) => longAt(this.core, at + offset));
      return report({ stage, done, count }) ? 1 : 0;
    }, "iii");
    try {
      const scope = this.create("espalier_progress_scope_create", callback, 0, milliseconds);
      try {
        return work();
      } finally {
        this.destroy("progress_scope", scope);
      }
    } finally {
      this.core.removeFunction(callback);
    }
  }
}

const collected = new FinalizationRegistry<() => void>((destroy) => destroy());

/** An object of the library. */
export abstract class Handle {
  private pointer: number;
  private readonly destroy: () => void;

  /** @param parts objects that are destroyed with it, by kind and address */
  constructor(
    protected readonly library: CLibrary,
    pointer: number,
    kind: string,
    parts: [string, number][] = [],
  ) {
    this.pointer = pointer;
    this.destroy = () => {
      for (const [each, address] of [[kind, pointer] as const, ...parts])
        library.destroy(each, address);
    };
    collected.register(this, this.destroy, this);
  }

  /** Frees the memory of the object, which must not be used afterwards. */
  free(): void {
    if (this.pointer === 0) return;
    this.pointer = 0;
    collected.unregister(this);
    this.destroy();
  }

  /** The address of the object. */
  get address(): number {
    if (this.pointer === 0) throw new Error("this object has been freed");
    return this.pointer;
  }
}
