// SPDX-License-Identifier: Apache-2.0
// Starts the page: makes its parts, connects the controls of index.html with them, and opens the files
// inside the page, or the work of last time.

import { Vector3 } from "three";
import { saveSoon, savedDocument } from "./autosave.ts";
import { commandsFor, frameOf, makeAround, openExample, type Command, type Page } from "./commands.ts";
import { isCompanion } from "./companions.ts";
import { isEmpty, nearestVertex } from "./document.ts";
import { bytesOf, embeddedFiles, nameOfWork, openEmbedded } from "./embedded.ts";
import { Editor } from "./editor.ts";
import { Engine } from "./engine.ts";
import { kExamples } from "./examples.ts";
import { Gizmo } from "./gizmo.ts";
import { onDrop, Pointer } from "./pointer.ts";
import type { Axis, ModelFile, NamedFile, Rules, Transform } from "./protocol.ts";
import { modelWords } from "./program.ts";
import * as selecting from "./selection.ts";
import { kShapes, shapeCommand, type Sizes } from "./shapes.ts";
import { Timeline } from "./timeline.ts";
import { kAxes, middleOf } from "./transforms.ts";
import { View, type Shown } from "./view.ts";
import type { Point } from "../library/espalier.ts";

const find = <Type extends Element = HTMLElement>(selector: string) =>
  document.querySelector<Type>(selector)!;
const findAll = <Type extends Element = HTMLElement>(selector: string) => [
  ...document.querySelectorAll<Type>(selector),
];

const view = new View(find("#view"));
const editor = new Editor(new Engine(libraryInPage()), view);
const gizmo = new Gizmo(editor);
const pointer = new Pointer(editor, gizmo, find<SVGPolygonElement>("#band polygon"));
const timeline = new Timeline(
  editor,
  find("#poses"),
  find<HTMLInputElement>("#time"),
  find('[data-command="play"]'),
);
const page: Page = { editor, gizmo, pointer, timeline, chooseFiles, save, switchTheme, refresh };
const commands = commandsFor(page);

