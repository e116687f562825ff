# SPDX-License-Identifier: Apache-2.0
"""The code of docs/from-pygeo-pygem-su2.md, and its answers to threads at pyGeo, PyGeM, SU2 and mimmo."""

import itertools

import numpy as np
import pytest
from scipy.special import binom

import espalier
from espalier.dvgeometry import DVGeometry

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


def plot3d(*blocks):
    """Returns blocks of points, arrays (I, J, K, 3), as the text of an FFD file of pyGeo."""
    lines = [str(len(blocks)), " ".join(str(n) for block in blocks for n in block.shape[:3])]
    lines += ["%.17g" % c for block in blocks for c in block.transpose(3, 2, 1, 0).ravel()]
    return "\n".join(lines) + "\n"


def grid(x, y, z):
    return np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).astype(float)


def test_an_ffd_box_of_pygeo(tmp_path):
    (tmp_path / "ffd.xyz").write_text(plot3d(grid(range(4), range(3), range(2))))
    points = np.random.default_rng(1).uniform(0, (3, 2, 1), (50, 3))
    lattice = espalier.read(tmp_path / "ffd.xyz")
    binding = espalier.bind(lattice, points, level=3)
    pose = lattice.positions.copy()
    pose[7, 2] += 0.5
    moved = binding.deform(pose)
    jacobian = binding.matrix
    np.testing.assert_allclose(moved, points + jacobian @ (pose - lattice.positions), atol=1e-14)
    gradients = np.ones_like(points)
    np.testing.assert_allclose(binding.adjoint(gradients), jacobian.T @ gradients, atol=1e-12)
    assert len(lattice.hexahedra) == 6


def test_a_dvgeometry(tmp_path):
    """The calls of pyGeo's class; tests/python/test_dvgeometry.py has the tests of each."""
    (tmp_path / "ffd.xyz").write_text(plot3d(grid((-1, -0.3, 0.3, 1), (-0.5, 0.5), (0, 3, 6, 8))))
    points = np.random.default_rng(4).uniform((-0.9, -0.4, 0.1), (0.9, 0.4, 7.9), (30, 3))
    by_points = np.ones((30, 3))

    def twist(values, geo):
        geo.rot_theta["axis"].coef[1:] = values

    geo = DVGeometry(tmp_path / "ffd.xyz")
    nodes = geo.addRefAxis("axis", xFraction=0.25, alignIndex="k", rotType=0)
    geo.addGlobalDV("twist", np.zeros(nodes - 1), twist, lower=-10, upper=10)
    geo.addLocalDV("shape", lower=-0.5, upper=0.5, axis="y")
    geo.addShapeFunctionDV("bump", [{geo.getLocalIndex()[1, 1, 2]: (0, 1, 0)}])
    geo.addPointSet(points, "wing")
    geo.setDesignVars({"twist": np.linspace(1, 5, nodes - 1)})
    moved = geo.update("wing")
    gradient = geo.totalSensitivity(by_points, "wing")
    assert nodes == 4 and gradient["twist"].shape == (1, 3) and gradient["shape"].shape == (1, 32)
    # The end of the wing turns by 5 degrees about the axis, at x = -0.5.
    end = np.flatnonzero(geo.lattice.positions[:, 2] == 8)
    turned = espalier.pose.rotate(geo.lattice.positions[end], "z", np.radians(5), center=(-0.5, 0, 8))
    np.testing.assert_allclose(geo.positions()[end], turned, atol=1e-14)
    assert np.abs(moved - points).max() > 0.05


def test_a_box_of_pygem():
    """PyGeM's FFD is the Bézier volume of Sederberg and Parry, whose weights are products of Bernstein polynomials."""
    points = np.random.default_rng(2).uniform((0.5, 0, 0), (2.5, 1, 1), (50, 3))
    lattice = espalier.shapes.box(cells=(3, 1, 2), min=(0.5, 0, 0), max=(2.5, 1, 1))
    binding = espalier.bind(lattice, points, basis="bezier")
    pose = lattice.positions.copy()
    corner = np.all(np.isclose(pose, (2.5, 1, 1)), axis=1)
    pose[corner] += (0.4, 0, 0)
    moved = binding.deform(pose)
    assert corner.sum() == 1
    # array_mu_x[3, 1, 2] = 0.2, since weights are relative to the side of the box.
    u = (points - (0.5, 0, 0)) / (2, 1, 1)
    weight = binom(3, 3) * u[:, 0] ** 3 * u[:, 1] * u[:, 2] ** 2
    np.testing.assert_allclose(moved[:, 0], points[:, 0] + 2 * 0.2 * weight, atol=1e-14)
    np.testing.assert_allclose(moved[:, 1:], points[:, 1:], atol=1e-14)


