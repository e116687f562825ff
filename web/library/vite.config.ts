// SPDX-License-Identifier: Apache-2.0
// Bundles the package: espalier.js, of the classes and of emscripten's loader.
import { copyFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));
const core = path("../../build/wasm/web/espalier-core");
const out = path("../../out/espalier-npm");

export default defineConfig({
  root: path("."),
  logLevel: "warn",
  resolve: { alias: { "espalier-core": `${core}.mjs` } },
  build: {
    outDir: out,
    emptyOutDir: true,
    target: "es2022",
    lib: { entry: path("espalier.ts"), formats: ["es"], fileName: () => "espalier.js" },
    rolldownOptions: { external: [/^node:/] },
  },
  plugins: [
    {
      name: "files of the package",
      closeBundle() {
        copyFileSync(`${core}.wasm`, `${out}/espalier.wasm`);
        copyFileSync(path("package.json"), `${out}/package.json`);
        copyFileSync(path("../README.md"), `${out}/README.md`);
        copyFileSync(path("../../LICENSE"), `${out}/LICENSE`);
        copyFileSync(path("../LICENCES.md"), `${out}/LICENCES.md`);
      },
    },
  ],
});
