// SPDX-License-Identifier: Apache-2.0
// Sparse matrices, and their products with positions.

import { choice, countPoints, flag, integer, integers, numbers, options as object, real } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { Evaluator } from "./evaluator.ts";
import type { Lattice } from "./lattice.ts";
import { doublesAt, integersAt, longsAt } from "./memory.ts";
import { Pull, type PullOptions } from "./pull.ts";

/** A sparse matrix in compressed rows. */
export interface CompressedRows {
  rowCount: number;
  columnCount: number;
  offsets: Int32Array;
  columns: Int32Array;
  weights: Float64Array;
}

export interface FitOptions {
  /** what displacements should satisfy besides reaching the targets; default "none" */
  smoothing?: "none" | "tikhonov" | "laplacian";
  /** weight of smoothing relative to the targets, 1e-4 to 1e4; default 1e-3 */
  strength?: number;
  /** vertices that do not move */
  frozen?: ArrayLike<number>;
  /** true: the vertices that the lattice holds, such as the outer ones of a collar, may move, too; default false */
  moveHeld?: boolean;
}

export interface Fit {
  /** three numbers for each vertex of the lattice */
  displacements: Float64Array;
  /** largest distance of a point from its target */
  largestMiss: number;
}

/** An immutable sparse matrix. */
export class Table extends Handle {
  constructor(library: CLibrary, pointer: number) {
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

  /** Finds the smallest displacements of the vertices that carry points to targets.
   *
   * @param lattice to which the points are bound
   * @param rows the points that have targets
   * @param misses three numbers for each of them: its target minus its place at rest
   */
  fit(
    lattice: Lattice,
    rows: ArrayLike<number>,
    misses: ArrayLike<number>,
    options: FitOptions = {},
  ): Fit {
    integers("rows", rows);
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    const { core } = this.library;
    const vertexCount = lattice.counts()[0];
    const {
      smoothing = "none",
      strength = 1e-3,
      frozen = [],
      moveHeld = false,
    } = object("options", options);
    integers("frozen", frozen);
    return this.library.scoped((scope) => {
      const displacements = scope.allocate(24 * vertexCount);
      const quality = scope.allocate(24);
      this.library.call(
        "espalier_lattice_fit",
        this.address,
        latticeAt,
        rows.length,
        scope.integers(rows),
        scope.doubles(numbers("misses", misses, 3 * rows.length)),
        scope.struct([
          ["size"],
          ["i32", choice("smoothing", smoothing, ["none", "tikhonov", "laplacian"])],
          ["i32", 0],
          ["f64", real("strength", strength)],
          ["i64", frozen.length],
          ["pointer", scope.integers(frozen)],
          ["i64", flag("moveHeld", moveHeld)],
        ]),
        vertexCount,
        displacements,
        quality,
      );
      return {
        displacements: doublesAt(core, displacements, 3 * vertexCount),
        largestMiss: core.HEAPF64[quality / 8],
      };
    });
  }

  /** Prepares pulls of points that bend the lattice: its cells stay as rigid as they can.
   *
   * @param lattice to which the points are bound
   * @param positions of its vertices at rest
   * @param rows the points that are pulled or pinned
   */
  pull(
    lattice: Lattice,
    positions: Float64Array,
    rows: ArrayLike<number>,
    options: PullOptions = {},
  ): Pull {
    integers("rows", rows);
    const latticeAt = Handle.addressOf("lattice", lattice, "lattice");
    const vertexCount = countPoints("positions", positions);
    const {
      frozen = [],
      pins = [],
      reach = 0.5,
      tolerance = 1e-6,
      maxIterations = 500,
      moveHeld = false,
    } = object("options", options);
    integers("frozen", frozen);
    integers("pins", pins);
    return this.library.scoped((scope) => {
      const pointer = this.library.create(
        "espalier_pull_create",
        latticeAt,
        vertexCount,
        scope.doubles(positions),
        this.address,
        rows.length,
        scope.integers(rows),
        scope.struct([
          ["size"],
          ["i64", frozen.length],
          ["pointer", scope.integers(frozen)],
          ["i64", pins.length],
          ["pointer", scope.integers(pins)],
          ["f64", real("reach", reach)],
          ["f64", real("tolerance", tolerance)],
          ["i32", integer("maxIterations", maxIterations)],
          ["i64", flag("moveHeld", moveHeld)],
        ]),
      );
      return new Pull(this.library, pointer, vertexCount, rows.length);
    });
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
