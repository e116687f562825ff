# SPDX-License-Identifier: Apache-2.0
"""A subinterpreter cannot import the package: the import says so, and does not hang."""

import pathlib
import subprocess
import sys

import pytest

import espalier

MODULE = "_interpreters" if sys.version_info >= (3, 13) else "_xxsubinterpreters"
pytest.importorskip(MODULE)

# The process reports the error of the subinterpreter in its output, which each version of Python has.
CODE = """
import sys
import {module} as interpreters
sys.path.insert(0, {path!r})
{first}
code = '''
import sys
sys.path.insert(0, {path!r})
try:
    import espalier
except ImportError as error:
    print(type(error).__name__, error)
'''
for _ in range(2):
    interpreters.run_string(interpreters.create(), code)
import espalier
print(len(espalier.shapes.box(cells=(1, 1, 1)).positions))
"""


@pytest.mark.parametrize("first", ["", "import espalier"], ids=["alone", "after the main one"])
def test_an_import_by_a_subinterpreter_is_refused(first):
    path = str(pathlib.Path(espalier.__file__).parents[1])
    # A separate process, since the import hung before.
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", CODE.format(module=MODULE, path=path, first=first)],
        capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    *refusals, vertices = done.stdout.splitlines()
    assert refusals == 2 * ["ImportError espalier: only the main interpreter of a process can import it; "
                            "this is a subinterpreter. Use a process (multiprocessing) instead."]
    assert vertices == "8"  # The main interpreter is as it was.
