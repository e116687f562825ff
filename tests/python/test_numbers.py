# SPDX-License-Identifier: Apache-2.0
"""Every real number of every function is refused, by the name of its argument, if it is not finite.

The functions and their arguments are those of the stubs (.pyi), which test_package.py compares with the module."""

import ast
import copy
import pathlib
import re

import espalier
import numpy as np
import pytest

BOX = espalier.shapes.box(cells=(2, 2, 2))
POSITIONS = BOX.positions
POINTS = np.array([[0.5, 0.5, 0.5], [0.2, 0.3, 0.9]])
FACES = BOX.boundary_faces
BOUND = espalier.bind(BOX, POINTS, level=1, gradients=True)
GRADIENTS = np.array([np.eye(3), np.eye(3)])
TABLE = espalier.CompiledTable(BOUND.table)
MARKS = {"edge_sharpness": {(0, 1): 1.0}, "vertex_sharpness": {0: 1.0}}
FALLOFF = {"positions": POSITIONS, "falloff_radius": 0.5}
PLACE = {"positions": POSITIONS, "weights": np.ones(27), "center": (0.5, 0.5, 0.5)}
ALONG = {**PLACE, "axis": (0, 0, 1), "range": (0, 1)}
MESH = {"positions": POSITIONS[:4], "faces": [[0, 1, 3]], "edge_sharpness": {(0, 1): 1.0},
        "vertex_sharpness": {0: 1.0}, "attributes": {"a": np.ones(4)},
        "texture_coordinates": np.zeros((3, 2)), "texture_corners": [[0, 1, 2]]}
SECTIONS = espalier.SectionVariables(POSITIONS, [0.0, 1.0])
AXIS = espalier.ReferenceAxis(POSITIONS, [[0.5, 0.5, 0.0], [0.5, 0.5, 1.0]])
CORNER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
CORNER_FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
# A body of 3 x 3 x 3 cubes, and a row of cubes on it.
LIMB = espalier.shapes.merge([espalier.shapes.box((3, 3, 3), (0, 0, 0), (3, 3, 3)),
                              espalier.shapes.box((1, 1, 3), (1, 1, 3), (2, 2, 6))])

