# SPDX-License-Identifier: Apache-2.0
"""espalier.dvgeometry: the calls of pyGeo on lattices. The numbers of pyGeo's own tests are compared by hand
(docs/from-pygeo-pygem-su2.md)."""

import tracemalloc

import numpy as np
import pytest

import espalier
from espalier.dvgeometry import DVGeometry

NODES = np.linspace((0, 0, 0), (0, 0, 8), 4)
POINTS = np.random.default_rng(0).uniform((-0.9, -0.4, 0.1), (0.9, 0.4, 7.9), (20, 3))


def wing():
    """A wing of 3 x 1 x 3 cells along z."""
    return espalier.shapes.box(cells=(3, 1, 3), min=(-1, -0.5, 0), max=(1, 0.5, 8))


def tube():
    """Eight sectors around an axis: no box, with vertices of other valences."""
    return espalier.shapes.cylinder(sectors=8, layers=3, radius=1.5, start=(0, 0, 0), end=(0, 0, 8))


def twist(values, geo):
    for node in range(1, 4):
        geo.rot_theta["axis"].coef[node] = values[node - 1]


def chord(values, geo):
    geo.scale_x["axis"].coef[:] = values


def turn(values, geo):
    geo.rot_x["axis"].coef[-1] = values[0]
    geo.rot_y["axis"].coef[-1] = values[1]
    geo.rot_z["axis"].coef[-1] = values[2]
    geo.scale["axis"].coef[1] = 1 + values[0] / 100


def span(values, geo):
    nodes = geo.extractCoef("axis")
    nodes[1:, 2] *= values[0]
    nodes[-1, 0] += values[0] - 1
    geo.restoreCoef(nodes, "axis")


def with_variables(lattice, **axis):
    geo = DVGeometry(lattice, level=2)
    geo.addPointSet(POINTS, "points")
    nodes = np.linspace((0, 0, 0), (0, 0, 8), 4)
    assert geo.addRefAxis("axis", curve=nodes, **{"axis": np.array([0, 0, 1.0]), **axis}) == 4
    geo.addGlobalDV("twist", np.zeros(3), twist, lower=-10, upper=10)
    geo.addGlobalDV("chord", np.ones(4), chord)
    geo.addGlobalDV("turn", np.zeros(3), turn)
    geo.addGlobalDV("span", 1.0, span)
    geo.addLocalDV("up", axis="y", vertices=[3, 5, 8])
    geo.addShapeFunctionDV("bump", [{2: (0, 1, 0), 6: (0.5, 0, 0)}, {7: (0, 0, 1)}])
    return geo


def some_values(geo):
    random = np.random.default_rng(5)
    values = geo.getValues()
    scales = {"twist": 20, "turn": 15}
    return {name: value + scales.get(name, 0.1) * random.normal(size=value.shape) for name, value in values.items()}


