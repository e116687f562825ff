// SPDX-License-Identifier: Apache-2.0
// The handles with which the selected vertices are moved, turned and scaled, and a point of the model is
// pulled.

import * as THREE from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Point } from "../library/espalier.ts";
import type { Editor } from "./editor.ts";
import type { Axis, Transform } from "./protocol.ts";
import { kAxes, optionsOf, type Weights } from "./transforms.ts";

export type Mode = "translate" | "rotate" | "scale";

export class Gizmo {
  mode: Mode = "translate";
  /** the point of the model that is pulled instead of vertices */
  pulled: number | null = null;

  /** the only axis of the handles; null for all three */
  axis: Axis | null = null;

  private readonly controls: TransformControls;
  private readonly handle = new THREE.Object3D();
  private start: { positions: Float64Array; weights: Weights; matrix: THREE.Matrix4 } | null = null;
  private latest: Float64Array | null = null;

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
  }

  /** Lets the handles move in steps: lengths of a power of ten near a fiftieth of the lattice, 15 degrees, and
   * tenths. */
  set isSnapping(isSnapping: boolean) {
    const step = 10 ** Math.round(Math.log10(this.editor.view.size / 50));
    this.controls.setTranslationSnap(isSnapping ? step : null);
    this.controls.setRotationSnap(isSnapping ? THREE.MathUtils.degToRad(15) : null);
    this.controls.setScaleSnap(isSnapping ? 0.1 : null);
  }

  get isSnapping(): boolean {
    return this.controls.rotationSnap !== null;
  }

  /** Whether a drag on a handle moves the selection. */
  set isEnabled(isEnabled: boolean) {
    this.controls.enabled = isEnabled && this.start === null;
  }

  /** Whether the pointer is on a handle, or drags it. */
  get isUsed(): boolean {
    return this.controls.dragging || this.controls.axis !== null;
  }

  /** Puts the handles where the selection is, or hides them. */
  place(): void {
    if (this.controls.dragging) return;
    const { document, view, binding } = this.editor;
    if (!binding || (this.pulled ?? 0) >= view.points.length / 3) this.pulled = null;
    const hasSelection = document.lattice !== null && document.selection.length > 0;
    if (!hasSelection && this.pulled === null) {
      this.controls.detach();
      view.ask();
      return;
    }
    const center =
      this.pulled !== null
        ? [...view.points.subarray(3 * this.pulled, 3 * this.pulled + 3)]
        : this.editor.pivotPoint;
    this.handle.position.fromArray(center);
    this.handle.rotation.set(0, 0, 0);
    this.handle.scale.set(1, 1, 1);
    this.handle.updateMatrixWorld();
    this.controls.setMode(this.pulled !== null ? "translate" : this.mode);
    this.controls.camera = view.camera;
    for (const axis of kAxes)
      this.controls[`show${axis.toUpperCase() as "X" | "Y" | "Z"}`] = [null, axis].includes(this.axis);
    this.controls.attach(this.handle);
    view.ask();
  }

  private begin(): void {
    this.handle.updateMatrix();
    const { positions } = this.editor;
    const weights = this.editor.weights();
    this.start = { positions, weights, matrix: this.handle.matrix.clone() };
    this.latest = null;
  }

  private drag(): void {
    const { start } = this;
    if (!start) return;
    this.handle.updateMatrix();
    if (this.pulled !== null) {
      void this.editor.attempt(() => this.pull());
      return;
    }
    if (this.mode !== "translate") {
      void this.editor.attempt(() => this.transform());
      return;
    }
    const offset = this.offset();
    const positions = start.positions.slice();
    start.weights.values.forEach((weight, v) => {
      if (weight > 0) offset.forEach((x, c) => (positions[3 * v + c] += weight * x));
    });
    this.latest = positions;
    void this.editor.preview(positions);
  }

  private offset(): Point {
    const from = new THREE.Vector3().setFromMatrixPosition(this.start!.matrix);
    return this.handle.position.clone().sub(from).toArray();
  }

  private async pull(): Promise<void> {
    const { start } = this;
    const by = this.offset();
    const moved = await this.editor.engine.run("pull", [{ point: this.pulled!, by }], start!.positions);
    if (this.start !== start) return;
    this.latest = start!.positions.map((x, i) => x + moved[i]);
    if (this.controls.dragging) void this.editor.preview(this.latest);
  }

  /** The operations of the program that do what the handles have done. */
  private transforms(): Transform[] {
    const { handle } = this;
    const { scale } = handle;
    switch (this.mode) {
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

  private async transform(): Promise<void> {
    const { start } = this;
    const { positions, weights } = start!;
    const { engine } = this.editor;
    const moved = await engine.run("transform", positions, weights.values, this.transforms());
    if (this.start !== start) return;
    this.latest = moved;
    if (this.controls.dragging) void this.editor.preview(moved);
  }

  private async end(): Promise<void> {
    const { start } = this;
    if (!start) return;
    if (this.handle.matrix.equals(start.matrix)) {
      // A click without a movement.
      this.start = null;
      return this.place();
    }
    this.controls.enabled = false; // No drag begins before this one has ended.
    const step = this.pulled === null ? optionsOf(start.weights, this.transforms()) : null;
    if (this.pulled !== null) await this.editor.attempt(() => this.pull());
    else if (this.mode !== "translate") await this.editor.attempt(() => this.transform());
    this.start = null;
    if (this.latest) await this.editor.attempt(() => this.editor.setPositions(this.latest!, step));
    this.controls.enabled = true;
    this.place();
  }
}
