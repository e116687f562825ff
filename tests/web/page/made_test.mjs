// SPDX-License-Identifier: Apache-2.0
// Lattices, rules and handles: what the page makes is what the program makes.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { settled } from "./browser.mjs";
import {
  assertSameFiles,
  choose,
  commandsShown,
  compareWithProgram,
  documentNow,
  download,
  handlesLetGo,
  file,
  makeBox,
  message,
  openExample,
  positionsOf,
  run,
  runLine,
  shownPoints,
  until,
  withPage,
} from "./person.mjs";

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
      await page.waitForFunction(() => document.querySelector("#message.error:not([hidden])") !== null);
      assert.match(await message(page), /broken/);
      assert.equal((await documentNow(page)).poses[0].steps.length, 0);
      assert.equal(await page.evaluate(() => globalThis.espalier.editor.shape.cells.length), 16);
    }));

  test("turns and scales by the handles", () =>
    withPage(async (page) => {
      await openExample(page, "column");
      await makeBox(page, 3);
      const turnHandles = async (mode, change) => {
        await page.evaluate(
          async ([mode, change]) => {
            const { editor, gizmo } = globalThis.espalier;
            document.querySelector(`[data-command="${mode}"]`).click();
            gizmo.controls.dragging = true;
            if (mode === "rotate") gizmo.handle.rotation.set(...change);
            else gizmo.handle.scale.set(...change);
            gizmo.controls.dispatchEvent({ type: "objectChange" });
            await editor.engine.run("memory");
            gizmo.controls.dragging = false;
          },
          [mode, change],
        );
        await handlesLetGo(page);
      };
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
