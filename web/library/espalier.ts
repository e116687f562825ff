// SPDX-License-Identifier: Apache-2.0
// Espalier for JavaScript: classes over the C interface (c/espalier.h), which says what each function does, costs
// and refuses. Arrays go in and come out as copies. Objects hold memory of the module until free() is called, or
// until they are collected.

import loadCore from "espalier-core";
import {
  bytesAt,
  doublesAt,
  EspalierError,
  floatsAt,
  integersAt,
  longAt,
  longsAt,
  Scope,
  textAt,
  type CFunction,
  type Core,
} from "./memory.ts";

export { EspalierError, isCancelled } from "./memory.ts";

/** x, y, z */
export type Point = [number, number, number];

/** Infinite sharpness: refinement never uses it up. */
export const SHARP = 10;

export interface RefineOptions {
  rules?: "siggraph96" | "cse96" | "mlca";
  boundary?: "sharp" | "edge-only" | "open";
  sharpEdges?: "single-cell" | "literal";
}

export interface BindOptions {
  /** level whose cells hold the points, 1 to 20; default 3 */
  level?: number;
  /** binds to the limit instead, within this tolerance: 1e-6 is usual */
  limitTolerance?: number;
  /** what happens to points outside; default "keep" */
  outside?: "keep" | "nearest" | "refuse";
  tolerance?: number;
}

export interface AroundOptions {
  /** cells along x, y and z */
  cells?: Point;
  cellsAlongLongest?: number;
  cellSize?: number;
  margin?: number;
  oriented?: boolean;
}

/** What joins a disk in its middle. */
export type DiskCore = "wedges" | "polygon";

/** Faces and their corners: face f has corners[offsets[f]] to corners[offsets[f + 1] - 1]. */
export interface Polygons {
  offsets: Int32Array;
  corners: Int32Array;
}

/** A level of a lattice: its cells by their faces, and its faces by their vertices. */
export interface Cells {
  vertexCount: number;
  cellOffsets: Int32Array;
  cellFaces: Int32Array;
  faceOffsets: Int32Array;
  faceVertices: Int32Array;
}

/** A sparse matrix in compressed rows. */
export interface CompressedRows {
  rowCount: number;
  columnCount: number;
  offsets: Int32Array;
  columns: Int32Array;
  weights: Float64Array;
}

export interface Marks {
  /** two vertices for each edge */
  edges: Int32Array;
  edgeSharpness: Float64Array;
  vertices: Int32Array;
  vertexSharpness: Float64Array;
}

export interface Progress {
  /** number of stages that have ended */
  stage: number;
  /** number of items of this stage that are done, of `count` */
  done: number;
  count: number;
}

/** Where binding found a point. */
export const enum PointStatus {
  Inside = 0,
  Outside = 1,
  NotConverged = 2,
}

const collected = new FinalizationRegistry<() => void>((destroy) => destroy());

/** An object of the library. */
abstract class Handle {
  private pointer: number;
  private readonly destroy: () => void;

  /** @param parts objects that are destroyed with it, by kind and address */
  constructor(
    protected readonly library: Espalier,
    pointer: number,
    kind: string,
    parts: [string, number][] = [],
  ) {
    this.pointer = pointer;
    this.destroy = () => {
      for (const [each, address] of [[kind, pointer] as const, ...parts])
        library.destroy(each, address);
    };
    collected.register(this, this.destroy, this);
  }

  /** Frees the memory of the object, which must not be used afterwards. */
  free(): void {
    if (this.pointer === 0) return;
    this.pointer = 0;
    collected.unregister(this);
    this.destroy();
  }

  /** The address of the object. */
  get address(): number {
    if (this.pointer === 0) throw new Error("this object has been freed");
    return this.pointer;
  }
}

/** Loads the library.
 *
 * @param source the file espalier.wasm: its bytes, or a compiled module; by default, the file beside this one
 */
export async function load(source?: BufferSource | WebAssembly.Module): Promise<Espalier> {
  const wasm = source ?? (await fileBesideThis());
  const core = await loadCore({
    instantiateWasm(imports: WebAssembly.Imports, done: (instance: WebAssembly.Instance) => void) {
      const start = async () =>
        wasm instanceof WebAssembly.Module
          ? WebAssembly.instantiate(wasm, imports)
          : (await WebAssembly.instantiate(wasm, imports)).instance;
      start().then(done);
      return {};
    },
  });
  return new Espalier(core as Core);
}

