#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/program.md: its examples print what the page shows, each combination of a command, an
option and a value in its table of options runs, and the page names all options of all commands.

    program_page_test.py PATH_OF_ESPALIER            runs the tests
    program_page_test.py PATH_OF_ESPALIER --write    puts the output of this program into the page
"""

import functools
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import program
from program import CliTest

PATH = pathlib.Path(__file__).resolve().parents[2] / "docs/program.md"
PAGE = PATH.read_text(encoding="utf-8")

# Finds the blocks of commands, each after "$ ", with their output.
CONSOLE = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.DOTALL | re.MULTILINE)

# Finds the numbers that depend on the run or on the machine: times, sizes, rounding errors.
VARIABLE = re.compile(r"\d+(\.\d+)? (s|B|kB|MB|GB|GB/s)\b|\b\d(\.\d+)?e-\d+")

# One run of each command, to which any option can be added. The tests remove -n 1 if --limit or --basis
# does not allow it.
COMMANDS = {
    "info": ["info", "box.ovm", "-n", 1],
    "shape": ["shape", "box", "-o", "out.ovm"],
    "pose": ["pose", "box.ovm", "--twist", "z", 30, "-o", "out.ovm"],
    "refine": ["refine", "box.ovm", "-n", 1, "-o", "out.ovm"],
    "stencils": ["stencils", "box.ovm", "-n", 1, "-o", "out%d.petsc"],
    "deform": ["deform", "model.obj", "--rest", "box.ovm", "--to", "pose.ovm", "-n", 1,
               "-o", "out.obj"],
    "bind": ["bind", "model.obj", "--rest", "box.ovm", "-n", 1, "-o", "out.espb"],
    "apply": ["apply", "bound.espb", "--to", "pose.ovm", "-o", "out.obj"],
    "fit": ["fit", "model.obj", "--rest", "box.ovm", "--targets", "targets.txt", "-n", 1,
            "-o", "out.ovm"],
    "check": ["check", "pose.ovm", "--rest", "box.ovm", "-n", 1],
    "page": ["page", "model.obj", "--rest", "box.ovm", "--to", "pose.ovm", "-n", 1, "-o", "out.html"],
    "bench": ["bench", "model.obj", "--rest", "box.ovm", "-n", 1, "--seconds", 0.001],
    "compare": ["compare", "box.ovm", "-n", 1],
}

# Runs with an input of another kind, for the values that need one: (command, option, value).
SPECIAL = {
    ("refine", "--rules", "rats"): ["refine", "mesh.obj", "-n", 1, "-o", "out.obj"],
    ("stencils", "--rules", "rats"): ["stencils", "mesh.obj", "-n", 1, "-o", "out.npz"],
    ("compare", "--boundary", "open"): ["compare", "mesh.obj", "-n", 1],
}

# Values that some commands of the option's row refuse, as the last column of the table says.
EXCEPTIONS = {
    ("--rules", "mlca"): {"compare"},
    ("--rules", "rats"): set(COMMANDS) - {"refine", "stencils"},
}

# Options that mean something else in a command than in the table.
OF_THEIR_OWN = {("pose", "--falloff"), ("fit", "--hold")}

# Values of the options whose rows do not list any. Flags have no value. All other options get their
# values from the table.
SAMPLES = {
    "--limit": [[]],
    "--gradients": [[]],
    "--keep-normals": [[]],
    "--weights": [["red"], ["green"]],
    "--only": [["part"]],
    "--hold": [["part"]],
    "--slide": [["part"]],
    "--falloff": [["0.5"]],
    "--level-tables": [[]],
    "--json": [[]],
    "--quiet": [[]],
    "--strict": [[]],
    "--tolerance": [["1e-6"], ["1e-9"]],
    "--threads": [["0"], ["2"]],
    "--max-memory": [["1000MB"], ["4GB"]],  # `bench` measures the memory's speed on 384 MB
    "--seconds": [["0.002"]],
}
FROM_TABLE = {"--basis", "--boundary", "--face-varying", "--creasing", "--triangles",
              "--sharp-edges", "--rules", "--petsc-indices", "--outside", "--report"}

QUOTED = re.compile(r"`([^`]+)`")


def rows_in(text):
    """Yields (option, cell of commands, cell of values) for each row of the table of options."""
    lines = iter(text.splitlines())
    head = next(line for line in lines if line.startswith("| option | commands |"))
    assert [cell.strip() for cell in head.strip("|").split("|")][:3] == \
        ["option", "commands", "values (default first)"], head
    next(lines)
    for line in itertools.takewhile(lambda line: line.startswith("|"), lines):
        option, commands, values, *_ = (cell.strip() for cell in line.strip("|").split("|"))
        yield QUOTED.fullmatch(option).group(1), commands, values


def commands_in(cell):
    """Returns the commands of a cell, each with the options that it needs there:
    {"deform": [], "stencils": ["--points"]}."""
    named = {words[0]: words[1:] for words in map(str.split, QUOTED.findall(cell))}
    unknown = set(named) - set(COMMANDS)
    assert not unknown, f"no commands: {unknown}"
    if cell == "all":
        return {command: [] for command in COMMANDS}
    if cell.startswith("all but "):
        return {command: [] for command in COMMANDS if command not in named}
    assert re.sub(r"`[^`]+`|,| ", "", cell) == "", cell
    return named


TABLE = {option: (commands_in(commands), values) for option, commands, values in rows_in(PAGE)}


def samples_of(option):
    """Returns the lists of arguments to try an option with."""
    if option in SAMPLES:
        return SAMPLES[option]
    assert option in FROM_TABLE, \
        f"{option} is in the page's table, but {pathlib.Path(__file__).name} has no sample of it"
    values = QUOTED.findall(TABLE[option][1])
    assert values, f"{option} has no values in the page's table"
    return [[value] for value in values]


def without(option, arguments):
    """Returns the arguments without an option and its value, if they are there."""
    if option not in arguments:
        return arguments
    at = arguments.index(option)
    return arguments[:at] + arguments[at + 2:]


def run_commands(block, folder):
    """Runs the commands of a block in a folder. Returns the block with the new output: for each command,
    standard output, then standard error."""
    lines, code = [], 0
    path = f"{os.path.dirname(program.ESPALIER)}:{os.environ['PATH']}"
    for command in re.findall(r"^\$ (.*)$", block, re.MULTILINE):
        result = subprocess.run(["bash", "-c", f"(exit {code}); {command}"], cwd=folder, text=True,
                                timeout=120, check=False, env={**os.environ, "PATH": path},
                                capture_output=True)
        code = result.returncode
        output = (result.stdout + result.stderr).splitlines()
        lines += [f"$ {command}", *(line.rstrip() for line in output)]
    return "".join(line + "\n" for line in lines)


def alike(text):
    """Returns the text with # for each variable number, and with one space for several."""
    return re.sub(r" +", " ", VARIABLE.sub("#", text))


