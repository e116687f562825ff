// SPDX-License-Identifier: Apache-2.0
// Fills geometries of three.js.

import * as THREE from "three";

export function attribute(
  geometry: THREE.BufferGeometry,
  name: string,
  array: Float32Array,
  size: number,
) {
  geometry.setAttribute(name, new THREE.BufferAttribute(array, size));
}

/** Replaces an attribute, or its numbers if there are as many.
 * @param copies vertices that are stored a second time, after all others
 */
export function setPositions(
  geometry: THREE.BufferGeometry,
  positions: Float32Array,
  copies: Uint32Array = new Uint32Array(0),
): void {
  const length = positions.length + 3 * copies.length;
  if (geometry.getAttribute("position")?.array.length !== length)
    attribute(geometry, "position", new Float32Array(length), 3);
  const { array } = geometry.getAttribute("position") as THREE.BufferAttribute;
  array.set(positions);
  for (let i = 0, at = positions.length; i < copies.length; ++i, at += 3)
    array.copyWithin(at, 3 * copies[i], 3 * copies[i] + 3);
  geometry.getAttribute("position").needsUpdate = true;
}

/** Sets each normal to the mean of the normals of the triangles at the vertex, by their areas.
 * @param from for each vertex the vertex that has its normal; empty if each has its own
 */
export function setNormals(
  geometry: THREE.BufferGeometry,
  triangles: Uint32Array,
  from: Uint32Array,
): void {
  const points = geometry.getAttribute("position").array as Float32Array;
  const old = geometry.getAttribute("normal") as THREE.BufferAttribute | undefined;
  if (!old || old.array.length !== points.length)
    attribute(geometry, "normal", new Float32Array(points.length), 3);
  const normal = geometry.getAttribute("normal") as THREE.BufferAttribute;
  const sums = normal.array as Float32Array;
  sums.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const ux = points[b] - points[a];
    const uy = points[b + 1] - points[a + 1];
    const uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a];
    const vy = points[c + 1] - points[a + 1];
    const vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (const at of [a, b, c]) {
      sums[at] += nx;
      sums[at + 1] += ny;
      sums[at + 2] += nz;
    }
  }
  for (let i = 0; i < sums.length; i += 3) {
    const length = Math.hypot(sums[i], sums[i + 1], sums[i + 2]) || 1;
    sums[i] /= length;
    sums[i + 1] /= length;
    sums[i + 2] /= length;
  }
  for (let v = 0; v < from.length; ++v)
    if (from[v] !== v) sums.copyWithin(3 * v, 3 * from[v], 3 * from[v] + 3);
  normal.needsUpdate = true;
}
