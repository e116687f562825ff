// SPDX-License-Identifier: Apache-2.0
// Runs the library. Holds the model, the lattice and the binding that are open, and does the jobs of
// protocol.ts with them. A job cannot be interrupted: to cancel it, the page ends the worker and starts
// another (engine.ts).

import {
  load,
  type Binding,
  type Deformer,
  type Espalier,
  type Evaluator,
  type Lattice,
  type Model,
  type Point,
  type Pull as LatticePull,
  type Refiner,
  type Table,
  type Validity,
} from "../library/espalier.ts";
import { buffersBeside, isGltf } from "./companions.ts";
import { carriedCovariances, drawnModel } from "./drawn.ts";
import type {
  Answer,
  Axis,
  BindSettings,
  BoundaryFace,
  CellSurface,
  JobName,
  Jobs,
  LatticeEdit,
  LatticeFile,
  LatticeShape,
  PoseResult,
  Pull,
  Recipe,
  Request,
  Rules,
  Start,
  Transform,
  Transformed,
} from "./protocol.ts";
import { kShapes } from "./shapes.ts";
import { kAxes } from "./transforms.ts";

let library: Espalier;

/** The objects of the library that are open. Each group is freed when the group before it changes. */
let model: OpenModel | null = null;
let lattice: { file: Lattice; rest: Float64Array; refiner: Refiner } | null = null;
/** The pull of a drag, and the displacements of its last frame. */
let pulling: { key: string; pull: LatticePull; last?: Float64Array } | null = null;
let bound: Bound | null = null;
let surface: { level: number; evaluator: Evaluator } | null = null;
let validity: { check: Validity; cells: Int32Array } | null = null;

interface OpenModel {
  file: Model;
  points: Float64Array;
  /** of splats */
  covariances: Float32Array | null;
}

/** A binding, and what applies it. */
interface Bound {
  binding: Binding;
  /** whether it carries normals, tangents and splats */
  hasGradients: boolean;
  table: Table;
  deformer: Deformer;
}

function free(...objects: { free(): void }[]): void {
  for (const object of objects) object.free();
}

function closePull(): void {
  if (pulling) free(pulling.pull);
  pulling = null;
}

function closeBinding(): void {
  closePull();
  if (bound) free(bound.deformer, bound.table, bound.binding);
  bound = null;
}

function closeLattice(): void {
  closeBinding();
  if (surface) free(surface.evaluator);
  if (validity) free(validity.check);
  if (lattice) free(lattice.refiner, lattice.file);
  surface = validity = lattice = null;
}

function closeModel(): void {
  closeBinding();
  if (model) free(model.file);
  model = null;
}

function openOr<T>(object: T | null, name: string): T {
  if (!object) throw new Error(`there is no ${name}`);
  return object;
}

const openLatticeNow = () => openOr(lattice, "lattice: make or open one first");
const openModelNow = () => openOr(model, "model: open one first");

/** Runs `use` with an object, and frees it. */
function using<Object extends { free(): void }, T>(object: Object, use: (object: Object) => T): T {
  try {
    return use(object);
  } finally {
    object.free();
  }
}

const fileOf = (made: Lattice): LatticeFile =>
  using(made, () => ({ bytes: made.write(".vtu"), positions: made.positions() }));

/** For each face the cells that have it, with the sign of the face in each. */
function cellsAtFaces(refiner: Refiner, level: number) {
  const { cellOffsets, cellFaces, faceOffsets, faceVertices } = refiner.cells(level);
  const signs = refiner.faceSigns(level);
  const faceCount = faceOffsets.length - 1;
  const cells = new Int32Array(2 * faceCount).fill(-1);
  const firstSign = new Int8Array(faceCount);
  for (let cell = 0; cell + 1 < cellOffsets.length; ++cell)
    for (let i = cellOffsets[cell]; i < cellOffsets[cell + 1]; ++i) {
      const face = cellFaces[i];
      if (cells[2 * face] < 0) {
        cells[2 * face] = cell;
        firstSign[face] = signs[i];
      } else cells[2 * face + 1] = cell;
    }
  /** anticlockwise as seen from outside the first cell */
  const loop = (face: number): number[] => {
    const vertices = [...faceVertices.subarray(faceOffsets[face], faceOffsets[face + 1])];
    return firstSign[face] > 0 ? vertices : vertices.reverse();
  };
  return { faceCount, cells, loop, cellOffsets, cellFaces, faceOffsets, faceVertices };
}