def setUpModule():
    """Stands in for the page that scripts/web builds."""
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    page = pathlib.Path(folder.name) / "espalier.html"
    page.write_text('<script type="application/json" id="espalier-files"></script>')
    os.environ["ESPALIER_PAGE"] = str(page)


class Examples(CliTest):
    def test_they_print_what_the_page_shows(self):
        if "--html" not in self.run_program("compare", "--help").stdout:
            self.skipTest("built without OpenSubdiv")
        blocks = CONSOLE.findall(PAGE)
        self.assertGreater(len(blocks), 8)
        for block in blocks:
            self.assertEqual(alike(run_commands(block, self.path)), alike(block))

    def test_each_command_has_one(self):
        shown = set(re.findall(r"^\$ espalier (\w+)", "".join(CONSOLE.findall(PAGE)), re.MULTILINE))
        self.assertEqual(shown, set(COMMANDS) - {"bench"})

    def test_what_counts_as_alike(self):
        shown = "a   1.5 s   7.0 kB    0.053 GB/s\nresidual  1e-17\n"
        self.assertEqual(alike(shown), alike(shown.replace("1.5", "20.25").replace("1e-17", "2.5e-18")))
        self.assertNotEqual(alike(shown), alike(shown.replace("residual", "rest")))
        self.assertNotEqual(alike("1 of 2 files"), alike("2 of 2 files"))
        self.assertEqual(run_commands("$ echo 1 2\nanother\n$ (exit 3)\n$ echo $?\n", self.path),
                         "$ echo 1 2\n1 2\n$ (exit 3)\n$ echo $?\n3\n")


