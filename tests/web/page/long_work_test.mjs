// SPDX-License-Identifier: Apache-2.0
// Pages with files in them, work that takes long, and memory.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { pageFile, settled } from "./browser.mjs";
import {
  clickVertex,
  compareWithProgram,
  documentNow,
  dragHandles,
  file,
  makeCage,
  openExample,
  plyText,
  run,
  until,
  withPage,
} from "./person.mjs";

describe("sent, cancelled, opened many times", () => {
  test("a page of espalier page opens the files in it", async () => {
    const corners = ["--min", "-1", "-1", "-1", "--max", "2", "2", "2"];
    run("shape", "box", "--cells", "2", "2", "2", ...corners, "-o", file("inside-rest.vtu"));
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
      await page.fill('[data-form="cage"] [name="vertices"]', "60");
      await makeCage(page);
      const start = await documentNow(page);
      // A cage has irregular cells, in which level 14 takes seconds.
      await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        void editor.change({ settings: { ...editor.document.settings, level: 14 } });
      });
      await page.waitForSelector("#busy:not([hidden])");
      await page.click('[data-command="cancel"]');
      await settled(page);
      assert.deepEqual(await documentNow(page), start);
      await clickVertex(page, 5);
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
          await editor.openModels([{ name: `${i}.obj`, bytes: bytes.slice() }]);
          await editor.makeLattice({ kind: "around", options: { cellsAlongLongest: 3 } }, "");
          await editor.change({ models: [], lattice: null, poses: [], time: 0, selection: [] });
          sizes.push(await editor.engine.run("memory"));
        }
        return sizes;
      });
      assert.equal(sizes[49], sizes[4], sizes.join(" "));
    }));
});