function shapeOf(file: Lattice, refiner: Refiner): LatticeShape {
  const at = cellsAtFaces(refiner, 0);
  const boundary: BoundaryFace[] = [];
  for (let face = 0; face < at.faceCount; ++face)
    if (at.cells[2 * face + 1] < 0)
      boundary.push({ face, cell: at.cells[2 * face], vertices: at.loop(face) });
  const cells: Int32Array[] = [];
  for (let cell = 0; cell + 1 < at.cellOffsets.length; ++cell) {
    const vertices = new Set<number>();
    for (const face of at.cellFaces.subarray(at.cellOffsets[cell], at.cellOffsets[cell + 1]))
      for (const v of at.faceVertices.subarray(at.faceOffsets[face], at.faceOffsets[face + 1]))
        vertices.add(v);
    cells.push(Int32Array.from(vertices).sort());
  }
  return {
    positions: file.positions(),
    edges: refiner.edges(0),
    edgeStrata: refiner.strata(0, 1),
    vertexStrata: refiner.strata(0, 0),
    cells,
    boundary,
    marks: file.marks(),
  };
}

function make(recipe: Recipe): Lattice {
  switch (recipe.kind) {
    case "around":
      return library.around(openModelNow().points, recipe.options);
    case "cage": {
      const { file, points } = openModelNow();
      return library.cage(points, file.faces(), { vertices: recipe.vertices });
    }
    case "shape":
      return kShapes[recipe.name].make(library, recipe.sizes);
  }
}

/** Makes each lattice of the next by a step, and frees all but the last. */
function chain(start: Lattice, steps: ((from: Lattice) => Lattice)[]): Lattice {
  return steps.reduce((from, step) => {
    try {
      return step(from);
    } finally {
      if (from !== start) from.free();
    }
  }, start);
}

function edited(edit: LatticeEdit): Lattice {
  const { file } = openLatticeNow();
  const copy = () => library.merged([file], 0);
  switch (edit.kind) {
    case "extrude":
      // The new vertices of neighbouring faces coincide, and become one.
      return chain(file, [
        ...edit.faces.map((face) => (from: Lattice) => from.withPrism(face, edit.offset)),
        (from) => library.merged([from], 1e-9),
      ]);
    case "pyramid":
      return file.withPyramid(edit.face, edit.apex);
    case "remove":
      return file.withoutCells(edit.cells);
    case "weld":
      return library.merged([file], edit.tolerance);
    case "join": {
      const { name, bytes } = edit.file;
      return using(library.readLattice(name, bytes), (other) =>
        library.merged([file, other], edit.tolerance),
      );
    }
    case "mark":
      return changed(copy(), (to) => {
        to.markEdges(edit.edges, new Array(edit.edges.length / 2).fill(edit.sharpness));
        to.markVertices(edit.vertices, new Array(edit.vertices.length).fill(edit.sharpness));
        to.refiner().free();
      });
    case "clear marks":
      return changed(copy(), (to) => to.clearMarks());
    case "move":
      return changed(copy(), (to) => to.setPositions(edit.positions));
  }
}

/** Changes a new object, and frees it if that fails. */
function changed(object: Lattice, change: (object: Lattice) => void): Lattice {
  try {
    change(object);
    return object;
  } catch (error) {
    object.free();
    throw error;
  }
}

function bind(settings: BindSettings): Uint32Array {
  const { file, points } = openModelNow();
  const { refiner, rest } = openLatticeNow();
  closeBinding();
  const hasGradients = file.hasDirections() && settings.normals !== "keep";
  const binding = refiner.bind(rest, points, {
    level: settings.level,
    outside: settings.outside,
    limitTolerance: settings.limit ? 1e-6 : 0,
    gradients: hasGradients,
  });
  bound = {
    binding,
    hasGradients,
    table: binding.table(),
    deformer: binding.deformer(),
  };
  const outside: number[] = [];
  binding.statuses().forEach((status, point) => {
    if (status !== 0) outside.push(point);
  });
  return Uint32Array.from(outside);
}

/** The points of the model for a pose, as `espalier deform` computes them. */
function deformed(pose: Float64Array): Float64Array {
  return openOr(bound, "binding").binding.apply(pose, openModelNow().points.length / 3);
}

/** The file of the model for a pose, as `espalier deform` writes it. */
function writeModel(pose: Float64Array, extension: string): Uint8Array {
  const { file, points } = openModelNow();
  const { binding, hasGradients } = openOr(bound, "binding");
  const gradients = hasGradients ? binding.gradients(pose, points.length / 3) : undefined;
  return file.write(deformed(pose), gradients, extension);
}

function pointsInSingle(pose: Float64Array, changedVertices?: Int32Array): Float32Array {
  const { deformer } = openOr(bound, "binding");
  const positions = Float32Array.from(pose);
  return changedVertices
    ? deformer.deformChanged(positions, changedVertices)
    : deformer.deform(positions);
}