def expect_derivatives(geo, values, name="points", **config):
    """Compares all forms of the derivatives with differences of fourth order."""
    geo.setDesignVars(values)
    count = geo.points[name].size
    jacobian = geo.computeTotalJacobian(name, **config).toarray()
    products = geo.totalSensitivity(np.eye(count).reshape(count, -1, 3), name, **config)
    first = 0
    for group in geo.getVarNames():
        for k in range(len(values[group])):
            h = 1e-3 * max(1, abs(values[group][k]))
            ends = []
            for step in (-2, -1, 1, 2):
                moved = {each: value.copy() for each, value in values.items()}
                moved[group][k] += step * h
                geo.setDesignVars(moved)
                ends.append(geo.update(name, **config).ravel())
            expected = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * h)
            np.testing.assert_allclose(jacobian[first + k], expected, atol=1e-9, err_msg=f"{group}[{k}]")
            np.testing.assert_allclose(products[group][:, k], expected, atol=1e-9)
        first += len(values[group])
    geo.setDesignVars(values)
    random = np.random.default_rng(6)
    seed = {group: random.normal(size=len(value)) for group, value in values.items()}
    np.testing.assert_allclose(geo.totalSensitivityProd(seed, name, **config),
                               jacobian.T @ geo.convertDictToSensitivity(seed), atol=1e-12)
    gradient = random.normal(size=(count // 3, 3))
    back = geo.totalSensitivityTransProd(gradient, name, **config)
    np.testing.assert_allclose(geo.convertDictToSensitivity(back), jacobian @ gradient.ravel(), atol=1e-12)


@pytest.mark.parametrize("lattice", [wing, tube], ids=["box", "cylinder"])
@pytest.mark.parametrize("axis", [{}, {"rotType": 0}, {"rotType": 1}, {"rotType": 7}, {"rotType": 0, "rot0ang": -90}],
                         ids=str)
def test_derivatives(lattice, axis):
    geo = with_variables(lattice(), **axis)
    np.testing.assert_array_equal(geo.update("points"), POINTS)
    assert geo.getVarNames() == ["twist", "chord", "turn", "span", "up", "bump"]
    assert geo.getNDV() == 3 + 4 + 3 + 1 + 3 + 2
    expect_derivatives(geo, some_values(geo))


def test_the_memory_for_derivatives_is_in_proportion_to_the_lattice():
    """Rows that were set one by one made a dense matrix: 6,600 bytes for each of 216 vertices, 33,000 for each of 1,331."""
    bytes_per_vertex = []
    for n in (5, 10):
        geo = DVGeometry(espalier.shapes.box(cells=(n, n, n), min=(-1, -0.5, 0), max=(1, 0.5, 8)))
        geo.addRefAxis("axis", curve=np.linspace((0, 0, 0), (0, 0, 8), 4), axis=np.array([0, 0, 1.0]))
        geo.addGlobalDV("chord", np.ones(4), chord)
        geo.addLocalDV("up")
        geo.addPointSet(POINTS, "points")
        tracemalloc.start()
        geo.totalSensitivity(POINTS, "points")
        bytes_per_vertex.append(tracemalloc.get_traced_memory()[1] / (n + 1) ** 3)
        tracemalloc.stop()
    # A fixed part, which weighs more in the small lattice, and about 350 bytes for each vertex.
    assert bytes_per_vertex[1] < bytes_per_vertex[0] and bytes_per_vertex[1] < 1000


def test_the_points_are_of_the_pose_of_the_lattice():
    geo = with_variables(tube())
    geo.setDesignVars(some_values(geo))
    binding = espalier.bind(geo.lattice, POINTS, level=2)
    np.testing.assert_allclose(geo.update("points"), binding.deform(geo.positions()), atol=1e-13)


def test_a_twist_is_in_degrees_and_about_the_axis():
    geo = DVGeometry(wing())
    geo.addPointSet(POINTS, "points")
    geo.addRefAxis("axis", curve=[(0, 0, 0), (0, 0, 8)], axis=np.array([0, 0, 1.0]))
    def all_turn(values, geo):
        geo.rot_z["axis"].coef[:] = values[0]
    geo.addGlobalDV("turn", 0.0, all_turn)
    geo.setDesignVars({"turn": 30, "other": 7})
    np.testing.assert_allclose(geo.update("points"), espalier.pose.rotate(POINTS, "z", np.pi / 6, center=(0, 0, 0)),
                               atol=1e-13)


def test_axes_follow_from_the_layers_of_a_box():
    geo = DVGeometry(wing())
    assert geo.addRefAxis("axis", xFraction=0.25, yFraction=0.4, alignIndex="k") == 4
    np.testing.assert_allclose(geo.axis["axis"]["curve"].X, [(-0.5, 0.1, 8 * k / 3) for k in range(4)])
    np.testing.assert_allclose(geo.extractS("axis"), [0, 1 / 3, 2 / 3, 1])
    np.testing.assert_array_equal(geo.getLocalIndex()[2, 1, 3], np.flatnonzero(
        np.isclose(geo.lattice.positions, (1 / 3, 0.5, 8)).all(axis=1)))
    with pytest.raises(ValueError, match="is not a hexahedron"):
        DVGeometry(espalier.shapes.tetrahedron()).addRefAxis("axis", xFraction=0.5, alignIndex="k")


def test_frozen_vertices_stay():
    geo = DVGeometry(wing(), faceFreeze={"0": ["kLow"]}, frozen=[31])
    held = np.append(np.flatnonzero(geo.lattice.positions[:, 2] < 3), 31)
    assert geo.addLocalDV("all", axis="xyz") == 3 * (32 - len(held))
    geo.addRefAxis("axis", curve=[(0, 0, 0), (0, 0, 8)])
    def move(values, geo):
        geo.restoreCoef(geo.extractCoef("axis") + values, "axis")
    geo.addGlobalDV("move", np.zeros(3), move)
    geo.setDesignVars({"all": np.full(geo.getNDV() - 3, 0.1), "move": (1, 2, 3)})
    moved = (geo.positions() != geo.lattice.positions).any(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(~moved), np.unique(held))


def test_frozen_vertices_stay_under_shapes_lines_and_links():
    geo = DVGeometry(wing(), frozen=[5, 6])
    geo.addShapeFunctionDV("shape", [{5: (0, 1, 0)}, {6: (1, 0, 0), 7: (0, 0, 1)}])
    geo.addLocalDV("linked", design=espalier.DesignVariables(32))
    geo.addSpanwiseLocalDV("line", "k", axis="x")
    geo.addPointSet(POINTS, "points")
    geo.setDesignVars({name: np.ones(len(value)) for name, value in geo.getValues().items()})
    still = np.flatnonzero((geo.positions() == geo.lattice.positions).all(axis=1))
    np.testing.assert_array_equal(still, [5, 6])
    expect_derivatives(geo, geo.getValues())


def test_vertices_that_the_lattice_holds_are_frozen():
    """They moved by local variables and by axes, though fits and pulls hold them."""
    collar = espalier.shapes.collar(espalier.shapes.box((2, 2, 2), (0, 0, 0), (2, 2, 2)), layers=2, reach=1.0)
    assert 0 < len(collar.held) < len(collar.positions)

    def lift(values, geo):
        geo.restoreCoef(geo.extractCoef("axis") + (0, 0, values[0]), "axis")

    for move_held in (False, True):
        geo = DVGeometry(collar, move_held=move_held)
        geo.addRefAxis("axis", curve=[(1, 1, 0), (1, 1, 2)])
        geo.addGlobalDV("lift", 0.0, lift)
        geo.addLocalDV("up", axis="z")
        geo.setDesignVars({name: np.ones(len(value)) for name, value in geo.getValues().items()})
        still = np.flatnonzero((geo.positions() == collar.positions).all(axis=1))
        np.testing.assert_array_equal(still, [] if move_held else np.sort(collar.held))


def test_variables_of_the_library():
    design = espalier.DesignVariables(32)
    design.mirror(wing().positions, axis=1)
    geo = DVGeometry(wing())
    assert geo.addLocalDV("even", design=design) == design.matrix().shape[1]
    values = np.random.default_rng(1).normal(size=design.matrix().shape[1])
    geo.setDesignVars({"even": values})
    np.testing.assert_array_equal(geo.positions(),
                                  geo.lattice.positions + (design.matrix().csr() @ values).reshape(-1, 3))


def test_lines_move_alike():
    geo = DVGeometry(wing())
    assert geo.addSpanwiseLocalDV("section", "k", axis="y") == 8
    values = np.arange(8.0)
    geo.setDesignVars({"section": values})
    lift = (geo.positions() - geo.lattice.positions)[geo.getLocalIndex()]
    np.testing.assert_array_equal(lift[..., 1], np.broadcast_to(values.reshape(4, 2, 1), (4, 2, 4)))
    assert (lift[..., [0, 2]] == 0).all()


def test_children_add_their_changes():
    """A child's vertices and axis follow the parent; its own changes are added, where its points are."""
    parent = with_variables(wing())
    small = espalier.shapes.box(cells=(2, 1, 2), min=(-0.8, -0.4, 1), max=(0.8, 0.4, 6))
    child = DVGeometry(small, child=True, name="flap", level=2)
    child.addRefAxis("hinge", curve=[(0, 0, 1), (0, 0, 6)], axis=np.array([0, 0, 1.0]), rotType=7)
    def hinge(values, geo):
        geo.rot_theta["hinge"].coef[:] = values
        nodes = geo.extractCoef("hinge")
        nodes[1, 0] += 0.01 * values[0]
        geo.restoreCoef(nodes, "hinge")
    child.addGlobalDV("angle", np.zeros(2), hinge)
    child.addLocalDV("up", axis="y", vertices=[4, 7])
    parent.addChild(child)
    parent.addPointSet(POINTS, "without", activeChildren=[])
    assert parent.getVarNames()[-2:] == ["flap_angle", "flap_up"]
    np.testing.assert_allclose(parent.update("points"), POINTS, atol=1e-13)
    values = some_values(parent)
    values["flap_angle"] = np.array([10.0, -5.0])
    expect_derivatives(parent, values)
    change = parent.update("points") - parent.update("without")
    inside = (np.abs(POINTS) <= (0.8, 0.4, 9)).all(axis=1) & (POINTS[:, 2] > 1) & (POINTS[:, 2] < 6)
    assert 0 < inside.sum() < len(POINTS)
    assert (np.abs(change[inside]) > 1e-6).any(axis=1).all() and (change[~inside] == 0).all()
    # With the variables of the parent at rest, it is the change of the child alone.
    parent.setDesignVars({name: value for name, value in with_variables(wing()).getValues().items()})
    own = espalier.bind(small, POINTS, level=2).deform(child.positions())
    np.testing.assert_allclose(parent.update("points"), own, atol=1e-13)
    # Variables that the child gets later, or that are set on the child, count as well.
    parent.update("points")
    parent.totalSensitivity(POINTS, "points")
    child.addLocalDV("side", axis="x", vertices=[2])
    assert not parent.pointSetUpToDate("points")
    expect_derivatives(parent, {**parent.getValues(), "flap_side": np.array([0.1])})
    before = parent.update("points")
    child.setDesignVars({"flap_side": 0.3})
    assert not parent.pointSetUpToDate("points") and np.abs(parent.update("points") - before).max() > 1e-3
    with pytest.raises(ValueError, match=r"^name: add the reference axes of a child before addChild\(\)$"):
        child.addRefAxis("late", curve=[(0, 0, 1), (0, 0, 6)])
    with pytest.raises(ValueError, match="^childDVGeo: there is a child flap already"):
        parent.addChild(DVGeometry(small, child=True, name="flap"))
    with pytest.raises(ValueError, match="^childDVGeo: expected a DVGeometry that was made with child=True"):
        parent.addChild(DVGeometry(small))


SMALL = espalier.shapes.box(cells=(2, 1, 2), min=(-0.8, -0.4, 1), max=(0.8, 0.4, 6))


def test_names_of_variables_are_unique_in_the_whole_tree():
    """Equal names hid the variables of the parent, and derivatives were of the wrong shape."""
    parent = DVGeometry(wing())
    parent.addLocalDV("up")
    child = DVGeometry(SMALL, child=True)
    child.addLocalDV("up")
    with pytest.raises(ValueError, match="^childDVGeo: the outermost lattice and the child both have variables up; give "):
        parent.addChild(child)
    assert not parent.children and child._parent is None
    first, second = (DVGeometry(SMALL, child=True, name=name) for name in ("first", "second"))
    parent.addChild(first)
    parent.addChild(second)
    first.addLocalDV("up")
    second.addLocalDV("up")
    for geo, owner in ((parent, "the child first has"), (second, "the child first has")):
        with pytest.raises(ValueError, match=f"^dvName: {owner} variables first_up already; give the variables of "):
            geo.addLocalDV("first_up", prependName=False)
    with pytest.raises(ValueError, match="^dvName: the outermost lattice has variables up already; give the variables of "
                                         "the child first another name$"):
        first.addLocalDV("up", prependName=False)
    inner = DVGeometry(SMALL, child=True, name="inner")
    inner.addLocalDV("second_up", prependName=False)
    with pytest.raises(ValueError, match="^childDVGeo: the child second and the child inner both have variables second_up"):
        first.addChild(inner)
    assert parent.getVarNames() == ["up", "first_up", "second_up"]
    with pytest.raises(ValueError, match="^childDVGeo: expected a DVGeometry that was made with child=True, and is in no"):
        inner.addChild(inner)


def test_points_in_another_frame():
    def transfer(coords, mode="fwd", applyDisplacement=True):
        turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        if mode == "fwd":
            return coords @ turn - np.array([0, 0, 5]) * applyDisplacement
        return (coords + np.array([0, 0, 5]) * applyDisplacement) @ turn.T

    geo = with_variables(wing())
    there = transfer(POINTS)
    geo.addPointSet(there, "there", coordXfer=transfer)
    np.testing.assert_allclose(geo.update("there"), there, atol=1e-14)
    values = some_values(geo)
    geo.setDesignVars(values)
    np.testing.assert_allclose(geo.update("there"), transfer(geo.update("points")), atol=1e-13)
    gradient = np.random.default_rng(2).normal(size=(1, 20, 3))
    here = geo.totalSensitivity(gradient @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]), "points")
    for name, each in geo.totalSensitivity(gradient, "there").items():
        np.testing.assert_allclose(each, here[name], atol=1e-12)
    seed = {"up": np.array([1.0, 2, 3])}
    np.testing.assert_allclose(geo.totalSensitivityProd(seed, "there").reshape(-1, 3), transfer(
        geo.totalSensitivityProd(seed, "points").reshape(-1, 3), applyDisplacement=False), atol=1e-14)
    expect_derivatives(geo, values, "there")


