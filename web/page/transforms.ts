// SPDX-License-Identifier: Apache-2.0
// Moves vertices: the operations of `espalier pose` (shapes/pose.h, which gives the formulas), with the
// options that do the same in the program.

import type { Point } from "../library/espalier.ts";

export type Axis = "x" | "y" | "z";
export const kAxes: readonly Axis[] = ["x", "y", "z"];
const numberOf = (axis: Axis) => kAxes.indexOf(axis);

export type Transform =
  | { kind: "move"; offset: Point }
  | { kind: "rotate"; axis: Axis; degrees: number }
  | { kind: "scale"; factors: Point }
  | { kind: "twist"; axis: Axis; degrees: number }
  | { kind: "bend"; axis: Axis; degrees: number }
  | { kind: "taper"; axis: Axis; factor: number };

/** Vertices with weights above 0, and how the weights were made. */
export interface Weights {
  /** one for each vertex, 0 to 1 */
  values: Float64Array;
  /** the vertices with weight 1 */
  selection: readonly number[];
  /** radius of the soft selection, 0 for none */
  radius: number;
}

/** Weights that fall smoothly from 1 at the selected vertices to 0 at a distance from them. */
export function softWeights(
  positions: Float64Array,
  selection: readonly number[],
  radius: number,
): Weights {
  const count = positions.length / 3;
  const values = new Float64Array(count);
  for (const v of selection) values[v] = 1;
  if (radius > 0)
    for (let v = 0; v < count; ++v) {
      let least = Infinity;
      for (const s of selection) least = Math.min(least, distance(positions, v, s));
      const u = least / radius;
      if (u < 1) values[v] = 1 - u * u * (3 - 2 * u);
    }
  return { values, selection, radius };
}

function distance(positions: Float64Array, a: number, b: number): number {
  const [x, y, z] = [0, 1, 2].map((c) => positions[3 * a + c] - positions[3 * b + c]);
  return Math.sqrt(x * x + y * y + z * z);
}

/** The least and largest coordinate of the vertices with weights above 0. */
function interval(positions: Float64Array, weights: Float64Array, axis: number): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  weights.forEach((weight, v) => {
    if (weight <= 0) return;
    low = Math.min(low, positions[3 * v + axis]);
    high = Math.max(high, positions[3 * v + axis]);
  });
  return [low, high];
}

/** The middle of the box around the vertices with weights above 0: the centre of all operations. */
export function centerOf(positions: Float64Array, weights: Float64Array): Point {
  return [0, 1, 2].map((axis) => {
    const [low, high] = interval(positions, weights, axis);
    return low + 0.5 * (high - low);
  }) as Point;
}

const kNoVertices = "select vertices first";

/** Returns the positions after an operation. Throws if no vertex is selected, or if a twist, bend or
 * taper has no length to grow along. */
export function transformed(
  positions: Float64Array,
  weights: Weights,
  transform: Transform,
): Float64Array {
  if (weights.selection.length === 0) throw new Error(kNoVertices);
  const center = centerOf(positions, weights.values);
  const map = mapOf(transform, positions, weights.values, center);
  const result = positions.slice();
  weights.values.forEach((weight, v) => {
    if (weight <= 0) return;
    const p: Point = [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
    result.set(map(p, weight), 3 * v);
  });
  return result;
}

type Map = (point: Point, weight: number) => Point;

function mapOf(
  transform: Transform,
  positions: Float64Array,
  weights: Float64Array,
  center: Point,
): Map {
  switch (transform.kind) {
    case "move": {
      const { offset } = transform;
      return (p, w) => p.map((x, i) => x + w * offset[i]) as Point;
    }
    case "scale": {
      const { factors } = transform;
      return (p, w) => p.map((x, i) => x + w * (factors[i] - 1) * (x - center[i])) as Point;
    }
    case "rotate": {
      const axis = numberOf(transform.axis);
      const angle = radians(transform.degrees);
      return (p, w) => rotated(p, axis, center, w * angle);
    }
    case "twist": {
      const axis = numberOf(transform.axis);
      const angle = radians(transform.degrees);
      const fraction = fractionAlong(positions, weights, axis);
      return (p, w) => rotated(p, axis, center, w * angle * fraction(p[axis]));
    }
    case "taper": {
      const axis = numberOf(transform.axis);
      const fraction = fractionAlong(positions, weights, axis);
      return (p, w) => {
        const change = w * (transform.factor - 1) * fraction(p[axis]);
        return p.map((x, i) => (i === axis ? x : x + change * (x - center[i]))) as Point;
      };
    }
    case "bend":
      return bendOf(positions, weights, transform, center);
  }
}

const radians = (degrees: number) => (degrees * Math.PI) / 180;

/** Turns a point about a coordinate axis through the centre, anticlockwise seen from its tip. */
function rotated(p: Point, axis: number, center: Point, angle: number): Point {
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
  const [du, dv] = [p[u] - center[u], p[v] - center[v]];
  const result: Point = [...p];
  result[u] = center[u] + (cosine * du - sine * dv);
  result[v] = center[v] + (sine * du + cosine * dv);
  return result;
}

function rangeAlong(positions: Float64Array, weights: Float64Array, axis: number) {
  const [low, high] = interval(positions, weights, axis);
  if (!(high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high))))
    throw new Error("the selected vertices are all at one place along the axis");
  return [low, high];
}

