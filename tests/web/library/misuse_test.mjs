// SPDX-License-Identifier: Apache-2.0
// Tests the npm package with wrong arguments, exceptions in callbacks, and objects that are not freed: what JavaScript
// without types can do to it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { root } from "../program.mjs";

const library = join(root, "out/espalier-npm/espalier.js");
assert.ok(existsSync(library), `${library} is missing: run scripts/web first`);
const { isCancelled, load } = await import(library);
const espalier = await load();
const { poses } = espalier;
const box = espalier.box([2, 2, 2], [0, 0, 0], [1, 1, 1]);
const rest = box.positions();
const refiner = box.refiner();
const binding = refiner.bind(rest, new Float64Array([0.5, 0.5, 0.5]));
const table = binding.table();
const evaluator = table.evaluator();
const deformer = binding.deformer();
const model = espalier.readModel("p.obj", new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
const square = { offsets: [0, 4], corners: [0, 1, 2, 3] };

/** Wrong calls, with the start of the message that names the argument. */
const calls = [
  ["axis: expected an array, got 0", () => poses.rotate(rest, 0, 1)],
  ["axis: expected 3 numbers, got 2", () => poses.rotate(rest, [0, 1], 1)],
  ["axis[1]: expected a number, got undefined", () => poses.rotate(rest, [0, , 1], 1)],
  ['axis[2]: expected a number, got "1"', () => poses.rotate(rest, [0, 0, "1"], 1)],
  ["axis[0]: expected a number, got the BigInt 0n", () => poses.rotate(rest, new BigInt64Array(3), 1)],
  ["angle: expected a number, got undefined", () => poses.rotate(rest, [0, 0, 1])],
  ["positions: expected an array, got an ArrayBuffer", () => poses.rotate(rest.buffer, [0, 0, 1], 1)],
  ["positions: expected 3 numbers for each point, got 4", () => poses.move([0, 0, 0, 0], [0, 0, 1])],
  ["positions: expected an array, got null", () => poses.selectEnd(null, [0, 0, 1])],
  ["options: expected an object, got 7", () => poses.twist(rest, [0, 0, 1], 1, 7)],
  ["weights: expected 27 numbers, got 1", () => poses.move(rest, [0, 0, 1], { weights: [1] })],
  ["range: expected 2 numbers, got 3", () => poses.taper(rest, [0, 0, 1], 2, { range: [0, 1, 2] })],
  ["falloff: expected an object, got 0.5", () => poses.selectBall(rest, [0, 0, 0], 1, 0.5)],
  ["falloff.radius: expected a number", () => poses.selectBall(rest, [0, 0, 0], 1, {})],
  ['falloff.profile: expected "linear" or "smooth", got "flat"', () =>
    poses.selectBall(rest, [0, 0, 0], 1, { radius: 1, profile: "flat" })],
  ["vertices[1]: expected an integer of 32 bits, got 0.5", () => poses.selectNumbers(rest, [0, 0.5])],
  ["lattice: expected a lattice of Espalier", () => poses.selectLimb([], rest, [0, 0, 0])],
  ["point: expected 3 numbers, got 2", () => poses.selectNear(box, rest, [0, 0], 1)],
  ["face: expected an integer of 32 bits, got 0.5", () => poses.selectBeyond(box, rest, 0.5)],
  ["weights: expected 27 numbers, got 1", () => poses.selectionBorder(box, rest, [1])],
  ["steps: expected an integer of 32 bits, got undefined", () => poses.growSelection(box, new Float64Array(27))],
  ["pins[0]: expected an integer of 32 bits, got 0.5", () => table.pull(box, rest, [0], { pins: [0.5] })],
  ['reach: expected a number, got "1"', () => table.pull(box, rest, [0], { reach: "1" })],
  ["misses: expected 3 numbers, got 1", () => table.pull(box, rest, [0]).solve([0])],
  ["start: expected 81 numbers, got 1", () => table.pull(box, rest, [0]).solve([0, 0, 0], [0])],
  ["toward: expected an array, got undefined", () => poses.bend(rest, [0, 0, 1], 1)],
  ["level: expected an integer of 32 bits, got 2.5", () => refiner.bind(rest, rest, { level: 2.5 })],
  ["options: expected an object, got 5", () => refiner.bind(rest, rest, 5)],
  ['outside: expected "keep" or "nearest" or "refuse", got "error"', () =>
    refiner.bind(rest, rest, { outside: "error" })],
  ["gradients: expected true or false, got 1", () => refiner.bind(rest, rest, { gradients: 1 })],
  ["weights: expected 27 numbers, got 1", () => refiner.bind(rest, rest, { weights: new Float64Array(1) })],
  ["weightSlopes: expected 81 numbers, got 27", () =>
    refiner.bind(rest, rest, { weightSlopes: new Float64Array(27) })],
  ['falloff: expected a number, got "1"', () => refiner.bind(rest, rest, { falloff: "1" })],
  ["pointCount: expected an integer of 32 bits, got undefined", () => model.weights()],
  ["weights: expected an array, got undefined", () => model.weightSlopes()],
  ["points: expected an array, got undefined", () => refiner.bind(rest)],
  ['level: expected an integer of 32 bits, got "2"', () => refiner.refine("2")],
  ["level: expected an integer of 32 bits, got 4294967297", () => refiner.counts(2 ** 32 + 1)],
  ["pointCount: expected an integer of 32 bits, got undefined", () => binding.apply(rest)],
  ["pose: expected an array, got an Object", () => binding.apply(box, 1)],
  ["bytes: expected a Uint8Array, got a String", () => espalier.readModel("a.obj", new String(""))],
  ['bytes: expected a Uint8Array, got "v 0 0 0"', () => espalier.readModel("a.obj", "v 0 0 0")],
  ["bytes: expected a Uint8Array, got an ArrayBuffer", () => espalier.readLattice("a.vtu", new ArrayBuffer(8))],
  ["name: expected a string, got a Uint8Array", () => espalier.readModel(new Uint8Array(8), "a.obj")],
  ["name: expected a string, got undefined", () => espalier.readTable()],
  ["extension: expected a string, got undefined", () => box.write()],
  ["ends: expected 4 numbers, got 2", () => box.markEdges([0, 1], [1, 1])],
  ["vertices: expected 1 numbers, got 2", () => box.markVertices([0, 1], [1])],
  ["cells: expected an array, got 1", () => box.withoutCells(1)],
  ["face: expected an integer of 32 bits, got undefined", () => box.withPrism()],
  ['rules: expected "siggraph96" or "cse96" or "mlca", got "catmull"', () => box.refiner({ rules: "catmull" })],
  ["lattices[0]: expected a lattice of Espalier", () => espalier.merged([refiner])],
  ["lattices: expected an array", () => espalier.merged(box)],
  ["lattice: expected a lattice of Espalier", () => table.fit(refiner, [0], [0, 0, 0])],
  ["misses: expected 3 numbers, got 1", () => table.fit(box, [0], [0])],
  ["rows: expected an array, got 0", () => table.fit(box, 0, [0, 0, 0])],
  ["source: expected 81 numbers, got 3", () => evaluator.evaluate(new Float32Array(3))],
  ["into: expected a Float32Array, got an Array", () => evaluator.evaluate(new Float32Array(81), [0, 0, 0])],
  ["into: expected 3 numbers, got 1", () => evaluator.evaluate(new Float32Array(81), new Float32Array(1))],
  ["pose: expected 81 numbers, got 3", () => deformer.deform(new Float32Array(3))],
  ["changed: expected an array, got 4", () => deformer.deformChanged(new Float32Array(81), 4)],
  ["gradients: expected 27 numbers, got 9", () => model.write(model.points(), new Float64Array(9))],
  ["faces: expected an object, got undefined", () => espalier.cage(rest)],
  ["faces.corners: expected 4 numbers, got 3", () => espalier.cage(rest, { ...square, corners: [0, 1, 2] })],
  ["cells.cellFaces: expected 6 numbers, got 1", () =>
    espalier.latticeOfCells({ ...espalier.regularSolid("cube").refiner().cells(0), cellFaces: [0] }, rest)],
  ["cells: expected 3 numbers, got 1", () => espalier.around(rest, { cells: [2] })],
  ["max: expected an array, got undefined", () => espalier.box([1, 1, 1], [0, 0, 0])],
  ['core: expected "wedges" or "polygon", got "hub"', () => espalier.star({ core: "hub" })],
  ["endRadius: expected a number", () => espalier.barbell({ endRadius: "1" })],
  ["joints[1]: expected an object", () => espalier.arm({ joints: [{ position: [0, 0, 0], radius: 1 }, 2] })],
  ["joints[0].position: expected 3 numbers", () => espalier.arm({ joints: [{ position: [0, 0], radius: 1 }] })],
  ['name: expected "tetrahedron" or "cube"', () => espalier.regularSolid("sphere")],
  ["sides: expected an integer", () => espalier.polygonalSolid("prism")],
  ["report: expected a function, got undefined", () => espalier.withProgress(undefined, () => 0)],
  ["work: expected a function, got undefined", () => espalier.withProgress(() => true)],
];

test("a wrong argument is named", () => {
  for (const [text, call] of calls)
    assert.throws(call, (error) => {
      assert.ok(error instanceof TypeError || error instanceof RangeError, `${text}: ${error?.stack}`);
      assert.ok(error.message.startsWith(text), `${error.message} is not ${text}`);
      return true;
    }, text);
});

test("arrays of other kinds are numbers too", () => {
  const expected = poses.rotate(rest, [0, 0, 1], 1);
  assert.deepEqual(poses.rotate([...rest], new Float32Array([0, 0, 1]), 1), expected);
  assert.deepEqual(poses.rotate({ length: rest.length, ...rest }, new Uint8Array([0, 0, 1]), 1), expected);
});

test("bytes that are no WebAssembly are refused", async () => {
  await assert.rejects(load(new Uint8Array(8)), WebAssembly.CompileError);
});

test("an exception of a progress callback reaches the caller", () => {
  const points = Float64Array.from({ length: 3000 }, (_, i) => (i * 0.6180339887) % 1);
  const work = () => refiner.bind(rest, points, { level: 6 });
  const own = new Error("in the callback");
  let calls = 0;
  const report = () => {
    ++calls;
    throw own;
  };
  for (const each of [work, () => [work, work].map((call) => assert.throws(call, isCancelled))])
    assert.throws(() => espalier.withProgress(report, each, 0), (error) => error === own);
  assert.equal(calls, 2); // Work that goes on after the exception does not call it again.
  // The library works afterwards, and a callback that returns nothing does not cancel.
  let reports = 0;
  const bound = espalier.withProgress(() => void ++reports, work, 0);
  assert.ok(reports > 0);
  assert.equal(bound.statuses().length, 1000);
});

test("an uncaught exception of a progress callback prints itself alone", () => {
  const code = `
    import { load } from ${JSON.stringify(library)};
    const espalier = await load();
    const box = espalier.regularSolid("cube").refiner();
    espalier.withProgress(() => { throw new Error("in the callback"); }, () => box.refine(5), 0);`;
  const run = () =>
    execFileSync(process.execPath, ["--input-type=module", "--eval", code], { stdio: "pipe", encoding: "utf8" });
  assert.throws(run, ({ stdout, stderr }) => {
    assert.equal(stdout, "");
    assert.match(stderr, /Error: in the callback/);
    // Node.js prints the line that threw, and at most ten lines of the stack.
    assert.ok(stderr.split("\n").length < 30, stderr.slice(0, 2000));
    return true;
  });
});

test("a deformer that has been freed says so, and leaves others alone", () => {
  const [one, other] = [binding.deformer(), binding.deformer()];
  const source = Float32Array.from(rest);
  const expected = one.deform(source);
  one.free();
  one.free();
  table.evaluator().evaluate(new Float32Array(81)); // takes the memory, if it is free
  assert.throws(() => one.deform(source), /has been freed/);
  assert.deepEqual(other.deform(source), expected);
});

test("`using` frees objects at the end of a block", () => {
  const points = Float64Array.from({ length: 300_000 }, (_, i) => (i * 0.6180339887) % 1);
  /** `{ using binding = …; }`, as compilers write it: Node.js 20 does not know the word. */
  const once = () => {
    const bound = refiner.bind(rest, points);
    bound[Symbol.dispose]();
    assert.throws(() => bound.statuses(), /has been freed/);
  };
  once();
  const before = espalier.core.HEAPU8.length;
  for (let i = 0; i < 100; ++i) once();
  assert.equal(espalier.core.HEAPU8.length, before);
});