async function fileBesideThis(): Promise<BufferSource> {
  const url = new URL("./espalier.wasm", import.meta.url);
  if (url.protocol !== "file:") return (await fetch(url)).arrayBuffer();
  const { readFile } = await import(/* @vite-ignore */ "node:fs/promises");
  return readFile(url);
}

/** The library. Makes all objects. */
export class Espalier {
  readonly version: string;

  /** @internal */
  constructor(readonly core: Core) {
    this.version = textAt(core, this.function("espalier_version")());
  }

  /** A function of the C interface by its name. */
  function(name: string): CFunction {
    const found = (this.core as unknown as Record<string, CFunction>)[`_${name}`];
    if (!found) throw new Error(`the library has no function ${name}`);
    return found;
  }

  /** Calls a C function that returns a status.
   * @throws EspalierError with the message of the library
   */
  call(name: string, ...values: (number | bigint)[]): void {
    const status = this.function(name)(...values);
    if (status !== 0)
      throw new EspalierError(status, textAt(this.core, this.function("espalier_last_error")()));
  }

  /** Runs `use` with temporary memory. */
  scoped<T>(use: (scope: Scope) => T): T {
    const scope = new Scope(this.core);
    try {
      return use(scope);
    } finally {
      scope.free();
    }
  }

  /** Calls a C function whose last parameter receives a new object, and returns its address. */
  create(name: string, ...values: (number | bigint)[]): number {
    return this.scoped((scope) => {
      const out = scope.allocate(4);
      this.call(name, ...values, out);
      return this.core.HEAP32[out / 4];
    });
  }

  /** @internal @param kind of the object; "" frees memory of malloc() */
  destroy(kind: string, pointer: number): void {
    if (kind === "") this.core._free(pointer);
    else this.function(`espalier_${kind}_destroy`)(pointer);
  }

  /** Writes a file by `write`, which gets a path, and returns its bytes. */
  file(extension: string, write: (path: string) => void): Uint8Array {
    const path = `/result${extension}`;
    write(path);
    const bytes = this.core.FS.readFile(path);
    this.core.FS.unlink(path);
    return bytes;
  }

  /** Makes a file for `read`, which gets its path. Messages of the library name the file as `name`. */
  withFile<T>(name: string, bytes: Uint8Array, read: (path: string) => T): T {
    const path = name.replaceAll("/", "_");
    this.core.FS.writeFile(path, bytes);
    try {
      return read(path);
    } finally {
      this.core.FS.unlink(path);
    }
  }

  /** Runs `work`, and reports its progress.
   *
   * @param report returns false to cancel: `work` then throws an error for which isCancelled() holds
   * @param milliseconds least time between two reports
   */
  withProgress<T>(report: (progress: Progress) => boolean, work: () => T, milliseconds = 50): T {
    const callback = this.core.addFunction((_user, at) => {
      const [stage, done, count] = [0, 8, 16].map((offset) => longAt(this.core, at + offset));
      return report({ stage, done, count }) ? 1 : 0;
    }, "iii");
    try {
      const scope = this.create("espalier_progress_scope_create", callback, 0, milliseconds);
      try {
        return work();
      } finally {
        this.destroy("progress_scope", scope);
      }
    } finally {
      this.core.removeFunction(callback);
    }
  }

  /** Reads a model: .obj, .ply, .stl, .vtu, .vtp or .vtk. */
  readModel(name: string, bytes: Uint8Array): Model {
    return this.scoped((scope) => {
      const content = scope.bytes(bytes);
      return new Model(
        this,
        this.create("espalier_model_read_bytes", scope.text(name), BigInt(bytes.length), content),
        extensionOf(name),
      );
    });
  }

  /** Reads a lattice: .ovm, .vtu or .vtk. */
  readLattice(name: string, bytes: Uint8Array): Lattice {
    return this.withFile(name, bytes, (path) =>
      this.makeLattice("espalier_lattice_read", (scope) => [scope.text(path)]),
    );
  }

  /** Reads a matrix: .npz, .mtx or .petsc. */
  readTable(name: string, bytes: Uint8Array): Table {
    return this.withFile(name, bytes, (path) =>
      this.scoped((scope) => new Table(this, this.create("espalier_table_read", scope.text(path)))),
    );
  }

