// SPDX-License-Identifier: Apache-2.0
// The messages between the page and its worker. The page asks for jobs. The worker (worker.ts) runs the
// jobs one after another with the library, and answers each.

import type { AroundOptions, Marks, Point, RefineOptions } from "../library/espalier.ts";
import type { Sizes } from "./shapes.ts";

/** The content of a file. Its extension tells the format. */
export interface NamedFile {
  readonly name: string;
  readonly bytes: Uint8Array;
}

/** A model, with files that belong to it: pictures, an .mtl, the .bin of a .gltf. */
export interface ModelFile extends NamedFile {
  readonly companions?: readonly NamedFile[];
}

/** Triangles of one material. */
export interface DrawnPart {
  /** the first of its numbers in `triangles`, and how many it has there */
  start: number;
  count: number;
  /** -1 for none */
  material: number;
}

/** The triangles of a model, and the vertices that they draw: the points, and copies of points that have several
 * texture coordinates or shades. */
export interface DrawnModel {
  /** 3 drawn vertices for each triangle; empty for a cloud of points */
  triangles: Uint32Array;
  /** empty if the model has no materials */
  parts: DrawnPart[];
  /** the points of the drawn vertices that follow the points */
  copies: Uint32Array;
  /** for each drawn vertex the drawn vertex that has its normal; empty if each has its own */
  normalsFrom: Uint32Array;
  /** two numbers for each drawn vertex */
  textures: Float32Array | null;
  /** red, green and blue in sRGB, and the opacity, of each drawn vertex */
  colors: Float32Array | null;
  /** the covariance xx, xy, xz, yy, yz and zz at rest of the Gaussian splat at each point */
  covariances: Float32Array | null;
}

/** Some of the points of a large model, and triangles between these. */
export interface Coarse {
  points: Uint32Array;
  /** numbers in `points` */
  triangles: Uint32Array;
}

/** What the page draws of a model. */
export interface ModelShape {
  /** as the file has them: 3 numbers for each point */
  points: Float64Array;
  drawn: DrawnModel;
  /** what may be drawn during a drag; null for a small model */
  coarse: Coarse | null;
  /** the names of the materials */
  materials: string[];
  faceCount: number;
  /** whether the file has normals, tangents or splats */
  hasDirections: boolean;
  /** names parts of the file that are not understood; empty if there are none */
  notes: string;
}

/** What the page draws of a lattice, and where its vertices are at rest. */
export interface LatticeShape {
  positions: Float64Array;
  /** two vertices for each edge */
  edges: Int32Array;
  /** 0 corner, 1 sharp edge, 2 surface, 3 interior */
  edgeStrata: Uint8Array;
  vertexStrata: Uint8Array;
  /** the vertices of each cell */
  cells: Int32Array[];
  /** the faces on the boundary, each anticlockwise from outside */
  boundary: BoundaryFace[];
  marks: Marks;
}

export interface BoundaryFace {
  /** its number in the lattice */
  face: number;
  cell: number;
  vertices: number[];
}

/** The faces at which the cells of the lattice end, on a finer level. */
export interface CellSurface {
  vertexCount: number;
  /** four vertices for each face */
  quads: Uint32Array;
  /** for each face the cell of the lattice behind it, and the cell in front of it or -1 */
  sides: Int32Array;
}

/** How the lattice is refined. */
export type Rules = Readonly<Required<RefineOptions>>;

export interface BindSettings {
  readonly level: number;
  /** binds to the limit instead of the level */
  readonly limit: boolean;
  readonly outside: "keep" | "nearest";
  /** whether normals, tangents and splats turn with the model, or stay as in the file */
  readonly normals: "turn" | "keep";
}

export interface BindResult {
  /** the points that are not inside, ascending; points of all models are numbered one model after the other */
  outside: Uint32Array;
  /** largest distance of a point at rest from its place in the lattice */
  residual: number;
}

/** How to make a lattice. */
export type Recipe =
  | { kind: "around"; options: AroundOptions }
  | { kind: "cage"; vertices: number }
  | { kind: "shape"; name: string; sizes: Sizes };

/** A change of the cells or of the marks of a lattice. */
export type LatticeEdit =
  | { kind: "extrude"; faces: number[]; offset: Point }
  | { kind: "pyramid"; face: number; apex: Point }
  | { kind: "remove"; cells: number[] }
  | { kind: "weld"; tolerance: number }
  | { kind: "join"; file: NamedFile; tolerance: number }
  | { kind: "mark"; edges: number[]; vertices: number[]; sharpness: number }
  | { kind: "clear marks" }
  | { kind: "move"; positions: Float64Array };

/** A lattice as the document keeps it: a .vtu file, and the positions that the file gives. */
export interface LatticeFile {
  bytes: Uint8Array;
  positions: Float64Array;
}

