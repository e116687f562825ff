// SPDX-License-Identifier: Apache-2.0
// Models: files with points that a lattice deforms.

import { countPoints, integer, numbers } from "./arguments.ts";
import { Handle, type CLibrary } from "./c_library.ts";
import { doublesAt, floatsAt, integersAt, longAt, longsAt, textAt } from "./memory.ts";

/** Faces and their corners: face f has corners[offsets[f]] to corners[offsets[f + 1] - 1]. */
export interface Polygons {
  offsets: Int32Array;
  corners: Int32Array;
}

/** How a model looks. An array is null if the file has none of its kind. Corners are the corners of Model.faces(). */
export interface Appearance {
  /** u and v, with v upwards, of each pair of texture coordinates */
  textures: Float64Array | null;
  /** for each corner the number of its pair */
  textureCorners: Int32Array | null;
  /** three numbers for each normal */
  normals: Float64Array | null;
  /** for each corner the number of its normal; null if there is a normal for each point */
  normalCorners: Int32Array | null;
  /** for each point red, green and blue as screens show them (sRGB), and the opacity: 0 to 1 */
  colors: Float32Array | null;
  /** for each point the covariance xx, xy, xz, yy, yz and zz of its Gaussian splat */
  covariances: Float32Array | null;
  /** names: of an .obj in the order of their first use; of glTF of all materials, which may be empty */
  materials: string[];
  /** for each face the number of its material, or -1 */
  faceMaterials: Int32Array | null;
}

/** A file with points that a lattice deforms. */
export class Model extends Handle {
  constructor(
    library: CLibrary,
    pointer: number,
    /** with which it is written, such as ".obj" */
    readonly extension: string,
  ) {
    super(library, pointer, "model");
  }

  /** Three numbers for each point, in the order of the file. */
  points(): Float64Array {
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call("espalier_model_points", this.address, out, out + 4);
      const [count, points] = integersAt(this.library.core, out, 2);
      return doublesAt(this.library.core, points, 3 * count);
    });
  }

  faces(): Polygons {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(16);
      this.library.call("espalier_model_faces", this.address, out);
      const [offsetsAt, cornersAt] = integersAt(core, out + 8, 2);
      const offsets = longsAt(core, offsetsAt, longAt(core, out) + 1);
      return { offsets, corners: integersAt(core, cornersAt, offsets[offsets.length - 1]) };
    });
  }

  /** Texture coordinates, normals, colours and names of materials. */
  appearance(): Appearance {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(44);
      this.library.call("espalier_model_appearance", this.address, out);
      const { pointCount, faceCount, cornerCount } = this.counts();
      // The fields of espalier_appearance: counts and pointers, 4 bytes each.
      const [
        textureCount,
        textures,
        textureCorners,
        normalCount,
        normals,
        normalCorners,
        ...others
      ] = integersAt(core, out, 11);
      const [colors, covariances, materialCount, materials, faceMaterials] = others;
      const integersOrNull = (at: number, count: number) =>
        at === 0 ? null : integersAt(core, at, count);
      return {
        textures: textures === 0 ? null : doublesAt(core, textures, 2 * textureCount),
        textureCorners: integersOrNull(textureCorners, cornerCount),
        normals: normals === 0 ? null : doublesAt(core, normals, 3 * normalCount),
        normalCorners: integersOrNull(normalCorners, cornerCount),
        colors: colors === 0 ? null : floatsAt(core, colors, 4 * pointCount),
        covariances: covariances === 0 ? null : floatsAt(core, covariances, 6 * pointCount),
        materials: this.texts(materials, materialCount),
        faceMaterials: integersOrNull(faceMaterials, faceCount),
      };
    });
  }

  private counts() {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const [points, faces] = [scope.allocate(8), scope.allocate(16)];
      this.library.call("espalier_model_points", this.address, points, points + 4);
      this.library.call("espalier_model_faces", this.address, faces);
      const faceCount = longAt(core, faces);
      const [offsets] = integersAt(core, faces + 8, 1);
      return {
        pointCount: integersAt(core, points, 1)[0],
        faceCount,
        cornerCount: longAt(core, offsets + 8 * faceCount),
      };
    });
  }

  private texts(at: number, count: number): string[] {
    const { core } = this.library;
    return Array.from(integersAt(core, at, count), (pointer) => textAt(core, pointer));
  }

  /** Names parts of the file that were skipped, or are kept without being understood; empty if there
   * are none. */
  notes(): string {
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      this.library.call("espalier_model_notes", this.address, out);
      return textAt(this.library.core, integersAt(this.library.core, out, 1)[0]);
    });
  }

  /** The names of the numbers at the points that weights() takes. */
  attributes(): string[] {
    return this.names("espalier_model_attributes");
  }

  /** The names of the groups, objects, meshes, nodes and materials that weights() takes. */
  groups(): string[] {
    return this.names("espalier_model_groups");
  }

  private names(call: string): string[] {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(8);
      this.library.call(call, this.address, out, out + 4);
      const [count, pointers] = integersAt(core, out, 2);
      return this.texts(pointers, count);
    });
  }

  /** The weights of the points of a part of the model, for Refiner.bind().
   * @param pointCount number of points of the model
   * @param attribute the name of an attribute of 0 to 1; empty for weights of 1
   * @param groups the points in none of these groups get the weight 0; empty for the whole model
   */
  weights(pointCount: number, attribute: string, groups: string[] = []): Float64Array {
    const { core } = this.library;
    return this.library.scoped((scope) => {
      const out = scope.allocate(8 * integer("pointCount", pointCount));
      const list = scope.allocate(4 * groups.length);
      groups.forEach((group, i) => (core.HEAP32[list / 4 + i] = scope.text(group)));
      this.library.call(
        "espalier_model_weights",
        this.address,
        attribute === "" ? 0 : scope.text(attribute),
        groups.length,
        list,
        pointCount,
        out,
      );
      return doublesAt(core, out, pointCount);
    });
  }

  /** The slopes of weights along the faces of the model: three numbers for each point. */
  weightSlopes(weights: Float64Array): Float64Array {
    const count = numbers("weights", weights).length;
    return this.library.scoped((scope) => {
      const out = scope.allocate(24 * count);
      this.library.call(
        "espalier_model_weight_slopes",
        this.address,
        count,
        scope.doubles(weights),
        out,
      );
      return doublesAt(this.library.core, out, 3 * count);
    });
  }

  hasDirections(): boolean {
    return this.library.scoped((scope) => {
      const out = scope.allocate(4);
      this.library.call("espalier_model_has_directions", this.address, out);
      return this.library.core.HEAP32[out / 4] !== 0;
    });
  }

  /** The file with new points. Without a change of points, the file that was read.
   * @param gradients nine numbers for each point, which carry normals, tangents and splats
   * @param extension of a format of models, to which the file is converted. A .gltf whose .bin is beside it is one
   *   file as ".glb"
   */
  write(points: Float64Array, gradients?: Float64Array, extension = this.extension): Uint8Array {
    const count = countPoints("points", points);
    if (gradients !== undefined) numbers("gradients", gradients, 9 * count);
    return this.library.file(extension, (path) =>
      this.library.scoped((scope) =>
        this.library.call(
          "espalier_model_write",
          this.address,
          scope.text(path),
          count,
          scope.doubles(points),
          gradients ? scope.doubles(gradients) : 0,
        ),
      ),
    );
  }
}