  /** Makes a lattice of cells of any shape. */
  latticeOfCells(cells: Cells, positions: Float64Array): Lattice {
    return this.makeLattice("espalier_lattice_create", (scope) => [
      scope.struct([
        ["i32", cells.vertexCount],
        ["i32", cells.faceOffsets.length - 1],
        ["i32", cells.cellOffsets.length - 1],
        ["pointer", scope.longs(cells.cellOffsets)],
        ["pointer", scope.integers(cells.cellFaces)],
        ["pointer", scope.longs(cells.faceOffsets)],
        ["pointer", scope.integers(cells.faceVertices)],
      ]),
      scope.doubles(positions),
    ]);
  }

  /** Makes a box of hexahedra around points. */
  around(points: Float64Array, options: AroundOptions = {}): Lattice {
    const cells = options.cells ?? [0, 0, 0];
    return this.makeLattice("espalier_lattice_create_around", (scope) => [
      BigInt(points.length / 3),
      scope.doubles(points),
      scope.struct([
        ["size"],
        ["i32", cells[0]],
        ["i32", cells[1]],
        ["i32", cells[2]],
        ["i32", options.cellsAlongLongest ?? 4],
        ["i32", options.oriented ? 1 : 0],
        ["f64", options.cellSize ?? 0],
        ["f64", options.margin ?? 0.05],
      ]),
    ]);
  }

  box(cells: Point, min: Point, max: Point): Lattice {
    return this.makeLattice("espalier_lattice_create_box", (scope) => [
      scope.integers(cells),
      scope.doubles(min),
      scope.doubles(max),
    ]);
  }

  cylinder(options: {
    sectors?: number;
    rings?: number;
    core?: DiskCore;
    layers?: number;
    radius?: number;
    from?: Point;
    to?: Point;
  }): Lattice {
    const { sectors = 8, rings = 1, layers = 1, radius = 1 } = options;
    return this.makeLattice("espalier_lattice_create_cylinder", (scope) => [
      sectors,
      rings,
      numberOfCore(options.core ?? "wedges"),
      layers,
      radius,
      scope.doubles(options.from ?? [0, 0, 0]),
      scope.doubles(options.to ?? [0, 0, 1]),
    ]);
  }

  torus(options: {
    segments?: number;
    gridCells?: number;
    /** makes the cross-section a disk of that many sides, instead of a grid */
    sides?: number;
    rings?: number;
    core?: DiskCore;
    majorRadius?: number;
    minorRadius?: number;
  }): Lattice {
    return this.makeLattice("espalier_lattice_create_torus", (scope) => [
      scope.struct([
        ["size"],
        ["i32", options.segments ?? 8],
        ["i32", options.sides === undefined ? 0 : 1],
        ["i32", options.gridCells ?? 1],
        ["i32", options.sides ?? 6],
        ["i32", options.rings ?? 1],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["f64", options.majorRadius ?? 1],
        ["f64", options.minorRadius ?? 0.4],
      ]),
    ]);
  }

  star(options: {
    points?: number;
    rings?: number;
    core?: DiskCore;
    layers?: number;
    innerRadius?: number;
    outerRadius?: number;
    height?: number;
  }): Lattice {
    return this.makeLattice("espalier_lattice_create_star", (scope) => [
      scope.struct([
        ["size"],
        ["i32", options.points ?? 5],
        ["i32", options.rings ?? 1],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["i32", options.layers ?? 1],
        ["f64", options.innerRadius ?? 0.5],
        ["f64", options.outerRadius ?? 1],
        ["f64", options.height ?? 0.25],
      ]),
    ]);
  }

  barbell(options: {
    endSegments?: number;
    barSegments?: number;
    barAcross?: number;
    rings?: number;
    core?: DiskCore;
    layers?: number;
    endRadius?: number;
    barLength?: number;
    barHalfWidth?: number;
    roundness?: number;
    height?: number;
  }): Lattice {
    return this.makeLattice("espalier_lattice_create_barbell", (scope) => [
      scope.struct([
        ["size"],
        ["i32", options.endSegments ?? 6],
        ["i32", options.barSegments ?? 2],
        ["i32", options.barAcross ?? 2],
        ["i32", options.rings ?? 1],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["i32", options.layers ?? 1],
        ["f64", options.endRadius ?? 1],
        ["f64", options.barLength ?? 2],
        ["f64", options.barHalfWidth ?? 0.4],
        ["f64", options.roundness ?? 1],
        ["f64", options.height ?? 0.5],
      ]),
    ]);
  }

