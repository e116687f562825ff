// SPDX-License-Identifier: Apache-2.0
// Draws Gaussian splats: each as the ellipse that its Gaussian covers on the screen, from the back to the front
// (M. Zwicker, H. Pfister, J. van Baar, M. Gross, "EWA Volume Splatting", 2001).

import * as THREE from "three";

/** Splats in a row of the textures that hold them. */
const kRow = 1024;
/** Depths that the order tells apart. */
const kDepths = 1 << 16;

const kVertexShader = `
  uniform highp sampler2D shapes;
  uniform lowp sampler2D colours;
  uniform vec2 viewport;
  varying vec4 colour;
  varying vec2 place;
  void main() {
    // Each splat has four vertices, without attributes: the corners of a square.
    int i = gl_VertexID / 4;
    int corner = gl_VertexID % 4;
    ivec2 at = ivec2(i % ${kRow}, i / ${kRow});
    colour = texelFetch(colours, at, 0);
    at.x *= 3;
    vec4 a = texelFetch(shapes, at, 0);
    vec4 b = texelFetch(shapes, at + ivec2(1, 0), 0);
    vec4 c = texelFetch(shapes, at + ivec2(2, 0), 0);
    vec3 centre = (modelViewMatrix * vec4(a.xyz, 1.0)).xyz;
    gl_Position = projectionMatrix * vec4(centre, 1.0);

    // The derivative of the place on the screen, in pixels. Beside the screen it would grow without bound.
    vec2 focal = 0.5 * viewport * vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
    mat3 derivative = mat3(focal.x, 0.0, 0.0, 0.0, focal.y, 0.0, 0.0, 0.0, 0.0);
    bool isParallel = projectionMatrix[3][3] == 1.0;
    if (!isParallel) {
      vec2 limit = 1.3 / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
      vec2 slope = clamp(centre.xy / -centre.z, -limit, limit);
      derivative[2].xy = focal * slope;
      derivative /= -centre.z;
    }
    mat3 toScreen = derivative * mat3(modelViewMatrix);
    mat3 covariance = mat3(a.w, b.x, b.y, b.x, b.z, b.w, b.y, b.w, c.x);
    mat3 flat2 = toScreen * covariance * transpose(toScreen);

    // The axes of the ellipse. It is at least a pixel wide.
    float xx = flat2[0][0] + 0.3;
    float xy = flat2[0][1];
    float yy = flat2[1][1] + 0.3;
    float middle = 0.5 * (xx + yy);
    float radius = length(vec2(0.5 * (xx - yy), xy));
    vec2 lengths = sqrt(vec2(middle + radius, max(middle - radius, 0.1)));
    vec2 longer = vec2(xy, middle + radius - xx);
    longer = dot(longer, longer) > 1e-12 ? normalize(longer) : vec2(1.0, 0.0);
    lengths = min(lengths, 1024.0);
    place = 2.8 * vec2(corner == 0 || corner == 3 ? -1.0 : 1.0, corner < 2 ? -1.0 : 1.0);
    vec2 pixels = place.x * lengths.x * longer + place.y * lengths.y * vec2(-longer.y, longer.x);
    gl_Position.xy += 2.0 * pixels / viewport * gl_Position.w;
    if (!isParallel && centre.z >= 0.0) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
  }`;

const kFragmentShader = `
  varying vec4 colour;
  varying vec2 place;
  void main() {
    float opacity = colour.a * exp(-0.5 * dot(place, place));
    if (opacity < 1.0 / 255.0) discard;
    gl_FragColor = vec4(colour.rgb, opacity);
  }`;

export class Splats {
  readonly object: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly count: number;
  private readonly shapes: THREE.DataTexture;
  private readonly colours: THREE.DataTexture;
  private points: Float32Array = new Float32Array(0);
  /** the direction in which the order is from the back to the front */
  private sortedAlong: THREE.Vector3 | null = null;

  /** @param colors red, green and blue in sRGB, and the opacity, of each splat */
  constructor(colors: Float32Array) {
    this.count = colors.length / 4;
    const rows = Math.max(1, Math.ceil(this.count / kRow));
    const bytes = new Uint8Array(4 * kRow * rows);
    colors.forEach((x, i) => (bytes[i] = Math.round(255 * x)));
    this.colours = new THREE.DataTexture(bytes, kRow, rows);
    this.colours.needsUpdate = true;
    const numbers = new Float32Array(12 * kRow * rows);
    this.shapes = new THREE.DataTexture(numbers, 3 * kRow, rows, THREE.RGBAFormat, THREE.FloatType);

    const geometry = new THREE.BufferGeometry();
    const corners = new THREE.BufferAttribute(new Uint32Array(6 * this.count), 1);
    geometry.setIndex(corners.setUsage(THREE.DynamicDrawUsage));
    const material = new THREE.ShaderMaterial({
      uniforms: {
        shapes: { value: this.shapes },
        colours: { value: this.colours },
        viewport: { value: new THREE.Vector2() },
      },
      vertexShader: kVertexShader,
      fragmentShader: kFragmentShader,
      transparent: true,
      depthWrite: false,
    });
    this.object = new THREE.Mesh(geometry, material);
    this.object.frustumCulled = false;
  }

  /** @param covariances xx, xy, xz, yy, yz and zz of each splat */
  setShapes(points: Float32Array, covariances: Float32Array): void {
    const numbers = this.shapes.image.data as Float32Array;
    for (let i = 0; i < this.count; ++i) {
      for (let c = 0; c < 3; ++c) numbers[12 * i + c] = points[3 * i + c];
      for (let c = 0; c < 6; ++c) numbers[12 * i + 3 + c] = covariances[6 * i + c];
    }
    this.shapes.needsUpdate = true;
    this.points = points;
    this.sortedAlong = null;
  }

  /** Prepares the picture of a camera. @param size of the picture in pixels of the device */
  prepare(camera: THREE.Camera, size: THREE.Vector2): void {
    this.object.material.uniforms.viewport.value.copy(size);
    const direction = camera.getWorldDirection(new THREE.Vector3());
    if (this.sortedAlong?.equals(direction)) return;
    this.sortedAlong = direction;
    this.sort(direction);
  }

  /** Sorts by depths in buckets, the farthest first. */
  private sort({ x, y, z }: THREE.Vector3): void {
    const { points, count } = this;
    const depths = new Float32Array(count);
    let least = Infinity;
    let largest = -Infinity;
    for (let i = 0; i < count; ++i) {
      const depth = x * points[3 * i] + y * points[3 * i + 1] + z * points[3 * i + 2];
      depths[i] = depth;
      least = Math.min(least, depth);
      largest = Math.max(largest, depth);
    }
    const scale = (kDepths - 1) / (largest - least || 1);
    const buckets = new Uint16Array(count);
    const ends = new Uint32Array(kDepths);
    for (let i = 0; i < count; ++i) {
      buckets[i] = (largest - depths[i]) * scale;
      ++ends[buckets[i]];
    }
    for (let bucket = 1; bucket < kDepths; ++bucket) ends[bucket] += ends[bucket - 1];
    const index = this.object.geometry.index!;
    for (let i = count - 1; i >= 0; --i) {
      const at = 6 * --ends[buckets[i]];
      // Two triangles.
      index.array[at] = index.array[at + 3] = 4 * i;
      index.array[at + 1] = 4 * i + 1;
      index.array[at + 2] = index.array[at + 4] = 4 * i + 2;
      index.array[at + 5] = 4 * i + 3;
    }
    index.needsUpdate = true;
  }

  dispose(): void {
    this.shapes.dispose();
    this.colours.dispose();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
