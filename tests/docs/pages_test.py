#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the pages of docs/ and of the top folder: their code is part of files that are built and
run, and their links exist."""

import pathlib
import re
import sys
import tempfile
import textwrap
import unittest

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS.parent / "bench"))

import ratios  # noqa: E402

# <!-- code: a.cpp b.py -->: the files whose code a page shows from here on, by extension.
SOURCES = re.compile(r"<!-- code: (.*?) -->")
FENCE = re.compile(r"^```(\w*)\s*$")
EXTENSIONS = {"cpp": ".cpp", "python": ".py"}
LINK = re.compile(r"(?<!`)\]\(([^)\s]+)\)")
DEFINITION = re.compile(r"^\[[^\]]+\]:\s+(\S+)")
HEADING = re.compile(r"^#+ (.*)")


def blocks_in(text):
    """Yields the fenced blocks as (line number, language, code, current sources)."""
    sources, start, language, code = [], None, None, []
    for number, line in enumerate(text.splitlines(), 1):
        fence = FENCE.match(line)
        if start is None:
            if SOURCES.search(line):
                sources = SOURCES.search(line).group(1).split()
            if fence:
                start, language, code = number, fence.group(1), []
        elif fence:
            yield start, language, "\n".join(code), sources
            start = None
        else:
            code.append(line)


def anchors_in(path):
    """Yields the anchors of the headings of a page, by GitHub's rules."""
    text = path.read_text(encoding="utf-8")
    for line in text.splitlines():
        heading = HEADING.match(line)
        if heading:
            yield re.sub(r"[^\w\- ]", "", heading.group(1).lower()).replace(" ", "-")


def is_part(code, source):
    """True if lines of code are consecutive in a source, with any indentation."""
    def lines_of(text):
        return [line.rstrip() for line in text.splitlines()]
    code = lines_of(textwrap.dedent(code))
    lines = lines_of(source)
    for first in range(len(lines) - len(code) + 1):
        part = "\n".join(lines[first:first + len(code)])
        if lines_of(textwrap.dedent(part)) == code:
            return True
    return False


def errors_in(page):
    """Returns the errors of a page, one line each."""
    text = page.read_text(encoding="utf-8")
    errors = []
    for number, language, code, sources in blocks_in(text):
        extension = EXTENSIONS.get(language)
        if extension is None or not SOURCES.search(text):
            continue
        paths = [page.parent / name for name in sources if name.endswith(extension)]
        if not paths:
            errors.append(f"line {number}: code of no source")
        for path in paths:
            if not path.is_file():
                errors.append(f"line {number}: there is no file {path.name}")
            elif not is_part(code, path.read_text(encoding="utf-8")):
                errors.append(f"line {number}: the code is not in {path.name}")
    for number, line in enumerate(text.splitlines(), 1):
        links = LINK.findall(line) + DEFINITION.findall(line)
        for link in links:
            if re.match(r"\w+:", link):
                continue
            file, _, anchor = link.partition("#")
            target = page.parent / file if file else page
            if not target.exists():
                errors.append(f"line {number}: there is no {file}")
            elif anchor and anchor not in anchors_in(target):
                errors.append(f"line {number}: {target.name} has no heading for #{anchor}")
    return errors


class Pages(unittest.TestCase):
    def test_code_and_links(self):
        pages = sorted(DOCS.glob("*.md")) + sorted(DOCS.parent.glob("*.md"))
        self.assertGreater(len(pages), 5)
        for page in pages:
            with self.subTest(page=page.name):
                self.assertEqual(errors_in(page), [])

    def test_pages_of_code_say_whose_it_is(self):
        for name in ("tutorial.md", "from-opensubdiv.md"):
            blocks = list(blocks_in((DOCS / name).read_text(encoding="utf-8")))
            self.assertGreater(sum(bool(block[3]) for block in blocks), 8, name)

    def test_the_plot_of_performance_shows_the_numbers_of_its_tables(self):
        page = (DOCS / "performance.md").read_text(encoding="utf-8")
        self.assertEqual((DOCS / "figures/performance-ratios.svg").read_text(encoding="utf-8"),
                         ratios.figure(page), "run bench/ratios.py")
        self.assertGreater(ratios.figure(page).count("<circle"), 20)

    def test_the_life_of_a_deform_names_functions_that_exist(self):
        text = (DOCS / "life-of-a-deform.md").read_text(encoding="utf-8")
        steps = re.findall(r"`(\w+)`\s+\(\[([^\]]+)\]", text)
        self.assertGreater(len(steps), 15)
        for name, path in steps:
            with self.subTest(name=name):
                source = (DOCS.parent / path).read_text(encoding="utf-8")
                # The head of a definition starts at the left margin, and a body follows.
                self.assertRegex(source, rf"(?m)^\S[^;={{}}]*\b{name}\([^;{{}}]*\)[^;{{}}]*{{")


class Checker(unittest.TestCase):
    """Tests the check itself: it finds each kind of error in a page."""

    GOOD = ("# The page, in C++\n<!-- code: a.cpp b.py -->\n"
            "```cpp\nif (x)\n    y();\n```\n```python\nprint(1)\n```\n```\nfree\n```\n"
            "[there](a.cpp) [up](#the-page-in-c) [out](https://example.org/none) [by name][b]\n"
            "\n[b]: b.py\n")

    def check(self, text):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "a.cpp").write_text("void f() {\n    if (x)\n        y();\n    z();\n}\n")
            (folder / "b.py").write_text("print(1)\n")
            (folder / "page.md").write_text(text)
            return errors_in(folder / "page.md")

    def test_a_good_page_passes(self):
        self.assertEqual(self.check(self.GOOD), [])

    def test_other_code_is_found(self):
        for right, wrong, error in [
                ("    y();", "    y(1);", "line 3: the code is not in a.cpp"),
                ("if (x)\n    y();", "if (x)\ny();", "line 3: the code is not in a.cpp"),
                ("if (x)\n    y();", "if (x)\n    z();", "line 3: the code is not in a.cpp"),
                ("print(1)", "print(2)", "line 7: the code is not in b.py"),
                ("a.cpp b.py", "a.cpp c.py", "line 7: there is no file c.py"),
                ("a.cpp b.py", "a.cpp", "line 7: code of no source")]:
            self.assertEqual(self.check(self.GOOD.replace(right, wrong, 1)), [error], wrong)

    def test_dead_links_are_found(self):
        for right, wrong, error in [
                ("(a.cpp)", "(c.cpp)", "line 13: there is no c.cpp"),
                ("(#the-page-in-c)", "(#page)", "line 13: page.md has no heading for #page"),
                ("]: b.py", "]: c.py", "line 15: there is no c.py")]:
            self.assertEqual(self.check(self.GOOD.replace(right, wrong, 1)), [error], wrong)


if __name__ == "__main__":
    unittest.main()