/** espalier.wasm, which is inside the page. */
async function libraryInPage(): Promise<Uint8Array> {
  const zipped = bytesOf(find("#espalier-wasm").textContent!);
  const stream = new Blob([zipped]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// ---- Files ---------------------------------------------------------------------------------------------

const read = async (file: File): Promise<NamedFile> => ({
  name: file.name,
  bytes: new Uint8Array(await file.arrayBuffer()),
});

/** Opens files, together with the files that belong to models; or adds these to the models that are open. */
async function openFiles(
  files: Iterable<File>,
  open: (files: ModelFile[]) => Promise<void>,
): Promise<void> {
  const all = await Promise.all([...files].map(read));
  const companions = all.filter(isCompanion);
  const others = all.filter((file) => !isCompanion(file));
  if (others.length > 0)
    await open(companions.length > 0 ? others.map((file) => ({ ...file, companions })) : others);
  else if (companions.length > 0) await editor.addCompanions(companions);
}

function chooseFiles(accept: string, open: (files: ModelFile[]) => Promise<void>): void {
  const input = find<HTMLInputElement>("#file");
  input.accept = accept;
  input.value = "";
  input.onchange = () => void editor.attempt(() => openFiles(input.files ?? [], open));
  input.click();
}

function save(name: string, content: Blob | Uint8Array): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(
    content instanceof Blob ? content : new Blob([content as BlobPart]),
  );
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  editor.onMessage(`${name} is in your downloads.`, false);
}

onDrop(find("main"), (files) =>
  editor.attempt(() => openFiles(files, (opened) => editor.openFiles(opened))),
);

// ---- Commands and keys -----------------------------------------------------------------------------------

const runCommand = (command: Command) => {
  if (canRun(command)) void editor.attempt(() => command.run());
};

function canRun({ needs }: Command): boolean {
  const { document, shape, binding } = editor;
  const { selection } = document;
  switch (needs) {
    case undefined:
      return true;
    case "undo":
      return editor.canUndo;
    case "redo":
      return editor.canRedo;
    case "model":
      return !isEmpty(document);
    case "models":
      return document.models.length > 0;
    case "lattice":
      return shape !== null;
    case "binding":
      return binding !== null;
    case "pull":
      return gizmo.pulls.length > 0;
    case "pins":
      return gizmo.pins.length > 0;
    case "pose":
      return Number.isInteger(document.time) && document.time > 0;
    case "selection":
      return shape !== null && selection.length > 0;
    case "rest faces":
      return shape !== null && selecting.facesOf(shape, selection).length > 0;
  }
}

for (const button of findAll("[data-command]")) {
  const command = commands[button.dataset.command!];
  button.addEventListener("click", () => runCommand(command));
  if (command.key) button.setAttribute("aria-keyshortcuts", command.key.replace("Ctrl", "Control"));
  button.title = titleOf(command);
}

/** What buttons that cannot be used wait for. */
const kNeeds: Record<NonNullable<Command["needs"]>, string> = {
  model: "a model or a lattice",
  models: "a model",
  lattice: "a lattice",
  selection: "selected vertices",
  binding: "a model in a lattice",
  pull: "a pulled point",
  pins: "a pinned point",
  pose: "a pose",
  "rest faces": "a selected face of the boundary",
  undo: "something to undo",
  redo: "something that was undone",
};

function titleOf({ title, key }: Command): string {
  return key ? `${title} (${key})` : title;
}

/** The key of an event, as commands name it. */
function keyOf(event: KeyboardEvent): string {
  const isLetter = event.key.length === 1;
  const shift = event.shiftKey && (!isLetter || /\p{Lu}/u.test(event.key)) ? "Shift+" : "";
  const control = event.ctrlKey || event.metaKey;
  const key = /^Numpad\d$/.test(event.code) ? event.code : event.key;
  return (
    (control ? "Ctrl+" : "") + shift + (control ? key.replace(/^\w$/, (c) => c.toLowerCase()) : key)
  );
}

window.addEventListener("keydown", (event) => {
  const target = event.target as HTMLElement;
  const isTyping = target.matches("input:not([type=range]):not([type=checkbox]), select, textarea");
  if (find("dialog[open]") || event.altKey) return;
  let key = keyOf(event);
  if (key === "Ctrl+Shift+z" || key === "Ctrl+Shift+Z") key = "Ctrl+y";
  const command = Object.values(commands).find((each) => each.key === key || each.also === key);
  if (!command || (isTyping && !key.startsWith("Ctrl+"))) return;
  // Controls keep the keys that they use themselves.
  if (key === " " && target.matches("button, summary, input")) return;
  if (key.includes("Arrow") && target.matches("input")) return;
  event.preventDefault();
  runCommand(command);
});

find("#help dl").innerHTML = Object.values(commands)
  .filter((command) => command.key)
  .map(({ key, title }) => {
    const shown = key === " " ? "Space" : key!.replace("Arrow", "");
    return `<dt><kbd>${shown}</kbd></dt><dd>${title}</dd>`;
  })
  .join("");

// ---- Forms and settings ------------------------------------------------------------------------------------

type Values = Record<string, string>;
const pointOf = ({ x, y, z }: Values) => [Number(x), Number(y), Number(z)] as Point;

const forms: Record<string, (values: Values) => Promise<void>> = {
  around: ({ cells, margin }) => makeAround(editor, Number(cells), Number(margin)),
  cage({ vertices }) {
    const command = `espalier shape cage ${modelWords(editor.document)} --vertices ${vertices} -o rest.vtu`;
    return editor.makeLattice({ kind: "cage", vertices: Number(vertices) }, command);
  },
  shape({ kind, ...values }) {
    const sizes: Sizes = {};
    for (const [key, size] of Object.entries(kShapes[kind].sizes))
      sizes[key] = size.kind === "word" ? values[key] : Number(values[key]);
    return editor.makeLattice({ kind: "shape", name: kind, sizes }, shapeCommand(kind, sizes));
  },
  place(values) {
    const center = middleOf(editor.positions, editor.document.selection);
    // A field that shows the rounded centre leaves it where it is.
    const offset = pointOf(values).map((x, i) =>
      values[kAxes[i]] === shownNumber(center[i]) ? 0 : x - center[i],
    ) as Point;
    return editor.transform({ kind: "move", offset });
  },
  move: (values) => editor.transform({ kind: "move", offset: pointOf(values) }),
  scale: (values) => editor.transform({ kind: "scale", factors: pointOf(values) }),
  turn({ kind, axis, amount }) {
    const transform =
      kind === "taper"
        ? { kind, axis, factor: Number(amount) }
        : { kind, axis, degrees: Number(amount) };
    return editor.transform(transform as Transform & { axis: Axis });
  },
  async extrude({ distance }) {
    const faces = selecting.facesOf(editor.shape!, editor.document.selection);
    if (faces.length === 0) throw new Error("no face is selected with all its vertices");
    const before = editor.shape!.positions;
    const { normal } = frameOf(before, faces);
    const offset = normal.map((x) => x * Number(distance)) as Point;
    const places = [...new Set(faces.flatMap(({ vertices }) => vertices))].map((v) =>
      offset.map((x, c) => before[3 * v + c] + x),
    );
    await editor.editLattice({ kind: "extrude", faces: faces.map(({ face }) => face), offset });
    // The new faces, so that they can be moved or extruded on.
    await editor.select(places.map((place) => nearestVertex(editor.shape!.positions, place)));
  },
};

/** The controls for the sizes of the chosen shape. */
function showSizes(): void {
  const name = shapeName.value;
  find("#sizes").replaceChildren(
    ...Object.entries(kShapes[name].sizes).map(([key, size]) => {
      const label = document.createElement("label");
      label.append(size.title);
      const control = document.createElement(size.kind === "word" ? "select" : "input");
      control.name = key;
      control.title = `${size.title} of the shape`;
      if (control instanceof HTMLInputElement) {
        control.type = "number";
        control.required = true;
        control.min = size.kind === "count" ? String(size.least) : "0";
        if (size.kind === "length") control.step = "any";
      } else if (size.kind === "word") for (const word of size.words) control.add(new Option(word));
      control.value = String(size.value);
      label.append(control);
      return label;
    }),
  );
}

const shapeName = find<HTMLSelectElement>('[data-form="shape"] [name="kind"]');
for (const [name, { title }] of Object.entries(kShapes)) shapeName.add(new Option(title, name));
shapeName.addEventListener("change", showSizes);
showSizes();

for (const form of findAll<HTMLFormElement>("[data-form]"))
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const values = Object.fromEntries(new FormData(form)) as Values;
    void editor.attempt(() => forms[form.dataset.form!](values));
  });

