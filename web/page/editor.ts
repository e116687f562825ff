// SPDX-License-Identifier: Apache-2.0
// The document that is edited, and what follows from it. An edit puts a new document into the history.
// Then update() brings the worker and the view to that document: it opens, binds and poses only what
// differs from what they have.

import { lookOf, type Look } from "./appearance.ts";
import { extensionOf, withCompanions } from "./companions.ts";
import { Cancelled, Engine } from "./engine.ts";
import {
  History,
  kEmptyDocument,
  positionsAt,
  withChangedLattice,
  withLattice,
  withMovedLattice,
  withPoseAdded,
  withPoseReplaced,
  type Document,
  type Pose,
} from "./document.ts";
import type {
  Axis,
  BindResult,
  LatticeEdit,
  LatticeFile,
  LatticeShape,
  ModelFile,
  ModelPose,
  ModelShape,
  NamedFile,
  Product,
  Recipe,
  Transform,
} from "./protocol.ts";
import { comment } from "./program.ts";
import { neighboursOf, sorted } from "./selection.ts";
import { borderOf, middleOf, optionsOf, softWeights, type Weights } from "./transforms.ts";
import type { Point } from "../library/espalier.ts";
import type { Shown, View } from "./view.ts";

/** Vertices within this part of the diagonal of the lattice become one. */
export const kWeldTolerance = 1e-3;

/** What the worker and the view have. */
interface Open {
  models: readonly ModelFile[];
  lattice: LatticeFile | null;
  rules: Document["rules"] | null;
  settings: Document["settings"] | null;
  positions: Float64Array | null;
  /** whether the points are in double precision */
  exact: boolean;
  cells: boolean;
}

const kNothing: Open = {
  models: [],
  lattice: null,
  rules: null,
  settings: null,
  positions: null,
  exact: false,
  cells: false,
};

export class Editor {
  /** Called after every change of the document and of what is known of it. */
  onChange: () => void = () => {};
  /** Called after the view shows a document. */
  onShown: () => void = () => {};
  /** Called with a message for the person. */
  onMessage: (text: string, isError: boolean) => void = () => {};

  models: ModelShape[] = [];
  shape: LatticeShape | null = null;
  binding: BindResult | null = null;
  folded: number[] = [];
  radius = 0;
  /** What rotations, scales and bends are about: the middle of the selection, its border, or a point. */
  pivot: "middle" | "border" | Point = "middle";
  /** The axis across which the other side does what one side does; null if it does not. */
  mirrorAxis: Axis | null = null;

  private history = new History(kEmptyDocument);
  private open: Open = kNothing;
  private running: Promise<void> | null = null;
  private isStale = false;
  /** positions while something is dragged or played, which are not in the document */
  private transient: Float64Array | null = null;
  /** the vertices that the last operations left in place, since they have no mirror image */
  private withoutImage = 0;
  private lastFoldCheck = { end: 0, took: 0 };

  constructor(
    readonly engine: Engine,
    readonly view: View,
  ) {
    engine.onRestart = () => {
      this.open = kNothing;
    };
  }

  // ---- The document ----------------------------------------------------------------------------------

  get document(): Document {
    return this.history.present;
  }

  get canUndo(): boolean {
    return this.history.canUndo;
  }

  get canRedo(): boolean {
    return this.history.canRedo;
  }

  /** The positions of the vertices that are shown. */
  get positions(): Float64Array {
    const { document } = this;
    return this.transient ?? positionsAt(document, document.time);
  }

  get isAtRest(): boolean {
    return this.document.time === 0;
  }

  /** Resolves when the view shows the document. */
  edit(document: Document): Promise<void> {
    this.history.push(document);
    return this.changed();
  }

  change(part: Partial<Document>): Promise<void> {
    return this.edit({ ...this.document, ...part });
  }

  undo(): Promise<void> {
    this.history.undo();
    return this.changed();
  }

  redo(): Promise<void> {
    this.history.redo();
    return this.changed();
  }

  /** Begins with another document, without a way back. */
  restart(document: Document): Promise<void> {
    this.history = new History(document);
    return this.changed();
  }

  setTime(time: number): Promise<void> {
    this.history.replace({ ...this.document, time });
    return this.changed();
  }

  private changed(): Promise<void> {
    this.transient = null;
    this.onChange();
    return this.update();
  }

  // ---- Showing the document ----------------------------------------------------------------------------

  /** Brings the worker and the view to the document. Calls during an update lead to one more. */
  update(): Promise<void> {
    this.isStale = true;
    this.running ??= this.runUpdates().finally(() => {
      this.running = null;
    });
    return this.running;
  }

