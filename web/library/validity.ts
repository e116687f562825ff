// SPDX-License-Identifier: Apache-2.0
// Cells that poses turn inside out.

import { integer, countPoints } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";

/** Finds out where poses turn the volume of a lattice inside out. */
export class Validity extends Handle {
  readonly cellCount: number;

  constructor(library: CLibrary, pointer: number) {
    super(library, pointer, "validity");
    this.cellCount = library.scoped((scope) => {
      const out = scope.allocate(4);
      library.call("espalier_validity_cell_count", pointer, out);
      return library.core.HEAP32[out / 4];
    });
  }

  /** The cells of the level that a pose turns inside out: at most 0 times the volume at rest. */
  invertedCells(pose: Float64Array): number[] {
    const vertexCount = countPoints("pose", pose);
    return this.library.scoped((scope) => {
      const ratios = scope.allocate(8 * this.cellCount);
      this.library.call(
        "espalier_validity_check",
        this.address,
        vertexCount,
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
      this.library.call("espalier_validity_base_cell", this.address, integer("cell", cell), out);
      return this.library.core.HEAP32[out / 4];
    });
  }
}
