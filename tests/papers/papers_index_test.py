#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every claim in docs/papers.md names tests that exist and are built."""

import ast
import pathlib
import re
import tempfile
import unittest

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "papers.md"

# [`Suite.Test`](path/of/its/file)
REFERENCE = re.compile(r"\[`(\w+)\.(\w+)`\]\(([^)\s]+)\)")
CODE = re.compile(r"`\w+\.\w+`")


def table_rows(text):
    """Yields the rows of all tables with their line numbers, without the headings."""
    is_in_table = False
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("|"):
            is_in_table = False
        elif not is_in_table:
            is_in_table = True  # the heading
        elif not re.fullmatch(r"[|\s:-]+", line):
            yield number, line


def tests_in(path):
    """Returns the tests of a C++ or Python file, as pairs of suite and name."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return {(node.name, part.name) for node in ast.parse(text).body
                if isinstance(node, ast.ClassDef) for part in node.body
                if isinstance(part, ast.FunctionDef)}
    return set(re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", text, re.MULTILINE))


def is_listed(path):
    """True if the CMakeLists.txt next to a test names it; otherwise the test would never run."""
    try:
        text = (path.parent / "CMakeLists.txt").read_text(encoding="utf-8")
    except FileNotFoundError:
        return False
    words = re.split(r"[\s()/]+", re.sub(r"#.*", "", text))
    return path.name in words


def errors_in(page):
    """Returns the errors of a page of claims, one line each."""
    errors = []
    text = page.read_text(encoding="utf-8")
    rows = list(table_rows(text))
    if not rows:
        errors.append("there is no claim")
    for number, row in rows:
        references = REFERENCE.findall(row)
        if not references:
            errors.append(f"line {number}: the claim names no test")
        if len(references) != len(CODE.findall(row)):
            errors.append(f"line {number}: a test without a link to its file")
    for number, line in enumerate(text.splitlines(), 1):
        for suite, name, link in REFERENCE.findall(line):
            path = page.parent / link
            if not path.is_file():
                errors.append(f"line {number}: there is no file {link}")
            elif (suite, name) not in tests_in(path):
                errors.append(f"line {number}: {link} has no test {suite}.{name}")
            elif not is_listed(path):
                errors.append(f"line {number}: {link} is not in the CMakeLists.txt of its folder")
    return errors


class Index(unittest.TestCase):
    def test_every_claim_names_tests_that_are_there(self):
        self.assertEqual(errors_in(PAGE), [])


class Checker(unittest.TestCase):
    """Tests the check itself: it finds each kind of error in a page."""

    GOOD = ("| Where | Says | Test |\n|---|:---|---|\n"
            "| 2.1 | rule | [`Curve.Halves`](a_test.cpp), [`Deform.test_rest`](b_test.py) |\n"
            "\nOutside of a table, see [`Curve.Fixture`](a_test.cpp).\n")

    LISTS = ("test(papers SOURCES\n  a_test.cpp  # the first\n)\n"
             "add_test(NAME b COMMAND python3 ${FOLDER}/b_test.py)\n")

    def check(self, text, lists=LISTS):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "a_test.cpp").write_text(
                "TEST(Curve, Halves) {\n}\nTEST_P(Curve,\n       Fixture) {\n}\n"
                "// TEST(Curve, InAComment)\n")
            (folder / "b_test.py").write_text("class Deform:\n    def test_rest(self): pass\n")
            if lists is not None:
                (folder / "CMakeLists.txt").write_text(lists)
            (folder / "page.md").write_text(text)
            return errors_in(folder / "page.md")

    def test_a_good_page_passes(self):
        self.assertEqual(self.check(self.GOOD), [])

    def test_misspelt_names_are_found(self):
        for right, wrong in [("Curve.Halves", "Curve.Halfs"), ("Curve.Halves", "Curves.Halves"),
                             ("Deform.test_rest", "Deform.test_rets"),
                             ("Curve.Halves", "Curve.InAComment")]:
            errors = self.check(self.GOOD.replace(right, wrong))
            self.assertEqual(len(errors), 1, wrong)
            self.assertIn("line 3: ", errors[0])
            self.assertIn("has no test " + wrong, errors[0])

    def test_misspelt_names_outside_tables_are_found(self):
        errors = self.check(self.GOOD.replace("Curve.Fixture", "Curve.Fixtures"))
        self.assertEqual(errors, ["line 5: a_test.cpp has no test Curve.Fixtures"])

    def test_missing_files_are_found(self):
        errors = self.check(self.GOOD.replace("b_test.py", "c_test.py"))
        self.assertEqual(errors, ["line 3: there is no file c_test.py"])

    def test_files_that_are_not_built_are_found(self):
        unlisted = "{}: {} is not in the CMakeLists.txt of its folder".format
        a, b = unlisted("line 3", "a_test.cpp"), unlisted("line 3", "b_test.py")
        a_again = unlisted("line 5", "a_test.cpp")
        for lists, errors in [("", [a, b, a_again]), (None, [a, b, a_again]),
                              (self.LISTS.replace("a_test.cpp", "# a_test.cpp"), [a, a_again]),
                              (self.LISTS.replace("a_test.cpp", "aa_test.cpp"), [a, a_again]),
                              (self.LISTS.replace("/b_test.py", "/b_test.pyc"), [b])]:
            self.assertEqual(self.check(self.GOOD, lists), errors, lists)

    def test_claims_without_a_test_are_found(self):
        errors = self.check(self.GOOD + "\n| W | S | T |\n|---|---|---|\n| 2.2 | rule | |\n")
        self.assertEqual(errors, ["line 9: the claim names no test"])

    def test_tests_without_a_link_are_found(self):
        errors = self.check(self.GOOD.replace("[`Deform.test_rest`](b_test.py)",
                                              "`Deform.test_rest`"))
        self.assertEqual(errors, ["line 3: a test without a link to its file"])

    def test_a_page_of_no_claims_fails(self):
        self.assertEqual(self.check("# Papers\n"), ["there is no claim"])


if __name__ == "__main__":
    unittest.main()
