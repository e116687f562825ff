// SPDX-License-Identifier: Apache-2.0
// Draws the model, the lattice and its cells with three.js, when something has changed. Knows nothing of
// documents: it gets arrays, and keeps what it needs to draw them and to find what is under the pointer.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { asSurface, type Look } from "./appearance.ts";
import type { BoundaryFace, CellSurface, DrawnModel, LatticeShape } from "./protocol.ts";
import { Splats } from "./splats.ts";

/** What is shown. */
export interface Shown {
  model: boolean;
  /** the materials and the colours of the model; without them it is clay */
  materials: boolean;
  lattice: boolean;
  /** the refined cells of the lattice */
  cells: boolean;
  /** an axis: the cells beyond a plane across it are hidden */
  cut: "" | "x" | "y" | "z";
  /** where the plane is: 0 to 1 across the lattice */
  cutAt: number;
}

const kCornerSize = 9;
const kLineWidth = 1.6;

/** Round points of a size in pixels, each with its colour. */
function pointMaterial(depthTest: boolean): THREE.ShaderMaterial {
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

/** Points of the model that are drawn as dots in front of everything. */
class Marks {
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

function attribute(
  geometry: THREE.BufferGeometry,
  name: string,
  array: Float32Array,
  size: number,
) {
  geometry.setAttribute(name, new THREE.BufferAttribute(array, size));
}

/** Replaces an attribute, or its numbers if there are as many.
 * @param copies the vertices that come once more after the others
 */
function setPositions(
  geometry: THREE.BufferGeometry,
  positions: Float32Array,
  copies: Uint32Array = new Uint32Array(0),
): void {
  const length = positions.length + 3 * copies.length;
  if (geometry.getAttribute("position")?.array.length !== length)
    attribute(geometry, "position", new Float32Array(length), 3);
  const { array } = geometry.getAttribute("position") as THREE.BufferAttribute;
  array.set(positions);
  for (let i = 0, at = positions.length; i < copies.length; ++i, at += 3)
    array.copyWithin(at, 3 * copies[i], 3 * copies[i] + 3);
  geometry.getAttribute("position").needsUpdate = true;
}

/** Colours for shaders, of colours in sRGB with opacities. */
function linear(colors: Float32Array): Float32Array {
  const result = colors.slice();
  const color = new THREE.Color();
  for (let i = 0; i < result.length; i += 4)
    color.setRGB(colors[i], colors[i + 1], colors[i + 2], THREE.SRGBColorSpace).toArray(result, i);
  return result;
}

/** Sets each normal to the mean of the normals of the triangles at the vertex, by their areas.
 * @param from for each vertex the vertex that has its normal; empty if each has its own
 */
function setNormals(
  geometry: THREE.BufferGeometry,
  triangles: Uint32Array,
  from: Uint32Array,
): void {
  const points = geometry.getAttribute("position").array as Float32Array;
  const old = geometry.getAttribute("normal") as THREE.BufferAttribute | undefined;
  if (!old || old.array.length !== points.length)
    attribute(geometry, "normal", new Float32Array(points.length), 3);
  const normal = geometry.getAttribute("normal") as THREE.BufferAttribute;
  const sums = normal.array as Float32Array;
  sums.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const ux = points[b] - points[a];
    const uy = points[b + 1] - points[a + 1];
    const uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a];
    const vy = points[c + 1] - points[a + 1];
    const vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (const at of [a, b, c]) {
      sums[at] += nx;
      sums[at + 1] += ny;
      sums[at + 2] += nz;
    }
  }
  for (let i = 0; i < sums.length; i += 3) {
    const length = Math.hypot(sums[i], sums[i + 1], sums[i + 2]) || 1;
    sums[i] /= length;
    sums[i + 1] /= length;
    sums[i + 2] /= length;
  }
  for (let v = 0; v < from.length; ++v)
    if (from[v] !== v) sums.copyWithin(3 * v, 3 * from[v], 3 * from[v] + 3);
  normal.needsUpdate = true;
}

