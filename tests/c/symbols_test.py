#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that libespalier.so exports the functions of symbols.txt and of the headers of c/, and no others."""

import pathlib
import re
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
NM = LIBRARY = HEADERS = None  # set by main

HOW_TO_CHANGE = """
Removing a function, or changing its parameters, breaks the programs that are linked to it. The
SOVERSION must change then: change the minor version in CMakeLists.txt below 1.0, and the major
version from 1.0 on. A new function needs a new minor version. Then change tests/c/symbols.txt."""


def names(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def without_comments():
    return "".join(re.sub(r"//.*", "", path.read_text(encoding="utf-8")) for path in HEADERS)


class Symbols(unittest.TestCase):
    def test_library(self):
        out = subprocess.run([NM, "-D", "--defined-only", LIBRARY], text=True, check=True,
                             stdout=subprocess.PIPE).stdout
        exported = [line.split()[-1] for line in out.splitlines()]
        self.assertEqual(sorted(exported), names(HERE / "symbols.txt"), HOW_TO_CHANGE)

    def test_header(self):
        text = without_comments()
        declared = re.findall(r"ESPALIER_C_API [^(;]*?\b(espalier_\w+)\(", text)
        self.assertEqual(sorted(declared), names(HERE / "symbols.txt"), HOW_TO_CHANGE)

    def test_corners(self):
        """Functions that take numbers, arrays or options are in corners_test.c."""
        text = without_comments()
        test = (HERE / "corners_test.c").read_text(encoding="utf-8")
        number = r"(u?int\d+_t|size_t|double|float|espalier_buffer_layout) \w+\b(?!\[)"
        struct = r"const espalier_(cells|\w+_options)\*"
        for name, parameters in re.findall(
                r"ESPALIER_C_API [^(;]*?\b(espalier_\w+)\(([^)]*)\)", text):
            if re.search(f"{number}|{struct}", parameters):
                self.assertTrue(f"{name}(" in test, f"corners_test.c does not try {name}")

    def test_numbers(self):
        """Functions that take real numbers are in numbers_test.c, which says of each what is not finite there."""
        text = without_comments()
        test = (HERE / "numbers_test.c").read_text(encoding="utf-8")
        structs = re.findall(r"typedef struct \w+ \{([^}]*)\} (\w+);", text)
        real = ["double", "float"] + [name for fields, name in structs if re.search(r"\b(double|float)\b", fields)]
        # Results are written through pointers without const; a pointer to a pointer is a result as well.
        given = r"\b({0}) \w+\b|const ({0})\*(?!\*)".format("|".join(real))
        for name, parameters in re.findall(r"ESPALIER_C_API [^(;]*?\b(espalier_\w+)\(([^)]*)\)", text):
            if re.search(given, parameters):
                self.assertTrue(f"{name}(" in test, f"numbers_test.c does not try {name}")


if __name__ == "__main__":
    HEADERS = sorted(pathlib.Path(sys.argv.pop()).glob("espalier*.h"))
    LIBRARY = sys.argv.pop()
    NM = sys.argv.pop()
    unittest.main()
