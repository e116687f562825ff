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
#: The rounding of a state of size 1 by a function of 50 operations. Only the first step allows for rounding, divided by
#: the step: derivatives of steep functions, for which the other steps are, are much larger than the rounding.
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
        result = self._axes_jacobian(rest, nodes, by_rest, by_nodes, config, columns) if self.axis else by_rest
        for name, group in self.DV_listLocal.items():
            if group.applies(config):
                result = result + _placed(group.matrix, columns[name], total)
        return result.tocsr()

    def _axes_jacobian(self, rest, nodes, by_rest, by_nodes, config, columns):
        self._check_functions(nodes, config)
        by_state = self._states_jacobian(nodes, by_nodes, config, columns)
        state = self._state(nodes, {name: group.value for name, group in self.DV_listGlobal.items()}, config)
        stays, blocks, moved_rows = np.ones(by_rest.shape[0]), [], [np.zeros(0, int)]
        for name, part in self._ranges().items():
            chosen, axis = self._axes[name]
            moved = axis.moved_to(rest[chosen], nodes[part])
            rows = (3 * chosen[:, None] + np.arange(3)).ravel()
            at_rest = scipy.sparse.vstack([by_rest[rows], by_nodes[3 * part.start:3 * part.stop]])
            blocks.append(moved.matrix(state[part]).csr() @ by_state[11 * part.start:11 * part.stop]
                          + moved.rest_matrix(state[part]).csr() @ at_rest)
            moved_rows.append(rows)
            stays[rows] = 0
        # The rows of the axes replace rows of by_rest, all at once. Setting them one by one took 4.5 s in place of 0.07 s
        # for 9,261 vertices.
        rows = np.concatenate(moved_rows)
        scatter = scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))),
                                          shape=(by_rest.shape[0], len(rows)))
        return scipy.sparse.diags(stays) @ by_rest + scatter @ scipy.sparse.vstack(blocks)

    def _states_jacobian(self, nodes, by_nodes, config, columns):
        """The derivatives of the values of the nodes by all variables: sparse matrix (11 n, variables)."""
        values = {name: group.value.astype(complex) for name, group in self.DV_listGlobal.items()}
        by_values = []
        for name, start in values.items():
            for k in range(len(start)):
                step = 1j * _STEP * np.eye(len(start))[k]
                state = self._state(nodes.astype(complex), {**values, name: start + step}, config)
                by_values.append((columns[name].start + k, state.imag.ravel() / _STEP))
        result = _columns(by_values, 11 * len(nodes), by_nodes.shape[1])
        # The functions start from nodes that the parents carry. There are fewer nodes than variables of the parents.
        by_carried = []
        for row in np.unique(by_nodes.nonzero()[0]):
            step = 1j * _STEP * np.reshape(np.arange(nodes.size) == row, nodes.shape)
            by_carried.append((row, self._state(nodes + step, values, config).imag.ravel() / _STEP))
        return result + _columns(by_carried, 11 * len(nodes), nodes.size) @ by_nodes

    def _check_functions(self, nodes, config):
        """Refuses functions of global variables that drop imaginary parts. Compares the complex step with differences,
        once for each combination of functions and axes."""
        groups = {name: group for name, group in self.DV_listGlobal.items() if group.applies(config)}
        key = tuple(groups.values()), tuple(self.axis), self._parent is not None
        if key in self._checked:
            return
        # At a random place near the values: where they are set, a kink such as abs(0) has the difference 0, too.
        random = np.random.default_rng(0)
        values = {name: group.near(random) for name, group in groups.items()}
        if not self._is_defined(nodes, values, config):
            values = {name: group.value for name, group in groups.items()}
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

    def _is_defined(self, nodes, values, config):
        """Tells whether the functions accept some values."""
        try:
            with np.errstate(all="ignore"):
                return bool(np.isfinite(self._state(nodes, values, config)).all())
        except Exception:  # pylint: disable=broad-exception-caught
            return False  # A function of a user may raise anything where it is not defined.

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
                rounding = _CHECK_ROUNDING / h * np.maximum(1, np.abs(high)) if h == _CHECK_STEPS[0] else 0
                bound = _CHECK_TOLERANCE * size + rounding
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


def _columns(vectors, rows, count):
    """A sparse matrix (rows, count) with some columns: pairs of number and vector."""
    numbers = [number for number, _ in vectors]
    dense = np.reshape([vector for _, vector in vectors], (len(vectors), rows)).T
    return scipy.sparse.csr_matrix(dense) @ scipy.sparse.csr_matrix(
        (np.ones(len(numbers)), (np.arange(len(numbers)), np.array(numbers, int))), shape=(len(numbers), count))


def _placed(matrix, columns, total):
    """A sparse matrix with the columns of another one at some columns."""
    before = scipy.sparse.csr_matrix((matrix.shape[0], columns.start))
    after = scipy.sparse.csr_matrix((matrix.shape[0], total - columns.stop))
    return scipy.sparse.hstack([before, matrix, after]).tocsr()
