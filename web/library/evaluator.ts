// SPDX-License-Identifier: Apache-2.0
// Products of a table with positions, and deformed points, in single precision.

import { integers, numbers, typed } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { EspalierError, floatsAt } from "./memory.ts";

/** A table in the form that is fastest to apply, in single precision. */
export class Evaluator extends Handle {
  private readonly arrays: FloatArrays;

  constructor(
    library: CLibrary,
    pointer: number,
    readonly rowCount: number,
    readonly columnCount: number,
  ) {
    const arrays = new FloatArrays(library, columnCount, rowCount);
    super(library, pointer, "evaluator_f32");
    this.arrays = arrays;
  }

  protected override release(): void {
    this.arrays.free();
  }

  /** The table times a source of three numbers for each column.
   * @param into receives the result, instead of a new array
   */
  evaluate(source: Float32Array, into?: Float32Array): Float32Array {
    const { arrays } = this;
    this.library.call(
      "espalier_evaluator_f32_evaluate",
      this.address,
      ...arrays.setSource("source", source),
      arrays.layout,
      ...arrays.destination,
      arrays.layout,
      0,
      this.rowCount,
      arrays.address,
    );
    return arrays.result(into);
  }
}

/** Deforms the points of a binding, for many poses, in single precision. Points that a pose does not move stay
 * exactly where they are. */
export class Deformer extends Handle {
  private readonly arrays: FloatArrays;

  constructor(library: CLibrary, pointer: number, vertexCount: number, pointCount: number) {
    const arrays = new FloatArrays(library, vertexCount, pointCount);
    super(library, pointer, "deformer_f32");
    this.arrays = arrays;
  }

  protected override release(): void {
    this.arrays.free();
  }

  /** The points for a pose: three numbers for each vertex of the lattice.
   * @param into receives the result, instead of a new array
   */
  deform(pose: Float32Array, into?: Float32Array): Float32Array {
    const { arrays } = this;
    this.library.call(
      "espalier_deformer_f32_deform",
      this.address,
      ...arrays.setSource("pose", pose),
      ...arrays.destination,
    );
    return arrays.result(into);
  }

  /** The points for a pose that differs from the last one in these vertices only. */
  deformChanged(pose: Float32Array, changed: ArrayLike<number>, into?: Float32Array): Float32Array {
    const { arrays } = this;
    integers("changed", changed);
    const source = arrays.setSource("pose", pose);
    this.library.scoped((scope) =>
      this.library.call(
        "espalier_deformer_f32_deform_changed",
        this.address,
        ...source,
        changed.length,
        scope.integers(changed),
        ...arrays.destination,
      ),
    );
    return arrays.result(into);
  }
}

/** A workspace, and the source and the result of evaluations, in the memory of the module. */
class FloatArrays extends Handle {
  /** The address of a buffer layout: offset 0, length 3, stride 3. */
  readonly layout: number;
  /** The address and the size of the result, as parameters of a call. */
  readonly destination: readonly [number, bigint];
  private readonly source: number;

  constructor(
    library: CLibrary,
    private readonly sourceCount: number,
    private readonly resultCount: number,
  ) {
    const { core } = library;
    const block = core._malloc(24 + 12 * sourceCount + 12 * resultCount);
    if (block === 0) throw new EspalierError(3, `there is no memory for ${resultCount} points`);
    super(library, library.create("espalier_workspace_create"), "workspace", [["", block]]);
    this.layout = block;
    this.source = block + 24;
    this.destination = [this.source + 12 * sourceCount, BigInt(3 * resultCount)];
    core.HEAP32.set([0, 0, 3, 0, 3, 0], this.layout / 4); // as 64-bit integers
  }

  /** Copies the source, and returns its address and its size. */
  setSource(name: string, values: Float32Array): readonly [number, bigint] {
    const checked = numbers(name, values, 3 * this.sourceCount);
    this.library.core.HEAPF32.set(checked, this.source / 4);
    return [this.source, BigInt(3 * this.sourceCount)];
  }

  result(into?: Float32Array): Float32Array {
    const count = 3 * this.resultCount;
    const [address] = this.destination;
    if (into === undefined) return floatsAt(this.library.core, address, count);
    typed("into", into, Float32Array);
    if (into.length < count)
      throw new RangeError(`into: expected ${count} numbers, got ${into.length}`);
    into.set(this.library.core.HEAPF32.subarray(address / 4, address / 4 + count));
    return into;
  }
}
