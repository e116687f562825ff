# SPDX-License-Identifier: Apache-2.0
"""examples/wing_design.py: its mesh, its gradients, and its ten steps."""

import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import espalier

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
sys.path.insert(0, str(EXAMPLES))
import wing_design  # noqa: E402
import wing_flow  # noqa: E402
import wing_mesh  # noqa: E402
from panel_method import Flow, naca  # noqa: E402


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    path = tmp_path_factory.mktemp("wing") / "wing.su2"
    wing_mesh.write_su2(path, *wing_mesh.make_mesh(stations=10, beyond=3, layers=6, panels=36))
    return path


@pytest.fixture(scope="module")
def swept_mesh(tmp_path_factory):
    """A wing with the planform of the ONERA M6 (swept by 26.7 degrees, tapered to 0.56), with the span along y and up along
    z."""
    points, cells, markers = wing_mesh.make_mesh(stations=10, beyond=3, layers=6, panels=36)
    along = points[:, 2] / 3
    chord = 1 - 0.44 * np.minimum(along, 1)
    x = points[:, 0] * chord + 0.75 * along
    path = tmp_path_factory.mktemp("swept") / "wing.su2"
    # To swap two axes is a reflection, which turns the cells inside out: they begin with their other end.
    cells = [[cell[0], *cell[1 + len(cell) // 2:], *cell[1:1 + len(cell) // 2]] for cell in cells]
    wing_mesh.write_su2(path, np.column_stack([x, points[:, 2] / 2, points[:, 1] * chord]), cells, markers)
    return path


def test_the_mesh_is_valid(mesh):
    model = espalier.read_model(mesh)
    check = espalier.MeshCheck(model)
    assert len(check.bad_at_rest) == 0 and check.cell_count == 13 * 6 * 36 + 3 * 18
    # The wing and its mirror image: the cut at the plane of symmetry is open.
    triangles = wing_mesh.read_triangles(mesh, "wing")
    with pytest.raises(ValueError, match="the surface is not closed"):
        espalier.constraints.volume(model.positions, triangles)
    with pytest.raises(ValueError, match="has no faces of a marker none"):
        wing_mesh.read_triangles(mesh, "none")


def test_sections_are_those_of_the_wing(mesh):
    model = espalier.read_model(mesh)
    rows = wing_flow.section_rows(model.positions, wing_mesh.read_triangles(mesh, "wing"), 2, 1.234, 60)
    points = rows @ model.positions
    np.testing.assert_allclose(points[:, 2], 1.234, atol=1e-14)
    assert points[0, 0] == pytest.approx(1) and points[30, 0] == pytest.approx(0)
    # Half a percent of the chord: the mesh has 36 points around the section, and the cut has 60.
    fine = naca(0.02, 0.12, 2000)
    assert max(abs(fine - p).min() for p in points[:, 0] + 1j * points[:, 1]) < 0.005
    flow, smooth = Flow(points[:, 0] + 1j * points[:, 1], 0.07), Flow(naca(0.02, 0.12, 60), 0.07)
    assert flow.lift == pytest.approx(smooth.lift, rel=0.05)


def test_lift_and_drag_are_those_of_a_lifting_line(mesh):
    model = espalier.read_model(mesh)
    wing = wing_flow.Wing(model.positions, wing_mesh.read_triangles(mesh, "wing"), 2, 24, 60, np.radians(4))
    lift, drag, _, _ = wing.evaluate(np.array(model.positions))
    # A rectangular wing of aspect ratio 6: the drag is within a few percent of the elliptic L^2 / (pi b^2).
    elliptic = lift**2 / (np.pi * 6**2)
    assert 1.0 < drag / elliptic < 1.1
    section = Flow(naca(0.02, 0.12, 60), np.radians(4)).lift
    assert lift == pytest.approx(6 * section / (1 + 2 / 6 * 1.1), rel=0.05)


@pytest.mark.parametrize("span", ["z", "y"])
def test_gradients(mesh, swept_mesh, span):
    path = mesh if span == "z" else swept_mesh
    triangles = wing_mesh.read_triangles(path, "wing")
    design = wing_design.Design(espalier.read_model(path), triangles, "xyz".index(span))
    random = np.random.default_rng(4)
    at, step = 0.3 * random.normal(size=20), random.normal(size=20)
    lift, drag, thickness, by_lift, by_drag, by_thickness, _ = design.evaluate(at)
    h = 1e-4

    def difference(pick):
        ends = [pick(design.evaluate(at + k * h * step)) for k in (-2, -1, 1, 2)]
        return (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * h)
    assert by_lift @ step == pytest.approx(difference(lambda e: e[0]), rel=1e-8)
    assert by_drag @ step == pytest.approx(difference(lambda e: e[1]), rel=1e-8)
    np.testing.assert_allclose(by_thickness @ step, difference(lambda e: e[2]), rtol=1e-7, atol=1e-10)


def test_ten_steps(tmp_path):
    done = subprocess.run([sys.executable, EXAMPLES / "wing_design.py", "--work", tmp_path], capture_output=True, text=True,
                          check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "12960 points, 11376 cells, 20 variables, 1404 vertices"
    rows = np.array([line.split() for line in lines[2:-1]], float)
    assert len(rows) == 11
    # The same lift, no section thinner, all cells valid, and less drag.
    np.testing.assert_allclose(rows[:, 1], rows[0, 1], rtol=1e-4)
    assert (rows[:, 3] >= 0.999).all() and (rows[:, 4] > 0.5).all() and (rows[:, 5] == 0).all()
    assert rows[-1, 2] < 0.96 * rows[0, 2]
    assert re.match(r"5\.\d % less drag at 3\.200\d of lift, in", lines[-1])
    moved = espalier.read_model(tmp_path / "optimised.su2")
    rest = espalier.read_model(tmp_path / "wing.su2")
    lattice, pose = espalier.read(tmp_path / "rest.vtu"), espalier.read(tmp_path / "pose.vtu")
    np.testing.assert_allclose(moved.positions, espalier.bind(lattice, rest).deform(pose.positions), atol=1e-12)
    # Nothing leaves the plane of symmetry, and nothing moves along the span.
    np.testing.assert_allclose(moved.positions[:, 2], rest.positions[:, 2], atol=1e-12)


def test_a_mesh_is_an_argument(tmp_path, swept_mesh):
    done = subprocess.run([sys.executable, EXAMPLES / "wing_design.py", swept_mesh, "--span", "y", "--steps", "4", "--work",
                           tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = np.array([line.split() for line in done.stdout.splitlines()[2:-1]], float)
    assert len(rows) == 5 and (rows[:, 5] == 0).all() and rows[-1, 2] < rows[0, 2]
    np.testing.assert_allclose(rows[-1, 1], rows[0, 1], rtol=1e-3)
    assert not (tmp_path / "wing.su2").exists() and (tmp_path / "optimised.su2").exists()


def test_wrong_meshes(tmp_path, mesh):
    for arguments, message in [(["none.su2"], "wing_design.py: .*none.su2"),
                               ([mesh, "--marker", "tail"], "wing_design.py: .* has no faces of a marker tail")]:
        done = subprocess.run([sys.executable, EXAMPLES / "wing_design.py", *arguments, "--work", tmp_path],
                              capture_output=True, text=True, check=False)
        assert done.returncode == 1 and re.match(message, done.stderr), done.stderr
