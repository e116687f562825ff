# SPDX-License-Identifier: Apache-2.0
import pickle
import warnings

import numpy as np
import pytest

import espalier

# The vertices of a cube, in VTK's order.
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
                 [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def test_hexahedra_from_arrays_are_what_the_inventory_makes():
    box = espalier.shapes.box(cells=(2, 1, 1))
    made = espalier.Lattice(box.positions, box.hexahedra)
    assert box.counts == made.counts == (12, 20, 11, 2)
    assert box.topology_difference(made) is None
    assert made.dimension == 3
    np.testing.assert_array_equal(made.positions, box.positions)


def test_box_positions_are_indexed_as_the_docstring_says():
    box = espalier.shapes.box(cells=(2, 3, 4), max=(2, 3, 4))
    grid = box.positions.reshape(5, 4, 3, 3)
    np.testing.assert_array_equal(grid[4, 2, 1], (1, 2, 4))


@pytest.mark.parametrize("cells", [
    [[0, 1, 2, 3, 4, 5, 6, 7]],
    np.array([[0, 1, 2, 3, 4, 5, 6, 7]], np.uint8),
    [[[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]],
    [[np.array([0, 3, 2, 1]), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6),
      (3, 0, 4, 7)]],
], ids=["list", "array", "loops", "loops of several kinds"])
def test_cells_are_given_in_any_of_the_ways(cells):
    cube = espalier.Lattice(CUBE, cells)
    assert cube.counts == (8, 12, 6, 1)
    assert cube.topology_difference(espalier.Lattice(CUBE, [range(8)])) is None


def test_cells_of_several_kinds():
    apex = np.vstack([CUBE, [0.5, 0.5, 2]])
    house = espalier.Lattice(apex, [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8]])
    assert house.counts == (9, 16, 10, 2)
    with pytest.raises(ValueError, match="^cell 1 is not a hexahedron"):
        house.hexahedra
    again = espalier.Lattice(house.positions, house.cells)
    assert house.topology_difference(again) is None


def test_positions_are_a_view_that_keeps_its_lattice():
    positions = espalier.shapes.box().positions
    assert not positions.flags.writeable and not positions.flags.owndata
    assert positions.sum() == 12  # each coordinate is 1 at four of eight vertices
    with pytest.raises(ValueError, match="read-only"):
        positions[0] = 1


def test_boundary_faces_and_edges():
    box = espalier.shapes.box(cells=(2, 1, 1))
    faces = box.boundary_faces
    assert len(faces) == 10 and faces.dtype == np.int32
    inside = set(range(11)) - set(faces)
    assert all(box.positions[box.faces[face]][:, 0].tolist() == [0.5] * 4 for face in inside)
    lengths = np.linalg.norm(np.diff(box.positions[box.edges], axis=1), axis=2)
    assert set(lengths.ravel()) == {0.5, 1.0}


def test_marks_come_back_and_change_what_is_refined():
    marked = espalier.Lattice(CUBE, [range(8)], edge_sharpness={(0, 1): 2.5},
                              vertex_sharpness={3: 0})
    assert marked.edge_sharpness == {(0, 1): 2.5} and marked.vertex_sharpness == {3: 0}
    smooth = marked.with_marks(edge_sharpness={tuple(edge): 0 for edge in marked.edges},
                               vertex_sharpness={v: 0 for v in range(8)})
    assert len(smooth.edge_sharpness) == 12
    assert not np.array_equal(espalier.refine(smooth).positions,
                              espalier.refine(marked).positions)


def test_attributes_are_refined_with_the_positions():
    height = CUBE[:, 2] * 7
    cube = espalier.Lattice(CUBE, [range(8)], attributes={"height": height, "uv": CUBE[:, :2]})
    assert {name: array.shape for name, array in cube.attributes.items()} == {
        "height": (8, 1), "uv": (8, 2)}
    refined = espalier.refine(cube, 2)
    # Both are the same sums, but heights are 7 times as large.
    np.testing.assert_allclose(refined.attributes["height"][:, 0], 7 * refined.positions[:, 2],
                               rtol=1e-15, atol=1e-15)