export class View {
  camera: THREE.PerspectiveCamera | THREE.OrthographicCamera;
  readonly scene = new THREE.Scene();
  controls: OrbitControls;
  /** Called after the camera has turned. */
  onTurn: () => void = () => {};
  readonly canvas: HTMLCanvasElement;
  shown: Shown = {
    model: true,
    materials: true,
    lattice: true,
    cells: false,
    cut: "",
    cutAt: 0.5,
  };

  private readonly perspective = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
  private readonly parallel = new THREE.OrthographicCamera();
  private readonly lights = new THREE.Group();
  private readonly renderer: THREE.WebGLRenderer;
  /** sphere(), until something moves */
  private around: THREE.Sphere | null = null;
  private readonly colours: Record<string, THREE.Color> = {};
  private frameIsAsked = false;

  private readonly clay = asSurface(new THREE.MeshStandardMaterial({ roughness: 0.62 }));
  /** clay with the colours of the points */
  private readonly colouredClay = asSurface(
    new THREE.MeshStandardMaterial({ roughness: 0.62, vertexColors: true }),
  );
  private readonly model: THREE.Mesh<THREE.BufferGeometry, THREE.Material | THREE.Material[]>;
  private readonly cloud: THREE.Points<THREE.BufferGeometry, THREE.PointsMaterial>;
  /** what is shown of a cloud of splats instead of its points */
  private splats: Splats | null = null;
  private drawn: DrawnModel | null = null;
  private pointCount = 0;
  /** the corners of the triangles, as the vertices that have their normals */
  private cornersOfNormals: Uint32Array = new Uint32Array(0);
  private materials: Look["materials"] = [];
  /** dots on the points outside the lattice, on pulled and on pinned points */
  private readonly marks = { outside: new Marks(5), pulls: new Marks(13), pins: new Marks(11) };

  private shape: LatticeShape | null = null;
  private pose: Float64Array = new Float64Array(0);
  private selected = new Set<number>();
  private weights: Float64Array = new Float64Array(0);
  private folded = new Set<number>();
  /** the vertices that are not drawn, and cannot be picked */
  private hidden: ReadonlySet<number> = new Set();
  private lines: LineSegments2[] = [];
  private corners: THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>[] = [];
  private readonly faces: THREE.Mesh;

  private surface: CellSurface | null = null;
  private readonly cells: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  private readonly foldedFaces: THREE.Mesh<THREE.BufferGeometry, THREE.MeshBasicMaterial>;

  constructor(container: HTMLElement) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.canvas = this.renderer.domElement;
    container.append(this.canvas);
    this.camera = this.perspective;
    this.controls = this.newControls();
    this.addLights();

