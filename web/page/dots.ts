// SPDX-License-Identifier: Apache-2.0
// Draws points as round dots: the vertices of the lattice, and marks on points of models.

import * as THREE from "three";
import { attribute, setPositions } from "./geometry.ts";

/** Round points of a size in pixels, each with its colour. */
export function pointMaterial(depthTest: boolean): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: { scale: { value: 1 }, opacity: { value: 1 }, rim: { value: new THREE.Color() } },
    vertexShader: `
      attribute float size;
      attribute vec3 color;
      uniform float scale;
      varying vec3 shade;
      varying float pixels;
      void main() {
        shade = color;
        pixels = size * scale;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= 2e-4 * gl_Position.w;
        gl_PointSize = pixels;
      }`,
    fragmentShader: `
      uniform float opacity;
      uniform vec3 rim;
      varying vec3 shade;
      varying float pixels;
      void main() {
        float radius = length(gl_PointCoord - 0.5) * pixels;
        float inside = 1.0 - smoothstep(0.5 * pixels - 1.2, 0.5 * pixels - 0.2, radius);
        float core = 1.0 - smoothstep(0.5 * pixels - 2.6, 0.5 * pixels - 1.6, radius);
        if (inside <= 0.0) discard;
        gl_FragColor = vec4(mix(rim, shade, core), opacity * inside);
        #include <colorspace_fragment>
      }`,
    transparent: true,
    depthTest,
    depthWrite: false,
  });
}

/** Points of models that are drawn as dots in front of everything. */
export class Marks {
  readonly object = new THREE.Points(new THREE.BufferGeometry(), pointMaterial(false));
  private points: ArrayLike<number> = [];

  constructor(private readonly size: number) {
    this.object.frustumCulled = false;
    this.object.renderOrder = 6;
  }

  get count(): number {
    return this.points.length;
  }

  set(points: ArrayLike<number>, from: Float32Array): void {
    this.points = points;
    this.object.geometry.dispose();
    this.object.geometry = new THREE.BufferGeometry();
    attribute(this.object.geometry, "size", new Float32Array(points.length).fill(this.size), 1);
    this.place(from);
  }

  /** @param rim around each dot */
  colour(colour: THREE.Color, rim: THREE.Color): void {
    const colours = new Float32Array(3 * this.count);
    for (let i = 0; i < this.count; ++i) colour.toArray(colours, 3 * i);
    attribute(this.object.geometry, "color", colours, 3);
    this.object.material.uniforms.rim.value = rim;
  }

  place(from: Float32Array): void {
    const positions = new Float32Array(3 * this.count);
    for (let i = 0; i < this.count; ++i)
      positions.set(from.subarray(3 * this.points[i], 3 * this.points[i] + 3), 3 * i);
    setPositions(this.object.geometry, positions);
  }
}
