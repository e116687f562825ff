// SPDX-License-Identifier: Apache-2.0
// Makes the materials of a model from its file and its companions, by the loaders of three.js.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MTLLoader } from "three/addons/loaders/MTLLoader.js";
import { baseName, companionOf, decoded, extensionOf, isGltf, isPicture } from "./companions.ts";
import type { ModelFile, ModelShape } from "./protocol.ts";

/** How a model looks. */
export interface Look {
  /** for each material of the model; null for clay */
  materials: (THREE.Material | null)[];
  /** names what is not shown, each with a number */
  notes: string[];
}

/** A picture that a model names. Without content it is missing. */
interface Picture {
  name: string;
  content?: Blob;
}

/** The loader of the pictures of a model, which the loaders of three.js use. */
class Pictures extends THREE.Loader<THREE.Texture> {
  readonly missing = new Set<string>();
  readonly unreadable = new Set<string>();
  private readonly loading: Promise<void>[] = [];

  constructor(private readonly find: (path: string) => Picture) {
    super(new THREE.LoadingManager());
    this.manager.addHandler(/(?:)/, this);
  }

  /** Calls `onLoad` even if there is no such picture. The texture then has the mark `userData.isAbsent`. */
  override load(path: string, onLoad?: (texture: THREE.Texture) => void): THREE.Texture {
    const { name, content } = this.find(path);
    const absent = (list: Set<string>, texture: THREE.Texture) => {
      list.add(name);
      texture.userData.isAbsent = true;
      onLoad?.(texture);
      return texture;
    };
    if (!content) return absent(this.missing, new THREE.Texture());
    const url = URL.createObjectURL(content);
    let ended = () => {};
    this.loading.push(new Promise((resolve) => (ended = resolve)));
    const texture = new THREE.TextureLoader().load(
      url,
      (loaded) => {
        onLoad?.(loaded);
        ended();
      },
      undefined,
      () => {
        absent(this.unreadable, texture);
        ended();
      },
    );
    void this.loaded().then(() => URL.revokeObjectURL(url));
    return texture;
  }

  async loaded(): Promise<void> {
    await Promise.all(this.loading);
  }
}

const blobOf = (bytes: Uint8Array, type?: string) => new Blob([bytes as BlobPart], { type });

/** The picture that a model names by a path. */
function pictureOf(file: ModelFile, path: string): Picture {
  const found = companionOf(file, path);
  return found && isPicture(found)
    ? { name: found.name, content: blobOf(found.bytes) }
    : { name: baseName(path) };
}

export async function lookOf(file: ModelFile, shape: ModelShape): Promise<Look> {
  const notes: string[] = [];
  const materials = isGltf(file.name)
    ? await gltfMaterials(file, shape.materials.length, notes)
    : await mtlMaterials(file, shape, notes);
  let secondSets = 0;
  for (const material of materials)
    if (material) secondSets += prepare(material, shape, isGltf(file.name));
  if (secondSets > 0)
    notes.push(
      `${areMany(secondSets, "texture")} not shown: by a second set of texture coordinates`,
    );
  return { materials, notes };
}

/** "1 texture of a.mtl is", "3 textures of a.mtl are". */
const areMany = (count: number, one: string) =>
  count === 1 ? `1 ${one} is` : `${count} ${one.replace(/^\w+/, "$&s")} are`;

/** Adapts a material to the page. Returns the number of textures that are left out. */
function prepare(material: THREE.Material, { drawn }: ModelShape, isGltf: boolean): number {
  const maps = material as unknown as Record<string, THREE.Texture | null>;
  const standard = material as THREE.MeshStandardMaterial & THREE.MeshPhongMaterial;
  let secondSets = 0;
  for (const [name, map] of Object.entries(maps)) {
    if (!(map instanceof THREE.Texture)) continue;
    if (map.channel > 0) ++secondSets;
    if (map.channel === 0 && !map.userData.isAbsent && drawn.textures) continue;
    maps[name] = null;
    if (name === "emissiveMap") standard.emissive.set(0);
  }
  // A metal mirrors a room, and would be black without. The light of a room takes seconds to prepare on a processor.
  if (standard.isMeshStandardMaterial) standard.metalness *= 0.4;
  // A displacement would move the surface away from the points.
  if (standard.displacementMap) standard.displacementMap = null;
  // A highlight without an end covers all of the surface.
  if (standard.shininess === 0) standard.specular.set(0);
  // three.js reads "Tr 1" as invisible, and some programs write it for opaque.
  if (material.opacity === 0) material.opacity = 1;
  // glTF multiplies a texture by the colours of the points. In other files both are the same colour.
  material.vertexColors = drawn.colors !== null && (isGltf || !standard.map);
  asSurface(material);
  return secondSets;
}

