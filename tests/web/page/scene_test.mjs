// SPDX-License-Identifier: Apache-2.0
// Several models in one scene, large models, and the page that is sent to somebody.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { pageFile, settled } from "./browser.mjs";
import {
  assertSameFiles,
  choose,
  commandsShown,
  documentNow,
  download,
  drop,
  file,
  gltfText,
  makeBox,
  plyText,
  run,
  runLine,
  shownPoints,
  stlText,
  until,
  withPage,
} from "./person.mjs";

/** The tetrahedron, and the same at another place in another format, with normals. */
function writeTwo() {
  writeFileSync(file("one.ply"), plyText());
  const corners = [[2, 0, 0], [3, 0, 0], [2, 1, 0], [2, 0, 1]]; // prettier-ignore
  const lines = [
    ...corners.map((p) => `v ${p.join(" ")}`),
    "vn 0 0 -1",
    "f 1//1 3//1 2//1",
    "f 1//1 2//1 4//1",
  ];
  writeFileSync(file("two.obj"), `${lines.join("\n")}\n`);
}

describe("several models", () => {
  test("all follow one lattice, and each is the file of the program", () =>
    withPage(async (page) => {
      writeTwo();
      await choose(page, "open", file("one.ply"));
      await until(page, () => globalThis.espalier.editor.models.length === 1);
      await choose(page, "open beside", file("two.obj"));
      await until(page, () => globalThis.espalier.editor.models.length === 2);
      assert.match(await page.textContent('[data-show="model"]'), /^2 models, 8 points$/);
      await makeBox(page, 3);
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.select([0, 1, 2, 3, 4, 5, 6, 7]);
        await editor.transform({ kind: "rotate", axis: "x", degrees: 30 });
      });
      await settled(page);
      // The commands make the lattice around both, and each deformed model.
      const text = await commandsShown(page);
      assert.match(text, /shape around one\.ply two\.obj /);
      for (const line of text.replaceAll("\\\n", " ").split("\n")) runLine(line);
      const downloads = [];
      page.on("download", (item) => downloads.push(item));
      await page.click('header [data-command="save model"]');
      while (downloads.length < 2) await page.waitForTimeout(50);
      for (const item of downloads) {
        const name = item.suggestedFilename();
        await item.saveAs(file(`taken-${name}`));
      }
      const pose = await download(page, "save pose", "pose.vtu");
      const rest = await download(page, "save rest", "rest.vtu");
      for (const [from, name] of [["one.ply", "one-deformed.ply"], ["two.obj", "two-deformed.obj"]]) { // prettier-ignore
        run("deform", from, "--rest", rest, "--to", pose, "-o", file(`expected-${name}`));
        assertSameFiles(file(`taken-${name}`), file(`expected-${name}`));
      }
      // A pull of a point of the second model moves it, and leaves the pinned point of the first.
      const before = await shownPoints(page);
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const pulls = [{ point: 5, by: [0, 0, 0.1] }];
        const { positions } = await editor.engine.run("pull", pulls, [1], editor.positions);
        await editor.setPositions(positions, null);
      });
      const after = await shownPoints(page);
      assert.ok(Math.abs(after[3 * 5 + 2] - before[3 * 5 + 2] - 0.1) < 1e-5);
      assert.ok(Math.abs(after[3 * 1 + 2] - before[3 * 1 + 2]) < 1e-5);
      // One of them can go, and come back.
      await page.click('[title="Take one.ply out of the scene"]');
      await until(page, () => globalThis.espalier.editor.models.length === 1);
      assert.equal((await documentNow(page)).models[0].name, "two.obj");
      assert.equal((await shownPoints(page)).length, 12);
      await page.keyboard.press("Control+z");
      await until(page, () => globalThis.espalier.editor.models.length === 2);
      assert.deepEqual(await shownPoints(page), after);
    }));

  test("files that are dropped together are one scene, with its lattice", () =>
    withPage(async (page) => {
      writeTwo();
      run("shape", "box", "--min", "-1", "-1", "-1", "--max", "4", "2", "2", "-o", file("box.vtu"));
      await drop(page, { "t.stl": stlText(), "t.gltf": gltfText(), "t.ply": plyText() });
      await until(page, () => globalThis.espalier.editor.models.length === 3);
      await choose(page, "open lattice", file("box.vtu"));
      await until(page, () => globalThis.espalier.editor.binding !== null);
      assert.equal(await page.evaluate(() => globalThis.espalier.editor.binding.outside.length), 0);
      // A broken file changes nothing.
      await drop(page, { "broken.ply": "no model" });
      await page.waitForFunction(() => document.querySelector("#message.error:not([hidden])") !== null);
      assert.equal((await documentNow(page)).models.length, 3);
      assert.ok(await page.evaluate(() => globalThis.espalier.editor.binding !== null));
    }));

  test("a large model is coarse during a drag, and exact after it", () =>
    withPage(async (page) => {
      // A sheet of 460 × 460 points.
      const count = 460;
      const lines = [];
      for (let j = 0; j < count; ++j)
        for (let i = 0; i < count; ++i)
          lines.push(`v ${i / count} ${j / count} ${(0.1 * Math.sin((9 * i) / count)).toFixed(4)}`);
      for (let j = 0; j + 1 < count; ++j)
        for (let i = 1; i < count; ++i) {
          const at = j * count + i;
          lines.push(`f ${at} ${at + 1} ${at + count + 1} ${at + count}`);
        }
      writeFileSync(file("sheet.obj"), `${lines.join("\n")}\n`);
      await choose(page, "open", file("sheet.obj"));
      await until(page, () => globalThis.espalier.editor.models.length === 1);
      await makeBox(page, 3);
      const drawn = () =>
        page.evaluate(() => {
          const [model] = globalThis.espalier.editor.view.models;
          const shown = model.mesh.visible ? model : model.coarse;
          const { geometry } = shown.mesh;
          return [geometry.index.count / 3, geometry.getAttribute("position").count, shown.mesh.visible];
        });
      assert.deepEqual(await drawn(), [2 * 459 * 459, 460 * 460, true]);
      const gap = await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const { points } = editor.models[0].coarse;
        const moved = editor.positions.map((x, i) => x + (i % 3 === 2 ? 0.3 * editor.positions[i - 2] : 0));
        await editor.preview(moved);
        const [model] = editor.view.models;
        const coarse = model.coarse.mesh.geometry.getAttribute("position").array.slice();
        await editor.setPositions(moved, null);
        const exact = editor.view.points;
        let gap = 0;
        points.forEach((point, i) => {
          for (let c = 0; c < 3; ++c)
            gap = Math.max(gap, Math.abs(coarse[3 * i + c] - exact[3 * point + c]));
        });
        return { gap, count: points.length, triangles: model.coarse.mesh.geometry.index.count / 3 };
      });
      // Both are floats, one computed in single precision.
      assert.ok(gap.gap < 1e-5, String(gap.gap));
      // The sheet is in 160 × 160 columns of cubes, and where it is steep, in two cubes of a column.
      assert.ok(gap.count > 25_000 && gap.count < 2 * 160 * 160, String(gap.count));
      assert.ok(gap.triangles > 1.8 * gap.count && gap.triangles <= 2 * gap.count, String(gap.triangles));
      assert.deepEqual(await drawn(), [2 * 459 * 459, 460 * 460, true]);
    }));
});

