#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The zip of the Blender add-on: its files, and that a failure leaves no zip. Needs neither Blender nor the module.

    blender_zip_test.py
"""

import ast
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

TOP = pathlib.Path(__file__).resolve().parents[2]
ADD_ON = TOP / "hosts/blender/espalier_lattice"


class BlenderZip(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)
        self.package = self.path / "build/python/espalier"
        self.package.mkdir(parents=True)
        (self.package / "__init__.py").write_text("")
        self.zip = self.path / "zips/a.zip"
        self.zip.parent.mkdir()
        self.zip.write_text("an older zip")

    def make(self):
        return subprocess.run([sys.executable, TOP / "hosts/blender/make_zip.py", self.path / "build", "-o", self.zip],
                              capture_output=True, text=True)

    def check_no_zip(self, result, message):
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(message, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        self.assertEqual(list(self.zip.parent.iterdir()), [])

    def test_the_files(self):
        (self.package / "_core.cpython-311-x86_64-linux-gnu.so").write_bytes(b"module")
        result = self.make()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([path.name for path in self.zip.parent.iterdir()], ["a.zip"])
        with zipfile.ZipFile(self.zip) as archive:
            names = set(archive.namelist())
        expected = {path.name for path in ADD_ON.iterdir() if path.suffix in (".py", ".toml")} | {
            "LICENSE", "lib/espalier/__init__.py", "lib/espalier/_core.cpython-311-x86_64-linux-gnu.so"}
        self.assertEqual(names, {"espalier_lattice/" + name for name in expected})
        self.assertLess({"__init__.py", "blender_manifest.toml", "operators.py"}, expected)

    def test_a_build_without_the_module_leaves_no_zip(self):
        self.check_no_zip(self.make(), "there is no Python module; run scripts/blender")

    def test_a_file_that_cannot_be_read_leaves_no_zip(self):
        (self.package / "_core.so").write_bytes(b"module")
        (self.package / "gone.py").symlink_to(self.path / "nowhere")
        self.check_no_zip(self.make(), "gone.py")

    def test_a_build_that_fails_leaves_no_zip(self):
        """scripts/blender, with programs that stand in for the package manager and CMake."""
        programs = self.path / "programs"
        programs.mkdir()
        for name, text in (("dpkg-query", "echo install ok installed"), ("cmake", "echo no compiler >&2; exit 3")):
            (programs / name).write_text("#!/bin/sh\n" + text + "\n")
            (programs / name).chmod(0o755)
        result = subprocess.run([TOP / "scripts/blender", "-o", self.zip], capture_output=True, text=True,
                                env={**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"})
        self.check_no_zip(result, "no compiler")

    def test_an_unknown_option_is_told(self):
        result = subprocess.run([TOP / "scripts/blender", "--instal"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertIn("scripts/blender [--install]", result.stderr)

    def test_the_manifest_says_the_same_as_bl_info(self):
        text = (ADD_ON / "__init__.py").read_text()
        info = ast.literal_eval(re.search(r"bl_info = (\{.*?\n\})", text, re.S).group(1))
        manifest = dict(re.findall(r'^(\w+) = "(.*)"$', (ADD_ON / "blender_manifest.toml").read_text(), re.M))
        self.assertEqual(manifest["version"], ".".join(map(str, info["version"])))
        self.assertEqual((manifest["name"], manifest["tagline"], manifest["maintainer"]),
                         (info["name"], info["description"], info["author"]))
        self.assertEqual(manifest["id"], ADD_ON.name)
        self.assertLessEqual(len(manifest["tagline"]), 64)


if __name__ == "__main__":
    unittest.main()
