// SPDX-License-Identifier: Apache-2.0
// Finds the program, with whose results the tests of this folder compare: the one that was built last, since an older
// one may write other bytes.
import assert from "node:assert/strict";
import { existsSync, statSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
const built = ["demo", "test", "release"]
  .map((preset) => join(root, "build", preset, "cli/espalier"))
  .filter((path) => existsSync(path))
  .sort((a, b) => statSync(b).mtimeMs - statSync(a).mtimeMs);
export const program = process.env.ESPALIER_PROGRAM ?? built[0];
assert.ok(program, "build the program first, or name it in ESPALIER_PROGRAM");