def test_a_child_turns_with_its_parent():
    """pyGeo 7: the displacement of a child is turned by a parent that turns, as if the child had been moved first."""
    points = np.random.default_rng(3).uniform(-0.4, 0.4, (40, 3))
    parent = espalier.shapes.box(cells=(2, 2, 2), min=(-2, -2, -2), max=(2, 2, 2))
    child = espalier.shapes.box(cells=(2, 2, 2), min=(-1, -1, -1), max=(1, 1, 1))
    binding = espalier.bind(child, points)
    child_pose = child.positions + (0.25, 0, 0)
    both = espalier.nest(binding, child_pose, parent)
    turned = espalier.pose.rotate(parent.positions, "z", np.pi / 2, center=(0, 0, 0))
    moved = both.csr() @ turned
    np.testing.assert_allclose(moved, (points + (0.25, 0, 0))[:, [1, 0, 2]] * (-1, 1, 1), atol=1e-12)


def test_the_move_of_a_vertex_turns_with_its_section():
    """pyGeo 136: the twist of a section turns the moves of its vertices, and the scale of the chord stretches them."""
    rest = espalier.shapes.box(cells=(2, 1, 2), min=(-1, -0.5, 0), max=(1, 0.5, 3))
    values = espalier.SectionVariables(rest.positions, [0.0, 1.5, 3.0]).at_rest
    twist, chord = np.pi / 3, 1.5
    values[10:12] = twist, chord  # the last section
    vertex = int(np.argmin(np.linalg.norm(rest.positions - (1, 0.5, 3), axis=1)))
    unmoved = espalier.SectionVariables(rest.positions, [0.0, 1.5, 3.0]).positions(values)

    shaped = rest.positions.copy()
    shaped[vertex] += (0, 0.2, 0)
    pose = espalier.SectionVariables(shaped, [0.0, 1.5, 3.0]).positions(values)

    # Coordinates are below 4 in size, so that a difference of two is wrong by at most 2e-15.
    np.testing.assert_allclose(pose[vertex] - unmoved[vertex], (-0.2 * np.sin(twist), 0.2 * np.cos(twist), 0),
                               rtol=0, atol=2e-15)
    others = np.delete(np.arange(len(pose)), vertex)
    np.testing.assert_array_equal(pose[others], unmoved[others])
    # A move along the chord is scaled, too.
    shaped = rest.positions.copy()
    shaped[vertex] += (0.1, 0, 0)
    pose = espalier.SectionVariables(shaped, [0.0, 1.5, 3.0]).positions(values)
    np.testing.assert_allclose(pose[vertex] - unmoved[vertex],
                               0.1 * chord * np.array([np.cos(twist), np.sin(twist), 0]), rtol=0, atol=2e-15)


def test_points_have_a_status_and_one_tolerance(tmp_path):
    """pyGeo 158: a point is placed, outside, or could not be placed; the only tolerance is relative to the lattice."""
    lattice = espalier.shapes.cylinder(sectors=8, layers=2, radius=10, end=(0, 0, 40))
    radius, angle, z = np.random.default_rng(4).uniform((0, 0, 0), (8, 2 * np.pi, 40), (2000, 3)).T
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    binding = espalier.bind(lattice, np.vstack([points, [[0, 0, 41]]]), level=4)
    assert (binding.statuses[:-1] == espalier.PointStatus.INSIDE).all()
    assert binding.statuses[-1] == espalier.PointStatus.OUTSIDE
    assert binding.largest_residual < 1e-13 * 40


