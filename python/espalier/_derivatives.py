# SPDX-License-Identifier: Apache-2.0
"""The derivatives of the vertices of espalier.dvgeometry.DVGeometry by its variables."""

import numpy as np
import scipy.sparse

from ._core import jacobian

_STEP = 1e-40  # of the complex step, by which functions of global variables are differentiated


class Derivatives:
    """Derivatives of vertices by variables, which children receive from their parents. The subclass has lattice, axes,
    variables and points."""

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
            if not state.imag.any():
                self._require_no_effect(name, k, state.real, nodes, config)
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

    def _require_no_effect(self, name, k, state, nodes, config):
        """Refuses a function that changes the axes, but not their imaginary parts."""
        values = {each: group.value.copy() for each, group in self.DV_listGlobal.items()}
        values[name][k] += 1e-3 * max(1, abs(values[name][k]))
        if not np.array_equal(self._state(nodes, values, config), state):
            raise ValueError(f"{name}: its function drops the imaginary part of its values; derivatives need it (use no "
                             "float(), no abs() and no real arrays)")

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
