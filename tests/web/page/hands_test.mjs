// SPDX-License-Identifier: Apache-2.0
// What hands do in the page: clicks through the handles, areas, the pivot, steps, the camera, keys, the first minute, and
// the commands that are pasted into a shell.
import assert from "node:assert/strict";
import { readdirSync, writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { settled } from "./browser.mjs";
import {
  choose,
  clickVertex,
  commandsShown,
  documentNow,
  download,
  dragHandles,
  drop,
  file,
  folder,
  handlesLetGo,
  makeBox,
  makeCage,
  openExample,
  plyText,
  positionsOf,
  runLine,
  shownPoints,
  until,
  withPage,
} from "./person.mjs";

const kLargeWindow = { viewport: { width: 1100, height: 700 } };
const selected = async (page) => (await documentNow(page)).selection;
const press = async (page, key) => {
  await page.keyboard.press(key);
  await settled(page);
};
const clickCommand = async (page, name) => {
  await page.evaluate((each) => document.querySelector(`[data-command="${each}"]`).click(), name);
  await settled(page);
};
const select = async (page, vertices) => {
  await page.evaluate((each) => globalThis.espalier.editor.select(each), vertices);
  await settled(page);
};
const positions = async (page) => page.evaluate(() => [...globalThis.espalier.editor.positions]);
const at = (all, v) => all.slice(3 * v, 3 * v + 3);

/** A box of 3 × 3 × 3 cells from -1 to 1: vertex (i, j, k) is i + 4 (j + 4 k). */
async function makeShape(page) {
  await page.click('[data-form="shape"] button');
  await until(page, () => globalThis.espalier.editor.shape !== null);
}

/** Drags the pointer along places of the view, given as parts of its size. */
async function drag(page, ...places) {
  const box = await page.locator("#view canvas").boundingBox();
  const [from, ...to] = places.map(([x, y]) => [box.x + x * box.width, box.y + y * box.height]);
  await page.mouse.move(...from);
  await page.mouse.down();
  for (const place of to) await page.mouse.move(...place, { steps: 3 });
  await page.mouse.up();
  await settled(page);
}

describe("hands in the page", () => {
  test("clicks select through the handles, and Add adds", () =>
    withPage(async (page) => {
      await makeShape(page);
      await clickVertex(page, 63);
      assert.deepEqual(await selected(page), [63]);
      // The handles are at the vertex now: a click there, without a drag, reaches the vertex.
      await clickVertex(page, 63);
      assert.deepEqual(await selected(page), [63]);
      // The handles in the middle of all vertices are in front of some: a vertex below them is selected.
      await press(page, "a");
      const below = await page.evaluate(() => {
        const { view } = globalThis.espalier.editor;
        const { x, y } = view.screenOf(63);
        const [left, top] = [view.canvas.clientWidth / 2, view.canvas.clientHeight / 2];
        return { x: x - left, y: y - top };
      });
      assert.ok(Math.hypot(below.x, below.y) > 20);
      await clickVertex(page, 63, { modifiers: ["Shift"] });
      assert.equal((await selected(page)).length, 63);
      await select(page, [63]);
      await clickVertex(page, 63, { modifiers: ["Shift"] });
      assert.deepEqual(await selected(page), []);
      await clickCommand(page, "add");
      for (const v of [60, 63, 15]) await clickVertex(page, v);
      assert.deepEqual(await selected(page), [15, 60, 63]);
      // A drag on a handle still moves.
      await clickCommand(page, "add");
      await clickVertex(page, 63);
      const before = await positions(page);
      await dragHandles(page, 40, -30);
      assert.notDeepEqual(at(await positions(page), 63), at(before, 63));
    }, kLargeWindow));

  test("a click on a handle with no vertex behind it keeps the selection", () =>
    withPage(async (page) => {
      await makeShape(page);
      await select(page, [63]);
      const arrow = await page.evaluate(() => {
        const { view } = globalThis.espalier.editor;
        const { x, y } = view.screenOf(63);
        return { x, y: y - 45 };
      });
      await page.mouse.move(0, 0);
      await page.locator("#view canvas").hover({ position: arrow });
      assert.ok(await page.evaluate(() => globalThis.espalier.gizmo.isUsed));
      await page.locator("#view canvas").click({ position: arrow });
      await settled(page);
      assert.deepEqual(await selected(page), [63]);
    }, kLargeWindow));

  test("a lasso selects what is inside it, all or only in front", () =>
    withPage(async (page) => {
      await makeShape(page);
      await press(page, "5");
      await drag(page, [0.004, 0.004], [0.996, 0.004], [0.996, 0.996], [0.004, 0.996]);
      assert.equal((await selected(page)).length, 64);
      await clickCommand(page, "front");
      await press(page, "Escape");
      await drag(page, [0.004, 0.004], [0.996, 0.004], [0.996, 0.996], [0.004, 0.996]);
      const front = await selected(page);
      // Three faces of a box are in front: 64 vertices less the 27 that they hide.
      assert.equal(front.length, 37);
      // A triangle is no box: its corner does not select what a box would.
      await clickCommand(page, "front");
      await press(page, "Escape");
      await drag(page, [0.02, 0.02], [0.98, 0.02], [0.02, 0.98]);
      const part = await selected(page);
      assert.ok(part.length > 0 && part.length < 64, String(part.length));
    }, kLargeWindow));

  test("what is not selected can be hidden, and is not picked then", () =>
    withPage(async (page) => {
      await makeShape(page);
      await select(page, [60, 61, 62, 63]);
      await press(page, "h");
      await clickVertex(page, 15);
      assert.deepEqual(await selected(page), []);
      await clickVertex(page, 63);
      assert.deepEqual(await selected(page), [63]);
      await press(page, "h");
      await clickVertex(page, 15);
      assert.deepEqual(await selected(page), [15]);
    }, kLargeWindow));

  test("turns and scales go about the pivot, as in the program", () =>
    withPage(async (page) => {
      await makeShape(page);
      const end = Array.from({ length: 64 }, (_, v) => v).filter((v) => v % 4 >= 2);
      await select(page, end);
      await page.selectOption('[data-choice="pivot"]', "border");
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "rotate", axis: "z", degrees: 90 }),
      );
      // The border is at x = 1/3: its middle (1/3, 0, 0) stays. Vertex 3 was at (1, -1, -1).
      const [x, y, z] = at(await positions(page), 3);
      assert.ok(Math.hypot(x - 4 / 3, y - 2 / 3, z + 1) < 1e-12, [x, y, z].join());
      const text = await commandsShown(page);
      assert.match(text, /--center 0\.333333333333\d* \S+ \S+ --rotate z 90 /);
      // Set here: the middle of one selection is the pivot of another.
      await press(page, "Control+z");
      await select(page, [0]);
      await clickCommand(page, "pivot here");
      await select(page, [63]);
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "scale", factors: [0.5, 0.5, 0.5] }),
      );
      assert.deepEqual(at(await positions(page), 63), [0, 0, 0]);
      await page.selectOption('[data-choice="pivot"]', "middle");
      // The handles are at the selection, also if its neighbours move in part.
      await page.evaluate(() => globalThis.espalier.editor.setRadius(1));
      const handle = await page.evaluate(() => globalThis.espalier.gizmo.handle.position.toArray());
      assert.deepEqual(handle, [0, 0, 0]);
    }, kLargeWindow));

  test("the handles move along one axis, and in steps", () =>
    withPage(async (page) => {
      await makeShape(page);
      await select(page, [63]);
      await press(page, "x");
      const shown = await page.evaluate(() => {
        const { showX, showY, showZ } = globalThis.espalier.gizmo.controls;
        return [showX, showY, showZ];
      });
      assert.deepEqual(shown, [true, false, false]);
      await press(page, "x");
      await clickCommand(page, "snap");
      await dragHandles(page, 37, -23);
      const moved = at(await positions(page), 63);
      const step = await page.evaluate(() => globalThis.espalier.gizmo.controls.translationSnap);
      assert.ok(step > 0);
      for (const x of moved) assert.ok(Math.abs(x / step - Math.round(x / step)) < 1e-6, String(x));
      assert.notDeepEqual(moved, [1, 1, 1]);
      await press(page, "g");
      assert.equal(await page.evaluate(() => globalThis.espalier.gizmo.mode), "translate");
    }, kLargeWindow));

  test("extruded faces are selected, at a distance of the size of the lattice", () =>
    withPage(async (page) => {
      await makeShape(page);
      await press(page, "ArrowUp");
      const top = Array.from({ length: 64 }, (_, v) => v).filter((v) => (v >> 2) % 4 === 3);
      await select(page, top);
      await press(page, "e");
      await until(page, () => globalThis.espalier.editor.shape.positions.length === 3 * 80);
      const now = await selected(page);
      assert.equal(now.length, 16);
      const all = await positions(page);
      // The cells are 2/3 wide, which two digits show as 0.67.
      for (const v of now) assert.ok(Math.abs(all[3 * v + 1] - 1.67) < 1e-12);
      // A chosen distance stays.
      await page.evaluate(() => (document.querySelector('[data-form="extrude"]').closest("details").open = true));
      await page.fill('[name="distance"]', "0.1");
      await select(page, now.slice(0, 4));
      assert.equal(await page.inputValue('[name="distance"]'), "0.1");
    }, kLargeWindow));

  test("the camera looks from the axes, in parallel, with z up, and clips nothing", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page);
      const eye = () =>
        page.evaluate(() => {
          const { camera, controls } = globalThis.espalier.editor.view;
          return camera.position.clone().sub(controls.target).normalize().toArray();
        });
      const isAlong = (found, expected) =>
        assert.ok(Math.hypot(...found.map((x, i) => x - expected[i])) < 1e-3, found.join());
      for (const [code, expected] of [
        ["Numpad1", [0, 0, 1]],
        ["Numpad3", [1, 0, 0]],
        ["Numpad7", [0, 1, 0]],
      ]) {
        await press(page, code);
        isAlong(await eye(), expected);
      }
      await page.click('#axes [aria-label="Look from −z"]');
      await settled(page);
      isAlong(await eye(), [0, 0, -1]);
      const corners = () =>
        page.evaluate(() => {
          const { view, shape } = globalThis.espalier.editor;
          const { clientWidth: width, clientHeight: height } = view.canvas;
          return [...shape.vertexStrata.keys()].every((v) => {
            const { x, y, depth } = view.screenOf(v);
            return x >= 0 && x <= width && y >= 0 && y <= height && Math.abs(depth) <= 1;
          });
        });
      assert.ok(await corners());
      await clickCommand(page, "parallel");
      assert.ok(await page.evaluate(() => globalThis.espalier.editor.view.camera.isOrthographicCamera));
      assert.ok(await corners());
      // Picking works in the parallel view, too.
      await press(page, "f");
      const box = await page.evaluate(() => globalThis.espalier.editor.shape.vertexStrata.length - 1);
      await clickVertex(page, box);
      assert.deepEqual(await selected(page), [box]);
      await clickCommand(page, "z up");
      await press(page, "Numpad1");
      isAlong(await eye(), [0, -1, 0]);
      assert.ok(await corners());
      await clickCommand(page, "z up");
      await clickCommand(page, "parallel");
      // After a pose that goes far, everything is in sight.
      await press(page, "a");
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [40, 0, 0] }),
      );
      await press(page, "Home");
      assert.ok(await corners());
    }, kLargeWindow));

  test("a tail that is pulled bends, and folds no cell", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeCage(page);
      const { gap, folded, milliseconds } = await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const { points } = editor.models[0];
        // The end of the tail is the point with the least x; the dog is about 2 high.
        let point = 0;
        for (let i = 0; i < points.length; i += 3) if (points[i] < points[3 * point]) point = i / 3;
        const { positions } = editor;
        const frames = 20;
        const start = performance.now();
        let moved;
        for (let frame = 1; frame <= frames; ++frame) {
          const by = [0, (0.5 * frame) / frames, 0];
          moved = (await editor.engine.run("pull", [{ point, by }], [], positions)).positions;
        }
        const milliseconds = (performance.now() - start) / frames;
        const before = points[3 * point + 1];
        await editor.setPositions(moved, null);
        const gap = editor.view.points[3 * point + 1] - before - 0.5;
        return { gap, folded: editor.folded.length, milliseconds };
      });
      console.log(`a frame of a pull takes ${milliseconds.toFixed(1)} ms`);
      assert.equal(folded, 0);
      assert.ok(Math.abs(gap) < 1e-5, String(gap)); // floats on the screen
    }, kLargeWindow));

  test("several points are pulled at once, and pinned points stay", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeCage(page);
      await press(page, "Numpad1");
      await press(page, "p");
      // Seen from the front, the dog's nose is at the right, its tail at the left; both are above the feet.
      const find = (axis, sign) =>
        page.evaluate(
          ([axis, sign]) => {
            const { view } = globalThis.espalier.editor;
            let best = 0;
            for (let i = 0; i < view.points.length / 3; ++i)
              if (sign * (view.points[3 * i + axis] - view.points[3 * best + axis]) > 0) best = i;
            // A little inside of the outline, so that the pointer meets the model.
            const place = view.camera.position.clone().fromArray(view.points, 3 * best);
            place.setComponent(axis, place.getComponent(axis) - 0.03 * sign);
            place.project(view.camera);
            const { clientWidth: width, clientHeight: height } = view.canvas;
            return { x: ((place.x + 1) / 2) * width, y: ((1 - place.y) / 2) * height };
          },
          [axis, sign],
        );
      const canvas = page.locator("#view canvas");
      const click = async (place, options) => {
        await canvas.click({ position: place, ...options });
        await settled(page);
      };
      const marked = () =>
        page.evaluate(() => ({ ...globalThis.espalier.gizmo, view: 0, editor: 0, handle: 0, controls: 0 }));
      const nose = await find(0, 1);
      const tail = await find(0, -1);
      await click(nose);
      await press(page, "k");
      const [pin] = (await marked()).pins;
      assert.ok(pin >= 0);
      await click(tail);
      const foot = await find(1, -1);
      await click(foot, { modifiers: ["Shift"] });
      const { pulls } = await marked();
      assert.equal(pulls.length, 2);
      const before = await shownPoints(page);
      const by = await page.evaluate(() => {
        const { gizmo } = globalThis.espalier;
        gizmo.controls.dragging = true;
        gizmo.controls.dispatchEvent({ type: "dragging-changed", value: true });
        gizmo.handle.position.y += 0.1;
        gizmo.handle.position.x -= 0.2;
        gizmo.controls.dispatchEvent({ type: "objectChange" });
        gizmo.controls.dragging = false;
        gizmo.controls.dispatchEvent({ type: "dragging-changed", value: false });
        return [-0.2, 0.1, 0];
      });
      await handlesLetGo(page);
      const after = await shownPoints(page);
      const moved = (point) => [0, 1, 2].map((c) => after[3 * point + c] - before[3 * point + c]);
      // Floats of about 2, and pulls that reach their targets up to 1e-8 of the way.
      for (const point of pulls)
        moved(point).forEach((x, c) => assert.ok(Math.abs(x - by[c]) < 1e-5, moved(point).join()));
      for (const x of moved(pin)) assert.ok(Math.abs(x) < 1e-5, moved(pin).join());
      // A click frees a pin; so does the button, all of them.
      await click(await find(0, 1));
      assert.deepEqual((await marked()).pins, []);
      await press(page, "k");
      await clickCommand(page, "free pins");
      assert.deepEqual((await marked()).pins, []);
    }, kLargeWindow));

  test("live mirroring lets the other side do what one side does, as in the program", () =>
    withPage(async (page) => {
      await makeShape(page);
      await page.selectOption('[data-choice="mirror"]', "x");
      await clickVertex(page, 63);
      await dragHandles(page, 40, -30);
      await press(page, "r");
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        await editor.select([3, 7]);
        await editor.transform({ kind: "rotate", axis: "z", degrees: 20 });
      });
      await settled(page);
      const all = await positions(page);
      const reflected = (v) => at(all, v).map((x, c) => (c === 0 ? -x : x));
      assert.notDeepEqual(at(all, 63), [1, 1, 1]);
      for (const [v, w] of [[63, 60], [3, 0], [7, 4]]) // prettier-ignore
        assert.deepEqual(at(all, w), reflected(v));
      const taken = await download(page, "save pose", "mirrored.vtu");
      const lines = (await commandsShown(page)).replaceAll("\\\n", " ").split("\n");
      assert.equal(lines.filter((line) => line.match(/--mirror x/g)?.length === 2).length, 1);
      for (const line of lines) if (/^espalier (shape|pose)/.test(line)) runLine(line);
      positionsOf(file("pose-1.vtu")).forEach((x, i) =>
        assert.ok(Math.abs(x - positionsOf(taken)[i]) < 1e-12),
      );
      // Vertices without an image are counted.
      await press(page, "ArrowUp");
      await select(page, [60, 61, 62, 63]);
      await page.evaluate(() => globalThis.espalier.editor.setTime(0));
      await page.selectOption('[data-choice="mirror"]', "");
      await select(page, [60]);
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [-0.4, 0, 0] }),
      );
      await settled(page);
      await page.selectOption('[data-choice="mirror"]', "y");
      await select(page, [0, 60]);
      await page.evaluate(() =>
        globalThis.espalier.editor.transform({ kind: "move", offset: [0, 0, 0.1] }),
      );
      assert.ok(await page.isVisible("#message"));
      assert.equal(
        await page.textContent("#message span"),
        "No mirror image for 1 of the vertices: they stay.",
      );
    }, kLargeWindow));

  test("a point is pulled by one drag, undo takes the handles along, and no handle moves out of sight", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeCage(page);
      await press(page, "Numpad1");
      await press(page, "p");
      const eye = () => page.evaluate(() => globalThis.espalier.editor.view.camera.position.toArray());
      const before = await eye();
      // A point of the tail, as a place on the screen.
      const [x, y] = await page.evaluate(() => {
        const { view } = globalThis.espalier.editor;
        const place = view.camera.position.clone().set(-1.14, 1.3, 0).project(view.camera);
        return [(place.x + 1) / 2, (1 - place.y) / 2];
      });
      const old = await shownPoints(page);
      await drag(page, [x, y], [x - 0.03, y], [x - 0.05, y + 0.05]);
      await handlesLetGo(page);
      const now = await shownPoints(page);
      assert.deepEqual(await eye(), before);
      const [pulled] = await page.evaluate(() => globalThis.espalier.gizmo.pulls);
      const moved = [0, 1, 2].map((c) => now[3 * pulled + c] - old[3 * pulled + c]);
      assert.ok(moved[0] < -0.05 && moved[1] < -0.05 && Math.abs(moved[2]) < 1e-4, moved.join());
      // The place of the pointer is where the point is now.
      const gap = await page.evaluate(
        ([pulled, x, y]) => {
          const { view } = globalThis.espalier.editor;
          const place = view.camera.position.clone().fromArray(view.points, 3 * pulled).project(view.camera);
          return Math.hypot((place.x + 1) / 2 - x, (1 - place.y) / 2 - y);
        },
        [pulled, x - 0.05, y + 0.05],
      );
      assert.ok(gap < 0.003, String(gap));
      await press(page, "Control+z");
      const handle = await page.evaluate(() => globalThis.espalier.gizmo.handle.position.toArray());
      handle.forEach((x, c) => assert.ok(Math.abs(x - old[3 * pulled + c]) < 1e-5));
      // Beside the model, a drag turns the view.
      await drag(page, [0.05, 0.5], [0.2, 0.5]);
      assert.notDeepEqual(await eye(), before);

      // From +x, the handle along x is at the middle: the middle moves in the plane of the screen.
      await press(page, "g");
      await select(page, [3]);
      await press(page, "Numpad3");
      const at = await page.evaluate(() => globalThis.espalier.editor.view.screenOf(3));
      await page.locator("#view canvas").hover({ position: { x: at.x, y: at.y } });
      assert.equal(await page.evaluate(() => globalThis.espalier.gizmo.controls.axis), "XYZ");
      const start = await positions(page);
      await dragHandles(page, 30, -40);
      const end = await positions(page);
      assert.ok(Math.abs(end[9] - start[9]) < 0.02, `${end[9]} ${start[9]}`);
      assert.ok(end[10] > start[10] + 0.02);
    }, kLargeWindow));

  test("undo during a drag ends it", () =>
    withPage(async (page) => {
      await makeShape(page);
      await select(page, [63]);
      const before = await positions(page);
      await page.evaluate(() => globalThis.espalier.editor.transform({ kind: "move", offset: [0.5, 0, 0] }));
      await page.evaluate(() => {
        const { gizmo } = globalThis.espalier;
        gizmo.controls.dragging = true;
        gizmo.handle.position.y += 0.4;
        gizmo.controls.dispatchEvent({ type: "objectChange" });
      });
      await press(page, "Control+z");
      await page.evaluate(() => {
        const { gizmo } = globalThis.espalier;
        gizmo.handle.position.y += 0.4;
        gizmo.controls.dispatchEvent({ type: "objectChange" });
        gizmo.controls.dragging = false;
      });
      await handlesLetGo(page);
      assert.deepEqual(await positions(page), before);
      assert.ok(!(await page.evaluate(() => globalThis.espalier.editor.transient)));
    }, kLargeWindow));

  test("a pull that would fold cells stays behind, and says so", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeCage(page);
      await press(page, "p");
      const folded = await page.evaluate(async () => {
        const { editor, gizmo } = globalThis.espalier;
        const { points } = editor.models[0];
        let [nose, foot] = [0, 0];
        for (let i = 0; i < points.length; i += 3) {
          if (points[i] > points[3 * nose]) nose = i / 3;
          if (points[i + 1] < points[3 * foot + 1]) foot = i / 3;
        }
        // The nose through a pin close behind it: both are in one cell, and about 2 % of the way are left.
        let pin = 0;
        const distance = (p) => Math.hypot(...[0, 1, 2].map((c) => points[3 * p + c] - points[3 * nose + c]));
        const gap = (p) => Math.abs(distance(p) - 0.04);
        for (let p = 0; p < points.length / 3; ++p) if (gap(p) < gap(pin)) pin = p;
        gizmo.pulls = [nose];
        gizmo.pins = [pin, foot];
        gizmo.place();
        gizmo.controls.dispatchEvent({ type: "dragging-changed", value: true });
        gizmo.handle.position.x -= 0.4;
        await gizmo.end();
        return editor.folded.length;
      });
      await settled(page);
      assert.equal(folded, 0);
      assert.match(await page.textContent("#message span"), /^Cells would fold there: the point stays \d+ % /);
    }, kLargeWindow));

  test("a pull is mirrored, too", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page, 8);
      await page.selectOption('[data-choice="mirror"]', "z");
      await press(page, "p");
      const gap = await page.evaluate(async () => {
        const { editor, gizmo } = globalThis.espalier;
        const { points } = editor.models[0];
        // The ear with the largest z, and its mirror image.
        let ear = 0;
        for (let i = 0; i < points.length; i += 3)
          if (points[i + 1] > 1.2 && points[i + 2] > points[3 * ear + 2]) ear = i / 3;
        gizmo.pulls = [ear];
        gizmo.place();
        gizmo.controls.dispatchEvent({ type: "dragging-changed", value: true });
        gizmo.handle.position.z += 0.2;
        await gizmo.end();
        const rest = editor.document.lattice.positions;
        const now = editor.positions;
        let [apart, moved] = [0, 0];
        const twice = Math.min(...rest.filter((_, i) => i % 3 === 2)) + Math.max(...rest.filter((_, i) => i % 3 === 2));
        for (let v = 0; v < rest.length; v += 3) {
          const image = [rest[v], rest[v + 1], twice - rest[v + 2]];
          const isAt = (i) => i % 3 === 0 && image.every((x, c) => Math.abs(rest[i + c] - x) < 1e-12);
          const w = rest.findIndex((_, i) => isAt(i));
          for (let c = 0; c < 3; ++c) {
            const reflected = c === 2 ? twice - now[v + c] : now[v + c];
            apart = Math.max(apart, Math.abs(now[w + c] - reflected));
            moved = Math.max(moved, Math.abs(now[v + c] - rest[v + c]));
          }
        }
        return { apart, moved, at: editor.view.points[3 * ear + 2] - points[3 * ear + 2] };
      });
      assert.ok(gap.apart < 1e-12, String(gap.apart));
      assert.ok(gap.moved > 0.1);
      assert.ok(Math.abs(gap.at - 0.2) < 0.01, String(gap.at));
    }, kLargeWindow));

  test("a limb is selected at a vertex, and turns about its joint", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeCage(page);
      const count = (await positions(page)).length / 3;
      // The vertex at the end of the tail has the least x.
      const all = await positions(page);
      let end = 0;
      for (let v = 0; v < count; ++v) if (all[3 * v] < all[3 * end]) end = v;
      await select(page, [end]);
      await clickCommand(page, "limb");
      const limb = await selected(page);
      assert.ok(limb.includes(end) && limb.length >= 8 && limb.length < count / 3, limb.join());
      assert.equal(await page.inputValue('[data-choice="pivot"]'), "border");
      for (const v of limb) assert.ok(all[3 * v] < 0 && all[3 * v + 1] > 0.4);
      await press(page, "]");
      const grown = await selected(page);
      assert.ok(grown.length > limb.length && limb.every((v) => grown.includes(v)));
      await press(page, "[");
      assert.ok((await selected(page)).length < grown.length);
      await select(page, [end]);
      await clickCommand(page, "beyond");
      assert.ok((await selected(page)).includes(end));
      // A box has no limb: the message says so.
      await makeBox(page);
      await select(page, [0]);
      await clickCommand(page, "limb");
      assert.match(await page.textContent("#message span"), /has no limb at/);
    }, kLargeWindow));

  test("no key replaces the work, and messages go with what they are about", () =>
    withPage(async (page) => {
      await openExample(page);
      await makeBox(page);
      const before = await documentNow(page);
      for (const key of "bcdefghijklmnopqrstuvwyz0123456789") {
        if (key === "o" || key === "l" || key === "c") continue; // These open a dialog.
        await press(page, key);
      }
      await press(page, "Escape");
      const { models, lattice } = await documentNow(page);
      assert.deepEqual([models, lattice], [before.models, before.lattice]);
      await page.evaluate(() => globalThis.espalier.editor.onMessage("about this", true));
      assert.ok(await page.isVisible("#message"));
      await select(page, [5]);
      assert.ok(!(await page.isVisible("#message")));
    }));

  test("every control says what it does", () =>
    withPage(async (page) => {
      const silent = await page.evaluate(() =>
        [...document.querySelectorAll("button, input, select")]
          .filter((control) => control.type !== "file")
          .filter((control) => !control.title && !control.closest("label[title]"))
          .map((control) => control.outerHTML),
      );
      assert.deepEqual(silent, []);
    }));

  test("an example is bent after one click, and can be taken home from any place", () =>
    withPage(async (page) => {
      await page.click('#start [data-command="example"]');
      await until(page, () => {
        const { document, binding } = globalThis.espalier.editor;
        return binding !== null && document.poses[0]?.steps?.length > 0 && document.selection.length > 0;
      });
      const { model, points } = await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        return { model: [...editor.models[0].points], points: [...editor.view.points] };
      });
      const moved = model.filter((x, i) => Math.abs(x - points[i]) > 1e-3).length;
      assert.ok(moved > model.length / 4, String(moved));
      assert.ok(await page.isVisible('header [data-command="save model"]'));
    }));

  test("the commands quote every name of a file", () =>
    withPage(async (page) => {
      for (const name of [
        "my model;touch PWNED;.ply",
        "-o.ply",
        "it's $(touch PWNED) `touch PWNED`.ply",
        "# new\ntouch PWNED\n.ply",
      ]) {
        writeFileSync(file(name), plyText());
        await drop(page, { [name]: plyText() });
        await page.waitForFunction(
          (name) => globalThis.espalier.editor.document.models[0]?.name === name,
          name,
        );
        await settled(page);
        await makeBox(page, 2);
        await clickCommand(page, "all");
        await page.evaluate(() =>
          globalThis.espalier.editor.transform({ kind: "move", offset: [1, 0, 0] }),
        );
        runLine(await commandsShown(page));
        const files = readdirSync(folder);
        assert.ok(!files.includes("PWNED"), name);
        assert.ok(files.includes(`${name.slice(0, -4)}-deformed.ply`), files.join());
      }
      // A lattice whose name breaks a line stays a comment.
      runLine("espalier shape box -o plain.vtu --quiet");
      await choose(page, "open lattice", file("plain.vtu"));
      await settled(page);
      await page.evaluate(async () => {
        const { editor } = globalThis.espalier;
        const { bytes } = editor.document.lattice;
        await editor.openLattice({ name: "x\ntouch PWNED\n.vtu", bytes });
      });
      assert.match(await commandsShown(page), /^# x touch PWNED \.vtu is rest\.vtu$/m);
    }));
});
