#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the program refuses files that claim too much data.

    refused_input_test.py PATH_OF_ESPALIER
"""

import base64
import os
import re
import struct
import sys
import unittest
import zlib

import program
from program import CliTest


class RefusedInput(CliTest):
    LIMITS = [[], ["--max-memory", "60MB"]]

    def bomb(self, name, type="Int64", components=1, megabytes=3072):
        """Returns an array of zeros, compressed to about a thousandth of `megabytes`."""
        block = zlib.compress(bytes(2**20), 9)
        header = struct.pack("<" + "Q" * (3 + megabytes), megabytes, 2**20, 0,
                             *[len(block)] * megabytes)
        payload = (base64.b64encode(header) + base64.b64encode(megabytes * block)).decode()
        return (f'<DataArray type="{type}" Name="{name}" NumberOfComponents="{components}" '
                f'format="binary">{payload}</DataArray>')

    def test_claims_are_compared_before_anything_is_inflated(self):
        self.run_program("shape", "box", "-o", "box.vtu", "--quiet")
        text = self.text("box.vtu")
        self.assertIn("<Points>", text)
        array = self.bomb("bomb", "Float64", 3, megabytes=100)
        self.put("bomb.vtu",
            text.replace("<Points>", f"<PointData>{array}</PointData><Points>", 1))
        for limit in self.LIMITS:
            error = self.error_of("info", "bomb.vtu", *limit)
            self.assertIn("the array 'bomb' has 13107200 numbers; expected 8 times 3", error)

    def test_claims_of_cells_and_marks_are_compared_before_anything_is_inflated(self):
        self.run_program("shape", "box", "-o", "box.vtu", "--quiet")
        text = self.text("box.vtu")
        vertices = ('<DataArray type="Int64" Name="espalier:edge_vertices" NumberOfComponents="2" '
                    'format="ascii">0 1</DataArray>')
        sharpness = self.bomb("espalier:edge_sharpness", "Float64")
        marks = [("espalier:edge_vertices", "at most 12 times 2",
                  self.bomb("espalier:edge_vertices", components=2) + sharpness),
                 ("espalier:edge_sharpness", "1, one an edge", vertices + sharpness)]
        files = [(name, expected, re.sub("<UnstructuredGrid>", lambda match: match[0] +
                                         f"<FieldData>{arrays}</FieldData>", text, count=1))
                 for name, expected, arrays in marks]
        for name, expected in [("offsets", "1, one a cell"),
                               ("connectivity", "8, the last of 'offsets'")]:
            pattern = rf'<DataArray [^>]*Name="{name}"[^>]*>[^<]*</DataArray>'
            self.assertEqual(len(re.findall(pattern, text)), 1)
            files.append((name, expected, re.sub(pattern, lambda _: self.bomb(name), text)))
        for name, expected, bomb in files:
            self.put("bomb.vtu", bomb)
            for limit in self.LIMITS:
                error = self.error_of("info", "bomb.vtu", *limit)
                self.assertIn(f"the array '{name}' has 402653184 numbers; expected {expected}",
                              error)


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    unittest.main()