  private async runUpdates(): Promise<void> {
    while (this.isStale) {
      this.isStale = false;
      const { document } = this;
      try {
        await this.bring(document);
        this.onShown();
      } catch (error) {
        // The document cannot be shown, or a person did not want to wait for it.
        if (this.document === document && this.history.canUndo) {
          this.history.drop();
          this.isStale = true;
          this.onChange();
        }
        if (!(error instanceof Cancelled)) this.fail(error);
      }
    }
  }

  private async bring(document: Document): Promise<void> {
    await this.bringModels(document);
    await this.bringLattice(document);
    await this.bringBinding(document);
    await this.bringCells();
    await this.bringPose(document);
  }

  private async bringModels({ models }: Document): Promise<void> {
    const open = this.open.models;
    if (open === models) return;
    const isSame =
      open.length === models.length && models.every(({ bytes }, i) => bytes === open[i].bytes);
    if (isSame) {
      await this.showLooks(models);
      return this.onChange();
    }
    await this.showModels(models);
    if (models.length > 0 && !this.document.lattice) this.view.look();
    this.onChange();
  }

  /** Opens models in the worker, and shows them as they are at rest. Returns notes on what is not shown. */
  private async showModels(models: readonly ModelFile[]): Promise<string[]> {
    this.models = await this.engine.run("openModels", models);
    this.open = { ...this.open, models, settings: null, positions: null };
    this.binding = null;
    this.view.setModels(this.models);
    return this.showLooks(models);
  }

  /** Shows the materials of the open models. */
  private async showLooks(models: readonly ModelFile[]): Promise<string[]> {
    const notes: string[] = [];
    for (const [i, model] of models.entries()) {
      const look = await lookOf(model, this.models[i]).catch((error: Error): Look => ({
        materials: [],
        notes: [`1 file of materials cannot be read: ${error.message}`],
      }));
      this.view.setLook(i, look.materials);
      notes.push(...look.notes);
    }
    this.open = { ...this.open, models };
    return notes;
  }

  private async bringLattice({ lattice, rules }: Document): Promise<void> {
    if (this.open.lattice === lattice && (this.open.rules === rules || !lattice)) return;
    const isFirst = !this.open.lattice;
    this.shape = await this.engine.run("openLattice", lattice?.bytes ?? null, rules);
    this.open = { ...this.open, lattice, rules, settings: null, positions: null, cells: false };
    this.binding = null;
    this.folded = [];
    if (typeof this.pivot !== "string") this.pivot = "middle"; // It was a place of the old lattice.
    this.view.setLattice(this.shape);
    if (lattice && isFirst) this.view.look();
    this.onChange();
  }

  private async bringBinding({ models, lattice, settings }: Document): Promise<void> {
    if (models.length === 0 || !lattice) {
      if (this.open.positions === null) {
        this.view.setModelPoses(this.models.map(atRest));
        this.view.setOutside(new Uint32Array(0));
      }
      return;
    }
    if (this.open.settings === settings) return;
    // A binding that fails leaves nothing bound.
    this.binding = null;
    this.open = { ...this.open, settings: null };
    this.binding = await this.engine.run("bind", settings);
    this.open = { ...this.open, settings, positions: null };
    this.view.setOutside(this.binding.outside);
    this.onChange();
  }

  private async bringCells(): Promise<void> {
    const { cells, cut } = this.view.shown;
    const isWanted = this.shape !== null && (cells || cut !== "" || this.folded.length > 0);
    if (!isWanted || this.open.cells) return;
    this.view.setSurface(await this.engine.run("cellSurface"));
    this.open = { ...this.open, cells: true, positions: null };
  }

  private async bringPose(document: Document): Promise<void> {
    if (!document.lattice) return;
    const { positions } = this;
    const exact = this.transient === null;
    this.view.setPose(positions);
    this.view.setSelection(document.selection, this.weights().values);
    const isShown = this.open.positions === positions && (this.open.exact || !exact);
    if (isShown) return this.checkFolds(positions);
    const result = await this.engine.run("pose", {
      positions,
      exact,
      surface: this.open.cells,
    });
    this.open = { ...this.open, positions, exact };
    if (result.models.length > 0) this.view.setModelPoses(result.models);
    if (result.surface) this.view.setSurfacePositions(result.surface);
    await this.checkFolds(positions);
  }

