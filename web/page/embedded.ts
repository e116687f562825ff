// SPDX-License-Identifier: Apache-2.0
// Files inside a page: `espalier page` puts them there, and so does this page when it is taken home.

import type { Editor } from "./editor.ts";
import type { BindSettings, ModelFile, NamedFile, Rules } from "./protocol.ts";

interface EmbeddedFile {
  name: string;
  /** in base64 */
  data: string;
}

/** The content of the element #espalier-files. */
export interface EmbeddedFiles {
  version: 1;
  /** files that belong to models */
  companions?: EmbeddedFile[];
  /** with the numbers of their companions */
  models?: (EmbeddedFile & { companions?: number[] })[];
  rest?: EmbeddedFile & { command?: string | null };
  poses?: (EmbeddedFile & { steps?: readonly string[] | null })[];
  options?: Partial<BindSettings> & { rules?: Rules };
}

/** The page as it was loaded: this module runs before anything changes it. */
const kPage = document.documentElement.outerHTML;

const kElement = '<script type="application/json" id="espalier-files">';

export const bytesOf = (base64: string): Uint8Array<ArrayBuffer> =>
  Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

function base64Of(bytes: Uint8Array): string {
  // Browsers limit the number of arguments.
  const kMost = 0x8000;
  let text = "";
  for (let i = 0; i < bytes.length; i += kMost)
    text += String.fromCharCode(...bytes.subarray(i, i + kMost));
  return btoa(text);
}

const encoded = ({ name, bytes }: NamedFile): EmbeddedFile => ({ name, data: base64Of(bytes) });
const decoded = ({ name, data }: EmbeddedFile): NamedFile => ({ name, bytes: bytesOf(data) });

/** The files in this page; null if there are none. */
export function embeddedFiles(): EmbeddedFiles | null {
  const text = document.querySelector("#espalier-files")!.textContent!.trim();
  return text === "" ? null : JSON.parse(text);
}

/** The name under which the browser keeps the work: a page that was sent has its own, since all pages that are opened
 * from files share what the browser keeps. */
export function nameOfWork(): string {
  const text = document.querySelector("#espalier-files")!.textContent!.trim();
  if (text === "") return "last";
  let hash = 0;
  for (let i = 0; i < text.length; ++i) hash = (Math.imul(hash, 31) + text.charCodeAt(i)) | 0;
  return `sent ${text.length} ${hash}`;
}

/** Opens the files as the document that undo goes back to. */
export async function openEmbedded(editor: Editor, files: EmbeddedFiles): Promise<void> {
  const { models = [], rest, poses = [], options = {} } = files;
  const { rules, ...settings } = options;
  const { document } = editor;
  await editor.change({
    settings: { ...document.settings, ...settings },
    rules: rules ?? document.rules,
  });
  const companions = (files.companions ?? []).map(decoded);
  await editor.openModels(
    models.map(({ companions: own, ...file }): ModelFile => ({
      ...decoded(file),
      ...(own && { companions: own.map((i) => companions[i]) }),
    })),
  );
  if (rest) await editor.openLattice(decoded(rest), rest.command ?? undefined);
  for (const pose of poses) await editor.openLatticeOrPose(decoded(pose));
  if (poses.length > 0) {
    // The pose that a new lattice begins with is not one of them.
    const own = editor.document.poses.slice(1);
    await editor.change({
      poses: own.map((pose, i) => ({ ...pose, steps: poses[i].steps ?? null })),
      time: own.length,
    });
  }
  await editor.restart(editor.document);
}

/** This page with the models, the lattice and the poses of the editor inside. */
export async function pageWith(editor: Editor): Promise<Blob> {
  const { models, lattice, poses, settings, rules } = editor.document;
  const files: EmbeddedFiles = { version: 1, options: { ...settings, rules } };
  const all = [...new Set(models.flatMap(({ companions = [] }) => companions))];
  files.companions = all.map(encoded);
  files.models = models.map(({ companions, ...file }) => ({
    ...encoded(file),
    ...(companions && { companions: companions.map((each) => all.indexOf(each)) }),
  }));
  if (lattice) {
    files.rest = {
      ...encoded({ name: "rest.vtu", bytes: lattice.bytes }),
      command: lattice.command,
    };
    files.poses = [];
    for (const { name, positions, steps } of poses) {
      const bytes = await editor.write({ kind: "lattice", positions, extension: ".vtu" });
      files.poses.push({ ...encoded({ name: `${name}.vtu`, bytes }), steps });
    }
  }
  const start = kPage.indexOf(kElement) + kElement.length;
  const end = kPage.indexOf("</script>", start);
  // "<" could end the element.
  const text = JSON.stringify(files).replaceAll("<", "\\u003c");
  const parts = ["<!doctype html>\n", kPage.slice(0, start), text, kPage.slice(end)];
  return new Blob(parts, { type: "text/html" });
}