def test_configurations():
    geo = with_variables(wing())
    geo.addLocalDV("flaps", axis="y", config="landing")
    by_config = [geo.computeTotalJacobian("points", config=config) for config in ("landing", "cruise")]
    assert geo.JT["points"] is by_config[1] and abs(by_config[0] - by_config[1]).max() > 0.1
    values = some_values(geo)
    expect_derivatives(geo, values, config="landing")
    expect_derivatives(geo, values, config="cruise")
    geo.setDesignVars({"flaps": np.full(32, 2.0)})
    gap = geo.update("points", config="landing") - geo.update("points", config="cruise")
    np.testing.assert_allclose(gap, np.broadcast_to((0, 2, 0), gap.shape), atol=1e-13)


def test_up_to_date():
    geo = with_variables(wing())
    assert not geo.pointSetUpToDate("points")
    geo.update("points")
    assert geo.pointSetUpToDate("points")
    geo.setDesignVars({"span": 1.1})
    assert not geo.pointSetUpToDate("points")


def test_variables_that_are_refused_change_nothing():
    geo = with_variables(wing())
    before, jacobian = geo.getValues(), geo.computeTotalJacobian("points")
    geo.update("points")
    for wrong, message in (([1, 2], "^up: expected 3 values, got 2$"), ([0, 0, np.inf], "^up: expected finite numbers$")):
        with pytest.raises(ValueError, match=message):
            geo.setDesignVars({"turn": [40.0, 0, 0], "up": wrong})
        for name, value in geo.getValues().items():
            np.testing.assert_array_equal(value, before[name])
    assert geo.pointSetUpToDate("points") and geo.computeTotalJacobian("points") is jacobian


