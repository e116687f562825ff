# SPDX-License-Identifier: Apache-2.0
"""No call from Python ends the interpreter."""

import pathlib
import subprocess
import sys

import espalier
import pytest


def test_no_call_ends_the_interpreter(tmp_path):
    script = pathlib.Path(__file__).with_name("fuzz_calls.py")
    done = subprocess.run([sys.executable, "-B", str(script)], cwd=tmp_path, text=True,
                          capture_output=True, timeout=120)
    assert done.returncode == 0 and done.stdout == "done\n", done.stderr[-2000:]


def test_other_packages_have_another_base_class():
    # SciPy uses pybind11 too. Its classes must not get the protections of Espalier's classes.
    pytest.importorskip("scipy.spatial._distance_pybind")
    script = """if True:
        import builtins
        import espalier
        try:
            assert espalier.compare(espalier.shapes.box(), 1).agrees  # across both extensions
        except ImportError:
            pass  # built without OpenSubdiv
        ours = [name for name in vars(builtins) if "pybind11_internals" in name]
        import scipy.spatial._distance_pybind
        both = [name for name in vars(builtins) if "pybind11_internals" in name]
        print(len(ours), len(both))
        """
    done = subprocess.run([sys.executable, "-B", "-c", script], text=True, capture_output=True)
    assert done.stdout == "1 2\n", done.stdout + done.stderr


def test_messages_show_bytes_that_are_not_utf_8(tmp_path):
    with pytest.raises(ValueError, match="none"):
        espalier.read(str(tmp_path) + "/none\udcff.vtu")
    with pytest.raises(ValueError, match="none"):
        espalier.read(bytes(tmp_path) + b"/none\xff.vtu")
    path = bytes(tmp_path) + b"/m\xff.obj"
    with open(path, "wb") as file:
        file.write(b"v 0 0 0\n")
    model = espalier.read_model(path)
    assert model.name == "m\udcff.obj" and repr(model) == r"<espalier.Model: m\xFF.obj, 1 points>"
