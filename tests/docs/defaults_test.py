#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that all front ends have the defaults of the library's option structs.

A header of the library gives each option its default. C repeats it in espalier_default_..._options() and in the
comment of the field, and so do Python's stubs and the comments of the npm package. The program needs no list: its
help shows the values of the structs."""
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# The options in C, and the structs of the library whose fields they have.
STRUCTS = {
    "refine": [("far/topology_refiner.h", "RefinerOptions")],
    "limit_stencil": [("limit/limit_stencils.h", "LimitStencilOptions")],
    "bind": [("bind/bind.h", "Level"), ("embed/embedding.h", "EmbeddingOptions"),
             ("bind/bind.h", "BindOptions")],
    "around": [("shapes/around.h", "AroundOptions")],
    "cage": [("cages/cage.h", "CageOptions")],
    "collar": [("cages/collar.h", "CollarOptions")],
    "torus": [("shapes/inventory.h", "TorusOptions")],
    "star": [("shapes/inventory.h", "StarOptions")],
    "barbell": [("shapes/inventory.h", "BarbellOptions")],
    "arm": [("shapes/inventory.h", "ArmOptions")],
    "fit": [("solve/lattice_fit.h", "FitOptions")],
    "pull": [("solve/rigid_pull.h", "RigidPullOptions")],
}
# The function in Python's stubs that takes them.
IN_PYTHON = {"refine": ("__init__.pyi", r"class Refiner:\s+def __init__"), "bind": ("__init__.pyi", "def bind"),
             "fit": ("__init__.pyi", "def fit"),
             "pull": ("__init__.pyi", r"class RigidPull:\s+def __init__")} | {
    shape: ("shapes.pyi", "def " + shape) for shape in ("around", "cage", "collar", "torus", "star", "barbell", "arm")}
# Python's default of these is None, which stands for the default of the library.
NONE_IN_PYTHON = {"boundary", "creasing", "triangles", "cells", "gradients"}

# The properties of the Blender add-on that stand for options.
IN_BLENDER = {"op_add.py": {"margin": ("around", "margin"), "cage_margin": ("cage", "margin"),
                            "vertices": ("cage", "vertices"), "cells": ("around", "cells_along_longest")},
              "settings.py": {"level": ("bind", "level")}}


def read(path):
    return (ROOT / path).read_text()


def value_of(text):
    """A number, or a word in the form of the library's words: "single-cell"."""
    text = text.strip().strip('"')
    if text in ("true", "True"):
        return 1.0
    if text in ("false", "False"):
        return 0.0
    try:
        return float(text)
    except ValueError:
        pass
    if "::" in text:
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", text.split("::")[-1]).lower()
    return text.lower().replace("_", "-")


def is_same(expected, got):
    """In C a word is a constant with a prefix: ESPALIER_SHARP_EDGES_SINGLE_CELL."""
    return got == expected or (isinstance(got, str) and got.startswith("espalier-") and
                               got.endswith(f"-{expected}"))


def fields_of(path, struct):
    """The defaults of a struct that are numbers or words: {"major_radius": 1.0}."""
    text = read(path)
    body = re.search(rf"struct {struct} \{{(.*?)\n\}};", text, re.S).group(1)
    fields = {}
    for name, value in re.findall(r"^\s*[\w:]+ (\w+) = ([^;{]+);", body, re.M):
        if re.fullmatch(r"k[A-Z]\w+", value):  # a constant, in this header or in another of its folder
            sources = [text, *(each.read_text() for each in (ROOT / path).parent.glob("*.h"))]
            value = next(found.group(1) for source in sources
                         if (found := re.search(rf"constexpr \w+ {value} = ([^;]+);", source)))
        fields[re.sub(r"(?=[A-Z])", "_", name).lower()] = value_of(value)
    if pattern := re.search(r"DiskPattern \w+ = \{(.*?)\};", body):
        fields |= fields_of("shapes/section.h", "DiskPattern")
        fields |= dict(zip(("rings", "core"), map(value_of, filter(None, pattern.group(1).split(", ")))))
    return fields


