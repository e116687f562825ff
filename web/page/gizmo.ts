// SPDX-License-Identifier: Apache-2.0
// The handles with which the selected vertices are moved, turned and scaled, and a point of the model is
// pulled.

import * as THREE from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Point } from "../library/espalier.ts";
import type { Document } from "./document.ts";
import type { Editor } from "./editor.ts";
import type { Axis, Transform } from "./protocol.ts";
import { centerOf, kAxes, type Weights } from "./transforms.ts";

export type Mode = "translate" | "rotate" | "scale";

/** The cosine of 20 degrees: nearer to the direction of the eye, handles cannot be told from their middle. */
const kEndOn = Math.cos(THREE.MathUtils.degToRad(20));

interface Start {
  /** A drag ends without an edit if the document is another one by then: after undo, say. */
  readonly document: Document;
  readonly positions: Float64Array;
  readonly weights: Weights;
  readonly mode: Mode;
  readonly matrix: THREE.Matrix4;
}

export class Gizmo {
  mode: Mode = "translate";
  /** Whether points of the model are pulled instead of vertices. */
  isPulling = false;
  /** the points of the model that are pulled together */
  pulls: readonly number[] = [];
  /** the points of the model that pulls leave where they are */
  pins: readonly number[] = [];

  /** the only axis of the handles; null for all three */
  axis: Axis | null = null;

  /** Whether the handles move in steps: lengths of a power of ten near a fiftieth of the lattice, 15 degrees, and
   * tenths. */
  isSnapping = false;

  private readonly controls: TransformControls;
  private readonly handle = new THREE.Object3D();
  /** the drag: what it began with */
  private start: Start | null = null;
  private latest: Float64Array | null = null;
  /** as in Pulled, of the last frame */
  private heldBack = 0;
  /** the frames of a drag that are being shown */
  private following: Promise<void> | null = null;
  private isStale = false;
  private isDragging = false;

  constructor(private readonly editor: Editor) {
    const { view } = editor;
    this.controls = new TransformControls(view.camera, view.canvas);
    this.controls.setSize(0.8);
    view.scene.add(this.handle, this.controls.getHelper());
    this.controls.addEventListener("change", () => view.ask());
    this.controls.addEventListener("dragging-changed", ({ value }) => {
      view.controls.enabled = !value;
      if (value) this.begin();
      else this.end();
    });
    this.controls.addEventListener("objectChange", () => this.drag());
    // A handle that points at the eye, or away from it, would move along a line that nobody sees.
    const hover = this.controls.pointerHover.bind(this.controls);
    this.controls.pointerHover = (pointer) => {
      hover(pointer);
      const axis = this.controls.axis?.toLowerCase() as Axis;
      if (this.controls.mode !== "rotate" && kAxes.includes(axis) && this.isEndOn(axis))
        this.controls.axis = this.axis === null ? "XYZ" : null;
    };
  }

  private isEndOn(axis: Axis): boolean {
    const { camera, isParallel } = this.editor.view;
    const toHandle = isParallel
      ? camera.getWorldDirection(new THREE.Vector3())
      : this.handle.position.clone().sub(camera.position).normalize();
    return Math.abs(toHandle.getComponent(kAxes.indexOf(axis))) > kEndOn;
  }

  private placeSteps(): void {
    const { isSnapping, controls } = this;
    const length = 10 ** Math.round(Math.log10(this.editor.view.size / 50));
    controls.setTranslationSnap(isSnapping ? length : null);
    controls.setRotationSnap(isSnapping ? THREE.MathUtils.degToRad(15) : null);
    controls.setScaleSnap(isSnapping ? 0.1 : null);
  }

  /** Whether a drag on a handle moves the selection. */
  set isEnabled(isEnabled: boolean) {
    this.controls.enabled = isEnabled && this.start === null;
  }

  /** Whether the pointer is on a handle, or drags it. */
  get isUsed(): boolean {
    return this.isDragging || this.controls.axis !== null;
  }

  /** Puts the handles where the selection is, or hides them. */
  place(): void {
    if (this.start) return;
    const { document, view, binding } = this.editor;
    const isThere = (point: number) => point < view.points.length / 3;
    if (!binding) this.isPulling = false;
    if (!binding || ![...this.pulls, ...this.pins].every(isThere)) this.pulls = this.pins = [];
    if (this.isPulling) view.setMarks(this.pulls, this.pins);
    else view.setMarks([], []);
    const hasSelection = document.lattice !== null && document.selection.length > 0;
    if (this.isPulling ? this.pulls.length === 0 : !hasSelection) {
      this.controls.detach();
      view.ask();
      return;
    }
    const center = this.isPulling
      ? centerOf(Float64Array.from(this.pulls.flatMap((point) => placeOf(view.points, point))))
      : this.editor.pivotPoint;
    this.handle.position.fromArray(center);
    this.handle.rotation.set(0, 0, 0);
    this.handle.scale.set(1, 1, 1);
    this.handle.updateMatrixWorld();
    this.controls.setMode(this.isPulling ? "translate" : this.mode);
    this.controls.camera = view.camera;
    for (const axis of kAxes)
      this.controls[`show${axis.toUpperCase() as "X" | "Y" | "Z"}`] = [null, axis].includes(this.axis);
    this.placeSteps();
    this.controls.attach(this.handle);
    view.ask();
  }

