// SPDX-License-Identifier: Apache-2.0
// Draws the models, the lattice and its cells with three.js, when something has changed. Knows nothing of
// documents: it gets arrays, and keeps what it needs to draw them and to find what is under the pointer.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Look } from "./appearance.ts";
import { Marks, pointMaterial } from "./dots.ts";
import { attribute, setPositions } from "./geometry.ts";
import { Clay, ModelView } from "./model_view.ts";
import type { BoundaryFace, CellSurface, LatticeShape, ModelPose, ModelShape } from "./protocol.ts";

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

  private readonly clay = new Clay();
  private models: ModelView[] = [];
  /** where the points of the models are shown, one model after the other */
  points: Float32Array = new Float32Array(0);
  /** Whether a model is shown coarsely, so that `points` are where they were before the drag. */
  private isCoarse = false;
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
    for (const object of [this.cells, this.foldedFaces]) object.frustumCulled = false;
    this.faces.visible = false;
    this.cells.renderOrder = 2;
    this.foldedFaces.renderOrder = 3;
    this.scene.add(this.faces, this.cells, this.foldedFaces);
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
    this.clay.plain.color = this.colours.model;
    for (const model of this.models) model.show();
    this.foldedFaces.material.color = this.colours.bad;
    for (const points of this.corners) points.material.uniforms.rim.value = this.colours.panel;
    this.colourMarks();
    this.colourLattice();
    this.rebuildCells();
    this.ask();
  }

  // ---- Models ----------------------------------------------------------------------------------------

  /** Shows models as they are at rest, in clay. */
  setModels(shapes: readonly ModelShape[]): void {
    for (const model of this.models) {
      this.scene.remove(model.object);
      model.dispose();
    }
    this.models = shapes.map(
      ({ points, drawn, coarse }) => new ModelView(points.length / 3, drawn, this.clay, coarse),
    );
    for (const model of this.models) {
      model.setShown(this.shown.materials);
      this.scene.add(model.object);
    }
    this.setOutside(new Uint32Array(0));
    this.setModelPoses(
      shapes.map(({ points }) => ({ points: Float32Array.from(points), isCoarse: false })),
    );
  }

  /** Sets the materials of a model, which are its own from now on. */
  setLook(model: number, materials: Look["materials"]): void {
    this.models[model].setLook(materials);
    this.ask();
  }

  /** Whether a model has materials or colours. */
  get hasLook(): boolean {
    return this.models.some((model) => model.hasLook);
  }

  setModelPoses(poses: readonly ModelPose[]): void {
    this.models.forEach((model, i) => model.setPose(poses[i]));
    this.isCoarse = poses.some((pose) => pose.isCoarse);
    if (!this.isCoarse) {
      this.points = joined(poses.map(({ points }) => points));
      this.around = null;
      for (const marks of Object.values(this.marks)) marks.place(this.points);
    }
    this.ask();
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
    for (const model of this.models) model.setShown(shown.materials);
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
    const { shown } = this;
    for (const { object } of this.models) object.visible = shown.model;
    for (const marks of Object.values(this.marks)) {
      marks.object.visible = shown.model && !this.isCoarse && marks.count > 0;
      marks.object.material.uniforms.scale.value = this.renderer.getPixelRatio();
    }
    for (const object of [...this.lines, ...this.corners]) object.visible = shown.lattice;
    this.cells.visible = shown.cells || shown.cut !== "";
    this.cells.material.opacity = shown.cut ? 0.92 : 0.3;
    this.cells.material.depthWrite = shown.cut !== "";
    this.cells.material.transparent = !shown.cut;
    this.foldedFaces.visible = this.folded.size > 0;
    this.placePlanes();
    const size = this.renderer.getDrawingBufferSize(new THREE.Vector2());
    for (const model of this.models) model.prepare(this.camera, size);
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

  /** The place in space that is seen at a place on the screen, in the plane through a point that faces the eye. */
  placeAt(x: number, y: number, point: THREE.Vector3): THREE.Vector3 {
    const forward = this.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(forward, point);
    return this.rayAt(x, y).ray.intersectPlane(plane, new THREE.Vector3()) ?? point.clone();
  }

  /** The ray through a place on the screen. */
  private rayAt(x: number, y: number): THREE.Raycaster {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    return ray;
  }

  /** Where a ray through a place on the screen meets an object, from front to back. */
  private hits(x: number, y: number, object: THREE.Mesh): THREE.Intersection[] {
    const hits: THREE.Intersection[] = [];
    object.raycast(this.rayAt(x, y), hits);
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

  /** The point of a model that is nearest to the place where the pointer meets a model: its number in `points`. */
  pointAt(x: number, y: number): number | null {
    if (!this.shown.model) return null;
    const ray = this.rayAt(x, y);
    ray.params.Points.threshold = 0.01 * this.size;
    let best: { point: number; distance: number } | null = null;
    let before = 0;
    for (const model of this.models) {
      const found = model.pointAt(ray);
      if (found && !(best && best.distance <= found.distance))
        best = { ...found, point: before + found.point };
      before += model.pointCount;
    }
    return best && best.point;
  }
}

/** Arrays one after the other. */
function joined(parts: readonly Float32Array[]): Float32Array {
  if (parts.length === 1) return parts[0];
  const result = new Float32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let end = 0;
  for (const part of parts) {
    result.set(part, end);
    end += part.length;
  }
  return result;
}
