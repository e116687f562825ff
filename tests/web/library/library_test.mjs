// SPDX-License-Identifier: Apache-2.0
// Tests the npm package under Node.js: each class, errors, memory, and the example of web/README.md. Results are
// compared with what the program makes from the same files.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { program, root } from "../program.mjs";

const library = join(root, "out/espalier-npm/espalier.js");
assert.ok(existsSync(library), `${library} is missing: run scripts/web first`);
const { EspalierError, isCancelled, load, SHARP } = await import(library);
const espalier = await load();
const bytesOf = (text) => new TextEncoder().encode(text);
const textOf = (bytes) => new TextDecoder().decode(bytes);

/** A sphere of `rows` rings, as OBJ. */
function sphere(rows) {
  let text = "# a sphere\n";
  const around = 2 * rows;
  for (let i = 0; i <= rows; ++i)
    for (let k = 0; k < around; ++k) {
      const [a, b] = [(Math.PI * i) / rows, (2 * Math.PI * k) / around];
      text += `v ${Math.sin(a) * Math.cos(b)} ${Math.sin(a) * Math.sin(b)} ${Math.cos(a)}\n`;
    }
  for (let i = 0; i < rows; ++i)
    for (let k = 0; k < around; ++k) {
      const at = (row, place) => 1 + row * around + (place % around);
      text += `f ${at(i, k)} ${at(i + 1, k)} ${at(i + 1, k + 1)} ${at(i, k + 1)}\n`;
    }
  return text;
}

let folder;
before(() => (folder = mkdtempSync(join(tmpdir(), "espalier-package-"))));
after(() => rmSync(folder, { recursive: true, force: true }));
const file = (name) => join(folder, name);
const run = (...words) => execFileSync(program, [...words.map(String), "--quiet"], { cwd: folder });

/** Checks that two texts differ in the last digits of numbers at most. The program's kernels use fused products where
 * the processor has them; WebAssembly has none. */
