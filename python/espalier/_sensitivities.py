# SPDX-License-Identifier: Apache-2.0
"""The derivatives of the points of espalier.dvgeometry.DVGeometry by its variables, in the arrays and dicts of pyGeo."""

import numpy as np
import scipy.sparse

from ._core import jacobian
from ._derivatives import Derivatives


class Sensitivities(Derivatives):
    """Derivatives of the sets of points by variables. The subclass has lattice, variables and points."""

    def computeTotalJacobian(self, ptSetName, config=None):
        """Computes the derivatives of the points by the variables, as they are set. Returns a sparse matrix of shape
        (variables, 3 N), which JT[ptSetName] keeps until variables are set."""
        if self.JT[ptSetName] is None or self._configs[ptSetName] != config:
            parts = [jacobian(deformation, change).csr() for deformation, change in self._parts(ptSetName, config)]
            total = sum(parts[1:], parts[0]).T.tocsr()
            if ptSetName in self._transfer:
                # Each row is a change of the points by one variable, which the other frame turns.
                turned = [self._to_frame(ptSetName, row.toarray().reshape(-1, 3)).ravel() for row in total]
                total = scipy.sparse.csr_matrix(np.reshape(turned, total.shape))
            self.JT[ptSetName], self._configs[ptSetName] = total, config
        return self.JT[ptSetName]

    def _parts(self, ptSetName, config):
        """The pairs of _changes() for the variables as they are set."""
        kept = self._kept.get(ptSetName)
        if kept is not None and kept[0] == config:
            return kept[1]
        first, columns = 0, {}
        for name, group in self._groups().items():
            columns[name] = slice(first, first + group.nVal)
            first = columns[name].stop
        rest, nodes = self.lattice.positions, self._rest_nodes()
        none = scipy.sparse.csr_matrix((3 * len(rest), first))
        by_nodes = scipy.sparse.csr_matrix((3 * len(nodes), first))
        parts = self._changes(ptSetName, rest, nodes, none, by_nodes, config, columns)
        self._kept[ptSetName] = config, parts
        return parts

    def totalSensitivity(self, dIdpt, ptSetName, comm=None, config=None):
        """Carries gradients by the points to the variables. Returns a dict from names to arrays (M, variables).

        dIdpt : array (N, 3), or (M, N, 3) for M functions
        comm : communicator of mpi4py, over which the results are summed
        """
        gradients, shape = np.array(dIdpt, dtype=float), self.points[ptSetName].shape
        if gradients.ndim not in (2, 3) or gradients.shape[-2:] != shape:
            raise ValueError(f"dIdpt: expected an array of shape {shape} or (M, {shape[0]}, 3), got {gradients.shape}")
        gradients = gradients if gradients.ndim == 3 else gradients[None]
        if ptSetName in self._transfer:
            for m, each in enumerate(gradients):
                gradients[m] = self._transfer[ptSetName](each, mode="bwd", applyDisplacement=False)
        result = np.zeros((len(gradients), self.getNDV()))
        for deformation, change in self._parts(ptSetName, config):
            # Dᵀ first: there are fewer vertices than points.
            by_vertices = [np.ravel(deformation.T @ each) for each in gradients]
            result += (change.T @ np.transpose(by_vertices)).T
        return self.convertSensitivityToDict(comm.allreduce(result) if comm else result)

    def totalSensitivityProd(self, vec, ptSetName, config=None):
        """Carries changes of the variables to the points. Returns an array (3 N,): x, y, z of point 0, and so on.

        vec : dict from names to arrays; variables that are not named do not change
        """
        groups = self._groups()
        for name in vec:
            if name not in groups:
                raise ValueError(f"vec: there are no variables {name}; there are {', '.join(groups)}")
        seeds = {name: np.ravel(np.asarray(vec.get(name, np.zeros(group.nVal)), dtype=float))
                 for name, group in groups.items()}
        for name, group in groups.items():
            if len(seeds[name]) != group.nVal:
                raise ValueError(f"vec: expected {group.nVal} values of {name}, got {len(seeds[name])}")
        seed = np.concatenate([np.zeros(0), *seeds.values()])
        moved = np.ravel(sum(deformation @ (change @ seed).reshape(-1, 3)
                             for deformation, change in self._parts(ptSetName, config)))
        return np.ravel(self._to_frame(ptSetName, moved.reshape(-1, 3)))

    def _to_frame(self, ptSetName, changes):
        """Changes of points, in the frame of the points."""
        if ptSetName not in self._transfer:
            return changes
        return np.asarray(self._transfer[ptSetName](changes, mode="fwd", applyDisplacement=False))

    def totalSensitivityTransProd(self, vec, ptSetName, config=None):
        """Carries one gradient by the points to the variables. Returns a dict from names to arrays (variables,).

        vec : array (N, 3), or (3 N,): x, y, z of point 0, and so on
        """
        gradient, shape = np.asarray(vec, dtype=float), self.points[ptSetName].shape
        if gradient.shape not in (shape, (3 * shape[0],)):
            raise ValueError(f"vec: expected an array of shape {shape}, got {gradient.shape}")
        back = self.totalSensitivity(gradient.reshape(shape), ptSetName, config=config)
        return {name: each[0] for name, each in back.items()}

    def convertSensitivityToDict(self, dIdx, out1D=False):
        """Splits the columns of an array (M, variables) by the names of the variables: a dict."""
        if np.shape(dIdx)[-1:] != (self.getNDV(),):
            raise ValueError(f"dIdx: expected an array with {self.getNDV()} columns, got shape {np.shape(dIdx)}")
        first, result = 0, {}
        for name, group in self._groups().items():
            columns = np.asarray(dIdx)[..., first:first + group.nVal]
            result[name] = np.ravel(columns) if out1D else columns
            first += group.nVal
        return result

    def convertDictToSensitivity(self, dIdxDict):
        """Joins the arrays of a dict by the names of the variables: array (variables,)."""
        for name, group in self._groups().items():
            if np.size(dIdxDict[name]) != group.nVal:
                raise ValueError(f"dIdxDict: expected {group.nVal} values of {name}, got {np.size(dIdxDict[name])}")
        return np.concatenate([np.zeros(0), *(np.ravel(dIdxDict[name]) for name in self._groups())])
