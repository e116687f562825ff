# SPDX-License-Identifier: Apache-2.0
"""The reference axes of espalier.dvgeometry.DVGeometry, and what functions of global variables change."""

import warnings
from collections import OrderedDict

import numpy as np

from . import pose as _pose
from ._core import ReferenceAxis

_VALUES = ("rot_x", "rot_y", "rot_z", "rot_theta", "scale", "scale_x", "scale_y", "scale_z")
#: The columns of the values of the nodes, which functions of global variables change.
_STATE_NAMES = ("x", "y", "z", *_VALUES)
_ComplexWarning = getattr(np, "exceptions", np).ComplexWarning  # its place in NumPy 2, and before
_ORDERS = {1: "xyz", 2: "xzy", 3: "yzx", 4: "yxz", 5: "zxy", 6: "zyx", 7: "zxy", 0: "zxy"}


def chosen_vertices(name, values, count):
    """Returns the numbers of some vertices, an array of int, as the library's other functions take them."""
    values = np.asarray(values)
    if values.size == 0:
        return np.zeros(0, int)
    if values.dtype.kind not in "iu":
        raise ValueError(f"{name}: expected an array of integers, got {values.dtype}")
    values = np.ravel(values)
    wrong = np.flatnonzero((values < 0) | (values >= count))
    if len(wrong):
        raise ValueError(f"{name}[{wrong[0]}]: expected a vertex, 0 to {count - 1}, got {values[wrong[0]]}")
    return values.astype(int)


def letter(name, value, letters):
    """Returns the place of a word of one letter among some letters."""
    if not isinstance(value, str) or len(value) != 1 or value.lower() not in letters:
        raise ValueError(f"{name}: expected {', '.join(letters[:-1])} or {letters[-1]}, got {value!r}")
    return letters.index(value.lower())


class _Curve:
    """Numbers or places at the nodes of a reference axis, as pyGeo's functions see them."""

    def __init__(self, coef):
        self.coef = coef
        self.k = 2

    @property
    def X(self):
        return self.coef

    @property
    def s(self):
        """The share of the length of the axis up to each node."""
        lengths = np.linalg.norm(np.diff(np.real(self.coef), axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(lengths) / lengths.sum()])


