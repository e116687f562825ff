// SPDX-License-Identifier: Apache-2.0
// Bundles the page into one file: out/espalier.html, with the scripts, the styles, and the library as
// espalier.wasm, compressed.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { defineConfig, type Plugin } from "vite";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));
const core = path("../../build/wasm/web/espalier-core");

/** Puts everything into the page, and writes nothing else. */
function oneFile(): Plugin {
  return {
    name: "one file",
    enforce: "post",
    generateBundle(_, bundle) {
      const page = bundle["index.html"];
      if (page?.type !== "asset") throw new Error("there is no index.html");
      let html = String(page.source);
      const put = (what: RegExp, content: string) => {
        if (!what.test(html)) throw new Error(`index.html has no ${what}`);
        html = html.replace(what, () => content);
      };
      for (const [name, item] of Object.entries(bundle)) {
        if (item === page) continue;
        if (item.type === "chunk") {
          put(new RegExp(`<script[^>]*src="[^"]*${item.fileName}"[^>]*></script>`), "");
          // "</script" inside a text of the script would end it.
          const code = item.code.replaceAll("</script", "<\\/script");
          put(/<\/body>/, `<script type="module">${code}</script>\n</body>`);
        } else if (name.endsWith(".css"))
          put(new RegExp(`<link[^>]*href="[^"]*${name}"[^>]*>`), `<style>${item.source}</style>`);
        else throw new Error(`nothing puts ${name} into the page`);
        delete bundle[name];
      }
      const wasm = gzipSync(readFileSync(`${core}.wasm`), { level: 9 }).toString("base64");
      put(/(?<=id="espalier-wasm">)(?=<\/script>)/, wasm);
      const licences = readFileSync(path("../LICENCES.md"), "utf8");
      put(
        /(?<=id="licences"[^>]*>)(?=<\/pre>)/,
        licences.replace(/[&<]/g, (c) => `&#${c.charCodeAt(0)};`),
      );
      page.source = html;
    },
    writeBundle({ dir }, bundle) {
      const page = bundle["index.html"];
      if (page?.type !== "asset") return;
      mkdirSync(path("../../out"), { recursive: true });
      writeFileSync(path("../../out/espalier.html"), page.source);
      console.log(`out/espalier.html: ${Math.round(page.source.length / 1000)} kB (${dir})`);
    },
  };
}

export default defineConfig({
  root: path("."),
  logLevel: "warn",
  resolve: { alias: { "espalier-core": `${core}.mjs` } },
  // Chromium starts no module workers in pages that are opened from a file.
  worker: { format: "iife" },
  build: {
    outDir: path("../../build/page"),
    emptyOutDir: true,
    target: "es2022",
    modulePreload: false,
    assetsInlineLimit: 1e8,
  },
  plugins: [oneFile()],
});
