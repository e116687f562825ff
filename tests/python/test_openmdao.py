# SPDX-License-Identifier: Apache-2.0
"""espalier.openmdao with OpenMDAO itself: derivatives, and a driver on the panel method of examples/."""

import importlib
import pathlib
import subprocess
import sys
import types

import numpy as np
import pytest

import espalier
import espalier.openmdao
from espalier.dvgeometry import DVGeometry

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "examples"))
from panel_method import Flow, area, naca  # noqa: E402

try:
    import openmdao.api as om
except ImportError:
    om = None
needs_openmdao = pytest.mark.skipif(om is None, reason="OpenMDAO is not installed")

PANELS, INCIDENCE = 60, np.radians(2)
SECTION = naca(0, 0.12, PANELS)
POINTS = np.column_stack([SECTION.real, SECTION.imag, np.full(PANELS, 0.05)])


def section_geometry():
    """An aerofoil section in a lattice that is one cell thick; both ends of the lattice stay."""
    lattice = espalier.shapes.box(cells=(6, 1, 1), min=(-0.1, -0.12, 0), max=(1.1, 0.12, 0.1))
    geo = DVGeometry(lattice, level=3)
    geo.addPointSet(POINTS, "section")
    geo.addRefAxis("axis", curve=[(0.25, 0, 0), (0.25, 0, 0.1)], axis=np.array([0, 0, 1.0]))

    def turn(values, geo):
        geo.rot_z["axis"].coef[:] = values[0]

    geo.addGlobalDV("turn", 0.0, turn)
    geo.addSpanwiseLocalDV("shape", "k", axis="y")
    return geo


LINES = espalier.constraints.crossings(
    np.vstack([POINTS - (0, 0, 0.05), POINTS + (0, 0, 0.05)]),
    [[a, b, a + PANELS] for a, b in zip(range(PANELS), [*range(1, PANELS), 0])]
    + [[b, b + PANELS, a + PANELS] for a, b in zip(range(PANELS), [*range(1, PANELS), 0])],
    [[x, 0.001, 0.05] for x in (0.2, 0.5, 0.8)], [[0, 1, 0]] * 3)


def thicknesses(points):
    """The thickness of the section at three places, as of a wing of one panel across."""
    both = np.vstack([points - (0, 0, 0.05), points + (0, 0, 0.05)])
    values, derivatives = espalier.constraints.thicknesses(both, LINES)
    derivatives = derivatives.csr()
    return values, derivatives[:, :3 * PANELS] + derivatives[:, 3 * PANELS:]


def test_the_module_can_be_imported_without_openmdao():
    code = ("import sys; sys.modules['openmdao'] = None\n"
            "import espalier.openmdao\n"
            "try:\n    espalier.openmdao.GeometryComponent()\n"
            "except ImportError as error:\n    print(error)\n")
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.startswith("espalier.openmdao needs OpenMDAO (pip install openmdao): ")


class Component:
    """Stands in for OpenMDAO's ExplicitComponent: options, inputs and outputs."""

    under_complex_step = False

    class Options(dict):
        def declare(self, name, default=None, **_):
            self.setdefault(name, default)

    def __init__(self, **options):
        self.options, self.inputs, self.outputs = self.Options(), {}, {}
        self.initialize()
        self.options.update(options)

    def add_input(self, name, val, **_):
        self.inputs[name] = val

    def add_output(self, name, val, **_):
        self.outputs[name] = val


@pytest.fixture
def component(monkeypatch):
    """GeometryComponent on the stand-in, whether OpenMDAO is installed or not."""
    api = types.ModuleType("openmdao.api")
    api.ExplicitComponent = Component
    for name, module in (("openmdao", types.ModuleType("openmdao")), ("openmdao.api", api)):
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(espalier, "openmdao", espalier.openmdao)
    monkeypatch.delitem(sys.modules, "espalier.openmdao")
    return importlib.import_module("espalier.openmdao").GeometryComponent


def expect_products(component, values, names):
    """Compares the products of both directions with differences of fourth order of compute()."""
    def outputs_at(values):
        outputs = {}
        component.compute(values, outputs)
        return np.concatenate([np.ravel(outputs[name]) for name in names])

    random = np.random.default_rng(2)
    seed = {name: random.normal(size=each.shape) for name, each in values.items()}
    ends = [outputs_at({name: each + step * 1e-3 * seed[name] for name, each in values.items()})
            for step in (-2, -1, 1, 2)]
    expected = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * 1e-3)
    forward = {name: np.zeros(np.shape(component.outputs[name])) for name in names}
    component.compute_jacvec_product(values, seed, forward, "fwd")
    # Errors of differences of fourth order: 1e-12 from the step, and 1e-13 from rounding.
    np.testing.assert_allclose(np.concatenate([np.ravel(each) for each in forward.values()]), expected, atol=1e-10)
    gradient = {name: random.normal(size=np.shape(component.outputs[name])) for name in names}
    back = {name: np.zeros(each.shape) for name, each in values.items()}
    component.compute_jacvec_product(values, back, gradient, "rev")
    wanted = np.concatenate([np.ravel(each) for each in gradient.values()]) @ expected
    assert sum((back[name] * seed[name]).sum() for name in values) == pytest.approx(wanted, abs=1e-9)