  /** Finds folded cells: after every edit, and during a drag as often as it does not slow it down. */
  private async checkFolds(positions: Float64Array): Promise<void> {
    const start = performance.now();
    if (this.transient && start - this.lastFoldCheck.end < 4 * this.lastFoldCheck.took) return;
    const folded = await this.engine.run("foldedCells", positions);
    const end = performance.now();
    this.lastFoldCheck = { end, took: end - start };
    const differs = folded.join() !== this.folded.join();
    this.folded = folded;
    if (folded.length > 0 && !this.open.cells) this.isStale = true;
    if (!differs) return;
    this.view.setFolded(folded);
    this.onChange();
  }

  setShown(shown: Shown): Promise<void> {
    this.view.setShown(shown);
    this.onChange();
    return this.update();
  }

  // ---- Edits -----------------------------------------------------------------------------------------

  /** Runs an action, and shows the message of what goes wrong. */
  async attempt(action: () => void | Promise<void>): Promise<void> {
    try {
      await action();
    } catch (error) {
      if (!(error instanceof Cancelled)) this.fail(error);
      else await this.update(); // The new worker has nothing open.
    }
  }

  private fail(error: unknown): void {
    this.onMessage(error instanceof Error ? error.message : String(error), true);
  }

  /** Opens models, lattices and poses of the lattice: each file as what it is. Of files that may be each of these, the
   * first is the model, unless there is another. */
  async openFiles(files: readonly ModelFile[]): Promise<void> {
    const mayBeLattice = ({ name }: NamedFile) => [".ovm", ".vtu", ".vtk"].includes(extensionOf(name));
    const models = files.filter((file) => !mayBeLattice(file));
    const others = files.filter(mayBeLattice);
    if (models.length === 0 && this.document.models.length === 0) {
      const first = others.findIndex(({ name }) => extensionOf(name) !== ".ovm");
      if (first >= 0) models.push(...others.splice(first, 1));
    }
    await this.openModels(models);
    for (const file of others) await this.openLatticeOrPose(file);
  }

  /** Opens models in place of those that are open, or beside them. A lattice stays, with its poses. */
  async openModels(files: readonly ModelFile[], beside = false): Promise<void> {
    if (files.length === 0) return;
    const models = beside ? [...this.document.models, ...files] : files;
    // The worker reads them here already, so a file that cannot be read changes nothing.
    const notes = await this.showModels(models);
    this.view.look();
    await this.change({ models });
    const hint = this.document.lattice
      ? ""
      : "Now put a lattice around it: Cage for a body with limbs, Box around for simple shapes.";
    this.tell([...this.models.map((model) => model.notes), ...notes], hint);
  }

  /** Where a point is at rest. Points of several models are numbered one model after the other. */
  restOf(point: number): number[] {
    for (const { points } of this.models) {
      if (3 * point < points.length) return [...points.subarray(3 * point, 3 * point + 3)];
      point -= points.length / 3;
    }
    throw new Error(`there is no point ${point}`);
  }

  closeModel(index: number): Promise<void> {
    return this.change({ models: this.document.models.filter((_, i) => i !== index) });
  }

  /** Adds files to the open models that belong to them. */
  async addCompanions(files: readonly NamedFile[]): Promise<void> {
    if (this.document.models.length === 0)
      throw new Error(
        `${files.map(({ name }) => name).join(", ")}: drop it together with its model`,
      );
    const models = this.document.models.map((model) => withCompanions(model, files));
    const notes = await this.showLooks(models);
    await this.change({ models });
    this.tell(notes);
  }

  /** @param hint what to say if there are no notes */
  private tell(notes: string[], hint = ""): void {
    const text = notes.filter((note) => note !== "").join("; ") || hint;
    if (text !== "") this.onMessage(text, false);
  }

  /** Opens a lattice; or a pose, if it has the cells of the lattice that is open. */
  async openLatticeOrPose(file: NamedFile): Promise<void> {
    if (this.document.lattice) {
      const positions = await this.engine.run("readPose", file).catch((error) => {
        if (error instanceof Cancelled) throw error;
        return null;
      });
      if (positions) return this.addPose(nameOf(file), positions);
    }
    await this.openLattice(file);
  }

  async openLattice(file: NamedFile): Promise<void> {
    const lattice = await this.engine.run("readLattice", file);
    await this.edit(
      withLattice(this.document, { ...lattice, command: restComment(file.name) }),
    );
  }

  async addPose(name: string, positions: Float64Array): Promise<void> {
    const poses = [...this.document.poses, { name, positions, steps: null }];
    await this.change({ poses, time: poses.length });
  }

  async makeLattice(recipe: Recipe, command: string): Promise<void> {
    const lattice = await this.engine.run("makeLattice", recipe);
    await this.edit(withLattice(this.document, { ...lattice, command }));
  }

