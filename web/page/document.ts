// SPDX-License-Identifier: Apache-2.0
// A document is some models, a lattice at rest, poses of the lattice, and settings. A document never changes.
// An edit makes a new document, which shares all parts that stay. Undo shows the document before.

import type { BindSettings, LatticeFile, ModelFile, Rules } from "./protocol.ts";

export interface Pose {
  readonly name: string;
  readonly positions: Float64Array;
  /** the options of `espalier pose` that make it from the rest lattice; null if none do */
  readonly steps: readonly string[] | null;
}

export interface RestLattice extends LatticeFile {
  /** the command of the program that makes it; null if none does */
  readonly command: string | null;
}

export interface Document {
  /** All of them follow the lattice. */
  readonly models: readonly ModelFile[];
  readonly lattice: RestLattice | null;
  readonly poses: readonly Pose[];
  /** 0 is the lattice at rest, i is pose i, counted from 1; fractions are between two poses */
  readonly time: number;
  /** the selected vertices, ascending */
  readonly selection: readonly number[];
  readonly settings: BindSettings;
  readonly rules: Rules;
}

export const kEmptyDocument: Document = {
  models: [],
  lattice: null,
  poses: [],
  time: 0,
  selection: [],
  settings: { level: 3, limit: false, outside: "keep", normals: "turn" },
  rules: { rules: "siggraph96", boundary: "sharp", sharpEdges: "single-cell" },
};

export const isEmpty = ({ models, lattice }: Document) => models.length === 0 && !lattice;

/** The positions of pose `index`, where 0 is the lattice at rest. */
function key(document: Document, index: number): Float64Array {
  return index === 0 ? document.lattice!.positions : document.poses[index - 1].positions;
}

/** The positions of the vertices at a time: linear between two poses. */
export function positionsAt(document: Document, time: number): Float64Array {
  const before = Math.floor(time);
  const part = time - before;
  const from = key(document, before);
  if (part === 0) return from;
  const to = key(document, before + 1);
  return from.map((x, i) => x + part * (to[i] - x));
}

/** A document with a new lattice, at the beginning of a first pose of it. */
export function withLattice(document: Document, lattice: RestLattice): Document {
  return {
    ...document,
    lattice,
    poses: [{ name: "Pose 1", positions: lattice.positions, steps: [] }],
    time: 1,
    selection: [],
  };
}

/** A document whose lattice was changed. Poses keep the displacements of the vertices; a new vertex
 * moves as the old vertex that is nearest at rest. */
export function withChangedLattice(document: Document, lattice: RestLattice): Document {
  const old = document.lattice!.positions;
  const nearest = nearestVertices(old, lattice.positions);
  const poses = document.poses.map((pose) => ({
    ...pose,
    steps: pose.steps?.length === 0 ? pose.steps : null,
    positions: lattice.positions.map((x, i) => {
      const from = 3 * nearest[Math.floor(i / 3)] + (i % 3);
      return x + (pose.positions[from] - old[from]);
    }),
  }));
  // Marks leave the vertices as they are.
  const isSame = old.length === lattice.positions.length;
  return { ...document, lattice, poses, selection: isSame ? document.selection : [] };
}

/** A document whose lattice has the same cells, at other positions. */
export function withMovedLattice(document: Document, lattice: RestLattice): Document {
  const old = document.lattice!.positions;
  const poses = document.poses.map((pose) => ({
    ...pose,
    steps: pose.steps?.length === 0 ? pose.steps : null,
    positions: pose.positions.map((x, i) => lattice.positions[i] + (x - old[i])),
  }));
  return { ...document, lattice, poses };
}

function nearestVertices(from: Float64Array, to: Float64Array): Int32Array {
  const exact = new Map<string, number>();
  for (let v = 3 * (from.length / 3 - 1); v >= 0; v -= 3)
    exact.set(from.subarray(v, v + 3).join(), v / 3);
  return new Int32Array(to.length / 3).map((_, v) => {
    const same = exact.get(to.subarray(3 * v, 3 * v + 3).join());
    return same ?? nearestVertex(from, to.subarray(3 * v, 3 * v + 3));
  });
}

export function nearestVertex(positions: Float64Array, point: ArrayLike<number>): number {
  let best = 0;
  let least = Infinity;
  for (let v = 0; v < positions.length / 3; ++v) {
    const distance = Math.hypot(...[0, 1, 2].map((c) => positions[3 * v + c] - point[c]));
    if (distance < least) [best, least] = [v, distance];
  }
  return best;
}

/** A document with a pose after the current time, which begins as the positions at that time. */
export function withPoseAdded(document: Document): Document {
  const { poses, time } = document;
  const index = Math.floor(time) + 1;
  const exact = Number.isInteger(time);
  const steps = !exact ? null : time === 0 ? [] : poses[time - 1].steps;
  const added: Pose = { name: freeName(poses), positions: positionsAt(document, time), steps };
  return {
    ...document,
    poses: [...poses.slice(0, index - 1), added, ...poses.slice(index - 1)],
    time: index,
  };
}

/** A document in which a pose is replaced by others: by none to delete it. */
export function withPoseReplaced(document: Document, index: number, ...by: Pose[]): Document {
  const poses = [...document.poses];
  poses.splice(index, 1, ...by);
  return { ...document, poses };
}

function freeName(poses: readonly Pose[]): string {
  let number = poses.length + 1;
  while (poses.some((pose) => pose.name === `Pose ${number}`)) ++number;
  return `Pose ${number}`;
}

/** Documents in the order of the edits, up to kMaxSteps and kMaxBytes of files. */
export class History {
  private readonly documents: Document[];
  private index = 0;
  private static readonly kMaxSteps = 300;
  private static readonly kMaxBytes = 256e6;

  constructor(start: Document) {
    this.documents = [start];
  }

  get present(): Document {
    return this.documents[this.index];
  }

  get canUndo(): boolean {
    return this.index > 0;
  }

  get canRedo(): boolean {
    return this.index + 1 < this.documents.length;
  }

  push(document: Document): void {
    this.documents.splice(this.index + 1, Infinity, document);
    while (this.documents.length > 2 && this.isTooLarge()) this.documents.shift();
    this.index = this.documents.length - 1;
  }

  /** Changes the present without a step: the time, say. */
  replace(document: Document): void {
    this.documents[this.index] = document;
  }

  undo(): void {
    if (this.canUndo) --this.index;
  }

  redo(): void {
    if (this.canRedo) ++this.index;
  }

  /** Removes the present and what was undone after it: it could not be shown. */
  drop(): void {
    if (this.canUndo) this.documents.splice(this.index--, Infinity);
  }

  private isTooLarge(): boolean {
    const arrays = new Set<Uint8Array | Float64Array | null>();
    for (const { models, lattice, poses } of this.documents) {
      arrays.add(lattice?.bytes ?? null);
      for (const model of models)
        for (const { bytes } of [model, ...(model.companions ?? [])]) arrays.add(bytes);
      for (const pose of poses) arrays.add(pose.positions);
    }
    let bytes = 0;
    for (const array of arrays) bytes += array?.byteLength ?? 0;
    return this.documents.length > History.kMaxSteps || bytes > History.kMaxBytes;
  }
}