class ReferenceAxes:
    """Reference axes that carry the vertices of a lattice. The subclass has the lattice, getLocalIndex() and
    _changed()."""

    def __init__(self):
        super().__init__()
        self.axis, self.DV_listGlobal = OrderedDict(), OrderedDict()
        self._axes, self._parent = {}, None
        self._start_axes(np.zeros((0, 3)))

    def addRefAxis(self, name, curve=None, xFraction=None, yFraction=None, zFraction=None, volumes=None, rotType=5,
                   axis="x", alignIndex=None, rotAxisVar=None, rot0ang=None, rot0axis=(1, 0, 0), includeVols=(),
                   ignoreInd=(), raySize=1.5, vertices=None):
        """Adds a reference axis, which global variables move, turn and scale. Returns the number of its nodes.

        curve : array (n, 3), the nodes; or a curve of pySpline of order 2
        xFraction, yFraction, zFraction : in place of a curve, of a lattice that is a box: a node in each layer,
            at this share of its extent (along y and z from above)
        alignIndex : "i", "j" or "k": the direction of the layers
        rotType : 1 to 6, the order of the turns rot_x, rot_y, rot_z; 0, sections follow the axis and turn about it
            by rot_theta; 7, both. Here rot_theta counts in all of them
        axis : "x", "y" or "z": vertices are linked along this direction; array (3,): in planes with this normal;
            None: to the nearest point
        rot0ang, rot0axis : with rotType 0, scale_x, scale_y and scale_z are along the axes of a lattice that
            these degrees about this axis would turn to x, y and z
        ignoreInd : vertices that the axis does not move
        vertices : array (K,) of int: the vertices that the axis moves; all by default. A vertex has at most one axis
        """
        if self._parent is not None:
            raise ValueError("name: add the reference axes of a child before addChild()")
        if name in self.axis:
            raise ValueError(f"name: there is an axis {name} already")
        if volumes is not None or len(includeVols) > 0:
            raise ValueError("volumes: the blocks are one lattice; give `vertices`")
        if rotType not in _ORDERS:
            raise ValueError(f"rotType: expected 0 to 7, got {rotType}")
        if rotAxisVar is not None:
            raise ValueError("rotAxisVar: it is for rotType 8, which Espalier does not have")
        rest = self.lattice.positions
        fractions = (xFraction, yFraction, zFraction)
        if curve is not None:
            if any(fraction is not None for fraction in fractions):
                raise ValueError("curve: expected nodes or xFraction, yFraction and zFraction, got both")
            if getattr(curve, "k", 2) != 2:
                raise ValueError("curve: expected a curve of order 2, straight lines between the nodes")
            nodes = np.array(getattr(curve, "X", curve), dtype=float)
        elif any(fraction is not None for fraction in fractions) and alignIndex is not None:
            nodes = self._nodes_of_layers(fractions, alignIndex, rot0ang, rot0axis)
        else:
            raise ValueError("curve: expected nodes, or xFraction, yFraction or zFraction with alignIndex")
        chosen = np.ones(len(rest), bool)
        if vertices is not None:
            chosen[:] = False
            chosen[chosen_vertices("vertices", vertices, len(rest))] = True
        chosen[chosen_vertices("ignoreInd", ignoreInd, len(rest))] = False
        chosen = np.flatnonzero(chosen & ~self._frozen)
        options = {"order": _ORDERS[rotType], "follows": rotType == 0}
        if isinstance(axis, str):
            options.update(link="along", direction=np.eye(3)[letter("axis", axis, "xyz")])
        elif axis is not None:
            options.update(link="across", direction=np.asarray(axis, dtype=float))
        if rot0ang is not None:
            options["frame"] = _turn(np.eye(3), rot0axis, -rot0ang)
        for other, (carried, _) in self._axes.items():
            both = np.intersect1d(carried, chosen)
            if len(both):
                raise ValueError(f"vertices: the axes {other} and {name} would both carry vertex {both[0]}; give the "
                                 "vertices of each axis by `vertices` or `ignoreInd`")
        self._axes[name] = (chosen, ReferenceAxis(rest[chosen], nodes, **options))
        self.axis[name] = {"curve": _Curve(nodes), "rotType": rotType, "axis": axis}
        self._start_axes(self._rest_nodes())
        self._changed()
        return len(nodes)

    def _nodes_of_layers(self, fractions, align_index, angle, about):
        layers = np.moveaxis(self.getLocalIndex(0), letter("alignIndex", align_index, "ijk"), 0)
        nodes = []
        for layer in layers:
            places = self.lattice.positions[layer.ravel()]
            if angle:
                places = _turn(places, about, angle)
            low, high = places.min(axis=0), places.max(axis=0)
            node = places.mean(axis=0)
            for c, fraction in enumerate(fractions):
                if fraction is not None:
                    node[c] = low[c] + fraction * (high[c] - low[c]) if c == 0 else high[c] - fraction * (
                        high[c] - low[c])
            nodes.append(node)
        return _turn(np.array(nodes), about, -angle) if angle else np.array(nodes)

    def _rest_nodes(self):
        nodes = [each["curve"].coef for each in self.axis.values()]
        return np.vstack([np.zeros((0, 3)), *nodes])

    def _ranges(self):
        """The nodes of each axis among the nodes of all axes."""
        first, ranges = 0, {}
        for name, each in self.axis.items():
            ranges[name] = slice(first, first + len(each["curve"].coef))
            first = ranges[name].stop
        return ranges

    def extractCoef(self, axisID):
        """Returns a copy of the nodes of an axis, an array (n, 3), for functions of global variables."""
        return self.coef[self._ranges()[axisID]].copy()

    def restoreCoef(self, coef, axisID):
        """Sets the nodes of an axis, in functions of global variables.

        coef : array (n, 3)
        """
        self.coef[self._ranges()[axisID]] = coef

    def extractS(self, axisID):
        """Returns the share of the length of an axis up to each node: array (n,)."""
        return self.axis[axisID]["curve"].s

    def _start_axes(self, nodes):
        """Sets what the functions of global variables change to its values at rest."""
        self.coef = nodes.copy()
        for key in _VALUES:
            start = np.ones if key.startswith("scale") else np.zeros
            setattr(self, key, OrderedDict((name, _Curve(start(len(each["curve"].coef), nodes.dtype)))
                                           for name, each in self.axis.items()))

    def _state(self, nodes, values, config, steps=None):
        """Runs the functions of the global variables. Returns the values of all nodes, an array (n, 11).

        values : dict from names to arrays, real or complex like the nodes
        steps : list, to which the name of each function and the values of the nodes after it are added
        """
        self._start_axes(nodes)
        with warnings.catch_warnings():
            warnings.simplefilter("error", _ComplexWarning)
            for name, group in self.DV_listGlobal.items():
                if not group.applies(config):
                    continue
                try:
                    # A copy: the function may change the values in place.
                    group.function(values[name].copy(), self)
                except _ComplexWarning as error:
                    raise ValueError(f"{name}: its function drops the imaginary part of its values; derivatives need it "
                                     "(use no float(), no abs() and no real arrays)") from error
                if steps is not None:
                    steps.append((name, self._gathered()))
        return self._gathered()

    def _gathered(self):
        """The values of all nodes, as the functions left them: array (n, 11)."""
        columns = [np.concatenate([np.zeros(0), *(np.ravel(curve.coef) for curve in getattr(self, key).values())])
                   for key in _VALUES]
        state = np.column_stack([self.coef, *columns])
        state[:, 3:7] *= np.pi / 180
        return state


def _turn(places, about, degrees):
    """Turns places about an axis through the origin."""
    return _pose.rotate(np.asarray(places, dtype=float), np.asarray(about, dtype=float), np.pi / 180 * degrees,
                        center=(0, 0, 0))
