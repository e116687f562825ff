// SPDX-License-Identifier: Apache-2.0
// Espalier for JavaScript: classes over the C interface (c/espalier.h), which says what each function does, costs
// and refuses. Arrays go in and come out as copies. Objects hold memory of the module until free() is called, or
// until they are collected.

import loadCore from "espalier-core";
import * as check from "./arguments.ts";
import { CLibrary, Handle } from "./c_library.ts";
import { Lattice, type Point } from "./lattice.ts";
import type { Core, Scope } from "./memory.ts";
import { Model, type Polygons } from "./model.ts";
import { Poses } from "./poses.ts";
import type { Cells } from "./refiner.ts";
import { Table } from "./table.ts";

export { Binding, PointStatus, type BindOptions } from "./binding.ts";
export type { Progress } from "./c_library.ts";
export { Deformer, Evaluator } from "./evaluator.ts";
export { Lattice, SHARP, type Marks, type Point } from "./lattice.ts";
export { EspalierError, isCancelled } from "./memory.ts";
export { Model, type Appearance, type Polygons } from "./model.ts";
export {
  Poses,
  type Falloff,
  type PoseOptions,
  type Section,
  type Mirrored,
  type SelectedPart,
} from "./poses.ts";
export { Pull, type Pulled, type PullOptions } from "./pull.ts";
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
  /** planes about which the cage is symmetric, across the axes; default "auto": those of the model */
  symmetric?: "auto" | "none" | "x" | "y" | "z" | "xy" | "xz" | "yz" | "xyz";
  /** largest distance of a mirrored point from the model that counts as symmetric, as a fraction of the
   * diagonal; default 1e-4 */
  symmetry?: number;
}

/** What joins a disk in its middle. */
export type DiskCore = "wedges" | "polygon";

/** Loads the library.
 *
 * @param source the file espalier.wasm: its bytes, or a compiled module; by default, the file beside this one
 */
