// SPDX-License-Identifier: Apache-2.0
// Models to begin with, as .obj files that are made here.

import type { NamedFile } from "./protocol.ts";

type Point = [number, number, number];

export interface Example {
  readonly title: string;
  make(): NamedFile;
}

interface Mesh {
  points: Point[];
  faces: number[][];
}

function objOf(name: string, { points, faces }: Mesh): NamedFile {
  const lines = [
    ...points.map((point) => `v ${point.map((x) => x.toFixed(5)).join(" ")}`),
    ...faces.map((face) => `f ${face.map((corner) => corner + 1).join(" ")}`),
  ];
  return { name, bytes: new TextEncoder().encode(lines.join("\n") + "\n") };
}

// ---- A dog, as the surface of a distance field ------------------------------------------------------

/** A capsule between two balls. */
interface Limb {
  from: Point;
  to: Point;
  radii: [number, number];
}

const limb = (from: Point, to: Point, first: number, last = first): Limb => ({
  from,
  to,
  radii: [first, last],
});
const pair = (from: Point, to: Point, first: number, last = first): Limb[] => {
  const other = ([x, y, z]: Point): Point => [x, y, -z];
  return [limb(from, to, first, last), limb(other(from), other(to), first, last)];
};

const kDog: Limb[] = [
  limb([-0.62, 0.72, 0], [0.42, 0.78, 0], 0.26, 0.3),
  limb([0.42, 0.84, 0], [0.68, 1.22, 0], 0.23, 0.18),
  limb([0.72, 1.32, 0], [0.8, 1.34, 0], 0.25, 0.24),
  limb([0.84, 1.27, 0], [1.12, 1.21, 0], 0.16, 0.115),
  limb([1.2, 1.25, 0], [1.21, 1.25, 0], 0.06),
  ...pair([0.98, 1.42, 0.1], [0.985, 1.42, 0.1], 0.04),
  ...pair([0.68, 1.47, 0.2], [0.56, 1.18, 0.31], 0.075, 0.095),
  ...pair([0.42, 0.72, 0.17], [0.44, 0.1, 0.19], 0.13, 0.085),
  ...pair([0.44, 0.07, 0.19], [0.56, 0.06, 0.19], 0.085, 0.075),
  ...pair([-0.6, 0.7, 0.17], [-0.66, 0.4, 0.2], 0.19, 0.11),
  ...pair([-0.66, 0.4, 0.2], [-0.6, 0.1, 0.19], 0.1, 0.085),
  ...pair([-0.6, 0.07, 0.19], [-0.48, 0.06, 0.19], 0.085, 0.075),
  limb([-0.84, 0.86, 0], [-1.1, 1.12, 0], 0.09, 0.07),
  limb([-1.1, 1.12, 0], [-1.18, 1.42, 0], 0.07, 0.045),
];

function distanceTo({ from, to, radii }: Limb, [x, y, z]: Point): number {
  const [ax, ay, az] = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
  const [px, py, pz] = [x - from[0], y - from[1], z - from[2]];
  const along = (ax * px + ay * py + az * pz) / (ax * ax + ay * ay + az * az);
  const t = Math.min(1, Math.max(0, along));
  const [dx, dy, dz] = [px - t * ax, py - t * ay, pz - t * az];
  return Math.sqrt(dx * dx + dy * dy + dz * dz) - (radii[0] + t * (radii[1] - radii[0]));
}

/** The least distance, rounded where two limbs meet. */
function smoothDistance(limbs: Limb[], p: Point): number {
  const kBlend = 0.07;
  let result = Infinity;
  for (const each of limbs) {
    const distance = distanceTo(each, p);
    const h = Math.max(0, 1 - Math.abs(result - distance) / kBlend);
    result = Math.min(result, distance) - (h * h * kBlend) / 4;
  }
  return result;
}

/** The surface where a field is 0, by surface nets: a vertex in each cube of a grid through which the
 * surface goes, and a quadrilateral around each edge that it crosses. */
