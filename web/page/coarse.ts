// SPDX-License-Identifier: Apache-2.0
// Makes the coarse model that is drawn in place of a large one while it is dragged.

import type { Coarse, DrawnModel } from "./protocol.ts";

/** Models with more points are drawn coarsely during a drag. */
const kManyPoints = 200_000;
/** Cubes along the longest side of the model, each of which keeps one point: a few pixels of a screen each. */
const kCubes = 160;

/** One point for each cube of a grid that has points, and the triangles that are left between different ones.
 * @return null for a model that is small enough
 */
export function coarseModel(points: Float64Array, drawn: DrawnModel): Coarse | null {
  const count = points.length / 3;
  if (count <= kManyPoints) return null;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  const scale = kCubes / (Math.max(...high.map((x, c) => x - low[c])) || 1);
  const cube = (point: number, c: number) =>
    Math.min(kCubes - 1, Math.floor((points[3 * point + c] - low[c]) * scale));

  const numberOfCube = new Int32Array(kCubes ** 3).fill(-1);
  const numbers = new Uint32Array(count);
  const chosen: number[] = [];
  for (let point = 0; point < count; ++point) {
    const at = cube(point, 0) + kCubes * (cube(point, 1) + kCubes * cube(point, 2));
    if (numberOfCube[at] < 0) numberOfCube[at] = chosen.push(point) - 1;
    numbers[point] = numberOfCube[at];
  }
  const corner = (i: number) => {
    const vertex = drawn.triangles[i];
    return numbers[vertex < count ? vertex : drawn.copies[vertex - count]];
  };
  const triangles: number[] = [];
  for (let i = 0; i < drawn.triangles.length; i += 3) {
    const [a, b, c] = [corner(i), corner(i + 1), corner(i + 2)];
    if (a !== b && b !== c && c !== a) triangles.push(a, b, c);
  }
  return { points: Uint32Array.from(chosen), triangles: Uint32Array.from(triangles) };
}