def test_variables_change_the_whole_tree():
    """Grandchildren kept their derivatives, and said that their points were up to date."""
    parent = DVGeometry(wing())
    lattices = [parent]
    for name in ("child", "grandchild"):
        geo = DVGeometry(SMALL, child=True, name=name)
        geo.addRefAxis("axis", curve=[(0, 0, 1), (0, 0, 6)], axis=np.array([0, 0, 1.0]))
        geo.addGlobalDV("bend", 0.0, lambda values, geo: geo.rot_z["axis"].coef.__setitem__(1, values[0]))
        lattices[-1].addChild(geo)
        lattices.append(geo)
    parent.addPointSet(POINTS, "points")
    for setter in lattices:
        jacobians = [geo.computeTotalJacobian("points") for geo in lattices]
        revisions = [geo.revision for geo in lattices]
        for geo in lattices:
            geo.update("points")
        setter.setDesignVars({"grandchild_bend": 30.0})
        assert not any(geo.pointSetUpToDate("points") for geo in lattices)
        assert all(geo.revision > before for geo, before in zip(lattices, revisions))
        for geo, before in zip(lattices, jacobians):
            assert np.abs(geo.computeTotalJacobian("points") - before).max() > 1e-3
        parent.setDesignVars({"grandchild_bend": 0.0})


