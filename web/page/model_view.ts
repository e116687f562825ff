// SPDX-License-Identifier: Apache-2.0
// Draws one model with three.js: its triangles with their materials, its splats, or its points.

import * as THREE from "three";
import { asSurface, type Look } from "./appearance.ts";
import { attribute, setNormals, setPositions } from "./geometry.ts";
import type { Coarse, DrawnModel, ModelPose } from "./protocol.ts";
import { Splats } from "./splats.ts";

/** Colours for shaders, of colours in sRGB with opacities. */
function linear(colors: Float32Array): Float32Array {
  const result = colors.slice();
  const color = new THREE.Color();
  for (let i = 0; i < result.length; i += 4)
    color.setRGB(colors[i], colors[i + 1], colors[i + 2], THREE.SRGBColorSpace).toArray(result, i);
  return result;
}

/** The materials of models, or of parts of models, that have none of their own. */
export class Clay {
  readonly plain = asSurface(new THREE.MeshStandardMaterial({ roughness: 0.62 }));
  /** with the colours of the points */
  readonly coloured = asSurface(
    new THREE.MeshStandardMaterial({ roughness: 0.62, vertexColors: true }),
  );
}

export class ModelView {
  readonly object = new THREE.Group();
  private readonly mesh: THREE.Mesh<THREE.BufferGeometry, THREE.Material | THREE.Material[]>;
  private readonly cloud: THREE.Points<THREE.BufferGeometry, THREE.PointsMaterial>;
  /** what is shown of a cloud of splats instead of its points */
  private readonly splats: Splats | null;
  /** what is shown during a drag of a large model */
  private readonly coarse: ModelView | null;
  /** the corners of the triangles, as the vertices that have their normals */
  private readonly cornersOfNormals: Uint32Array;
  private materials: Look["materials"] = [];
  private hasMaterials = true;
  private isCoarse = false;

  constructor(
    readonly pointCount: number,
    private readonly drawn: DrawnModel,
    private readonly clay: Clay,
    coarse: Coarse | null = null,
  ) {
    const { triangles, textures, colors, normalsFrom, covariances } = drawn;
    const geometry = new THREE.BufferGeometry();
    if (this.hasFaces) geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    if (textures) attribute(geometry, "uv", textures, 2);
    if (colors) attribute(geometry, "color", linear(colors), 4);
    this.cornersOfNormals =
      normalsFrom.length > 0 ? triangles.map((v) => normalsFrom[v]) : triangles;
    this.mesh = new THREE.Mesh(geometry, clay.plain);
    this.cloud = new THREE.Points(
      geometry,
      new THREE.PointsMaterial({ size: 2, sizeAttenuation: false }),
    );
    this.splats = covariances && colors ? new Splats(colors) : null;
    this.coarse = coarse ? new ModelView(coarse.points.length, coarsened(drawn, coarse), clay) : null;
    for (const object of [this.mesh, this.cloud, this.splats?.object, this.coarse?.object])
      if (object) this.object.add(object);
    this.mesh.frustumCulled = this.cloud.frustumCulled = false;
    this.show();
  }

  /** Sets the materials of the model, which are its own from now on. */
  setLook(materials: Look["materials"]): void {
    this.disposeMaterials();
    this.materials = materials;
    this.show();
  }

  /** Whether the model has materials or colours. */
  get hasLook(): boolean {
    return this.drawn.colors !== null || this.materials.some((material) => material !== null);
  }

  /** Shows materials and colours, or clay. */
  setShown(hasMaterials: boolean): void {
    this.hasMaterials = hasMaterials;
    this.coarse?.setShown(hasMaterials);
    this.show();
  }

