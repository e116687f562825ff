# SPDX-License-Identifier: Apache-2.0
"""Texture coordinates of meshes: made, read, refined and written."""

import copy

import numpy as np
import pytest

import espalier

# Two squares side by side. Their texture coordinates are two charts.
POSITIONS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]]
FACES = [[0, 1, 2, 3], [1, 4, 5, 2]]
TEXTURES = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [5, 5], [6, 5], [6, 6], [5, 6]], dtype=float)
CORNERS = [[0, 1, 2, 3], [4, 5, 6, 7]]
OBJ = ("".join("v {} {} {}\n".format(*p) for p in POSITIONS)
       + "".join("vt {} {}\n".format(*t) for t in TEXTURES)
       + "f 1/1 2/2 3/3 4/4\nf 2/5 5/6 6/7 3/8\n")


def mesh(corners=CORNERS, textures=TEXTURES):
    return espalier.Lattice.mesh(POSITIONS, FACES, texture_coordinates=textures,
                                 texture_corners=corners)


def at_corners(lattice):
    """Returns the texture coordinates at the corners of all faces."""
    return lattice.texture_coordinates[np.concatenate(lattice.texture_corners)]


def test_a_mesh_has_the_texture_coordinates_that_it_was_made_with(tmp_path):
    for corners in (CORNERS, np.array(CORNERS), [np.array(face) for face in CORNERS]):
        made = mesh(corners)
        assert made.texture_corners == CORNERS
        np.testing.assert_array_equal(made.texture_coordinates, TEXTURES)
        assert not made.texture_coordinates.flags.writeable
    made.write(tmp_path / "a.obj")
    (tmp_path / "b.obj").write_text(OBJ)
    for name in ("a.obj", "b.obj"):
        read = espalier.read(tmp_path / name)
        assert read.texture_corners == CORNERS and read.faces == FACES
        np.testing.assert_array_equal(read.texture_coordinates, TEXTURES)
    # A pose and a copy keep them; other lattices have none.
    for other in (made.with_positions(np.ones((6, 3))), made.with_marks(), copy.deepcopy(made),
                  made.transformed(np.diag([-1, 1, 1]))):
        assert other.texture_corners == CORNERS
    for lattice in (espalier.Lattice.mesh(POSITIONS, FACES), espalier.shapes.box()):
        assert lattice.texture_corners == [] and lattice.texture_coordinates.shape == (0, 2)


def test_charts_are_refined_apart():
    # By default, each square is refined bilinearly: nine values in each chart.
    fine = espalier.refine(mesh())
    assert fine.texture_coordinates.shape == (18, 2) and fine.tags["face_varying"] == "all"
    assert len(fine.texture_corners) == 8
    first = [[0, 0], [.5, 0], [.5, .5], [0, .5]]  # the child at the first corner
    np.testing.assert_array_equal(at_corners(fine)[:4], first)
    # "none" rounds the corners of the charts, which are corners of no mesh: (6 P + 2 M) / 8 with M
    # the mean of the midpoints of the two edges. For the corner (1, 0) the neighbours are (0, 0)
    # and (1, 1), so M is (0.75, 0.25). The mesh itself has a corner at (0, 0).
    smooth = espalier.refine(espalier.Refiner(mesh(), face_varying="none"))
    np.testing.assert_array_equal(at_corners(smooth)[0], [0, 0])
    assert [0.875, 0.125] in at_corners(smooth).tolist()
    # No chart reaches into the other one.
    assert at_corners(smooth)[:16].max() <= 1 and at_corners(smooth)[16:].min() >= 5


def test_the_tag_of_the_file_is_the_default_mode(tmp_path):
    tagged = OBJ + "t facevaryinginterpolateboundary 1/0/0 1\n"
    (tmp_path / "a.obj").write_text(tagged)
    read = espalier.read(tmp_path / "a.obj")
    assert read.tags == {"face_varying": "corners-only"}
    results = {}
    for mode in ("none", "corners-only", "corners-plus1", "corners-plus2", "boundaries", "all"):
        chosen = espalier.Refiner(mesh(), face_varying=mode)
        results[mode] = at_corners(chosen.refine(2))
        # Levels one by one are the same: the refined mesh has the mode as a tag.
        np.testing.assert_allclose(at_corners(espalier.refine(chosen.refine(1))), results[mode],
                                   atol=1e-13)
        np.testing.assert_array_equal(at_corners(espalier.Refiner(read, face_varying=mode)
                                                 .refine(2)), results[mode])
    np.testing.assert_array_equal(at_corners(espalier.refine(read, 2)), results["corners-only"])
    np.testing.assert_array_equal(at_corners(espalier.refine(mesh(), 2)), results["all"])
    assert not np.array_equal(results["none"], results["corners-only"])
    read.write(tmp_path / "b.obj")
    assert "t facevaryinginterpolateboundary 1/0/0 1\n" in (tmp_path / "b.obj").read_text()


def test_without_seams_they_are_refined_as_positions():
    flat = espalier.Lattice.mesh(POSITIONS, FACES, texture_coordinates=np.array(POSITIONS)[:, :2],
                                 texture_corners=FACES)
    fine = espalier.refine(espalier.Refiner(flat, face_varying="none"), 3)
    np.testing.assert_array_equal(fine.texture_coordinates, fine.positions[:, :2])
    assert fine.texture_corners == fine.faces


@pytest.mark.parametrize("arguments, message", [
    ({"texture_coordinates": TEXTURES}, "expected both or neither"),
    ({"texture_corners": CORNERS}, "expected both or neither"),
    ({"texture_coordinates": TEXTURES[:, :1], "texture_corners": CORNERS},
     r"texture_coordinates: expected an array of shape \(T, 2\), got \(8, 1\)"),
    ({"texture_coordinates": TEXTURES + np.inf, "texture_corners": CORNERS},
     r"texture_coordinates\[0, 0\] is inf; expected a finite number"),
    ({"texture_coordinates": TEXTURES, "texture_corners": CORNERS[:1]},
     "texture_corners: expected one entry for each of the 2 faces, got 1"),
    ({"texture_coordinates": TEXTURES, "texture_corners": [[0, 1, 2], [4, 5, 6, 7]]},
     r"texture_corners\[0\]: expected 4 values, one for each corner, got 3"),
    ({"texture_coordinates": TEXTURES, "texture_corners": [[0, 1, 2, 3], [4, 5, 6, 8]]},
     r"texture_corners\[1\]: names 8; there are 8 texture coordinates"),
    ({"texture_coordinates": TEXTURES, "texture_corners": [[0, 1, 2, 3], [4, 5, 6, -1]]},
     r"texture_corners\[1\]: names -1"),
    ({"texture_coordinates": TEXTURES, "texture_corners": 7}, "texture_corners: expected an array"),
])
def test_texture_coordinates_that_do_not_fit_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        espalier.Lattice.mesh(POSITIONS, FACES, **arguments)


def test_unknown_modes_are_refused():
    with pytest.raises(ValueError, match="face_varying: expected .*corners-plus1.*, got \"linear\""):
        espalier.Refiner(mesh(), face_varying="linear")