  /** A tube around a polyline. */
  arm(options: {
    joints: { position: Point; radius: number; twist?: number }[];
    segments?: number;
    sides?: number;
    rings?: number;
    core?: DiskCore;
    up?: Point;
  }): Lattice {
    const joints = options.joints.flatMap((joint) => [
      ...joint.position,
      joint.radius,
      joint.twist ?? 0,
    ]);
    const up = options.up ?? [0, 0, 1];
    return this.makeLattice("espalier_lattice_create_arm", (scope) => [
      scope.struct([
        ["size"],
        ["i32", options.segments ?? 2],
        ["i32", options.sides ?? 4],
        ["i32", options.rings ?? 1],
        ["i32", numberOfCore(options.core ?? "polygon")],
        // joint_count, a 64-bit integer, begins at a multiple of 8 bytes.
        ["i32", 0],
        ["i32", options.joints.length],
        ["i32", 0],
        ["pointer", scope.doubles(joints)],
        ["i32", 0],
        ["f64", up[0]],
        ["f64", up[1]],
        ["f64", up[2]],
      ]),
    ]);
  }

  /** A single cell, which is a regular solid about the origin. */
  regularSolid(name: keyof typeof kRegularSolids, radius = 1): Lattice {
    return this.makeLattice("espalier_lattice_create_regular_solid", () => [
      kRegularSolids[name],
      radius,
    ]);
  }

  /** A single cell over a regular polygon. */
  polygonalSolid(
    name: keyof typeof kPolygonalSolids,
    sides: number,
    radius = 1,
    height = 1,
  ): Lattice {
    return this.makeLattice("espalier_lattice_create_polygonal_solid", () => [
      kPolygonalSolids[name],
      sides,
      radius,
      height,
    ]);
  }

  /** Joins lattices by welding vertices that coincide; of a single lattice, its own vertices. */
  merged(lattices: Lattice[], tolerance = 1e-6): Lattice {
    return this.makeLattice("espalier_lattice_create_merged", (scope) => [
      BigInt(lattices.length),
      scope.integers(lattices.map((lattice) => lattice.address)),
      tolerance,
    ]);
  }

  /** @internal */
  makeLattice(name: string, values: (scope: Scope) => (number | bigint)[]): Lattice {
    return this.scoped((scope) => new Lattice(this, this.create(name, ...values(scope))));
  }
}

const kRegularSolids = { tetrahedron: 0, cube: 1, octahedron: 2, dodecahedron: 3, icosahedron: 4 };
const kPolygonalSolids = { prism: 0, pyramid: 1, bipyramid: 2 };
const numberOfCore = (core: DiskCore) => (core === "wedges" ? 0 : 1);
const extensionOf = (name: string) => name.slice(name.lastIndexOf(".")).toLowerCase();

/** A file with points that a lattice deforms. */
export class Model extends Handle {
  constructor(
    library: Espalier,
    pointer: number,
    /** with which it is written, such as ".obj" */
    readonly extension: string,
  ) {
    super(library, pointer, "model");
  }

  /** Three numbers for each point, in the order of the file. */
  points(): Float64Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_model_points", this.address, out, out + 4);
      const [count, points] = integersAt(this.library.core, out, 2);
      return doublesAt(this.library.core, points, 3 * count);
    });
  }

  faces(): Polygons {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_model_faces", this.address, out);
      const [offsetsAt, cornersAt] = integersAt(core, out + 8, 2);
      const offsets = longsAt(core, offsetsAt, longAt(core, out) + 1);
      return { offsets, corners: integersAt(core, cornersAt, offsets[offsets.length - 1]) };
    });
  }

  hasDirections(): boolean {
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      this.library.call("espalier_model_has_directions", this.address, out);
      return this.library.core.HEAP32[out / 4] !== 0;
    });
  }

  /** The file with new points. Without a change of points, the file that was read.
   * @param gradients nine numbers for each point, which carry normals and tangents
   */
  write(points: Float64Array, gradients?: Float64Array): Uint8Array {
    return this.library.file(this.extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call(
          "espalier_model_write",
          this.address,
          scope.text(path),
          points.length / 3,
          scope.doubles(points),
          gradients ? scope.doubles(gradients) : 0,
        ),
      ),
    );
  }
}

