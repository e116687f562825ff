// SPDX-License-Identifier: Apache-2.0
// Products of a table with positions, in single precision.

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
    const arrays = new FloatArrays(library, rowCount, columnCount);
    super(library, pointer, "evaluator_f32", arrays.parts());
    this.arrays = arrays;
  }

  /** The table times a source of three numbers for each column; with `addend`, plus the addend.
   * @param into receives the result, instead of a new array
   */
  evaluate(source: Float32Array, addend?: Float32Array, into?: Float32Array): Float32Array {
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
    return this.arrays.result(into);
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
    library: CLibrary,
    pointer: number,
    private readonly arrays: FloatArrays,
  ) {
    super(library, pointer, "change_evaluator_f32");
  }

  /** Sets the rows that depend on these columns, to the table times the source, plus the addend of
   * the last evaluation if it had one; returns all rows. */
  evaluate(source: Float32Array, changed: ArrayLike<number>, into?: Float32Array): Float32Array {
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
    return this.arrays.result(into);
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
    private readonly library: CLibrary,
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

  result(into?: Float32Array): Float32Array {
    const count = 3 * this.rowCount;
    if (!into) return floatsAt(this.library.core, this.destination, count);
    const at = this.destination / 4;
    into.set(this.library.core.HEAPF32.subarray(at, at + count));
    return into;
  }
}
