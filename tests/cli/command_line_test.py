#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What users type: help, misspelt words, several numbers, "-", --version, and completion by shells.

    command_line_test.py PATH_OF_ESPALIER FOLDER_OF_THE_COMPLETIONS
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import program
from man_page_test import commands_in, options_in
from program import CliTest

COMPLETIONS = None  # folder of espalier.bash and _espalier, made by the build; set by main


class Help(CliTest):
    def test_help_is_printed_for_each_form_of_asking(self):
        for question, answer in [(["help"], ["--help"]), (["help", "deform"], ["deform", "--help"]),
                                 (["help", "shape", "box"], ["shape", "box", "--help"])]:
            self.assertEqual(self.run_program(*question).stdout, self.run_program(*answer).stdout)

    def test_a_missing_command_prints_the_help(self):
        for words in [[], ["shape"]]:
            result = self.run_program(*words, code=2)
            self.assertEqual(result.stdout, self.run_program(*words, "--help").stdout)
            self.assertEqual(result.stderr, "espalier: expected a command, as listed above\n")


class EveryCommand(CliTest):
    def commands(self):
        """The words of each command: ["deform"], ["shape", "box"]."""
        programs = commands_in(self.run_program("--help").stdout)
        return [[name] for name in programs if name != "shape"] + [
            ["shape", name] for name in commands_in(self.run_program("shape", "--help").stdout)]


class Numbers(EveryCommand):
    """Every number that an option takes, of every command: by the help, which the program makes from its own
    options."""
    WORDS = {"AXIS": "x", "linear|smooth": "linear"}  # of options with words before their numbers

    def numeric_options(self, *command):
        """The options of a command that take numbers: (name, a word for each value, indices of the numbers)."""
        text = self.run_program(*command, "--help").stdout
        for name, form in re.findall(r"^  (?:-\w,)?(--[\w-]+) (\S.*?)(?:  |$)", text, re.MULTILINE):
            form = re.sub(r"=\S+| x \d+|\.\.\.|REQUIRED|\[.*?\]|(Excludes|Needs): .*", "", form)
            words = form.split("|")[-1].split() if "|" in form and form[0].isupper() else form.split()
            words = [word.split(":")[0] for word in words if not word.startswith(("to", "and", "at"))]
            numbers = [i for i, word in enumerate(words) if re.fullmatch("[A-Z][A-Z0-9]*", word)
                       and word not in ("TEXT", "DIRECTION", "SIZE", "KIND", "AXIS", "NAME", "GROUP")]
            if numbers:
                yield name, [self.WORDS.get(word, "1") for word in words], numbers

    def test_those_that_are_not_finite_are_refused(self):
        tried = set()
        for command in self.commands():
            for name, words, numbers in self.numeric_options(*command):
                for i in numbers:
                    for bad in ("nan", "inf", "-inf", "1e999", ""):
                        values = words[:i] + [bad] + words[i + 1:]
                        with self.subTest(command=command, option=[name, *values]):
                            # A number that is not required could be the missing file otherwise.
                            file = ["x.obj"] if command in (["pose"], ["shape", "around"]) else []
                            error = self.error_of(*command, *file, name, *values, code=2)
                            if bad != "-inf":
                                self.assertIn(name + ": expected", error)
                                self.assertTrue(error.endswith(f"got {bad or 'nothing'}\n"), error)
                            else:
                                self.assertRegex(error, f"{name}: expected .*, got -inf$|: -inf: expected a finite")
                tried.add(" ".join([*command, name]))
        # The form of a help that the pattern above does not know would be left out in silence.
        for known in ("fit --pull", "fit --strength", "check --max-step", "pose --bend", "pose --falloff",
                      "pose --scale", "shape cage --margin", "shape around --around-part", "bench --seconds",
                      "shape arm --joint", "deform --level", "deform --threads", "deform --frame-rate",
                      "shape merge --tolerance", "shape torus --minor-radius", "fit --freeze", "check --list"):
            self.assertIn(known, tried)

    def test_those_that_are_not_whole_or_too_large_are_refused(self):
        tried = set()
        for command in self.commands():
            text = self.run_program(*command, "--help").stdout
            for name, form in re.findall(r"^  (?:-\w,)?(--[\w-]+) (U?INT|I J K|N\|I J K)\b", text, re.MULTILINE):
                for bad in ("1.5", "1e3", "99999999999", "-99999999999"):
                    values = [bad] + ["1", "1"] * ("J" in form)
                    file = ["x.obj"] if command == ["shape", "around"] else []
                    with self.subTest(command=command, option=[name, *values]):
                        self.assertRegex(self.error_of(*command, *file, name, *values, code=2),
                                         f"^espalier: {name}: expected a whole number, -?\\d+ to \\d+, got {bad}\n$")
                tried.add(" ".join([*command, name]))
        for known in ("shape box --cells", "shape around --cells", "shape star --rings", "shape cage --vertices",
                      "deform --level", "check --list", "fit --freeze", "info --threads"):
            self.assertIn(known, tried)

    def test_selections_of_pose_take_finite_numbers(self):
        for words in (["ball", "nan", 0, 0, 1], ["ball", 0, 0, 0, "inf"], ["box", 0, 0, 0, 1, 1, "inf"],
                      ["half-space", 0, 0, 0, "nan", 0, 1], ["vertices", "nan"]):
            with self.subTest(words):
                self.assertIn("--select", self.error_of("pose", "x.vtu", "--select", *words, "--move", 1, 0, 0,
                                                        "-o", "y.vtu", code=2))