function surfaceOf(field: (p: Point) => number, min: Point, max: Point, spacing: number): Mesh {
  const size = min.map((x, i) => Math.ceil((max[i] - x) / spacing) + 1);
  const at = (i: number, j: number, k: number) => i + size[0] * (j + size[1] * k);
  const place = (i: number, j: number, k: number): Point => [
    min[0] + i * spacing,
    min[1] + j * spacing,
    min[2] + k * spacing,
  ];
  const values = new Float32Array(size[0] * size[1] * size[2]);
  for (let k = 0; k < size[2]; ++k)
    for (let j = 0; j < size[1]; ++j)
      for (let i = 0; i < size[0]; ++i) values[at(i, j, k)] = field(place(i, j, k));

  const points: Point[] = [];
  const vertices = new Map<number, number>();
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [n & 1, (n >> 1) & 1, n >> 2]);
  for (let k = 0; k + 1 < size[2]; ++k)
    for (let j = 0; j + 1 < size[1]; ++j)
      for (let i = 0; i + 1 < size[0]; ++i) {
        // Far from the surface no corner needs a look.
        if (Math.abs(values[at(i, j, k)]) > 2 * spacing) continue;
        const value = corners.map(([a, b, c]) => values[at(i + a, j + b, k + c)]);
        if (value.every((x) => x < 0) || value.every((x) => x >= 0)) continue;
        const sum = [0, 0, 0];
        let crossings = 0;
        for (let a = 0; a < 8; ++a)
          for (const bit of [1, 2, 4]) {
            const b = a | bit;
            if (a & bit || value[a] < 0 === value[b] < 0) continue;
            const t = value[a] / (value[a] - value[b]);
            corners[a].forEach((x, axis) => (sum[axis] += x + t * (corners[b][axis] - x)));
            ++crossings;
          }
        vertices.set(at(i, j, k), points.length);
        const [x, y, z] = sum.map((each) => each / crossings);
        points.push(place(i + x, j + y, k + z));
      }

  const faces: number[][] = [];
  const steps = [1, size[0], size[0] * size[1]];
  for (const cell of vertices.keys())
    for (let axis = 0; axis < 3; ++axis) {
      if (values[cell] < 0 === values[cell + steps[axis]] < 0) continue;
      const [u, v] = [steps[(axis + 1) % 3], steps[(axis + 2) % 3]];
      const face = [cell, cell - u, cell - u - v, cell - v].map((id) => vertices.get(id)!);
      faces.push(values[cell] < 0 ? face : face.reverse());
    }
  return { points, faces };
}

// ---- Surfaces by formulas ------------------------------------------------------------------------------

/** A tube around the closed curve that winds 2 times one way and 3 times the other around a torus. */
function knot(): Mesh {
  const [along, around] = [320, 24];
  const curve = (t: number): Point => {
    const radius = 1 + 0.42 * Math.cos(3 * t);
    return [radius * Math.cos(2 * t), 0.42 * Math.sin(3 * t), radius * Math.sin(2 * t)];
  };
  const points: Point[] = [];
  const faces: number[][] = [];
  for (let i = 0; i < along; ++i) {
    const t = (2 * Math.PI * i) / along;
    const [p, ahead] = [curve(t), curve(t + 1e-3)];
    const tangent = unit(difference(ahead, p));
    const side = unit(cross(tangent, p));
    const up = cross(side, tangent);
    for (let j = 0; j < around; ++j) {
      const angle = (2 * Math.PI * j) / around;
      const [c, s] = [0.17 * Math.cos(angle), 0.17 * Math.sin(angle)];
      points.push(p.map((x, axis) => x + c * side[axis] + s * up[axis]) as Point);
      const [i1, j1] = [(i + 1) % along, (j + 1) % around];
      faces.push([i * around + j, i1 * around + j, i1 * around + j1, i * around + j1]);
    }
  }
  return { points, faces };
}

const difference = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = ([a, b, c]: Point, [x, y, z]: Point): Point => [
  b * z - c * y,
  c * x - a * z,
  a * y - b * x,
];
const unit = (p: Point) => p.map((x) => x / Math.hypot(...p)) as Point;

/** A tall block with many points. */
function column(): Mesh {
  const [sides, layers] = [96, 160];
  const points: Point[] = [];
  const faces: number[][] = [];
  for (let j = 0; j <= layers; ++j)
    for (let i = 0; i < sides; ++i) {
      const angle = (2 * Math.PI * i) / sides;
      const flute = 0.3 + 0.022 * Math.abs(Math.sin(6 * angle));
      const y = (2.4 * j) / layers;
      points.push([flute * Math.cos(angle), y, flute * Math.sin(angle)]);
      if (j < layers) {
        const [a, b] = [j * sides + i, j * sides + ((i + 1) % sides)];
        faces.push([a, a + sides, b + sides, b]);
      }
    }
  const ends = [0, layers].map((j) => [...Array(sides).keys()].map((i) => j * sides + i));
  faces.push(ends[0], ends[1].reverse());
  return { points, faces };
}

export const kExamples: Record<string, Example> = {
  dog: {
    title: "Dog",
    // The grid is symmetric about z = 0, and so is the dog.
    make: () =>
      objOf(
        "dog.obj",
        surfaceOf((p) => smoothDistance(kDog, p), [-1.4, -0.1, -0.546], [1.4, 1.75, 0.546], 0.026),
      ),
  },
  knot: { title: "Knot", make: () => objOf("knot.obj", knot()) },
  column: { title: "Column", make: () => objOf("column.obj", column()) },
};
