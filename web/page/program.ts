// SPDX-License-Identifier: Apache-2.0
// Writes the commands of the program that make what the page shows.

import { takenExtension } from "./companions.ts";
import { kEmptyDocument, type Document, type Pose } from "./document.ts";
import { nameOf } from "./editor.ts";

const kRestAsPose = "rest-as-pose.vtu";

/** Makes each name of a file differ from the names before it, and from some others: by a number before its extension. */
function distinct(names: readonly string[], others: readonly string[] = []): string[] {
  const taken = new Set(others);
  return names.map((name) => {
    const dot = name.lastIndexOf(".");
    let result = name;
    for (let i = 2; taken.has(result); ++i) result = `${name.slice(0, dot)}-${i}${name.slice(dot)}`;
    taken.add(result);
    return result;
  });
}

/** The name of the file of a pose. The stand-in for the lattice at rest is "rest.vtu". */
export function poseFile({ poses }: Document, pose: Pose): string {
  const words = (name: string) => name.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-");
  const names = poses.map(({ name }) => `${words(name)}.vtu`);
  const index = poses.indexOf(pose);
  return index < 0 ? `${pose.name}.vtu` : distinct(names, ["rest.vtu", kRestAsPose])[index];
}

/** The names of the deformed models. */
export const deformedNames = ({ models }: Document) =>
  distinct(models.map((model) => `${nameOf(model)}-deformed${takenExtension(model)}`));

/** The names of the matrices of the models. */
export const matrixNames = ({ models }: Document) =>
  models.length === 1 ? ["D.npz"] : distinct(models.map((model) => `D-${nameOf(model)}.npz`));

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
  const isRest = document.time === 0;
  const to = isRest ? kRestAsPose : fileWord(poseFile(document, pose));
  if (isRest) lines.push(`cp rest.vtu ${to}`);
  else if (pose.steps) {
    const steps = pose.steps.length > 0 ? pose.steps : ["--move 0 0 0"];
    lines.push(
      ["espalier pose rest.vtu", ...steps, `-o ${to}`].join(" \\\n    "),
    );
  } else lines.push(comment(`${poseFile(document, pose)}: Take home, Pose .vtu`));
  for (const [i, model] of models.entries()) {
    const turns = hasDirections[i] && document.settings.normals !== "keep";
    const keep = hasDirections[i] && !turns ? " --keep-normals" : "";
    const options = `--rest rest.vtu ${bindingOptions(document)}${keep}`;
    // With gradients, points are placed more exactly: D is then the matrix of the deformed file.
    const gradients = document.settings.limit && turns ? " --gradients" : "";
    const [from, result, matrix] = [
      model.name,
      deformedNames(document)[i],
      matrixNames(document)[i],
    ].map(fileWord);
    lines.push(
      `espalier deform ${from} ${options} \\\n    --to ${to} -o ${result}`,
      `espalier stencils rest.vtu --points ${from} ${bindingOptions(document)}${gradients} -o ${matrix}`,
    );
  }
  return lines.join("\n");
}
