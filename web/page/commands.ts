// SPDX-License-Identifier: Apache-2.0
// Everything that a button or a key does. Buttons name a command by data-command; the help sheet lists
// the commands with keys.

import { Vector3 } from "three";
import { kCompanions, takenExtension } from "./companions.ts";
import { kEmptyDocument, withPoseAdded, withPoseReplaced } from "./document.ts";
import { kWeldTolerance, nameOf, type Editor } from "./editor.ts";
import { pageWith } from "./embedded.ts";
import { kExamples } from "./examples.ts";
import type { Gizmo, Mode } from "./gizmo.ts";
import { neighbourTowards, type Pick, type Pointer } from "./pointer.ts";
import { commandsOf, deformedNames, matrixNames, modelWords, poseFile } from "./program.ts";
import type { BoundaryFace, ModelFile, Product } from "./protocol.ts";
import * as selecting from "./selection.ts";
import type { Timeline } from "./timeline.ts";
import { centerOf, kAxes, middleOf } from "./transforms.ts";
import type { Point } from "../library/espalier.ts";

/** The parts of the page that commands work on. */
export interface Page {
  editor: Editor;
  gizmo: Gizmo;
  pointer: Pointer;
  timeline: Timeline;
  /** Asks for files, and opens each. */
  chooseFiles(accept: string, open: (files: ModelFile[]) => Promise<void>): void;
  save(name: string, content: Blob | Uint8Array): void;
  switchTheme(): void;
  /** Shows the controls as they are: which is chosen, and which can be used. */
  refresh(): void;
}

export interface Command {
  /** what it does, for the help sheet */
  title: string;
  /** The key, as KeyboardEvent.key gives it; before it "Ctrl+" or "Shift+". A key of the number pad is
   * its KeyboardEvent.code. */
  key?: string;
  /** another key */
  also?: string;
  /** what must be there */
  needs?:
    | "model"
    | "models"
    | "lattice"
    | "selection"
    | "binding"
    | "pull"
    | "pins"
    | "pose"
    | "rest faces"
    | "undo"
    | "redo";
  /** whether a button of a choice is chosen */
  isChosen?(): boolean;
  run(): void | Promise<void>;
}

const kModels = ".obj,.ply,.stl,.glb,.gltf,.vtu,.vtp,.vtk";
const kCellFiles = ".vtu,.ovm,.vtk";
const kLattices = `${kCellFiles},.obj,.ply`;

/** The sides of the scene, with the keys of Blender's number pad. */
const kSides = [
  ["front", "Numpad1"],
  ["back", "Ctrl+Numpad1"],
  ["right", "Numpad3"],
  ["left", "Ctrl+Numpad3"],
  ["top", "Numpad7"],
  ["bottom", "Ctrl+Numpad7"],
] as const;

/** The direction of a side, where y points up and z to the front, or z points up and y to the back. */
function directionOf(side: (typeof kSides)[number][0], up: "y" | "z"): Vector3 {
  const isY = up === "y";
  const top = new Vector3(0, isY ? 1 : 0, isY ? 0 : 1);
  const front = new Vector3(0, isY ? 0 : -1, isY ? 1 : 0);
  const right = new Vector3(1, 0, 0);
  const axis = { front, back: front, right, left: right, top, bottom: top }[side];
  return side === "back" || side === "left" || side === "bottom" ? axis.negate() : axis;
}

/** Lets the keys reach a control, and those after it. */
function focusOn(selector: string): void {
  const control = document.querySelector<HTMLElement>(selector)!;
  control.closest("details")!.open = true;
  control.focus();
}

/** Opens files one after the other. */
const each = (open: (file: ModelFile) => Promise<void>) => async (files: ModelFile[]) => {
  for (const file of files) await open(file);
};

