// SPDX-License-Identifier: Apache-2.0
// The page by itself: undo, broken files, keys, selections, poses, touch.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { kPatience, settled } from "./browser.mjs";
import {
  choose,
  clickVertex,
  compareWithProgram,
  documentNow,
  download,
  dragHandles,
  drop,
  file,
  folder,
  handlesLetGo,
  makeBox,
  message,
  openExample,
  plyText,
  run,
  shownPoints,
  until,
  withPage,
} from "./person.mjs";
import { program } from "../program.mjs";

/** The time in the document that the page has saved. (waitForFunction does not await promises.) */
const timeOfSavedDocument = (page) =>
  page.evaluate(async () => {
    const resultOf = (request) =>
      new Promise((resolve, reject) => {
        request.onsuccess = () => resolve(request.result);
        request.onerror = () => reject(request.error);
      });
    const database = await resultOf(indexedDB.open("espalier"));
    const store = database.transaction("documents").objectStore("documents");
    const saved = await resultOf(store.get("last"));
    database.close();
    return saved?.time;
  });

/** A window that shows the whole lattice. */
const kLargeWindow = { viewport: { width: 900, height: 600 } };

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
      await openExample(page);
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
    }, kLargeWindow));

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

  test("moves, turns and pulls keep the vertices that the lattice holds, unless told otherwise", () =>
    withPage(async (page) => {
      run("shape", "box", "--cells", "1", "1", "1", "-o", "inner.vtu");
      run("shape", "collar", "inner.vtu", "--layers", "1", "--reach", "1", "-o", "held.vtu");
      await openExample(page);
      await choose(page, "open lattice", file("held.vtu"));
      await until(page, () => globalThis.espalier.editor.document.lattice?.positions.length === 3 * 64);
      const moved = async () => {
        await settled(page);
        const { lattice, poses } = await documentNow(page);
        const before = lattice.positions;
        const after = poses.length > 0 ? poses[0].positions : before;
        return [...Array(64).keys()].filter((v) => [0, 1, 2].some((c) => before[3 * v + c] !== after[3 * v + c]));
      };
      const inner = [0, 1, 2, 3, 4, 5, 6, 7];
      await page.keyboard.press("a");
      await page.evaluate(() => globalThis.espalier.editor.transform({ kind: "move", offset: [0.1, 0, 0] }));
      assert.deepEqual(await moved(), inner);
      const pull = () =>
        page.evaluate(async () => {
          const { editor } = globalThis.espalier;
          const pulls = [{ point: 0, by: [0, 0.05, 0] }];
          const { positions } = await editor.engine.run("pull", pulls, [], editor.positions, editor.movesHeld);
          await editor.setPositions(positions, null);
        });
      await pull();
      assert.deepEqual(await moved(), inner);
      // A selection of held vertices alone gives a message.
      await page.evaluate(() => globalThis.espalier.editor.select([8, 9]));
      await assert.rejects(
        page.evaluate(() => globalThis.espalier.editor.transform({ kind: "move", offset: [1, 0, 0] })),
        /all selected vertices are held/,
      );
      await page.check('[data-choice="held"]', { force: true });
      await page.evaluate(() => globalThis.espalier.editor.transform({ kind: "move", offset: [0.1, 0, 0] }));
      assert.deepEqual(await moved(), [...inner, 8, 9]);
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
          await editor.setPositions(
            (await editor.engine.run("pull", [{ point, by }], [], editor.positions)).positions,
            null,
          );
        },
        [point, by],
      );
      const shown = await shownPoints(page);
      // The floats on the screen round coordinates of about 2.
      for (let c = 0; c < 3; ++c) {
        const gap = shown[3 * point + c] - before[3 * point + c] - by[c];
        assert.ok(Math.abs(gap) < 1e-6, String(gap));
      }

      // By hand: a click chooses the point, and its handles pull it.
      await page.keyboard.press("p");
      const canvas = page.locator("#view canvas");
      const { x, y, width, height } = await canvas.boundingBox();
      await canvas.click({ position: { x: width / 2, y: height / 2 } });
      const pulled = await page.evaluate(() => globalThis.espalier.gizmo.pulls[0]);
      const from = await page.evaluate(() => {
        const { gizmo, editor } = globalThis.espalier;
        const { points, camera } = editor.view;
        const place = camera.position
          .clone()
          .fromArray(points, 3 * gizmo.pulls[0])
          .project(camera);
        return [place.x, place.y];
      });
      const start = { x: x + ((from[0] + 1) / 2) * width, y: y + ((1 - from[1]) / 2) * height };
      const old = await shownPoints(page);
      await page.mouse.move(start.x, start.y);
      await page.mouse.down();
      await page.mouse.move(start.x + 40, start.y - 40, { steps: 4 });
      await page.mouse.up();
      await handlesLetGo(page);
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
      const begin = Date.now();
      while ((await timeOfSavedDocument(page)) !== 0.5)
        assert.ok(Date.now() - begin < kPatience, "the document is not saved");
      await page.reload();
      await page.waitForSelector("html[data-ready]");
      await settled(page);
      assert.deepEqual((await documentNow(page)).poses, poses);
      assert.deepEqual(await shownPoints(page), points);
    }));

  test("files are dropped, and vertices are tapped", () =>
    withPage(
      async (page) => {
        const corners = ["--min", "0", "0", "0", "--max", "1", "1", "1"];
        run("shape", "box", "--cells", "2", "2", "2", ...corners, "-o", file("dropped.vtu"));
        await drop(page, {
          "dropped.ply": plyText(),
          "dropped.vtu": readFileSync(file("dropped.vtu")),
        });
        await until(page, () => globalThis.espalier.editor.binding !== null);
        const at = await page.evaluate(() => globalThis.espalier.editor.view.screenOf(26));
        await page.locator("#view canvas").tap({ position: { x: at.x + 15, y: at.y } });
        await settled(page);
        assert.deepEqual((await documentNow(page)).selection, [26]);
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 400);
      },
      { viewport: { width: 400, height: 780 }, hasTouch: true, isMobile: true },
    ));
});