def test_functions_and_optimisers_get_copies_of_the_values():
    """A function that scaled its values in place scaled the variables with each update."""
    def radians(values, geo):
        values *= 2
        geo.rot_z["axis"].coef[:] = values[0]

    geo = with_function(radians, 10.0)
    first = geo.update("points")
    np.testing.assert_array_equal(geo.update("points"), first)
    expect_derivatives(geo, geo.getValues())
    assert geo.getValues()["f"] == 10

    class Problem:
        def addVarGroup(self, name, count, kind, value, lower, upper, scale):
            value *= 0
            if lower is not None:
                lower *= 0

    geo.addVariablesPyOpt(Problem(), freezeVars=["f"])
    assert geo.getValues()["f"] == 10
    # The array of a caller who goes on with it.
    mine = np.array([3.0])
    geo.setDesignVars({"f": mine})
    mine[:] = 4
    assert geo.getValues()["f"] == 3


def test_a_matrix_in_place_of_binding():
    geo = DVGeometry(wing())
    geo.addLocalDV("up", axis="y")
    matrix = espalier.bind(wing(), POINTS, basis="bezier").matrix
    geo.addPointSet(POINTS, "bezier", deformation=matrix)
    geo.addPointSet(POINTS, "same", basis="bezier")
    values = np.random.default_rng(3).normal(size=32)
    geo.setDesignVars({"up": values})
    np.testing.assert_array_equal(geo.update("bezier"), geo.update("same"))
    np.testing.assert_allclose(geo.update("bezier")[:, 1], POINTS[:, 1] + matrix @ values, atol=1e-14)


def test_variables_for_pyoptsparse():
    class Problem:
        groups = {}

        def addVarGroup(self, name, count, kind, value, lower, upper, scale):
            self.groups[name] = (count, kind, lower, upper)

    geo, problem = with_variables(wing()), Problem()
    geo.addVariablesPyOpt(problem, ignoreVars=["span"], freezeVars=["chord"])
    assert list(problem.groups) == ["twist", "chord", "turn", "up", "bump"]
    assert problem.groups["up"] == (3, "c", None, None)
    np.testing.assert_array_equal(problem.groups["twist"][2], [-10] * 3)
    np.testing.assert_array_equal(problem.groups["chord"][3], np.ones(4))


def test_the_lattice_is_written(tmp_path):
    geo = with_variables(wing())
    geo.setDesignVars(some_values(geo))
    path = geo.writeTecplot(str(tmp_path / "lattice.dat"))
    assert path == tmp_path / "lattice.vtu"
    np.testing.assert_array_equal(espalier.read(path).positions, geo.positions())


def with_function(function, value, child=False):
    """A wing whose axis a function moves, by itself or as a child of a lattice that moves it."""
    geo = DVGeometry(wing(), child=child, name="inner" if child else None)
    geo.addRefAxis("axis", curve=np.linspace((0, 0, 0), (0, 0, 8), 4), axis=np.array([0, 0, 1.0]))
    geo.addGlobalDV("fine", np.ones(4), chord)
    geo.addGlobalDV("f", value, function)
    if child:
        inner, geo = geo, DVGeometry(wing())
        geo.addChild(inner)
        geo.addLocalDV("up", axis="xyz", vertices=[3, 5])
    geo.addPointSet(POINTS, "points")
    return geo


def partly_real(values, geo):
    geo.scale["axis"].coef[:] = 1 + values[0] / 10
    geo.rot_z["axis"].coef[-1] = abs(values[0])


def by_length(values, geo):
    nodes = geo.extractCoef("axis")
    nodes[1:, 2] *= values[0]
    geo.restoreCoef(nodes, "axis")
    geo.scale_y["axis"].coef[:] = 8 / np.linalg.norm(nodes[-1] - nodes[0])


def far_away(values, geo):
    nodes = geo.extractCoef("axis") + (1e5, 0, 0)
    geo.restoreCoef(nodes + (1e-3 * values[0].real, 0, 0), "axis")


@pytest.mark.parametrize("function, value, changed", [
    (far_away, 0.0, "x"), (partly_real, 5.0, "rot_z"), (partly_real, 0.0, "rot_z"), (partly_real, -5.0, "rot_z"),
    (by_length, 1.1, "scale_y")])
def test_a_function_that_drops_a_part_of_its_imaginary_values_is_refused(function, value, changed):
    """The derivatives were wrong by 0.0165 of partly_real at 5, and by 0.72 of by_length."""
    geo = with_function(function, value)
    with pytest.raises(ValueError, match="^f: its function drops the imaginary part of its values: the derivative of "
                                         rf"{changed} by f\[0\] differs from the difference quotient"):
        geo.computeTotalJacobian("points")


def test_a_function_that_drops_imaginary_parts_of_carried_nodes_is_refused():
    def stretched(values, geo):
        nodes = geo.extractCoef("axis")
        geo.scale_x["axis"].coef[:] = values[0] * 8 / np.linalg.norm(nodes[-1] - nodes[0])

    geo = with_function(stretched, 1.2, child=True)
    with pytest.raises(ValueError, match="^inner_f: its function drops the imaginary part of its values: the derivative of "
                                         "scale_x by the nodes that a parent carries differs from "):
        geo.computeTotalJacobian("points")

    def right(values, geo):
        nodes = geo.extractCoef("axis")
        geo.scale_x["axis"].coef[:] = values[0] * 8 / np.sqrt(((nodes[-1] - nodes[0]) ** 2).sum())

    geo = with_function(right, 1.2, child=True)
    expect_derivatives(geo, some_values(geo))