describe("work that must not be lost", () => {
  test("what is cancelled or fails takes no edit along", () =>
    withPage(async (page) => {
      writeTwo();
      await choose(page, "open", file("one.ply"));
      await until(page, () => globalThis.espalier.editor.models.length === 1);
      await makeBox(page, 3);
      await page.evaluate(() => globalThis.espalier.editor.select([1, 2]));
      const before = await documentNow(page);
      // Cells that cannot be had are not drawn, and not asked for again.
      const asked = await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const { engine } = editor;
        const run = engine.run.bind(engine);
        let asked = 0;
        engine.run = (job, ...values) => {
          if (job !== "cellSurface") return run(job, ...values);
          ++asked;
          return Promise.reject(new Error("no memory"));
        };
        await editor.setShown({ ...editor.view.shown, cells: true });
        await editor.update();
        engine.run = run;
        return asked;
      });
      assert.equal(asked, 1);
      assert.equal(await page.isChecked('[data-shown="cells"]'), false);
      assert.deepEqual(await documentNow(page), before);
      // A binding that fails is made again.
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.change({ settings: { ...editor.document.settings, level: 99 } });
      });
      assert.deepEqual(await documentNow(page), before);
      assert.ok(await page.evaluate(() => globalThis.espalier.editor.binding !== null));
      // Cancelling leaves an empty worker, which gets everything again.
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const made = editor.attempt(() => editor.makeLattice({ kind: "cage", vertices: 2000 }, ""));
        editor.engine.cancel();
        await made;
        await editor.transform({ kind: "move", offset: [0.25, 0, 0] });
      });
      await download(page, "save model", "after.ply");
      assert.equal((await documentNow(page)).poses[0].steps.length, 1);
    }));

  test("models that are opened while poses play, and edits after an undo", () =>
    withPage(async (page) => {
      writeTwo();
      await choose(page, "open", file("one.ply"));
      await until(page, () => globalThis.espalier.editor.models.length === 1);
      await makeBox(page, 2);
      await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        void globalThis.espalier.timeline.toggle();
        void editor.attempt(() => editor.addPose("b", editor.positions));
      });
      for (let i = 2; i <= 4; ++i) {
        await choose(page, "open beside", file("two.obj"));
        await page.waitForFunction((i) => globalThis.espalier.editor.models.length === i, i);
      }
      await page.evaluate(() => globalThis.espalier.timeline.toggle());
      await settled(page);
      assert.equal((await documentNow(page)).models.length, 4);
      assert.ok(await page.isHidden("#message.error"));
      // The lattice that an edit changes is another one by then.
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.editLattice({ kind: "mark", edges: [0, 1], vertices: [], sharpness: 10 });
        const edit = editor.attempt(() => editor.editLattice({ kind: "clear marks" }));
        await editor.undo();
        await edit;
      });
      assert.match(await page.textContent("#message span"), /the lattice has changed meanwhile/);
    }));

  test("vertices at one place stay two", () =>
    withPage(async (page) => {
      await page.click('[data-form="shape"] button');
      await until(page, () => globalThis.espalier.editor.shape !== null);
      const count = await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.setTime(0);
        const move = (v, to) => {
          const positions = editor.positions.slice();
          positions.set(to, 3 * v);
          return editor.setPositions(positions, null);
        };
        await move(0, editor.positions.slice(3, 6));
        await move(0, [-1, -1, -1.5]);
        return editor.positions.length / 3;
      });
      assert.equal(count, 64);
      const { lattice } = await documentNow(page);
      assert.equal(lattice.positions[2], -1.5);
    }));

  test("files of poses and models get names of their own", () =>
    withPage(async (page) => {
      writeTwo();
      writeFileSync(file("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
      await choose(page, "open", file("one.ply"), file("one.obj"));
      await until(page, () => globalThis.espalier.editor.models.length === 2);
      await makeBox(page, 2);
      const names = ["Rest", "A!", "A?"];
      await page.evaluate(async (names) => {
        const { editor } = globalThis.espalier;
        const poses = names.map((name) => ({ ...editor.document.poses[0], name }));
        await editor.change({ poses, time: 1 });
      }, names);
      const files = [];
      for (let time = 1; time <= 3; ++time) {
        await page.evaluate((time) => globalThis.espalier.editor.setTime(time), time);
        const text = await commandsShown(page);
        assert.match(text, /-o D-one\.npz[\s\S]*-o D-one-2\.npz/);
        files.push(text.match(/espalier pose[^]*?-o (\S+)/)[1]);
      }
      assert.deepEqual(files, ["rest-2.vtu", "a-.vtu", "a--2.vtu"]);
      await page.evaluate(() => globalThis.espalier.editor.setTime(0));
      assert.match(await commandsShown(page), /^cp rest\.vtu rest-as-pose\.vtu$/m);
    }));
});

