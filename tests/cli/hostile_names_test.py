#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names that nobody would choose, of files and in them: what the program says of them is printable.

    hostile_names_test.py PATH_OF_ESPALIER
"""

import json
import os
import subprocess
import sys
import unicodedata
import unittest

import program
from program import CliTest, icosphere_points

# Parts of names of files. None has a slash, or more bytes than a name can have.
HOSTILE = [b"a\nespalier: forged", b"\x1b[2J\x1b]0;title\x07", b"\r\x08\x7f", "\u0085\u009b2J".encode(),
           b"\x9b2J\x80\x9f", "\u202etxt\u202c\u2066\u2069\u2028\u2029".encode(), b"gr\xf6\xdfe",
           b"\xc3\x28\xed\xa0\x80\xf4\x90\x80\x80"]
# Every command meets all parts in one name, and a name that is long. One command meets each part alone.
TOGETHER = [b"+".join(HOSTILE), b"n" * 200]
LONG = b"/".join([b"x" * 199] * 60)  # of 12,000 bytes


class HostileNames(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 3, 3, 3, "-o", "rest.vtu", "--quiet")
        self.write_model(icosphere_points(20))
        self.put("empty.html", '<script type="application/json" id="espalier-files"></script>')

    def run_bytes(self, *arguments):
        arguments = [a if isinstance(a, bytes) else str(a).encode() for a in arguments]
        return subprocess.run([os.fsencode(program.ESPALIER), *arguments], cwd=self.path,
                              capture_output=True, timeout=120)

    def assert_printable(self, output):
        """That it is UTF-8, and has no characters that a terminal obeys, but ends of lines."""
        text = output.decode()  # throws what is not UTF-8
        for character in text.replace("\n", ""):
            self.assertNotIn(unicodedata.category(character), ["Cc", "Cf", "Cn", "Zl", "Zp"],
                             repr(text))
        return text

    def refused(self, *arguments):
        """The message of a command that fails: one printable line."""
        result = self.run_bytes(*arguments)
        self.assertIn(result.returncode, [1, 2], (arguments, result.stderr))
        text = self.assert_printable(result.stderr)
        self.assertEqual((text.count("\n"), text[-1]), (1, "\n"), repr(text))
        self.assertTrue(text.startswith("espalier: "))
        self.assertLess(len(result.stderr), 2100)
        self.assert_printable(result.stdout)
        return text

    def succeeds(self, *arguments):
        result = self.run_bytes(*arguments)
        self.assertEqual((result.returncode, result.stderr), (0, b""), arguments)
        return self.assert_printable(result.stdout)

    def commands(self, lattice, model, output, bound):
        """All commands, with these files (bytes) as all that they take."""
        yield "info", lattice
        yield "info", lattice, "--json"
        yield "shape", "merge", lattice, lattice, "-o", output + b".vtu"
        yield "shape", "box", "-o", output + b".vtu"
        yield "shape", "around", model, "-o", output + b".vtu"
        yield "pose", lattice, "--twist", "z", 30, "-o", output + b".vtu"
        yield "refine", lattice, "-n", 1, "-o", output + b".vtu"
        for extension in [b".mtx", b".npy", b".npz", b".petsc"]:
            yield "stencils", lattice, "-n", 1, "-o", output + extension
        yield "stencils", lattice, "-n", 2, "--level-tables", "-o", output + b".%d.mtx"
        yield "stencils", lattice, "-n", 1, "--points", model, "-o", output + b".mtx"
        yield "deform", model, "--rest", lattice, "--to", lattice, "-n", 1, "-o", output + b".obj"
        yield ("deform", model, "--rest", lattice, "--to", lattice, lattice, "-n", 1, "-o",
               output + b".obj", "--report", "json")
        yield "bind", model, "--rest", lattice, "-n", 1, "-o", bound
        yield "apply", bound, "--to", lattice, "-o", output + b".obj"
        yield "bench", model, "--rest", lattice, "-n", 1, "--seconds", 0.001
        yield ("fit", model, "--rest", lattice, "--targets", model, "-n", 1, "-o",
               output + b".vtu")
        yield "check", lattice, "--rest", lattice, "-n", 1, "-o", output + b".vtu"
        yield ("page", model, "--rest", lattice, "--to", lattice, "--page", "empty.html", "-o",
               output + b".html")

    def test_paths_in_reports(self):
        for name in HOSTILE:
            (self.path / os.fsdecode(name + b".vtu")).write_bytes(self.bytes("rest.vtu"))
            self.succeeds("info", name + b".vtu")
        for name in TOGETHER:
            lattice, model = name + b".vtu", name + b".obj"
            for source, target in [("rest.vtu", lattice), ("model.obj", model)]:
                (self.path / os.fsdecode(target)).write_bytes(self.bytes(source))
            for command in self.commands(lattice, model, b"out" + name, name + b".espb"):
                if "merge" not in command:  # a lattice with itself is none
                    self.succeeds(*command)

    def test_paths_in_errors(self):
        for name in HOSTILE:
            self.refused("info", name)
        for name in [*TOGETHER, LONG]:
            bad = name + b" is not there"
            for command in self.commands(bad + b".vtu", b"model.obj", b"out", b"none.espb"):
                if bad + b".vtu" in command or b"none.espb" in command:
                    self.refused(*command)
            for command in self.commands(b"rest.vtu", b"model.obj", bad + b"/out",
                                         bad + b"/out.espb"):
                if command[0] not in ["info", "bench"]:
                    self.refused(*command)
            for command in self.commands(b"rest.vtu", bad + b".obj", b"out", bad + b".espb"):
                if bad + b".obj" in command or bad + b".espb" in command:
                    self.refused(*command)

    def test_words_of_the_command_line(self):
        for name in HOSTILE:
            self.refused("info", "rest.vtu", "--rules", name)
        for name in [*TOGETHER, LONG]:
            self.refused(name)
            self.refused("info", b"--" + name)
            self.refused("info", "rest.vtu", name)
            self.refused("info", "rest.vtu", "--rules", name)
            self.refused("info", "rest.vtu", "-n", name)
            self.refused("--max-memory", name, "info", "rest.vtu")
            self.refused("shape", "arm", "--joint", name, "-o", "arm.vtu")
            for option in ["--select", "--twist", "--move", "--falloff", "--toward"]:
                self.refused("pose", "rest.vtu", option, name, "-o", "pose.vtu")
            for kind in ["attribute", "box", "end", "vertices"]:
                self.refused("pose", "rest.vtu", "--select", kind, name, "-o", "pose.vtu")
            self.refused("deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu", "-o",
                         b"%" + name)
            self.refused("bind", "model.obj", "--rest", "rest.vtu", "--tolerance", name, "-o",
                         "b.espb")

    def test_a_long_path_keeps_its_ends(self):
        text = self.refused("info", b"begin" + LONG + b"/end.vtu")
        self.assertTrue(text.startswith("espalier: beginxxx"), text)
        self.assertIn("xxx/end.vtu: cannot open: File name too long", text)
        self.assertLess(len(text), 400)

    def test_names_of_attributes(self):
        self.run_program("refine", "rest.vtu", "-n", 0, "-o", "rest.ovm")
        plain = self.bytes("rest.ovm")
        count = int(plain.split(b"Vertices\n")[1].split()[0])
        for name in HOSTILE:
            if b"\n" in name or b"\r" in name:
                continue  # one line holds the name
            values = b"\n".join([b"1"] * count) + b"\n"
            (self.path / "a.ovm").write_bytes(
                plain + b'VProp double "' + name + b'"\n' + values)
            self.succeeds("info", "a.ovm", "-n", 0)
            report = json.loads(self.succeeds("info", "a.ovm", "-n", 0, "--json"))
            self.assertEqual(report["attributes"], [name.decode(errors="replace")])
            (self.path / "broken.ovm").write_bytes(
                plain + b'VProp double "' + name + b'"\n' + values.replace(b"1", name, 1))
            self.refused("info", "broken.ovm")

    def test_json_of_names_that_are_not_utf8(self):
        for name in HOSTILE:
            path = name + b".vtu"
            (self.path / os.fsdecode(path)).write_bytes(self.bytes("rest.vtu"))
            report = json.loads(self.succeeds("info", path, "-n", 0, "--json"))
            self.assertEqual(report["lattice"], path.decode(errors="replace"))

    def test_names_of_data_that_a_converted_model_lacks(self):
        head = (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                b"property float z\n")
        for name in [*TOGETHER, b"x" * 12000]:
            word = b"".join(name.split())
            (self.path / "model.ply").write_bytes(
                head + b"".join(b"property float %s%d\n" % (word, i) for i in range(9)) +
                b"end_header\n0 0 0 1 2 3 4 5 6 7 8 9\n")
            result = self.run_bytes("deform", "model.ply", "--rest", "rest.vtu", "--to",
                                    "rest.vtu", "-o", "out.obj")
            self.assertEqual(result.returncode, 0, result.stderr)
            text = self.assert_printable(result.stderr)
            self.assertIn("data that are not written: properties of points '", text)
            self.assertEqual(text.count("\n"), 1)
            self.assertLess(len(text), 1000)

    def test_words_of_files(self):
        for word in [b"".join(TOGETHER[0].split()), b"x" * 12000]:
            samples = {
                "w.obj": b"v 0 0 " + word + b"\n",
                "tag.obj": b"v 0 0 0\nf 1 1 1\nt crease " + word + b"\n",
                "w.ply": b"ply\nformat ascii 1.0\n" + word + b"\n",
                "name.ply": b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                            b"property float y\nproperty float z\nelement " + word +
                            b" 3\nproperty float a\nend_header\n0 0 0\n0 0 0\n1\n",
                "w.stl": b"solid\nfacet " + word + b"\n",
                "w.ovm": b"OVM ASCII\n" + word + b"\n",
                "w.vtk": b"# vtk DataFile Version 3.0\n\nASCII\nDATASET " + word + b"\n",
                "word.vtk": b"# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n"
                            b"0 0 0\n" + word + b"\n",
                "w.vtp": b"<VTKFile type=\"" + word + b"\"/>",
                "w.vtu": b"<VTKFile type=\"" + word + b"\"/>",
                "w.espb": word,
            }
            for name, contents in samples.items():
                (self.path / name).write_bytes(contents)
                if name.endswith(".espb"):
                    self.refused("apply", name, "--to", "rest.vtu", "-o", "out.obj")
                elif name in ["w.obj", "w.ply", "name.ply", "w.stl", "word.vtk", "w.vtp"]:
                    self.refused("bind", name, "--rest", "rest.vtu", "-o", "out.espb")
                if name.endswith((".obj", ".ovm", ".vtk", ".vtu")):
                    self.refused("refine", name, "-o", "out.obj")
            (self.path / "targets.txt").write_bytes(b"0 0 0 " + word + b"\n")
            self.refused("fit", "model.obj", "--rest", "rest.vtu", "--targets", "targets.txt",
                         "-o", "out.vtu")


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    unittest.main()