def two_components(geo, make):
    """The thicknesses of a section, in two configurations of one geometry."""
    geo.addLocalDV("flap", axis="y", config="landing")
    return [make(geometry=geo, measures={config: ("section", thicknesses)}, config=config)
            for config in ("cruise", "landing")]


def test_the_component_without_openmdao(component):
    geo = section_geometry()
    made = component(geometry=geo, measures={"thickness": ("section", thicknesses)})
    made.setup()
    assert list(made.inputs) == ["turn", "shape"] and list(made.outputs) == ["section", "thickness"]
    random = np.random.default_rng(1)
    values = {"turn": np.array([3.0]), "shape": 0.01 * random.normal(size=14)}
    outputs = {}
    made.compute(values, outputs)
    np.testing.assert_array_equal(outputs["section"], geo.update("section"))
    expect_products(made, values, ["section", "thickness"])
    # A complex step of a model around the component.
    made.under_complex_step = True
    seed = {name: random.normal(size=each.shape) for name, each in values.items()}
    made.compute({name: each + 1e-40j * seed[name] for name, each in values.items()}, outputs)
    forward = {name: np.zeros(np.shape(made.outputs[name])) for name in outputs}
    made.compute_jacvec_product(values, seed, forward, "fwd")
    for name, each in forward.items():
        np.testing.assert_allclose(np.imag(outputs[name]) / 1e-40, each, atol=1e-13)


def test_two_components_share_a_geometry(component):
    """The second component took the derivatives of its measures from the values before."""
    geo = section_geometry()
    both = two_components(geo, component)
    for each in both:
        each.setup()
    random = np.random.default_rng(3)
    for _ in range(2):
        values = {name: each + 0.01 * random.normal(size=each.shape) for name, each in geo.getValues().items()}
        for each in both:
            gradient, back = {each.options["config"]: np.ones(3)}, {name: np.zeros(v.shape) for name, v in values.items()}
            each.compute_jacvec_product(values, back, gradient, "rev")
            fresh = component(**each.options)
            fresh.setup()
            expected = {name: np.zeros(v.shape) for name, v in values.items()}
            fresh.compute_jacvec_product(values, expected, gradient, "rev")
            for name in values:
                np.testing.assert_array_equal(back[name], expected[name])
    # The geometry was set by others.
    geo.setDesignVars({"turn": 20.0})
    expect_products(both[1], geo.getValues(), ["landing"])


def test_setup_forgets_the_measures(component):
    """A measure that is replaced before a second setup counts."""
    geo = section_geometry()
    made = component(geometry=geo, measures={"size": ("section", thicknesses)})
    backs = []
    for factor in (1, 2):
        made.options["measures"] = {"size": ("section", lambda points, factor=factor: tuple(
            factor * each for each in thicknesses(points)))}
        made.setup()
        backs.append({"turn": np.zeros(1), "shape": np.zeros(14)})
        made.compute_jacvec_product(geo.getValues(), backs[-1], {"size": np.ones(3)}, "rev")
    assert backs[0]["shape"].any()
    np.testing.assert_array_equal(backs[1]["shape"], 2 * backs[0]["shape"])


if om is not None:
    class Panels(om.ExplicitComponent):
        """The lift and the area of a section, with their gradients by its points."""

        def setup(self):
            self.add_input("section", val=POINTS)
            self.add_output("lift", val=0.0)
            self.add_output("area", val=0.0)
            self.declare_partials("*", "*")

        def compute(self, inputs, outputs):
            plane = inputs["section"][:, 0] + 1j * inputs["section"][:, 1]
            outputs["lift"], outputs["area"] = Flow(plane, INCIDENCE).lift, area(plane)[0]

        def compute_partials(self, inputs, partials):
            plane = inputs["section"][:, 0] + 1j * inputs["section"][:, 1]
            flow = Flow(plane, INCIDENCE)
            # lift = -2 strength · length: by the strengths, and by the lengths of the panels.
            gradient = flow.gradient(-2 * flow.length)
            by_length = -2 * flow.strength * flow.tangent
            gradient = gradient - by_length + np.roll(by_length, 1)
            for name, each in (("lift", gradient), ("area", area(plane)[1])):
                partials[name, "section"] = np.column_stack([each.real, each.imag, 0 * each.real]).reshape(1, -1)


def problem_of(geo):
    problem = om.Problem(reports=False)
    problem.model.add_subsystem("geometry", espalier.openmdao.GeometryComponent(
        geometry=geo, measures={"thickness": ("section", thicknesses)}), promotes=["*"])
    problem.model.add_subsystem("panels", Panels(), promotes=["*"])
    return problem


