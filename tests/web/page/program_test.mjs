// SPDX-License-Identifier: Apache-2.0
// Compares what the page makes with what the program makes, to the last bit.
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { describe, test } from "node:test";
import { settled } from "./browser.mjs";
import {
  assertSameFiles,
  choose,
  clickVertex,
  commandsShown,
  compareWithProgram,
  documentNow,
  download,
  dragHandles,
  file,
  gltfText,
  kCorners,
  kFaces,
  makeBox,
  makeCage,
  openExample,
  plyText,
  pointsOf,
  run,
  runLine,
  shownPoints,
  stlText,
  until,
  withPage,
} from "./person.mjs";
import { root } from "../program.mjs";

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
      await until(page, () => globalThis.espalier.editor.models.length > 0);
      await makeCage(page);
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
      await until(page, () => globalThis.espalier.editor.models.length > 0);
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
      // Normals that stay.
      await page.selectOption('[data-setting="normals"]', "keep");
      await settled(page);
      const kept = await download(page, "save model", "kept.obj");
      assert.match(await commandsShown(page), /espalier deform .*--keep-normals/);
      run("deform", "normals.obj", ...options, "--keep-normals", "--to", pose, "-o", file("kept-expected.obj"));
      assertSameFiles(kept, file("kept-expected.obj"));
      assert.ok(readFileSync(kept, "utf8").includes("vn 0 -1 0"));
    }));

  test("other formats are written as the program writes them", () =>
    withPage(async (page) => {
      const texts = { "model.ply": plyText(), "model.stl": stlText(), "model.gltf": gltfText() };
      for (const [name, text] of Object.entries(texts)) {
        writeFileSync(file(name), text);
        await choose(page, "open", file(name));
        await page.waitForFunction(
          (expected) => globalThis.espalier.editor.document.models[0]?.name === expected,
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
