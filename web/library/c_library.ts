// SPDX-License-Identifier: Apache-2.0
// Calls the C interface: what classes over it have in common.
/// <reference lib="esnext.disposable" preserve="true" />

import { callback, integer, text, typed } from "./arguments.ts";
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
    text("extension", extension);
    const path = `/result${extension}`;
    write(path);
    const bytes = this.core.FS.readFile(path);
    this.core.FS.unlink(path);
    return bytes;
  }

  /** Makes a file for `read`, which gets its path. Messages of the library name the file as `name`. */
  withFile<T>(name: string, bytes: Uint8Array, read: (path: string) => T): T {
    const path = text("name", name).replaceAll("/", "_");
    this.core.FS.writeFile(path, typed("bytes", bytes, Uint8Array));
    try {
      return read(path);
    } finally {
      this.core.FS.unlink(path);
    }
  }

  /** Makes files for `use`, in folders that may be missing. */
  withFiles<T>(files: Record<string, Uint8Array>, use: () => T): T {
    const made: string[] = [];
    try {
      for (const [path, bytes] of Object.entries(files)) {
        typed(path, bytes, Uint8Array);
        this.core.FS.mkdirTree(`/${path}`.replace(/\/[^/]*$/, "") || "/");
        this.core.FS.writeFile(path, bytes);
        made.push(path);
      }
      return use();
    } finally {
      for (const path of made) this.core.FS.unlink(path);
    }
  }

  /** Runs `work`, and reports its progress.
   *
   * @param report returns false to cancel: `work` then throws an error for which isCancelled() holds. An exception
   *   of `report` cancels too, and withProgress() throws it
   * @param milliseconds least time between two reports
   */
  withProgress<T>(
    report: (progress: Progress) => boolean | void,
    work: () => T,
    milliseconds = 50,
  ): T {
    callback("report", report);
    callback("work", work);
    integer("milliseconds", milliseconds);
    const thrown: unknown[] = [];
    const reporter = this.core.addFunction((_user, at) => {
      if (thrown.length > 0) return 0;
      const [stage, done, count] = [0, 8, 16].map((offset) => longAt(this.core, at + offset));
      try {
        return report({ stage, done, count }) === false ? 0 : 1;
      } catch (error) {
        // C++ frames that do not expect it would be between the error and the caller.
        thrown.push(error);
        return 0;
      }
    }, "iii");
    try {
      const scope = this.create("espalier_progress_scope_create", reporter, 0, milliseconds);
      try {
        return work();
      } finally {
        this.destroy("progress_scope", scope);
      }
    } finally {
      this.core.removeFunction(reporter);
      if (thrown.length > 0) throw thrown[0];
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
    private readonly kind: string,
    parts: [string, number][] = [],
  ) {
    this.pointer = pointer;
    this.destroy = () => {
      for (const [each, address] of [[kind, pointer] as const, ...parts])
        library.destroy(each, address);
    };
    collected.register(this, this.destroy, this);
  }

  /** The address of an argument that must be an object of this kind.
   * @internal
   */
  static addressOf(argument: string, value: Handle, kind: string): number {
    if (!(value instanceof Handle) || value.kind !== kind)
      throw new TypeError(`${argument}: expected a ${kind} of Espalier`);
    return value.address;
  }

  /** Frees the memory of the object, which must not be used afterwards. */
  free(): void {
    if (this.pointer === 0) return;
    this.pointer = 0;
    collected.unregister(this);
    this.destroy();
    this.release();
  }

  /** Frees what it shares with other objects. */
  protected release(): void {}

  /** Frees it too, at the end of the block of `using object = …`. */
  [Symbol.dispose](): void {
    this.free();
  }

  /** The address of the object. */
  get address(): number {
    if (this.pointer === 0) throw new Error("this object has been freed");
    return this.pointer;
  }
}