describe("a page to send", () => {
  test("has the models, the lattice, the poses and the settings inside", async () => {
    writeTwo();
    let sent;
    await withPage(async (page) => {
      await choose(page, "open", file("one.ply"), file("two.obj"));
      await until(page, () => globalThis.espalier.editor.models.length === 2);
      await makeBox(page, 2);
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const { settings, rules } = editor.document;
        await editor.change({ settings: { ...settings, level: 2, outside: "nearest" }, rules: { ...rules, boundary: "open" } });
        await editor.select([0, 5]);
        await editor.transform({ kind: "move", offset: [0.1, 0.2, 0.3] });
      });
      await settled(page);
      const points = await shownPoints(page);
      const html = await download(page, "save page", "sent.html");
      sent = { points, html, document: await documentNow(page) };
    });
    for (let copy = 0; copy < 2; ++copy)
      await withPage(
        async (page) => {
          await until(page, () => globalThis.espalier.editor.document.poses[0]?.name === "Pose 1");
          const { models, settings, rules, poses, time, lattice } = await documentNow(page);
          assert.equal(lattice.command, sent.document.lattice.command);
          assert.deepEqual(poses[0].steps, sent.document.poses[0].steps);
          assert.deepEqual(models, sent.document.models);
          assert.deepEqual([settings, rules], [sent.document.settings, sent.document.rules]);
          assert.deepEqual([poses.length, time], [1, 1]);
          assert.deepEqual(poses[0].positions, sent.document.poses[0].positions);
          assert.deepEqual(await shownPoints(page), sent.points);
          // It keeps its work apart: the page without files has none.
          await page.waitForTimeout(600);
          await page.goto(`file://${pageFile}`);
          await page.waitForSelector("html[data-ready]");
          assert.deepEqual((await documentNow(page)).models, []);
          await page.goto(`file://${sent.html}`);
          await page.waitForSelector("html[data-ready]");
          await settled(page);
          assert.equal((await documentNow(page)).models.length, 2);
          // A page that was sent can be sent on.
          sent.html = await download(page, "save page", "sent-on.html");
        },
        { file: sent.html },
      );
  });
});
