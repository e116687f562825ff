# SPDX-License-Identifier: Apache-2.0
"""examples/deform.py, which the README shows, deforms a model in a file."""

import pathlib
import subprocess
import sys

import numpy as np

import espalier

EXAMPLE = pathlib.Path(__file__).parents[2] / "examples/deform.py"


def test_it_deforms_a_model(tmp_path, rest, points, pose):
    model, out = tmp_path / "model.obj", tmp_path / "out.obj"
    model.write_text("".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()))
    rest.write(tmp_path / "rest.vtu")
    rest.with_positions(pose).write(tmp_path / "pose.vtu")
    subprocess.run([sys.executable, EXAMPLE, model, tmp_path / "rest.vtu", tmp_path / "pose.vtu", out],
                   check=True)
    expected = espalier.bind(rest, points, level=3).deform(pose)
    # A lattice read from a file numbers its edges in another order, which changes the order of sums.
    np.testing.assert_allclose(espalier.read_model(out).positions, expected, rtol=0, atol=1e-14)
