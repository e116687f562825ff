// SPDX-License-Identifier: Apache-2.0
// Uses the page as a person does, in Debian's Chromium, and compares what it makes with what the program
// makes from the same files.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { openBrowser, openPage, pageFile, settled } from "./browser.mjs";
import { program, root } from "../program.mjs";

let browser;
let folder;
before(async () => {
  browser = await openBrowser();
  folder = mkdtempSync(join(tmpdir(), "espalier-page-"));
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

const file = (name) => join(folder, name);
const run = (...words) => execFileSync(program, [...words, "--quiet"], { cwd: folder });

/** Opens the page for one test. The page must have no errors at the end. */
async function withPage(use, options) {
  const page = await openPage(browser, options);
  try {
    await use(page);
    assert.deepEqual(page.errors, []);
  } finally {
    await page.context().close();
  }
}

/** Clicks the button of a command that takes a file home, and returns the file. */
async function download(page, command, name = undefined) {
  const [item] = await Promise.all([
    page.waitForEvent("download"),
    page.evaluate((each) => document.querySelector(`[data-command="${each}"]`).click(), command),
  ]);
  const to = file(name ?? item.suggestedFilename());
  await item.saveAs(to);
  return to;
}

/** Opens files by the button of a command. */
async function choose(page, command, ...files) {
  const [chooser] = await Promise.all([
    page.waitForEvent("filechooser"),
    page.evaluate((each) => document.querySelector(`[data-command="${each}"]`).click(), command),
  ]);
  await chooser.setFiles(files);
}

/** The document, with the sizes of the files in it. */
const documentNow = (page) =>
  page.evaluate(() => {
    const { document } = globalThis.espalier.editor;
    const { model, lattice } = document;
    const size = (file) => file && { ...file, bytes: file.bytes.length };
    return { ...document, model: size(model), lattice: size(lattice) };
  });
const message = (page) => page.textContent("#message span");

/** The commands of the program that the sheet shows. */
async function commandsShown(page) {
  await page.evaluate(() => document.querySelector('[data-command="commands"]').click());
  const text = await page.textContent("#program pre");
  await page.evaluate(() => document.querySelector("#program").close());
  return text;
}

/** Runs a line of a shell with the program in the folder of the files. */
const runLine = (line) =>
  execFileSync("bash", ["-ec", line], {
    cwd: folder,
    env: { ...process.env, PATH: `${join(program, "..")}:${process.env.PATH}` },
  });

/** Waits until something is so in the page, and is shown. */
async function until(page, condition) {
  await page.waitForFunction(condition, null, { timeout: 20_000 });
  await settled(page);
}

async function openExample(page, name = "dog") {
  await page.selectOption('[data-choice="example"]', name);
  await until(page, () => globalThis.espalier.editor.model !== null);
  const text = await page.evaluate(() =>
    new TextDecoder().decode(globalThis.espalier.editor.document.model.bytes),
  );
  const model = `${name}.obj`;
  writeFileSync(file(model), text);
  return model;
}

async function makeBox(page, cells = 4) {
  await page.fill('[data-form="around"] [name="cells"]', String(cells));
  await page.click('[data-form="around"] button');
  await until(page, () => globalThis.espalier.editor.binding !== null);
}

/** Clicks a vertex where it is on the screen. */
async function clickVertex(page, vertex, options = {}) {
  const at = await page.evaluate((v) => globalThis.espalier.editor.view.screenOf(v), vertex);
  await page.locator("#view canvas").click({ position: { x: at.x, y: at.y }, ...options });
  await settled(page);
}

/** Drags the handles of the selection by their middle. */
async function dragHandles(page, dx, dy) {
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
  await settled(page);
}

/** Base64 passes to the test ten times as fast as numbers. */
const shownPoints = async (page) => {
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
const pointsOf = (path) =>
  readFileSync(path, "utf8")
    .split("\n")
    .filter((line) => line.startsWith("v "))
    .flatMap((line) => line.split(/\s+/).slice(1, 4).map(Number));

/** Compares two files byte for byte. */
function assertSameFiles(actual, expected) {
  const [ours, theirs] = [actual, expected].map((path) => readFileSync(path));
  assert.equal(Buffer.compare(ours, theirs), 0, `${actual} and ${expected} differ`);
}

/** Compares what is shown and what is taken home with what the program makes. */
async function compareWithProgram(page, model, ...options) {
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
function positionsOf(path) {
  const cage = `${path.slice(0, -4)}-cage.obj`;
  run("refine", path, "--level", "0", "-o", cage);
  return pointsOf(cage);
}

describe("against the program", () => {
  test("a vertex that is dragged moves every point as in the program, to the last bit", () =>
    withPage(async (page) => {
      const model = await openExample(page);
      await makeBox(page);
      run("shape", "around", model, "-o", file("program-rest.vtu"));
      const rest = await download(page, "save rest");
      assert.ok(readFileSync(rest).equals(readFileSync(file("program-rest.vtu"))));

      const atRest = await shownPoints(page);
      assert.deepEqual(atRest, Float32Array.from(pointsOf(file(model))));
      await clickVertex(page, 59);
      assert.deepEqual((await documentNow(page)).selection, [59]);
      await dragHandles(page, 70, -60);
      const { poses, lattice } = await documentNow(page);
      assert.notDeepEqual(poses[0].positions, lattice.positions);
      assert.notDeepEqual(await shownPoints(page), atRest);
      await compareWithProgram(page, model);
    }));

  const spot = join(root, "../shared/data/models/spot.obj");
  test("Spot in a cage", { skip: existsSync(spot) ? false : `${spot} is missing` }, () =>
    withPage(async (page) => {
      writeFileSync(file("spot.obj"), readFileSync(spot));
      await choose(page, "open", file("spot.obj"));
      await until(page, () => globalThis.espalier.editor.model !== null);
      await page.click('[data-form="cage"] button');
      await until(page, () => globalThis.espalier.editor.binding !== null);
      run("shape", "cage", "spot.obj", "--vertices", "150", "-o", file("cage.vtu"));
      assertSameFiles(await download(page, "save rest"), file("cage.vtu"));
      const { poses } = await documentNow(page);
      const { length } = Object.keys(poses[0].positions);
      assert.ok(length / 3 > 0.8 * 150 && length / 3 < 1.2 * 150, `${length / 3} vertices`);
      // A vertex that nothing hides: the nearest to the eye
      const vertex = await page.evaluate(() => {
        const { view, shape } = globalThis.espalier.editor;
        const depth = (v) => view.screenOf(v).depth;
        return [...shape.vertexStrata.keys()].reduce(
          (best, v) => (depth(v) < depth(best) ? v : best),
          0,
        );
      });
      await clickVertex(page, vertex);
      await dragHandles(page, 40, -30);
      await compareWithProgram(page, "spot.obj");
    }),
  );

  test("levels, the limit, and points outside are as in the program", () =>
    withPage(async (page) => {
      // A lattice around the front alone leaves points outside.
      const model = await openExample(page, "knot");
      run(
        "shape",
        "box",
        "--cells",
        "2",
        "2",
        "2",
        "--min",
        "-0.5",
        "-1",
        "-1",
        "--max",
        "2",
        "1",
        "1",
        "-o",
        file("part.vtu"),
      );
      await choose(page, "open lattice", file("part.vtu"));
      await until(page, () => globalThis.espalier.editor.binding !== null);
      const outside = await page.textContent('[data-show="outside"]');
      assert.match(outside, /^[\d,]+ points outside the lattice: they stay where they are$/);
      await clickVertex(page, 26);
      await dragHandles(page, 60, -40);
      await compareWithProgram(page, model);
      await page.selectOption('[data-setting="outside"]', "nearest");
      await page.selectOption('[data-setting="level"]', "2");
      await settled(page);
      await compareWithProgram(page, model, "--outside", "nearest", "--level", "2");
      await page.selectOption('[data-setting="level"]', "limit");
      await settled(page);
      await compareWithProgram(page, model, "--outside", "nearest", "--limit");
    }));

  test("normals follow the limit as in the program", () =>
    withPage(async (page) => {
      const normals = ["0 0 -1", "0 -1 0", "1 1 1", "-1 0 0"];
      writeFileSync(
        file("normals.obj"),
        [
          ...kCorners.map((p) => `v ${p.join(" ")}`),
          ...normals.map((n) => `vn ${n}`),
          ...kFaces.map((f) => `f ${f.map((v) => `${v + 1}//${v + 1}`).join(" ")}`),
        ].join("\n") + "\n",
      );
      await choose(page, "open", file("normals.obj"));
      await until(page, () => globalThis.espalier.editor.model !== null);
      await makeBox(page, 2);
      await page.selectOption('[data-setting="level"]', "limit");
      await settled(page);
      await page.click('[data-command="all"]');
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "twist", axis: "z", degrees: 40 }),
      );
      const [rest, pose] = [
        await download(page, "save rest"),
        await download(page, "save pose", "pose.vtu"),
      ];
      const taken = await download(page, "save model", "taken.obj");
      const options = ["--rest", rest, "--limit"];
      run("deform", "normals.obj", ...options, "--to", pose, "-o", file("expected.obj"));
      assertSameFiles(taken, file("expected.obj"));
      assert.ok(!readFileSync(taken, "utf8").includes("vn 0 -1 0"));
      const matrix = await download(page, "save matrix");
      assert.match(await commandsShown(page), /--gradients -o D\.npz/);
      run("stencils", rest, "--points", "normals.obj", "--limit", "--gradients", "-o", file("expected.npz"));
      assertSameFiles(matrix, file("expected.npz"));
    }));

  test("other formats are written as the program writes them", () =>
    withPage(async (page) => {
      for (const name of ["model.ply", "model.stl"]) {
        writeFileSync(file(name), name.endsWith("ply") ? plyText() : stlText());
        await choose(page, "open", file(name));
        await page.waitForFunction(
          (expected) => globalThis.espalier.editor.document.model?.name === expected,
          name,
        );
        await makeBox(page, 2);
        await page.click('[data-command="all"]');
        await page.selectOption('[data-form="turn"] [name="kind"]', "twist");
        await page.click('[data-form="turn"] button');
        await settled(page);
        await compareWithProgram(page, name);
      }
    }));

  test("the operations with numbers are those of espalier pose", () =>
    withPage(async (page) => {
      const model = await openExample(page, "column");
      await makeBox(page);
      await page.click('[data-command="all"]');
      const submit = async (form, values) => {
        for (const [name, value] of Object.entries(values)) {
          const control = page.locator(`[data-form="${form}"] [name="${name}"]`);
          if (await control.evaluate((each) => each.matches("select")))
            await control.selectOption(value);
          else await control.fill(value);
        }
        await page.click(`[data-form="${form}"] button`);
        await settled(page);
      };
      await submit("turn", { kind: "twist", axis: "y", amount: "80" });
      await submit("turn", { kind: "bend", axis: "y", amount: "-40" });
      await submit("turn", { kind: "taper", axis: "y", amount: "0.6" });
      await submit("turn", { kind: "rotate", axis: "z", amount: "15" });
      await submit("scale", { x: "1.1", y: "0.9", z: "1" });
      await page.click('[data-command="none"]');
      await clickVertex(page, 0);
      await page.evaluate(() => {
        const slider = document.querySelector('[data-choice="radius"]');
        slider.value = "0.5";
        slider.dispatchEvent(new Event("input"));
      });
      await submit("move", { x: "0.2", y: "-0.1", z: "0.3" });
      await compareWithProgram(page, model);

      // The commands on the sheet make the same pose. Sine and cosine differ in the last bits.
      const taken = pointsOf(file("taken.obj"));
      runLine(await commandsShown(page));
      const made = pointsOf(file("column-deformed.obj"));
      assert.equal(made.length, taken.length);
      made.forEach((x, i) => assert.ok(Math.abs(x - taken[i]) < 1e-12, `${x} ${taken[i]}`));
      assert.ok(existsSync(file("D.npz")));
    }));

  test("grown and marked lattices deform as in the program", () =>
    withPage(async (page) => {
      const model = await openExample(page);
      await makeBox(page, 3);
      const cellCount = () => page.evaluate(() => globalThis.espalier.editor.shape.cells.length);
      const before = await cellCount();
      const pick = (axis, place) =>
        page.evaluate(
          ([axis, place]) => {
            const { editor } = globalThis.espalier;
            const { positions } = editor.shape;
            const all = [...positions].filter((_, i) => i % 3 === axis);
            const end = place === "max" ? Math.max(...all) : Math.min(...all);
            return editor.select([...all.keys()].filter((v) => Math.abs(all[v] - end) < 1e-9));
          },
          [axis, place],
        );
      const press = async (command) => {
        await page.evaluate(
          (each) => document.querySelector(`[data-command="${each}"]`).click(),
          command,
        );
        await page.waitForTimeout(50);
        await settled(page);
      };
      await pick(0, "max");
      const faces = await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        const selected = new Set(editor.document.selection);
        return editor.shape.boundary.filter((f) => f.vertices.every((v) => selected.has(v))).length;
      });
      await page.evaluate(() => document.querySelector('[data-form="extrude"]').requestSubmit());
      await page.waitForFunction(
        (n) => globalThis.espalier.editor.shape.cells.length === n,
        before + faces,
      );
      await settled(page);

      await pick(1, "max");
      await press("sharp");
      await press("none");
      await press("pick cells");
      // The first cell, by its vertices
      await page.evaluate(() =>
        globalThis.espalier.editor.select([...globalThis.espalier.editor.shape.cells[0]]),
      );
      await press("remove cells");
      assert.equal(await cellCount(), before + faces - 1);
      await press("pick vertices");
      await clickVertex(page, 12);
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [0.1, 0.2, 0.3] }),
      );
      const { marks } = await page.evaluate(() => globalThis.espalier.editor.shape);
      assert.ok(Object.keys(marks.edgeSharpness).length > 0);
      await compareWithProgram(page, model);
    }));
});

