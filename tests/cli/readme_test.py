#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README.md and docs/your-model.md: their commands run, and README.md stays short. (tests/docs checks
code and links.)

    readme_test.py PATH_OF_ESPALIER
"""

import os
import pathlib
import re
import shlex
import sys
import unittest

import program
from program import CliTest, icosphere_points

TOP = pathlib.Path(__file__).resolve().parents[2]
README = (TOP / "README.md").read_text(encoding="utf-8")
MAX_WORDS = 1300


def commands_in(page):
    """Returns the lines of all blocks of commands, split into words, without comments."""
    return [shlex.split(line, comments=True)
            for block in re.findall(r"^```sh\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
            for line in block.splitlines()]


COMMANDS = commands_in(README)


class Readme(CliTest):
    def test_it_is_short(self):
        self.assertLessEqual(len(README.split()), MAX_WORDS)

    def test_the_commands_of_the_program_run(self):
        self.write_model(icosphere_points(20))
        self.write_mesh()
        self.run_program("shape", "cylinder", "-o", "lattice.vtu")
        has_compare = "--html" in self.run_program("compare", "--help").stdout
        commands = [words[1:] for words in COMMANDS if words[0] == "espalier"]
        self.assertEqual([words[0] for words in commands], ["shape", "pose", "deform", "compare"])
        for words in commands:
            if words[0] != "compare" or has_compare:
                self.run_program(*words)
        self.assertTrue((self.path / "twisted.obj").is_file())

    def test_the_commands_for_a_model_of_your_own_run(self):
        self.write_model(icosphere_points(200))
        page = (TOP / "docs/your-model.md").read_text(encoding="utf-8")
        commands = commands_in(page)
        self.assertGreater(len(commands), 6)
        for words in commands:
            if "posed-editor.obj" in words:  # which an editor writes
                (self.path / "posed-editor.obj").write_bytes(self.bytes("editor.obj"))
            if words[0] == "espalier":
                self.run_program(*words[1:])
        for output in ["posed.obj", "twisted.obj", "pulled.obj", "frame-0001.obj"]:
            self.assertTrue((self.path / output).is_file(), output)

    def test_the_scripts_are_there(self):
        scripts = {words[0] for words in COMMANDS} - {"espalier"}
        self.assertEqual(scripts, {"scripts/demo", "scripts/test", "scripts/agreement"})
        for script in scripts:
            self.assertTrue(os.access(TOP / script, os.X_OK), script)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
