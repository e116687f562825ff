// SPDX-License-Identifier: Apache-2.0
// Lattices: cells, the positions of their vertices, and marks.

import { choice, countPoints, integer, integers, numbers, options as object } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { doublesAt, integersAt, longAt, type Scope } from "./memory.ts";
import { Refiner, type RefineOptions } from "./refiner.ts";

/** x, y, z */
export type Point = [number, number, number];

/** Infinite sharpness: refinement never uses it up. */
export const SHARP = 10;

export interface Marks {
  /** two vertices for each edge */
  edges: Int32Array;
  edgeSharpness: Float64Array;
  vertices: Int32Array;
  vertexSharpness: Float64Array;
}

/** Cells, the positions of their vertices, and marks. */
export class Lattice extends Handle {
  constructor(library: CLibrary, pointer: number) {
    super(library, pointer, "lattice");
  }

  /** @internal Calls a C function whose last parameter receives a new lattice. */
  static make(
    library: CLibrary,
    name: string,
    values: (scope: Scope) => (number | bigint)[],
  ): Lattice {
    return library.scoped((scope) => new Lattice(library, library.create(name, ...values(scope))));
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
    const count = countPoints("positions", positions);
    this.library.scoped((scope) =>
      this.library.call(
        "espalier_lattice_set_positions",
        this.address,
        count,
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
    numbers("sharpness", sharpness);
    integers("ends", ends, 2 * sharpness.length);
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
    numbers("sharpness", sharpness);
    integers("vertices", vertices, sharpness.length);
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
    return Lattice.make(this.library, "espalier_lattice_create_with_prism", (scope) => [
      this.address,
      integer("face", face),
      scope.doubles(numbers("offset", offset, 3)),
    ]);
  }

  /** A lattice with one more cell: a pyramid on a boundary face. */
  withPyramid(face: number, apex: Point): Lattice {
    return Lattice.make(this.library, "espalier_lattice_create_with_pyramid", (scope) => [
      this.address,
      integer("face", face),
      scope.doubles(numbers("apex", apex, 3)),
    ]);
  }

  /** A lattice without some cells, and without the vertices of these cells alone. */
  withoutCells(cells: ArrayLike<number>): Lattice {
    integers("cells", cells);
    return Lattice.make(this.library, "espalier_lattice_create_without_cells", (scope) => [
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
  writeEditorMesh(extension: string): Uint8Array {
    return this.library.file(extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call("espalier_lattice_write_editor_mesh", this.address, scope.text(path)),
      ),
    );
  }

  /** Reads a pose of this lattice: a lattice with the same cells, or an editor mesh (.obj, .ply). */
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
    const { rules = "siggraph96", boundary = "sharp" } = object("options", options);
    const { sharpEdges = "single-cell" } = options;
    return this.library.scoped((scope) => {
      const chosen = scope.struct([
        ["size"],
        ["i32", choice("rules", rules, ["siggraph96", "cse96", "mlca"])],
        ["i32", choice("boundary", boundary, ["sharp", "edge-only", "open"])],
        ["i32", choice("sharpEdges", sharpEdges, ["single-cell", "literal"])],
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
