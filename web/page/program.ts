// SPDX-License-Identifier: Apache-2.0
// Writes the commands of the program that make what the page shows.

import { takenExtension } from "./companions.ts";
import { kEmptyDocument, type Document, type Pose } from "./document.ts";
import { nameOf } from "./editor.ts";
import type { ModelFile } from "./protocol.ts";

export const fileName = (pose: Pose) =>
  `${pose.name.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-")}.vtu`;

export const deformedName = (model: ModelFile) =>
  `${nameOf(model)}-deformed${takenExtension(model)}`;

/** The name of the matrix of a model: of one of several, with the name of the model. */
export const matrixName = ({ models }: Document, model: ModelFile) =>
  models.length > 1 ? `D-${nameOf(model)}.npz` : "D.npz";

/** A word as a shell needs it. */
export const word = (text: string) =>
  /^[\w./+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;

/** The name of a file as a shell needs it. A name that begins with a hyphen would be an option. */
export const fileWord = (name: string) => word(name.startsWith("-") ? `./${name}` : name);

/** A comment, which ends with its line: control characters become spaces. */
export const comment = (text: string) => `# ${text.replace(/[\p{Cc}\u2028\u2029]+/gu, " ")}`;

/** The names of the models as a shell needs them. */
export const modelWords = ({ models }: Document) =>
  models.map(({ name }) => fileWord(name)).join(" ");

function bindingOptions({ settings, rules }: Document): string {
  const how = settings.limit ? "--limit" : `--level ${settings.level}`;
  const standard = kEmptyDocument.rules;
  const words = [how, `--outside ${settings.outside}`];
  if (rules.rules !== standard.rules) words.push(`--rules ${rules.rules}`);
  if (rules.boundary !== standard.boundary) words.push(`--boundary ${rules.boundary}`);
  if (rules.sharpEdges !== standard.sharpEdges) words.push(`--sharp-edges ${rules.sharpEdges}`);
  return words.join(" ");
}

/** @param hasDirections whether each model has normals, tangents or splats */
export function commandsOf(document: Document, pose: Pose, hasDirections: boolean[]): string {
  const { lattice, models } = document;
  if (!lattice) return "# Make a lattice first.";
  const lines: string[] = [lattice.command ?? "# rest.vtu: Take home, Rest .vtu"];
  if (pose.name === "rest") lines.push("cp rest.vtu rest-as-pose.vtu");
  else if (pose.steps) {
    const steps = pose.steps.length > 0 ? pose.steps : ["--move 0 0 0"];
    lines.push(
      ["espalier pose rest.vtu", ...steps, `-o ${fileWord(fileName(pose))}`].join(" \\\n    "),
    );
  } else lines.push(comment(`${fileName(pose)}: Take home, Pose .vtu`));
  for (const [i, model] of models.entries()) {
    const turns = hasDirections[i] && document.settings.normals !== "keep";
    const keep = hasDirections[i] && !turns ? " --keep-normals" : "";
    const options = `--rest rest.vtu ${bindingOptions(document)}${keep}`;
    // With gradients, points are placed more exactly: D is then the matrix of the deformed file.
    const gradients = document.settings.limit && turns ? " --gradients" : "";
    const to = pose.name === "rest" ? "rest-as-pose.vtu" : fileWord(fileName(pose));
    const [from, result] = [model.name, deformedName(model)].map(fileWord);
    const matrix = fileWord(matrixName(document, model));
    lines.push(
      `espalier deform ${from} ${options} \\\n    --to ${to} -o ${result}`,
      `espalier stencils rest.vtu --points ${from} ${bindingOptions(document)}${gradients} -o ${matrix}`,
    );
  }
  return lines.join("\n");
}