class Names(EveryCommand):
    def test_empty_ones_are_refused(self):
        """Every option and every argument that names a file, of every command."""
        tried = set()
        for command in self.commands():
            text = self.run_program(*command, "--help").stdout
            for name in re.findall(r"^  (?:-\w,)?(--[\w-]+|[A-Z|]+) TEXT", text, re.MULTILINE):
                with self.subTest(command=command, name=name):
                    words = [name, ""] if name.startswith("-") else [""]
                    self.assertEqual(self.error_of(*command, *words, code=2),
                                     f"espalier: {name}: expected the name of a file, got nothing\n")
                tried.add(" ".join([*command, name]))
        for known in ("stencils --points", "page --page", "page --rest", "fit --targets", "deform --to", "deform MODEL",
                      "shape box --output", "shape merge LATTICE", "compare --html", "compare FILE",
                      "refine LATTICE|MESH|CURVE"):
            self.assertIn(known, tried)

    def test_empty_words_are_refused(self):
        for words, expected in [(["deform", "--outside", ""], "--outside: expected error|keep|nearest"),
                                (["pose", "x.vtu", "--toward", ""], "--toward: expected an axis x, y or z, or with a "
                                                                    "sign (+x, -z)"),
                                (["pose", "x.vtu", "--falloff", "", 1], "--falloff: expected linear|smooth RADIUS"),
                                (["pose", "x.vtu", "--select", ""], "--select: expected KIND ..."),
                                (["shape", "arm", "--joint", "", 1, 1, 1], "--joint: expected X Y Z RADIUS [TWIST]"),
                                (["--completion", ""], "--completion: expected bash or zsh")]:
            self.assertEqual(self.error_of(*words, code=2), f"espalier: {expected}, got nothing\n")


class MisspeltWords(CliTest):
    def test_the_nearest_command_is_suggested(self):
        for words, message in [
                (["defrom", "x"], "espalier has no command defrom; did you mean deform? espalier --help"),
                (["help", "chek"], "espalier has no command chek; did you mean check? espalier --help"),
                (["shape", "bx"], "espalier shape has no command bx; did you mean box? espalier shape --help"),
                (["teapot"], "espalier has no command teapot; espalier --help")]:
            self.assertEqual(self.error_of(*words, code=2), f"espalier: {message} lists them\n")

    def test_the_nearest_option_is_suggested_before_others_are_missing(self):
        for words, option, nearest in [
                (["deform", "m.obj", "--rset", "a.vtu"], "--rset", "--rest"),
                (["deform", "m.obj", "-rest", "a.vtu"], "-rest", "--rest"),
                (["stencils", "a.vtu", "--pionts=m.obj"], "--pionts", "--points"),
                (["shape", "box", "--min", -1, -1, -1, "--cels", 2, 2, 2], "--cels", "--cells"),
                (["--versoin"], "--versoin", "--version")]:
            self.assertRegex(self.error_of(*words, code=2),
                             f"^espalier: espalier.* has no option {option}; did you mean {nearest}\\? ")
        self.assertEqual(self.error_of("deform", "m.obj", "--lattise", "a.vtu", code=2),
                         "espalier: espalier deform has no option --lattise; espalier deform --help "
                         "lists them\n")

    def test_values_may_look_like_options(self):
        self.run_program("shape", "box", "-o", "-x.ovm")
        self.run_program("pose", "--toward", "-y", "--bend", "-x", -1, "-o", "out.ovm", "--", "-x.ovm")
        self.run_program("info", "-n0", "out.ovm", "--quiet")