function fractionAlong(positions: Float64Array, weights: Float64Array, axis: number) {
  const [low, high] = rangeAlong(positions, weights, axis);
  return (s: number) => Math.min(1, Math.max(0, (s - low) / (high - low)));
}

const sinc = (x: number) => (x === 0 ? 1 : Math.sin(x) / x);

/** Bends the axis into an arc of a circle, towards the next axis. */
function bendOf(
  positions: Float64Array,
  weights: Float64Array,
  { axis, degrees }: { axis: Axis; degrees: number },
  center: Point,
): Map {
  const along = numberOf(axis);
  const across = (along + 1) % 3;
  const [low, high] = rangeAlong(positions, weights, along);
  return (p, w) => {
    const r = p[across] - center[across];
    const inside = Math.min(high, Math.max(low, p[along])) - low;
    const beyond = p[along] - low - inside;
    const theta = (w * radians(degrees) * inside) / (high - low);
    const result: Point = [...p];
    result[along] =
      low + inside * sinc(theta) - Math.sin(theta) * r + Math.cos(theta) * beyond;
    result[across] =
      center[across] +
      inside * Math.sin(theta / 2) * sinc(theta / 2) +
      Math.cos(theta) * r +
      Math.sin(theta) * beyond;
    return result;
  };
}

/** The options of `espalier pose` for an operation. */
export function optionsOf(weights: Weights, transform: Transform): string {
  const all = weights.selection.length === weights.values.length;
  const select = all ? "--select-all" : `--select vertices ${weights.selection.join(" ")}`;
  const falloff = weights.radius > 0 && !all ? ` --falloff smooth ${weights.radius}` : "";
  return `${select}${falloff} ${operation(transform)}`;
}

function operation(transform: Transform): string {
  switch (transform.kind) {
    case "move":
      return `--move ${transform.offset.join(" ")}`;
    case "scale":
      return `--scale ${transform.factors.join(" ")}`;
    case "taper":
      return `--taper ${transform.axis} ${transform.factor}`;
    default:
      return `--${transform.kind} ${transform.axis} ${transform.degrees}`;
  }
}

/** Gives selected vertices the mirror images of the vertices on the other side of the middle plane of
 * the rest lattice, across an axis. */
export function mirrored(
  rest: Float64Array,
  positions: Float64Array,
  selection: readonly number[],
  axis: Axis,
): Float64Array {
  if (selection.length === 0) throw new Error(kNoVertices);
  const along = numberOf(axis);
  const count = rest.length / 3;
  const all = new Float64Array(count).fill(1);
  const [low, high] = interval(rest, all, along);
  const extents = [0, 1, 2].map((c) => interval(rest, all, c));
  const size = Math.hypot(...extents.map(([from, to]) => to - from));
  const result = positions.slice();
  const missing: number[] = [];
  for (const v of selection) {
    const image = [...rest.subarray(3 * v, 3 * v + 3)];
    image[along] = low + high - image[along];
    const partner = vertexAt(rest, image, 1e-3 * size);
    if (partner < 0) missing.push(v);
    else {
      result.set(positions.subarray(3 * v, 3 * v + 3), 3 * partner);
      result[3 * partner + along] = low + high - positions[3 * v + along];
    }
  }
  if (missing.length === selection.length)
    throw new Error(
      `the lattice at rest is not symmetric across ${axis}: no selected vertex has a partner on the other side`,
    );
  return result;
}

function vertexAt(positions: Float64Array, place: number[], tolerance: number): number {
  for (let v = 0; v < positions.length / 3; ++v)
    if (Math.hypot(...[0, 1, 2].map((c) => positions[3 * v + c] - place[c])) <= tolerance) return v;
  return -1;
}