export async function load(source?: BufferSource | WebAssembly.Module): Promise<Espalier> {
  const wasm = source ?? (await fileBesideThis());
  const module = wasm instanceof WebAssembly.Module ? wasm : await WebAssembly.compile(wasm);
  const core = await loadCore({
    instantiateWasm(imports: WebAssembly.Imports, done: (instance: WebAssembly.Instance) => void) {
      WebAssembly.instantiate(module, imports).then(done);
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

  /** Reads a model: .obj, .ply, .stl, .glb, .gltf, .vtu, .vtp or .vtk.
   * @param beside files that the model names, by the names: the .bin of a .gltf
   */
  readModel(name: string, bytes: Uint8Array, beside: Record<string, Uint8Array> = {}): Model {
    check.text("name", name);
    check.typed("bytes", bytes, Uint8Array);
    return this.withFiles(beside, () =>
      this.scoped((scope) => {
        const content = scope.bytes(bytes);
        return new Model(
          this,
          this.create("espalier_model_read_bytes", scope.text(name), BigInt(bytes.length), content),
          extensionOf(name),
        );
      }),
    );
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
    check.options("cells", cells);
    checkLists("cells.cellOffsets", cells.cellOffsets, "cells.cellFaces", cells.cellFaces);
    checkLists("cells.faceOffsets", cells.faceOffsets, "cells.faceVertices", cells.faceVertices);
    check.integer("cells.vertexCount", cells.vertexCount);
    check.numbers("positions", positions, 3 * cells.vertexCount);
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
    const { cells = [0, 0, 0], cellsAlongLongest = 4 } = check.options("options", options);
    const { oriented = false, cellSize = 0, margin = 0.05 } = options;
    const count = check.countPoints("points", points);
    check.integers("cells", cells, 3);
    return this.makeLattice("espalier_lattice_create_around", (scope) => [
      BigInt(count),
      scope.doubles(points),
      scope.struct([
        ["size"],
        ["i32", cells[0]],
        ["i32", cells[1]],
        ["i32", cells[2]],
        ["i32", check.integer("cellsAlongLongest", cellsAlongLongest)],
        ["i32", check.flag("oriented", oriented)],
        ["f64", check.real("cellSize", cellSize)],
        ["f64", check.real("margin", margin)],
      ]),
    ]);
  }

  /** Makes a lattice of hexahedra that follows the shape of a model and contains all its faces. */
  cage(points: Float64Array, faces: Polygons, options: CageOptions = {}): Lattice {
    const { vertices = 200, keepApart = false } = check.options("options", options);
    const { cellSize = 0, margin = 0, shell = 0, symmetric = "auto", symmetry = 1e-4 } = options;
    const count = check.countPoints("points", points);
    const { offsets, corners } = check.options("faces", faces);
    checkLists("faces.offsets", offsets, "faces.corners", corners);
    return this.makeLattice("espalier_lattice_create_cage", (scope) => [
      count,
      scope.doubles(points),
      scope.struct([
        ["i64", offsets.length - 1],
        ["pointer", scope.longs(offsets)],
        ["pointer", scope.integers(corners)],
      ]),
      scope.struct([
        ["size"],
        ["i32", check.integer("vertices", vertices)],
        ["i32", check.flag("keepApart", keepApart)],
        ["f64", check.real("cellSize", cellSize)],
        ["f64", check.real("margin", margin)],
        ["f64", check.real("shell", shell)],
        ["f64", check.real("symmetry", symmetry)],
        ["i32", check.choice("symmetric", symmetric, kSymmetric)],
      ]),
    ]);
  }

  box(cells: Point, min: Point, max: Point): Lattice {
    return this.makeLattice("espalier_lattice_create_box", (scope) => [
      scope.integers(check.integers("cells", cells, 3)),
      scope.doubles(check.numbers("min", min, 3)),
      scope.doubles(check.numbers("max", max, 3)),
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
    const { sectors = 8, rings = 1, layers = 1, radius = 1 } = check.options("options", options);
    const { from = [0, 0, 0], to = [0, 0, 1] } = options;
    return this.makeLattice("espalier_lattice_create_cylinder", (scope) => [
      check.integer("sectors", sectors),
      check.integer("rings", rings),
      numberOfCore(options.core ?? "wedges"),
      check.integer("layers", layers),
      check.real("radius", radius),
      scope.doubles(check.numbers("from", from, 3)),
      scope.doubles(check.numbers("to", to, 3)),
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
    check.options("options", options);
    return this.makeLattice("espalier_lattice_create_torus", (scope) => [
      scope.struct([
        ["size"],
        ["i32", check.integer("segments", options.segments ?? 8)],
        ["i32", options.sides === undefined ? 0 : 1],
        ["i32", check.integer("gridCells", options.gridCells ?? 1)],
        ["i32", check.integer("sides", options.sides ?? 6)],
        ["i32", check.integer("rings", options.rings ?? 1)],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["f64", check.real("majorRadius", options.majorRadius ?? 1)],
        ["f64", check.real("minorRadius", options.minorRadius ?? 0.4)],
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
    check.options("options", options);
    return this.makeLattice("espalier_lattice_create_star", (scope) => [
      scope.struct([
        ["size"],
        ["i32", check.integer("points", options.points ?? 5)],
        ["i32", check.integer("rings", options.rings ?? 1)],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["i32", check.integer("layers", options.layers ?? 1)],
        ["f64", check.real("innerRadius", options.innerRadius ?? 0.5)],
        ["f64", check.real("outerRadius", options.outerRadius ?? 1)],
        ["f64", check.real("height", options.height ?? 0.25)],
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
    check.options("options", options);
    return this.makeLattice("espalier_lattice_create_barbell", (scope) => [
      scope.struct([
        ["size"],
        ["i32", check.integer("endSegments", options.endSegments ?? 6)],
        ["i32", check.integer("barSegments", options.barSegments ?? 2)],
        ["i32", check.integer("barAcross", options.barAcross ?? 2)],
        ["i32", check.integer("rings", options.rings ?? 1)],
        ["i32", numberOfCore(options.core ?? "wedges")],
        ["i32", check.integer("layers", options.layers ?? 1)],
        ["f64", check.real("endRadius", options.endRadius ?? 1)],
        ["f64", check.real("barLength", options.barLength ?? 2)],
        ["f64", check.real("barHalfWidth", options.barHalfWidth ?? 0.4)],
        ["f64", check.real("roundness", options.roundness ?? 1)],
        ["f64", check.real("height", options.height ?? 0.5)],
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
    const { up = [0, 0, 1] } = check.options("options", options);
    check.list("joints", options.joints);
    check.numbers("up", up, 3);
    const joints = Array.from(options.joints, (joint, i) => {
      const { position, radius, twist = 0 } = check.options(`joints[${i}]`, joint);
      return [
        ...Array.from(check.numbers(`joints[${i}].position`, position, 3)),
        check.real(`joints[${i}].radius`, radius),
        check.real(`joints[${i}].twist`, twist),
      ];
    }).flat();
    return this.makeLattice("espalier_lattice_create_arm", (scope) => [
      scope.struct([
        ["size"],
        ["i32", check.integer("segments", options.segments ?? 2)],
        ["i32", check.integer("sides", options.sides ?? 4)],
        ["i32", check.integer("rings", options.rings ?? 1)],
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
  regularSolid(name: (typeof kRegularSolids)[number], radius = 1): Lattice {
    return this.makeLattice("espalier_lattice_create_regular_solid", () => [
      check.choice("name", name, kRegularSolids),
      check.real("radius", radius),
    ]);
  }

  /** A single cell over a regular polygon. */
  polygonalSolid(
    name: (typeof kPolygonalSolids)[number],
    sides: number,
    radius = 1,
    height = 1,
  ): Lattice {
    return this.makeLattice("espalier_lattice_create_polygonal_solid", () => [
      check.choice("name", name, kPolygonalSolids),
      check.integer("sides", sides),
      check.real("radius", radius),
      check.real("height", height),
    ]);
  }

  /** Joins lattices by welding vertices that coincide; of a single lattice, its own vertices. */
  merged(lattices: Lattice[], tolerance = 1e-6): Lattice {
    check.list("lattices", lattices);
    const addresses = Array.from(lattices, (lattice, i) =>
      Handle.addressOf(`lattices[${i}]`, lattice, "lattice"),
    );
    return this.makeLattice("espalier_lattice_create_merged", (scope) => [
      BigInt(addresses.length),
      scope.integers(addresses),
      check.real("tolerance", tolerance),
    ]);
  }

  private makeLattice(name: string, values: (scope: Scope) => (number | bigint)[]): Lattice {
    return Lattice.make(this, name, values);
  }
}

// in the order of the C enumerations
const kRegularSolids = [
  "tetrahedron",
  "cube",
  "octahedron",
  "dodecahedron",
  "icosahedron",
] as const;
const kPolygonalSolids = ["prism", "pyramid", "bipyramid"] as const;
const kSymmetric = ["auto", "none", "x", "y", "z", "xy", "xz", "yz", "xyz"] as const;
const numberOfCore = (core: DiskCore) => check.choice("core", core, ["wedges", "polygon"]);

/** Checks lists: list i has the members offsets[i] to offsets[i + 1] - 1. The library checks the offsets but for the
 * last, which says how many members it reads. */
function checkLists(
  nameOfOffsets: string,
  offsets: ArrayLike<number>,
  nameOfMembers: string,
  members: ArrayLike<number>,
): void {
  check.integers(nameOfOffsets, offsets);
  check.integers(nameOfMembers, members, offsets[offsets.length - 1] ?? 0);
}
const extensionOf = (name: string) => name.slice(name.lastIndexOf(".")).toLowerCase();
