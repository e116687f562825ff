// SPDX-License-Identifier: Apache-2.0
// The document that is edited, and what follows from it. An edit puts a new document into the history.
// Then update() brings the worker and the view to that document: it opens, binds and poses only what
// differs from what they have.

import { lookOf, type Look } from "./appearance.ts";
import { hasPointsOf, extensionOf, withCompanions } from "./companions.ts";
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
import { sorted } from "./selection.ts";
import { middleOf, optionsOf, softWeights, type Weights } from "./transforms.ts";
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
  /** The joint of the selection, if it is the pivot; null if the selection has none, and its middle counts. */
  border: Point | null = null;
  /** The axis of live mirroring: the other side follows each edit. Null: it does not follow. */
  mirrorAxis: Axis | null = null;
  /** Whether the vertices that the lattice holds, such as the outer ones of a collar, move, too. */
  movesHeld = false;

  private history = new History(kEmptyDocument);
  private open: Open = kNothing;
  private running: Promise<void> | null = null;
  private isStale = false;
  /** the document that the view showed last */
  private shown: Document | null = null;
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
        this.shown = document;
        this.onShown();
      } catch (error) {
        const isNew = this.document === document && this.shown !== document && !this.transient;
        if (isNew && this.history.canUndo) {
          // The document cannot be shown, or a person did not want to wait for it.
          this.history.drop();
          this.isStale = true;
          this.onChange();
        }
        if (!(error instanceof Cancelled)) this.fail(error);
        else if (this.shown === document) this.isStale = true; // The new worker has nothing open.
      }
    }
  }

  /** Does work with the worker and the view while no update runs; then come the updates that were asked for. */
  private async alone<T>(work: () => Promise<T>): Promise<T> {
    while (this.running) await this.running;
    const done = work();
    this.running = done
      .then(
        () => {},
        () => {}, // The caller gets the error.
      )
      .then(() => this.runUpdates())
      .finally(() => {
        this.running = null;
      });
    return done;
  }

  private async bring(document: Document): Promise<void> {
    await this.bringModels(document);
    await this.bringLattice(document);
    await this.bringBinding(document);
    await this.bringCells();
    await this.bringPose(document);
    if (!this.transient) await this.bringBorder(document);
  }

  private async bringModels({ models }: Document): Promise<void> {
    if (this.open.models === models) return;
    await this.showModels(models);
    this.onChange();
  }

  /** Opens models in the worker, unless it has their points, and shows them as they are at rest. Returns notes on what
   * is not shown. */
  private async showModels(models: readonly ModelFile[]): Promise<string[]> {
    const { models: open } = this.open;
    const isSame = open.length === models.length && models.every((each, i) => hasPointsOf(each, open[i]));
    if (!isSame) {
      this.models = await this.engine.run("openModels", models);
      this.open = { ...this.open, models, settings: null, positions: null };
      this.binding = null;
      this.view.setModels(this.models);
      if (models.length > 0 && !this.document.lattice) this.view.look();
    }
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
    try {
      this.view.setSurface(await this.engine.run("cellSurface"));
    } catch (error) {
      // Otherwise each update would try again.
      this.folded = [];
      this.view.setShown({ ...this.view.shown, cells: false, cut: "" });
      this.onChange();
      throw error;
    }
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

  /** Opens models, lattices and poses of the lattice. A .vtu or .vtk can be each of these: it is a lattice or a pose if
   * there is a model already. */
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
    const notes = await this.changeModels(models);
    this.view.look();
    const hint = this.document.lattice
      ? ""
      : "Now put a lattice around it: Cage for a body with limbs, Box around for simple shapes.";
    this.tell([...this.models.map((model) => model.notes), ...notes], hint);
  }

  /** Returns notes on what is not shown. Models that cannot be read change nothing. */
  private async changeModels(models: readonly ModelFile[]): Promise<string[]> {
    const notes = await this.alone(async () => {
      const result = await this.showModels(models);
      this.history.push({ ...this.document, models });
      return result;
    });
    await this.changed();
    return notes;
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
    this.tell(await this.changeModels(models));
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

  /** @param command of the program that makes it */
  async openLattice(file: NamedFile, command = restComment(file.name)): Promise<void> {
    const lattice = await this.engine.run("readLattice", file);
    await this.edit(withLattice(this.document, { ...lattice, command }));
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
    const { lattice: before } = this.document;
    const lattice = await this.engine.run("editLattice", edit);
    if (this.document.lattice !== before)
      throw new Error("the lattice has changed meanwhile: do this once more");
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
    const { document, pivot, positions } = this;
    if (typeof pivot !== "string") return pivot;
    return (pivot === "border" && this.border) || middleOf(positions, document.selection);
  }

  setPivot(pivot: "middle" | "border" | Point): Promise<void> {
    this.pivot = pivot;
    this.onChange();
    return this.update();
  }

  private async bringBorder({ lattice, selection }: Document): Promise<void> {
    const isWanted = this.pivot === "border" && lattice !== null && selection.length > 0;
    const border = isWanted ? await this.engine.run("border", selection, this.positions) : null;
    const differs = border?.join() !== this.border?.join();
    this.border = border;
    if (differs) this.onChange();
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
    const { movesHeld } = this;
    const result = await this.engine.run("transform", positions, weights, transforms, movesHeld);
    this.withoutImage = result.withoutImage;
    return result.positions;
  }

  /** The options of `espalier pose` for operations. Null if held vertices move, since `--move-held` would be for
   * all steps. */
  stepOf(weights: Weights, transforms: readonly Transform[]): string | null {
    return this.movesHeld ? null : optionsOf(weights, transforms);
  }

  /** Moves the selected vertices by operations, one after the other, about the pivot. */
  async transform(...given: Transform[]): Promise<void> {
    const weights = this.weights();
    if (weights.selection.length === 0) throw new Error("select vertices first");
    if (this.pivot === "border") await this.update(); // finds the border
    const { positions } = this;
    const center = this.pivot === "middle" ? undefined : this.pivotPoint;
    const transforms = this.withMirror(
      given.map((each) =>
        each.kind === "move" || each.kind === "mirror" || each.center ? each : { ...each, center },
      ),
    );
    const moved = await this.transformed(positions, weights.values, transforms);
    await this.setPositions(moved, this.stepOf(weights, transforms));
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
