# SPDX-License-Identifier: Apache-2.0
import subprocess
import sys

import numpy as np
import pytest

import espalier

try:
    from espalier import _compare
except ImportError:
    _compare = None

needs_open_subdiv = pytest.mark.skipif(_compare is None, reason="built without OpenSubdiv")


@needs_open_subdiv
@pytest.mark.parametrize("shape", ["box", "star", "torus"])
def test_the_surface_is_open_subdivs(shape):
    agreement = espalier.compare(getattr(espalier.shapes, shape)(), level=3)
    assert agreement.agrees and [level.level for level in agreement.levels] == [1, 2, 3]
    last = agreement.levels[-1]
    assert last.counts == last.open_subdiv_counts and last.topology_difference == ""
    assert last.position_difference < 1e-13 and last.weight_difference < 1e-14


@needs_open_subdiv
def test_the_rules_of_a_refiner_are_compared():
    points = np.random.default_rng(7).normal(size=(5, 3))
    mesh = espalier.Lattice.mesh(points, [[0, 1, 2, 3], [3, 2, 4]])
    assert espalier.compare(espalier.Refiner(mesh, triangles="smooth"), level=2).agrees
    with pytest.raises(ValueError, match="RATS"):
        espalier.compare(espalier.Refiner(mesh, rules="rats"), level=2)
    with pytest.raises(ValueError, match="MLCA"):
        espalier.compare(espalier.Refiner(mesh, rules="mlca"), level=2)


@needs_open_subdiv
def test_what_cannot_be_compared():
    with pytest.raises(ValueError, match="curve"):
        espalier.compare(espalier.Lattice.curve(np.eye(3)))
    with pytest.raises(ValueError, match="^level: expected 1 or more, got 0$"):
        espalier.compare(espalier.shapes.box(), level=0)


def test_open_subdiv_is_loaded_only_when_it_is_asked_for():
    code = ("import espalier, sys; assert 'espalier._compare' not in sys.modules;"
            "assert 'osdCPU' not in open('/proc/self/maps').read()")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_without_it_compare_says_so():
    code = ("import sys; sys.modules['espalier._compare'] = None; import espalier\n"
            "try: espalier.compare(espalier.shapes.box())\n"
            "except ImportError as error: assert 'OpenSubdiv' in str(error)\n"
            "else: raise SystemExit('no error')")
    subprocess.run([sys.executable, "-c", code], check=True)