def test_a_pose_and_an_affine_image():
    cube = espalier.Lattice(CUBE, [range(8)])
    np.testing.assert_array_equal(cube.with_positions(CUBE + 1).positions, CUBE + 1)
    turned = cube.transformed([[0, -1, 0], [1, 0, 0], [0, 0, 1]], translation=(1, 0, 0))
    np.testing.assert_array_equal(turned.positions,
                                  CUBE[:, [1, 0, 2]] * [-1, 1, 1] + [1, 0, 0])


@pytest.mark.parametrize("extension", ["ovm", "vtu", "vtk"])
def test_files_give_the_lattice_back(tmp_path, extension):
    cube = espalier.Lattice(CUBE / 3, [range(8)], edge_sharpness={(0, 1): 2.5},
                            attributes={"height": CUBE[:, 2]})
    path = tmp_path / f"cube.{extension}"
    cube.write(path)
    again = espalier.read(str(path))
    assert cube.topology_difference(again) is None
    np.testing.assert_array_equal(again.positions, cube.positions)
    np.testing.assert_array_equal(again.attributes["height"], cube.attributes["height"])
    assert again.edge_sharpness == cube.edge_sharpness


def test_unused_vertices_of_a_file_are_dropped_with_a_warning(tmp_path):
    path = tmp_path / "cube.vtk"
    espalier.Lattice(CUBE, [range(8)]).write(path)
    text = path.read_text()
    assert "POINTS 8 double\n" in text and "CELLS 1 9\n" in text
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cube = espalier.read(path)
    path.write_text(text.replace("POINTS 8 double\n", "POINTS 9 double\n")
                    .replace("CELLS 1 9\n", "9 9 9\nCELLS 1 9\n"))
    with pytest.warns(UserWarning, match=r"cube.vtk: dropped 1 unused vertex \(vertex 8\)$"):
        again = espalier.read(path)
    assert cube.topology_difference(again) is None
    np.testing.assert_array_equal(again.positions, cube.positions)
    with warnings.catch_warnings(), pytest.raises(UserWarning):
        warnings.simplefilter("error")
        espalier.read(path)


def test_integers_of_a_file_are_carried_and_not_averaged(tmp_path):
    path = tmp_path / "cube.vtk"
    espalier.Lattice(CUBE, [range(8)]).write(path)
    gids = [2**53 + 1 + 2 * i for i in range(8)]
    large = [2**64 - 2 - i for i in range(8)]
    with open(path, "a") as file:
        file.write("POINT_DATA 8\nFIELD f 2\ngid 1 8 vtktypeint64\n" + " ".join(map(str, gids)) +
                   "\nlarge 1 8 vtktypeuint64\n" + " ".join(map(str, large)) + "\n")
    cube = espalier.read(path)
    assert cube.attributes == {}
    for lattice in (cube, pickle.loads(pickle.dumps(cube)), espalier.refine(cube, 2)):
        rest = len(lattice.positions) - 8
        assert lattice.integers["gid"].dtype == np.int64
        assert lattice.integers["gid"][:, 0].tolist() == gids + [-1] * rest
        assert lattice.integers["large"].dtype == np.uint64
        assert lattice.integers["large"][:, 0].tolist() == large + [2**64 - 1] * rest


INTEGERS = [f"{order}{kind}{size}" for size in (1, 2, 4, 8) for kind in "iu" for order in "<>"]


def extremes(dtype):
    """Returns an array of shape (8, 1) with the smallest and the largest number of a type."""
    limits = np.iinfo(dtype)
    return np.array([limits.min, limits.max, 0, 1, 2, limits.max - 1, 5, 7], dtype)[:, None]


