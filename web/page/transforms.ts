// SPDX-License-Identifier: Apache-2.0
// The parts of the vertices in an operation, the options of `espalier pose` that do the same, and mirror
// images. The worker does the operations themselves.

import type { Point } from "../library/espalier.ts";
import type { Axis, Transform } from "./protocol.ts";

export const kAxes: readonly Axis[] = ["x", "y", "z"];

/** Vertices with weights above 0, and how the weights were made. */
export interface Weights {
  /** one for each vertex, 0 to 1 */
  values: Float64Array;
  /** the vertices with weight 1 */
  selection: readonly number[];
  /** radius of the soft selection, 0 for none */
  radius: number;
}

/** Weights that fall smoothly from 1 at the selected vertices to 0 at a distance from them, which is measured
 * in the lattice at rest: so the neighbours of a vertex stay its neighbours. */
export function softWeights(
  rest: Float64Array,
  selection: readonly number[],
  radius: number,
): Weights {
  const count = rest.length / 3;
  const values = new Float64Array(count);
  for (const v of selection) values[v] = 1;
  if (radius > 0)
    for (let v = 0; v < count; ++v) {
      let least = Infinity;
      for (const s of selection) least = Math.min(least, distance(rest, v, s));
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
export function centerOf(
  positions: Float64Array,
  weights = new Float64Array(positions.length / 3).fill(1),
): Point {
  return [0, 1, 2].map((axis) => {
    const [low, high] = interval(positions, weights, axis);
    return low + 0.5 * (high - low);
  }) as Point;
}

/** The options of `espalier pose` for operations. */
export function optionsOf(weights: Weights, transforms: readonly Transform[]): string {
  const all = weights.selection.length === weights.values.length;
  const select = all ? "--select-all" : `--select vertices ${weights.selection.join(" ")}`;
  const falloff = weights.radius > 0 && !all ? ` --falloff smooth ${weights.radius}` : "";
  return [`${select}${falloff}`, ...transforms.map(operation)].join(" ");
}

function operation(transform: Transform): string {
  if (transform.kind === "move") return `--move ${transform.offset.join(" ")}`;
  if (transform.kind === "mirror") return `--mirror ${transform.axis}`;
  const about = transform.center ? `--center ${transform.center.join(" ")} ` : "";
  switch (transform.kind) {
    case "scale":
      return `${about}--scale ${transform.factors.join(" ")}`;
    case "taper":
      return `${about}--taper ${transform.axis} ${transform.factor}`;
    default:
      return `${about}--${transform.kind} ${transform.axis} ${transform.degrees}`;
  }
}

/** The middle of the box around selected vertices. */
export function middleOf(positions: Float64Array, selection: readonly number[]): Point {
  const weights = new Float64Array(positions.length / 3);
  for (const v of selection) weights[v] = 1;
  return centerOf(positions, weights);
}