    this.model = new THREE.Mesh(new THREE.BufferGeometry(), this.clay);
    this.cloud = new THREE.Points(
      this.model.geometry,
      new THREE.PointsMaterial({ size: 2, sizeAttenuation: false }),
    );
    this.faces = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }),
    );
    this.cells = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshStandardMaterial({
        roughness: 0.8,
        vertexColors: true,
        flatShading: true,
        transparent: true,
        opacity: 0.3,
        depthWrite: false,
        side: THREE.DoubleSide,
      }),
    );
    this.foldedFaces = new THREE.Mesh(
      new THREE.BufferGeometry(),
      new THREE.MeshBasicMaterial({
        transparent: true,
        opacity: 0.45,
        depthTest: false,
        depthWrite: false,
        side: THREE.DoubleSide,
      }),
    );
    for (const object of [this.model, this.cloud, this.cells, this.foldedFaces])
      object.frustumCulled = false;
    this.faces.visible = false;
    this.cells.renderOrder = 2;
    this.foldedFaces.renderOrder = 3;
    this.scene.add(this.model, this.cloud, this.faces, this.cells, this.foldedFaces);
    for (const { object } of Object.values(this.marks)) this.scene.add(object);

    new ResizeObserver(() => this.resize(container)).observe(container);
    this.resize(container);
    this.readColours();
  }

  private newControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.zoomToCursor = true;
    controls.addEventListener("change", () => this.ask());
    return controls;
  }

  private addLights(): void {
    const light = (intensity: number, x: number, y: number, z: number) => {
      const result = new THREE.DirectionalLight(0xffffff, intensity);
      result.position.set(x, y, z);
      this.lights.add(result, result.target);
    };
    light(1.9, -2, 3, 4);
    light(0.55, 4, 0.5, 2);
    light(0.7, 1, 2, -4);
    this.camera.add(this.lights);
    this.scene.add(this.perspective, this.parallel, new THREE.HemisphereLight(0xffffff, 0x8d8f99, 1.25));
  }

  private resize(container: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = container;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.perspective.aspect = width / height;
    this.perspective.updateProjectionMatrix();
    this.widenParallel();
    for (const line of this.lines) line.material.resolution.set(width, height);
    this.ask();
  }

  /** Takes the colours of the style sheet: again after a change between light and dark. */
  readColours(): void {
    const style = getComputedStyle(document.documentElement);
    for (const name of [
      "model",
      "corner",
      "sharp",
      "surface",
      "inside",
      "accent",
      "warn",
      "bad",
      "panel",
    ])
      this.colours[name] = new THREE.Color(style.getPropertyValue(`--${name}`).trim());
    this.clay.color = this.colours.model;
    this.chooseMaterials();
    this.foldedFaces.material.color = this.colours.bad;
    for (const points of this.corners) points.material.uniforms.rim.value = this.colours.panel;
    this.colourMarks();
    this.colourLattice();
    this.rebuildCells();
    this.ask();
  }

  // ---- Model -----------------------------------------------------------------------------------------

  /** @param drawn null for no model */
  setModel(points: Float32Array, drawn: DrawnModel | null): void {
    const { model, cloud } = this;
    model.geometry.dispose();
    const geometry = (model.geometry = cloud.geometry = new THREE.BufferGeometry());
    this.drawn = drawn;
    this.pointCount = points.length / 3;
    if (drawn) {
      const { triangles, textures, colors, normalsFrom } = drawn;
      if (triangles.length > 0) geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
      if (textures) attribute(geometry, "uv", textures, 2);
      if (colors) attribute(geometry, "color", linear(colors), 4);
      this.cornersOfNormals =
        normalsFrom.length > 0 ? triangles.map((v) => normalsFrom[v]) : triangles;
    }
    this.setSplats(drawn?.covariances && drawn.colors ? new Splats(drawn.colors) : null);
    this.setOutside(new Uint32Array(0));
    this.setLook([]);
    this.setPoints(points);
  }

  /** Sets the materials of the model, which are its own from now on. */
  setLook(materials: Look["materials"]): void {
    for (const material of this.materials) {
      for (const map of Object.values(material ?? {}))
        if (map instanceof THREE.Texture) map.dispose();
      material?.dispose();
    }
    this.materials = materials;
    this.chooseMaterials();
    this.ask();
  }

  /** Whether the model has materials or colours. */
  get hasLook(): boolean {
    return Boolean(this.drawn?.colors) || this.materials.some((material) => material !== null);
  }

  private chooseMaterials(): void {
    const { drawn, model, cloud, materials } = this;
    const hasColours = this.shown.materials && Boolean(drawn?.colors);
    const clay = hasColours ? this.colouredClay : this.clay;
    model.geometry.clearGroups();
    model.material = clay;
    if (drawn && this.shown.materials && materials.some((material) => material !== null)) {
      const parts =
        drawn.parts.length > 0 ? drawn.parts : [{ start: 0, count: Infinity, material: 0 }];
      parts.forEach(({ start, count }, i) => model.geometry.addGroup(start, count, i));
      model.material = parts.map(({ material }) => materials[material] ?? clay);
    }
    cloud.material.color = hasColours ? new THREE.Color(1, 1, 1) : this.colours.model;
    cloud.material.vertexColors = hasColours;
    cloud.material.needsUpdate = true;
  }

  private setSplats(splats: Splats | null): void {
    if (this.splats) this.scene.remove(this.splats.object);
    this.splats?.dispose();
    this.splats = splats;
    if (splats) this.scene.add(splats.object);
  }

  /** @param covariances of splats; as at rest if they are missing */
  setPoints(points: Float32Array, covariances = this.drawn?.covariances): void {
    this.splats?.setShapes(points, covariances!);
    const { geometry } = this.model;
    setPositions(geometry, points, this.drawn?.copies);
    if (this.hasFaces) setNormals(geometry, this.cornersOfNormals, this.drawn!.normalsFrom);
    geometry.boundingSphere = null;
    geometry.boundingBox = null;
    this.around = null;
    for (const marks of Object.values(this.marks)) marks.place(points);
    this.ask();
  }

  private get hasFaces(): boolean {
    return this.drawn !== null && this.drawn.triangles.length > 0;
  }

  /** The points of the model that are shown. */
  get points(): Float32Array {
    const position = this.model.geometry.getAttribute("position");
    return position
      ? (position.array as Float32Array).subarray(0, 3 * this.pointCount)
      : new Float32Array(0);
  }

  setOutside(points: Uint32Array): void {
    this.marks.outside.set(points, this.points);
    this.colourMarks();
    this.ask();
  }

  /** Marks points of the model that are pulled, and points that are pinned. */
  setMarks(pulls: readonly number[], pins: readonly number[]): void {
    this.marks.pulls.set(pulls, this.points);
    this.marks.pins.set(pins, this.points);
    this.colourMarks();
    this.ask();
  }

  private colourMarks(): void {
    const { warn, accent, sharp, panel } = this.colours;
    this.marks.outside.colour(warn, warn);
    this.marks.pulls.colour(accent, panel);
    this.marks.pins.colour(sharp, panel);
  }

  // ---- Lattice ---------------------------------------------------------------------------------------

  setLattice(shape: LatticeShape | null): void {
    for (const object of [...this.lines, ...this.corners]) {
      this.scene.remove(object);
      object.geometry.dispose();
      object.material.dispose();
    }
    this.lines = [];
    this.corners = [];
    this.shape = shape;
    this.folded.clear();
    this.hidden = new Set();
    this.setSurface(null);
    this.pose = new Float64Array(0);
    this.around = null;
    if (!shape) return;
    const vertexCount = shape.positions.length / 3;
    this.weights = new Float64Array(vertexCount);
    const lines = new LineSegmentsGeometry();
    lines.setPositions(new Float32Array(3 * shape.edges.length));
    lines.setColors(new Float32Array(3 * shape.edges.length));
    const corners = new THREE.BufferGeometry();
    attribute(corners, "color", new Float32Array(3 * vertexCount), 3);
    attribute(corners, "size", new Float32Array(vertexCount), 1);
    // First a faint copy that the model does not hide.
    for (const front of [false, true]) {
      const line = new LineSegments2(
        lines,
        new LineMaterial({
          linewidth: kLineWidth,
          vertexColors: true,
          transparent: true,
          opacity: front ? 1 : 0.22,
          depthTest: front,
          depthWrite: false,
        }),
      );
      line.material.resolution.set(this.canvas.clientWidth, this.canvas.clientHeight);
      const points = new THREE.Points(corners, pointMaterial(front));
      points.material.uniforms.opacity.value = front ? 1 : 0.35;
      points.material.uniforms.scale.value = this.renderer.getPixelRatio();
      points.material.uniforms.rim.value = this.colours.panel;
      line.renderOrder = front ? 4 : 1;
      points.renderOrder = front ? 5 : 1;
      line.frustumCulled = points.frustumCulled = false;
      this.lines.push(line);
      this.corners.push(points);
      this.scene.add(line, points);
    }
    const triangles = shape.boundary.flatMap(({ vertices }) =>
      vertices.slice(2).flatMap((v, i) => [vertices[0], vertices[i + 1], v]),
    );
    this.faces.geometry.dispose();
    this.faces.geometry = new THREE.BufferGeometry().setIndex(triangles);
    this.setPose(shape.positions);
    this.colourLattice();
  }

  setPose(positions: Float64Array): void {
    if (!this.shape) return;
    this.pose = positions;
    this.around = null;
    const single = Float32Array.from(positions);
    setPositions(this.corners[0].geometry, single);
    setPositions(this.faces.geometry, single);
    this.faces.geometry.boundingSphere = null;
    const ends = this.lines[0].geometry.getAttribute(
      "instanceStart",
    ) as THREE.InterleavedBufferAttribute;
    const { edges } = this.shape;
    edges.forEach((v, i) => {
      // An edge with a hidden end gets the length 0.
      const isHidden = this.hidden.has(v) || this.hidden.has(edges[i ^ 1]);
      const end = isHidden ? edges[i & ~1] : v;
      ends.data.array.set(single.subarray(3 * end, 3 * end + 3), 3 * i);
    });
    ends.data.needsUpdate = true;
    if (this.shown.cut) this.rebuildCells();
    this.ask();
  }

  get hidesVertices(): boolean {
    return this.hidden.size > 0;
  }

  /** Hides some vertices, and the edges at them; all others are shown. */
  hide(vertices: Iterable<number>): void {
    this.hidden = new Set(vertices);
    this.setPose(this.pose);
    this.colourLattice();
  }

  setSelection(selection: readonly number[], weights: Float64Array): void {
    this.selected = new Set(selection);
    this.weights = weights;
    this.colourLattice();
    this.ask();
  }

  private colourLattice(): void {
    if (!this.shape) return;
    const { edges, edgeStrata, vertexStrata } = this.shape;
    const byStratum = ["corner", "sharp", "surface", "inside"].map((name) => this.colours[name]);
    const accent = this.colours.accent;
    const mixed = new THREE.Color();
    const shade = (stratum: number, weight: number) =>
      mixed.copy(byStratum[stratum]).lerp(accent, weight);

    const geometry = this.corners[0].geometry;
    const colours = geometry.getAttribute("color");
    const sizes = geometry.getAttribute("size");
    vertexStrata.forEach((stratum, v) => {
      shade(stratum, this.weights[v] ?? 0).toArray(colours.array, 3 * v);
      const size = this.selected.has(v) ? kCornerSize + 4 : stratum === 3 ? 7 : kCornerSize;
      sizes.array[v] = this.hidden.has(v) ? 0 : size;
    });
    colours.needsUpdate = sizes.needsUpdate = true;

    const starts = this.lines[0].geometry.getAttribute(
      "instanceColorStart",
    ) as THREE.InterleavedBufferAttribute;
    edgeStrata.forEach((stratum, edge) => {
      for (let end = 0; end < 2; ++end) {
        const weight = this.weights[edges[2 * edge + end]] ?? 0;
        shade(stratum, weight).toArray(starts.data.array, 6 * edge + 3 * end);
      }
    });
    starts.data.needsUpdate = true;
  }

  // ---- Cells -----------------------------------------------------------------------------------------

  setSurface(surface: CellSurface | null): void {
    this.surface = surface;
    this.rebuildCells();
  }

  setSurfacePositions(positions: Float32Array): void {
    setPositions(this.cells.geometry, positions);
    this.foldedFaces.geometry.setAttribute(
      "position",
      this.cells.geometry.getAttribute("position"),
    );
    this.ask();
  }

  setFolded(cells: number[]): void {
    this.folded = new Set(cells);
    this.rebuildCells();
    this.ask();
  }

  setShown(shown: Shown): void {
    this.shown = shown;
    this.chooseMaterials();
    this.rebuildCells();
    this.ask();
  }

  /** Chooses the faces of cells to draw: faces between a cell that is shown and one that is not. */
  private rebuildCells(): void {
    const { cells, foldedFaces } = this;
    if (!this.surface || !this.shape) {
      cells.geometry.setIndex([]);
      foldedFaces.geometry.setIndex([]);
      return;
    }
    const { quads, sides, vertexCount } = this.surface;
    const hidden = this.shape.cells.map((vertices) => this.isCutAway(vertices));
    const isShown = (cell: number) => cell >= 0 && !hidden[cell];
    const index: number[] = [];
    const bad: number[] = [];
    if (!cells.geometry.getAttribute("position"))
      this.setSurfacePositions(new Float32Array(3 * vertexCount));
    const colours = new Float32Array(3 * vertexCount);
    const boundary = this.colours.surface.clone().lerp(this.colours.panel, 0.25);
    const inside = this.colours.inside.clone().lerp(this.colours.panel, 0.35);
    for (let face = 0; face < quads.length / 4; ++face) {
      const [behind, front] = [sides[2 * face], sides[2 * face + 1]];
      const [a, b, c, d] = quads.subarray(4 * face, 4 * face + 4);
      const triangles = [a, b, c, a, c, d];
      if (isShown(behind) !== isShown(front)) {
        index.push(...triangles);
        const colour = isShown(behind) && front < 0 ? boundary : inside;
        for (const v of [a, b, c, d]) colour.toArray(colours, 3 * v);
      }
      if (this.folded.has(behind) !== this.folded.has(front)) bad.push(...triangles);
    }
    cells.geometry.setIndex(index);
    attribute(cells.geometry, "color", colours, 3);
    foldedFaces.geometry.setIndex(bad);
  }

  private isCutAway(vertices: Int32Array): boolean {
    if (!this.shown.cut) return false;
    const axis = ["x", "y", "z"].indexOf(this.shown.cut);
    let sum = 0;
    for (const v of vertices) sum += this.pose[3 * v + axis];
    return sum / vertices.length > this.cutPlace(axis);
  }

  private cutPlace(axis: number): number {
    const { min, max } = this.bounds();
    const [low, high] = [min.getComponent(axis), max.getComponent(axis)];
    return low + this.shown.cutAt * (high - low);
  }

  // ---- Camera and drawing ------------------------------------------------------------------------------

  get isParallel(): boolean {
    return this.camera === this.parallel;
  }

  /** Draws parallel lines as parallel, or farther things smaller. */
  setParallel(isParallel: boolean): void {
    if (isParallel === this.isParallel) return;
    const { position, quaternion, up } = this.camera;
    const { target } = this.controls;
    const other = isParallel ? this.parallel : this.perspective;
    if (!isParallel) {
      // As near as a perspective must be to show as much.
      const from = position.clone().sub(target);
      position.copy(target).addScaledVector(from, 1 / this.parallel.zoom);
    }
    other.position.copy(position);
    other.quaternion.copy(quaternion);
    other.up.copy(up);
    this.camera = other;
    other.add(this.lights);
    this.parallel.zoom = 1;
    this.replaceControls(target);
    this.widenParallel();
  }

  /** The axis that points up on the screen. */
  get up(): "y" | "z" {
    return this.camera.up.z === 1 ? "z" : "y";
  }

  set up(axis: "y" | "z") {
    this.camera.up.set(0, axis === "y" ? 1 : 0, axis === "z" ? 1 : 0);
    this.replaceControls(this.controls.target);
    this.look();
  }

  /** Controls read which axis is up, and which camera they turn, when they are made. */
  private replaceControls(target: THREE.Vector3): void {
    this.controls.dispose();
    this.controls = this.newControls();
    this.controls.target.copy(target);
    this.controls.update();
    this.ask();
  }

  /** Gives the parallel camera the height that the perspective has at the target. */
  private widenParallel(): void {
    if (!this.isParallel) return;
    const { aspect, fov } = this.perspective;
    const distance = this.parallel.position.distanceTo(this.controls.target);
    const half = distance * Math.tan((fov * Math.PI) / 360);
    const { parallel } = this;
    [parallel.left, parallel.right] = [-half * aspect, half * aspect];
    [parallel.top, parallel.bottom] = [half, -half];
    parallel.updateProjectionMatrix();
  }

  /** The box around the lattice at rest, or around the model without a lattice. */
  private bounds(): THREE.Box3 {
    const box = new THREE.Box3();
    if (this.shape) return box.setFromArray(this.shape.positions as unknown as number[]);
    return this.points.length > 0
      ? box.setFromArray(this.points as unknown as number[])
      : box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  }

  get size(): number {
    return this.bounds().getSize(new THREE.Vector3()).length() || 1;
  }

  /** A sphere around all that is shown. */
  private sphere(): THREE.Sphere {
    if (this.around) return this.around;
    const box = this.bounds();
    for (const shown of [this.points, this.pose])
      if (shown.length > 0)
        box.union(new THREE.Box3().setFromArray(shown as unknown as number[]));
    return (this.around = box.getBoundingSphere(new THREE.Sphere()));
  }

  /** Looks at everything from a direction: by default from the front, the right and above. */
  look(from?: THREE.Vector3): void {
    const standard = this.up === "y" ? [0.75, 0.42, 1] : [0.75, -1, 0.42];
    const direction = from?.clone() ?? new THREE.Vector3().fromArray(standard);
    const { center, radius } = this.sphere();
    const angle = (this.perspective.fov * Math.PI) / 360;
    const narrow = Math.min(1, this.perspective.aspect);
    const distance = (1.04 * Math.max(radius, 1e-9)) / (Math.sin(angle) * narrow);
    this.camera.position.copy(center).addScaledVector(direction.normalize(), distance);
    this.parallel.zoom = 1;
    this.controls.target.copy(center);
    this.widenParallel();
    this.controls.update();
    this.ask();
  }

  /** Puts the near and the far plane of the camera around all that is shown. */
  private placePlanes(): void {
    const { center, radius } = this.sphere();
    const distance = this.camera.position.distanceTo(center);
    const reach = 1.5 * Math.max(radius, 1e-9);
    this.camera.far = distance + reach;
    this.camera.near = this.isParallel
      ? distance - reach
      : Math.max(distance - reach, (distance + reach) / 5000);
    this.camera.updateProjectionMatrix();
  }

  /** Draws soon: once, however often it is asked. */
  ask(): void {
    if (this.frameIsAsked) return;
    this.frameIsAsked = true;
    requestAnimationFrame(() => this.draw());
  }

  draw(): void {
    this.frameIsAsked = false;
    const { shown, hasFaces } = this;
    this.model.visible = shown.model && hasFaces;
    const hasSplats = this.splats !== null && shown.materials;
    this.cloud.visible = shown.model && !hasFaces && !hasSplats && this.points.length > 0;
    if (this.splats) this.splats.object.visible = shown.model && hasSplats;
    for (const marks of Object.values(this.marks)) {
      marks.object.visible = shown.model && marks.count > 0;
      marks.object.material.uniforms.scale.value = this.renderer.getPixelRatio();
    }
    for (const object of [...this.lines, ...this.corners]) object.visible = shown.lattice;
    this.cells.visible = shown.cells || shown.cut !== "";
    this.cells.material.opacity = shown.cut ? 0.92 : 0.3;
    this.cells.material.depthWrite = shown.cut !== "";
    this.cells.material.transparent = !shown.cut;
    this.foldedFaces.visible = this.folded.size > 0;
    this.placePlanes();
    if (this.splats?.object.visible)
      this.splats.prepare(this.camera, this.renderer.getDrawingBufferSize(new THREE.Vector2()));
    this.renderer.render(this.scene, this.camera);
    this.onTurn();
  }

  /** The picture on the screen, as a .png file. */
  picture(): Promise<Blob> {
    this.draw();
    return new Promise((resolve, reject) =>
      this.canvas.toBlob((blob) =>
        blob ? resolve(blob) : reject(new Error("the browser made no picture")),
      ),
    );
  }

  // ---- Under the pointer -------------------------------------------------------------------------------

  /** Where a vertex is on the screen, in CSS pixels from the corner of the canvas. */
  screenOf(vertex: number): { x: number; y: number; depth: number } {
    const p = new THREE.Vector3().fromArray(this.pose, 3 * vertex).project(this.camera);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return { x: ((p.x + 1) / 2) * width, y: ((1 - p.y) / 2) * height, depth: p.z };
  }

  /** The vertex at a place on the screen: the nearest to the eye within a distance. */
  vertexAt(x: number, y: number, within: number): number | null {
    if (!this.shape) return null;
    let best: number | null = null;
    let least = Infinity;
    for (let v = 0; v < this.pose.length / 3; ++v) {
      const at = this.screenOf(v);
      const gap = Math.hypot(at.x - x, at.y - y);
      if (gap > within || Math.abs(at.depth) > 1 || this.hidden.has(v)) continue;
      // A pixel farther away counts as much as a thousandth of the depth.
      const cost = gap + 1000 * at.depth;
      if (cost < least) [best, least] = [v, cost];
    }
    return best;
  }

  /** The vertices in an area of the screen; all of them, or those that no face of the lattice hides. */
  verticesIn(isInside: (x: number, y: number) => boolean, onlyFront: boolean): number[] {
    const result: number[] = [];
    for (let v = 0; v < this.pose.length / 3; ++v) {
      const { x, y, depth } = this.screenOf(v);
      if (this.hidden.has(v) || Math.abs(depth) > 1 || !isInside(x, y)) continue;
      if (!onlyFront || !this.isBehindFace(v, x, y)) result.push(v);
    }
    return result;
  }

  private isBehindFace(vertex: number, x: number, y: number): boolean {
    const [hit] = this.hits(x, y, this.faces);
    if (!hit) return false;
    const at = new THREE.Vector3().fromArray(this.pose, 3 * vertex);
    // The faces at the vertex meet the ray there, up to the rounding of floats.
    const forward = this.camera.getWorldDirection(new THREE.Vector3());
    return hit.point.clone().sub(at).dot(forward) < -1e-3 * this.size;
  }

  /** Where a ray through a place on the screen meets an object, from front to back. */
  private hits(x: number, y: number, object: THREE.Mesh): THREE.Intersection[] {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    const hits: THREE.Intersection[] = [];
    object.raycast(ray, hits);
    return hits.sort((a, b) => a.distance - b.distance);
  }

  faceAt(x: number, y: number): BoundaryFace | null {
    if (!this.shape) return null;
    for (const { faceIndex } of this.hits(x, y, this.faces)) {
      let triangle = faceIndex!;
      const face = this.shape.boundary.find(({ vertices }) => {
        triangle -= vertices.length - 2;
        return triangle < 0;
      });
      if (face && !face.vertices.some((v) => this.hidden.has(v))) return face;
    }
    return null;
  }

  /** The point of the model that is nearest to the place where the pointer meets it. */
  pointAt(x: number, y: number): number | null {
    const [found] = this.hasFaces ? this.hits(x, y, this.model) : [];
    if (!found?.face) return null;
    const { pointCount } = this;
    const [a, b, c] = [found.face.a, found.face.b, found.face.c].map((v) =>
      v < pointCount ? v : this.drawn!.copies[v - pointCount],
    );
    const gap = (point: number) =>
      new THREE.Vector3().fromArray(this.points, 3 * point).distanceTo(found.point);
    return [a, b, c].sort((p, q) => gap(p) - gap(q))[0];
  }
}