@pytest.mark.parametrize("function, value", [
    (lambda v: 1 + v ** 2, 0.0), (lambda v: np.cos(v), 0.0), (lambda v: np.exp(1000 * v), 0.0),
    (lambda v: np.sqrt(1 - v ** 2), 0.5), (lambda v: 1 + 1e-9 * v, 3.0), (lambda v: np.maximum(v.real, 0.5) + 0 * v, -2.0)],
    ids=["zero", "cosine", "steep", "root", "flat", "constant"])
def test_functions_with_right_derivatives_are_accepted(function, value):
    """Some derivatives are exactly 0, too steep for one step of a difference, or smaller than a difference shows."""
    def scale(values, geo):
        geo.scale["axis"].coef[:] = function(values[0])
    with_function(scale, value).computeTotalJacobian("points")


def test_functions_need_not_be_defined_beyond_their_values():
    """The place of the comparison is beside the values; where a function refuses it, the comparison is at the values."""
    def up_to(limit):
        def scale(values, geo):
            if values[0].real > limit:
                raise RuntimeError("too far")
            geo.scale["axis"].coef[:] = np.sqrt(1.01 - values[0])
        return scale

    for value, limit in ((1.005, 9), (0.0, 0.005)):
        geo = with_function(up_to(limit), value)
        geo.computeTotalJacobian("points")
    # Bounds are kept.
    seen = []

    def bounded(values, geo):
        seen.append(values[0].real)
        geo.scale["axis"].coef[:] = 1 + values[0]

    geo = with_function(up_to(9), 0.0)
    for name, value, bounds in (("high", 1.0, (0, 1)), ("low", 0.0, (0, 1)), ("fixed", 0.5, (0.5, 0.5))):
        geo.addGlobalDV(name, value, bounded, lower=bounds[0], upper=bounds[1])
        geo.computeTotalJacobian("points")
        # A step of the differences, 1e-4, goes beyond.
        assert bounds[0] - 1e-4 <= min(seen) and max(seen) <= bounds[1] + 1e-4
        del geo.DV_listGlobal[name], seen[:]


def test_functions_are_compared_with_differences_once():
    calls = []

    def count(values, geo):
        calls.append(geo.coef.dtype)
        geo.scale["axis"].coef[:] = 1 + values[0]

    geo = with_function(count, 0.0)
    geo.computeTotalJacobian("points")
    first = len(calls)
    geo.setDesignVars({"f": 0.1})
    del calls[:]
    geo.computeTotalJacobian("points")
    # The complex step by each of 5 variables, and the values as they are set, twice.
    assert len(calls) == 7 < first
    geo.addGlobalDV("g", 0.0, partly_real)
    with pytest.raises(ValueError, match="^g: its function drops"):
        geo.computeTotalJacobian("points")


def small_child(name="flap"):
    child = DVGeometry(SMALL, child=True, name=name)
    child.addLocalDV("up", axis="y")
    return child


def test_children_move_points_that_were_added_before():
    """They moved nothing."""
    first, later = DVGeometry(wing()), DVGeometry(wing())
    first.addChild(small_child())
    for geo in (first, later):
        geo.addPointSet(POINTS, "points")
        geo.addPointSet(POINTS, "without", activeChildren=[])
    later.addChild(small_child())
    # A grandchild, too.
    for geo in (first, later):
        geo.children["flap"].addChild(small_child("tab"))
        geo.setDesignVars({name: np.ones(18) for name in ("flap_up", "tab_up")})
    np.testing.assert_array_equal(first.update("points"), later.update("points"))
    assert np.abs(later.update("points") - POINTS)[:, 1].max() > 1.9
    np.testing.assert_array_equal(later.update("without"), POINTS)
    expect_derivatives(later, later.getValues())


def test_sets_of_points_have_one_name_each():
    """A set that was added again kept its children and its frame."""
    geo, child = DVGeometry(wing()), small_child()
    geo.addPointSet(POINTS, "points")
    with pytest.raises(ValueError, match="^ptName: the outermost lattice has points points already$"):
        geo.addPointSet(POINTS, "points", activeChildren=[])
    with pytest.raises(ValueError, match="^activeChildren: there is no child flap; add the children before the points$"):
        geo.addPointSet(POINTS, "more", activeChildren=["flap"])
    child.addPointSet(POINTS, "own")
    geo.addChild(child)
    with pytest.raises(ValueError, match="^ptName: the child flap has points own already$"):
        geo.addPointSet(POINTS, "own")
    other = small_child("other")
    other.addPointSet(POINTS, "points")
    with pytest.raises(ValueError, match="^ptName: the child other has points points already$"):
        geo.addChild(other)
    assert geo.ptSetNames == ["points"] and list(geo.children) == ["flap"]


def test_options_of_points_are_used():
    geo = DVGeometry(wing())
    matrix = espalier.bind(wing(), POINTS).matrix
    for options, message in (({"levle": 2}, "^levle: there is no such option; there are level, limit, basis, outside, "
                              "tolerance, weights, falloff$"),
                             ({"level": 2, "deformation": matrix}, "^level: the points are not bound if there is a `def")):
        with pytest.raises(TypeError, match=message):
            geo.addPointSet(POINTS, "points", **options)
    geo.addPointSet(POINTS, "points", weights=np.zeros(20))
    geo.addLocalDV("up")
    geo.setDesignVars({"up": np.ones(32)})
    np.testing.assert_array_equal(geo.update("points"), POINTS)


