// SPDX-License-Identifier: Apache-2.0
// Times the library in Chromium and natively, one after the other, and prints a table with the ratios. Both have one
// thread. Build first: scripts/web; scripts/build release espalier_c
//
//   node bench/speed.mjs [POINTS...]
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const root = fileURLToPath(new URL("../..", import.meta.url));
const library = process.env.ESPALIER_LIBRARY ?? join(root, "build/release/c"); // folder of libespalier.so
const counts = process.argv.length > 2 ? process.argv.slice(2).map(Number) : [100000, 1000000];

/** Does in the page what speed.c does: the milliseconds, the least of several runs. */
async function inBrowser({ script, wasm, count }) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const url = URL.createObjectURL(new Blob([bytes(script)], { type: "text/javascript" }));
  const { load } = await import(url);
  const espalier = await load(bytes(wasm));
  if (!crossOriginIsolated) throw new Error("the clock of the page is coarse");
  const result = { points: count };
  const few = count > 200000 ? 2 : 5;
  const many = count > 200000 ? 40 : 200;
  const least = (name, runs, work) => {
    result[name] = Infinity;
    for (let run = 0; run < runs; ++run) {
      const start = performance.now();
      const made = work();
      result[name] = Math.min(result[name], performance.now() - start);
      if (run < runs - 1) made?.free?.();
      else return made;
    }
  };
  const lattice = espalier.box([4, 4, 4], [0, 0, 0], [1, 1, 1]);
  const rest = lattice.positions();
  const refiner = lattice.refiner();
  const points = new Float64Array(3 * count);
  for (let i = 0, state = 1; i < points.length; ++i) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    points[i] = 0.02 + (0.96 * state) / 4294967296;
  }
  const pose = Float32Array.from(rest);
  const binding = least("bind", few, () => refiner.bind(rest, points));
  const deformer = least("compile", few, () => binding.deformer());
  // As a page does: the result is copied into an array of JavaScript.
  const moved = new Float32Array(3 * count);
  least("pose", many, () => void deformer.deform(pose, moved));
  least("drag", many, () => void deformer.deformChanged(pose, [62], moved));
  return result;
}

const folder = mkdtempSync(join(tmpdir(), "espalier-speed-"));
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"],
});
try {
  const native = join(folder, "speed");
  execFileSync("cc", [
    ...["-O2", "-std=gnu11", `-I${root}/c`, join(root, "web/bench/speed.c"), "-o", native],
    ...[`-L${library}`, `-Wl,-rpath,${library}`, "-lespalier"],
  ]);
  const base64 = (name) => readFileSync(join(root, "out/espalier-npm", name)).toString("base64");
  console.log("| points | work | native | Chromium | ratio |\n|---:|---|---:|---:|---:|");
  for (const count of counts) {
    const page = await browser.newPage();
    // An isolated page has a clock with steps of 5 µs instead of 0.1 ms.
    await page.route("http://localhost/", (route) =>
      route.fulfill({
        contentType: "text/html",
        body: "",
        headers: {
          "Cross-Origin-Opener-Policy": "same-origin",
          "Cross-Origin-Embedder-Policy": "require-corp",
        },
      }),
    );
    await page.goto("http://localhost/");
    const chrome = await page.evaluate(inBrowser, {
      script: base64("espalier.js"),
      wasm: base64("espalier.wasm"),
      count,
    });
    await page.close();
    const here = JSON.parse(execFileSync(native, [String(count)], { encoding: "utf8" }));
    for (const work of ["bind", "compile", "pose", "drag"]) {
      const ratio = (chrome[work] / here[work]).toFixed(2);
      console.log(
        `| ${count} | ${work} | ${here[work].toFixed(2)} ms | ${chrome[work].toFixed(2)} ms | ${ratio} |`,
      );
    }
  }
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