@needs_openmdao
def test_partial_derivatives():
    geo = section_geometry()
    problem = problem_of(geo)
    problem.setup(force_alloc_complex=True)
    random = np.random.default_rng(1)
    problem.set_val("turn", 3.0)
    problem.set_val("shape", 0.01 * random.normal(size=14))
    problem.run_model()
    np.testing.assert_array_equal(problem.get_val("section"), geo.update("section"))
    for method, bound in (("fd", 2e-8), ("cs", 1e-12)):
        checked = problem.check_partials(out_stream=None, includes=["geometry"], method=method, step=1e-5
                                         if method == "fd" else 1e-40, form="central" if method == "fd" else None)
        for (output, of), each in checked["geometry"].items():
            assert np.abs(each["J_fd"]).max() > 1e-7, (output, of)
            np.testing.assert_allclose(each["J_fwd"], each["J_fd"], atol=bound)
            np.testing.assert_allclose(each["J_rev"], each["J_fd"], atol=bound)
    totals = problem.check_totals(of=["lift", "area", "thickness"], wrt=["turn", "shape"], out_stream=None, method="fd",
                                  form="central", step=1e-5)
    for each in totals.values():
        np.testing.assert_allclose(each["J_rev" if "J_rev" in each else "J_fwd"], each["J_fd"], atol=1e-6)


@needs_openmdao
def test_a_driver_finds_a_section_with_more_lift():
    """The largest lift at the same area and thicknesses of at least 90 %, with bounded variables."""
    problem = problem_of(section_geometry())
    problem.model.add_design_var("shape", lower=-0.03, upper=0.03)
    problem.model.add_objective("lift", scaler=-1)
    problem.driver = om.ScipyOptimizeDriver(optimizer="SLSQP", maxiter=30, tol=1e-6, disp=False)
    start_area, start_thickness = area(SECTION)[0], thicknesses(POINTS)[0]
    problem.model.add_constraint("area", equals=start_area, ref=start_area)
    problem.model.add_constraint("thickness", lower=0.9 * start_thickness)
    problem.setup()
    problem.run_model()
    before = problem.get_val("lift")[0]
    problem.run_driver()
    assert not problem.driver.fail
    assert problem.get_val("lift")[0] > before + 0.2
    assert problem.get_val("area")[0] == pytest.approx(start_area, rel=1e-5)
    assert (problem.get_val("thickness") > 0.9 * start_thickness - 1e-6).all()
    assert np.abs(problem.get_val("shape")).max() <= 0.03 + 1e-9


@needs_openmdao
def test_total_derivatives_of_two_components_of_one_geometry():
    geo = section_geometry()
    problem = om.Problem(reports=False)
    source = problem.model.add_subsystem("source", om.IndepVarComp(), promotes=["*"])
    both = two_components(geo, espalier.openmdao.GeometryComponent)
    for name, value in geo.getValues().items():
        source.add_output(name, value)
    for each in both:
        each.options["points"] = []
        problem.model.add_subsystem("of_" + each.options["config"], each, promotes=["*"])
    problem.setup()
    problem.run_model()
    problem.compute_totals(of=["cruise", "landing"], wrt=["turn", "shape", "flap"])
    problem.set_val("turn", 20.0)
    problem.set_val("shape", 0.01 * np.random.default_rng(4).normal(size=14))
    problem.run_model()
    checked = problem.check_totals(of=["cruise", "landing"], wrt=["turn", "shape", "flap"], out_stream=None,
                                   form="central", step=1e-5)
    for each in checked.values():
        np.testing.assert_allclose(each["J_rev" if "J_rev" in each else "J_fwd"], each["J_fd"], atol=1e-8)


@needs_openmdao
def test_points_and_configurations_are_chosen():
    geo = section_geometry()
    geo.addPointSet(POINTS + (0, 0.01, 0), "other")
    geo.addLocalDV("flap", axis="y", config="landing")
    problem = om.Problem(reports=False)
    problem.model.add_subsystem("geometry", espalier.openmdao.GeometryComponent(
        geometry=geo, points=["other"], config="cruise"), promotes=["*"])
    problem.setup()
    problem.set_val("flap", np.full(28, 0.1))
    problem.set_val("turn", 5.0)
    problem.run_model()
    np.testing.assert_array_equal(problem.get_val("other"), geo.update("other", config="cruise"))
    with pytest.raises(KeyError):
        problem.get_val("section")
    checked = problem.check_partials(out_stream=None, form="central", step=1e-5)["geometry"]
    assert not checked["other", "flap"]["J_fwd"].any()
    np.testing.assert_allclose(checked["other", "turn"]["J_rev"], checked["other", "turn"]["J_fd"], atol=1e-9)