def test_a_vertex_has_one_axis():
    """The last axis moved it, and other axes did nothing; an axis of the same name replaced the first."""
    geo = DVGeometry(wing())
    geo.addRefAxis("a", curve=NODES, vertices=[1, 2, 3])
    with pytest.raises(ValueError, match="^vertices: the axes a and b would both carry vertex 1; give the vertices "):
        geo.addRefAxis("b", curve=NODES)
    with pytest.raises(ValueError, match="^name: there is an axis a already$"):
        geo.addRefAxis("a", curve=NODES, vertices=[4])
    assert geo.addRefAxis("b", curve=NODES, ignoreInd=[1, 2, 3]) == 4 and list(geo.axis) == ["a", "b"]


def test_axes_count_that_are_added_after_their_function():
    geo = DVGeometry(wing())
    geo.addRefAxis("a", curve=NODES, vertices=[1, 2, 3])
    geo.addPointSet(POINTS, "points")

    def lift(values, geo):
        for name in geo.axis:
            geo.restoreCoef(geo.extractCoef(name) + (0, values[0], 0), name)

    geo.addGlobalDV("lift", 1.0, lift)
    geo.update("points")
    before = geo.computeTotalJacobian("points")
    geo.addRefAxis("b", curve=NODES, ignoreInd=[1, 2, 3])
    assert not geo.pointSetUpToDate("points")
    assert np.abs(geo.computeTotalJacobian("points") - before).max() > 0.1
    expect_derivatives(geo, geo.getValues())


@pytest.mark.parametrize("wrong, message", [
    (np.arange(32) > 20, r": expected an array of integers, got bool$"),
    ([2.7], ": expected an array of integers, got float64$"), ([1, -1], r"\[1\]: expected a vertex, 0 to 31, got -1$"),
    ([32], r"\[0\]: expected a vertex, 0 to 31, got 32$")], ids=["mask", "float", "negative", "beyond"])
def test_vertices_are_chosen_by_numbers(wrong, message):
    """A mask was read as the vertices 0 and 1, -1 as the last vertex, and 2.7 as vertex 2."""
    geo = DVGeometry(wing())
    for name, call in [("frozen", lambda: DVGeometry(wing(), frozen=wrong)),
                       ("vertices", lambda: geo.addLocalDV("up", vertices=wrong)),
                       ("vertices", lambda: geo.addRefAxis("axis", curve=NODES, vertices=wrong)),
                       ("ignoreInd", lambda: geo.addRefAxis("axis", curve=NODES, ignoreInd=wrong))]:
        with pytest.raises(ValueError, match="^" + name + message):
            call()
    assert geo.addLocalDV("none", vertices=[]) == 0 and geo.addLocalDV("two", vertices=np.array([3, 5, 5], "u8")) == 2


def test_sides_and_options_have_exact_names():
    for wrong in (["ilow"], ["iMin"], "iLow", ["kLower"], [0]):
        with pytest.raises(ValueError, match="^faceFreeze: expected a list of iLow, iHigh, jLow, jHigh, kLow, kHigh; got "):
            DVGeometry(wing(), faceFreeze={"0": wrong})
    with pytest.raises(ValueError, match="^faceFreeze: the blocks are one lattice, \"0\"; got '1'$"):
        DVGeometry(wing(), faceFreeze={"1": ["iLow"]})
    for wrong in ("levle", "symmPlane", "volBounds"):
        with pytest.raises(TypeError, match=f"^{wrong}: there is no such option; there are level, limit, basis, outside, "):
            DVGeometry(wing(), **{wrong: 3})
    low = DVGeometry(wing(), faceFreeze={0: ["jHigh"]})
    assert low.addLocalDV("none") == 0  # two layers of two


def test_sets_without_points_have_gradients():
    geo = with_variables(wing())
    geo.addPointSet(np.zeros((0, 3)), "none")
    assert geo.update("none").shape == (0, 3) and geo.computeTotalJacobian("none").shape == (16, 0)
    for gradients, count in ((np.zeros((0, 3)), 1), (np.zeros((2, 0, 3)), 2)):
        back = geo.totalSensitivity(gradients, "none")
        assert back["twist"].shape == (count, 3) and not back["twist"].any()