/** Cells, the positions of their vertices, and marks. */
export class Lattice extends Handle {
  constructor(library: Espalier, pointer: number) {
    super(library, pointer, "lattice");
  }

  /** The numbers of vertices, edges, faces and cells. */
  counts(): [number, number, number, number] {
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_lattice_counts", this.address, out);
      return [...integersAt(this.library.core, out, 4)] as [number, number, number, number];
    });
  }

  positions(): Float64Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_lattice_positions", this.address, out, out + 4);
      const [count, positions] = integersAt(this.library.core, out, 2);
      return doublesAt(this.library.core, positions, 3 * count);
    });
  }

  setPositions(positions: Float64Array): void {
    this.library.scoped((scope) =>
      this.library.call(
        "espalier_lattice_set_positions",
        this.address,
        positions.length / 3,
        scope.doubles(positions),
      ),
    );
  }

  marks(): Marks {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_lattice_mark_counts", this.address, out, out + 8);
      const [edges, vertices] = [longAt(core, out), longAt(core, out + 8)];
      const ends = scope.allocate(8 * edges);
      const ofEdges = scope.allocate(8 * edges);
      const marked = scope.allocate(4 * vertices);
      const ofVertices = scope.allocate(8 * vertices);
      this.library.call(
        "espalier_lattice_marks",
        this.address,
        BigInt(edges),
        ends,
        ofEdges,
        BigInt(vertices),
        marked,
        ofVertices,
      );
      return {
        edges: integersAt(core, ends, 2 * edges),
        edgeSharpness: doublesAt(core, ofEdges, edges),
        vertices: integersAt(core, marked, vertices),
        vertexSharpness: doublesAt(core, ofVertices, vertices),
      };
    });
  }

  /** Marks edges, each by its two vertices: SHARP, less for a crease, 0 for smooth. */
  markEdges(ends: ArrayLike<number>, sharpness: ArrayLike<number>): void {
    this.library.scoped((scope) =>
      this.library.call(
        "espalier_lattice_mark_edges",
        this.address,
        BigInt(sharpness.length),
        scope.integers(ends),
        scope.doubles(sharpness),
      ),
    );
  }

  markVertices(vertices: ArrayLike<number>, sharpness: ArrayLike<number>): void {
    this.library.scoped((scope) =>
      this.library.call(
        "espalier_lattice_mark_vertices",
        this.address,
        BigInt(sharpness.length),
        scope.integers(vertices),
        scope.doubles(sharpness),
      ),
    );
  }

  clearMarks(): void {
    this.library.call("espalier_lattice_clear_marks", this.address);
  }

  /** A lattice with one more cell: a prism on a boundary face. */
  withPrism(face: number, offset: Point): Lattice {
    return this.library.makeLattice("espalier_lattice_create_with_prism", (scope) => [
      this.address,
      face,
      scope.doubles(offset),
    ]);
  }

  /** A lattice with one more cell: a pyramid on a boundary face. */
  withPyramid(face: number, apex: Point): Lattice {
    return this.library.makeLattice("espalier_lattice_create_with_pyramid", (scope) => [
      this.address,
      face,
      scope.doubles(apex),
    ]);
  }

  /** A lattice without some cells, and without the vertices of these cells alone. */
  withoutCells(cells: ArrayLike<number>): Lattice {
    return this.library.makeLattice("espalier_lattice_create_without_cells", (scope) => [
      this.address,
      cells.length,
      scope.integers(cells),
    ]);
  }

  /** The file of the lattice: ".vtu", ".ovm" or ".vtk". */
  write(extension: string): Uint8Array {
    return this.library.file(extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call("espalier_lattice_write", this.address, scope.text(path)),
      ),
    );
  }

  /** The mesh of all faces of the lattice, for mesh editors: ".obj" or ".ply". */
  writeCage(extension: string): Uint8Array {
    return this.library.file(extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call("espalier_lattice_write_cage", this.address, scope.text(path)),
      ),
    );
  }

  /** Reads a pose of this lattice: a lattice with the same cells, or a cage (.obj, .ply). */
  readPose(name: string, bytes: Uint8Array): Float64Array {
    const count = this.counts()[0];
    return this.library.withFile(name, bytes, (path) =>
      this.library.scoped((scope) => {
        const pose = scope.allocate(24 * count);
        this.library.call(
          "espalier_lattice_read_pose",
          this.address,
          scope.text(path),
          count,
          pose,
        );
        return doublesAt(this.library.core, pose, 3 * count);
      }),
    );
  }

  refiner(options: RefineOptions = {}): Refiner {
    return this.library.scoped((scope) => {
      const chosen = scope.struct([
        ["size"],
        ["i32", ["siggraph96", "cse96", "mlca"].indexOf(options.rules ?? "siggraph96")],
        ["i32", ["sharp", "edge-only", "open"].indexOf(options.boundary ?? "sharp")],
        ["i32", ["single-cell", "literal"].indexOf(options.sharpEdges ?? "single-cell")],
        ["i32", 0],
        ["i32", 0],
      ]);
      return new Refiner(
        this.library,
        this.library.create("espalier_refiner_create", this.address, chosen),
      );
    });
  }
}