# A good call of each function: its arguments by name, with each real number that it takes. `model` stands for a model.
GOOD = {
    "Lattice": {"positions": POSITIONS, "cells": BOX.hexahedra, **MARKS, "attributes": {"a": np.ones(27)}},
    "Lattice.mesh": MESH,
    "Lattice.curve": {"positions": POSITIONS[:4], "vertex_sharpness": {0: 1.0}, "attributes": {"a": np.ones(4)}},
    "Lattice.with_positions": {"positions": POSITIONS},
    "Lattice.with_marks": MARKS,
    "Lattice.transformed": {"linear": np.eye(3), "translation": (1.0, 2.0, 3.0)},
    "Refiner.positions": {"level": 1, "pose": POSITIONS},
    "CompiledTable.evaluate": {"values": POSITIONS},
    "CompiledAdjoint.evaluate": {"values": POINTS},
    "ChangeEvaluator.evaluate_changed": {"values": POSITIONS, "changed": [0], "out": np.zeros((2, 3))},
    "Model.write": {"path": "out.obj", "positions": POINTS, "gradients": GRADIENTS},
    "Binding.deform": {"pose": POSITIONS},
    "Binding.adjoint": {"gradients": POINTS},
    "Binding.gradients": {"pose": POSITIONS},
    "carry_normals": {"gradients": GRADIENTS, "normals": POINTS},
    "carry_tangents": {"gradients": GRADIENTS, "tangents": POINTS},
    "DesignVariables.link": {"vertex": 1, "to": 0, "factors": (1.0, 2.0, 3.0)},
    "DesignVariables.mirror": {"positions": POSITIONS, "axis": 0, "at": 0.5, "tolerance": 1e-9},
    "DesignVariables.scale": {"vertices": 1, "unit": 2.0},
    "SectionVariables": {"positions": POSITIONS, "stations": [0.0, 1.0], "axis": (0, 0, 1), "chord": (1, 0, 0),
                         "center": (0.5, 0.5, 0)},
    "SectionVariables.positions": {"values": SECTIONS.at_rest},
    "SectionVariables.matrix": {"values": SECTIONS.at_rest},
    "ReferenceAxis": {"positions": POSITIONS, "nodes": AXIS.at_rest[:, :3], "direction": (0.0, 0.0, 1.0),
                      "frame": np.eye(3)},
    "ReferenceAxis.moved_to": {"positions": POSITIONS, "nodes": AXIS.at_rest[:, :3]},
    "ReferenceAxis.positions": {"values": AXIS.at_rest},
    "ReferenceAxis.matrix": {"values": AXIS.at_rest},
    "ReferenceAxis.rest_matrix": {"values": AXIS.at_rest},
    "constraints.distances": {"points": POINTS, "pairs": [[0, 1]]},
    "constraints.crossings": {"points": CORNER, "triangles": CORNER_FACES, "line_points": np.array([[0.1, 0.1, 0.1]]),
                              "line_directions": np.array([[0.0, 0.0, 1.0]])},
    "constraints.thicknesses": {"points": CORNER, "crossings": espalier.constraints.crossings(
        CORNER, CORNER_FACES, [[0.1, 0.1, 0.1]], [[0, 0, 1]])},
    "constraints.volume": {"points": CORNER, "triangles": CORNER_FACES},
    "constraints.area": {"points": CORNER, "triangles": CORNER_FACES},
    "constraints.curvatures": {"points": CORNER, "line": [0, 1, 2]},
    "constraints.planarity": {"points": CORNER, "some": [0, 1, 2]},
    "ValidityCheck.check": {"pose": POSITIONS},
    "ValidityCheck.largest_step": {"pose": POSITIONS, "most": 1.0},
    "bind": {"lattice": BOX, "points": POINTS, "tolerance": 1e-6, "weights": np.ones(2), "falloff": 0.5},
    "fit": {"lattice": BOX, "deformation": BOUND, "misses": 0 * POINTS, "strength": 1e-3},
    "RigidPull": {"lattice": BOX, "deformation": BOUND, "reach": 1.0, "tolerance": 1e-6},
    "RigidPull.solve": {"misses": POINTS, "start": 0 * POSITIONS},
    "check": {"lattice": BOX, "pose": POSITIONS},
    "hold": {"lattice": BOX, "points": POINTS, "tolerance": 1e-6},
    "nest": {"child": BOUND, "child_pose": POSITIONS / 2 + 0.25, "parent": BOX, "tolerance": 1e-6},
    "pose.move": {"positions": POSITIONS, "weights": np.ones(27), "offset": (1, 2, 3)},
    "pose.displace": {"positions": POSITIONS, "weights": np.ones(27), "displacements": POSITIONS},
    "pose.rotate": {**PLACE, "axis": (0, 0, 1), "angle": 1.0},
    "pose.scale": {**PLACE, "factors": (1, 2, 3)},
    "pose.twist": {**ALONG, "angle": 1.0},
    "pose.bend": {**ALONG, "angle": 1.0, "toward": (1, 0, 0)},
    "pose.mirror": {"rest": POSITIONS, "positions": POSITIONS, "axis": "x", "weights": np.ones(27), "plane": 0.5},
    "pose.taper": {**ALONG, "factor": 0.5},
    "pose.select_box": {**FALLOFF, "corner": (0, 0, 0), "opposite": (1, 1, 1)},
    "pose.select_ball": {**FALLOFF, "center": (0, 0, 0), "radius": 1.0},
    "pose.select_half_space": {**FALLOFF, "point": (0, 0, 0), "normal": (0, 0, 1)},
    "pose.select_end": {**FALLOFF, "direction": (0, 0, 1)},
    "pose.select_numbers": {**FALLOFF, "numbers": [0]},
    "pose.select_limb": {"lattice": LIMB, "point": (1.5, 1.5, 6), "falloff_radius": 0.5},
    "pose.select_beyond": {"lattice": BOX, "face": (0.2, 0.2, 0.5), "falloff_radius": 0.5},
    "pose.select_near": {"lattice": BOX, "point": (0, 0, 0), "radius": 0.5, "falloff_radius": 0.5},
    "pose.grow": {"lattice": BOX, "weights": np.ones(27)},
    "pose.without_held": {"lattice": BOX, "weights": np.ones(27)},
    "pose.border": {"lattice": BOX, "weights": np.repeat([1.0, 0.0], [18, 9])},
    "shapes.box": {"min": (0, 0, 0), "max": (1, 1, 1)},
    "shapes.around": {"points": POINTS, "cell_size": 0.1, "margin": 0.1, "symmetry": "x", "symmetry_at": 0.2},
    "shapes.collar": {"lattice": BOX, "reach": 0.0, "until": ((-1, -1, -1), (2, 2, 2))},
    "shapes.cage": {"model": POSITIONS, "faces": [BOX.faces[face] for face in FACES], "vertices": 40,
                    "cell_size": 0.0, "margin": 0.0, "shell": 0.0, "symmetry": 1e-4},
    "shapes.cylinder": {"radius": 1.0, "start": (0, 0, 0), "end": (0, 0, 1)},
    "shapes.torus": {"major_radius": 1.0, "minor_radius": 0.4},
    "shapes.star": {"inner_radius": 0.5, "outer_radius": 1.0, "height": 0.25},
    "shapes.barbell": {"end_radius": 1.0, "bar_length": 2.0, "bar_half_width": 0.4, "roundness": 1.0, "height": 0.5},
    "shapes.arm": {"joints": np.array([[0, 0, 0, 1, 0], [4, 0, 0, 1, 0.0]]), "up": (0, 0, 1)},
    **{f"shapes.{name}": {"radius": 1.0} for name in ("tetrahedron", "cube", "octahedron", "dodecahedron",
                                                       "icosahedron")},
    **{f"shapes.{name}": {"radius": 1.0, "height": 1.0} for name in ("prism", "pyramid", "bipyramid")},
    "shapes.merge": {"lattices": [BOX], "tolerance": 1e-9},
}
# Methods need an object.
OBJECTS = {"Lattice": BOX, "Refiner": espalier.Refiner(BOX), "CompiledTable": TABLE,
           "CompiledAdjoint": espalier.CompiledAdjoint(BOUND.table), "ChangeEvaluator": espalier.ChangeEvaluator(TABLE),
           "Binding": BOUND, "DesignVariables": espalier.DesignVariables(27), "SectionVariables": SECTIONS,
           "ReferenceAxis": AXIS,
           "ValidityCheck": espalier.ValidityCheck(BOX, 1), "RigidPull": espalier.RigidPull(BOX, BOUND)}
