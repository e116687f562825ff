// SPDX-License-Identifier: Apache-2.0
// Checks the arguments of a call, for callers without TypeScript. The library would read memory of others for an array
// that is too short, and JavaScript turns a text into 0. Each function returns the argument, or throws a TypeError or
// (for a length) a RangeError that names the argument.

/** A value as messages show it. */
function shown(value: unknown): string {
  if (typeof value === "string") return JSON.stringify(value);
  if (typeof value === "bigint") return `the BigInt ${value}n`;
  if (typeof value === "function") return "a function";
  if (typeof value !== "object" || value === null) return String(value);
  const kind = Object.prototype.toString.call(value).slice("[object ".length, -1);
  return `${/^[AEIO]/.test(kind) ? "an" : "a"} ${kind}`;
}

function refuse(name: string, expected: string, value: unknown): never {
  throw new TypeError(`${name}: expected ${expected}, got ${shown(value)}`);
}

export function real(name: string, value: number): number {
  return typeof value === "number" ? value : refuse(name, "a number", value);
}

const isInteger = (value: unknown) => typeof value === "number" && (value | 0) === value;

/** An integer of 32 bits. */
export function integer(name: string, value: number): number {
  return isInteger(value) ? value : refuse(name, "an integer of 32 bits", value);
}

/** 1 for true, 0 for false. */
export function flag(name: string, value: boolean): number {
  return typeof value === "boolean" ? Number(value) : refuse(name, "true or false", value);
}

export function text(name: string, value: string): string {
  return typeof value === "string" ? value : refuse(name, "a string", value);
}

/** The place of a word among the words that are possible. */
export function choice<Word extends string>(
  name: string,
  value: Word,
  words: readonly Word[],
): number {
  const place = words.indexOf(value);
  return place >= 0 ? place : refuse(name, words.map(shown).join(" or "), value);
}

export function callback<Function>(name: string, value: Function): Function {
  return typeof value === "function" ? value : refuse(name, "a function", value);
}

export function options<Options extends object>(name: string, value: Options): Options {
  const isPlain = typeof value === "object" && value !== null && !isList(value);
  return isPlain ? value : refuse(name, "an object", value);
}

/** A typed array of this class. */
export function typed<Values>(name: string, value: Values, type: new () => Values): Values {
  return value instanceof type ? value : refuse(name, `a ${type.name}`, value);
}

const isList = (value: unknown): value is ArrayLike<unknown> =>
  typeof value === "object" &&
  value !== null &&
  Number.isInteger((value as ArrayLike<unknown>).length);

/** The list, whose length is `count` if that is given. */
export function list<Item>(
  name: string,
  values: ArrayLike<Item>,
  count?: number,
): ArrayLike<Item> {
  if (!isList(values)) refuse(name, "an array", values);
  if (count !== undefined && values.length !== count)
    throw new RangeError(`${name}: expected ${count} numbers, got ${values.length}`);
  return values;
}

const isTypedArray = (value: ArrayLike<number>) => ArrayBuffer.isView(value);

/** Numbers, `count` of them if that is given. */
export function numbers(
  name: string,
  values: ArrayLike<number>,
  count?: number,
): ArrayLike<number> {
  list(name, values, count);
  // All items of a typed array are numbers if one is: only those of 64 bits are BigInt.
  const checked = isTypedArray(values) ? Math.min(1, values.length) : values.length;
  for (let i = 0; i < checked; ++i) real(`${name}[${i}]`, values[i]);
  return values;
}

/** Integers of 32 bits, `count` of them if that is given. */
export function integers(
  name: string,
  values: ArrayLike<number>,
  count?: number,
): ArrayLike<number> {
  list(name, values, count);
  if (!(values instanceof Int32Array))
    for (let i = 0; i < values.length; ++i) integer(`${name}[${i}]`, values[i]);
  return values;
}

/** How many points have these coordinates. */
export function countPoints(name: string, coordinates: ArrayLike<number>): number {
  numbers(name, coordinates);
  if (coordinates.length % 3 !== 0)
    throw new RangeError(`${name}: expected 3 numbers for each point, got ${coordinates.length}`);
  return coordinates.length / 3;
}