/** The topology of a lattice and of its levels. */
export class Refiner extends Handle {
  constructor(library: Espalier, pointer: number) {
    super(library, pointer, "refiner");
  }

  refine(level: number): void {
    this.library.call("espalier_refiner_refine", this.address, level);
  }

  counts(level: number): [number, number, number, number] {
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_refiner_counts", this.address, level, out);
      return [...integersAt(this.library.core, out, 4)] as [number, number, number, number];
    });
  }

  cells(level: number): Cells {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(28);
      this.library.call("espalier_refiner_cells", this.address, level, out);
      const [vertexCount, faceCount, cellCount, cells, faces, loops, vertices] = integersAt(
        core,
        out,
        7,
      );
      const cellOffsets = longsAt(core, cells, cellCount + 1);
      const faceOffsets = longsAt(core, loops, faceCount + 1);
      return {
        vertexCount,
        cellOffsets,
        cellFaces: integersAt(core, faces, cellOffsets[cellCount]),
        faceOffsets,
        faceVertices: integersAt(core, vertices, faceOffsets[faceCount]),
      };
    });
  }

  /** One number for each of cellFaces: 1 if the face goes round anticlockwise from outside, or -1. */
  faceSigns(level: number): Int8Array {
    const { core } = this.library;
    const count = this.cells(level).cellFaces.length;
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      this.library.call("espalier_refiner_face_signs", this.address, level, out);
      const signs = core.HEAP32[out / 4];
      return core.HEAP8.slice(signs, signs + count);
    });
  }

  /** The two vertices of each edge. */
  edges(level: number): Int32Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_refiner_edges", this.address, level, out, out + 4);
      const [count, ends] = integersAt(this.library.core, out, 2);
      return integersAt(this.library.core, ends, 2 * count);
    });
  }

  /** For each entity the dimension of its feature: 0 corner, 1 sharp edge, 2 surface, 3 interior. */
  strata(level: number, dimension: 0 | 1 | 2 | 3): Uint8Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_refiner_strata", this.address, level, dimension, out, out + 4);
      const [count, strata] = integersAt(this.library.core, out, 2);
      return bytesAt(this.library.core, strata, count);
    });
  }

  /** S_level: vertices of the level × vertices of the lattice. */
  stencils(level: number): Table {
    return new Table(
      this.library,
      this.library.create("espalier_table_create_stencils", this.address, level),
    );
  }

  /** Limit positions of the vertices of a level: vertices of the level × vertices of the lattice. */
  limits(level: number): Table {
    return new Table(
      this.library,
      this.library.create("espalier_table_create_limits", this.address, level),
    );
  }

  bind(positions: Float64Array, points: Float64Array, options: BindOptions = {}): Binding {
    return this.library.scoped((scope) => {
      const binding = this.library.create(
        "espalier_binding_create",
        this.address,
        positions.length / 3,
        scope.doubles(positions),
        points.length / 3,
        scope.doubles(points),
        scope.struct([
          ["size"],
          ["i32", options.level ?? 3],
          ["i32", ["keep", "nearest", "refuse"].indexOf(options.outside ?? "keep")],
          ["f64", options.tolerance ?? 1e-6],
          ["f64", options.limitTolerance ?? 0],
        ]),
      );
      return new Binding(this.library, binding);
    });
  }

  /** Prepares checks of poses for cells that are inside out. */
  validity(positions: Float64Array, level = 3): Validity {
    return this.library.scoped((scope) => {
      const validity = this.library.create(
        "espalier_validity_create",
        this.address,
        positions.length / 3,
        scope.doubles(positions),
        scope.struct([["size"], ["i32", level], ["i32", 0]]),
      );
      return new Validity(this.library, validity);
    });
  }
}

