// SPDX-License-Identifier: Apache-2.0
// Passes values between JavaScript and the memory of the WebAssembly module.

/** The module that web/CMakeLists.txt builds: the functions of the C headers, and its memory. */
export interface Core {
  HEAPU8: Uint8Array;
  HEAP8: Int8Array;
  HEAP32: Int32Array;
  HEAPF32: Float32Array;
  HEAPF64: Float64Array;
  _malloc(size: number): number;
  _free(pointer: number): void;
  FS: {
    writeFile(path: string, bytes: Uint8Array): void;
    readFile(path: string): Uint8Array;
    unlink(path: string): void;
    mkdirTree(path: string): void;
  };
  addFunction(callback: (...values: number[]) => number | void, signature: string): number;
  removeFunction(pointer: number): void;
}

/** A function of the C interface. 64-bit integers are bigint. */
export type CFunction = (...values: (number | bigint)[]) => number;

/** An error of the library, with the message that it gave. */
export class EspalierError extends Error {
  /** ESPALIER_ERROR_... or ESPALIER_CANCELLED (c/espalier.h) */
  readonly status: number;

  constructor(status: number, message: string) {
    super(message);
    this.name = "EspalierError";
    this.status = status;
  }
}

const kCancelled = 4;
export const isCancelled = (error: unknown) =>
  error instanceof EspalierError && error.status === kCancelled;

/** The type of a field of a C struct: the size of the struct, an integer of 32 or 64 bits, a double or
 * a pointer. */
export type FieldType = "size" | "i32" | "i64" | "f64" | "pointer";

/** Temporary memory of one call. `free` frees all of it. */
export class Scope {
  private readonly blocks: number[] = [];

  constructor(private readonly core: Core) {}

  allocate(size: number): number {
    const pointer = this.core._malloc(Math.max(size, 1));
    if (pointer === 0) throw new EspalierError(3, `there is no memory for ${size} bytes`);
    this.blocks.push(pointer);
    return pointer;
  }

  free(): void {
    for (const block of this.blocks) this.core._free(block);
  }

  doubles(values: ArrayLike<number>): number {
    const pointer = this.allocate(8 * values.length);
    this.core.HEAPF64.set(values, pointer / 8);
    return pointer;
  }

  floats(values: ArrayLike<number>): number {
    const pointer = this.allocate(4 * values.length);
    this.core.HEAPF32.set(values, pointer / 4);
    return pointer;
  }

  integers(values: ArrayLike<number>): number {
    const pointer = this.allocate(4 * values.length);
    this.core.HEAP32.set(values, pointer / 4);
    return pointer;
  }

  /** 64-bit integers, each below 2^53 */
  longs(values: ArrayLike<number>): number {
    const pointer = this.allocate(8 * values.length);
    for (let i = 0; i < values.length; ++i) this.setLong(pointer + 8 * i, values[i]);
    return pointer;
  }

  private setLong(at: number, value: number): void {
    this.core.HEAP32[at / 4] = value | 0;
    this.core.HEAP32[at / 4 + 1] = Math.floor(value / 2 ** 32);
  }

  bytes(values: Uint8Array): number {
    const pointer = this.allocate(values.length);
    this.core.HEAPU8.set(values, pointer);
    return pointer;
  }

  text(value: string): number {
    const bytes = new TextEncoder().encode(value);
    const pointer = this.allocate(bytes.length + 1);
    this.core.HEAPU8.set(bytes, pointer);
    this.core.HEAPU8[pointer + bytes.length] = 0;
    return pointer;
  }

  /** A struct with these fields, laid out as C does. */
  struct(fields: [FieldType, number?][]): number {
    let size = 0;
    let alignment = 4;
    const places = fields.map(([type]) => {
      const width = type === "f64" || type === "i64" ? 8 : 4;
      alignment = Math.max(alignment, width);
      size = Math.ceil(size / width) * width;
      size += width;
      return size - width;
    });
    size = Math.ceil(size / alignment) * alignment;
    const pointer = this.allocate(size);
    fields.forEach(([type, value = 0], i) => {
      const at = pointer + places[i];
      if (type === "f64") this.core.HEAPF64[at / 8] = value;
      else if (type === "i64") this.setLong(at, value);
      else this.core.HEAP32[at / 4] = type === "size" ? size : value;
    });
    return pointer;
  }
}

/** Reads a null-terminated text. */
export function textAt(core: Core, pointer: number): string {
  let end = pointer;
  while (core.HEAPU8[end] !== 0) ++end;
  return new TextDecoder().decode(core.HEAPU8.slice(pointer, end));
}

/** Copies numbers from the memory of the module. */
export const doublesAt = (core: Core, pointer: number, count: number) =>
  core.HEAPF64.slice(pointer / 8, pointer / 8 + count);
export const floatsAt = (core: Core, pointer: number, count: number) =>
  core.HEAPF32.slice(pointer / 4, pointer / 4 + count);
export const integersAt = (core: Core, pointer: number, count: number) =>
  core.HEAP32.slice(pointer / 4, pointer / 4 + count);
export const bytesAt = (core: Core, pointer: number, count: number) =>
  core.HEAPU8.slice(pointer, pointer + count);

/** Reads a 64-bit integer, below 2^53. */
export const longAt = (core: Core, pointer: number) =>
  (core.HEAP32[pointer / 4] >>> 0) + 2 ** 32 * core.HEAP32[pointer / 4 + 1];
export function longsAt(core: Core, pointer: number, count: number): Int32Array {
  const result = new Int32Array(count);
  for (let i = 0; i < count; ++i) result[i] = longAt(core, pointer + 8 * i);
  return result;
}