/** Lets a material show both sides, and the lattice in front of it. */
export function asSurface<Type extends THREE.Material>(material: Type): Type {
  material.side = THREE.DoubleSide;
  material.polygonOffset = true;
  material.polygonOffsetFactor = 1;
  material.polygonOffsetUnits = 1;
  return material;
}

function noteAbsent(pictures: Pictures, from: string, notes: string[]): void {
  const { missing, unreadable } = pictures;
  const others = [...missing].filter((name) => !isPicture({ name }) && name.includes("."));
  const here = [...missing].filter((name) => !others.includes(name));
  if (here.length > 0)
    notes.push(
      `${areMany(here.length, `texture of ${from}`)} not here: drop ${listed(here)} together with the model`,
    );
  const unknown = [...others, ...unreadable];
  if (unknown.length > 0)
    notes.push(
      `${areMany(unknown.length, `texture of ${from}`)} not shown: browsers do not know ${listed(unknown)}`,
    );
}

const listed = (names: string[]) =>
  names.length > 4
    ? `${names.slice(0, 3).join(", ")} and ${names.length - 3} more`
    : names.join(", ");

// ---- OBJ and others ----------------------------------------------------------------------------------------

/** Materials of .mtl files. Without one, a picture that is the only one is the texture. */
async function mtlMaterials(
  file: ModelFile,
  { materials: names, drawn }: ModelShape,
  notes: string[],
): Promise<(THREE.Material | null)[]> {
  const { companions = [] } = file;
  const libraries = companions.filter(({ name }) => extensionOf(name) === ".mtl");
  const pictures = new Pictures((path) => pictureOf(file, path));
  if (libraries.length === 0) {
    const [only, ...others] = companions.filter(isPicture);
    if (only && others.length === 0 && drawn.textures) {
      const map = pictures.load(only.name);
      map.colorSpace = THREE.SRGBColorSpace;
      map.wrapS = map.wrapT = THREE.RepeatWrapping;
      await pictures.loaded();
      noteAbsent(pictures, file.name, notes);
      return (names.length > 0 ? names : [""]).map(() => new THREE.MeshPhongMaterial({ map }));
    }
    if (names.length > 0)
      notes.push(
        `${areMany(names.length, `material of ${file.name}`)} not here: drop its .mtl and its pictures together with it`,
      );
    return names.map(() => null);
  }
  const creators = libraries.map(({ bytes }) =>
    // MTLLoader knows no tabs.
    new MTLLoader(pictures.manager).parse(
      new TextDecoder().decode(bytes).replaceAll("\t", " "),
      "",
    ),
  );
  const materials = names.map((name) => {
    const creator = creators.find(({ materialsInfo }) => Object.hasOwn(materialsInfo, name));
    return creator?.create(name) ?? null;
  });
  await pictures.loaded();
  noteAbsent(pictures, libraries.map(({ name }) => name).join(", "), notes);
  const unknown = names.filter((_, i) => !materials[i]);
  if (unknown.length > 0)
    notes.push(
      `${areMany(unknown.length, `material of ${file.name}`)} in no .mtl: ${listed(unknown)}`,
    );
  return materials;
}

// ---- glTF --------------------------------------------------------------------------------------------------

interface GltfMaterial {
  pbrMetallicRoughness?: unknown;
  extensions?: {
    KHR_materials_pbrSpecularGlossiness?: {
      diffuseFactor?: number[];
      diffuseTexture?: unknown;
      glossinessFactor?: number;
    };
  };
}

