// SPDX-License-Identifier: Apache-2.0
// Products of a table with positions, in single precision.

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
    const arrays = new FloatArrays(library, rowCount, columnCount);
    super(library, pointer, "evaluator_f32");
    this.arrays = arrays;
  }

  protected override release(): void {
    this.arrays.free();
  }

  /** The table times a source of three numbers for each column; with `addend`, plus the addend.
   * @param into receives the result, instead of a new array
   */
  evaluate(source: Float32Array, addend?: Float32Array, into?: Float32Array): Float32Array {
    const evaluator = this.address;
    this.arrays.setSource(source);
    if (addend !== undefined) this.arrays.setAddend(addend);
    this.library.call(
      `espalier_evaluator_f32_evaluate${addend !== undefined ? "_and_add" : ""}`,
      evaluator,
      ...this.arrays.parameters(addend !== undefined),
      0,
      this.rowCount,
      this.arrays.address,
    );
    return this.arrays.result(into);
  }

  /** Prepares evaluations of the rows that depend on a few changed columns. The two share their
   * results: evaluate() sets all rows, and evaluate() of the changes some of them. */
  changes(): ChangeEvaluator {
    const pointer = this.library.create("espalier_change_evaluator_f32_create", this.address);
    return new ChangeEvaluator(this.library, pointer, this.arrays.share());
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

  protected override release(): void {
    this.arrays.free();
  }

  /** Sets the rows that depend on these columns, to the table times the source, plus the addend of
   * the last evaluation if it had one; returns all rows. */
  evaluate(source: Float32Array, changed: ArrayLike<number>, into?: Float32Array): Float32Array {
    const evaluator = this.address;
    integers("changed", changed);
    this.arrays.setSource(source);
    this.library.scoped((scope) =>
      this.library.call(
        `espalier_change_evaluator_f32_evaluate${this.arrays.hasAddend ? "_and_add" : ""}`,
        evaluator,
        ...this.arrays.parameters(this.arrays.hasAddend),
        changed.length,
        scope.integers(changed),
        this.arrays.address,
      ),
    );
    return this.arrays.result(into);
  }
}

/** A workspace, and the source, the result and the addend of evaluations, in the memory of the module. An evaluator
 * and the evaluators of its changes share them; free() by the last of these frees them. */
class FloatArrays extends Handle {
  hasAddend = false;
  private users = 1;
  private readonly source: number;
  private readonly destination: number;
  private readonly addend: number;
  private readonly layout: number;

  constructor(
    library: CLibrary,
    private readonly rowCount: number,
    private readonly columnCount: number,
  ) {
    const { core } = library;
    const sizes = [24, 12 * columnCount, 12 * rowCount, 12 * rowCount];
    const block = core._malloc(sizes.reduce((sum, size) => sum + size, 0));
    if (block === 0) throw new EspalierError(3, `there is no memory for ${rowCount} points`);
    super(library, library.create("espalier_workspace_create"), "workspace", [["", block]]);
    this.layout = block;
    this.source = this.layout + sizes[0];
    this.destination = this.source + sizes[1];
    this.addend = this.destination + sizes[2];
    // offset 0, length 3, stride 3, as 64-bit integers
    core.HEAP32.set([0, 0, 3, 0, 3, 0], this.layout / 4);
  }

  share(): FloatArrays {
    ++this.users;
    return this;
  }

  override free(): void {
    if (--this.users === 0) super.free();
  }

  setSource(values: Float32Array): void {
    const checked = numbers("source", values, 3 * this.columnCount);
    this.library.core.HEAPF32.set(checked, this.source / 4);
  }

  setAddend(values: Float32Array): void {
    const checked = numbers("addend", values, 3 * this.rowCount);
    this.library.core.HEAPF32.set(checked, this.addend / 4);
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
    if (into === undefined) return floatsAt(this.library.core, this.destination, count);
    const at = this.destination / 4;
    typed("into", into, Float32Array);
    if (into.length < count)
      throw new RangeError(`into: expected ${count} numbers, got ${into.length}`);
    into.set(this.library.core.HEAPF32.subarray(at, at + count));
    return into;
  }
}