/** A tetrahedron, as two kinds of files. */
const kCorners = [
  [0, 0, 0],
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const kFaces = [
  [0, 2, 1],
  [0, 1, 3],
  [1, 2, 3],
  [2, 0, 3],
];
const plyText = () =>
  [
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z",
    "element face 4\nproperty list uchar int vertex_indices\nend_header",
    ...kCorners.map((p) => p.join(" ")),
    ...kFaces.map((f) => `3 ${f.join(" ")}`),
  ].join("\n") + "\n";
const stlText = () =>
  "solid t\n" +
  kFaces
    .map(
      (f) =>
        `facet normal 0 0 0\nouter loop\n${f.map((v) => `vertex ${kCorners[v].join(" ")}\n`).join("")}endloop\nendfacet\n`,
    )
    .join("") +
  "endsolid t\n";

describe("what the program makes too", () => {
  test("every ready shape, with sizes that a person chooses", () =>
    withPage(async (page) => {
      const names = await page.$$eval('[data-form="shape"] [name="kind"] option', (options) =>
        options.map((each) => each.value),
      );
      assert.equal(names.length, 14);
      for (const name of names) {
        await page.selectOption('[data-form="shape"] [name="kind"]', name);
        // Other sizes than the standard ones: one more of all counts, and the last word
        await page.evaluate(() => {
          for (const control of document.querySelectorAll("#sizes input"))
            control.value =
              control.step === "any" ? Number(control.value) * 1.25 : Number(control.value) + 1;
          for (const control of document.querySelectorAll("#sizes select"))
            control.selectedIndex = control.options.length - 1;
        });
        const before = await page.evaluate(() => globalThis.espalier.editor.document.lattice);
        await page.click('[data-form="shape"] button');
        await page.waitForFunction(
          (last) => {
            const { lattice } = globalThis.espalier.editor.document;
            return lattice && lattice.command !== last;
          },
          before?.command,
        );
        await settled(page);
        const { lattice } = await documentNow(page);
        assert.match(lattice.command, new RegExp(`^espalier shape ${name} `));
        const rest = await download(page, "save rest", `${name}.vtu`);
        runLine(lattice.command);
        // Circles: the sines of the two standard libraries differ in the last bits.
        const expected = positionsOf(file("rest.vtu"));
        const made = positionsOf(rest);
        assert.equal(made.length, expected.length, name);
        made.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) < 1e-14, `${name} ${i}`));
      }
    }));

  test("rules of refinement", () =>
    withPage(async (page) => {
      const model = await openExample(page, "knot");
      // Five cells meet at the axis: in a regular lattice, all rules for the inside agree.
      await page.selectOption('[data-form="shape"] [name="kind"]', "cylinder");
      for (const [name, value] of Object.entries({ sectors: 5, rings: 3, radius: 2.5, layers: 4 }))
        await page.fill(`#sizes [name="${name}"]`, String(value));
      await page.click('[data-form="shape"] button');
      await until(page, () => globalThis.espalier.editor.binding !== null);
      await page.click('[data-command="all"]');
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "twist", axis: "x", degrees: 50 }),
      );
      const choose = async (rule, value) => {
        await page.selectOption(`[data-rule="${rule}"]`, value);
        await settled(page);
      };
      const shownBefore = await shownPoints(page);
      await page.click('summary:text("Rules")');
      await choose("rules", "cse96");
      await choose("boundary", "edge-only");
      await choose("sharpEdges", "literal");
      assert.notDeepEqual(await shownPoints(page), shownBefore);
      const options = ["--rules", "cse96", "--boundary", "edge-only", "--sharp-edges", "literal"];
      await compareWithProgram(page, model, ...options);
      await choose("boundary", "open");
      options[3] = "open";
      await compareWithProgram(page, model, ...options);
      const commands = await commandsShown(page);
      assert.ok(commands.includes("--rules cse96 --boundary open --sharp-edges literal"), commands);
      for (let step = 0; step < 4; ++step) await page.evaluate(() => globalThis.espalier.editor.undo());
      assert.deepEqual(await shownPoints(page), shownBefore);
    }));

  test("a lattice that is joined with another", () =>
    withPage(async (page) => {
      const box = ["shape", "box", "--cells", "2", "2", "2"];
      run(...box, "-o", file("first.vtu"));
      run(...box, "--min", "1", "0", "0", "--max", "2", "1", "1", "-o", file("second.vtu"));
      const lattices = [file("first.vtu"), file("second.vtu")];
      run("shape", "merge", ...lattices, "--tolerance", "1e-3", "-o", file("both.vtu"));
      await choose(page, "open lattice", lattices[0]);
      await until(page, () => globalThis.espalier.editor.shape !== null);
      await choose(page, "join lattice", lattices[1]);
      await until(page, () => globalThis.espalier.editor.shape.cells.length === 16);
      const rest = await download(page, "save rest", "joined.vtu");
      assertSameFiles(rest, file("both.vtu"));
      // A broken file changes nothing.
      writeFileSync(file("broken.vtu"), "no lattice");
      await choose(page, "join lattice", file("broken.vtu"));
      await page.waitForFunction(() => !document.querySelector("#message").hidden);
      assert.match(await message(page), /broken/);
      assert.equal((await documentNow(page)).poses[0].steps.length, 0);
      assert.equal(await page.evaluate(() => globalThis.espalier.editor.shape.cells.length), 16);
    }));

  test("turns and scales by the handles", () =>
    withPage(async (page) => {
      await openExample(page, "column");
      await makeBox(page, 3);
      const turnHandles = (mode, change) =>
        page.evaluate(
          async ([mode, change]) => {
            const { editor, gizmo } = globalThis.espalier;
            document.querySelector(`[data-command="${mode}"]`).click();
            gizmo.controls.dragging = true;
            if (mode === "rotate") gizmo.handle.rotation.set(...change);
            else gizmo.handle.scale.set(...change);
            gizmo.controls.dispatchEvent({ type: "objectChange" });
            await editor.engine.run("memory");
            gizmo.controls.dragging = false;
            await editor.engine.run("memory");
            await editor.update();
          },
          [mode, change],
        );
      await page.evaluate(() => globalThis.espalier.editor.select([0, 1, 3, 5, 7]));
      const [before] = (await documentNow(page)).poses;
      await turnHandles("rotate", [0.3, -0.5, 0.7]);
      await turnHandles("scale", [1.5, 0.8, 1]);
      const [{ positions, steps }] = (await documentNow(page)).poses;
      assert.equal(steps.length, 2);
      assert.match(
        steps[0],
        /^--select vertices 0 1 3 5 7 --center \S+ \S+ \S+ (--center .*)?--rotate x .* --rotate y .* --rotate z /,
      );
      assert.notDeepEqual(Object.values(positions), Object.values(before.positions));
      // The handles turn about fixed axes, as a matrix does.
      const expected = await page.evaluate(
        ([rest, change, selection]) => {
          const { gizmo } = globalThis.espalier;
          const object = gizmo.handle.clone();
          object.rotation.set(...change);
          object.position.set(0, 0, 0);
          object.scale.set(1, 1, 1);
          const at = (v) => rest.slice(3 * v, 3 * v + 3);
          const middle = [0, 1, 2].map((c) => {
            const all = selection.map((v) => at(v)[c]);
            return (Math.min(...all) + Math.max(...all)) / 2;
          });
          return selection.map((v) => {
            const point = object.position.clone().fromArray(at(v).map((x, c) => x - middle[c]));
            return point.applyEuler(object.rotation).toArray().map((x, c) => x + middle[c]);
          });
        },
        [Object.values(before.positions), [0.3, -0.5, 0.7], [0, 1, 3, 5, 7]],
      );
      await page.evaluate(() => globalThis.espalier.editor.undo());
      const turned = Object.values((await documentNow(page)).poses[0].positions);
      [0, 1, 3, 5, 7].forEach((v, i) =>
        expected[i].forEach((x, c) => assert.ok(Math.abs(x - turned[3 * v + c]) < 1e-12)),
      );
      await page.evaluate(() => globalThis.espalier.editor.redo());
      // The commands make the same pose.
      const taken = await download(page, "save pose", "taken-pose.vtu");
      for (const line of (await commandsShown(page)).replaceAll("\\\n", " ").split("\n"))
        if (/^espalier (shape|pose)/.test(line)) runLine(line);
      const [ours, theirs] = [taken, file("pose-1.vtu")].map(positionsOf);
      assert.equal(ours.length, theirs.length);
      ours.forEach((x, i) => assert.ok(Math.abs(x - theirs[i]) < 1e-12, `${x} ${theirs[i]}`));
    }));
});

