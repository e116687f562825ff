// SPDX-License-Identifier: Apache-2.0
// What a person does in the page, in Debian's Chromium, and what the program makes from the same files. A test
// file that imports this has a browser and an empty folder of its own.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";
import { openBrowser, openPage, settled } from "./browser.mjs";
import { program } from "../program.mjs";

let browser;
export let folder;
before(async () => {
  browser = await openBrowser();
  folder = mkdtempSync(join(tmpdir(), "espalier-page-"));
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

export const file = (name) => join(folder, name);
export const run = (...words) => execFileSync(program, [...words, "--quiet"], { cwd: folder });

/** Opens the page for one test. The page must have no errors at the end. */
export async function withPage(use, options) {
  const page = await openPage(browser, options);
  try {
    await use(page);
    assert.deepEqual(page.errors, []);
  } finally {
    await page.context().close();
  }
}

/** Clicks the button of a command that takes a file home, and returns the file. */
export async function download(page, command, name = undefined) {
  // Chromium holds back the eleventh download after the last input of a person.
  // (The key Shift alone is not always taken for an input.)
  await page.locator("header").click({ position: { x: 2, y: 2 } });
  const [item] = await Promise.all([
    page.waitForEvent("download"),
    page.evaluate((each) => document.querySelector(`[data-command="${each}"]`).click(), command),
  ]);
  const to = file(name ?? item.suggestedFilename());
  await item.saveAs(to);
  return to;
}

/** Opens files by the button of a command. */
export async function choose(page, command, ...files) {
  const [chooser] = await Promise.all([
    page.waitForEvent("filechooser"),
    page.evaluate((each) => document.querySelector(`[data-command="${each}"]`).click(), command),
  ]);
  await chooser.setFiles(files);
}

/** The document, with the sizes of the files in it. */
export const documentNow = (page) =>
  page.evaluate(() => {
    const { document } = globalThis.espalier.editor;
    const { models, lattice } = document;
    const size = (file) => file && { ...file, bytes: file.bytes.length };
    return { ...document, models: models.map(size), lattice: size(lattice) };
  });
export const message = (page) => page.textContent("#message span");

/** The commands of the program that the sheet shows. */
export async function commandsShown(page) {
  await page.evaluate(() => document.querySelector('[data-command="commands"]').click());
  const text = await page.textContent("#program pre");
  await page.evaluate(() => document.querySelector("#program").close());
  return text;
}

/** Runs a line of a shell with the program in the folder of the files. */
export const runLine = (line) =>
  execFileSync("bash", ["-ec", line], {
    cwd: folder,
    env: { ...process.env, PATH: `${join(program, "..")}:${process.env.PATH}` },
  });

/** Waits until something is so in the page, and is shown. */
export async function until(page, condition) {
  await page.waitForFunction(condition);
  await settled(page);
}

export async function openExample(page, name = "dog") {
  await page.selectOption('[data-choice="example"]', name);
  await until(page, () => globalThis.espalier.editor.models.length > 0);
  const text = await page.evaluate(() =>
    new TextDecoder().decode(globalThis.espalier.editor.document.models[0].bytes),
  );
  const model = `${name}.obj`;
  writeFileSync(file(model), text);
  return model;
}

export async function makeBox(page, cells = 4) {
  await page.fill('[data-form="around"] [name="cells"]', String(cells));
  await page.click('[data-form="around"] button');
  await until(page, () => globalThis.espalier.editor.binding !== null);
}

/** Makes a cage around the model. */
export async function makeCage(page) {
  await page.click('[data-form="cage"] button');
  await until(page, () => globalThis.espalier.editor.binding !== null);
}

/** Drops files together onto the page: a text or bytes for each name. */
export async function drop(page, files) {
  const contents = Object.entries(files).map(([name, content]) => [
    name,
    Buffer.from(content).toString("base64"),
  ]);
  await page.evaluate((all) => {
    const data = new DataTransfer();
    for (const [name, base64] of all)
      data.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: data }));
  }, contents);
}

/** Clicks a vertex where it is on the screen. */
export async function clickVertex(page, vertex, options = {}) {
  const at = await page.evaluate((v) => globalThis.espalier.editor.view.screenOf(v), vertex);
  await page.locator("#view canvas").click({ position: { x: at.x, y: at.y }, ...options });
  await settled(page);
}

/** Drags the handles of the selection by their middle. */
export async function dragHandles(page, dx, dy) {
  const from = await page.evaluate(() => {
    const { editor } = globalThis.espalier;
    const canvas = editor.view.canvas.getBoundingClientRect();
    const [vertex] = editor.document.selection;
    const { x, y } = editor.view.screenOf(vertex);
    return { x: canvas.x + x, y: canvas.y + y };
  });
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let step = 1; step <= 4; ++step)
    await page.mouse.move(from.x + (dx * step) / 4, from.y + (dy * step) / 4);
  await page.mouse.up();
  await handlesLetGo(page);
}

