// SPDX-License-Identifier: Apache-2.0
// glTF files of the program and of the npm package, judged by others: Khronos' validator, and three.js as a reader.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { program, root } from "../program.mjs";

assert.ok(existsSync(join(root, "web/node_modules/gltf-validator")), "the validator is missing: run scripts/web first");
const require = createRequire(join(root, "web/package.json"));
const validator = require("gltf-validator");
const module = (name) => import(pathToFileURL(join(root, "web/node_modules", name)));
const { Matrix3, Matrix4, Vector3 } = await module("three/build/three.module.js");
const { GLTFLoader } = await module("three/examples/jsm/loaders/GLTFLoader.js");
globalThis.self ??= globalThis; // the loader asks for these two
globalThis.ProgressEvent ??= class extends Event {};

let folder;
before(() => (folder = mkdtempSync(join(tmpdir(), "espalier-gltf-"))));
after(() => rmSync(folder, { recursive: true, force: true }));
const file = (name) => join(folder, name);
const run = (...words) => execFileSync(program, [...words.map(String), "--quiet"], { cwd: folder, stdio: "pipe" });

/** A half of a torus with normals, texture coordinates, colours and two materials. */
function halfTorus() {
  const [along, around] = [16, 12];
  const lines = { v: "", vt: "", vn: "", f: "" };
  for (let i = 0; i <= along; ++i)
    for (let k = 0; k <= around; ++k) {
      const [a, b] = [(Math.PI * i) / along, (2 * Math.PI * k) / around];
      const normal = [Math.cos(a) * Math.cos(b), Math.sin(a) * Math.cos(b), Math.sin(b)];
      const point = [2 * Math.cos(a) + normal[0], 2 * Math.sin(a) + normal[1], normal[2]];
      lines.v += `v ${point.join(" ")} ${i / along} ${k / around} 0.5\n`;
      lines.vt += `vt ${i / along} ${k / around}\n`;
      lines.vn += `vn ${normal.join(" ")}\n`;
    }
  for (let i = 0; i < along; ++i) {
    lines.f += `usemtl ${i % 2 ? "odd" : "even"}\nf`;
    for (let k = 0; k < around; ++k) {
      const at = (row, place) => 1 + row * (around + 1) + place;
      const corner = (number) => ` ${number}/${number}/${number}`;
      lines.f += `${k > 0 ? "f" : ""}${corner(at(i, k))}${corner(at(i + 1, k))}${corner(at(i + 1, k + 1))}${corner(at(i, k + 1))}\n`;
    }
  }
  return lines.v + lines.vt + lines.vn + lines.f;
}

/** Expects no errors and no warnings of the validator. */
async function assertValid(name) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file(name))), {
    uri: name,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(file(uri))),
  });
  const { numErrors, numWarnings, messages } = report.issues;
  assert.deepEqual([numErrors, numWarnings], [0, 0], `${name}: ${JSON.stringify(messages)}`);
}

/** The positions and normals of all vertices in the world, as three.js draws them. */
async function drawn(name) {
  const bytes = readFileSync(file(name));
  const data = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const { scene } = await new GLTFLoader().parseAsync(data, "");
  scene.updateMatrixWorld(true);
  const result = { positions: [], normals: [], materials: new Set(), attributes: new Set() };
  scene.traverse((object) => {
    if (!object.isMesh) return;
    const { position, normal } = object.geometry.attributes;
    const turn = new Matrix3().getNormalMatrix(object.matrixWorld);
    for (let i = 0; i < position.count; ++i) {
      result.positions.push(new Vector3().fromBufferAttribute(position, i).applyMatrix4(object.matrixWorld));
      result.normals.push(new Vector3().fromBufferAttribute(normal, i).applyMatrix3(turn).normalize());
    }
    result.materials.add(object.material.name);
    Object.keys(object.geometry.attributes).forEach((each) => result.attributes.add(each));
  });
  return result;
}

test("models and animations are valid, and turn as a whole", async () => {
  writeFileSync(file("model.obj"), halfTorus());
  run("shape", "around", "model.obj", "--cells", "3,2,2", "-o", "rest.vtu");
  run("pose", "rest.vtu", "--center", 0, 0, 0, "--rotate", "z", 30, "-o", "turned.vtu");
  run("pose", "rest.vtu", "--twist", "x", 80, "-o", "twisted.vtu");
  run("deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu", "-o", "model.glb");
  const rest = await drawn("model.glb");
  assert.deepEqual([...rest.materials].sort(), ["even", "odd"]);
  for (const each of ["position", "normal", "uv", "color"]) assert.ok(rest.attributes.has(each), each);
  for (const name of ["a.glb", "a.gltf"])
    for (const model of ["model.obj", "model.glb"]) {
      run("deform", model, "--rest", "rest.vtu", "--to", "turned.vtu", "-o", name);
      await assertValid(name);
      if (name === "a.gltf" && model === "model.glb") continue; // three.js would need a server for its a.bin
      // Turning the model turns what is drawn.
      const now = await drawn(name);
      const turn = new Matrix4().makeRotationZ(Math.PI / 6);
      assert.equal(now.positions.length, rest.positions.length);
      now.positions.forEach((position, i) => {
        // Floats of coordinates up to 3 are 2.4e-7 apart; each side was rounded twice.
        assert.ok(position.distanceTo(rest.positions[i].clone().applyMatrix4(turn)) < 1e-6);
        assert.ok(now.normals[i].distanceTo(rest.normals[i].clone().applyMatrix4(turn)) < 1e-6);
      });
    }
  run("deform", "model.glb", "--rest", "rest.vtu", "--to", "twisted.vtu", "-n", 3, "-o", "b.glb");
  await assertValid("b.glb");
  for (const name of ["poses.glb", "poses.gltf"]) {
    run("deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu", "twisted.vtu", "-o", name);
    await assertValid(name);
  }
  const animated = await drawn("poses.glb");
  assert.equal(animated.positions.length, rest.positions.length);
});

test("the npm package writes what the program writes", async () => {
  const library = join(root, "out/espalier-npm/espalier.js");
  assert.ok(existsSync(library), `${library} is missing: run scripts/web first`);
  const espalier = await (await import(library)).load();
  const bytes = readFileSync(file("model.glb"));
  const model = espalier.readModel("model.glb", bytes);
  assert.deepEqual(Buffer.from(model.write(model.points())), bytes);
  const moved = model.points().map((x, i) => (i % 3 === 2 ? x + 1 : x));
  writeFileSync(file("moved.glb"), model.write(moved));
  await assertValid("moved.glb");
  const [rest, now] = [await drawn("model.glb"), await drawn("moved.glb")];
  now.positions.forEach((position, i) =>
    assert.ok(Math.abs(position.z - rest.positions[i].z - 1) < 1e-6),
  );
});
