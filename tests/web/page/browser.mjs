// SPDX-License-Identifier: Apache-2.0
// Opens out/espalier.html in Debian's Chromium, from the file, for the tests and the pictures.
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

const path = (relative) => fileURLToPath(new URL(relative, import.meta.url));
export const pageFile = path("../../../out/espalier.html");
if (!existsSync(pageFile)) throw new Error(`${pageFile} is missing: run scripts/web first`);
const require = createRequire(path("../../../web/package.json"));
const { chromium } = require("playwright-core");

const kFlags =
  "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking " +
  "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader " +
  "--enable-unsafe-swiftshader";

/** How long to wait for what must happen, in milliseconds: long, for a machine that is busy. */
export const kPatience = 120_000;

export function openBrowser() {
  return chromium.launch({ executablePath: "/usr/bin/chromium", args: kFlags.split(" ") });
}

/** Opens the page in a browser context of its own, which keeps no files of other pages. The window is small, since the
 * processor draws the picture.
 * The time of the tests follows the number of its pixels; below a width of 720 the page has another layout.
 * @param options of playwright-core, such as viewport */
export async function openPage(browser, { file = pageFile, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 760, height: 440 }, ...options });
  context.setDefaultTimeout(kPatience);
  const page = await context.newPage();
  page.errors = [];
  page.on("pageerror", (error) => page.errors.push(String(error)));
  page.on("console", (line) => {
    if (line.type() === "error") page.errors.push(line.text());
  });
  page.on("request", (request) => {
    if (/^(https?|wss?):/.test(request.url()))
      page.errors.push(`the page asks for ${request.url()}`);
  });
  await page.goto(`file://${file}`);
  await page.waitForSelector("html[data-ready]");
  return page;
}

/** Waits until the view shows the document. */
export const settled = (page) =>
  page.evaluate(async () => {
    await globalThis.espalier.editor.update();
    await new Promise(requestAnimationFrame);
  });
