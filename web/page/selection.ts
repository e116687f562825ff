// SPDX-License-Identifier: Apache-2.0
// Finds vertices of a lattice to select. Faces, cells and edges are selected with all their vertices.

import type { BoundaryFace, LatticeShape } from "./protocol.ts";

export type Selection = readonly number[];

export const sorted = (vertices: Iterable<number>): number[] =>
  [...new Set(vertices)].sort((a, b) => a - b);

/** Adds vertices to a selection; removes them instead if all of them are in it. */
export function toggled(selection: Selection, vertices: readonly number[]): number[] {
  const result = new Set(selection);
  const remove = vertices.every((v) => result.has(v));
  for (const v of vertices) {
    if (remove) result.delete(v);
    else result.add(v);
  }
  return sorted(result);
}

/** Whether a place is inside a polygon of places, by the even-odd rule. */
export function isInside(polygon: readonly (readonly number[])[], x: number, y: number): boolean {
  let inside = false;
  polygon.forEach(([ax, ay], i) => {
    const [bx, by] = polygon[(i + 1) % polygon.length];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) inside = !inside;
  });
  return inside;
}

export function inverted(selection: Selection, vertexCount: number): number[] {
  const selected = new Set(selection);
  return [...Array(vertexCount).keys()].filter((v) => !selected.has(v));
}

/** The vertices with the same coordinate along an axis as a selected vertex. */
export function atPlanes(positions: Float64Array, selection: Selection, axis: number): number[] {
  const count = positions.length / 3;
  let [low, high] = [Infinity, -Infinity];
  for (let v = 0; v < count; ++v) {
    low = Math.min(low, positions[3 * v + axis]);
    high = Math.max(high, positions[3 * v + axis]);
  }
  const near = 1e-3 * (high - low);
  const levels = selection.map((v) => positions[3 * v + axis]);
  return [...Array(count).keys()].filter((v) =>
    levels.some((level) => Math.abs(positions[3 * v + axis] - level) <= near),
  );
}

/** The rows of vertices straight on from each edge between two selected vertices. A row goes on from
 * an edge to the edge at its end that is in no cell with it, as far as there is just one. */
export function rows(shape: LatticeShape, selection: Selection): number[] {
  const neighbours = neighboursOf(shape);
  const cellsOf = cellsAtVertices(shape);
  const share = (a: number, b: number) => cellsOf[a].some((cell) => cellsOf[b].includes(cell));
  const next = (before: number, vertex: number): number | null => {
    const candidates = neighbours[vertex].filter((v) => v !== before && !share(v, before));
    return candidates.length === 1 ? candidates[0] : null;
  };

  const selected = new Set(selection);
  const result = new Set(selection);
  for (let i = 0; i < shape.edges.length; i += 2) {
    const ends = [shape.edges[i], shape.edges[i + 1]];
    if (!ends.every((v) => selected.has(v))) continue;
    for (const [first, second] of [ends, [ends[1], ends[0]]]) {
      let [before, at] = [first, second];
      for (let steps = 0; steps < neighbours.length; ++steps) {
        const on = next(before, at);
        if (on === null || on === first) break;
        result.add(on);
        [before, at] = [at, on];
      }
    }
  }
  return sorted(result);
}

export function neighboursOf({ edges, positions }: LatticeShape): number[][] {
  const result: number[][] = Array.from({ length: positions.length / 3 }, () => []);
  for (let i = 0; i < edges.length; i += 2) {
    result[edges[i]].push(edges[i + 1]);
    result[edges[i + 1]].push(edges[i]);
  }
  return result;
}

function cellsAtVertices({ cells, positions }: LatticeShape): number[][] {
  const result: number[][] = Array.from({ length: positions.length / 3 }, () => []);
  cells.forEach((vertices, cell) => vertices.forEach((v) => result[v].push(cell)));
  return result;
}

/** The boundary faces all of whose vertices are selected. */
export function facesOf(shape: LatticeShape, selection: Selection): BoundaryFace[] {
  const selected = new Set(selection);
  return shape.boundary.filter((face) => face.vertices.every((v) => selected.has(v)));
}

/** The cells all of whose vertices are selected. */
export function cellsOf(shape: LatticeShape, selection: Selection): number[] {
  const selected = new Set(selection);
  return [...shape.cells.keys()].filter((cell) => shape.cells[cell].every((v) => selected.has(v)));
}

/** The edges between selected vertices: two vertices each. */
export function edgesOf(shape: LatticeShape, selection: Selection): number[] {
  const selected = new Set(selection);
  const result: number[] = [];
  for (let i = 0; i < shape.edges.length; i += 2)
    if (selected.has(shape.edges[i]) && selected.has(shape.edges[i + 1]))
      result.push(shape.edges[i], shape.edges[i + 1]);
  return result;
}
