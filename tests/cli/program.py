# SPDX-License-Identifier: Apache-2.0
"""Helpers of the tests of the program: each test gets a folder, and writes and reads files there."""

import json
import math
import os
import pathlib
import pty
import resource
import signal
import subprocess
import tempfile
import unittest

ESPALIER = ""  # path of the program; the tests set it


def icosphere_points(count):
    """Returns points well inside the unit cube, on a spiral around its middle."""
    points = []
    for i in range(count):
        z = 1 - 2 * (i + 0.5) / count
        angle = math.pi * (3 - math.sqrt(5)) * i
        radius = math.sqrt(1 - z * z)
        points.append((0.5 + 0.4 * radius * math.cos(angle),
                       0.5 + 0.4 * radius * math.sin(angle), 0.5 + 0.4 * z))
    return points


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def text(self, name):
        return (self.path / name).read_text()

    def bytes(self, name):
        return (self.path / name).read_bytes()

    def put(self, name, text):
        (self.path / name).write_text(text)

    def run_program(self, *arguments, code=0):
        result = subprocess.run([ESPALIER, *map(str, arguments)], cwd=self.path, encoding="utf-8",
                                capture_output=True, timeout=120)
        self.assertEqual(result.returncode, code, result.stderr)
        if code != 0:
            self.assertEqual(result.stderr.count("\n"), 1, "one line: " + result.stderr)
        return result

    def error_of(self, *arguments, code=1):
        return self.run_program(*arguments, code=code).stderr

    def assert_nothing_is_lost_on_a_full_disk(self, *arguments, output, room=4096,
                                               named=None):
        """Checks that a command that can write at most `room` bytes a file reports the error, and
        leaves all files unchanged. `named` is a pattern for the file that the message names; by
        default the output."""
        def fill():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

        self.put(output, "old")
        before = {path: path.read_bytes() for path in self.path.iterdir()}
        result = subprocess.run([ESPALIER, *map(str, arguments), "-o", output], cwd=self.path,
                                text=True, capture_output=True, timeout=120, preexec_fn=fill)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, rf"^espalier: {named or output}: cannot write: File too large\n$")
        self.assertEqual({path: path.read_bytes() for path in self.path.iterdir()}, before)

    def write_model(self, points, name="model.obj"):
        lines = ["# a comment"] + ["v %.17g %.17g %.17g" % p for p in points]
        lines += ["vt 0 0", "f 1/1 2/1 3/1"]
        self.put(name, "\n".join(lines) + "\n")

    def write_mesh(self, tags=(), name="mesh.obj"):
        """Writes a plane of 3 by 3 squares. Vertices 0, 3, 12 and 15 are its corners; 5 is inside."""
        lines = [f"v {i % 4} {i // 4} {0.1 * (i % 3)}" for i in range(16)]
        for j in range(3):
            for i in range(3):
                a = 4 * j + i + 1
                lines.append(f"f {a} {a + 1} {a + 5} {a + 4}")
        self.put(name, "\n".join([*lines, *tags]) + "\n")

    def read_points(self, name):
        lines = self.text(name).splitlines()
        return [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith("v ")]

    def read_ovm_positions(self, name):
        lines = self.text(name).splitlines()
        at = lines.index("Vertices")
        count = int(lines[at + 1])
        return [tuple(map(float, line.split())) for line in lines[at + 2:at + 2 + count]]

    def write_positions(self, name, rest, positions):
        """Writes the lattice `rest` with other positions of its vertices."""
        lines = self.text(rest).splitlines()
        at = lines.index("Vertices") + 2
        lines[at:at + len(positions)] = ["%.17g %.17g %.17g" % tuple(p) for p in positions]
        self.put(name, "\n".join(lines) + "\n")

    def write_pose(self, name, rest, move):
        """Writes the lattice `rest` with each vertex moved. Returns the positions."""
        positions = [move(p) for p in self.read_ovm_positions(rest)]
        self.write_positions(name, rest, positions)
        return positions

    def deform(self, model, rest, pose, *options, out):
        return self.run_program("deform", model, "--rest", rest, "--to", pose, *options, "-o", out)

    def bind(self, model, rest, *options, out):
        return self.run_program("bind", model, "--rest", rest, *options, "-o", out)

    def shown_on_a_terminal(self, *arguments):
        """Returns the text that a successful command shows on a terminal."""
        terminal, other_end = pty.openpty()
        subprocess.run([ESPALIER, *map(str, arguments)], cwd=self.path, check=True, timeout=120,
                       stdout=subprocess.DEVNULL, stderr=other_end)
        os.close(other_end)
        shown = os.read(terminal, 100000).decode()
        os.close(terminal)
        return shown

    def assert_close(self, points, expected, bound):
        self.assertEqual(len(points), len(expected))
        for p, q in zip(points, expected):
            self.assertLess(math.dist(p, q), bound)

    def product(self, name, points):
        """Multiplies a matrix by points."""
        lines = [line for line in self.text(name).splitlines() if not line.startswith("%")]
        product = [[0.0] * 3 for _ in range(int(lines[0].split()[0]))]
        for line in lines[1:]:
            row, column, weight = line.split()
            for c in range(3):
                product[int(row) - 1][c] += float(weight) * points[int(column) - 1][c]
        return product

    def info(self, *arguments):
        return json.loads(self.run_program("info", *arguments, "--json").stdout)