  /** Changes the cells or the marks of the lattice. */
  async editLattice(edit: LatticeEdit): Promise<void> {
    const lattice = await this.engine.run("editLattice", edit);
    const from = edit.kind === "move" ? withMovedLattice : withChangedLattice;
    await this.edit(from(this.document, { ...lattice, command: null }));
  }

  /** Adds the cells of another lattice. Vertices within kWeldTolerance, in diagonals, become one. */
  joinLattice(file: NamedFile): Promise<void> {
    return this.editLattice({ kind: "join", file, tolerance: kWeldTolerance });
  }

  select(vertices: Iterable<number>): Promise<void> {
    const selection = sorted(vertices);
    if (selection.join() === this.document.selection.join()) return Promise.resolve();
    return this.change({ selection });
  }

  setRadius(radius: number): void {
    this.radius = radius;
    this.view.setSelection(this.document.selection, this.weights().values);
    this.onChange();
  }

  /** The weights of the vertices in an operation, from the selection and the soft selection. */
  weights(): Weights {
    const { lattice, selection } = this.document;
    return softWeights(lattice?.positions ?? new Float64Array(0), selection, this.radius);
  }

  /** The point that the pivot stands for. */
  get pivotPoint(): Point {
    const { document, pivot, positions, shape } = this;
    if (pivot === "middle") return middleOf(positions, document.selection);
    if (pivot === "border") return borderOf(positions, document.selection, neighboursOf(shape!));
    return pivot;
  }

  /** Operations, and the one that lets the other side do the same, if it shall. */
  withMirror(transforms: Transform[]): Transform[] {
    const axis = this.mirrorAxis;
    return axis === null ? transforms : [...transforms, { kind: "mirror", axis }];
  }

  /** The positions after operations. */
  async transformed(
    positions: Float64Array,
    weights: Float64Array,
    transforms: readonly Transform[],
  ): Promise<Float64Array> {
    const result = await this.engine.run("transform", positions, weights, transforms);
    this.withoutImage = result.withoutImage;
    return result.positions;
  }

  /** Moves the selected vertices by operations, one after the other, about the pivot. */
  async transform(...given: Transform[]): Promise<void> {
    const weights = this.weights();
    if (weights.selection.length === 0) throw new Error("select vertices first");
    const { positions } = this;
    const center = this.pivot === "middle" ? undefined : this.pivotPoint;
    const transforms = this.withMirror(
      given.map((each) =>
        each.kind === "move" || each.kind === "mirror" || each.center ? each : { ...each, center },
      ),
    );
    const moved = await this.transformed(positions, weights.values, transforms);
    await this.setPositions(moved, optionsOf(weights, transforms));
  }

  /** Shows positions without an edit. */
  preview(positions: Float64Array): Promise<void> {
    this.transient = positions;
    return this.update();
  }

  /** Ends previews without an edit. */
  endPreview(): Promise<void> {
    return this.changed();
  }

  /** Sets the positions of the pose at the current time, or of the lattice at rest.
   * @param step the option of `espalier pose` that does the same, if there is one
   */
  async setPositions(positions: Float64Array, step: string | null): Promise<void> {
    await this.editPositions(positions, step);
    if (this.withoutImage > 0)
      this.onMessage(`No mirror image for ${this.withoutImage} of the vertices: they stay.`, false);
    this.withoutImage = 0;
  }

  private async editPositions(positions: Float64Array, step: string | null): Promise<void> {
    if (this.isAtRest) return this.editLattice({ kind: "move", positions });
    // Between two poses, the edit makes a pose of its own.
    const { time } = this.document;
    const document = Number.isInteger(time) ? this.document : withPoseAdded(this.document);
    const index = document.time - 1;
    const pose = document.poses[index];
    const steps = step !== null && pose.steps ? [...pose.steps, step] : null;
    await this.edit(withPoseReplaced(document, index, { ...pose, positions, steps }));
  }

  write(product: Product): Promise<Uint8Array> {
    return this.engine.run("write", product);
  }

  /** The current pose, or a stand-in for the lattice at rest. */
  get pose(): Pose {
    const { document } = this;
    const pose = Number.isInteger(document.time) ? document.poses[document.time - 1] : undefined;
    return (
      pose ?? {
        name: this.isAtRest ? "rest" : "between",
        positions: this.positions,
        steps: this.isAtRest ? [] : null,
      }
    );
  }
}

const restComment = (name: string) =>
  comment(name === "rest.vtu" ? "rest.vtu: Take home, Rest .vtu" : `${name} is rest.vtu`);

const atRest = ({ points }: ModelShape): ModelPose => ({
  points: Float32Array.from(points),
  isCoarse: false,
});

export const nameOf = (file: NamedFile) => file.name.replace(/\.[^.]*$/, "");
