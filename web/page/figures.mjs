// SPDX-License-Identifier: Apache-2.0
// Draws docs/figures/page.png and page-dark.png: the page, with a dog that looks up.
//     node web/page/figures.mjs [FOLDER]
import { fileURLToPath } from "node:url";
import { openBrowser, openPage, settled } from "../../tests/web/page/browser.mjs";

const folder = process.argv[2] ?? fileURLToPath(new URL("../../docs/figures", import.meta.url));
const browser = await openBrowser();
const page = await openPage(browser, { viewport: { width: 1280, height: 800 } });
await page.selectOption('[data-choice="example"]', "dog");
await page.waitForFunction(() => globalThis.espalier.editor.models.length > 0);
await page.click('[data-form="cage"] button');
await page.waitForFunction(() => globalThis.espalier.editor.binding, null, { timeout: 60_000 });
await page.evaluate(async () => {
  const { editor } = globalThis.espalier;
  const { positions } = editor;
  const isHead = (v) => positions[3 * v] > 0.62 && positions[3 * v + 1] > 0.95;
  const vertices = [...Array(positions.length / 3).keys()];
  await editor.select(vertices.filter(isHead));
  await editor.transform({ kind: "rotate", axis: "z", degrees: 24 });
  await editor.transform({ kind: "move", offset: [0.1, 0.22, 0] });
  await editor.change({ poses: [{ ...editor.document.poses[0], name: "Looks up" }] });
});
await settled(page);
await page.screenshot({ path: `${folder}/page.png` });

await page.click('[data-command="theme"]');
await page.evaluate(async () => {
  const { editor } = globalThis.espalier;
  await editor.setShown({ ...editor.view.shown, cut: "z", cutAt: 0.55 });
});
await settled(page);
await page.screenshot({ path: `${folder}/page-dark.png` });
await browser.close();
