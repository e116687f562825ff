# SPDX-License-Identifier: Apache-2.0
"""Deforms models by lattices of any polyhedral topology.

A control lattice is refined by Catmull-Clark rules for volumes, and points are bound to a level of
it. That makes one sparse matrix D: for a pose p' of the lattice the points are D @ p'.

    import espalier

    rest = espalier.shapes.box(cells=(2, 2, 4), min=(-1, -1, 0), max=(1, 1, 4))
    binding = espalier.bind(rest, points, level=3)   # points: array (N, 3)
    pose = rest.positions.copy()
    pose[-9:, 0] += 0.5                              # array (V, 3)
    moved = binding.deform(pose)                     # array (N, 3)
    gradient = binding.adjoint(by_points)            # array (V, 3): D.T @ by_points
    D = binding.matrix                               # scipy.sparse.csr_matrix (N, V)

Arrays of positions have shape (count, 3) and any unit of length; angles are in radians. A wrong
argument raises a ValueError that names it. Work that would take more memory than a MemoryLimit allows
raises a MemoryError.

Other threads of Python run during long calls, but not while arguments and results are converted to
arrays and lists. Ctrl-C soon ends refining, binding, evaluating and checking; work on a single core
(reading and writing files, compiling tables, fit()) is finished first. Everything but
DesignVariables may be used from many threads at once.

Lattice, StencilTable and Binding can be pickled. They never change, so a copy is the object itself.
"""

import enum

from . import constraints, pose, shapes
from ._core import *
from ._core import __version__

__all__ = [
    "Binding",
    "ChangeEvaluator",
    "CompiledAdjoint",
    "CompiledTable",
    "DesignVariables",
    "LargestStep",
    "Lattice",
    "LatticeFit",
    "MemoryLimit",
    "MeshCheck",
    "Model",
    "PointStatus",
    "PoseValidity",
    "ReferenceAxis",
    "Refiner",
    "RigidPose",
    "RigidPull",
    "SectionVariables",
    "SlidingPoints",
    "StencilTable",
    "ThreadLimit",
    "ValidityCheck",
    "__version__",
    "bind",
    "carry_normals",
    "carry_tangents",
    "check",
    "compare",
    "constraints",
    "fit",
    "hold",
    "jacobian",
    "load_binding",
    "nest",
    "pose",
    "read",
    "read_model",
    "read_pose",
    "refine",
    "shapes",
]


class PointStatus(enum.IntEnum):
    """Whether a bound point is inside the lattice: the values of Binding.statuses."""

    INSIDE = 0  # in a cell, in a gap between two cells, or within the tolerance
    OUTSIDE = 1  # outside the region that the cells fill
    NOT_CONVERGED = 2  # could not be placed: its cell is degenerate, or a coordinate is not finite
    NOT_BOUND = 3  # its weight is 0


def compare(lattice, level=3):
    """Compares the surface of a lattice, or a mesh, with OpenSubdiv's, level by level.

    lattice : Lattice, or Refiner for rules other than the defaults
    level   : the last level to compare, 1 or more

    Returns an Agreement: agrees, levels (each with counts, topology_difference, and the largest
    differences of positions and weights) and a note. Raises ImportError if Espalier was built without
    OpenSubdiv, or OpenSubdiv is not installed.
    """
    try:
        from . import _compare
    except ImportError as error:
        raise ImportError("espalier.compare() needs OpenSubdiv, and Espalier built with it: "
                          f"{error}") from error
    refiner = lattice if isinstance(lattice, Refiner) else Refiner(lattice)
    return _compare.compare(refiner, level)
