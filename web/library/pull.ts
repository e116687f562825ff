// SPDX-License-Identifier: Apache-2.0
// Pulls of points of a model that bend the lattice (c/espalier_solve.h).

import { numbers } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { doublesAt, integersAt } from "./memory.ts";

export interface PullOptions {
  /** vertices that do not move */
  frozen?: ArrayLike<number>;
  /** places in the list of rows: the points that are to stay */
  pins?: ArrayLike<number>;
  /** vertices farther from all pulled points than this part of the farthest one's distance do not move: 0 to 1;
   * default 0.5 */
  reach?: number;
  /** the iteration ends when no vertex moves by more than this part of the lattice's diagonal; default 1e-6 */
  tolerance?: number;
  /** default 500; for one frame of a drag 20 are enough */
  maxIterations?: number;
  /** true: the vertices that the lattice holds, such as the outer ones of a collar, may move, too; default false */
  moveHeld?: boolean;
}

export interface Pulled {
  /** three numbers for each vertex of the lattice */
  displacements: Float64Array;
  /** largest distance of a point from its target */
  largestMiss: number;
  iterations: number;
  /** true if cells would fold, or nearly, without the barrier that keeps them open; points may then stay away from
   * their targets */
  meetsBarrier: boolean;
}

/** Pulls points while the cells of the lattice stay as rigid as they can. Made by Table.pull(), for any number of
 * targets of the same points. */
export class Pull extends Handle {
  constructor(
    library: CLibrary,
    pointer: number,
    private readonly vertexCount: number,
    private readonly pointCount: number,
  ) {
    super(library, pointer, "pull");
  }

  /** The vertices that do not move: frozen ones, and those beyond the reach. */
  fixedVertices(): Int32Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_pull_fixed", this.address, out, out + 4);
      const [count, vertices] = integersAt(this.library.core, out, 2);
      return integersAt(this.library.core, vertices, count);
    });
  }

  /** Finds displacements of the vertices.
   *
   * @param misses three numbers for each point: its target minus its place at rest
   * @param start displacements to start from, such as those of the frame before; default: rest
   */
  solve(misses: ArrayLike<number>, start?: ArrayLike<number>): Pulled {
    const { core } = this.library;
    numbers("misses", misses, 3 * this.pointCount);
    if (start !== undefined) numbers("start", start, 3 * this.vertexCount);
    return this.library.scoped((scope) => {
      const displacements = scope.allocate(24 * this.vertexCount);
      const quality = scope.allocate(32);
      this.library.call(
        "espalier_pull_solve",
        this.address,
        this.pointCount,
        scope.doubles(misses),
        this.vertexCount,
        start === undefined ? 0 : scope.doubles(start),
        displacements,
        quality,
      );
      return {
        displacements: doublesAt(core, displacements, 3 * this.vertexCount),
        largestMiss: core.HEAPF64[quality / 8],
        iterations: core.HEAP32[quality / 4 + 6],
        meetsBarrier: core.HEAP32[quality / 4 + 7] !== 0,
      };
    });
  }
}