export interface PoseRequest {
  positions: Float64Array;
  /** in double precision, as the program computes it; else in single precision, which is faster, and of the coarse
   * models where there are some */
  exact: boolean;
  /** also moves the cell surface */
  surface: boolean;
}

/** Where a model is drawn. */
export interface ModelPose {
  /** all points of the model, or those of the coarse one */
  points: Float32Array;
  isCoarse: boolean;
  /** of splats that turn with the model */
  covariances?: Float32Array;
}

export interface PoseResult {
  /** one for each model; none if nothing is bound */
  models: ModelPose[];
  /** the vertices of the cell surface, if it was asked for */
  surface?: Float32Array;
}

/** A point that is pulled, numbered as in BindResult. */
export interface Pull {
  point: number;
  /** the target minus the place where the point is now */
  by: Point;
}

export interface Pulled {
  positions: Float64Array;
  /** The part of the way by which a point stays away from its target, since cells would fold otherwise; 0 if none
   * would. */
  heldBack: number;
}

export type Axis = "x" | "y" | "z";

/** An operation of `espalier pose` on the vertices. */
export type Transform =
  | { kind: "move"; offset: Point }
  | { kind: "mirror"; axis: Axis }
  | { kind: "scale"; factors: Point; center?: Point }
  | { kind: "rotate" | "twist" | "bend"; axis: Axis; degrees: number; center?: Point }
  | { kind: "taper"; axis: Axis; factor: number; center?: Point };

export interface Transformed {
  positions: Float64Array;
  /** the number of vertices that have no mirror image, and so stay */
  withoutImage: number;
}

/** A file to take home. */
export type Product =
  | { kind: "model"; model: number; pose: Float64Array; extension: string }
  | { kind: "lattice"; positions: Float64Array; extension: ".vtu" | ".obj" }
  | { kind: "matrix"; model: number };

/** All jobs of the worker. */
export interface Jobs {
  /** Reads models, which become the models of the jobs that follow. */
  openModels(files: readonly ModelFile[]): ModelShape[];
  /** Reads a lattice from any lattice file. */
  readLattice(file: NamedFile): LatticeFile;
  /** Makes a lattice, around the open models if the recipe needs one. */
  makeLattice(recipe: Recipe): LatticeFile;
  /** Changes the open lattice; the result must be opened to be used. */
  editLattice(edit: LatticeEdit): LatticeFile;
  /** Opens a lattice that readLattice(), makeLattice() or editLattice() gave; null closes it. */
  openLattice(bytes: Uint8Array | null, rules: Rules): LatticeShape | null;
  /** Binds the open models to the open lattice. */
  bind(settings: BindSettings): BindResult;
  cellSurface(): CellSurface;
  pose(request: PoseRequest): PoseResult;
  /** The cells of the lattice that a pose turns inside out somewhere. */
  foldedCells(positions: Float64Array): number[];
  /** Reads a pose of the open lattice. */
  readPose(file: NamedFile): Float64Array;
  /** The positions of the vertices of the lattice that pull points of the model, while the cells stay as rigid as
   * they can. Calls with the same points, pins and positions are the frames of one drag.
   * @param pins points that stay
   * @param positions of the vertices before the drag
   * @param movesHeld whether the vertices that the lattice holds may move, too
   * @param isFrame whether more frames follow: each takes few iterations
   */
  pull(
    pulls: Pull[],
    pins: number[],
    positions: Float64Array,
    movesHeld: boolean,
    isFrame?: boolean,
  ): Pulled;
  /** The positions after operations, one after the other. @param weights one for each vertex, 0 to 1
   * @param movesHeld whether the vertices that the lattice holds move, too */
  transform(
    positions: Float64Array,
    weights: Float64Array,
    transforms: readonly Transform[],
    movesHeld: boolean,
  ): Transformed;
  /** The vertices of a part of the lattice: the limb at a point, or what lies beyond the face nearest to the point. */
  part(kind: "limb" | "beyond", point: Point, positions: Float64Array): number[];
  /** The middle of the section between the selected vertices and the rest; null if there is none. */
  border(selection: readonly number[], positions: Float64Array): Point | null;
  /** Adds the vertices that are at most `steps` edges away from a selection. Below 0, removes the outer ones. */
  grow(selection: readonly number[], steps: number): number[];
  write(product: Product): Uint8Array;
  /** The size of the memory of the module, in bytes. */
  memory(): number;
}

export type JobName = keyof Jobs;

export interface Start {
  module: WebAssembly.Module;
}

export interface Request<Name extends JobName = JobName> {
  id: number;
  job: Name;
  values: Parameters<Jobs[Name]>;
}

export type Answer =
  | { id: number; result: unknown }
  | { id: number; error: string }
  | { id: number; progress: number };
