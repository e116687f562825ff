#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Input that claims too much, or that was once read in silence though it is wrong.

    refused_input_test.py PATH_OF_ESPALIER
"""

import base64
import os
import struct
import sys
import unittest
import zlib

import program
from program import CliTest


class RefusedInput(CliTest):
    def test_claims_are_compared_before_anything_is_inflated(self):
        self.run_program("shape", "box", "-o", "box.vtu", "--quiet")
        text = (self.path / "box.vtu").read_text()
        block = zlib.compress(bytes(2**20), 9)
        header = struct.pack("<" + "Q" * (3 + 100), 100, 2**20, 0, *[len(block)] * 100)
        payload = (base64.b64encode(header) + base64.b64encode(100 * block)).decode()
        array = (f'<DataArray type="Float64" Name="bomb" NumberOfComponents="3" format="binary">'
                 f"{payload}</DataArray>")
        self.assertIn("<Points>", text)
        (self.path / "bomb.vtu").write_text(
            text.replace("<Points>", f"<PointData>{array}</PointData><Points>", 1))
        for limit in [[], ["--max-memory", "60MB"]]:
            error = self.error_of("info", "bomb.vtu", *limit)
            self.assertIn("the array 'bomb' has 13107200 numbers; expected 8 times 3", error)


if __name__ == "__main__":
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    unittest.main()
