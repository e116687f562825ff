// SPDX-License-Identifier: Apache-2.0
// Finds the program, with whose results the tests of this folder compare.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
export const program = [
  process.env.ESPALIER_PROGRAM,
  ...["demo", "test", "release"].map((preset) => join(root, "build", preset, "cli/espalier")),
].find((path) => path && existsSync(path));
assert.ok(program, "build the program first, or name it in ESPALIER_PROGRAM");
