#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the comments of the public headers: Doxygen must not warn."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

DOXYGEN = DOXYFILE = None  # set by main


class Headers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_doxygen(self, **settings):
        """Runs Doxygen with some settings changed; the last setting of a name counts."""
        settings = {"OUTPUT_DIRECTORY": self.folder, **settings}
        text = DOXYFILE.read_text(encoding="utf-8") + "".join(
            f'{name} = "{value}"\n' for name, value in settings.items())
        return subprocess.run([DOXYGEN, "-"], input=text, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, check=False)

    def test_the_headers_give_no_warnings(self):
        result = self.run_doxygen()
        self.assertEqual((result.returncode, result.stdout), (0, ""))
        headers = re.findall(r'/(\w+)\.h"', DOXYFILE.read_text(encoding="utf-8"))
        pages = {path.name for path in (self.folder / "html").glob("*.html")}
        self.assertGreater(len(headers), 80)
        for header in headers:
            self.assertIn(header.replace("_", "__") + "_8h.html", pages)
        # Our own commands have headings, as Doxygen's commands do.
        page = (self.folder / "html/namespaceespalier_1_1far.html").read_text(encoding="utf-8")
        for heading in ("Cost", "Reference", "Exceptions"):
            self.assertTrue(f"<dt>{heading}</dt>" in page, heading)

    def test_comments_that_are_wrong_are_found(self):
        header = self.folder / "wrong.h"
        for wrong in (r"\param valeu of it", r"\costs much", "<b>bold", r"\ref nothing"):
            header.write_text(f"/// \\file\n\n/// Sets a number.\n/// {wrong}\n"
                              "void set(int value);\n", encoding="utf-8")
            result = self.run_doxygen(INPUT=header)
            self.assertNotEqual(result.returncode, 0, wrong)
            self.assertIn("wrong.h", result.stdout, wrong)


if __name__ == "__main__":
    DOXYFILE = pathlib.Path(sys.argv.pop())
    DOXYGEN = sys.argv.pop()
    unittest.main()