/** Points that are bound to a lattice. */
export class Binding extends Handle {
  constructor(library: Espalier, pointer: number) {
    super(library, pointer, "binding");
  }

  /** A PointStatus for each point. */
  statuses(): Uint8Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_binding_statuses", this.address, out, out + 4);
      const [count, statuses] = integersAt(this.library.core, out, 2);
      return bytesAt(this.library.core, statuses, count);
    });
  }

  largestResidual(): number {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_binding_largest_residual", this.address, out);
      return this.library.core.HEAPF64[out / 8];
    });
  }

  /** D: points × vertices of the lattice. */
  table(): Table {
    return new Table(this.library, this.library.create("espalier_binding_table", this.address));
  }

  /** The points for a pose of the lattice. */
  apply(pose: Float64Array, pointCount: number): Float64Array {
    return this.library.scoped((scope) => {
      const points = scope.allocate(24 * pointCount);
      this.library.call(
        "espalier_binding_apply",
        this.address,
        pose.length / 3,
        scope.doubles(pose),
        pointCount,
        points,
      );
      return doublesAt(this.library.core, points, 3 * pointCount);
    });
  }
}

/** An immutable sparse matrix. */
export class Table extends Handle {
  constructor(library: Espalier, pointer: number) {
    super(library, pointer, "table");
  }

  rows(): CompressedRows {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(20);
      this.library.call("espalier_table_csr", this.address, out);
      const [rowCount, columnCount, starts, columns, weights] = integersAt(core, out, 5);
      const offsets = longsAt(core, starts, rowCount + 1);
      const entries = offsets[rowCount];
      return {
        rowCount,
        columnCount,
        offsets,
        columns: integersAt(core, columns, entries),
        weights: doublesAt(core, weights, entries),
      };
    });
  }

  /** The file of the table: ".npz", ".mtx" or ".petsc". */
  write(extension: string): Uint8Array {
    return this.library.file(extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call("espalier_table_write", this.address, scope.text(path)),
      ),
    );
  }

  evaluator(): Evaluator {
    const pointer = this.library.create("espalier_evaluator_f32_create", this.address);
    return new Evaluator(this.library, pointer, ...this.size());
  }

  /** The numbers of rows and of columns. */
  size(): [number, number] {
    return this.library.scoped((scope) => {
      const out = scope.allocate(20);
      this.library.call("espalier_table_csr", this.address, out);
      const [rows, columns] = integersAt(this.library.core, out, 2);
      return [rows, columns];
    });
  }
}

/** A table in the form that is fastest to apply, in single precision. */
export class Evaluator extends Handle {
  private readonly arrays: FloatArrays;

  constructor(
    library: Espalier,
    pointer: number,
    readonly rowCount: number,
    readonly columnCount: number,
  ) {
    const arrays = new FloatArrays(library, rowCount, columnCount);
    super(library, pointer, "evaluator_f32", arrays.parts());
    this.arrays = arrays;
  }

  /** The table times a source of three numbers for each column; with `addend`, plus the addend. */
  evaluate(source: Float32Array, addend?: Float32Array): Float32Array {
    this.arrays.setSource(source);
    if (addend) this.arrays.setAddend(addend);
    this.library.call(
      `espalier_evaluator_f32_evaluate${addend ? "_and_add" : ""}`,
      this.address,
      ...this.arrays.parameters(addend !== undefined),
      0,
      this.rowCount,
      this.arrays.workspace,
    );
    return this.arrays.result();
  }

  /** Prepares evaluations of the rows that depend on a few changed columns. The two share their
   * results: evaluate() sets all rows, and evaluate() of the changes some of them. */
  changes(): ChangeEvaluator {
    const pointer = this.library.create("espalier_change_evaluator_f32_create", this.address);
    return new ChangeEvaluator(this.library, pointer, this.arrays);
  }
}

/** Evaluates only the rows of a table that depend on a few changed columns. */
export class ChangeEvaluator extends Handle {
  constructor(
    library: Espalier,
    pointer: number,
    private readonly arrays: FloatArrays,
  ) {
    super(library, pointer, "change_evaluator_f32");
  }