interface GltfJson {
  asset: unknown;
  materials?: GltfMaterial[];
  textures?: { source?: number; extensions?: Record<string, { source?: number }> }[];
  samplers?: unknown[];
  images?: { uri?: string; bufferView?: number; mimeType?: string; name?: string }[];
  buffers?: { uri?: string }[];
  bufferViews?: { buffer: number; byteOffset?: number; byteLength: number }[];
  extensionsUsed?: string[];
}

/** The JSON of a glTF file, and the first binary chunk of a .glb. */
function gltfParts({ name, bytes }: ModelFile): { json: GltfJson; binary: Uint8Array } {
  const text = (part: Uint8Array) => JSON.parse(new TextDecoder().decode(part)) as GltfJson;
  if (extensionOf(name) === ".gltf") return { json: text(bytes), binary: new Uint8Array(0) };
  // A header of 12 bytes, then chunks: the length, the type, the content.
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const end = 20 + view.getUint32(12, true);
  const hasBinary = bytes.length >= end + 8;
  const length = hasBinary ? view.getUint32(end, true) : 0;
  return { json: text(bytes.subarray(20, end)), binary: bytes.subarray(end + 8, end + 8 + length) };
}

/** The bytes of a URI "data:…;base64,…". */
const bytesOfData = (uri: string) =>
  Uint8Array.from(atob(decoded(uri.slice(uri.indexOf(",") + 1))), (c) => c.charCodeAt(0));

/** The materials of a glTF file by GLTFLoader, which gets a file without meshes. */
async function gltfMaterials(
  file: ModelFile,
  count: number,
  notes: string[],
): Promise<(THREE.Material | null)[]> {
  if (count === 0) return [];
  const { json, binary } = gltfParts(file);
  const images = json.images ?? [];
  const bufferOf = (index: number) => {
    const { uri } = json.buffers![index];
    if (uri === undefined) return binary;
    return uri.startsWith("data:") ? bytesOfData(uri) : companionOf(file, decoded(uri))?.bytes;
  };
  const pictures = new Pictures((path) => {
    const index = Number(path);
    const { uri, bufferView, mimeType, name = `picture ${index}` } = images[index] ?? {};
    if (uri?.startsWith("data:")) return { name, content: blobOf(bytesOfData(uri)) };
    if (uri !== undefined) return pictureOf(file, decoded(uri));
    if (bufferView === undefined) return { name };
    const { buffer, byteOffset: begin = 0, byteLength } = json.bufferViews![bufferView];
    const part = bufferOf(buffer)?.subarray(begin, begin + byteLength);
    return { name, content: part && blobOf(part, mimeType) };
  });
  const { asset, textures = [], samplers, extensionsUsed = [] } = json;
  const alone = {
    asset,
    materials: json.materials!.map(withoutSpecularGlossiness),
    // A texture without a picture names one that is not there.
    textures: textures.map(({ extensions = {}, ...texture }) => {
      const {
        EXT_texture_webp: webp,
        EXT_texture_avif: avif,
        KHR_texture_basisu: basis,
      } = extensions;
      const source = (webp ?? avif)?.source ?? texture.source ?? basis?.source ?? images.length;
      return { ...texture, source };
    }),
    samplers,
    images: [...images.keys(), images.length].map((i) => ({ uri: String(i) })),
    extensionsUsed: extensionsUsed.filter((name) =>
      /^KHR_(materials_|texture_transform)/.test(name),
    ),
  };
  const { parser } = await new GLTFLoader(pictures.manager).parseAsync(JSON.stringify(alone), "");
  const result: THREE.Material[] = await parser.getDependencies("material");
  await pictures.loaded();
  noteAbsent(pictures, file.name, notes);
  return result;
}

/** A material of older files with its colour, in the form that GLTFLoader knows. */
function withoutSpecularGlossiness(material: GltfMaterial): GltfMaterial {
  const old = material.extensions?.KHR_materials_pbrSpecularGlossiness;
  if (!old || material.pbrMetallicRoughness) return material;
  const pbrMetallicRoughness = {
    baseColorFactor: old.diffuseFactor,
    baseColorTexture: old.diffuseTexture,
    metallicFactor: 0,
    roughnessFactor: 1 - (old.glossinessFactor ?? 1),
  };
  return { ...material, pbrMetallicRoughness };
}
