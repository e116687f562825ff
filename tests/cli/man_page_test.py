#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The manual page, which the program makes of its own help: it has every command and every option,
its source is correct, and its examples run.

    man_page_test.py PATH_OF_ESPALIER PATH_OF_THE_PAGE
"""

import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import unittest

import program
from program import CliTest, icosphere_points

PAGE = None  # path of the page that the build made; set by main


def options_in(help_text):
    """The options that a help text lists: [("-n", "--level"), ("--json",)]."""
    lines = re.findall(r"^ +(-[-\w,]+)", help_text, re.MULTILINE)
    return [tuple(line.split(",")) for line in lines]


def commands_in(help_text):
    """The subcommands that a help text lists."""
    _, found, listed = help_text.partition("\nSubcommands:\n")
    return re.findall(r"^  (\w+)", listed, re.MULTILINE) if found else []


def unescaped(text):
    return re.sub(r"\\f[BIR]", "", text).replace("\\-", "-").replace("\\e", "\\")


class ManPage(CliTest):
    def setUp(self):
        super().setUp()
        self.page = PAGE.read_text(encoding="utf-8")

    def part(self, heading):
        """The text below a heading, as a reader sees it."""
        parts = re.split(r"^\.S[SH] (.*)$", self.page, flags=re.MULTILINE)
        found = [text for name, text in zip(parts[1::2], parts[2::2]) if unescaped(name) == heading]
        self.assertEqual(len(found), 1, f"{heading} is there {len(found)} times")
        return unescaped(found[0])

    def commands(self, *words):
        """Each command with its help: (["shape", "box"], help)."""
        text = self.run_program(*words, "--help").stdout
        yield list(words), text
        for command in commands_in(text):
            yield from self.commands(*words, command)

    def test_the_build_made_it(self):
        self.assertEqual(self.page, self.run_program("--man").stdout)

    def test_it_has_every_command_and_every_option(self):
        common = self.part("COMMON OPTIONS")
        count = 0
        for words, text in self.commands():
            part = self.part(" ".join(["espalier", *words]) if words else "OPTIONS")
            if words:
                self.assertIn(words[0], self.part("SYNOPSIS"))
            for names in options_in(text):
                with self.subTest(" ".join([*words, names[-1]])):
                    if words and names[-1] == "--help":
                        continue  # stated once, for all
                    self.assertIn(names[-1], part)
                    described = [", ".join(names) in where for where in (part, common)]
                    self.assertIn(True, described)
                count += 1
        self.assertGreater(count, 150)

    def test_it_says_what_the_help_says(self):
        for words, text in self.commands():
            if words:
                description = text.splitlines()[0]
                self.assertIn(description, self.part(" ".join(["espalier", *words])))
        self.assertIn("Default: 0.2.", self.part("espalier bench"))
        self.assertIn("Only with --hold.", self.part("espalier fit"))
        self.assertIn("Required.", self.part("espalier apply"))

    def test_troff_has_no_warnings(self):
        if shutil.which("groff") is None:
            self.skipTest("needs groff")
        result = subprocess.run(["groff", "-k", "-man", "-ww", "-Tutf8", PAGE], check=False,
                                capture_output=True)
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        self.assertIn("EXIT STATUS", re.sub("\x1b\\[[0-9]*m|.\x08", "", result.stdout.decode()))

    def test_mandoc_has_no_warnings(self):
        if shutil.which("mandoc") is None:
            self.skipTest("needs mandoc")
        result = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", PAGE], check=False,
                                text=True, capture_output=True)
        # A date would make each build another one.
        warnings = [line for line in result.stdout.splitlines() if "missing date" not in line]
        self.assertEqual((warnings, result.stderr), ([], ""))

    def test_the_examples_run(self):
        self.write_model(icosphere_points(20))
        self.run_program("shape", "box", "--cells", 2, 2, 4, "--max", 1, 1, 5, "-o", "pose.vtu")
        lines = re.findall(r"^espalier (.*)$", self.part("EXAMPLES"), re.MULTILINE)
        self.assertGreater(len(lines), 3)
        for line in lines:
            self.run_program(*shlex.split(line))

    def test_the_parts_of_a_help_text(self):
        text = "Usage: x\n\nOptions:\n  -n,--level INT=2\n                  Not -this\n  --json  Print\n"
        self.assertEqual(options_in(text), [("-n", "--level"), ("--json",)])
        self.assertEqual(commands_in(text), [])
        self.assertEqual(commands_in(text + "\nSubcommands:\n  box    One\n  arm\n"), ["box", "arm"])


if __name__ == "__main__":
    PAGE = pathlib.Path(sys.argv.pop())
    program.ESPALIER = sys.argv.pop()
    unittest.main()