@pytest.mark.parametrize("dtype", INTEGERS)
def test_integers_that_are_given_are_integers(tmp_path, dtype):
    given = extremes(dtype)
    wide = np.uint64 if dtype.endswith("u8") else np.int64
    none = np.iinfo(dtype).max if dtype[1] == "u" else -1
    for made in (espalier.Lattice(CUBE, [range(8)], attributes={"id": given, "z": CUBE[:, 2]}),
                 espalier.Lattice(CUBE, [range(8)], attributes={"z": CUBE[:, 2],
                                                                "id": given[:, 0]})):
        for extension in "vtk", "vtu":  # .ovm has no integers of 8 bits
            made.write(tmp_path / f"cube.{extension}")
            for lattice in (made, espalier.read(tmp_path / f"cube.{extension}"),
                            made.with_positions(CUBE + 1), pickle.loads(pickle.dumps(made))):
                assert list(lattice.attributes) == ["z"] and list(lattice.integers) == ["id"]
                assert lattice.integers["id"].dtype == wide
                np.testing.assert_array_equal(lattice.integers["id"], given)
        refined = espalier.refine(made).integers["id"]
        np.testing.assert_array_equal(refined[:8], given)
        assert set(refined[8:, 0].tolist()) == {none}
        name = {"i": "Int", "u": "UInt"}[dtype[1]] + str(8 * int(dtype[2]))
        assert f'type="{name}" Name="id"' in (tmp_path / "cube.vtu").read_text()


def test_integers_of_other_shapes():
    pairs = np.arange(16).reshape(8, 2)
    curve = espalier.Lattice.curve(CUBE, attributes={"pair": np.asfortranarray(pairs),
                                                     "list": list(range(8))})
    again = espalier.Lattice.curve(CUBE, attributes={**curve.attributes, **curve.integers})
    for each in curve, again:
        np.testing.assert_array_equal(each.integers["pair"], pairs)
        np.testing.assert_array_equal(each.integers["list"][:, 0], range(8))
    for wrong in (np.arange(7), np.zeros((8, 0), int), np.zeros((8, 1, 1), int)):
        with pytest.raises(ValueError, match=r'^attributes\["id"\]: expected an array of shape'):
            espalier.Lattice(CUBE, [range(8)], attributes={"id": wrong})
    with pytest.raises(ValueError, match=r'^attributes\["id"\]: expected an array of real numbers'):
        espalier.Lattice(CUBE, [range(8)], attributes={"id": [True] * 8})


# A byte that is not UTF-8, a surrogate encoded as in UTF-8, an incomplete character, and valid UTF-8.
NAMES = [b"m\xff", b"\xed\xa0\x80", b"\xc3", "größe μ 😀".encode()]


def str_of(name):
    return name.decode("utf-8", "surrogateescape")


@pytest.mark.parametrize("name", [*NAMES, b"a\0b"])
def test_names_that_are_not_utf_8(name):
    text = str_of(name)
    cube = espalier.Lattice(CUBE, [range(8)], attributes={text: CUBE[:, 2]})
    merged = espalier.shapes.merge([cube, cube.with_positions(CUBE + [1, 0, 0])])
    for lattice in (cube, pickle.loads(pickle.dumps(cube)), espalier.refine(cube), merged):
        assert list(lattice.attributes) == [text]
        assert list(espalier.Lattice(lattice.positions, lattice.cells,
                                     attributes=lattice.attributes).attributes) == [text]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("extension", ["ovm", "vtk"])
def test_names_of_files_come_back_as_the_same_bytes(tmp_path, extension, name):
    path, again = (tmp_path / f"{each}.{extension}" for each in "ab")
    espalier.Lattice(CUBE, [range(8)], attributes={"MARK": CUBE[:, 2]}).write(path)
    written = name.replace(b" ", b"%20") if extension == "vtk" else name
    path.write_bytes(path.read_bytes().replace(b"MARK", written))
    read = espalier.read(path)
    assert list(read.attributes) == [str_of(name)]
    read.write(again)
    assert list(espalier.read(again).attributes) == [str_of(name)]
    if extension == "ovm":  # .vtk writes some bytes as "%FF"
        assert again.read_bytes() == path.read_bytes()


def test_names_of_attributes_are_str():
    for name in (1, b"a", None):
        with pytest.raises(ValueError, match="^attributes: expected names that are str, got "):
            espalier.Lattice(CUBE, [range(8)], attributes={name: CUBE[:, 2]})
    with pytest.raises(ValueError, match="surrogates not allowed"):
        espalier.Lattice(CUBE, [range(8)], attributes={"\ud800": CUBE[:, 2]})
    with pytest.raises(ValueError, match=r'^attributes\["m\\xFF"\]: expected an array of shape'):
        espalier.Lattice(CUBE, [range(8)], attributes={"m\udcff": CUBE[:3]})