class Defaults(unittest.TestCase):
    def setUp(self):
        self.fields = {name: {key: value for struct in structs for key, value in fields_of(*struct).items()}
                       for name, structs in STRUCTS.items()}
        self.c = "".join(path.read_text() for path in sorted((ROOT / "c").glob("*.h")))

    def test_each_struct_has_defaults(self):
        for name, fields in self.fields.items():
            self.assertGreater(len(fields), 1, name)

    def test_all_options_of_c_are_known_here(self):
        names = set(re.findall(r"espalier_default_(\w+)_options\(void\)", self.c))
        # Their structs have no values: poses take pointers, and a check of validity has arguments.
        self.assertEqual(names, set(STRUCTS) | {"pose", "validity"})

    def test_functions_of_c(self):
        for name, fields in self.fields.items():
            body = re.search(rf"espalier_default_{name}_options\(void\) \{{(.*?)\n\}}", self.c, re.S).group(1)
            got = {key: value_of(value) for key, value in re.findall(r"options\.(\w+) = ([^;=]+);", body)}
            shared = set(fields) & set(got)
            self.assertGreater(len(shared), 1, name)
            for key in shared:
                self.assertTrue(is_same(fields[key], got[key]), f"{name}.{key}: {fields[key]}, in C {got[key]}")

    def test_comments_of_c(self):
        found = 0
        for name, fields in self.fields.items():
            body = re.search(rf"typedef struct espalier_{name}_options \{{(.*?)\n\}} espalier_{name}_options;", self.c,
                             re.S).group(1)
            for _, key, comment in re.findall(r"^    (\w+) (\w+);\s*///<((?:.*\n\s*///<)*.*)", body, re.M):
                comment = re.sub(r"\n\s*///<", " ", comment)
                said = re.search(r"default ([A-Z][A-Z0-9_]+|[-+.e0-9]+)\b", comment)
                if said and key in fields:
                    found += 1
                    got = value_of(said.group(1).rstrip("."))
                    self.assertTrue(got == fields[key], f"{name}.{key}: {fields[key]}, in the comment {got}")
        self.assertGreater(found, 20)

    def test_stubs_of_python(self):
        for name, (stub, begin) in IN_PYTHON.items():
            arguments = re.search(rf"{begin}\((.*?)\) ->", read("python/espalier/" + stub), re.S).group(1)
            got = dict(re.findall(r"(\w+): [^=]*? = ([^,\n]+)", arguments))
            shared = set(self.fields[name]) & set(got)
            self.assertGreater(len(shared), 1, name)
            for key in shared:
                if got[key] == "None":
                    self.assertIn(key, NONE_IN_PYTHON, name)
                else:
                    self.assertEqual(value_of(got[key]), self.fields[name][key], f"{name}.{key}")

    def test_properties_of_blender(self):
        """The properties of the add-on that stand for options of the library."""
        for file, properties in IN_BLENDER.items():
            text = read("hosts/blender/espalier_lattice/" + file)
            for key, (name, field) in properties.items():
                arguments = re.search(rf"^    {key}: bpy.props.\w+\((.*?)\n    \w", text, re.S | re.M).group(1)
                got = value_of(re.search(r"default=([^,)]+)", arguments).group(1))
                self.assertEqual(got, self.fields[name][field], f"{file}: {key}")

    def test_comments_of_npm(self):
        """A comment "default 200" belongs to the field after it, of an interface with the options of C's name."""
        found = 0
        for path in sorted((ROOT / "web/library").glob("*.ts")):
            for name, body in re.findall(r"interface (\w+)Options \{(.*?)\n\}", path.read_text(), re.S):
                fields = self.fields.get(name.lower())
                for said, key in re.findall(r"default ([-+.e0-9]+)[^*]*\*/\s*(\w+)\?:", body):
                    key = re.sub(r"(?=[A-Z])", "_", key).lower()
                    if fields and key in fields:
                        found += 1
                        self.assertEqual(value_of(said.rstrip(".")), fields[key], f"{path.name}: {name}.{key}")
        self.assertGreaterEqual(found, 3)


if __name__ == "__main__":
    unittest.main()