/** Waits until the document has what the handles did. */
export const handlesLetGo = (page) =>
  until(page, () => {
    const { controls, start } = globalThis.espalier.gizmo;
    return controls.enabled && start === null;
  });

/** Base64 passes to the test ten times as fast as numbers. */
export const shownPoints = async (page) => {
  const text = await page.evaluate(() => {
    const { points } = globalThis.espalier.editor.view;
    const bytes = new Uint8Array(points.buffer, points.byteOffset, points.byteLength);
    let characters = "";
    for (const byte of bytes) characters += String.fromCharCode(byte);
    return btoa(characters);
  });
  return new Float32Array(Uint8Array.from(Buffer.from(text, "base64")).buffer);
};

/** The coordinates of the points in an .obj. */
export const pointsOf = (path) =>
  readFileSync(path, "utf8")
    .split("\n")
    .filter((line) => line.startsWith("v "))
    .flatMap((line) => line.split(/\s+/).slice(1, 4).map(Number));

/** Compares two files byte for byte. */
export function assertSameFiles(actual, expected) {
  const [ours, theirs] = [actual, expected].map((path) => readFileSync(path));
  assert.equal(Buffer.compare(ours, theirs), 0, `${actual} and ${expected} differ`);
}

/** Compares what is shown and what is taken home with what the program makes. */
export async function compareWithProgram(page, model, ...options) {
  const rest = await download(page, "save rest");
  const pose = await download(page, "save pose", "pose.vtu");
  const extension = model.slice(model.lastIndexOf("."));
  const taken = await download(page, "save model", `taken${extension}`);
  const expected = file(`expected${extension}`);
  run("deform", model, "--rest", rest, "--to", pose, "-o", expected, ...options);
  assertSameFiles(taken, expected);

  const matrix = await download(page, "save matrix");
  const level = options.some((word) => /^--(level|limit)$/.test(word)) ? [] : ["--level", "3"];
  run("stencils", rest, "--points", model, "-o", file("expected.npz"), ...level, ...options);
  assertSameFiles(matrix, file("expected.npz"));

  if (extension !== ".obj") return;
  const shown = await shownPoints(page);
  // A coordinate that has not moved is written as the file had it, which may be -0.
  const withoutSign = (x) => x + 0;
  assert.deepEqual(shown.map(withoutSign), Float32Array.from(pointsOf(expected)).map(withoutSign));
}

/** The coordinates of the points in a .vtu that the program wrote, by the program. */
export function positionsOf(path) {
  const cage = `${path.slice(0, -4)}-cage.obj`;
  run("refine", path, "--level", "0", "-o", cage);
  return pointsOf(cage);
}

/** A tetrahedron, as two kinds of files. */
export const kCorners = [
  [0, 0, 0],
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
export const kFaces = [
  [0, 2, 1],
  [0, 1, 3],
  [1, 2, 3],
  [2, 0, 3],
];
export const plyText = () =>
  [
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z",
    "element face 4\nproperty list uchar int vertex_indices\nend_header",
    ...kCorners.map((p) => p.join(" ")),
    ...kFaces.map((f) => `3 ${f.join(" ")}`),
  ].join("\n") + "\n";
/** In glTF a node turns the tetrahedron, by a quaternion that no library may round in its own way. */
export function gltfText() {
  const data = Buffer.from(Float32Array.from(kCorners.flat()).buffer);
  const indices = Buffer.from(Uint16Array.from(kFaces.flat()).buffer);
  const bytes = Buffer.concat([data, indices]);
  return JSON.stringify({
    asset: { version: "2.0" },
    buffers: [
      {
        byteLength: bytes.length,
        uri: `data:application/octet-stream;base64,${bytes.toString("base64")}`,
      },
    ],
    bufferViews: [
      { buffer: 0, byteLength: data.length },
      { buffer: 0, byteOffset: data.length, byteLength: indices.length },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [0, 0, 0], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" },
    ],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    nodes: [{ mesh: 0, rotation: [0.1, 0.2, 0.3, 0.92736184954957] }],
    scenes: [{ nodes: [0] }],
    scene: 0,
  });
}
export const stlText = () =>
  "solid t\n" +
  kFaces
    .map(
      (f) =>
        `facet normal 0 0 0\nouter loop\n${f.map((v) => `vertex ${kCorners[v].join(" ")}\n`).join("")}endloop\nendfacet\n`,
    )
    .join("") +
  "endsolid t\n";