/** The covariances of the splats of the model for a pose; null if it has none that turn. */
function splatsOf(pose: Float64Array): Float32Array | null {
  if (!model?.covariances || !bound?.hasGradients) return null;
  const gradients = bound.binding.gradients(pose, model.points.length / 3);
  return carriedCovariances(model.covariances, gradients);
}

/** Finer levels of larger lattices would cost more than they show. */
const surfaceLevel = () => (openLatticeNow().file.counts()[3] > 3000 ? 1 : 2);

function checkOfPoses() {
  const { refiner, rest } = openLatticeNow();
  if (!validity) {
    const check = refiner.validity(rest, surfaceLevel());
    const cells = new Int32Array(check.cellCount).map((_, cell) => check.baseCell(cell));
    validity = { check, cells };
  }
  return validity;
}

/** The positions of vertices that pull points, so that limbs bend: as `espalier fit --pull`. Each frame of a drag starts
 * from the frame before. */
function pull(pulls: Pull[], pins: number[], positions: Float64Array): Float64Array {
  const points = [...pulls.map((each) => each.point), ...pins];
  const key = [pulls.length, ...points, ...positions].join();
  if (pulling?.key !== key) {
    const { table } = openOr(bound, "binding");
    const { file } = openLatticeNow();
    closePull();
    const rows = pins.map((_, i) => pulls.length + i);
    pulling = { key, pull: table.pull(file, positions, points, { pins: rows }) };
  }
  const misses = points.flatMap((_, i) => pulls[i]?.by ?? [0, 0, 0]);
  const { displacements } = pulling.pull.solve(misses, pulling.last);
  pulling.last = displacements;
  return positions.map((x, i) => x + displacements[i]);
}

const kDirections: Record<Axis, Point> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const kNext: Record<Axis, Axis> = { x: "y", y: "z", z: "x" };
const radians = (degrees: number) => (degrees * Math.PI) / 180;

function moved(
  positions: Float64Array,
  weights: Float64Array,
  to: Exclude<Transform, { kind: "mirror" }>,
): Float64Array {
  const { poses } = library;
  const options = { weights, center: to.kind === "move" ? undefined : to.center };
  switch (to.kind) {
    case "move":
      return poses.move(positions, to.offset, options);
    case "scale":
      return poses.scale(positions, to.factors, options);
    case "rotate":
      return poses.rotate(positions, kDirections[to.axis], radians(to.degrees), options);
    case "twist":
      return poses.twist(positions, kDirections[to.axis], radians(to.degrees), options);
    case "bend": {
      const [axis, toward] = [to.axis, kNext[to.axis]].map((each) => kDirections[each]);
      return poses.bend(positions, axis, radians(to.degrees), toward, options);
    }
    case "taper":
      return poses.taper(positions, kDirections[to.axis], to.factor, options);
  }
}

function transformed(from: Transformed, weights: Float64Array, to: Transform): Transformed {
  const { positions } = from;
  if (to.kind !== "mirror") return { ...from, positions: moved(positions, weights, to) };
  const { rest } = openLatticeNow();
  return library.poses.mirror(rest, positions, kAxes.indexOf(to.axis), { weights });
}

/** The vertices with a weight above 0. */
const chosen = (weights: Float64Array) => [...weights.keys()].filter((v) => weights[v] > 0);