describe("the page", () => {
  test("undo goes back to the start, and redo to the end", () =>
    withPage(async (page) => {
      const start = await documentNow(page);
      await openExample(page);
      await makeBox(page);
      await clickVertex(page, 59);
      await dragHandles(page, 50, -30);
      await page.keyboard.press("a");
      await page.keyboard.press("Shift+ArrowUp");
      await page.click('[data-command="add pose"]');
      await settled(page);
      const end = await documentNow(page);
      const shown = await shownPoints(page);
      while (await page.isEnabled('[data-command="undo"]')) {
        await page.keyboard.press("Control+z");
        await settled(page);
      }
      assert.deepEqual(await documentNow(page), start);
      assert.equal((await shownPoints(page)).length, 0);
      while (await page.isEnabled('[data-command="redo"]')) {
        await page.keyboard.press("Control+y");
        await settled(page);
      }
      assert.deepEqual(await documentNow(page), end);
      assert.deepEqual(await shownPoints(page), shown);
    }));

  test("a file that cannot be read gives the message of the library and changes nothing", () =>
    withPage(async (page) => {
      await openExample(page);
      const start = await documentNow(page);
      const bad = [
        ["empty.obj", ""],
        ["broken.obj", "v 0 0 0\nv 1 zero 0\n"],
        ["torn.ply", plyText().slice(0, -20)],
        ["what.xyzzy", "hello"],
      ];
      for (const [name, text] of bad) {
        writeFileSync(file(name), text);
        await page.evaluate(() => document.querySelector("#message button").click());
        await choose(page, "open", file(name));
        await page.waitForSelector("#message:not([hidden])");
        const said = await message(page);
        let expected = "";
        try {
          execFileSync(program, ["info", name], {
            cwd: folder,
            stdio: ["ignore", "ignore", "pipe"],
          });
        } catch (error) {
          expected = String(error.stderr);
        }
        if (name !== "what.xyzzy")
          assert.ok(expected.includes(said), `${said} is not in ${expected}`);
        assert.ok(said.includes(name), said);
        assert.deepEqual(await documentNow(page), start);
      }
      await page.evaluate(() => document.querySelector("#message button").click());
      writeFileSync(file("torn.vtu"), '<VTKFile type="UnstructuredGrid">');
      await choose(page, "open lattice", file("torn.vtu"));
      await page.waitForSelector("#message:not([hidden])");
      assert.match(await message(page), /torn\.vtu/);
      assert.deepEqual(await documentNow(page), start);
    }));

  test("everything works by keys alone", () =>
    withPage(async (page) => {
      await page.keyboard.press("e");
      await until(page, () => globalThis.espalier.editor.model !== null);
      // Tab reaches the fields and buttons of the panels.
      const reach = async (selector) => {
        for (let i = 0; i < 80; ++i) {
          if (await page.evaluate((each) => document.activeElement?.matches(each), selector))
            return;
          await page.keyboard.press("Tab");
        }
        assert.fail(`Tab does not reach ${selector}`);
      };
      await reach('[data-form="around"] [name="cells"]');
      await page.keyboard.type("3");
      await page.keyboard.press("Enter");
      await until(page, () => globalThis.espalier.editor.binding !== null);
      await reach("#view");
      await page.keyboard.press("n");
      await settled(page);
      const [first] = (await documentNow(page)).selection;
      assert.equal(first, 0);
      for (const key of ["ArrowUp", "ArrowRight", "ArrowLeft", "ArrowDown"]) {
        await page.keyboard.press(key);
        await settled(page);
      }
      const { selection } = await documentNow(page);
      assert.equal(selection.length, 1);
      const before = await shownPoints(page);
      for (let i = 0; i < 5; ++i) await page.keyboard.press("Shift+ArrowUp");
      await settled(page);
      assert.notDeepEqual(await shownPoints(page), before);
      await page.keyboard.press("?");
      await page.waitForSelector("#help[open]");
      await page.keyboard.press("Escape");
      await page.keyboard.press("Control+Enter");
      await settled(page);
      assert.equal((await documentNow(page)).poses.length, 2);
      const [item] = await Promise.all([
        page.waitForEvent("download"),
        page.keyboard.press("Control+s"),
      ]);
      assert.equal(item.suggestedFilename(), "dog-deformed.obj");
    }));

  test("vertices are selected by box, rows, planes, faces and cells", () =>
    withPage(async (page) => {
      await page.click('[data-form="shape"] button');
      await until(page, () => globalThis.espalier.editor.shape !== null);
      const selected = async () => (await documentNow(page)).selection;
      const box = await page.locator("#view canvas").boundingBox();
      await page.keyboard.down("Shift");
      await page.mouse.move(box.x + 5, box.y + 5);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width - 5, box.y + box.height - 5, { steps: 3 });
      await page.mouse.up();
      await page.keyboard.up("Shift");
      await settled(page);
      assert.equal((await selected()).length, 64);
      await page.keyboard.press("Escape");
      await page.evaluate(() => globalThis.espalier.editor.select([0, 1]));
      await page.keyboard.press("w");
      await settled(page);
      assert.deepEqual(await selected(), [0, 1, 2, 3]);
      // A row inside: vertex (i, j, k) is i + 4 (j + 4 k).
      await page.evaluate(() => globalThis.espalier.editor.select([21, 25]));
      await page.keyboard.press("w");
      await settled(page);
      assert.deepEqual(await selected(), [17, 21, 25, 29]);
      await page.evaluate(() => globalThis.espalier.editor.select([0]));
      await page.keyboard.press("Shift+X");
      await settled(page);
      assert.deepEqual(
        await selected(),
        Array.from({ length: 16 }, (_, i) => 4 * i),
      );
      await page.keyboard.press("2");
      const middle = { position: { x: box.width / 2, y: box.height / 2 } };
      await page.locator("#view canvas").click(middle);
      await settled(page);
      assert.equal((await selected()).length, 4);
      await page.keyboard.press("3");
      await page.locator("#view canvas").click(middle);
      await settled(page);
      assert.equal((await selected()).length, 8);
      await page.keyboard.press("i");
      await settled(page);
      assert.equal((await selected()).length, 56);
    }));

  test("folded cells are shown, and a mirrored pose is symmetric", () =>
    withPage(async (page) => {
      await page.click('[data-form="shape"] button');
      await until(page, () => globalThis.espalier.editor.shape !== null);
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.select([0]);
        await editor.transform({ kind: "move", offset: [-0.2, -0.1, 0.1] });
      });
      assert.equal(await page.textContent("#status"), "");
      await page.evaluate(() => document.querySelector('[data-command="mirror x"]').click());
      await settled(page);
      const { poses } = await documentNow(page);
      const at = (v) => [0, 1, 2].map((c) => poses[0].positions[3 * v + c]);
      assert.deepEqual(at(0), [-1.2, -1.1, -0.9]);
      assert.deepEqual(at(3), [1.2, -1.1, -0.9]);
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [3, 0, 0] }),
      );
      await settled(page);
      assert.match(await page.textContent("#status"), /cells? folded/);
      await page.keyboard.press("Control+z");
      await settled(page);
      assert.equal(await page.textContent("#status"), "");
    }));

  test("a point of the model that is pulled goes where it is pulled", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page);
      const by = [0.1, 0.15, -0.05];
      const point = 4000;
      const before = await shownPoints(page);
      await page.evaluate(
        async ([point, by]) => {
          const { editor } = globalThis.espalier;
          const moved = await editor.engine.run("pull", [{ point, by }]);
          await editor.setPositions(
            editor.positions.map((x, i) => x + moved[i]),
            null,
          );
        },
        [point, by],
      );
      const shown = await shownPoints(page);
      // Tikhonov's term of 1e-3 keeps the point a little behind, as with espalier fit --pull.
      for (let c = 0; c < 3; ++c) {
        const gap = shown[3 * point + c] - before[3 * point + c] - by[c];
        assert.ok(Math.abs(gap) < 0.02 * Math.hypot(...by), String(gap));
      }

      // By hand: a click chooses the point, and its handles pull it.
      await page.keyboard.press("p");
      const canvas = page.locator("#view canvas");
      const { x, y, width, height } = await canvas.boundingBox();
      await canvas.click({ position: { x: width / 2, y: height / 2 } });
      const pulled = await page.evaluate(() => globalThis.espalier.gizmo.pulled);
      const from = await page.evaluate(() => {
        const { gizmo, editor } = globalThis.espalier;
        const { points, camera } = editor.view;
        const place = camera.position
          .clone()
          .fromArray(points, 3 * gizmo.pulled)
          .project(camera);
        return [place.x, place.y];
      });
      const start = { x: x + ((from[0] + 1) / 2) * width, y: y + ((1 - from[1]) / 2) * height };
      const old = await shownPoints(page);
      await page.mouse.move(start.x, start.y);
      await page.mouse.down();
      await page.mouse.move(start.x + 40, start.y - 40, { steps: 4 });
      await page.mouse.up();
      await page.waitForTimeout(300);
      await settled(page);
      const now = await shownPoints(page);
      const moved = Math.hypot(...[0, 1, 2].map((c) => now[3 * pulled + c] - old[3 * pulled + c]));
      assert.ok(moved > 0.05, `the point moved by ${moved}`);
      await compareWithProgram(page, "dog.obj");
    }));

  test("poses are interpolated, and the document is there after the page was closed", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page);
      await page.keyboard.press("a");
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [2, 0, 0] }),
      );
      await page.evaluate(() => {
        const time = document.querySelector("#time");
        time.value = "0.5";
        time.dispatchEvent(new Event("input"));
      });
      await settled(page);
      const { lattice, poses } = await documentNow(page);
      const half = await page.evaluate(() => globalThis.espalier.editor.positions[0]);
      assert.equal(
        half,
        lattice.positions[0] + 0.5 * (poses[0].positions[0] - lattice.positions[0]),
      );
      const points = await shownPoints(page);
      await page.waitForTimeout(700);
      await page.reload();
      await page.waitForSelector("html[data-ready]");
      await settled(page);
      assert.deepEqual((await documentNow(page)).poses, poses);
      assert.deepEqual(await shownPoints(page), points);
    }));

  test("files are dropped, and vertices are tapped", () =>
    withPage(
      async (page) => {
        run(
          "shape",
          "box",
          "--cells",
          "2",
          "2",
          "2",
          "--min",
          "0",
          "0",
          "0",
          "--max",
          "1",
          "1",
          "1",
          "-o",
          file("dropped.vtu"),
        );
        const files = [
          { name: "dropped.ply", text: plyText() },
          { name: "dropped.vtu", text: readFileSync(file("dropped.vtu"), "latin1") },
        ];
        await page.evaluate((files) => {
          const data = new DataTransfer();
          for (const { name, text } of files)
            data.items.add(new File([Uint8Array.from(text, (c) => c.charCodeAt(0))], name));
          document.dispatchEvent(new DragEvent("drop", { dataTransfer: data }));
        }, files);
        await until(page, () => globalThis.espalier.editor.binding !== null);
        const at = await page.evaluate(() => globalThis.espalier.editor.view.screenOf(26));
        await page.locator("#view canvas").tap({ position: { x: at.x + 15, y: at.y } });
        await settled(page);
        assert.deepEqual((await documentNow(page)).selection, [26]);
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 400);
      },
      { viewport: { width: 400, height: 780 }, hasTouch: true, isMobile: true },
    ));

  test("a page of espalier page opens the files in it", async () => {
    run(
      "shape",
      "box",
      "--cells",
      "2",
      "2",
      "2",
      "--min",
      "-1",
      "-1",
      "-1",
      "--max",
      "2",
      "2",
      "2",
      "-o",
      file("inside-rest.vtu"),
    );
    run("pose", "inside-rest.vtu", "--twist", "y", "40", "-o", file("wave.vtu"));
    writeFileSync(file("inside.ply"), plyText());
    const inside = ["inside.ply", "--rest", "inside-rest.vtu", "--to", "wave.vtu", "--level", "2"];
    run("page", ...inside, "--page", pageFile, "-o", file("filled.html"));
    await withPage(
      async (page) => {
        await until(page, () => globalThis.espalier.editor.document.poses[0]?.name === "wave");
        const { poses, settings, time } = await documentNow(page);
        assert.deepEqual([poses.length, poses[0].name, settings.level, time], [1, "wave", 2, 1]);
        await compareWithProgram(page, "inside.ply", "--level", "2");
      },
      { file: file("filled.html") },
    );
  });

  test("long work can be cancelled", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page);
      const start = await documentNow(page);
      // Level 12 takes seconds.
      await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        void editor.change({ settings: { ...editor.document.settings, level: 14 } });
      });
      await page.waitForSelector("#busy:not([hidden])");
      await page.click('[data-command="cancel"]');
      await settled(page);
      assert.deepEqual(await documentNow(page), start);
      await clickVertex(page, 59);
      await dragHandles(page, 30, 20);
      await compareWithProgram(page, "dog.obj");
    }));

  test("opening and closing 50 models needs no more memory than a few", () =>
    withPage(async (page) => {
      const sizes = await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        // Points on a screw: 2,000 of them need some megabytes with their rows of D.
        const lines = Array.from(
          { length: 2000 },
          (_, i) => `v ${Math.cos(i)} ${i / 1000} ${Math.sin(i)}`,
        );
        const bytes = new TextEncoder().encode(lines.join("\n"));
        const sizes = [];
        for (let i = 0; i < 50; ++i) {
          await editor.openModel({ name: `${i}.obj`, bytes: bytes.slice() });
          await editor.makeLattice({ kind: "around", options: { cellsAlongLongest: 3 } }, "");
          await editor.change({ model: null, lattice: null, poses: [], time: 0, selection: [] });
          sizes.push(await editor.engine.run("memory"));
        }
        return sizes;
      });
      assert.equal(sizes[49], sizes[4], sizes.join(" "));
    }));
});