class Options(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--max", 3, 3, 3, "-o", "box.ovm")
        self.run_program("shape", "box", "--cells", 3, 3, 3, "--max", 3, 3, 4, "-o", "pose.ovm")
        # These points are in the region of all bases.
        points = [(1.25, 1.5, 1.75), (1.5, 1.25, 1.25), (1.75, 1.75, 1.5)]
        self.put("model.obj", "".join("v %g %g %g 1 0.5 0\n" % point for point in points) + "g part\nf 1 2 3\n")
        self.write_mesh()
        self.put("targets.txt", "0 1.25 1.5 1.8\n")
        self.bind("model.obj", "box.ovm", out="bound.espb")
        self.has_compare = "--html" in self.help("compare")  # no: built without OpenSubdiv

    @functools.cache
    def help(self, command):
        words = ["shape", "box"] if command == "shape" else [command]
        return self.run_program(*words, "--help").stdout

    def run_of(self, command, needed, option, values):
        arguments = SPECIAL.get((command, option, *values), COMMANDS[command])
        arguments = list(without(option, arguments))
        for other in needed:
            arguments += [other, "model.obj"] if other == "--points" else [other]
        arguments += [option, *values]
        takes_no_level = (("--limit" in arguments and command != "check") or
                          "bezier" in arguments or "bspline" in arguments)
        return without("-n", arguments) if takes_no_level else arguments

    def combinations(self):
        for option, (commands, _) in TABLE.items():
            for command, needed in commands.items():
                samples = samples_of(option)
                if command == "bench":  # Each run measures the memory's speed, in a second or more.
                    samples = samples[-1:]
                for values in samples:
                    yield command, needed, option, values

    def test_each_combination_of_the_table_runs(self):
        count = 0
        for command, needed, option, values in self.combinations():
            if command == "compare" and not self.has_compare:
                continue
            arguments = self.run_of(command, needed, option, values)
            is_exception = command in EXCEPTIONS.get((option, *values), ())
            with self.subTest(" ".join(map(str, arguments))):
                self.run_program(*arguments, code=2 if is_exception else 0)
            count += 1
        # Checks that the table was found and read.
        self.assertGreater(count, 150)

    def test_the_defaults_are_the_first_values(self):
        for option in FROM_TABLE:
            commands, values = TABLE[option]
            first = QUOTED.findall(values)[0]
            for command in commands:
                if command == "compare" and not self.has_compare:
                    continue
                with self.subTest(f"{command} {option}"):
                    self.assertRegex(self.help(command), rf"{option} [\w|-]+={first}\b")

    def test_no_command_has_an_option_that_is_not_there(self):
        named = set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", PAGE))
        for command in COMMANDS:
            if command == "compare" and not self.has_compare:
                continue
            for short, option in re.findall(r"^ +(?:(-\w),)?(--[a-z][a-z-]*)", self.help(command),
                                            re.MULTILINE):
                if option == "--help":
                    continue
                with self.subTest(f"{command} {option}"):
                    if option in TABLE and (command, option) not in OF_THEIR_OWN:
                        self.assertIn(command, TABLE[option][0],
                                      "the table has the option without this command")
                    elif command == "shape" and not short:
                        continue  # the page leaves these to `shape NAME --help`
                    else:
                        self.assertTrue({short, option} & named, "the page does not name it")


class ParsingTheTable(unittest.TestCase):
    """Checks that the tests above fail where they should."""

    def test_cells_of_commands(self):
        self.assertEqual(set(commands_in("all")), set(COMMANDS))
        self.assertEqual(set(commands_in("all but `shape`, `apply`")),
                         set(COMMANDS) - {"shape", "apply"})
        self.assertEqual(commands_in("`deform`, `stencils --points`"),
                         {"deform": [], "stencils": ["--points"]})
        for cell in ["`deforms`", "`deform` and such", "all but `shapes`"]:
            with self.assertRaises(AssertionError):
                commands_in(cell)

    def test_options_without_a_sample(self):
        with self.assertRaisesRegex(AssertionError, "--other is in the page's table, but"):
            samples_of("--other")

    def test_every_sample_is_of_an_option_of_the_table(self):
        self.assertEqual(set(SAMPLES) | FROM_TABLE, set(TABLE))


def write_outputs():
    """Runs the examples, and updates the page where their output has changed."""
    def updated(block):
        output = run_commands(block.group(), folder)
        return block.group() if alike(output) == alike(block.group()) else output
    with tempfile.TemporaryDirectory() as folder:
        page = CONSOLE.sub(updated, PAGE)
    PATH.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    if sys.argv[1:] == ["--write"]:
        write_outputs()
    else:
        unittest.main()
