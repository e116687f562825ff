#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that each source file has a test of its name, or a line in tests/sources.txt."""

import pathlib
import tempfile
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("base far shapes stencils embed limit osd solve cages io compare petsc c python cli").split()


def has_test_of_its_name(top, source):
    folder, name = top / "tests" / source.parts[0], source.stem
    return any(list(folder.glob(pattern)) for pattern in (f"{name}_test.*", f"test_{name}.py"))


def errors_in(top):
    """Returns the errors of the table, one line each."""
    errors, listed = [], set()
    for line in (top / "tests" / "sources.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        source, _, tests = line.partition(":")
        listed.add(source)
        if not (top / source).is_file():
            errors.append(f"{source}: there is no such file")
        elif has_test_of_its_name(top, pathlib.Path(source)):
            errors.append(f"{source}: has a test of its name")
        if not tests.split():
            errors.append(f"{source}: no test is named")
        errors += [f"{source}: there is no tests/{test}" for test in tests.split()
                   if not (top / "tests" / test).is_file()]
    for folder in FOLDERS:
        for path in sorted((top / folder).rglob("*.c*")):
            source = path.relative_to(top)
            if path.suffix in (".cpp", ".cu") and str(source) not in listed and \
                    not has_test_of_its_name(top, source):
                errors.append(f"{source}: no test is known")
    return errors


class Sources(unittest.TestCase):
    def test_every_source_file_has_tests(self):
        self.assertEqual(errors_in(TOP), [])

    def test_what_is_wrong_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            for name in ("far/a.cpp", "far/b.cpp", "io/in/c.cpp", "io/in/d.cu", "tests/far/a_test.cpp",
                         "tests/far/e_test.cpp", "tests/python/test_f.py", "python/f.cpp"):
                (top / name).parent.mkdir(parents=True, exist_ok=True)
                (top / name).touch()
            table = top / "tests" / "sources.txt"
            table.write_text("# A comment.\nfar/b.cpp: far/e_test.cpp\nio/in/c.cpp: far/a_test.cpp\n"
                             "io/in/d.cu: far/a_test.cpp\n")
            self.assertEqual(errors_in(top), [])
            for line, error in [("far/a.cpp: far/a_test.cpp", "far/a.cpp: has a test of its name"),
                                ("far/g.cpp: far/a_test.cpp", "far/g.cpp: there is no such file"),
                                ("far/b.cpp:", "far/b.cpp: no test is named"),
                                ("far/b.cpp: far/g_test.cpp",
                                 "far/b.cpp: there is no tests/far/g_test.cpp")]:
                with self.subTest(line=line):
                    before = table.read_text()
                    table.write_text(before + line + "\n")
                    self.assertEqual(errors_in(top), [error])
                    table.write_text(before)
            table.write_text("far/b.cpp: far/e_test.cpp\nio/in/d.cu: far/a_test.cpp\n")
            self.assertEqual(errors_in(top), ["io/in/c.cpp: no test is known"])


if __name__ == "__main__":
    unittest.main()