  /** Sets the rows that depend on these columns, to the table times the source, plus the addend of
   * the last evaluation if it had one; returns all rows. */
  evaluate(source: Float32Array, changed: ArrayLike<number>): Float32Array {
    this.arrays.setSource(source);
    this.library.scoped((scope) =>
      this.library.call(
        `espalier_change_evaluator_f32_evaluate${this.arrays.hasAddend ? "_and_add" : ""}`,
        this.address,
        ...this.arrays.parameters(this.arrays.hasAddend),
        changed.length,
        scope.integers(changed),
        this.arrays.workspace,
      ),
    );
    return this.arrays.result();
  }
}

/** The source, the result and the addend of evaluations, in the memory of the module. */
class FloatArrays {
  readonly workspace: number;
  hasAddend = false;
  private readonly block: number;
  private readonly source: number;
  private readonly destination: number;
  private readonly addend: number;
  private readonly layout: number;

  constructor(
    private readonly library: Espalier,
    private readonly rowCount: number,
    private readonly columnCount: number,
  ) {
    const { core } = library;
    this.workspace = library.create("espalier_workspace_create");
    const sizes = [24, 12 * columnCount, 12 * rowCount, 12 * rowCount];
    this.block = core._malloc(sizes.reduce((sum, size) => sum + size, 0));
    if (this.block === 0) throw new EspalierError(3, `there is no memory for ${rowCount} points`);
    this.layout = this.block;
    this.source = this.layout + sizes[0];
    this.destination = this.source + sizes[1];
    this.addend = this.destination + sizes[2];
    // offset 0, length 3, stride 3, as 64-bit integers
    core.HEAP32.set([0, 0, 3, 0, 3, 0], this.layout / 4);
  }

  parts(): [string, number][] {
    return [
      ["workspace", this.workspace],
      ["", this.block],
    ];
  }

  setSource(values: Float32Array): void {
    if (values.length !== 3 * this.columnCount)
      throw new EspalierError(1, `got ${values.length} numbers; expected ${3 * this.columnCount}`);
    this.library.core.HEAPF32.set(values, this.source / 4);
  }

  setAddend(values: Float32Array): void {
    if (values.length !== 3 * this.rowCount)
      throw new EspalierError(1, `got ${values.length} numbers; expected ${3 * this.rowCount}`);
    this.library.core.HEAPF32.set(values, this.addend / 4);
    this.hasAddend = true;
  }

  /** The parameters from `source` to `destination_layout`. */
  parameters(withAddend: boolean): (number | bigint)[] {
    const points = BigInt(3 * this.rowCount);
    return [
      this.source,
      BigInt(3 * this.columnCount),
      this.layout,
      ...(withAddend ? [this.addend, points, this.layout] : []),
      this.destination,
      points,
      this.layout,
    ];
  }

  result(): Float32Array {
    return floatsAt(this.library.core, this.destination, 3 * this.rowCount);
  }
}

/** Finds out where poses turn the volume of a lattice inside out. */
export class Validity extends Handle {
  readonly cellCount: number;

  constructor(library: Espalier, pointer: number) {
    super(library, pointer, "validity");
    this.cellCount = library.scoped((scope) => {
      const out = scope.allocate(4);
      library.call("espalier_validity_cell_count", pointer, out);
      return library.core.HEAP32[out / 4];
    });
  }

  /** The cells of the level that a pose turns inside out: at most 0 times the volume at rest. */
  invertedCells(pose: Float64Array): number[] {
    return this.library.scoped((scope) => {
      const ratios = scope.allocate(8 * this.cellCount);
      this.library.call(
        "espalier_validity_check",
        this.address,
        pose.length / 3,
        scope.doubles(pose),
        this.cellCount,
        ratios,
        scope.allocate(16),
      );
      const inverted: number[] = [];
      for (let cell = 0; cell < this.cellCount; ++cell)
        if (this.library.core.HEAPF64[ratios / 8 + cell] <= 0) inverted.push(cell);
      return inverted;
    });
  }

  /** The cell of the lattice from which a cell of the level descends. */
  baseCell(cell: number): number {
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      this.library.call("espalier_validity_base_cell", this.address, cell, out);
      return this.library.core.HEAP32[out / 4];
    });
  }
}