const jobs: Jobs = {
  openModel(file) {
    if (!file) {
      closeModel();
      return null;
    }
    const read = library.readModel(file.name, file.bytes, buffersBeside(file));
    try {
      const points = read.points();
      const faces = read.faces();
      const appearance = read.appearance();
      const drawn = drawnModel(points, faces, appearance, isGltf(file.name));
      closeModel();
      model = { file: read, points, covariances: drawn.covariances };
      return {
        points,
        drawn,
        materials: appearance.materials,
        faceCount: faces.offsets.length - 1,
        hasDirections: read.hasDirections(),
        notes: read.notes(),
      };
    } catch (error) {
      read.free();
      throw error;
    }
  },

  readLattice: (file) => fileOf(library.readLattice(file.name, file.bytes)),
  makeLattice: (recipe) => fileOf(make(recipe)),
  editLattice: (edit) => fileOf(edited(edit)),

  openLattice(bytes, rules: Rules) {
    if (!bytes) {
      closeLattice();
      return null;
    }
    const file = library.readLattice("lattice.vtu", bytes);
    try {
      const refiner = file.refiner(rules);
      try {
        const shape = shapeOf(file, refiner);
        closeLattice();
        lattice = { file, rest: shape.positions, refiner };
        return shape;
      } catch (error) {
        refiner.free();
        throw error;
      }
    } catch (error) {
      file.free();
      throw error;
    }
  },

  bind(settings) {
    const outside = bind(settings);
    return { outside, residual: openOr(bound, "binding").binding.largestResidual() };
  },

  cellSurface(): CellSurface {
    const { refiner } = openLatticeNow();
    const level = surfaceLevel();
    refiner.refine(level);
    if (!surface)
      surface = using(refiner.stencils(level), (table) => ({
        level,
        evaluator: table.evaluator(),
      }));
    const baseCells = checkOfPoses().cells;
    const at = cellsAtFaces(refiner, level);
    const quads: number[] = [];
    const sides: number[] = [];
    for (let face = 0; face < at.faceCount; ++face) {
      const behind = baseCells[at.cells[2 * face]];
      const other = at.cells[2 * face + 1];
      const front = other < 0 ? -1 : baseCells[other];
      if (behind === front) continue;
      quads.push(...at.loop(face));
      sides.push(behind, front);
    }
    return {
      vertexCount: surface.evaluator.rowCount,
      quads: Uint32Array.from(quads),
      sides: Int32Array.from(sides),
    };
  },

  pose({ positions, changed: changedVertices, exact, surface: withSurface }) {
    let points: Float32Array = new Float32Array(0);
    // Changes continue from the last evaluation in single precision: hence both.
    if (bound) points = pointsInSingle(positions, changedVertices);
    if (bound && exact) points = Float32Array.from(deformed(positions));
    const result: PoseResult = { points };
    const covariances = splatsOf(positions);
    if (covariances) result.covariances = covariances;
    if (withSurface && surface)
      result.surface = surface.evaluator.evaluate(Float32Array.from(positions));
    return result;
  },

  foldedCells(positions) {
    const { check, cells } = checkOfPoses();
    return [...new Set(check.invertedCells(positions).map((cell) => cells[cell]))];
  },

  readPose: (file) => openLatticeNow().file.readPose(file.name, file.bytes),
  pull,
  transform: (positions, weights, transforms) =>
    transforms.reduce((from, to) => transformed(from, weights, to), { positions, withoutImage: 0 }),
  part(kind, point, positions) {
    const { file } = openLatticeNow();
    const { poses } = library;
    return chosen(
      kind === "limb"
        ? poses.selectLimb(file, positions, point).weights
        : poses.selectBeyond(file, positions, poses.nearestInnerFace(file, positions, point)).weights,
    );
  },
  grow(selection, steps) {
    const { file, rest } = openLatticeNow();
    const weights = new Float64Array(rest.length / 3);
    for (const v of selection) weights[v] = 1;
    return chosen(library.poses.growSelection(file, weights, steps));
  },

  write(product) {
    switch (product.kind) {
      case "model":
        return writeModel(product.pose, product.extension);
      case "lattice": {
        const { file, rest } = openLatticeNow();
        file.setPositions(product.positions);
        try {
          return product.extension === ".vtu" ? file.write(".vtu") : file.writeEditorMesh(".obj");
        } finally {
          file.setPositions(rest);
        }
      }
      case "matrix":
        return openOr(bound, "binding").table.write(".npz");
    }
  },

  memory: () => library.core.HEAPU8.length,
};

/** The memory of the arrays in a result, which goes over to the page instead of being copied. */
function buffersOf(result: unknown): ArrayBuffer[] {
  if (ArrayBuffer.isView(result)) return [result.buffer as ArrayBuffer];
  if (result === null || typeof result !== "object" || Array.isArray(result)) return [];
  return Object.values(result).flatMap(buffersOf);
}

function run({ id, job, values }: Request<JobName>): void {
  const answer = (content: Answer, buffers: ArrayBuffer[] = []) =>
    postMessage(content, { transfer: [...new Set(buffers)] });
  const report = ({ done, count }: { done: number; count: number }) => {
    answer({ id, progress: count > 0 ? done / count : 0 });
    return true;
  };
  try {
    const work = () => (jobs[job] as (...all: unknown[]) => unknown)(...values);
    // A pose takes a few milliseconds, and is asked for in each frame.
    const result = job === "pose" ? work() : library.withProgress(report, work);
    // The worker keeps the points of models and the positions of lattices, so they are copied.
    const keeps = job === "openModel" || job === "openLattice";
    answer({ id, result }, keeps ? [] : buffersOf(result));
  } catch (error) {
    answer({ id, error: error instanceof Error ? error.message : String(error) });
  }
}

/** Requests that came before the library was there. */
const waiting: Request[] = [];

addEventListener("message", async ({ data }: MessageEvent<Start | Request>) => {
  if ("module" in data) {
    try {
      library = await load(data.module);
    } catch (error) {
      reportError(error);
    }
    for (const request of waiting.splice(0)) run(request);
  } else if (library) run(data);
  else waiting.push(data);
});