def test_a_body_in_blocks_that_meet_in_a_corner(tmp_path):
    """pyGeo 211: an L of three blocks, of which the middle one has a side that two blocks share in part; every point
    of the body is found, and a pose that moves nothing moves no point."""
    # The block at the bottom is twice as long as the block on it, and they share points only.
    bottom = grid(range(5), range(3), range(3))
    top = grid(range(3), range(3), range(2, 5))
    wing = grid(range(3), range(-2, 1), range(5))
    (tmp_path / "ffd.xyz").write_text(plot3d(bottom, top, wing))
    lattice = espalier.read(tmp_path / "ffd.xyz")
    assert len(lattice.hexahedra) == 16 + 8 + 16
    # 45 + 27 + 45 points, of which the blocks share 9 and 15.
    assert len(lattice.positions) == 45 + 27 + 45 - 9 - 15
    random = np.random.default_rng(5)
    points = np.vstack([random.uniform((0.5, 0.5, 0.5), (3.5, 1.5, 1.5), (300, 3)),
                        random.uniform((0.5, 0.5, 0.5), (1.5, 1.5, 3.5), (300, 3)),
                        random.uniform((0.5, -1.5, 0.5), (1.5, 1.5, 3.5), (300, 3))])
    binding = espalier.bind(lattice, points)
    assert (binding.statuses == espalier.PointStatus.INSIDE).all()
    # The weights of a row sum to 1 up to their rounding.
    np.testing.assert_allclose(binding.deform(lattice), points, atol=1e-14)


def test_the_motion_of_a_body_is_prescribed():
    """PyGeM 107: points of the body get given places; the pose of the lattice follows, and moves the mesh around."""
    random = np.random.default_rng(6)
    body = random.normal(size=(60, 3))
    body /= np.linalg.norm(body, axis=1)[:, None]
    mesh = np.vstack([body, random.uniform(-2.9, 2.9, (500, 3))])
    lattice = espalier.shapes.box(cells=(6, 6, 6), min=(-3, -3, -3), max=(3, 3, 3))
    binding = espalier.bind(lattice, mesh)
    rows = np.arange(len(body))
    motion = np.tile((0.2, 0.0, 0.1), (len(body), 1))
    outer = np.flatnonzero(np.abs(lattice.positions).max(axis=1) == 3)
    fit = espalier.fit(lattice, binding, motion, rows=rows, frozen=outer, smoothing="laplacian")
    moved = binding.deform(lattice.positions + fit.displacements)
    np.testing.assert_allclose(moved[rows], body + motion, atol=2 * fit.largest_miss)
    assert fit.largest_miss < 1e-3
    assert np.abs(moved - mesh).max() < 0.4


def test_a_lattice_is_placed_around_the_points():
    """PyGeM 135: the box follows from the points."""
    points = np.random.default_rng(7).uniform((5, 0, -3), (6, 10, -2), (100, 3))
    lattice = espalier.shapes.around(points)
    assert (espalier.bind(lattice, points).statuses == espalier.PointStatus.INSIDE).all()


@pytest.mark.parametrize("options", [{"level": 3}, {"limit": True}, {"basis": "bezier"}])
def test_points_on_the_sides_of_the_box_move(options):
    """PyGeM 272: the control points are the corners of the bounding box, so points lie on all its sides."""
    points = np.random.default_rng(8).uniform(0, 1, (200, 3))
    for axis, side in itertools.product(range(3), (0.0, 1.0)):
        points[20 * axis + 10 * int(side):][:10, axis] = side
    points[60:68] = CUBE
    lattice = espalier.shapes.box(cells=(1, 1, 1), min=(0, 0, 0), max=(1, 1, 1))
    binding = espalier.bind(lattice, points, **options)
    assert (binding.statuses == espalier.PointStatus.INSIDE).all() and len(binding.kept) == 0
    np.testing.assert_allclose(binding.deform(lattice.positions + (1, 2, 3)), points + (1, 2, 3), atol=1e-14)