def test_wrong_arguments():
    geo = with_variables(wing())
    for call, message in [
            (lambda: geo.setDesignVars({"twist": [1, 2]}), "^twist: expected 3 values, got 2$"),
            (lambda: geo.setDesignVars({"up": [0, np.nan, 0]}), "^up: expected finite numbers$"),
            (lambda: geo.addLocalDV("up"), "^dvName: there are variables up already$"),
            (lambda: geo.addGlobalDV("more", np.zeros(3), twist, lower=[1, 2]),
             "^more: expected one bound or 3, got 2$"),
            (lambda: geo.addLocalDV("blocks", volList=[0]), "^volList: the blocks are one lattice; give `vertices`$"),
            (lambda: geo.addShapeFunctionDV("far", {32: (0, 0, 1)}), r"^shapes\[0\]: there is no vertex 32$"),
            (lambda: geo.addRefAxis("b", curve=[(0, 0, 0), (0, 0, 1)], rotType=8), "^rotType: expected 0 to 7, got 8$"),
            (lambda: geo.addRefAxis("b"), "^curve: expected nodes, or xFraction"),
            (lambda: geo.addPointSet(POINTS, "p", origConfig=False), "^origConfig: expected True"),
            (lambda: geo.getLocalIndex(1), "^iVol: the blocks are one lattice"),
            (lambda: geo.totalSensitivityProd({"none": [1]}, "points"), "^vec: there are no variables none; there are "),
            (lambda: DVGeometry(wing(), isComplex=True), "^isComplex: the derivatives"),
            (lambda: geo.addRefAxis("b", curve=NODES, xFraction=0.5, alignIndex="k"), "^curve: expected nodes or xFraction"),
            (lambda: geo.addLocalDV("s", vertices=[1], design=espalier.DesignVariables(32)),
             "^vertices: expected one of vertices, pointSelect and design$"),
            (lambda: geo.addLocalDV("s", design=espalier.DesignVariables(31)),
             "^design: expected variables of 32 vertices, got 31$"),
            (lambda: geo.addRefAxis("b", curve=NODES, rotAxisVar="t"), "^rotAxisVar: it is for rotType 8"),
            (lambda: geo.addRefAxis("b", xFraction=0.5, alignIndex="kj"), "^alignIndex: expected i, j or k, got 'kj'$"),
            (lambda: geo.addRefAxis("b", curve=NODES, axis="xy"), "^axis: expected x, y or z, got 'xy'$"),
            (lambda: geo.addRefAxis("b", curve=NODES, axis="up"), "^axis: expected x, y or z, got 'up'$"),
            (lambda: geo.addSpanwiseLocalDV("s", "jk"), "^spanIndex: expected i, j or k, got 'jk'$"),
            (lambda: geo.addSpanwiseLocalDV("s", ""), "^spanIndex: expected i, j or k, got ''$"),
            (lambda: geo.addSpanwiseLocalDV("s", "k", axis="xz"), "^axis: expected x, y or z, got 'xz'$"),
            (lambda: geo.addLocalDV("s", axis=""), "^axis: expected x, y, z or several of them, such as xy; got ''$"),
            (lambda: geo.addLocalDV("s", axis="yy"), "^axis: expected x, y, z or several .* got 'yy'$"),
            (lambda: geo.addLocalDV("s", axis="u"), "^axis: expected x, y, z or several .* got 'u'$"),
            (lambda: geo.addShapeFunctionDV("s", {2.7: (0, 0, 1)}),
             r"^shapes\[0\]: expected integers as vertices, got 2.7$"),
            (lambda: geo.addShapeFunctionDV("s", {True: (0, 0, 1)}),
             r"^shapes\[0\]: expected integers as vertices, got True"),
            (lambda: geo.addShapeFunctionDV("s", {1: (0, 1)}),
             r"^shapes\[0\]: expected 3 finite numbers for vertex 1, got "),
            (lambda: geo.addShapeFunctionDV("s", {1: (0, 1, np.nan)}),
             r"^shapes\[0\]: expected 3 finite numbers for ver"),
            (lambda: geo.totalSensitivity(POINTS.T, "points"),
             r"^dIdpt: expected an array of shape \(20, 3\) or \(M, 20, 3\), got \(3, 20\)$"),
            (lambda: geo.totalSensitivity(POINTS.ravel(), "points"), "^dIdpt: expected an array of shape"),
            (lambda: geo.totalSensitivity(POINTS.reshape(2, 10, 3), "points"), "^dIdpt: expected an array of shape"),
            (lambda: geo.totalSensitivityTransProd(POINTS.T, "points"),
             r"^vec: expected an array of shape \(20, 3\), got \(3, 20\)$"),
            (lambda: geo.totalSensitivityProd({"twist": np.ones(4), "turn": np.ones(2)}, "points"),
             "^vec: expected 3 values of twist, got 4$"),
            (lambda: geo.convertSensitivityToDict(np.ones((1, 3))), r"^dIdx: expected an array with 16 columns, got shape"),
            (lambda: geo.convertDictToSensitivity({**geo.getValues(), "up": np.ones(2)}),
             "^dIdxDict: expected 3 values of up, got 2$")]:
        with pytest.raises(ValueError, match=message):
            call()
    def real(values, geo):
        nodes = np.zeros((4, 3))
        nodes[:, 2] = np.linspace(0, 8, 4) * float(abs(values[0]))
        geo.restoreCoef(nodes, "axis")
    geo.addGlobalDV("real", 1.0, real)
    with pytest.raises(ValueError, match="^real: its function drops the imaginary part of its values"):
        geo.totalSensitivity(POINTS, "points")
    del geo.DV_listGlobal["real"]
    def cast(values, geo):
        stretched = np.zeros(4)
        stretched[:] = values[0]
        geo.scale_x["axis"].coef[:] = stretched
    geo.addGlobalDV("cast", 1.0, cast)
    with pytest.raises(ValueError, match="^cast: its function drops the imaginary part of its values"):
        geo.totalSensitivity(POINTS, "points")