const setting = (name: string) => find<HTMLSelectElement>(`[data-setting="${name}"]`);
setting("level").addEventListener("change", ({ target }) => {
  const { value } = target as HTMLSelectElement;
  const limit = value === "limit";
  const { settings } = editor.document;
  const level = limit ? settings.level : Number(value);
  void editor.change({ settings: { ...settings, level, limit } });
});
setting("outside").addEventListener("change", ({ target }) => {
  const outside = (target as HTMLSelectElement).value as "keep" | "nearest";
  void editor.change({ settings: { ...editor.document.settings, outside } });
});
setting("normals").addEventListener("change", ({ target }) => {
  const normals = (target as HTMLSelectElement).value as "turn" | "keep";
  void editor.change({ settings: { ...editor.document.settings, normals } });
});
for (const rule of findAll<HTMLSelectElement>("[data-rule]"))
  rule.addEventListener("change", () => {
    const rules = { ...editor.document.rules, [rule.dataset.rule!]: rule.value };
    void editor.change({ rules });
  });

const radius = find<HTMLInputElement>('[data-choice="radius"]');
radius.addEventListener("input", () => {
  editor.setRadius(Number((Number(radius.value) * 0.6 * view.size).toPrecision(3)));
});

find<HTMLSelectElement>('[data-choice="pivot"]').addEventListener("change", ({ target }) => {
  void editor.setPivot((target as HTMLSelectElement).value as "middle" | "border");
});

find<HTMLSelectElement>('[data-choice="mirror"]').addEventListener("change", ({ target }) => {
  editor.mirrorAxis = ((target as HTMLSelectElement).value || null) as Axis | null;
});

find<HTMLInputElement>('[data-choice="held"]').addEventListener("change", ({ target }) => {
  editor.movesHeld = (target as HTMLInputElement).checked;
});

const examples = find<HTMLSelectElement>('[data-choice="example"]');
for (const [name, { title }] of Object.entries(kExamples)) examples.add(new Option(title, name));
examples.addEventListener("change", () => {
  const name = examples.value;
  examples.value = "";
  void editor.attempt(() => openExample(editor, name));
});

for (const control of findAll<HTMLInputElement | HTMLSelectElement>("[data-shown]"))
  control.addEventListener("input", () => {
    const isBox = control instanceof HTMLInputElement && control.type === "checkbox";
    const value = isBox
      ? control.checked
      : control.type === "range"
        ? Number(control.value)
        : control.value;
    void editor.setShown({ ...view.shown, [control.dataset.shown!]: value } as Shown);
  });

// ---- What the controls show ----------------------------------------------------------------------------------

const put = (name: string, text: string) => {
  find(`[data-show="${name}"]`).textContent = text;
};
const number = (count: number) => count.toLocaleString("en");
const plural = (count: number, one: string) =>
  `${number(count)} ${count === 1 ? one : one === "vertex" ? "vertices" : `${one}s`}`;