def test_meshes_and_curves(tmp_path):
    mesh = espalier.Lattice.mesh(CUBE, [[0, 3, 2, 1], [0, 1, 5, 4]])
    assert mesh.dimension == 2 and mesh.counts == (8, 7, 2, 0)
    mesh.write(tmp_path / "mesh.obj")
    assert espalier.read(tmp_path / "mesh.obj").faces == mesh.faces
    curve = espalier.Lattice.curve(CUBE[:3], closed=True)
    assert curve.counts == (3, 3, 0, 0)
    # New vertices are midpoints, or have weights (1/8, 3/4, 1/8) of three consecutive vertices (Joy,
    # on-line notes).
    np.testing.assert_allclose(espalier.refine(curve).positions[1], (7 / 8, 1 / 8, 0))


@pytest.mark.parametrize("name", espalier.shapes.__all__)
def test_the_inventory_is_valid(name):
    shape = getattr(espalier.shapes, name)
    box = espalier.shapes.box()
    arguments = {"merge": [[box, box.transformed(np.eye(3), (1, 0, 0))]],
                 "around": [box.positions],
                 "collar": [espalier.shapes.box()],
                 "cage": [box.positions, box.faces]}
    lattice = shape(*arguments.get(name, []), **({"reach": 1.0} if name == "collar" else {}))
    refined = espalier.refine(lattice)
    assert refined.counts[3] >= 4
    check = espalier.ValidityCheck(lattice, 1)
    assert len(check.bad_at_rest) == 0


def test_the_inventory_takes_options():
    assert espalier.shapes.cylinder(sectors=5, core="polygon", layers=2).counts[3] == 2
    joints = [[0, 0, 0, 0.3], [1, 0, 0, 0.3], [2, 0, 0, 0.2]]
    arm = espalier.shapes.arm(joints=joints, segments=1)
    twisted = espalier.shapes.arm(joints=np.c_[joints, [0, 0, np.pi / 2]], segments=1)
    assert arm.topology_difference(twisted) is None
    # A quarter turn maps the four vertices at the hand to one another.
    hand = {tuple(p.round(12) + 0.0) for p in arm.positions[-4:]}
    assert {tuple(p.round(12) + 0.0) for p in twisted.positions[-4:]} == hand
    assert not np.allclose(arm.positions[-4:], twisted.positions[-4:])


def test_a_box_around_points():
    around = espalier.shapes.around
    corners = np.array([[0, 0, 0], [4, 2, 1]])
    margin = 0.05 * np.sqrt(21)
    np.testing.assert_allclose(around(corners).positions.min(axis=0), [-margin] * 3)
    np.testing.assert_allclose(around(corners).positions.max(axis=0), corners[1] + margin)
    assert around(corners).counts[3] == 4 * 2 * 1
    assert around(corners, cells=8, margin=0).counts[3] == 8 * 4 * 2
    assert around(corners, cells=(1, 2, 3)).counts[3] == 6
    assert around(corners, cell_size=0.5, margin=0).counts[3] == 8 * 4 * 2
    segment = [[0, 0, 0], [3, 4, 0]]
    assert around(segment, margin=0.1).counts[3] == 3 * 4 * 1
    assert around(segment, margin=0.1, oriented=True).counts[3] == 4
    points = np.random.default_rng(3).normal(size=(500, 3)).astype(np.float32)
    for oriented in (False, True):
        rest = around(points, oriented=oriented)
        binding = espalier.bind(rest, points, outside="error")
        np.testing.assert_allclose(binding.deform(rest), points, atol=1e-12)
    for options, message in [
            ({"cells": 0}, "cells: expected 1 or more, got 0"), ({"cells": (0, 0, 0)}, "cells: expected 1 or more"),
            ({"cells": (1, -1, 1)}, r"cells\[1\]: expected 1 or more, got -1"), ({"cell_size": -1}, "cell_size"),
            ({"margin": -1}, "margin")]:
        with pytest.raises(ValueError, match="^around: " + message):
            around(corners, **options)
    with pytest.raises(ValueError, match="there are no points"):
        around(np.zeros((0, 3)))


