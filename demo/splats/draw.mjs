// SPDX-License-Identifier: Apache-2.0
// Draws Gaussian splats by a public viewer in headless Chromium, with WebGL on the processor.
//
//     node draw.mjs '{"width": 400, "height": 600, "position": [...], "target": [...], "up": [...]}' IN.ply OUT.png ...

import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const [viewJson, ...files] = process.argv.slice(2);
const view = JSON.parse(viewJson);
const packages = fileURLToPath(new URL("node_modules/", import.meta.url));

const page = `<!doctype html><meta charset="utf-8">
<style>html, body, #view { margin: 0; width: 100%; height: 100%; background: white }</style>
<div id="view"></div>
<script type="importmap">{"imports": {"three": "/packages/three/build/three.module.js",
  "splats": "/packages/@mkkellogg/gaussian-splats-3d/build/gaussian-splats-3d.module.js"}}</script>
<script type="module">
import * as THREE from "three";
import * as Splats from "splats";
const view = ${JSON.stringify(view)};
const root = document.getElementById("view");
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, antialias: false });
renderer.setSize(view.width, view.height);
renderer.setClearColor(0xffffff, 1);
root.append(renderer.domElement);
const camera = new THREE.PerspectiveCamera(view.angle, view.width / view.height, 0.1, 500);
camera.position.set(...view.position);
camera.up.set(...view.up);
camera.lookAt(...view.target);
camera.updateProjectionMatrix();
const viewer = new Splats.Viewer({ rootElement: root, renderer, camera, selfDrivenMode: false,
  useBuiltInControls: false, sharedMemoryForWorkers: false, gpuAcceleratedSort: false,
  sphericalHarmonicsDegree: 2, sceneRevealMode: Splats.SceneRevealMode.Instant,
  logLevel: Splats.LogLevel.None });
await viewer.addSplatScene("/model.ply", { showLoadingUI: false, progressiveLoad: false,
  splatAlphaRemovalThreshold: 0 });
// The viewer sorts in another thread.
for (let frame = 0; frame < 40; ++frame) {
  viewer.update();
  viewer.render();
  await new Promise((next) => setTimeout(next, 50));
}
document.title = "drawn";
</script>`;

let model;
const server = createServer((request, response) => {
  const path = new URL(request.url, "http://localhost").pathname;
  if (path === "/") return response.setHeader("content-type", "text/html").end(page);
  if (path === "/model.ply") return response.end(model);
  if (!path.startsWith("/packages/")) return response.writeHead(404).end();
  response.setHeader("content-type", "text/javascript");
  response.end(readFileSync(packages + path.slice("/packages/".length)));
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  for (let i = 0; i + 1 < files.length; i += 2) {
    model = readFileSync(files[i]);
    const tab = await browser.newPage({
      viewport: { width: view.width, height: view.height },
    });
    tab.on("pageerror", (error) => console.error(String(error)));
    await tab.goto(`http://127.0.0.1:${server.address().port}/`);
    await tab.waitForFunction(() => document.title === "drawn", null, { timeout: 240_000 });
    await tab.screenshot({ path: files[i + 1] });
    await tab.close();
  }
} finally {
  await browser.close();
  server.close();
}