export function commandsFor(page: Page): Record<string, Command> {
  const { editor, gizmo, pointer, timeline } = page;
  const shape = () => editor.shape!;
  const selection = () => editor.document.selection;

  const handles = (mode: Mode, key: string, title: string): Command => ({
    title,
    key,
    isChosen: () => gizmo.mode === mode && !gizmo.isPulling,
    run() {
      gizmo.mode = mode;
      gizmo.isPulling = false;
      gizmo.place();
      page.refresh();
    },
  });

  const picks = (pick: Pick, key: string, title: string): Command => ({
    title,
    key,
    isChosen: () => pointer.pick === pick,
    run() {
      pointer.pick = pick;
      page.refresh();
    },
  });

  /** Switches something on and off. */
  const toggle = (title: string, isOn: () => boolean, set: (on: boolean) => void, key?: string) =>
    ({
      title,
      key,
      isChosen: isOn,
      run() {
        set(!isOn());
        page.refresh();
      },
    }) satisfies Command;

  /** Selects a part of the lattice, which turns about its joint from then on. */
  const part = (kind: "limb" | "beyond", key: string, title: string): Command => ({
    title,
    key,
    needs: "selection",
    async run() {
      const rest = editor.document.lattice!.positions;
      const point = middleOf(rest, selection());
      await editor.select(await editor.engine.run("part", kind, point, rest));
      await editor.setPivot("border");
    },
  });

  const grows = (key: string, title: string, by: number): Command => ({
    title,
    key,
    needs: "selection",
    run: async () => editor.select(await editor.engine.run("grow", selection(), by)),
  });

  const steps = (title: string, key: string, by: number): Command => ({
    title,
    key,
    needs: "lattice",
    run() {
      const count = shape().positions.length / 3;
      const [first] = selection();
      return editor.select([
        first === undefined ? (by > 0 ? 0 : count - 1) : (first + by + count) % count,
      ]);
    },
  });

  /** An arrow goes to the neighbour there; with Shift it moves the selection by a hundredth. */
  const arrows = (name: string, dx: number, dy: number): Record<string, Command> => ({
    [`go ${name}`]: {
      title: `Go to the neighbour: ${name}`,
      key: `Arrow${name[0].toUpperCase()}${name.slice(1)}`,
      needs: "selection",
      run() {
        const next = neighbourTowards(editor, dx, dy);
        return next === null ? undefined : editor.select([next]);
      },
    },
    [`nudge ${name}`]: {
      title: `Move the selection: ${name}`,
      key: `Shift+Arrow${name[0].toUpperCase()}${name.slice(1)}`,
      needs: "selection",
      run: () => editor.transform({ kind: "move", offset: nudge(dx, dy) }),
    },
  });

  /** A step along the axes that are nearest to right and up on the screen. */
  function nudge(dx: number, dy: number): Point {
    const e = editor.view.camera.matrixWorld.elements;
    const direction = dx !== 0 ? [e[0], e[1], e[2]] : [e[4], e[5], e[6]];
    const axis = direction.reduce(
      (best, x, i) => (Math.abs(x) > Math.abs(direction[best]) ? i : best),
      0,
    );
    const offset: Point = [0, 0, 0];
    const sign = Math.sign(direction[axis]) * (dx !== 0 ? dx : -dy);
    offset[axis] = sign * Number((editor.view.size / 100).toPrecision(2));
    return offset;
  }

  const commandsNow = () =>
    commandsOf(
      editor.document,
      editor.pose,
      editor.models.map((model) => model.hasDirections),
    );

  const take = (name: () => string, product: () => Product) => async () =>
    page.save(name(), await editor.write(product()));

  const mark = (sharpness: number) => () => {
    const edges = selecting.edgesOf(shape(), selection());
    const vertices = edges.length === 0 ? [...selection()] : [];
    return editor.editLattice({ kind: "mark", edges, vertices, sharpness });
  };

  const planes = Object.fromEntries(
    kAxes.map((axis, i) => [
      `plane ${axis}`,
      {
        title: `Select all at the same ${axis}`,
        key: `Shift+${axis.toUpperCase()}`,
        needs: "selection",
        run: () => editor.select(selecting.atPlanes(editor.positions, selection(), i)),
      } satisfies Command,
    ]),
  );

  const onAxes = Object.fromEntries(
    kAxes.map((axis) => [
      `only ${axis}`,
      {
        title: `Handles along ${axis} only, or along all axes again`,
        key: axis,
        needs: "selection",
        isChosen: () => gizmo.axis === axis,
        run() {
          gizmo.axis = gizmo.axis === axis ? null : axis;
          page.refresh();
        },
      } satisfies Command,
    ]),
  );

  const views = Object.fromEntries(
    kSides.map(([side, key]) => [
      `view ${side}`,
      {
        title: `Look from the ${side}`,
        key,
        run: () => editor.view.look(directionOf(side, editor.view.up)),
      } satisfies Command,
    ]),
  );

  const mirrors = Object.fromEntries(
    kAxes.map((axis) => [
      `mirror ${axis}`,
      {
        title: `Give the mirror images of the selected vertices across ${axis} their mirrored places`,
        needs: "selection",
        run: () => editor.transform({ kind: "mirror", axis }),
      } satisfies Command,
    ]),
  );

  return {
    open: {
      title: "Open a model",
      key: "o",
      run: () =>
        page.chooseFiles([kModels, ...kCompanions].join(), (files) => editor.openModels(files)),
    },
    "open beside": {
      title: "Open more models beside: all follow the lattice",
      needs: "models",
      run: () =>
        page.chooseFiles([kModels, ...kCompanions].join(), (files) => editor.openModels(files, true)),
    },
    "open lattice": {
      title: "Open a lattice, or a pose of it",
      key: "l",
      run: () => page.chooseFiles(kLattices, each((file) => editor.openLatticeOrPose(file))),
    },
    "join lattice": {
      title: "Join the cells of another lattice",
      needs: "lattice",
      run: () => page.chooseFiles(kCellFiles, each((file) => editor.joinLattice(file))),
    },
    example: { title: "Open a model in a lattice, with a pose", run: () => openBentExample(editor) },
    new: { title: "Begin anew", run: () => editor.change(kEmptyDocument) },
    undo: { title: "Undo", key: "Ctrl+z", needs: "undo", run: () => editor.undo() },
    redo: { title: "Redo", key: "Ctrl+y", needs: "redo", run: () => editor.redo() },

    translate: handles("translate", "g", "Move by handles"),
    rotate: handles("rotate", "r", "Rotate by handles"),
    scale: handles("scale", "s", "Scale by handles"),
    ...onAxes,
    snap: toggle(
      "Let the handles move in steps: round lengths, 15 degrees, tenths",
      () => gizmo.isSnapping,
      (on) => (gizmo.isSnapping = on),
    ),
    "pivot here": {
      title: "Turn, scale and bend about the middle of this selection from now on",
      needs: "selection",
      run() {
        return editor.setPivot(middleOf(editor.positions, selection()));
      },
    },
    pull: {
      title: "Pull a point of the model",
      key: "p",
      needs: "binding",
      isChosen: () => gizmo.isPulling,
      run() {
        gizmo.isPulling = true;
        gizmo.place();
        editor.onMessage(
          "Drag a point of the model. Click with Shift or Add to pull more points at once, by the handles. Pin keeps points where they are.",
          false,
        );
        page.refresh();
      },
    },
    pin: {
      title: "Pin the pulled points: later pulls leave them where they are, until you click them again",
      key: "k",
      needs: "pull",
      run() {
        gizmo.pins = selecting.sorted([...gizmo.pins, ...gizmo.pulls]);
        gizmo.pulls = [];
        page.refresh();
      },
    },
    "free pins": {
      title: "Free all pins",
      needs: "pins",
      run() {
        gizmo.pins = [];
        page.refresh();
      },
    },
    "pick vertices": picks("vertices", "1", "Click selects a vertex"),
    "pick faces": picks("faces", "2", "Click selects a face"),
    "pick cells": picks("cells", "3", "Click selects a cell"),
    "pick box": picks("box", "4", "Drag selects by a box"),
    "pick lasso": picks("lasso", "5", "Drag selects by a lasso"),
    add: toggle(
      "Clicks, boxes and lassos add to the selection, as with Shift",
      () => pointer.adds,
      (on) => (pointer.adds = on),
      "+",
    ),
    front: toggle(
      "Boxes and lassos select only what the lattice does not hide",
      () => pointer.onlyFront,
      (on) => (pointer.onlyFront = on),
    ),
    isolate: {
      title: "Hide what is not selected, or show all again",
      key: "h",
      needs: "lattice",
      isChosen: () => editor.view.hidesVertices,
      run() {
        const { view } = editor;
        if (!view.hidesVertices && selection().length === 0)
          throw new Error("select the vertices that shall stay in sight");
        const count = shape().positions.length / 3;
        view.hide(view.hidesVertices ? [] : selecting.inverted(selection(), count));
        page.refresh();
      },
    },

    all: {
      title: "Select all",
      key: "a",
      needs: "lattice",
      run: () => editor.select(shape().vertexStrata.keys()),
    },
    none: { title: "Select none", key: "Escape", needs: "selection", run: () => editor.select([]) },
    invert: {
      title: "Invert the selection",
      key: "i",
      needs: "lattice",
      run: () => editor.select(selecting.inverted(selection(), shape().positions.length / 3)),
    },
    row: {
      title: "Select rows of cells: go on from an edge between two selected vertices",
      key: "w",
      needs: "selection",
      run: () => editor.select(selecting.rows(shape(), selection())),
    },
    limb: part("limb", "Shift+L", "Select the arm, leg or ear at the selection"),
    beyond: part("beyond", "Shift+B", "Select what lies beyond the face at the selection"),
    grow: grows("]", "Select the neighbours, too", 1),
    shrink: grows("[", "Take the outer vertices from the selection", -1),
    ...planes,
    "next vertex": steps("Select the next vertex", "n", 1),
    "previous vertex": steps("Select the vertex before", "Shift+N", -1),
    ...arrows("left", -1, 0),
    ...arrows("right", 1, 0),
    ...arrows("up", 0, -1),
    ...arrows("down", 0, 1),

    ...mirrors,
    reset: {
      title: "Put the selection back to rest",
      key: "Backspace",
      needs: "selection",
      run() {
        const rest = editor.document.lattice!.positions;
        const positions = editor.positions.slice();
        for (const v of selection()) positions.set(rest.subarray(3 * v, 3 * v + 3), 3 * v);
        return editor.setPositions(positions, null);
      },
    },

    pyramid: {
      title: "Attach a pyramid",
      needs: "rest faces",
      run() {
        const [face] = selecting.facesOf(shape(), selection());
        const { center, normal, size } = frameOf(shape().positions, [face]);
        const apex = center.map((x, i) => x + 0.7 * size * normal[i]) as Point;
        return editor.editLattice({ kind: "pyramid", face: face.face, apex });
      },
    },
    weld: {
      title: "Merge vertices that are close",
      needs: "lattice",
      run: () => editor.editLattice({ kind: "weld", tolerance: kWeldTolerance }),
    },
    "remove cells": {
      title: "Delete the selected cells",
      key: "Delete",
      needs: "selection",
      run() {
        const cells = selecting.cellsOf(shape(), selection());
        if (cells.length === 0) throw new Error("no cell is selected with all its vertices");
        return editor.editLattice({ kind: "remove", cells });
      },
    },
    sharp: { title: "Mark as sharp", needs: "selection", run: mark(10) },
    smooth: { title: "Mark as smooth", needs: "selection", run: mark(0) },
    "clear marks": {
      title: "Remove all marks",
      needs: "lattice",
      run: () => editor.editLattice({ kind: "clear marks" }),
    },

    "save model": {
      title: "Take the deformed model home",
      key: "Ctrl+s",
      needs: "binding",
      async run() {
        for (const [model, file] of editor.document.models.entries()) {
          const extension = takenExtension(file);
          const pose = editor.positions;
          const content = await editor.write({ kind: "model", model, pose, extension });
          page.save(deformedNames(editor.document)[model], content);
        }
      },
    },
    "save pose": {
      title: "Take the pose home",
      needs: "lattice",
      run: take(
        () => poseFile(editor.document, editor.pose),
        () => ({ kind: "lattice", positions: editor.positions, extension: ".vtu" }),
      ),
    },
    "save pose cage": {
      title: "Take the pose home, as .obj",
      needs: "lattice",
      run: take(
        () => poseFile(editor.document, editor.pose).replace(".vtu", ".obj"),
        () => ({ kind: "lattice", positions: editor.positions, extension: ".obj" }),
      ),
    },
    "save rest": {
      title: "Take the lattice at rest home",
      needs: "lattice",
      run: () => page.save("rest.vtu", editor.document.lattice!.bytes),
    },
    "save rest cage": {
      title: "Take the lattice at rest home, as .obj",
      needs: "lattice",
      run: take(
        () => "rest.obj",
        () => ({
          kind: "lattice",
          positions: editor.document.lattice!.positions,
          extension: ".obj",
        }),
      ),
    },
    "save matrix": {
      title: "Take the matrix of the deformation home",
      needs: "binding",
      async run() {
        for (const [model, name] of matrixNames(editor.document).entries())
          page.save(name, await editor.write({ kind: "matrix", model }));
      },
    },
    "save page": {
      title: "Take this page home, with the models, the lattice and the poses inside: one file to send to somebody",
      needs: "model",
      async run() {
        const [first] = editor.document.models;
        page.save(`${first ? nameOf(first) : "lattice"}.html`, await pageWith(editor));
      },
    },
    picture: {
      title: "Take a picture home",
      needs: "model",
      run: async () => page.save("espalier.png", await editor.view.picture()),
    },
    commands: {
      title: "Show the commands of the program",
      key: "c",
      needs: "lattice",
      run() {
        const dialog = document.querySelector<HTMLDialogElement>("#program")!;
        dialog.querySelector("pre")!.textContent = commandsNow();
        dialog.showModal();
      },
    },
    "go to lattice": {
      title: "Go to the ways to make a lattice",
      key: "v",
      run: () => focusOn('[data-form="cage"] input'),
    },
    "go to operations": {
      title: "Go to the operations on the selection",
      key: "q",
      run: () => focusOn('[data-form="turn"] select'),
    },
    "copy commands": {
      title: "Copy the commands",
      run: () => navigator.clipboard.writeText(commandsNow()),
    },

    play: { title: "Play the poses", key: " ", needs: "lattice", run: () => timeline.toggle() },
    "add pose": {
      title: "Add a pose",
      key: "Ctrl+Enter",
      needs: "lattice",
      run: () => editor.edit(withPoseAdded(editor.document)),
    },
    "rename pose": {
      title: "Rename the pose",
      key: "F2",
      needs: "pose",
      run() {
        const name = prompt("Name of the pose", editor.pose.name)?.trim();
        if (!name) return;
        const index = editor.document.time - 1;
        return editor.edit(withPoseReplaced(editor.document, index, { ...editor.pose, name }));
      },
    },
    "delete pose": {
      title: "Delete the pose",
      needs: "pose",
      run() {
        const time = editor.document.time - 1;
        return editor.edit({ ...withPoseReplaced(editor.document, time), time });
      },
    },
    "next pose": { title: "Next pose", key: ".", needs: "lattice", run: () => timeline.step(1) },
    "previous pose": {
      title: "Pose before",
      key: ",",
      needs: "lattice",
      run: () => timeline.step(-1),
    },

    frame: { title: "Show everything", key: "f", also: "Home", run: () => editor.view.look() },
    ...views,
    parallel: toggle(
      "Draw parallel lines as parallel, or farther things smaller",
      () => editor.view.isParallel,
      (on) => editor.view.setParallel(on),
      "Numpad5",
    ),
    "z up": toggle(
      "Let z point up, or y again",
      () => editor.view.up === "z",
      (on) => (editor.view.up = on ? "z" : "y"),
    ),
    extrude: {
      title: "Extrude the selected faces",
      key: "e",
      needs: "rest faces",
      run: () => document.querySelector<HTMLFormElement>('[data-form="extrude"]')!.requestSubmit(),
    },
    theme: { title: "Light or dark", key: "d", run: () => page.switchTheme() },
    help: {
      title: "Show this sheet",
      key: "?",
      run: () => document.querySelector<HTMLDialogElement>("#help")!.showModal(),
    },
    cancel: { title: "Cancel", run: () => editor.engine.cancel() },
  };
}

