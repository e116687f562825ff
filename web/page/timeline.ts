// SPDX-License-Identifier: Apache-2.0
// The list of poses, and the time between them.

import type { Editor } from "./editor.ts";

/** seconds from one pose to the next when they are played */
const kSecondsOfPose = 1;

export class Timeline {
  private playing = false;

  constructor(
    private readonly editor: Editor,
    private readonly list: HTMLElement,
    private readonly slider: HTMLInputElement,
    private readonly button: HTMLElement,
  ) {
    slider.addEventListener("input", () => {
      this.playing = false;
      void editor.setTime(Number(slider.value));
    });
    list.addEventListener("click", ({ target }) => {
      const index = [...list.children].indexOf(target as Element);
      if (index >= 0) void this.go(index);
    });
  }

  refresh(): void {
    const { document } = this.editor;
    const names = document.lattice ? ["Rest", ...document.poses.map((pose) => pose.name)] : [];
    while (this.list.children.length > names.length) this.list.lastElementChild!.remove();
    names.forEach((name, i) => {
      const chip = this.list.children[i] ?? this.list.appendChild(newChip());
      chip.textContent = name;
      (chip as HTMLElement).title = i === 0 ? "The lattice at rest" : `Show the pose ${name}`;
      chip.setAttribute("aria-selected", String(document.time === i));
    });
    this.slider.max = String(Math.max(1, document.poses.length));
    this.slider.value = String(document.time);
    this.slider.disabled = document.poses.length === 0;
    this.button.setAttribute("aria-label", this.playing ? "Stop" : "Play");
    this.button.setAttribute("aria-checked", String(this.playing));
  }

  go(index: number): Promise<void> {
    this.playing = false;
    return this.editor.setTime(index);
  }

  step(by: number): Promise<void> {
    const { time, poses } = this.editor.document;
    const next = by > 0 ? Math.floor(time) + 1 : Math.ceil(time) - 1;
    return this.go(Math.min(poses.length, Math.max(0, next)));
  }

  /** Plays the poses to the last one and from the first again, until it is called once more. */
  async toggle(): Promise<void> {
    this.playing = !this.playing;
    const { editor } = this;
    let last = performance.now();
    while (this.playing && editor.document.poses.length > 0) {
      await new Promise(requestAnimationFrame);
      if (!this.playing) break;
      const now = performance.now();
      const { time, poses } = editor.document;
      const next = time + (now - last) / 1000 / kSecondsOfPose;
      last = now;
      await editor.setTime(time === poses.length ? 0 : Math.min(poses.length, next));
    }
    this.playing = false;
    this.refresh();
  }
}

function newChip(): HTMLElement {
  const chip = document.createElement("button");
  chip.setAttribute("role", "tab");
  return chip;
}