class SeveralNumbers(CliTest):
    def same(self, command, *forms):
        """Checks that a command writes the same with each form of its numbers."""
        first = None
        for form in forms:
            out = "out." + command[-1]
            self.run_program(*command[:-1], *form, "-o", out)
            first = first or self.bytes(out)
            self.assertEqual(self.bytes(out), first, form)

    def test_spaces_and_commas_mean_the_same(self):
        box = ["shape", "box", "ovm"]
        self.same(box, ["--min", -0.48, -0.74, -0.67, "--cells", 2, 2, 3],
                  ["--min", "-0.48,-0.74,-0.67", "--cells", "2,2,3"],
                  ["--min=-0.48,-.74,-0.67", "--cells=2,2,3"],
                  ["--cells", "2,2,3", "--min", "-.48,-0.74,-0.67"])
        self.same(["shape", "cylinder", "ovm"], ["--from", 0, -1, 0, "--to", 1, 0, -2],
                  ["--to", "1,0,-2", "--from", "0,-1,0"])
        arm = ["shape", "arm", "ovm"]
        self.same(arm, ["--up=0,-1,0", "--joint", "0,0,0,.5", "--joint", "-1,0,3,1,-30"],
                  ["--joint", 0, 0, 0, .5, "--joint", -1, 0, 3, 1, -30, "--up", 0, -1, 0],
                  ["--up", "0,-1,0", "--joint=0,0,0,0.5", "--joint", -1, 0, 3, 1, -30])
        self.run_program("shape", "box", "--cells", 2, 2, 2, "-o", "rest.ovm")
        self.write_model([(.5, .5, .5), (.1, .2, .3), (.7, .2, .8)])
        self.same(["shape", "around", "model.obj", "ovm"],
                  ["--cells", 1, 2, 3, "--around-part", -1, -1, -1, 1, 1, 1],
                  ["--cells", "1,2,3", "--around-part", "-1,-1,-1,1,1,1"])
        self.same(["fit", "model.obj", "--rest", "rest.ovm", "-n", 1, "ovm"],
                  ["--pull", .5, .5, .5, -.1, 0, 0], ["--pull", ".5,.5,.5,-.1,0,0"])
        self.put("targets.txt", "0 .6 .5 .5\n")
        self.same(["fit", "model.obj", "--rest", "rest.ovm", "--targets", "targets.txt", "-n", 1, "ovm"],
                  ["--hold", -.1, -.1, -.1, .1, 1.1, 1.1, "--freeze", 1, 2],
                  ["--freeze", "1,2", "--hold", "-.1,-.1,-.1,.1,1.1,1.1"])

    def test_an_argument_may_follow_numbers(self):
        self.write_model([(.5, .5, .5), (.1, .2, .3), (.7, .2, .8)])
        model = "model.obj"
        self.same(["shape", "around", "ovm"], [model, "--cells", 2], ["--cells", 2, model],
                  ["--cells=2", model], ["--cells", 2, "--", model])
        self.same(["shape", "around", "ovm"], [model, "--cells", 1, 2, 3, "--margin", .5],
                  ["--margin", .5, "--cells", 1, 2, 3, model], ["--cells", "1,2,3", model, "--margin", .5],
                  ["--margin", .5, "--cells", 1, "2,3", model])
        self.run_program("shape", "box", "-o", "rest.ovm")
        self.same(["pose", "ovm"], ["rest.ovm", "--scale", 2, "--move", 1, 2, 3],
                  ["--scale", 2, "rest.ovm", "--move", 1, 2, 3],
                  ["--scale", 2, "--move", 1, 2, 3, "rest.ovm"])
        self.same(["pose", "ovm"], ["rest.ovm", "--twist", "z", -9], ["--twist", "z", -9, "rest.ovm"])
        for words in [("box", 0, 0, 0, 1, 1, 0), ("box", "0,0,0", "1,1,0"), ("ball", 0, 0, 0, .5),
                      ("ball,0,0,0,.5",), ("half-space", 0, 0, .5, 0, 0, "-1"), ("end", "+z"),
                      ("end", "-z"), ("end,+z",), ("vertices", 0, 3), ("vertices", "0,3")]:
            self.same(["pose", "ovm"], ["rest.ovm", "--select", *words, "--move", 1, 2, 3],
                      ["--select", *words, "rest.ovm", "--move", 1, 2, 3],
                      ["--select", *words, "--", "rest.ovm", "--move", 1, 2, 3])
        self.same(["pose", "ovm"], ["rest.ovm", "--select", "end", "+z", "--move", 1, 2, 3],
                  ["--select=end,+z", "rest.ovm", "--move=1,2,3"],
                  ["--select=end,+z", "--move=1,2,3", "rest.ovm"])
        self.run_program("shape", "box", "-o", "rest.vtu")
        self.put("rest.vtu", self.text("rest.vtu").replace(
            "<PointData>", '<PointData><DataArray type="Float64" Name="t" format="ascii">'
                           "0 0 0 0 1 1 1 1</DataArray>"))
        self.same(["pose", "vtu"], ["rest.vtu", "--select", "attribute", "t", "--move", 1, 2, 3],
                  ["--select", "attribute", "t", "rest.vtu", "--move", 1, 2, 3])
        self.assertIn("--select: box 1 2: expected box X0 Y0 Z0 X1 Y1 Z1",
                      self.error_of("pose", "--select", "box", 1, 2, "rest.ovm", "-o", "x.ovm", code=2))
        self.same(["fit", "ovm"], [model, "--pull", .5, .5, .5, -.1, 0, 0, "--rest", "rest.ovm", "-n", 1],
                  ["--rest", "rest.ovm", "-n", 1, "--pull", .5, .5, .5, "-.1,0,0", model])
        self.assertIn("--move: expected the numbers X Y Z, with spaces or commas between, got rest.ovm",
                      self.error_of("pose", "--move", 1, 2, "rest.ovm", "-o", "x.ovm", code=2))

    def test_wrong_numbers_are_named(self):
        names = "--min: expected the numbers X Y Z, with spaces or commas between, got"
        for numbers, message in [
                (["1,2"], f"{names} -o"), (["1,x,2"], f"{names} x"),
                (["1,2,3,4"], "--min: At Most 3 required but received 4")]:
            self.assertEqual(self.error_of("shape", "box", "--min", *numbers, "-o", "x.ovm", code=2),
                             f"espalier: {message}\n")
        self.assertIn("--pull: expected the numbers X Y Z DX DY DZ, with spaces or commas between, got x",
                      self.error_of("fit", "m.obj", "--rest", "r.ovm", "--pull", "1,2,x,4,5,6",
                                    "-o", "x.ovm", code=2))
        self.assertIn("--joint: expected 4 or 5 numbers X Y Z RADIUS [TWIST], got 3",
                      self.error_of("shape", "arm", "--joint", "1,2,3", "-o", "x.ovm", code=2))

    def test_the_help_names_them(self):
        for shape in commands_in(self.run_program("shape", "--help").stdout):
            self.assertNotRegex(self.run_program("shape", shape, "--help").stdout, r"INT,|FLOAT,")
        self.assertIn("--min X Y Z=0,0,0 ", self.run_program("shape", "box", "--help").stdout)