function refresh(): void {
  const { document: work, models, shape, binding, folded } = editor;
  find("#start").hidden = !isEmpty(work);
  const points = models.reduce((sum, model) => sum + model.points.length / 3, 0);
  const names = work.models.length === 1 ? work.models[0].name : plural(work.models.length, "model");
  document.title = work.models.length > 0 ? `${names} – Espalier` : "Espalier";
  put("model", work.models.length > 0 && points > 0 ? `${shortened(names)}, ${plural(points, "point")}` : "");
  showModels();
  showShown();
  put(
    "lattice",
    shape
      ? `${plural(shape.vertexStrata.length, "vertex")}, ${plural(shape.cells.length, "cell")}`
      : "",
  );
  put(
    "selection",
    shape ? `${number(work.selection.length)} of ${number(shape.vertexStrata.length)}` : "",
  );
  put("pose", work.lattice ? (editor.isAtRest ? "the lattice at rest" : editor.pose.name) : "");
  const outside = binding?.outside.length ?? 0;
  const verb = work.settings.outside === "keep" ? "stay where they are" : "follow the nearest cell";
  put(
    "outside",
    outside > 0 ? `${plural(outside, "point")} outside the lattice: they ${verb}` : "",
  );
  const folds =
    folded.length > 0
      ? `<b title="Turn or move less, select more vertices with Soft or Grow, or use Pull">${plural(folded.length, "cell")} folded</b>`
      : "";
  find("#status").innerHTML = folds;

  setting("level").value = work.settings.limit ? "limit" : String(work.settings.level);
  setting("outside").value = work.settings.outside;
  setting("normals").value = work.settings.normals ?? "turn";
  find<HTMLInputElement>('[data-shown="materials"]').disabled = !view.hasLook;
  setting("normals").disabled = !models.some((model) => model.hasDirections);
  for (const rule of findAll<HTMLSelectElement>("[data-rule]"))
    rule.value = work.rules[rule.dataset.rule as keyof Rules];
  for (const button of findAll<HTMLButtonElement>("button[data-command]")) {
    const command = commands[button.dataset.command!];
    button.disabled = !canRun(command);
    button.title = titleOf(command) + (button.disabled ? ` – needs ${kNeeds[command.needs!]}` : "");
    if (command.isChosen) button.setAttribute("aria-checked", String(command.isChosen()));
  }
  const needsOf: Record<string, Command["needs"]> = {
    around: "models",
    cage: "models",
    extrude: "rest faces",
    shape: undefined,
  };
  for (const form of findAll<HTMLFormElement>("[data-form]")) {
    const name = form.dataset.form!;
    const usable =
      name in needsOf ? canRun({ needs: needsOf[name] } as Command) : canRun(commands.none);
    for (const control of form.elements) (control as HTMLInputElement).disabled = !usable;
  }
  const { pivot } = editor;
  const pivots = find<HTMLSelectElement>('[data-choice="pivot"]');
  const hasBorder = pivot !== "border" || editor.border !== null || work.selection.length === 0;
  pivots.options[1].textContent = hasBorder ? "border" : "border (none here: middle)";
  pivots.options[2].hidden = typeof pivot === "string";
  pivots.value = typeof pivot === "string" ? pivot : "point";
  put("radius", editor.radius > 0 ? shownNumber(editor.radius) : "");
  refreshPlace();
  refreshDistance();
  timeline.refresh();
  gizmo.place();
}

/** A name with as many letters as the panel has room for. */
const shortened = (name: string) => (name.length > 18 ? `${name.slice(0, 11)}…${name.slice(-6)}` : name);

/** The list of several models, each with a button that takes it out. */
function showModels(): void {
  const { models } = editor.document;
  const shown = models.length > 1 ? models : [];
  find("#models").replaceChildren(
    ...shown.map(({ name }, i) => {
      const item = document.createElement("li");
      const button = document.createElement("button");
      button.textContent = "×";
      button.title = `Take ${name} out of the scene`;
      button.setAttribute("aria-label", button.title);
      button.addEventListener("click", () => void editor.attempt(() => editor.closeModel(i)));
      item.append(name, button);
      return item;
    }),
  );
}

function showShown(): void {
  for (const control of findAll<HTMLInputElement | HTMLSelectElement>("[data-shown]")) {
    const value = view.shown[control.dataset.shown as keyof Shown];
    if (control instanceof HTMLInputElement && control.type === "checkbox") control.checked = Boolean(value);
    else control.value = String(value);
  }
}

