#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that all front ends have the words of the library: "keep", "edge-only".

A header of the library lists the words of an enumeration (Word, base/word.h). Python's stubs, the constants
of C, the types of the npm package and the lists of the Blender add-on repeat them. A new word that one of
them lacks, or a word that only one of them has, fails here."""
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Each list has a name in each front end: a prefix of constants in C, a type or a parameter in Python's stubs,
# a field or a type on npm, and a property in Blender. None means that a front end does not offer the list.
LISTS = {
    "Rules": ("RULES", "_Rules", "rules", "rules"),
    "Boundary": ("BOUNDARY", "_Boundary", "boundary", None),
    "SharpEdges": ("SHARP_EDGES", "sharp_edges", "sharpEdges", None),
    "Creasing": ("CREASING", "creasing", None, None),
    "TriangleSubdivision": ("TRIANGLES", "triangles", None, None),
    "FaceVaryingLinear": (None, "_FaceVarying", None, None),
    "OutsidePolicy": ("OUTSIDE", "_Outside", "outside", "outside"),
    "Basis": ("BASIS", "basis", None, None),
    "Continuity": ("CONTINUITY", "continuity", None, None),
    "Smoothing": ("SMOOTHING", "smoothing", "smoothing", None),
    "Undetermined": ("UNDETERMINED", "undetermined", None, None),
    "Criterion": (None, "criterion", None, None),
    "Core": ("CORE", "_Core", "DiskCore", None),
    "TorusSection": ("SECTION", "section", None, None),
    "Symmetric": ("SYMMETRIC", "symmetric", "symmetric", None),
    "Falloff": ("FALLOFF", "_Falloff", "profile", None),
    "AxisLink": (None, "link", None, None),
    "TurnOrder": (None, "order", None, None),
}
# Words for the program alone.
ONLY_HERE = {"ReportFormat", "PetscInt"}

# The word in C, where it differs; None if C has none.
IN_C = {
    "rats": None,  # rules for meshes; C has lattices only
    "subdivision": None,  # another function binds by a basis
    "error": "refuse",  # ESPALIER_ERROR_... are statuses
}
# Blender offers what an artist needs.
NOT_IN_BLENDER = {"rats": "for meshes", "error": "an operator cannot fail for a point"}


def words_of_library():
    """The words of each list, in their order."""
    found = {}
    for folder in "base far shapes stencils embed limit bind osd solve cages io cli".split():
        for path in [*(ROOT / folder).rglob("*.h"), *(ROOT / folder).rglob("*.cpp")]:
            for name, body in re.findall(r"\bWord<[^;]*?> k(\w+)Words\[\] = \{(.*?)\};", path.read_text(), re.S):
                found[name] = re.findall(r'\{\s*"([^"]+)"\s*,', body)
    return found


def words_of_c(words):
    return [IN_C.get(word, word) for word in words if IN_C.get(word, word) is not None]


class Words(unittest.TestCase):
    lists = words_of_library()

    def test_each_list_of_the_library_is_known_here(self):
        self.assertEqual(set(self.lists), set(LISTS) | ONLY_HERE)
        for name, words in self.lists.items():
            self.assertGreater(len(words), 1, name)
            self.assertEqual(len(words), len(set(words)), name)

    def test_constants_of_c(self):
        text = "".join(path.read_text() for path in sorted((ROOT / "c").glob("*.h")))
        for name, (prefix, *_) in LISTS.items():
            if prefix:
                got = re.findall(rf"\bESPALIER_{prefix}_(\w+) = (\d+)", text)
                expected = [(word.upper().replace("-", "_"), str(value))
                            for value, word in enumerate(words_of_c(self.lists[name]))]
                self.assertEqual(got, expected, name)

    def test_stubs_of_python(self):
        text = "".join(path.read_text() for path in sorted((ROOT / "python/espalier").glob("*.pyi")))
        for name, (_, field, *_) in LISTS.items():
            if field:
                got = re.findall(rf"\b{field}(?:: | = )Literal\[(.*?)\]", text, re.S)
                self.assertTrue(got, name)
                for each in got:
                    self.assertEqual(re.findall(r'"([^"]+)"', each), self.lists[name], name)

    def test_types_of_npm(self):
        text = "".join(path.read_text() for path in sorted((ROOT / "web/library").glob("*.ts")))
        for name, (_, _, field, _) in LISTS.items():
            if field:
                got = re.findall(rf'\b{field}(?:\?:| =) ((?:"[a-z0-9-]+"(?: \| )?)+);', text)
                self.assertTrue(got, name)
                for each in got:
                    self.assertEqual(re.findall(r'"([^"]+)"', each), words_of_c(self.lists[name]), name)

    def test_lists_of_blender(self):
        text = (ROOT / "hosts/blender/espalier_lattice/settings.py").read_text()
        for name, (*_, field) in LISTS.items():
            if field:
                items = re.search(rf"\b{field}: bpy\.props\.EnumProperty\((.*?)\)\)\)", text, re.S).group(1)
                expected = [word for word in self.lists[name] if word not in NOT_IN_BLENDER]
                self.assertEqual(re.findall(r'\(\s*"([a-z0-9-]+)", "', items), expected, name)


if __name__ == "__main__":
    unittest.main()
