// SPDX-License-Identifier: Apache-2.0
// Points that are bound to a lattice.

import { countPoints, integer } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { Deformer } from "./evaluator.ts";
import { bytesAt, doublesAt, integersAt } from "./memory.ts";
import { Table } from "./table.ts";

export interface BindOptions {
  /** level whose cells hold the points, 1 to 20; default 3 */
  level?: number;
  /** binds to the limit instead, within this tolerance: 1e-6 is usual */
  limitTolerance?: number;
  /** what happens to points outside; default "keep" */
  outside?: "keep" | "nearest" | "refuse";
  tolerance?: number;
  /** makes the gradients too, for Binding.gradients() */
  gradients?: boolean;
  /** how far each point follows: a number of 0 to 1 for each; default: all follow fully */
  weights?: Float64Array;
  /** the derivatives of the weights by the points, three for each, for the gradients:
   * Model.weightSlopes(); default: 0 */
  weightSlopes?: Float64Array;
  /** above 0, points outside follow with a weight that falls to 0 at this distance; default 0 */
  falloff?: number;
}

/** Where binding found a point. */
export const enum PointStatus {
  Inside = 0,
  Outside = 1,
  NotConverged = 2,
  /** its weight is 0 */
  NotBound = 3,
}

/** Points that are bound to a lattice. */
export class Binding extends Handle {
  constructor(library: CLibrary, pointer: number) {
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

  /** A deformer for many poses, in single precision. */
  deformer(): Deformer {
    const [vertexCount, , pointCount] = this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_binding_rest", this.address, out, out + 4, out + 8, out + 12);
      return integersAt(this.library.core, out, 3);
    });
    const pointer = this.library.create("espalier_deformer_f32_create", this.address);
    return new Deformer(this.library, pointer, vertexCount, pointCount);
  }

  /** The points for a pose of the lattice. */
  apply(pose: Float64Array, pointCount: number): Float64Array {
    return this.forPose("apply", pose, pointCount, 3);
  }

  /** The deformation gradient of each point for a pose, nine numbers, row by row: for Model.write(). */
  gradients(pose: Float64Array, pointCount: number): Float64Array {
    return this.forPose("gradients", pose, pointCount, 9);
  }

  /** Calls a C function that makes `width` numbers for each point. */
  private forPose(name: string, pose: Float64Array, pointCount: number, width: number) {
    const vertexCount = countPoints("pose", pose);
    const size = width * integer("pointCount", pointCount);
    return this.library.scoped((scope) => {
      const results = scope.allocate(8 * size);
      this.library.call(
        `espalier_binding_${name}`,
        this.address,
        vertexCount,
        scope.doubles(pose),
        pointCount,
        results,
      );
      return doublesAt(this.library.core, results, size);
    });
  }
}
