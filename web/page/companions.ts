// SPDX-License-Identifier: Apache-2.0
// Files that belong to a model: pictures, the .mtl of an .obj, the .bin of a .gltf. They are dropped together with the
// model, or later.

import type { ModelFile, NamedFile } from "./protocol.ts";

const kPictures = [".png", ".jpg", ".jpeg", ".webp", ".gif", ".bmp", ".avif"];
/** Pictures that browsers do not show. */
const kOtherPictures = [".tga", ".dds", ".tif", ".tiff", ".ktx2", ".exr", ".hdr", ".psd"];
export const kCompanions = [".mtl", ".bin", ...kPictures, ...kOtherPictures];

export const extensionOf = (name: string) => name.slice(name.lastIndexOf(".")).toLowerCase();
export const isCompanion = ({ name }: { name: string }) => kCompanions.includes(extensionOf(name));
export const isPicture = ({ name }: { name: string }) => kPictures.includes(extensionOf(name));
export const isGltf = (name: string) => [".glb", ".gltf"].includes(extensionOf(name));

/** The name of a file without its folders, which may be of Windows. */
export const baseName = (path: string) =>
  path.slice(Math.max(path.lastIndexOf("/"), path.lastIndexOf("\\")) + 1);

const simple = (path: string) => path.replaceAll("\\", "/").toLowerCase();

/** The companion that a model names by a path: the one whose path is its end, or whose name is. Capital letters do not
 * count. */
export function companionOf({ companions = [] }: ModelFile, path: string): NamedFile | undefined {
  const wanted = simple(path);
  // An .mtl may have options before the name of a picture.
  const isEnd = (own: string) =>
    wanted === own || wanted.endsWith(`/${own}`) || wanted.endsWith(` ${own}`);
  const byPath = companions.filter(({ name }) => isEnd(simple(name)));
  const named = byPath.length > 0 ? byPath : companions.filter(({ name }) => isEnd(baseName(simple(name))));
  return named.sort((a, b) => b.name.length - a.name.length)[0];
}

const isBuffer = ({ name }: NamedFile) => extensionOf(name) === ".bin";

/** Whether a model has the points of another: the same file, with the same buffers. */
export function hasPointsOf(model: ModelFile, other: ModelFile): boolean {
  const [own, its] = [model, other].map((each) => (each.companions ?? []).filter(isBuffer));
  return (
    model.bytes === other.bytes &&
    own.length === its.length &&
    own.every(({ bytes }) => its.some((each) => each.bytes === bytes))
  );
}

/** A model with more companions. A file replaces a file of the same name. */
export function withCompanions(model: ModelFile, added: readonly NamedFile[]): ModelFile {
  const names = new Set(added.map(({ name }) => name.toLowerCase()));
  const kept = (model.companions ?? []).filter(({ name }) => !names.has(name.toLowerCase()));
  return { ...model, companions: [...kept, ...added] };
}

/** The JSON of a .gltf. A broken one has nothing: the library says what is wrong. */
function jsonOf({ bytes }: NamedFile): { buffers?: ({ uri?: string } | null)[] } | null {
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch {
    return {};
  }
}

/** The files with the points of a .gltf, by the paths that the .gltf has for them.
 * @throws Error that names the files that are missing
 */
export function buffersBeside(model: ModelFile): Record<string, Uint8Array> {
  const found: Record<string, Uint8Array> = {};
  if (extensionOf(model.name) !== ".gltf") return found;
  const missing: string[] = [];
  for (const buffer of [jsonOf(model)?.buffers ?? []].flat()) {
    const uri = buffer?.uri;
    if (typeof uri !== "string" || /^[a-z][a-z\d+.-]*:/i.test(uri)) continue;
    const path = decoded(uri);
    const file = companionOf(model, path);
    if (file) found[path] = file.bytes;
    else missing.push(baseName(path));
  }
  if (missing.length > 0)
    throw new Error(`${model.name} has its points in ${missing.join(", ")}: drop both together`);
  return found;
}

export function decoded(uri: string): string {
  try {
    return decodeURIComponent(uri);
  } catch {
    return uri;
  }
}

/** The extension of the deformed model. A .gltf with its points in another file becomes one file. */
export function takenExtension(model: ModelFile): string {
  const hasBuffers = (model.companions ?? []).some(isBuffer);
  const { name } = model;
  return extensionOf(name) === ".gltf" && hasBuffers ? ".glb" : name.slice(name.lastIndexOf("."));
}
