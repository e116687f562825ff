// SPDX-License-Identifier: Apache-2.0
// Selects vertices by clicks, by areas and by the arrow keys, and takes files that are dropped.

import type { Editor } from "./editor.ts";
import type { Gizmo } from "./gizmo.ts";
import { isInside, neighboursOf, toggled } from "./selection.ts";

/** What a click selects the vertices of; box, lasso: a drag selects by an area. */
export type Pick = "vertices" | "faces" | "cells" | "box" | "lasso";

/** A press of the pointer that has not ended. */
interface Press {
  /** the places of the pointer, in pixels of the canvas: x and y */
  path: [number, number][];
  area: "box" | "lasso" | null;
  /** A handle of the selection is under the pointer, so a drag moves the selection. */
  isOnHandle: boolean;
  /** the point of a model under the pointer, which a drag pulls */
  pulled: number | null;
  isPulling: boolean;
}

export class Pointer {
  pick: Pick = "vertices";
  /** Clicks and areas add to the selection, as with Shift. */
  adds = false;
  /** Areas select only vertices in front of the lattice. */
  onlyFront = false;
  private press: Press | null = null;

  constructor(
    private readonly editor: Editor,
    private readonly gizmo: Gizmo,
    private readonly band: SVGPolygonElement,
  ) {
    const { canvas } = editor.view;
    // Before the handles and the camera get the event.
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", () => this.stop());
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || !event.isPrimary) return this.stop();
    const isOnHandle = this.gizmo.isUsed && !event.shiftKey;
    const areas = this.pick === "box" || this.pick === "lasso" ? this.pick : null;
    const { offsetX: x, offsetY: y } = event;
    const adds = event.shiftKey || this.adds;
    const pulled =
      this.gizmo.isPulling && this.gizmo.isIdle && !isOnHandle && !adds ? this.editor.view.pointAt(x, y) : null;
    const hasNoArea = isOnHandle || !this.editor.shape || this.gizmo.isPulling;
    const area = hasNoArea ? null : event.shiftKey ? (areas ?? "box") : areas;
    this.press = { path: [[x, y]], area, isOnHandle, pulled, isPulling: false };
    if (!area && pulled === null) return;
    this.letOthersDrag(false);
    this.editor.view.canvas.setPointerCapture(event.pointerId);
  }

  /** Lets the camera and the handles follow the pointer, or not. */
  private letOthersDrag(mayDrag: boolean): void {
    this.editor.view.controls.enabled = mayDrag;
    this.gizmo.isEnabled = mayDrag;
  }

  private hasMoved({ offsetX, offsetY }: PointerEvent): boolean {
    return this.press!.path.some(([x, y]) => Math.hypot(offsetX - x, offsetY - y) > 5);
  }

  private move(event: PointerEvent): void {
    const { press } = this;
    if (!press || !this.hasMoved(event)) return;
    if (press.pulled !== null) {
      if (!press.isPulling) this.gizmo.beginPull(press.pulled);
      press.isPulling = true;
      this.gizmo.moveTo(event.offsetX, event.offsetY);
    }
    if (!press.area) return;
    const [[x, y]] = press.path;
    const [u, v] = [event.offsetX, event.offsetY];
    if (press.area === "lasso") press.path.push([u, v]);
    else press.path = [[x, y], [u, y], [u, v], [x, v]]; // prettier-ignore
    this.band.setAttribute("points", press.path.join(" "));
  }

  private stop(): void {
    const { press } = this;
    if (press && (press.area || press.pulled !== null)) this.letOthersDrag(true);
    if (press?.isPulling) void this.gizmo.end();
    this.press = null;
    this.band.removeAttribute("points");
  }

  private up(event: PointerEvent): void {
    const { press } = this;
    if (!press) return;
    const moved = this.hasMoved(event);
    this.stop();
    if (press.isPulling) return;
    if (!moved) void this.editor.attempt(() => this.click(event, press.isOnHandle));
    else if (press.area) {
      const { view, document } = this.editor;
      const inside = view.verticesIn((x, y) => isInside(press.path, x, y), this.onlyFront);
      const before = event.shiftKey || this.adds ? document.selection : [];
      void this.editor.select([...before, ...inside]);
    }
  }

  private async click(event: PointerEvent, isOnHandle: boolean): Promise<void> {
    const { editor, gizmo } = this;
    if (gizmo.isPulling) {
      const point = editor.view.pointAt(event.offsetX, event.offsetY);
      if (point === null) return;
      gizmo.pins = gizmo.pins.filter((pin) => pin !== point);
      const adds = event.shiftKey || this.adds;
      gizmo.pulls = adds ? toggled(gizmo.pulls, [point]) : [point];
      editor.onChange();
      return;
    }
    if (!editor.shape) return;
    const vertices = this.verticesAt(event);
    // A click on a handle, with nothing behind it, is no wish to select nothing.
    if (isOnHandle && vertices.length === 0) return;
    if (event.shiftKey || this.adds)
      await editor.select(toggled(editor.document.selection, vertices));
    else await editor.select(vertices);
  }

  private verticesAt({ offsetX, offsetY, pointerType }: PointerEvent): number[] {
    const { view, shape } = this.editor;
    if (this.pick === "faces" || this.pick === "cells") {
      const face = view.faceAt(offsetX, offsetY);
      if (!face) return [];
      return this.pick === "faces" ? face.vertices : [...shape!.cells[face.cell]];
    }
    const vertex = view.vertexAt(offsetX, offsetY, pointerType === "touch" ? 24 : 14);
    return vertex === null ? [] : [vertex];
  }
}

/** The neighbour of a vertex that lies most in a direction on the screen, or null. */
export function neighbourTowards(editor: Editor, dx: number, dy: number): number | null {
  const { selection } = editor.document;
  if (!editor.shape || selection.length !== 1) return null;
  const at = editor.view.screenOf(selection[0]);
  let best: number | null = null;
  let most = 0.3;
  for (const v of neighboursOf(editor.shape)[selection[0]]) {
    const there = editor.view.screenOf(v);
    const [x, y] = [there.x - at.x, there.y - at.y];
    const along = (x * dx + y * dy) / (Math.hypot(x, y) || 1);
    if (along > most) [best, most] = [v, along];
  }
  return best;
}

/** Calls `take` with the files that are dropped onto an element. */
export function onDrop(element: HTMLElement, take: (files: File[]) => void): void {
  let depth = 0;
  const mark = (change: number) => {
    depth += change;
    element.classList.toggle("dropping", depth > 0);
  };
  document.addEventListener("dragenter", () => mark(1));
  document.addEventListener("dragleave", () => mark(-1));
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    mark(-depth);
    take([...(event.dataTransfer?.files ?? [])]);
  });
}
