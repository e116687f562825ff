// SPDX-License-Identifier: Apache-2.0
// The topology of a lattice and of its levels, and what is made of it.

import {
  choice,
  countPoints,
  flag,
  integer,
  numbers,
  options as object,
  real,
} from "./arguments.ts";
import { Binding, type BindOptions } from "./binding.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { bytesAt, integersAt, longsAt } from "./memory.ts";
import { Table } from "./table.ts";
import { Validity } from "./validity.ts";

export interface RefineOptions {
  rules?: "siggraph96" | "cse96" | "mlca";
  boundary?: "sharp" | "edge-only" | "open";
  sharpEdges?: "single-cell" | "literal";
}

/** A level of a lattice: its cells by their faces, and its faces by their vertices. */
export interface Cells {
  vertexCount: number;
  cellOffsets: Int32Array;
  cellFaces: Int32Array;
  faceOffsets: Int32Array;
  faceVertices: Int32Array;
}

/** The topology of a lattice and of its levels. */
export class Refiner extends Handle {
  constructor(library: CLibrary, pointer: number) {
    super(library, pointer, "refiner");
  }

  refine(level: number): void {
    this.library.call("espalier_refiner_refine", this.address, integer("level", level));
  }

  counts(level: number): [number, number, number, number] {
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_refiner_counts", this.address, integer("level", level), out);
      return [...integersAt(this.library.core, out, 4)] as [number, number, number, number];
    });
  }

  cells(level: number): Cells {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(28);
      this.library.call("espalier_refiner_cells", this.address, integer("level", level), out);
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
      this.library.call("espalier_refiner_face_signs", this.address, integer("level", level), out);
      const signs = core.HEAP32[out / 4];
      return core.HEAP8.slice(signs, signs + count);
    });
  }

  /** The two vertices of each edge. */
  edges(level: number): Int32Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_refiner_edges", this.address, integer("level", level), out, out + 4);
      const [count, ends] = integersAt(this.library.core, out, 2);
      return integersAt(this.library.core, ends, 2 * count);
    });
  }

  /** For each entity the dimension of its feature: 0 corner, 1 sharp edge, 2 surface, 3 interior. */
  strata(level: number, dimension: 0 | 1 | 2 | 3): Uint8Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call(
        "espalier_refiner_strata",
        this.address,
        integer("level", level),
        integer("dimension", dimension),
        out,
        out + 4,
      );
      const [count, strata] = integersAt(this.library.core, out, 2);
      return bytesAt(this.library.core, strata, count);
    });
  }

  /** S_level: vertices of the level × vertices of the lattice. */
  stencils(level: number): Table {
    return new Table(
      this.library,
      this.library.create("espalier_table_create_stencils", this.address, integer("level", level)),
    );
  }

  /** Limit positions of the vertices of a level: vertices of the level × vertices of the lattice. */
  limits(level: number): Table {
    return new Table(
      this.library,
      this.library.create("espalier_table_create_limits", this.address, integer("level", level)),
    );
  }

  bind(positions: Float64Array, points: Float64Array, options: BindOptions = {}): Binding {
    const { level = 3, outside = "keep", tolerance = 1e-6 } = object("options", options);
    const { limitTolerance = 0, gradients = false, falloff = 0 } = options;
    const { weights, weightSlopes } = options;
    const vertexCount = countPoints("positions", positions);
    const pointCount = countPoints("points", points);
    if (weights) numbers("weights", weights, pointCount);
    if (weightSlopes) numbers("weightSlopes", weightSlopes, 3 * pointCount);
    return this.library.scoped((scope) => {
      const binding = this.library.create(
        "espalier_binding_create",
        this.address,
        vertexCount,
        scope.doubles(positions),
        pointCount,
        scope.doubles(points),
        scope.struct([
          ["size"],
          ["i32", integer("level", level)],
          ["i32", choice("outside", outside, ["keep", "nearest", "refuse"])],
          ["f64", real("tolerance", tolerance)],
          ["f64", real("limitTolerance", limitTolerance)],
          ["i32", flag("gradients", gradients)],
          ["i32", weights ? scope.doubles(weights) : 0],
          ["i32", weightSlopes ? scope.doubles(weightSlopes) : 0],
          ["f64", real("falloff", falloff)],
        ]),
      );
      return new Binding(this.library, binding);
    });
  }

  /** Prepares checks of poses for cells that are inside out. */
  validity(positions: Float64Array, level = 3): Validity {
    const vertexCount = countPoints("positions", positions);
    return this.library.scoped((scope) => {
      const validity = this.library.create(
        "espalier_validity_create",
        this.address,
        vertexCount,
        scope.doubles(positions),
        scope.struct([["size"], ["i32", integer("level", level)], ["i32", 0]]),
      );
      return new Validity(this.library, validity);
    });
  }
}