# Arrays of integers.
INTEGERS = {"cells", "faces", "holes", "texture_corners", "vertices", "changed", "rows", "frozen", "pins", "numbers",
            "pairs", "triangles", "line", "some"}
# A mesh of tetrahedra is checked in the same way: MeshCheck and SlidingPoints read it from a file.
MESH_CHECK = {"MeshCheck.check": {"points"}, "MeshCheck.largest_step": {"points", "most"},
              "MeshCheck.quality": {"points"}, "MeshCheck.shorten": {"points"},
              "MeshCheck.solver_errors": {"points"}, "MeshCheck.broken_patches": {"points"},
              "SlidingPoints.slide": {"points"}}


def real_arguments():
    """Returns the names of the arguments of each function that the stubs say take real numbers."""
    found = {}
    folder = pathlib.Path(espalier.__file__).parent
    for stub, prefix in (("__init__.pyi", ""), ("pose.pyi", "pose."), ("shapes.pyi", "shapes."),
                         ("constraints.pyi", "constraints.")):
        def visit(body, outer):
            for node in body:
                if isinstance(node, ast.ClassDef):
                    visit(node.body, outer + node.name + ".")
                elif isinstance(node, ast.FunctionDef):
                    name = (outer + node.name).removesuffix(".__init__")
                    arguments = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
                    real = {each.arg for each in arguments if each.annotation
                            and re.search(r"\bfloat\b|ArrayLike|_Axis", ast.unparse(each.annotation))}
                    if real - INTEGERS:
                        found[name] = real - INTEGERS
        visit(ast.parse((folder / stub).read_text()).body, prefix)
    return found


def test_every_function_is_here():
    found = real_arguments()
    assert sorted(found) == sorted({**GOOD, **MESH_CHECK})
    for name, arguments in found.items():
        assert arguments <= set(GOOD.get(name, MESH_CHECK.get(name))), name


def changed(value, bad):
    """Returns a value with `bad` in place of one of its numbers."""
    if isinstance(value, dict):
        return {key: changed(each, bad) for key, each in value.items()}
    if isinstance(value, float):
        return bad
    array = np.array(value, float)
    array.flat[array.size // 2] = bad
    return array if isinstance(value, np.ndarray) else type(value)(array.tolist())


@pytest.fixture
def call(tmp_path):
    (tmp_path / "model.obj").write_text("v 0 0 0\nv 1 0 0\n")
    objects = {**OBJECTS, "Model": espalier.read_model(tmp_path / "model.obj")}

    def call(name, arguments):
        owner, _, method = name.rpartition(".")
        where = objects.get(owner) or getattr(espalier, owner, espalier)
        if "path" in arguments:
            arguments = {**arguments, "path": tmp_path / arguments["path"]}
        return getattr(where, method)(**arguments)

    return call


@pytest.mark.parametrize("name", GOOD)
def test_numbers_that_are_not_finite_are_refused(name, call):
    call(name, GOOD[name])
    for argument in real_arguments()[name]:
        for bad in (float("nan"), float("inf"), -float("inf")):
            word = argument
            if argument.endswith("sharpness"):
                if bad > 0:
                    continue  # infinitely sharp
                word = "sharpness"  # "vertex 0 is marked with sharpness nan"
            with pytest.raises(ValueError) as error:
                call(name, {**GOOD[name], argument: changed(copy.copy(GOOD[name][argument]), bad)})
            assert re.search(rf"\b{word}\b", str(error.value)), (argument, bad, str(error.value))


@pytest.mark.parametrize("name", MESH_CHECK)
def test_numbers_of_the_checks_of_meshes(name, tmp_path):
    (tmp_path / "mesh.su2").write_text(
        "NDIME= 3\nNELEM= 1\n10 0 1 2 3\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        "NMARK= 1\nMARKER_TAG= low\nMARKER_ELEMS= 1\n5 0 2 1\n")
    model = espalier.read_model(tmp_path / "mesh.su2")
    owner = espalier.MeshCheck(model) if name.startswith("MeshCheck") else espalier.SlidingPoints(model, ["low"])
    method = getattr(owner, name.split(".")[1])
    good = {"points": model.positions, "most": 1.0}
    good = {argument: good[argument] for argument in MESH_CHECK[name]}
    method(**good)
    for argument in good:
        for bad in (float("nan"), float("inf"), -float("inf")):
            with pytest.raises(ValueError, match=rf"\b{argument}\b"):
                method(**{**good, argument: changed(copy.copy(good[argument]), bad)})