def test_the_control_points_come_from_a_file(tmp_path):
    """SU2 177: a lattice with control points at any places, for a mesh of SU2."""
    control = grid(range(3), range(3), range(3))
    control[1, 1, 1] += (0.2, 0.1, -0.1)
    (tmp_path / "ffd.xyz").write_text(plot3d(control))
    (tmp_path / "mesh.su2").write_text("NDIME= 3\nNELEM= 1\n10 0 1 2 3 0\nNPOIN= 4\n0.5 0.5 0.5 0\n1.5 0.5 0.5 1\n"
                                       "0.5 1.5 0.5 2\n0.5 0.5 1.5 3\nNMARK= 0\n")
    mesh = espalier.read_model(tmp_path / "mesh.su2")
    lattice = espalier.read(tmp_path / "ffd.xyz")
    binding = espalier.bind(lattice, mesh)
    mesh.write(tmp_path / "moved.su2", binding.deform(lattice.positions + (0, 0, 1)))
    moved = espalier.read_model(tmp_path / "moved.su2").positions
    np.testing.assert_allclose(moved, mesh.positions + (0, 0, 1), atol=1e-14)


def test_a_small_move_that_folds_a_thin_cell_is_found(tmp_path):
    """SU2 1026: a boundary layer of thin cells folds at a small move; the largest step that folds none is known."""
    thin = 1e-5
    (tmp_path / "mesh.su2").write_text(
        f"NDIME= 3\nNELEM= 1\n12 0 1 2 3 4 5 6 7 0\nNPOIN= 8\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
        f"0 0 {thin}\n1 0 {thin}\n1 1 {thin}\n0 1 {thin}\nNMARK= 0\n")
    model = espalier.read_model(tmp_path / "mesh.su2")
    check = espalier.MeshCheck(model)
    moved = model.positions.copy()
    moved[6, 2] -= 4 * thin
    inverted = check.check(moved).inverted
    step = check.largest_step(moved)
    assert list(inverted) == [0] and step.limiting_cell == 0
    # The point meets the plane of the other three at a quarter of the way.
    assert step.length == pytest.approx(0.25, abs=1e-10)
    safe = model.positions + 0.99 * step.length * (moved - model.positions)
    assert len(check.check(safe).inverted) == 0


def test_points_outside_the_lattice_stay():
    """SU2 1879: nothing moves outside; where the outer vertices stay, the moved part continues the rest."""
    lattice = espalier.shapes.box(cells=(4, 4, 4), min=(0, 0, 0), max=(4, 4, 4))
    pose = lattice.positions.copy()
    pose[np.all(pose == 2, axis=1)] += (0.4, 0, 0)
    outside = np.random.default_rng(9).uniform(4.01, 9, (100, 3))
    sides = np.random.default_rng(10).uniform(0, 4, (100, 3))
    sides[:, 0] = 4
    binding = espalier.bind(lattice, np.vstack([outside, sides, [[2, 2, 2]]]))
    moved = binding.deform(pose)
    np.testing.assert_array_equal(moved[:100], outside)
    np.testing.assert_allclose(moved[100:200], sides, atol=1e-14)
    assert moved[200, 0] > 2.05


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".ovm"])
def test_a_lattice_is_written_for_viewers(tmp_path, suffix):
    """mimmo 140: in several formats, and as a mesh for editors of meshes."""
    lattice = espalier.shapes.torus(segments=6)
    lattice.write(tmp_path / ("a" + suffix))
    assert espalier.read(tmp_path / ("a" + suffix)).topology_difference(lattice) is None
    lattice.write_editor_mesh(tmp_path / "a.obj")
    np.testing.assert_array_equal(espalier.read_pose(tmp_path / "a.obj", lattice), lattice.positions)


def test_a_lattice_of_several_boxes_is_one(tmp_path):
    """mimmo 175: an elbow of boxes is one lattice, whose volume is smooth across the faces where the boxes met."""
    boxes = [espalier.shapes.box(cells=(4, 2, 2), min=(0, 0, 0), max=(4, 2, 2)),
             espalier.shapes.box(cells=(2, 4, 2), min=(4, -2, 0), max=(6, 2, 2))]
    elbow = espalier.shapes.merge(boxes)
    assert len(elbow.positions) == 45 + 45 - 9 and len(elbow.cells) == 32
    pose = elbow.positions + 0.1 * np.sin(3 * elbow.positions[:, [1, 2, 0]])
    # Across the face x = 4 the first derivative is the same on both sides, inside the elbow.
    h = 1e-4
    x = np.array([[4 + k * h, 1, 1] for k in (-1, 0, 1)])
    left, middle, right = espalier.bind(elbow, x, limit=True).deform(pose)
    np.testing.assert_allclose((middle - left) / h, (right - middle) / h, atol=1e-3)
