# SPDX-License-Identifier: Apache-2.0
"""A component of OpenMDAO for the geometry of espalier.dvgeometry.

    import openmdao.api as om
    from espalier.openmdao import GeometryComponent

    geometry = GeometryComponent(geometry=geo, measures={"volume": ("wing", volume)})
    problem.model.add_subsystem("geometry", geometry, promotes=["*"])
    problem.model.add_design_var("twist", lower=-10, upper=10)

The module can be imported without OpenMDAO; the component cannot be made without it.
"""

import numpy as np

from .dvgeometry import DVGeometry

try:
    from openmdao.api import ExplicitComponent
except ImportError as _error:
    _missing = str(_error)

    class ExplicitComponent:
        """Stands in for OpenMDAO's class."""

        def __init__(self, **options):
            raise ImportError(f"espalier.openmdao needs OpenMDAO (pip install openmdao): {_missing}")


__all__ = ["GeometryComponent"]


class GeometryComponent(ExplicitComponent):
    """The points of a DVGeometry, and measures of them, as functions of its variables.

    Inputs are the groups of variables, by their names; outputs are the sets of points, arrays (N, 3), and the measures,
    arrays (m,). Derivatives are products with sparse matrices, in both directions.

    geometry : DVGeometry with its points, variables and children
    points   : list of the sets of points to give out; all by default
    measures : dict from names of outputs to (name of points, function of an array (N, 3)); a function returns values and
               derivatives, as those of espalier.constraints
    config   : str, the configuration of the variables
    """

    def initialize(self):
        """Declares the options."""
        self.options.declare("geometry", types=DVGeometry, recordable=False, desc="variables and points")
        self.options.declare("points", default=None, desc="names of the points to give out; all by default")
        self.options.declare("measures", default={}, types=dict, recordable=False,
                             desc="names of outputs, with names of points and functions")
        self.options.declare("config", default=None, desc="configuration of the variables")
        self._by_points = {}

    def _point_sets(self):
        """The sets of points to give out."""
        names = self.options["points"]
        return list(self.options["geometry"].points) if names is None else list(names)

    def setup(self):
        """Adds the variables as inputs, and the points and the measures as outputs."""
        geometry, config = self.options["geometry"], self.options["config"]
        self._by_points = {}
        for name, values in geometry.getValues().items():
            self.add_input(name, val=values, tags=["espalier"])
        for name in self._point_sets():
            self.add_output(name, val=geometry.update(name, config=config), tags=["espalier"])
        for name, (points, measure) in self.options["measures"].items():
            values, _ = measure(np.ascontiguousarray(geometry.update(points, config=config)))
            self.add_output(name, val=np.atleast_1d(values), tags=["espalier"])

    def _set(self, inputs):
        geometry = self.options["geometry"]
        values = {name: np.real(inputs[name]) for name in geometry.getVarNames()}
        now = geometry.getValues()
        if any((np.ravel(values[name]) != now[name]).any() for name in now):
            geometry.setDesignVars(values)
        return geometry

    def _measured(self, geometry, name):
        """The derivatives of a measure by its points, as the variables are set."""
        # Other components, and callers of setDesignVars(), change the variables, too.
        if self._by_points.get(name, (None,))[0] != geometry.revision:
            points, measure = self.options["measures"][name]
            _, derivatives = measure(np.ascontiguousarray(geometry.update(points, config=self.options["config"])))
            derivatives = derivatives.csr() if hasattr(derivatives, "csr") else derivatives
            self._by_points[name] = geometry.revision, derivatives
        return self._by_points[name][1]

    def compute(self, inputs, outputs):
        """Moves the points, and measures them. A complex step of a model around this one gets the derivatives of this
        component as its imaginary part."""
        geometry, config = self._set(inputs), self.options["config"]
        seeds = {name: np.imag(inputs[name]) for name in geometry.getVarNames()} if self.under_complex_step else None
        for name in self._point_sets():
            moved = geometry.update(name, config=config)
            if seeds is not None:
                moved = moved + 1j * geometry.totalSensitivityProd(seeds, name, config=config).reshape(-1, 3)
            outputs[name] = moved
        for name, (points, measure) in self.options["measures"].items():
            values, _ = measure(np.ascontiguousarray(geometry.update(points, config=config)))
            if seeds is not None:
                change = geometry.totalSensitivityProd(seeds, points, config=config)
                values = values + 1j * (self._measured(geometry, name) @ change)
            outputs[name] = values

    def compute_jacvec_product(self, inputs, d_inputs, d_outputs, mode):
        """Carries changes of the variables to the outputs ("fwd"), or gradients back ("rev")."""
        geometry, config = self._set(inputs), self.options["config"]
        by_name = {name: (name, None) for name in self._point_sets()}
        by_name.update((name, (points, name)) for name, (points, _) in self.options["measures"].items())
        for output, (points, measured) in by_name.items():
            if output not in d_outputs:
                continue
            by_points = self._measured(geometry, measured) if measured is not None else None
            if mode == "fwd":
                seeds = {name: d_inputs[name] for name in geometry.getVarNames() if name in d_inputs}
                change = geometry.totalSensitivityProd(seeds, points, config=config)
                change = change if by_points is None else by_points @ change
                d_outputs[output] += change.reshape(np.shape(d_outputs[output]))
            else:
                gradient = np.ravel(d_outputs[output])
                gradient = gradient if by_points is None else by_points.T @ gradient
                back = geometry.totalSensitivityTransProd(gradient.reshape(-1, 3), points, config=config)
                for name, change in back.items():
                    if name in d_inputs:
                        d_inputs[name] += change
