// SPDX-License-Identifier: Apache-2.0
// Selects vertices by clicks, by boxes and by the arrow keys, and takes files that are dropped.

import type { Editor } from "./editor.ts";
import type { Gizmo } from "./gizmo.ts";
import { neighboursOf, toggled } from "./selection.ts";

/** What a click selects the vertices of; box: a drag selects by a box. */
export type Pick = "vertices" | "faces" | "cells" | "box";

export class Pointer {
  pick: Pick = "vertices";
  private from: { x: number; y: number; isBox: boolean } | null = null;

  constructor(
    private readonly editor: Editor,
    private readonly gizmo: Gizmo,
    private readonly band: HTMLElement,
  ) {
    const { canvas } = editor.view;
    // Before the handles and the camera get the event.
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", () => this.stop());
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || !event.isPrimary || this.gizmo.isUsed) return this.stop();
    const isBox = (event.shiftKey || this.pick === "box") && this.editor.shape !== null;
    this.from = { x: event.offsetX, y: event.offsetY, isBox };
    if (isBox) this.editor.view.controls.enabled = false;
  }

  private hasMoved({ offsetX, offsetY }: PointerEvent): boolean {
    return Math.hypot(offsetX - this.from!.x, offsetY - this.from!.y) > 5;
  }

  private move(event: PointerEvent): void {
    if (!this.from?.isBox || !this.hasMoved(event)) return;
    const { x, y } = this.from;
    this.band.hidden = false;
    Object.assign(this.band.style, {
      left: `${Math.min(x, event.offsetX)}px`,
      top: `${Math.min(y, event.offsetY)}px`,
      width: `${Math.abs(event.offsetX - x)}px`,
      height: `${Math.abs(event.offsetY - y)}px`,
    });
  }

  private stop(): void {
    if (this.from?.isBox) this.editor.view.controls.enabled = true;
    this.from = null;
    this.band.hidden = true;
  }

  private up(event: PointerEvent): void {
    const { from } = this;
    if (!from) return;
    const moved = this.hasMoved(event);
    this.stop();
    if (!moved) void this.editor.attempt(() => this.click(event));
    else if (from.isBox) {
      const inside = this.editor.view.verticesInBox(from.x, from.y, event.offsetX, event.offsetY);
      const before = event.shiftKey ? this.editor.document.selection : [];
      void this.editor.select([...before, ...inside]);
    }
  }

  private async click(event: PointerEvent): Promise<void> {
    const { editor, gizmo } = this;
    if (gizmo.pulled !== null) {
      const point = editor.view.pointAt(event.offsetX, event.offsetY);
      if (point !== null) gizmo.pulled = point;
      gizmo.place();
      return;
    }
    if (!editor.shape) return;
    const vertices = this.verticesAt(event);
    if (event.shiftKey) await editor.select(toggled(editor.document.selection, vertices));
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
