// SPDX-License-Identifier: Apache-2.0
// Runs the library. Holds the models, the lattice and the bindings that are open, and does the jobs of
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
  type Polygons,
  type Pull as LatticePull,
  type Refiner,
  type Validity,
} from "../library/espalier.ts";
import { coarseModel } from "./coarse.ts";
import { buffersBeside, isGltf } from "./companions.ts";
import { carriedCovariances, drawnModel } from "./drawn.ts";
import type {
  Answer,
  Axis,
  BindResult,
  BindSettings,
  BoundaryFace,
  CellSurface,
  Coarse,
  JobName,
  Jobs,
  LatticeEdit,
  LatticeFile,
  LatticeShape,
  ModelPose,
  ModelShape,
  PoseResult,
  Pull,
  Pulled,
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
let models: OpenModel[] = [];
let lattice: { file: Lattice; rest: Float64Array; refiner: Refiner } | null = null;
/** The pull of a drag, and the displacements of its last frame. */
let pulling: Pulling | null = null;
let surface: { level: number; evaluator: Evaluator } | null = null;
let validity: { check: Validity; cells: Int32Array } | null = null;

interface Pulling {
  /** of the points and the positions */
  key: string;
  isFrame: boolean;
  pull: LatticePull;
  last?: Float64Array;
}

interface OpenModel {
  file: Model;
  points: Float64Array;
  /** of splats */
  covariances: Float32Array | null;
  coarse: Coarse | null;
  bound: Bound | null;
}

/** The binding of a model, and what applies it. */
interface Bound {
  settings: BindSettings;
  binding: Binding;
  /** whether it carries normals, tangents and splats */
  hasGradients: boolean;
  /** moves all points */
  all: Follower;
  /** moves the points of the coarse model */
  coarse: Follower | null;
}

/** Moves points in single precision, in less time where few vertices have moved since the last time. */
class Follower {
  private last: Float64Array | null = null;

  constructor(private readonly deformer: Deformer) {}

  move(pose: Float64Array): Float32Array {
    const changed = changedVertices(this.last, pose);
    this.last = pose;
    const positions = Float32Array.from(pose);
    return changed
      ? this.deformer.deformChanged(positions, changed)
      : this.deformer.deform(positions);
  }

  free(): void {
    this.deformer.free();
  }
}

/** The vertices that differ; undefined if there is nothing to compare with. */
function changedVertices(from: Float64Array | null, to: Float64Array): Int32Array | undefined {
  if (!from || from.length !== to.length) return undefined;
  const result: number[] = [];
  for (let v = 0; v < to.length; v += 3)
    if (from[v] !== to[v] || from[v + 1] !== to[v + 1] || from[v + 2] !== to[v + 2])
      result.push(v / 3);
  return Int32Array.from(result);
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
  for (const model of models) {
    const { bound } = model;
    model.bound = null;
    if (bound) free(bound.all, ...(bound.coarse ? [bound.coarse] : []), bound.binding);
  }
}

function closeLattice(): void {
  closeBinding();
  if (surface) free(surface.evaluator);
  if (validity) free(validity.check);
  if (lattice) free(lattice.refiner, lattice.file);
  surface = validity = lattice = null;
}

function closeModels(): void {
  closeBinding();
  for (const { file } of models) free(file);
  models = [];
}

function openOr<T>(object: T | null, name: string): T {
  if (!object) throw new Error(`there is no ${name}`);
  return object;
}

const openLatticeNow = () => openOr(lattice, "lattice: make or open one first");
const boundOf = (model: OpenModel) => openOr(model.bound, "binding");

/** The points of all models, one model after the other. */
function allPoints(): Float64Array {
  if (models.length === 0) throw new Error("there is no model: open one first");
  return joinedPoints(models.map(({ points }) => points));
}

function joinedPoints(parts: readonly Float64Array[]): Float64Array {
  const result = new Float64Array(parts.reduce((sum, { length }) => sum + length, 0));
  let end = 0;
  for (const part of parts) {
    result.set(part, end);
    end += part.length;
  }
  return result;
}

/** The faces of all models, between allPoints(). */
function allFaces(): Polygons {
  const offsets = [0];
  const corners: number[] = [];
  let before = 0;
  for (const { file, points } of models) {
    const faces = file.faces();
    const first = corners.length;
    for (let face = 1; face < faces.offsets.length; ++face) offsets.push(first + faces.offsets[face]);
    for (const corner of faces.corners) corners.push(before + corner);
    before += points.length / 3;
  }
  return { offsets: Int32Array.from(offsets), corners: Int32Array.from(corners) };
}

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
      return library.around(allPoints(), recipe.options);
    case "cage":
      return library.cage(allPoints(), allFaces(), { vertices: recipe.vertices });
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
  // merged() would join vertices at one place.
  const copy = () => library.readLattice("lattice.vtu", file.write(".vtu"));
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

/** Binds points to the open lattice. */
function bindingOf(points: Float64Array, settings: BindSettings, gradients: boolean): Binding {
  const { refiner, rest } = openLatticeNow();
  return refiner.bind(rest, points, {
    level: settings.level,
    outside: settings.outside,
    limitTolerance: settings.limit ? 1e-6 : 0,
    gradients,
  });
}

function bind(settings: BindSettings): BindResult {
  closeBinding();
  const outside: number[] = [];
  let [before, residual] = [0, 0];
  for (const model of models) {
    const { file, points, coarse } = model;
    const hasGradients = file.hasDirections() && settings.normals !== "keep";
    const binding = bindingOf(points, settings, hasGradients);
    model.bound = {
      settings,
      binding,
      hasGradients,
      all: new Follower(binding.deformer()),
      coarse: coarse && coarseFollower(pointsAt(points, coarse.points), settings),
    };
    binding.statuses().forEach((status, point) => {
      if (status !== 0) outside.push(before + point);
    });
    residual = Math.max(residual, binding.largestResidual());
    before += points.length / 3;
  }
  return { outside: Uint32Array.from(outside), residual };
}

const coarseFollower = (points: Float64Array, settings: BindSettings) =>
  using(bindingOf(points, settings, false), (binding) => new Follower(binding.deformer()));

const pointsAt = (points: Float64Array, numbers: ArrayLike<number>) =>
  Float64Array.from({ length: 3 * numbers.length }, (_, i) => {
    return points[3 * numbers[Math.floor(i / 3)] + (i % 3)];
  });

/** The points of a model for a pose, as `espalier deform` computes them. */
const deformed = (model: OpenModel, pose: Float64Array) =>
  boundOf(model).binding.apply(pose, model.points.length / 3);

/** The gradients at the points of a model for a pose, if it has normals, tangents or splats that turn. */
function gradientsOf(model: OpenModel, pose: Float64Array): Float64Array | undefined {
  const { binding, hasGradients } = boundOf(model);
  return hasGradients ? binding.gradients(pose, model.points.length / 3) : undefined;
}

function modelPose(model: OpenModel, pose: Float64Array, isExact: boolean): ModelPose {
  const { all, coarse } = boundOf(model);
  if (coarse && !isExact) return { points: coarse.move(pose), isCoarse: true };
  const points = isExact ? Float32Array.from(deformed(model, pose)) : all.move(pose);
  const gradients = model.covariances ? gradientsOf(model, pose) : undefined;
  if (!gradients) return { points, isCoarse: false };
  return { points, isCoarse: false, covariances: carriedCovariances(model.covariances!, gradients) };
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

/** Iterations for a frame of a drag: each goes on from the frame before. */
const kIterationsOfFrame = 20;

/** The positions of vertices that pull points, so that limbs bend: as `espalier fit --pull`. */
function pull(
  pulls: Pull[],
  pins: number[],
  positions: Float64Array,
  movesHeld: boolean,
  isFrame = false,
): Pulled {
  const points = [...pulls.map((each) => each.point), ...pins];
  const key = [pulls.length, movesHeld, ...points, ...positions].join();
  if (pulling?.key !== key || pulling.isFrame !== isFrame) {
    const { file } = openLatticeNow();
    const { settings } = boundOf(models[0]);
    const places = pointsAt(allPoints(), points);
    const options = {
      pins: pins.map((_, i) => pulls.length + i),
      moveHeld: movesHeld,
      ...(isFrame && { maxIterations: kIterationsOfFrame }),
    };
    const made = using(bindingOf(places, settings, false), (binding) =>
      using(binding.table(), (table) => table.pull(file, positions, [...points.keys()], options)),
    );
    // The end of a drag goes on from its last frame, too.
    const last = pulling?.key === key ? pulling.last : undefined;
    closePull();
    pulling = { key, isFrame, pull: made, last };
  }
  const misses = points.flatMap((_, i) => pulls[i]?.by ?? [0, 0, 0]);
  const { displacements, meetsBarrier, largestMiss } = pulling.pull.solve(misses, pulling.last);
  pulling.last = displacements;
  const way = Math.max(...pulls.map(({ by }) => Math.hypot(...by)));
  return {
    positions: positions.map((x, i) => x + displacements[i]),
    heldBack: meetsBarrier && way > 0 ? largestMiss / way : 0,
  };
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

/** Weights of 1 for the selected vertices. */
function weightsOf(selection: readonly number[]): Float64Array {
  const weights = new Float64Array(openLatticeNow().rest.length / 3);
  for (const v of selection) weights[v] = 1;
  return weights;
}

/** The vertices with a weight above 0. */
const chosen = (weights: Float64Array) => [...weights.keys()].filter((v) => weights[v] > 0);

/** Reads what is drawn of a model. */
function shapeOfModel(model: OpenModel, name: string): ModelShape {
  const { file } = model;
  const points = file.points();
  const appearance = file.appearance();
  const faces = file.faces();
  const drawn = drawnModel(points, faces, appearance, isGltf(name));
  const coarse = coarseModel(points, drawn);
  Object.assign(model, { points, covariances: drawn.covariances, coarse });
  return {
    points,
    drawn,
    coarse,
    materials: appearance.materials,
    faceCount: faces.offsets.length - 1,
    hasDirections: file.hasDirections(),
    notes: file.notes(),
  };
}

const jobs: Jobs = {
  openModels(files) {
    const opened: OpenModel[] = [];
    try {
      const shapes = files.map((file) => {
        const read = library.readModel(file.name, file.bytes, buffersBeside(file));
        const model: OpenModel = {
          file: read,
          points: new Float64Array(0),
          covariances: null,
          coarse: null,
          bound: null,
        };
        opened.push(model);
        return shapeOfModel(model, file.name);
      });
      closeModels();
      models = opened;
      return shapes;
    } catch (error) {
      for (const { file } of opened) free(file);
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

  bind,

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

  pose({ positions, exact, surface: withSurface }) {
    const isBound = models.length > 0 && models.every(({ bound }) => bound !== null);
    const result: PoseResult = {
      models: isBound ? models.map((model) => modelPose(model, positions, exact)) : [],
    };
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
  transform(positions, weights, transforms, movesHeld) {
    const free = movesHeld ? weights : library.poses.withoutHeld(openLatticeNow().file, weights);
    if (chosen(free).length === 0 && chosen(weights).length > 0)
      throw new Error("all selected vertices are held; tick “Move held” to move them");
    const start: Transformed = { positions, withoutImage: 0 };
    return transforms.reduce((from, to) => transformed(from, free, to), start);
  },
  part(kind, point, positions) {
    const { file } = openLatticeNow();
    const { poses } = library;
    return chosen(
      kind === "limb"
        ? poses.selectLimb(file, positions, point).weights
        : poses.selectBeyond(file, positions, poses.nearestInnerFace(file, positions, point)).weights,
    );
  },
  border(selection, positions) {
    const { file } = openLatticeNow();
    try {
      return library.poses.selectionBorder(file, positions, weightsOf(selection)).center;
    } catch {
      return null; // All vertices are selected, or too few for a face.
    }
  },
  grow: (selection, steps) =>
    chosen(library.poses.growSelection(openLatticeNow().file, weightsOf(selection), steps)),

  write(product) {
    switch (product.kind) {
      case "model": {
        const model = models[product.model];
        const { pose, extension } = product;
        return model.file.write(deformed(model, pose), gradientsOf(model, pose), extension);
      }
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
        return using(boundOf(models[product.model]).binding.table(), (table) => table.write(".npz"));
    }
  },

  memory: () => library.core.HEAPU8.length,
};

/** The memory of the arrays in a result, which goes over to the page instead of being copied. */
function buffersOf(result: unknown): ArrayBuffer[] {
  if (ArrayBuffer.isView(result)) return [result.buffer as ArrayBuffer];
  if (result === null || typeof result !== "object") return [];
  if (Array.isArray(result) && typeof result[0] !== "object") return [];
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
    if (failure) throw failure;
    const work = () => (jobs[job] as (...all: unknown[]) => unknown)(...values);
    // A pose takes a few milliseconds, and is asked for in each frame.
    const result = job === "pose" ? work() : library.withProgress(report, work);
    // The worker keeps the points of models and the positions of lattices, so they are copied.
    const keeps = job === "openModels" || job === "openLattice";
    answer({ id, result }, keeps ? [] : buffersOf(result));
  } catch (error) {
    answer({ id, error: error instanceof Error ? error.message : String(error) });
  }
}

/** Requests that came before the library was there. */
const waiting: Request[] = [];
let failure: unknown = null;

addEventListener("message", async ({ data }: MessageEvent<Start | Request>) => {
  if ("module" in data) {
    try {
      library = await load(data.module);
    } catch (error) {
      failure = error;
    }
    for (const request of waiting.splice(0)) run(request);
  } else if (library || failure) run(data);
  else waiting.push(data);
});