class Dash(CliTest):
    def test_it_is_no_name_of_standard_output(self):
        self.run_program("shape", "box", "-o", "box.ovm")
        commands = [["shape", "box"], ["shape", "merge", "box.ovm", "box.ovm"],
                    ["shape", "around", "box.ovm"], ["pose", "box.ovm"], ["refine", "box.ovm"],
                    ["stencils", "box.ovm"], ["bind", "m.obj", "--rest", "box.ovm"],
                    ["deform", "m.obj", "--rest", "box.ovm", "--to", "box.ovm", "box.ovm"],
                    ["apply", "m.espb", "--to", "box.ovm"], ["check", "box.ovm", "--rest", "box.ovm"],
                    ["fit", "m.obj", "--rest", "box.ovm", "--targets", "m.obj"]]
        for command in commands:
            self.assertRegex(self.error_of(*command, "-o", "-", code=2),
                             "^espalier: --output: - does not mean standard output: .* /dev/stdout")
        self.assertEqual(os.listdir(self.path), ["box.ovm"])

    def test_the_ways_that_the_message_names_write_to_standard_output(self):
        self.run_program("shape", "box", "-o", "box.ovm")
        (self.path / "link.ovm").symlink_to("/dev/stdout")
        self.assertEqual(self.run_program("shape", "box", "-o", "link.ovm", "--quiet").stdout,
                         self.text("box.ovm"))
        self.run_program("stencils", "box.ovm", "-n", 1, "-o", "D.mtx", "--quiet")
        self.assertEqual(self.run_program("stencils", "box.ovm", "-n", 1, "-o", "/dev/stdout",
                                          "--quiet").stdout, self.text("D.mtx"))


class Version(CliTest):
    def test_it_has_the_commit_and_the_libraries(self):
        lines = self.run_program("--version").stdout.splitlines()
        # A build from an archive knows no commit.
        self.assertRegex(lines[0], r"^espalier \d+\.\d+\.\d+( \([0-9a-f]{7,}(-dirty)?\))?$")
        self.assertEqual([line.split()[0] for line in lines[1:]], ["compiler", "threads", "compare"])
        has_compare = "--html" in self.run_program("compare", "--help").stdout
        self.assertEqual(bool(re.search(r"OpenSubdiv \d", lines[3])), has_compare)