export async function openExample(editor: Editor, name: string): Promise<void> {
  await editor.openModels([kExamples[name].make()]);
}

/** Makes a box of cells around the model.
 * @param cells along the longest side
 * @param margin room around the model, as a part of its size */
export function makeAround(editor: Editor, cells: number, margin: number): Promise<void> {
  const command = `espalier shape around ${modelWords(editor.document)} --cells ${cells} --margin ${margin} -o rest.vtu`;
  return editor.makeLattice({ kind: "around", options: { cellsAlongLongest: cells, margin } }, command);
}

/** Opens an example in a lattice that a pose bends, and selects the end that a person may move on. */
async function openBentExample(editor: Editor): Promise<void> {
  await openExample(editor, "dog");
  await makeAround(editor, 4, 0.05);
  const count = editor.shape!.positions.length / 3;
  await editor.select(Array(count).keys());
  await editor.transform({ kind: "twist", axis: "y", degrees: 40 });
  const high = Math.max(...editor.positions.filter((_, i) => i % 3 === 1));
  const near = 1e-6 * editor.view.size;
  const isHigh = (v: number) => editor.positions[3 * v + 1] > high - near;
  await editor.select([...Array(count).keys()].filter(isHigh));
  editor.onMessage(
    "Drag the handles: the dog follows its lattice. Click a vertex to choose another.",
    false,
  );
}

/** The middle of faces, their mean normal, and their mean edge. */
export function frameOf(positions: Float64Array, faces: BoundaryFace[]) {
  const sum: Point = [0, 0, 0];
  let edges = 0;
  let length = 0;
  for (const { vertices } of faces)
    vertices.forEach((v, i) => {
      const [p, q] = [v, vertices[(i + 1) % vertices.length]].map((w) =>
        positions.subarray(3 * w, 3 * w + 3),
      );
      // The sum of p × q around a loop is its normal times twice its area.
      for (let c = 0; c < 3; ++c)
        sum[c] += p[(c + 1) % 3] * q[(c + 2) % 3] - p[(c + 2) % 3] * q[(c + 1) % 3];
      length += Math.hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]);
      ++edges;
    });
  const area = Math.hypot(...sum) || 1;
  const weights = new Float64Array(positions.length / 3);
  for (const { vertices } of faces) for (const v of vertices) weights[v] = 1;
  return {
    center: centerOf(positions, weights),
    normal: sum.map((x) => x / area) as Point,
    size: length / edges,
  };
}