function refreshPlace(): void {
  const form = find<HTMLFormElement>('[data-form="place"]');
  if (!canRun(commands.none) || form.contains(document.activeElement)) return;
  const center = middleOf(editor.positions, editor.document.selection);
  for (const [i, axis] of kAxes.entries()) {
    const field = form.elements.namedItem(axis) as HTMLInputElement;
    field.value = shownNumber(center[i]);
    field.title = `The middle of the selected vertices along ${axis}: ${center[i]}`;
  }
}

/** A number with as many digits as a field has room for. */
const shownNumber = (x: number) =>
  String(Math.abs(x) < 1e-4 * view.size ? 0 : Number(x.toPrecision(4)));

/** Offers the mean edge of the selected faces as the distance of an extrusion, until a person has
 * chosen another. */
function refreshDistance(): void {
  const field = find<HTMLInputElement>('[data-form="extrude"] [name="distance"]');
  if (!editor.shape || field.dataset.isChosen) return;
  const faces = selecting.facesOf(editor.shape, editor.document.selection);
  const size = faces.length > 0 ? frameOf(editor.shape.positions, faces).size : view.size / 10;
  field.value = String(Number(size.toPrecision(2)));
}
find('[data-form="extrude"] [name="distance"]').addEventListener("input", ({ target }) => {
  (target as HTMLInputElement).dataset.isChosen = "yes";
});

const kWork = nameOfWork();

const message = find("#message");
/** The document that the message is about. */
let messageDocument = editor.document;
editor.onShown = () => gizmo.place();
editor.onChange = () => {
  refresh();
  if (editor.document !== messageDocument) message.hidden = true;
  saveSoon(editor.document, kWork, () =>
    editor.onMessage("The browser has no room to keep this work: take it home before you close the page.", true),
  );
};

let messageTimer: ReturnType<typeof setTimeout> | undefined;
editor.onMessage = (text, isError) => {
  messageDocument = editor.document;
  message.hidden = false;
  message.classList.toggle("error", isError);
  message.querySelector("span")!.textContent = text;
  clearTimeout(messageTimer);
  if (!isError) messageTimer = setTimeout(() => (message.hidden = true), 10_000);
};
message.querySelector("button")!.addEventListener("click", () => (message.hidden = true));

const kJobTitles: Partial<Record<string, string>> = {
  openModels: "Opening the model",
  bind: "Binding the points",
  makeLattice: "Making the lattice",
};
const busy = find("#busy");
let busyTimer: ReturnType<typeof setTimeout> | undefined;
editor.engine.onBusy = (job) => {
  clearTimeout(busyTimer);
  if (job === null) busy.hidden = true;
  else
    busyTimer = setTimeout(() => {
      busy.hidden = false;
      busy.querySelector("span")!.textContent = kJobTitles[job] ?? "Working";
    }, 300);
};
editor.engine.onProgress = (_, done) => {
  busy.querySelector("progress")!.value = done;
};

// ---- The axis cross -----------------------------------------------------------------------------------------------

const ends = kAxes.flatMap((axis, i) =>
  [1, -1].map((sign) => {
    const button = document.createElement("button");
    button.title = `Look from ${sign > 0 ? "+" : "−"}${axis}`;
    button.setAttribute("aria-label", button.title);
    button.textContent = sign > 0 ? axis : "";
    button.dataset.axis = axis;
    const direction = new Vector3().setComponent(i, sign);
    button.addEventListener("click", () => view.look(direction));
    find("#axes").append(button);
    return { button, direction };
  }),
);
view.onTurn = () => {
  const toScreen = view.camera.quaternion.clone().invert();
  for (const { button, direction } of ends) {
    const { x, y, z } = direction.clone().applyQuaternion(toScreen);
    button.style.translate = `${28 * x}px ${-28 * y}px`;
    button.style.zIndex = String(Math.round(10 * z));
    button.style.opacity = String(0.75 + 0.25 * z);
  }
};

// ---- Light and dark --------------------------------------------------------------------------------------------

const kTheme = "espalier-theme";

function setTheme(theme: string): void {
  document.documentElement.dataset.theme = theme;
  view.readColours();
}

function switchTheme(): void {
  const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem(kTheme, theme);
  setTheme(theme);
}

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
setTheme(localStorage.getItem(kTheme) ?? (prefersDark.matches ? "dark" : "light"));

// ---- Start -----------------------------------------------------------------------------------------------------

async function start(): Promise<void> {
  refresh();
  view.look();
  const saved = await savedDocument(kWork);
  if (saved && !isEmpty(saved)) return editor.restart(saved);
  const embedded = embeddedFiles();
  if (embedded) await editor.attempt(() => openEmbedded(editor, embedded));
}

await start();
document.documentElement.dataset.ready = "";
// For scripts in the console, and for the tests.
Object.assign(globalThis, { espalier: page });
