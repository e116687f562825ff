#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that lists of file formats name the formats that there are.

The registry (io/formats.h) is printed by the program print_formats. docs/file-formats.md has a table of all
formats. Any other text that lists three extensions or more must list all formats of some content, such as
all that a model is written in; a text that means a few of them says so by "such as"."""
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PRINT_FORMATS = sys.argv.pop()

# Texts in which lists of extensions reach users; the help and the messages of the program are made of the registry.
TEXTS = ("README.md", "SECURITY.md", "docs/*.md", "c/*.h", "python/*.cpp", "python/espalier/*.py*", "io/**/*.h",
         "web/library/*.ts", "web/page/*.ts", "web/page/*.html", "web/*.md", "cli/*.cpp", "cli/*.h",
         "hosts/*.md", "hosts/blender/**/*.py", "scripts/agreement")
EXTENSION = r"\*?\.[a-z][a-z0-9]{0,5}\b"
MARK = r"[`\"'*]*"
# ".ovm, .vtu or .vtk", over line ends and the marks of comments.
SEPARATOR = rf"{MARK}(?:,|;|\||\s*/)?(?:\s|\n[/#*\s]*)*(?:(?:or|and)(?:\s|\n[/#*\s]*)+)?{MARK}"
LIST = re.compile(rf"{MARK}{EXTENSION}(?:{SEPARATOR}{EXTENSION}){{2,}}")

# Formats that belong together: the extensions of Nastran and of PLOT3D, and the models of VTK.
FAMILIES = {frozenset((".bdf", ".nas", ".fem")),
            frozenset((".xyz", ".p3d", ".fmt", ".g", ".x", ".grd", ".ufmt")), frozenset((".vtp", ".vtu", ".vtk"))}


def registry():
    """The extensions of each content and use: {"Model write": [".obj", ...]}."""
    lists = {}
    for line in subprocess.run([PRINT_FORMATS], check=True, capture_output=True, text=True).stdout.splitlines():
        name, _, extensions = line.partition(": ")
        lists[name] = extensions.split()
    return lists


class Formats(unittest.TestCase):
    lists = registry()

    def test_table_of_formats(self):
        page = (ROOT / "docs/file-formats.md").read_text()
        got = {name: set() for name in self.lists}
        for row in re.findall(r"^\| (.*) \|$", page.split("## All formats")[0], re.M):
            cells = [cell.strip() for cell in row.split(" |")]
            extensions = re.findall(r"`(\.[a-z0-9]+)`", cells[0])
            if not extensions or extensions == [".foam"]:
                continue
            for extension in extensions:
                for name, cell, column in [("Lattice", r"\b(read|write)\b", 1), ("EditorMesh", r"", 1),
                                           ("Mesh", r"", 2), ("Model", r"", 3), ("Matrix", r"", 4)]:
                    is_editor_mesh = cells[column].startswith("poses: ")
                    if (name == "EditorMesh") != is_editor_mesh and column == 1:
                        continue
                    for part in cells[column].split("; "):
                        other = {"a bound model": "BoundModel", "targets of its points": "Targets",
                                 "displacements": "Displacements",
                                 "all poses in one file": "Animation"}.get(part.split(":")[0])
                        for use in re.findall(r"\b(read|write)\b", part):
                            got[f"{other or name} {use}"].add(extension)
        # Every model can be written again in its own format.
        expected = {name: set(extensions) for name, extensions in self.lists.items()}
        expected["Model write"] = expected["Model read"]
        got["Model read"].discard(".cgns")
        got["Model write"].discard(".cgns")  # an optional component
        self.assertEqual(got, expected)

    def test_other_lists(self):
        lists = {frozenset(extensions) for extensions in self.lists.values()}
        every = frozenset().union(*lists)
        known = {a | b for a in lists for b in lists} | {a - b for a in lists for b in lists} | FAMILIES
        found, wrong = 0, []
        for pattern in TEXTS:
            for path in sorted(ROOT.glob(pattern)):
                text = path.read_text()
                for match in LIST.finditer(text):
                    extensions = frozenset(re.findall(r"\.[a-z][a-z0-9]{0,5}", match.group()))
                    if len(extensions & every) < 3 or text[:match.start()].rstrip(" /*\n").endswith("such as"):
                        continue
                    found += 1
                    if extensions not in known:
                        line = text.count("\n", 0, match.start()) + 1
                        wrong.append(f"{path.relative_to(ROOT)}:{line}: {' '.join(match.group().split())}")
        self.assertGreater(found, 0)
        self.assertEqual(wrong, [], "\n".join(wrong))


if __name__ == "__main__":
    unittest.main()