def test_a_cage_follows_a_model(tmp_path):
    """The same lattice comes from a model, from its points and faces in another order, and from the model twice."""
    cage = espalier.shapes.cage
    surface = espalier.refine(espalier.shapes.torus(), 1)
    corners = [surface.faces[face] for face in surface.boundary_faces]
    surface = espalier.Lattice.mesh(surface.positions, corners)
    surface.write(tmp_path / "torus.obj")
    model = espalier.read_model(tmp_path / "torus.obj")
    made = cage(model, vertices=60)
    assert 48 <= made.counts[0] <= 72
    assert len(espalier.ValidityCheck(made, limit=True).bad_at_rest) == 0
    binding = espalier.bind(made, model, outside="error", limit=True)
    np.testing.assert_allclose(binding.deform(made), model.positions, atol=1e-12)
    for other in (cage(model.positions, np.array(corners), vertices=60),
                  cage(model.positions, corners[::-1], vertices=60), cage([model, model], vertices=60)):
        np.testing.assert_array_equal(other.positions, made.positions)
        assert other.topology_difference(made) is None
    # Smaller cells are more; a margin makes the lattice wider.
    assert cage(model, cell_size=0.4).counts[0] > made.counts[0]
    around = cage(model, vertices=60, margin=0.05).positions
    assert np.ptp(around, axis=0)[0] > np.ptp(made.positions, axis=0)[0] + 0.1


def test_a_cage_names_what_is_wrong(tmp_path):
    cage = espalier.shapes.cage
    box = espalier.shapes.box()
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\n")
    points = espalier.read_model(tmp_path / "points.obj")
    for arguments, options, message in [
            ([points], {}, r"points.obj has no faces; shapes.around\(\) makes a box"),
            ([box.positions], {}, "model: expected a Model or a list of Model, got ndarray; points need the argument `fa"),
            ([[box.positions]], {}, "model: expected a list of Model, got one with ndarray"),
            ([box.positions, 3], {}, "faces: expected an array or a list of loops, got int"),
            ([box.positions, [[0, 1, 8]]], {}, "a face names point 8"),
            ([box.positions, []], {}, "the model has no faces"),
            ([box.positions, box.faces], {"vertices": 7}, "cage: vertices: expected 8 to 100000, got 7"),
            ([box.positions, box.faces], {"cell_size": -1}, "cage: cell_size: expected 0 to 1e.90, got -1"),
            ([box.positions, box.faces], {"shell": np.nan}, "cage: shell: expected 0 to .*, got nan")]:
        with pytest.raises(ValueError, match=message):
            cage(*arguments, **options)


def test_what_a_lattice_looks_like():
    assert repr(espalier.shapes.box()) == (
        "<espalier.Lattice: 8 vertices, 12 edges, 6 faces, 1 cells>")


@pytest.mark.parametrize("name", ["editor.obj", "editor.ply", "pose.vtu"])
def test_poses_are_read_from_cages_and_lattices(tmp_path, name):
    box = espalier.shapes.box(cells=(2, 1, 1))
    posed = box.with_positions(box.positions * (1, 2, 1 / 3))
    (posed.write if name.endswith("vtu") else posed.write_editor_mesh)(tmp_path / name)
    positions = espalier.read_pose(tmp_path / name, box)
    assert positions.dtype == np.float64
    np.testing.assert_array_equal(positions, posed.positions)
    moved = espalier.bind(box, box.positions, level=1).deform(positions)
    np.testing.assert_allclose(moved, posed.positions, atol=1e-14)
    with pytest.raises(ValueError, match=f"{name}: is not a pose of the lattice"):
        espalier.read_pose(tmp_path / name, espalier.shapes.box(cells=(1, 1, 1)))


def test_the_notes_on_the_file_of_a_pose_are_warnings(tmp_path):
    box = espalier.shapes.box()
    box.write(tmp_path / "pose.ovm")
    text = (tmp_path / "pose.ovm").read_text()
    assert "Vertices\n8\n" in text
    text = text.replace("Vertices\n8\n", "Vertices\n9\n").replace("Edges", "9 9 9\nEdges", 1)
    (tmp_path / "pose.ovm").write_text(text)
    with pytest.warns(UserWarning, match="dropped 1 unused vertex"):
        positions = espalier.read_pose(tmp_path / "pose.ovm", box)
    np.testing.assert_array_equal(positions, box.positions)
