# SPDX-License-Identifier: Apache-2.0
"""The derivatives of the vertices of espalier.dvgeometry.DVGeometry by its variables."""

import numpy as np
import scipy.sparse

from ._core import jacobian
from ._reference_axes import _STATE_NAMES

_STEP = 1e-40  # of the complex step, by which functions of global variables are differentiated
#: The steps of the differences that check the complex step. Steep functions need the small steps, noisy functions the large.
_CHECK_STEPS = 1e-4, 1e-6, 1e-8
#: How far a derivative may be from a difference, relative to both. The error of a central difference is the square of its
#: step, 1e-8, times the third derivative; a dropped imaginary part changes a derivative by a share of its size.
_CHECK_TOLERANCE = 1e-4
#: The same, for the rounding of a state of size 1 by a function of 50 operations, divided by the step.
_CHECK_ROUNDING = 1e-14


class Derivatives:
    """Derivatives of vertices by variables, which children receive from their parents. The subclass has lattice, axes,
    variables and points."""

    def __init__(self):
        super().__init__()
        self._checked = set()

    def _jacobian(self, rest, nodes, by_rest, by_nodes, config, columns):
        """The derivatives of the vertices by all variables: sparse matrix (3 V, variables).

        by_rest, by_nodes : the derivatives of rest and nodes, by the variables of the parents
        columns : dict from names to slices of columns
        """
        total = by_rest.shape[1]
        result = by_rest.tolil() if self.axis else by_rest
        if self.axis:
            result = self._axes_jacobian(rest, nodes, by_rest, by_nodes, config, columns, total)
        for name, group in self.DV_listLocal.items():
            if group.applies(config):
                result = result + _placed(group.matrix, columns[name], total)
        return result.tocsr()

    def _axes_jacobian(self, rest, nodes, by_rest, by_nodes, config, columns, total):
        self._check_functions(nodes, config)
        values = {name: group.value.astype(complex) for name, group in self.DV_listGlobal.items()}
        by_state = scipy.sparse.lil_matrix((11 * len(nodes), total))
        dense_nodes = by_nodes.tocsc()
        inputs = [(name, k) for name in values for k in range(len(values[name]))]
        for name, k in inputs:
            start = values[name]
            values[name] = start.copy()
            values[name][k] += 1j * _STEP
            state = self._state(nodes.astype(complex), values, config)
            values[name] = start
            by_state[:, columns[name].start + k] = state.imag.reshape(-1, 1) / _STEP
        # The functions start from nodes that the parents carry.
        for column in np.unique(dense_nodes.nonzero()[1]):
            seed = dense_nodes[:, column].toarray().reshape(-1, 3)
            state = self._state(nodes + 1j * _STEP * seed, values, config)
            by_state[:, column] = state.imag.reshape(-1, 1) / _STEP
        by_state = by_state.tocsr()
        state = self._state(nodes, {name: group.value for name, group in self.DV_listGlobal.items()}, config)
        result = by_rest.tolil()
        for name, part in self._ranges().items():
            chosen, axis = self._axes[name]
            moved = axis.moved_to(rest[chosen], nodes[part])
            rows = (3 * chosen[:, None] + np.arange(3)).ravel()
            own = moved.matrix(state[part]).csr() @ by_state[11 * part.start:11 * part.stop]
            at_rest = scipy.sparse.vstack([by_rest.tocsr()[rows], by_nodes.tocsr()[3 * part.start:3 * part.stop]])
            result[rows] = own + moved.rest_matrix(state[part]).csr() @ at_rest
        return result

    def _check_functions(self, nodes, config):
        """Refuses functions of global variables that drop imaginary parts. Compares the complex step with differences, once
        for each combination of functions and axes."""
        groups = {name: group for name, group in self.DV_listGlobal.items() if group.applies(config)}
        key = tuple(groups.values()), tuple(self.axis), self._parent is not None
        if key in self._checked:
            return
        # At a random place near the values: where they are set, a kink such as abs(0) has the difference 0, too.
        random = np.random.default_rng(0)
        values = {name: group.near(random) for name, group in groups.items()}
        extent = np.ptp(nodes, axis=0).max() if len(nodes) else 0.0
        none = {name: np.zeros(len(value)) for name, value in values.items()}
        if self._parent is not None:
            nodes = nodes + 1e-3 * extent * random.uniform(-1, 1, nodes.shape)
            self._compare_steps(nodes, values, extent * random.uniform(-1, 1, nodes.shape), none, config,
                                "the nodes that a parent carries")
        for name, value in values.items():
            for k in range(len(value)):
                seed = {**none, name: np.eye(len(value))[k] * max(1, abs(value[k]))}
                self._compare_steps(nodes, values, np.zeros(nodes.shape), seed, config, f"{name}[{k}]")
        self._checked.add(key)

    def _compare_steps(self, nodes, values, node_seed, seed, config, variable):
        """Compares the complex step along one direction with differences, after each function."""

        def after_each(step):
            moved = {name: value + step * seed[name] for name, value in values.items()}
            steps = []
            with np.errstate(all="ignore"):
                self._state(nodes + step * node_seed, moved, config, steps)
            return steps

        exact = [(name, state.imag / _STEP) for name, state in after_each(1j * _STEP)]
        agrees = [False] * len(exact)
        for h in _CHECK_STEPS:
            for each, ((_, by_step), (_, low), (_, high)) in enumerate(zip(exact, after_each(-h), after_each(h))):
                difference = (high - low) / (2 * h)
                size = np.maximum(np.abs(by_step), np.abs(difference))
                error = np.abs(by_step - difference)
                bound = _CHECK_TOLERANCE * size + _CHECK_ROUNDING / h * np.maximum(1, np.abs(high))
                # A state that is not finite at this place says nothing.
                agrees[each] = agrees[each] | (error <= bound) | ~np.isfinite(error)
        for (name, _), each in zip(exact, agrees):
            if not each.all():
                changed = _STATE_NAMES[np.argwhere(~each)[0][1]]
                raise ValueError(f"{name}: its function drops the imaginary part of its values: the derivative of {changed} "
                                 f"by {variable} differs from the difference quotient (use no float(), no abs(), no "
                                 "np.linalg.norm() and no real arrays)")

    def _changes(self, name, rest, nodes, by_rest, by_nodes, config, columns):
        """Pairs (D, derivatives of vertices by all variables), for this lattice and the children: the derivatives of points
        are the sum of (D x I3) times the second ones."""
        by_pose = self._jacobian(rest, nodes, by_rest, by_nodes, config, columns)
        # A child adds its own changes only.
        result = [(self._bindings[name], (by_pose - by_rest).tocsr())]
        pose = self._pose(rest, nodes, config)
        for key, child in self.children.items():
            if name in child.points:
                places, deformation = self._carried[key]
                carried = places + deformation @ (pose - self.lattice.positions)
                by_carried = jacobian(deformation, by_pose).csr()
                count = len(child.lattice.positions)
                result += child._changes(name, carried[:count], carried[count:], by_carried[:3 * count],
                                         by_carried[3 * count:], config, columns)
        return result


def _placed(matrix, columns, total):
    """A sparse matrix with the columns of another one at some columns."""
    before = scipy.sparse.csr_matrix((matrix.shape[0], columns.start))
    after = scipy.sparse.csr_matrix((matrix.shape[0], total - columns.stop))
    return scipy.sparse.hstack([before, matrix, after]).tocsr()