class Completion(CliTest):
    """Completes words as a shell does. `complete` returns what is offered for the last word; nothing
    for names of files."""

    BASH = r"""
        source "$1"; shift
        COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
        _espalier; printf '%s\n' "${COMPREPLY[@]}" """
    # zsh offers the words that begin as the last one among those that compadd gets.
    ZSH = r"""
        script=$1; shift
        words=("$@") CURRENT=$# last=${words[-1]}
        compset() { last=${last#*=} }
        compadd() { shift; for word; do [[ $word == $last* ]] && print -r -- $word; done; true }
        _files() { true }
        source $script"""

    def setUp(self):
        super().setUp()
        self.shells = [("bash", ["bash", "--norc", "-c", self.BASH, "bash"],
                        COMPLETIONS / "espalier.bash")]
        if shutil.which("zsh"):
            self.shells.append(("zsh", ["zsh", "-f", "-c", self.ZSH, "zsh"],
                                COMPLETIONS / "_espalier"))

    def complete(self, *words):
        offers = []
        for name, shell, script in self.shells:
            given = words
            if name == "bash":  # bash splits words at "="
                given = [part for word in words for part in re.split("(=)", word)]
                if len(given) > 1 and given[-2:] == ["=", ""]:
                    given.pop()
            result = subprocess.run([*shell, script, "espalier", *given], text=True, check=False,
                                    capture_output=True, timeout=60, cwd=self.path)
            self.assertEqual((result.returncode, result.stderr), (0, ""))
            offers.append(sorted(set(result.stdout.split())))
        self.assertEqual(offers, offers[:1] * len(offers))
        return offers[0]

    def test_the_build_made_the_scripts(self):
        for shell, _, script in self.shells:
            self.assertEqual(script.read_text(), self.run_program("--completion", shell).stdout)
        self.assertIn("expected bash or zsh, got fish", self.error_of("--completion", "fish", code=2))

    def test_every_command_and_every_option_is_offered(self):
        def check(*words):
            text = self.run_program(*words, "--help").stdout
            inner = commands_in(text)
            self.assertEqual(self.complete(*words, ""), sorted(inner))
            options = {name for names in options_in(text) for name in names}
            self.assertEqual(set(self.complete(*words, "-")), options)
            for command in inner:
                check(*words, command)
        check()

    def test_the_begin_of_a_word_chooses(self):
        self.assertEqual(self.complete("de"), ["deform"])
        self.assertEqual(self.complete("help", "sha"), ["shape"])
        self.assertEqual(self.complete("shape", "o"), ["octahedron"])
        self.assertEqual(self.complete("deform", "m.obj", "--re"), ["--report", "--rest"])

    def test_words_of_options_are_offered(self):
        for words in (["--outside", ""], ["--outside="], ["m.obj", "--outside", ""]):
            self.assertEqual(self.complete("deform", *words), ["error", "keep", "nearest"])
        self.assertEqual(self.complete("deform", "--outside=ne"), ["nearest"])
        self.assertEqual(self.complete("stencils", "--petsc-indices", ""), ["32", "64"])
        self.assertNotIn("mlca", self.complete("compare", "--rules", ""))
        self.assertEqual(self.complete("--completion", ""), ["bash", "zsh"])

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh_finds_the_script(self):
        # compinit reads the first lines of the scripts in $fpath.
        script = r"""fpath=($1 $fpath); autoload -Uz compinit; compinit -u -d $2/dump
                     print -r -- ${_comps[espalier]}; autoload +X -Uz _espalier"""
        result = subprocess.run(["zsh", "-f", "-c", script, "zsh", COMPLETIONS, self.path],
                                text=True, capture_output=True, timeout=60, check=False)
        self.assertEqual((result.stdout, result.stderr), ("_espalier\n", ""))

    def test_names_of_files_are_left_to_the_shell(self):
        for words in (["deform", ""], ["deform", "m.obj", "--rest", ""], ["info", "sha"]):
            self.assertEqual(self.complete(*words), [])
        self.assertRegex((COMPLETIONS / "espalier.bash").read_text(), "complete -o default ")


if __name__ == "__main__":
    COMPLETIONS = pathlib.Path(sys.argv.pop()).resolve()
    program.ESPALIER = os.path.abspath(sys.argv.pop())
    unittest.main()