function assertAlike(actual, expected) {
  const [ours, theirs] = [actual, expected].map((text) => text.split(/(?<=[\s"])/));
  assert.equal(ours.length, theirs.length);
  ours.forEach((word, i) => {
    if (word === theirs[i]) return;
    assert.ok(Math.abs(Number(word) - Number(theirs[i])) < 1e-15 * 8, `${word} is not ${theirs[i]}`);
  });
}

test("the files of a deformation are the program's", () => {
  writeFileSync(file("sphere.obj"), sphere(12));
  run("shape", "cage", "sphere.obj", "--vertices", 60, "-o", "rest.vtu");
  run("pose", "rest.vtu", "--twist", "z", 40, "-o", "pose.vtu");
  run("deform", "sphere.obj", "--rest", "rest.vtu", "--to", "pose.vtu", "-o", "moved.obj");
  run("stencils", "rest.vtu", "--points", "sphere.obj", "-n", 3, "-o", "d.npz");
  run("refine", "rest.vtu", "-n", 0, "-o", "cage.obj");
  run("refine", "rest.vtu", "-n", 0, "-o", "again.vtu");

  const model = espalier.readModel("sphere.obj", readFileSync(file("sphere.obj")));
  const cage = espalier.readLattice("rest.vtu", readFileSync(file("rest.vtu")));
  assert.deepEqual(Buffer.from(cage.write(".vtu")), readFileSync(file("again.vtu")));
  assert.deepEqual(Buffer.from(cage.writeEditorMesh(".obj")), readFileSync(file("cage.obj")));
  const rest = cage.positions();
  const pose = cage.readPose("pose.vtu", readFileSync(file("pose.vtu")));
  const twisted = espalier.poses.twist(rest, [0, 0, 1], (40 * Math.PI) / 180);
  pose.forEach((coordinate, i) => assert.ok(Math.abs(coordinate - twisted[i]) < 1e-14));

  const binding = cage.refiner().bind(rest, model.points());
  assert.ok(binding.statuses().every((status) => status === 0));
  assert.ok(binding.statuses().every((status) => status === 0));
  assert.ok(binding.largestResidual() < 1e-9);
  const moved = binding.apply(pose, model.points().length / 3);
  assertAlike(textOf(model.write(moved)), readFileSync(file("moved.obj"), "utf8"));
  assert.deepEqual(Buffer.from(model.write(model.points())), readFileSync(file("sphere.obj")));
  const [d, ofProgram] = [binding.table(), espalier.readTable("d.npz", readFileSync(file("d.npz")))];
  assert.deepEqual(d.rows().columns, ofProgram.rows().columns);
  const weights = ofProgram.rows().weights;
  d.rows().weights.forEach((weight, i) => assert.ok(Math.abs(weight - weights[i]) < 1e-15 * 8));
  assert.deepEqual(espalier.readTable("same.npz", d.write(".npz")).rows(), d.rows());
});

test("deformers follow a drag", () => {
  const lattice = espalier.box([4, 4, 4], [0, 0, 0], [1, 1, 1]);
  const points = new Float64Array(3000).map((_, i) => 0.02 + 0.96 * ((i * 0.6180339887) % 1));
  const binding = lattice.refiner().bind(lattice.positions(), points);
  const deformer = binding.deformer();
  const pose = Float32Array.from(lattice.positions());
  const rest = deformer.deform(pose);
  assert.deepEqual(rest, Float32Array.from(points));
  pose[3 * 62 + 1] += 0.125;
  const dragged = deformer.deformChanged(pose, [62]);
  assert.deepEqual(dragged, deformer.deform(pose));
  assert.notDeepEqual(dragged, rest);
  const into = new Float32Array(3000);
  assert.equal(deformer.deform(pose, into), into);
  assert.deepEqual(into, dragged);
  // The table alone: D times the pose, where each row sums to 1.
  const table = binding.table();
  const product = table.evaluator().evaluate(pose);
  product.forEach((value, i) => assert.ok(Math.abs(value - dragged[i]) < 1e-5));

  const { displacements, largestMiss } = table.fit(lattice, [5], [0.1, 0, 0]);
  assert.ok(largestMiss < 1e-12 && displacements.some((value) => value > 0));
  const still = table.fit(lattice, [5], [0.1, 0, 0], { frozen: [62] }).displacements;
  assert.equal(still[3 * 62], 0);
});

test("cages hold their models", () => {
  const model = espalier.readModel("sphere.obj", bytesOf(sphere(12)));
  const cage = espalier.cage(model.points(), model.faces(), { vertices: 60 });
  assert.ok(Math.abs(cage.counts()[0] - 60) <= 12);
  const binding = cage.refiner().bind(cage.positions(), model.points());
  assert.ok(binding.statuses().every((status) => status === 0));
});

test("a model tells how it looks", () => {
  const text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.5\nvn 0 0 1\nusemtl wood\nf 1/1/1 2/1/1 3/1/1\n";
  const look = espalier.readModel("a.obj", bytesOf(text)).appearance();
  assert.deepEqual(look, {
    textures: Float64Array.of(0, 0.5),
    textureCorners: Int32Array.of(0, 0, 0),
    normals: Float64Array.of(0, 0, 1),
    normalCorners: Int32Array.of(0, 0, 0),
    colors: null,
    covariances: null,
    materials: ["wood"],
    faceMaterials: Int32Array.of(0),
  });
  const colours = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0.5\n";
  const { colors, textures } = espalier.readModel("b.obj", bytesOf(colours)).appearance();
  assert.deepEqual(colors, Float32Array.of(1, 0, 0, 1, 0, 1, 0.5, 1));
  assert.equal(textures, null);
});

test("a model is read with a file beside it, and written in another format", () => {
  const points = new Uint8Array(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0).buffer);
  const json = {
    asset: { version: "2.0" },
    buffers: [{ byteLength: 36, uri: "data/a%20b.bin" }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    nodes: [{ mesh: 0 }],
  };
  const bytes = bytesOf(JSON.stringify(json));
  assert.throws(() => espalier.readModel("a.gltf", bytes), /its buffer is in another file/);
  const model = espalier.readModel("a.gltf", bytes, { "data/a b.bin": points });
  assert.deepEqual(model.points(), Float64Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0));
  const moved = Float64Array.of(2, 0, 0, 1, 0, 0, 0, 1, 0);
  const written = model.write(moved, undefined, ".glb");
  assert.deepEqual(espalier.readModel("a.glb", written).points(), moved);
  assert.throws(
    () => espalier.readModel("a.gltf", bytes, { "data/a b.bin": points.length }),
    TypeError,
  );
});

test("a part of a model follows", () => {
  const text =
    "v .1 .1 .5 1 0 0\nv .9 .1 .5 .5 0 0\nv .9 .9 .5 .25 0 0\nv .1 .9 1.25 1 0 0\n" +
    "vn 0 0 1\ng a\nf 1//1 2//1 3//1\ng b c\nf 1//1 3//1 4//1\n";
  const model = espalier.readModel("two.obj", bytesOf(text));
  assert.deepEqual(model.attributes(), ["red", "green", "blue"]);
  assert.deepEqual(model.groups(), ["a", "b", "c"]);
  assert.deepEqual([...model.weights(4, "", ["c"])], [1, 0, 1, 1]);
  const weights = model.weights(4, "red");
  assert.deepEqual([...weights], [1, 0.5, 0.25, 1]);
  assert.throws(() => model.weights(4, "bend"), /has no attribute 'bend' of points; it has 'red'/);
  const lattice = espalier.box([2, 2, 2], [0, 0, 0], [1, 1, 1]);
  const rest = lattice.positions();
  const weightSlopes = model.weightSlopes(weights);
  const options = { gradients: true, weights, weightSlopes, falloff: 0.5 };
  const binding = lattice.refiner().bind(rest, model.points(), options);
  const up = rest.map((coordinate, i) => coordinate + Number(i % 3 === 2));
  const lifted = binding.apply(up, 4).map((coordinate, i) => coordinate - model.points()[i]);
  // Half of the distance of the falloff from the lattice, a point follows with a half.
  [1, 0.5, 0.25, 0.5].forEach((height, i) => assert.ok(Math.abs(lifted[3 * i + 2] - height) < 1e-12));
  // The weight of point 1 falls by 0.625 along x in its only triangle, and so does its height.
  assert.ok(Math.abs(binding.gradients(up, 4)[9 + 6] + 0.625) < 1e-12);
  assert.equal(lattice.refiner().bind(rest, model.points(), { weights: new Float64Array(4) }).statuses()[0], 3);
});

test("lattices are edited", () => {
  const cube = espalier.regularSolid("cube");
  assert.deepEqual(cube.counts(), [8, 12, 6, 1]);
  // Outwards from a face is its middle as seen from the origin, the middle of the cube.
  const { faceVertices } = cube.refiner().cells(0);
  const outwards = [0, 1, 2].map((axis) =>
    [0, 1, 2, 3].reduce((sum, i) => sum + cube.positions()[3 * faceVertices[i] + axis], 0),
  );
  const two = cube.withPrism(0, outwards);
  assert.deepEqual(two.counts(), [12, 20, 11, 2]);
  assert.deepEqual(two.withoutCells([1]).counts(), [8, 12, 6, 1]);
  assert.deepEqual(cube.withPyramid(0, outwards).counts(), [9, 16, 10, 2]);
  const boxes = [0, 1].map((x) => espalier.box([1, 1, 1], [x, 0, 0], [x + 1, 1, 1]));
  assert.deepEqual(espalier.merged(boxes).counts(), [12, 20, 11, 2]);
  cube.markEdges([0, 1], [1.5]);
  cube.markVertices([2], [SHARP]);
  const marks = espalier.readLattice("c.vtu", cube.write(".vtu")).marks();
  assert.deepEqual([...marks.edgeSharpness, ...marks.vertexSharpness], [1.5, SHARP]);
  cube.clearMarks();
  assert.equal(cube.marks().edges.length, 0);
  const refiner = cube.refiner();
  refiner.refine(1);
  assert.deepEqual(refiner.counts(1), [27, 54, 36, 8]);
  assert.equal(refiner.edges(1).length, 108);
  assert.equal(refiner.strata(1, 0).filter((stratum) => stratum === 3).length, 1);
  assert.equal(refiner.cells(1).cellOffsets[8], 48);
});

test("folded cells are found", () => {
  const lattice = espalier.box([2, 2, 2], [0, 0, 0], [2, 2, 2]);
  const rest = lattice.positions();
  const validity = lattice.refiner().validity(rest, 1);
  assert.deepEqual(validity.invertedCells(rest), []);
  const folded = rest.map((coordinate, i) => (i === 3 * 26 ? -3 : coordinate));
  const inverted = validity.invertedCells(folded);
  assert.ok(inverted.length > 0);
  assert.ok(inverted.every((cell) => validity.baseCell(cell) < 8));
});

test("limbs, and selections along the cells", () => {
  // A box of 3 x 3 x 3 cubes, of which a column remains above the lowest layer.
  const box = espalier.box([3, 3, 6], [0, 0, 0], [3, 3, 6]);
  const isRemoved = (cell) => cell >= 27 && cell % 9 !== 4;
  const lattice = box.withoutCells([...Array(54).keys()].filter(isRemoved));
  const rest = lattice.positions();
  const { poses } = espalier;
  const { weights, section } = poses.selectLimb(lattice, rest, [1.5, 1.5, 6]);
  assert.equal(weights.filter((weight) => weight === 1).length, 16);
  assert.ok(Math.abs(section.area - 1) < 1e-14);
  section.center.forEach((c, i) => assert.ok(Math.abs(c - [1.5, 1.5, 3][i]) < 1e-14));
  assert.deepEqual(poses.selectionBorder(lattice, rest, weights), section);
  const face = poses.nearestInnerFace(lattice, rest, [1.5, 1.5, 4]);
  const beyond = poses.selectBeyond(lattice, rest, face);
  assert.equal(beyond.weights.filter((weight) => weight === 1).length, 12);
  assert.deepEqual(poses.growSelection(lattice, weights, -1), beyond.weights);
  assert.deepEqual(poses.withoutHeld(lattice, weights), weights);
  const near = poses.selectNear(lattice, rest, [1.5, 1.5, 6], 1);
  assert.equal(near.filter((weight) => weight === 1).length, 4);
  const vertices = [...near.keys()].filter((v) => near[v] === 1);
  const falling = poses.selectAlongCells(lattice, rest, vertices, { radius: 2, profile: "linear" });
  assert.equal(falling.filter((weight) => weight === 0.5).length, 4);
  assert.throws(() => poses.selectLimb(box, box.positions(), [0, 0, 0]), /has no limb/);
});

test("pulls bend the lattice", () => {
  const lattice = espalier.box([2, 2, 8], [0, 0, 0], [2, 2, 8]);
  const rest = lattice.positions();
  const points = new Float64Array([1, 1, 7.5, 1, 1, 0.5]);
  const table = lattice.refiner().bind(rest, points).table();
  const all = table.pull(lattice, rest, [0], { reach: 1 });
  assert.equal(all.fixedVertices().length, 0);
  const moved = all.solve([1, 2, 3]).displacements;
  moved.forEach((d, i) => assert.ok(Math.abs(d - [1, 2, 3][i % 3]) < 1e-9));
  const pull = table.pull(lattice, rest, [0, 1], { pins: [1], frozen: [0] });
  assert.ok(pull.fixedVertices().includes(0));
  const bent = pull.solve([1, 0, -0.2, 0, 0, 0]);
  assert.equal(typeof bent.meetsBarrier, "boolean");
  assert.ok(bent.largestMiss < 1e-6 && bent.iterations > 1);
  assert.equal(bent.displacements[0], 0);
  assert.ok(pull.solve([1, 0, -0.2, 0, 0, 0], bent.displacements).iterations <= bent.iterations);
  assert.throws(() => pull.solve([1, 0, 0]), /misses: expected 6 numbers, got 3/);
  pull.free();
});

test("selections and operations", () => {
  const rest = espalier.box([1, 1, 2], [0, 0, 0], [1, 1, 2]).positions();
  const { poses } = espalier;
  const end = poses.selectEnd(rest, [0, 0, 1]);
  assert.deepEqual([...end], [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1]);
  // The end is the last 1 % of the height of 2, so the middle layer is 0.98 away from it.
  const falling = poses.selectEnd(rest, [0, 0, 1], { radius: 2, profile: "linear" })[4];
  assert.ok(Math.abs(falling - 0.51) < 1e-14);
  assert.equal(poses.selectBox(rest, [0, 0, 0], [1, 1, 0])[3], 1);
  assert.equal(poses.selectBall(rest, [0, 0, 0], 1.1)[3], 0);
  assert.equal(poses.selectHalfSpace(rest, [0, 0, 1], [0, 0, 1])[4], 1);
  assert.equal(poses.selectNumbers(rest, [7])[7], 1);
  const moved = poses.move(rest, [0, 0, 1], { weights: end });
  assert.equal(moved[3 * 8 + 2], 3);
  assert.equal(moved[3 * 7 + 2], 1);
  const scaled = poses.scale(rest, [2, 1, 1], { center: [0, 0, 0] });
  assert.equal(scaled[3], 2);
  const turned = poses.rotate(rest, [0, 0, 1], Math.PI / 2, { center: [0, 0, 0] });
  assert.ok(Math.abs(turned[4] - 1) < 1e-15);
  const half = poses.taper(rest, [0, 0, 1], 0.5, { center: [0, 0, 0], range: [0, 2] });
  assert.equal(half[3 * 9], 0.5);
  const both = poses.mirror(rest, moved, 2, { weights: end });
  assert.deepEqual([both.positions[2], both.positions[3 * 4 + 2], both.withoutImage], [-1, 1, 0]);
  assert.equal(poses.mirror(rest, rest, 2, { plane: 0 }).withoutImage, 8);
  const bent = poses.bend(rest, [0, 0, 1], Math.PI / 2, [1, 0, 0]);
  assert.ok(bent[3 * 8] > 1);
});

test("errors have the library's messages, and work can be cancelled", () => {
  const refused = (text, call) =>
    assert.throws(call, (error) => error instanceof EspalierError && error.message.includes(text));
  refused("b.obj:1: 'x' is not a number", () => espalier.readModel("b.obj", bytesOf("v 1 x 2\n")));
  refused("e.obj", () => espalier.readModel("e.obj", bytesOf("")));
  refused("t.vtu", () => espalier.readLattice("t.vtu", bytesOf("<VTKFile")));
  refused("barbell: endRadius: expected a finite number above 0, got -1", () => espalier.barbell({ endRadius: -1 }));
  refused("cells[0]", () => espalier.around(new Float64Array(6).map((_, i) => i), { cells: [-1, 1, 1] }));
  const cube = espalier.regularSolid("cube");
  refused("level", () => cube.refiner().bind(cube.positions(), new Float64Array(3), { level: 99 }));
  let reports = 0;
  const work = () => cube.refiner().refine(6);
  espalier.withProgress(() => (++reports, true), work, 0);
  assert.ok(reports > 1);
  assert.throws(() => espalier.withProgress(() => false, work, 0), isCancelled);
  cube.free();
  assert.throws(() => cube.counts(), /has been freed/);
});

test("freed memory is used again", () => {
  const bytes = bytesOf(sphere(60));
  const once = () => {
    const model = espalier.readModel("sphere.obj", bytes);
    const lattice = espalier.around(model.points());
    const refiner = lattice.refiner();
    const binding = refiner.bind(lattice.positions(), model.points());
    const table = binding.table();
    const evaluator = table.evaluator();
    const deformer = binding.deformer();
    evaluator.evaluate(Float32Array.from(lattice.positions()));
    deformer.deform(Float32Array.from(lattice.positions()));
    for (const each of [deformer, evaluator, table, binding, refiner, lattice, model]) each.free();
  };
  for (let i = 0; i < 5; ++i) once();
  const before = espalier.core.HEAPU8.length;
  for (let i = 0; i < 50; ++i) once();
  assert.equal(espalier.core.HEAPU8.length, before);
});

test("the example of the README prints a bent plate", async () => {
  const page = readFileSync(join(root, "web/README.md"), "utf8");
  const example = /```js\n(.*?)```/s.exec(page)[1];
  const source = example.replace(`"espalier"`, `"${join(root, "out/espalier-npm/espalier.js")}"`);
  writeFileSync(file("example.mjs"), source);
  const out = execFileSync(process.execPath, [file("example.mjs")], { encoding: "utf8" });
  const points = [...out.matchAll(/^v (\S+) (\S+) (\S+)$/gm)].map((line) => line.slice(1, 4).map(Number));
  assert.equal(points.length, 4);
  // The lower edge is below the middle of the bend by as much as the upper edge leans over.
  assert.ok(points[2][0] > points[0][0] + 0.5);
  assert.ok(out.endsWith("f 1 2 4 3\n\n"));
});