  /** Whether no drag goes on, or is being ended. */
  get isIdle(): boolean {
    return this.start === null;
  }

  /** Pulls a point from now on to where the pointer is: moveTo() and end() follow. */
  beginPull(point: number): void {
    this.pulls = [point];
    this.pins = this.pins.filter((pin) => pin !== point);
    this.place();
    this.begin();
  }

  /** Moves the handles to a place on the screen, as far from the eye as they were. */
  moveTo(x: number, y: number): void {
    this.handle.position.copy(this.editor.view.placeAt(x, y, this.handle.position));
    this.drag();
  }

  private begin(): void {
    this.isDragging = true;
    this.handle.updateMatrix();
    const { document, positions } = this.editor;
    const weights = this.editor.weights();
    this.start = { document, positions, weights, mode: this.mode, matrix: this.handle.matrix.clone() };
    this.latest = null;
  }

  /** Follows the handles: one frame after the other, always to where they are now. */
  private drag(): void {
    this.isStale = true;
    if (this.start) this.following ??= this.follow().finally(() => (this.following = null));
  }

  private async follow(): Promise<void> {
    while (this.isStale && this.start?.document === this.editor.document) {
      this.isStale = false;
      await this.editor.attempt(async () => {
        this.latest = await this.moved();
        if (this.isDragging) await this.editor.preview(this.latest);
      });
    }
  }

  /** The positions that follow from where the handles are now. */
  private moved(): Promise<Float64Array> {
    this.handle.updateMatrix();
    if (this.isPulling) return this.pulled();
    const { positions, weights } = this.start!;
    return this.editor.transformed(positions, weights.values, this.transforms());
  }

  private offset(): Point {
    const from = new THREE.Vector3().setFromMatrixPosition(this.start!.matrix);
    return this.handle.position.clone().sub(from).toArray();
  }

  private async pulled(): Promise<Float64Array> {
    const { editor, pins } = this;
    const { positions } = this.start!;
    const by = this.offset();
    const pulls = this.pulls.map((point) => ({ point, by }));
    const { isDragging } = this;
    const { movesHeld } = editor;
    const result = await editor.engine.run(
      "pull",
      pulls,
      [...pins],
      positions,
      movesHeld,
      isDragging,
    );
    this.heldBack = result.heldBack;
    if (editor.mirrorAxis === null) return result.positions;
    const weights = this.weightsOfPulledSide(kAxes.indexOf(editor.mirrorAxis));
    return editor.transformed(result.positions, weights, editor.withMirror([]));
  }

  /** Weights of 1 for the vertices that are nearer to the pulled points than their mirror images are. */
  private weightsOfPulledSide(axis: number): Float64Array {
    const { editor } = this;
    const rest = editor.document.lattice!.positions;
    const middle = centerOf(rest)[axis];
    const pulled = centerOf(Float64Array.from(this.pulls.flatMap((point) => editor.restOf(point))));
    const side = Math.sign(pulled[axis] - middle) || 1;
    const isOnSide = (v: number) => side * (rest[3 * v + axis] - middle) >= -1e-3 * editor.view.size;
    return Float64Array.from({ length: rest.length / 3 }, (_, v) => (isOnSide(v) ? 1 : 0));
  }

  /** The operations of the program that do what the handles have done. */
  private transforms(): Transform[] {
    return this.editor.withMirror(this.ownTransforms());
  }

  private ownTransforms(): Transform[] {
    const { handle } = this;
    const { scale } = handle;
    switch (this.start!.mode) {
      case "translate":
        return [{ kind: "move", offset: this.offset() }];
      case "scale":
        return [{ kind: "scale", factors: scale.toArray(), center: handle.position.toArray() }];
      case "rotate": {
        // About x, then y, then z. The first turn moves the middle of the selection, so all name it.
        const center = this.handle.position.toArray();
        const { x, y, z } = new THREE.Euler().setFromQuaternion(this.handle.quaternion, "ZYX");
        return kAxes
          .map((axis, i): Transform => {
            const degrees = THREE.MathUtils.radToDeg([x, y, z][i]);
            return { kind: "rotate", axis, degrees, center };
          })
          .filter((turn) => turn.kind === "rotate" && Math.abs(turn.degrees) > 1e-12);
      }
    }
  }

  async end(): Promise<void> {
    this.isDragging = false;
    const { start } = this;
    if (!start) return;
    this.handle.updateMatrix();
    if (this.handle.matrix.equals(start.matrix)) {
      // A click without a movement.
      this.start = null;
      return this.place();
    }
    this.controls.enabled = false; // No drag begins before this one has ended.
    const step = this.isPulling ? null : this.editor.stepOf(start.weights, this.transforms());
    this.isStale = true;
    await (this.following ?? this.follow());
    this.start = null;
    const { latest } = this;
    const isValid = start.document === this.editor.document && latest !== null;
    await this.editor.attempt(() =>
      isValid ? this.editor.setPositions(latest, step) : this.editor.endPreview(),
    );
    this.controls.enabled = true;
    this.place();
    // Less is not seen.
    if (this.isPulling && this.heldBack > 0.01)
      this.editor.onMessage(
        `Cells would fold there: the point stays ${Math.round(100 * this.heldBack)} % of the way behind. Pull less far, or free pins.`,
        false,
      );
  }
}

const placeOf = (points: ArrayLike<number>, point: number) => [0, 1, 2].map((c) => points[3 * point + c]);
