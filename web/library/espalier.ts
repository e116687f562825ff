// SPDX-License-Identifier: Apache-2.0
// Espalier for JavaScript: classes over the C interface (c/espalier.h), which says what each function does, costs
// and refuses. Arrays go in and come out as copies. Objects hold memory of the module until free() is called, or
// until they are collected.

import loadCore from "espalier-core";
import { CLibrary } from "./c_library.ts";
import { Lattice, type Point } from "./lattice.ts";
import type { Core, Scope } from "./memory.ts";
import { Model, type Polygons } from "./model.ts";
import { Poses } from "./poses.ts";
import type { Cells } from "./refiner.ts";
import { Table } from "./table.ts";

export { Binding, PointStatus, type BindOptions } from "./binding.ts";
export type { Progress } from "./c_library.ts";
export { ChangeEvaluator, Evaluator } from "./evaluator.ts";
export { Lattice, SHARP, type Marks, type Point } from "./lattice.ts";
export { EspalierError, isCancelled } from "./memory.ts";
export { Model, type Polygons } from "./model.ts";
export { Poses, type Falloff, type PoseOptions } from "./poses.ts";
export { Refiner, type Cells, type RefineOptions } from "./refiner.ts";
export { Table, type CompressedRows, type Fit, type FitOptions } from "./table.ts";
export { Validity } from "./validity.ts";

export interface AroundOptions {
  /** cells along x, y and z */
  cells?: Point;
  cellsAlongLongest?: number;
  cellSize?: number;
  margin?: number;
  oriented?: boolean;
}

export interface CageOptions {
  /** number of vertices; the cage has between 0.8 and 1.2 times as many; default 200 */
  vertices?: number;
  /** edge of the cells, instead of a number of vertices */
  cellSize?: number;
  /** least distance from the model, as a fraction of the diagonal of the box around it */
  margin?: number;
  /** thickness of a cage around the surface only */
  shell?: number;
  keepApart?: boolean;
}

/** What joins a disk in its middle. */
export type DiskCore = "wedges" | "polygon";

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
export class Espalier extends CLibrary {
  /** Selections of vertices, and operations that move them. */
  readonly poses = new Poses(this);

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

  /** Makes a lattice of hexahedra that follows the shape of a model and contains all its faces. */
  cage(points: Float64Array, faces: Polygons, options: CageOptions = {}): Lattice {
    return this.makeLattice("espalier_lattice_create_cage", (scope) => [
      points.length / 3,
      scope.doubles(points),
      scope.struct([
        ["i64", faces.offsets.length - 1],
        ["pointer", scope.longs(faces.offsets)],
        ["pointer", scope.integers(faces.corners)],
      ]),
      scope.struct([
        ["size"],
        ["i32", options.vertices ?? 200],
        ["i32", options.keepApart ? 1 : 0],
        ["f64", options.cellSize ?? 0],
        ["f64", options.margin ?? 0],
        ["f64", options.shell ?? 0],
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
        ["i64", options.joints.length],
        ["pointer", scope.doubles(joints)],
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

  private makeLattice(name: string, values: (scope: Scope) => (number | bigint)[]): Lattice {
    return Lattice.make(this, name, values);
  }
}

const kRegularSolids = { tetrahedron: 0, cube: 1, octahedron: 2, dodecahedron: 3, icosahedron: 4 };
const kPolygonalSolids = { prism: 0, pyramid: 1, bipyramid: 2 };
const numberOfCore = (core: DiskCore) => (core === "wedges" ? 0 : 1);
const extensionOf = (name: string) => name.slice(name.lastIndexOf(".")).toLowerCase();
