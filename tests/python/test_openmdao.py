# SPDX-License-Identifier: Apache-2.0
"""espalier.openmdao with OpenMDAO itself: derivatives, and a driver on the panel method of examples/."""

import pathlib
import subprocess
import sys

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
    assert problem.driver.result.success if hasattr(problem.driver, "result") else True
    assert problem.get_val("lift")[0] > before + 0.2
    assert problem.get_val("area")[0] == pytest.approx(start_area, rel=1e-5)
    assert (problem.get_val("thickness") > 0.9 * start_thickness - 1e-6).all()
    assert np.abs(problem.get_val("shape")).max() <= 0.03 + 1e-9


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