  /** Draws the model as it is set; again after the colours of the clay have changed. */
  show(): void {
    const { drawn, mesh, cloud, materials, hasMaterials, isCoarse } = this;
    const hasColours = hasMaterials && drawn.colors !== null;
    const clay = hasColours ? this.clay.coloured : this.clay.plain;
    mesh.geometry.clearGroups();
    mesh.material = clay;
    if (hasMaterials && materials.some((material) => material !== null)) {
      const parts =
        drawn.parts.length > 0 ? drawn.parts : [{ start: 0, count: Infinity, material: 0 }];
      parts.forEach(({ start, count }, i) => mesh.geometry.addGroup(start, count, i));
      mesh.material = parts.map(({ material }) => materials[material] ?? clay);
    }
    cloud.material.color = hasColours ? new THREE.Color(1, 1, 1) : this.clay.plain.color;
    cloud.material.vertexColors = hasColours;
    cloud.material.needsUpdate = true;
    const showsSplats = this.splats !== null && hasMaterials;
    mesh.visible = !isCoarse && this.hasFaces;
    cloud.visible = !isCoarse && !this.hasFaces && !showsSplats;
    if (this.splats) this.splats.object.visible = !isCoarse && showsSplats;
    if (this.coarse) this.coarse.object.visible = isCoarse;
    this.coarse?.show();
  }

  setPose({ points, covariances, isCoarse }: ModelPose): void {
    if (isCoarse !== this.isCoarse) {
      this.isCoarse = isCoarse;
      this.show();
    }
    if (isCoarse) return this.coarse!.setPose({ points, isCoarse: false });
    this.splats?.setShapes(points, covariances ?? this.drawn.covariances!);
    const { geometry } = this.mesh;
    setPositions(geometry, points, this.drawn.copies);
    if (this.hasFaces) setNormals(geometry, this.cornersOfNormals, this.drawn.normalsFrom);
    geometry.boundingSphere = null;
    geometry.boundingBox = null;
  }

  /** Prepares the picture of a camera. @param size of the picture in pixels of the device */
  prepare(camera: THREE.Camera, size: THREE.Vector2): void {
    if (this.splats?.object.visible) this.splats.prepare(camera, size);
  }

  /** The point that is nearest to the place where a ray meets the model, and the distance of the place. Points of a cloud
   * are met within the threshold of the ray. */
  pointAt(ray: THREE.Raycaster): { point: number; distance: number } | null {
    const hits: THREE.Intersection[] = [];
    if (this.hasFaces) this.mesh.raycast(ray, hits);
    else this.cloud.raycast(ray, hits);
    const [found] = hits.sort((a, b) => a.distance - b.distance);
    if (!found) return null;
    if (!found.face) return { point: found.index!, distance: found.distance };
    const { pointCount } = this;
    const { array } = this.mesh.geometry.getAttribute("position");
    const [a, b, c] = [found.face.a, found.face.b, found.face.c].map((v) =>
      v < pointCount ? v : this.drawn.copies[v - pointCount],
    );
    const gap = (point: number) =>
      new THREE.Vector3().fromArray(array, 3 * point).distanceTo(found.point);
    const [point] = [a, b, c].sort((p, q) => gap(p) - gap(q));
    return { point, distance: found.distance };
  }

  private get hasFaces(): boolean {
    return this.drawn.triangles.length > 0;
  }

  private disposeMaterials(): void {
    for (const material of this.materials) {
      for (const map of Object.values(material ?? {}))
        if (map instanceof THREE.Texture) map.dispose();
      material?.dispose();
    }
  }

  dispose(): void {
    this.disposeMaterials();
    this.coarse?.dispose();
    this.splats?.dispose();
    this.mesh.geometry.dispose();
    this.cloud.material.dispose();
  }
}

/** What is drawn of a coarse model: some of the points, with their colours. */
function coarsened({ colors }: DrawnModel, { points, triangles }: Coarse): DrawnModel {
  const colour = (i: number) => colors![4 * points[i >> 2] + (i & 3)];
  return {
    triangles,
    parts: [],
    copies: new Uint32Array(0),
    normalsFrom: new Uint32Array(0),
    textures: null,
    colors: colors && Float32Array.from({ length: 4 * points.length }, (_, i) => colour(i)),
    covariances: null,
  };
}
