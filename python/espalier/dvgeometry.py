# SPDX-License-Identifier: Apache-2.0
"""Design variables of a lattice, by the calls of pyGeo's DVGeometry.

    geo = espalier.dvgeometry.DVGeometry("ffd.xyz")
    geo.addPointSet(points, "wing")
    geo.addRefAxis("axis", curve=quarter_chord, axis=np.array([0, 0, 1.0]))
    geo.addGlobalDV("twist", np.zeros(4), twist)     # twist(values, geo) sets geo.rot_theta["axis"].coef
    geo.addLocalDV("shape", axis="y")
    geo.setDesignVars({"twist": values})
    moved = geo.update("wing")                       # array (N, 3)
    gradient = geo.totalSensitivity(by_points, "wing")   # dict of arrays

Names and arguments are pyGeo's; docs/from-pygeo-pygem-su2.md says what differs. The lattice may have
any topology. Angles of reference axes are in degrees, as in pyGeo.
"""

import pathlib
from collections import OrderedDict

import numpy as np
import scipy.sparse

from ._core import DesignVariables, Lattice, Refiner, bind, read
from ._reference_axes import ReferenceAxes, chosen_vertices, letter
from ._sensitivities import Sensitivities

__all__ = ["DVGeometry"]

_OPTIONS = "level", "limit", "basis", "outside", "tolerance"  # of bind(), for all points
_SIDES = "iLow", "iHigh", "jLow", "jHigh", "kLow", "kHigh"


def _require_options(options, known):
    for each in options:
        if each not in known:
            raise TypeError(f"{each}: there is no such option; there are {', '.join(known)}")


class _Group:
    """A group of design variables."""

    def __init__(self, name, value, lower, upper, scale, config):
        self.name, self.value = name, np.atleast_1d(np.array(value, dtype=float)).ravel()
        self.nVal = len(self.value)
        self.lower, self.upper, self.scale = (self._each(each) for each in (lower, upper, scale))
        self.config = [config] if isinstance(config, str) else config

    def _each(self, bound):
        if bound is None:
            return None
        values = np.atleast_1d(np.asarray(bound, dtype=float))
        if len(values) not in (1, self.nVal):
            raise ValueError(f"{self.name}: expected one bound or {self.nVal}, got {len(values)}")
        return np.broadcast_to(values, self.nVal).copy()

    def applies(self, config):
        return self.config is None or config is None or config in self.config


class _Global(_Group):
    def __init__(self, *arguments, function):
        super().__init__(*arguments)
        self.function = function

    def near(self, random):
        """Random values near those that are set, between the bounds."""
        far = 1e-2 * np.maximum(1, np.abs(self.value))
        step = far * random.uniform(0.5, 1, self.nVal)
        low, high = (np.full(self.nVal, sign * np.inf) if bound is None else bound
                     for sign, bound in ((-1, self.lower), (1, self.upper)))
        near = np.where(self.value + far > high, self.value - step, self.value + step)
        return np.where((near < low) | (near > high), self.value, near)


class _Local(_Group):
    def __init__(self, *arguments, matrix):
        super().__init__(*arguments)
        self.matrix = matrix  # displacements by variables, of shape (3 V, variables)


class DVGeometry(ReferenceAxes, Sensitivities):
    """Design variables of a lattice, and the points that follow it, by the calls of pyGeo.

    lattice    : path of a file, Lattice, or Refiner; a PLOT3D file of boxes is welded to one lattice
    child      : True for a lattice that addChild() puts into another one
    faceFreeze : dict {"0": ["iLow", ...]} of a lattice that is a box: two layers of vertices that no
                 variable and no reference axis moves
    name       : is put before the names of the variables: "name_variable"
    frozen     : array (K,) of int: vertices that no variable and no reference axis moves
    move_held  : if True, the vertices that the lattice holds (Lattice.held) may move; they are frozen by default
    options    : of bind() for all points: level, limit, basis, outside, tolerance

    `revision` is a number that rises with each change of variables, of their values and of points.
    """

    def __init__(self, lattice, *, child=False, faceFreeze=None, name=None, frozen=(), move_held=False,
                 **options):
        if isinstance(lattice, Refiner):
            self._refiner, self.lattice = lattice, lattice.lattice
        else:
            self.lattice = lattice if isinstance(lattice, Lattice) else read(lattice)
            self._refiner = Refiner(self.lattice)
        if options.pop("isComplex", False):
            raise ValueError("isComplex: the derivatives of totalSensitivity() are exact; there are no complex points")
        _require_options(options, _OPTIONS)
        self._options = options
        self.name, self.isChild, self.revision = name, child, 0
        self.points, self.ptSetNames, self.updated, self.JT = OrderedDict(), [], {}, {}
        self.children, self.DV_listLocal = OrderedDict(), OrderedDict()
        self._bindings, self._carried, self._transfer, self._kept = {}, {}, {}, {}
        self._active, self._configs = {}, {}
        super().__init__()
        self._frozen = np.zeros(len(self.lattice.positions), bool)
        if not move_held:
            self._frozen[self.lattice.held] = True
        self._frozen[chosen_vertices("frozen", frozen, len(self._frozen))] = True
        for volume, faces in (faceFreeze or {}).items():
            if str(volume) != "0":
                raise ValueError(f"faceFreeze: the blocks are one lattice, \"0\"; got {volume!r}")
            layers = self.getLocalIndex()
            for face in faces:
                if face not in _SIDES:
                    raise ValueError(f"faceFreeze: expected a list of {', '.join(_SIDES)}; got {face!r}")
                along = np.moveaxis(layers, "ijk".index(face[0]), 0)
                self._frozen[along[:2] if face[1:] == "Low" else along[-2:]] = True

    # Points.

    def addPointSet(self, points, ptName, origConfig=True, coordXfer=None, activeChildren=None, deformation=None,
                    **options):
        """Adds points that follow the lattice.

        points : array (N, 3)
        ptName : name of the points for update() and the sensitivities
        origConfig : must be True: points are of the lattice at rest
        coordXfer : function (array (N, 3), mode="fwd" or "bwd", applyDisplacement=True) between the frame of
            the lattice and the frame of the points
        activeChildren : list of names: the children whose variables move the points; all by default, also
            children that are added later
        deformation : D, a sparse matrix (N, V), in place of binding the points
        options : of bind(), for these points only; also weights and falloff
        """
        if not origConfig:
            raise ValueError("origConfig: expected True, points of the lattice at rest")
        for name in activeChildren if activeChildren is not None else ():
            if name not in self.children:
                raise ValueError(f"activeChildren: there is no child {name}; add the children before the points")
        self._require_no_set(ptName, activeChildren)
        if options and deformation is not None:
            raise TypeError(f"{next(iter(options))}: the points are not bound if there is a `deformation`")
        _require_options(options, (*_OPTIONS, "weights", "falloff"))
        points = np.array(points, dtype=float)
        if coordXfer is not None:
            points = np.asarray(coordXfer(points, mode="bwd", applyDisplacement=True))
        if deformation is None:
            deformation = self._bound(points, options)
        if coordXfer is not None:
            self._transfer[ptName] = coordXfer
        self.ptSetNames.append(ptName)
        self._active[ptName] = None if activeChildren is None else list(activeChildren)
        self.points[ptName], self._bindings[ptName] = points, deformation
        self.updated[ptName], self.JT[ptName] = False, None
        for child in self._children_of(ptName):
            child.addPointSet(points, ptName)
        self._changed()

    def _require_no_set(self, ptName, activeChildren=None):
        if ptName in self.points:
            raise ValueError(f"ptName: {self._title()} has points {ptName} already")
        for name, child in self.children.items():
            if activeChildren is None or name in activeChildren:
                child._require_no_set(ptName)

    def _children_of(self, ptName):
        """The children whose variables move some points."""
        active = self._active[ptName]
        return [child for name, child in self.children.items() if active is None or name in active]

    def _bound(self, points, options):
        """Returns D for some points."""
        return bind(self._refiner, points, **{**self._options, **options}).matrix

    def pointSetUpToDate(self, ptSetName):
        """Tells whether update() was called for these points since the variables were set."""
        return self.updated.get(ptSetName, True)

    def addChild(self, childDVGeo):
        """Puts a lattice into this one. Its vertices and its reference axes follow this lattice; the changes by
        its own variables are added to the points inside it, also to points that were added before.

        childDVGeo : DVGeometry with child=True
        """
        if not childDVGeo.isChild or childDVGeo._parent is not None or childDVGeo is self._root():
            raise ValueError("childDVGeo: expected a DVGeometry that was made with child=True, and is in no other")
        name = childDVGeo.name if childDVGeo.name is not None else f"child{len(self.children)}"
        if name in self.children:
            raise ValueError(f"childDVGeo: there is a child {name} already; give it another name")
        owners = self._root()._owners()
        for variables, owner in childDVGeo._owners().items():
            if variables in owners:
                raise ValueError(f"childDVGeo: {owners[variables]._title()} and {owner._title()} both have variables "
                                 f"{variables}; give the variables other names, or the child a name")
        for ptName, active in self._active.items():
            if active is None:
                childDVGeo._require_no_set(ptName)
        places = np.vstack([childDVGeo.lattice.positions, childDVGeo._rest_nodes()])
        self._carried[name] = (places, self._bound(places, {"outside": "nearest"}))
        self.children[name], childDVGeo._parent = childDVGeo, self
        for ptName, points in self.points.items():
            if childDVGeo in self._children_of(ptName):
                childDVGeo.addPointSet(points, ptName)
        self._changed()

    # Variables.

    def _named(self, name, prepend):
        full = f"{self.name}_{name}" if self.name is not None and prepend else name
        owner = self._root()._owners().get(full)
        if owner is self:
            raise ValueError(f"dvName: there are variables {full} already")
        if owner is not None:
            raise ValueError(f"dvName: {owner._title()} has variables {full} already; give the variables of {self._title()} "
                             "another name")
        return full

    def _root(self):
        return self if self._parent is None else self._parent._root()

    def _owners(self):
        """The lattices that have the variables: dict from names."""
        owners = {name: self for name in (*self.DV_listGlobal, *self.DV_listLocal)}
        for child in self.children.values():
            owners.update(child._owners())
        return owners

    def _title(self):
        """The lattice in messages."""
        if self._parent is None:
            return "the child" if self.isChild and self.name is None else (
                f"the child {self.name}" if self.isChild else "the outermost lattice")
        return "the child " + next(name for name, each in self._parent.children.items() if each is self)

    def _changed(self):
        self._forget_results()
        if self._parent is not None:
            self._parent._changed()

    def _forget_results(self):
        for name in self.ptSetNames:
            self.updated[name], self.JT[name] = False, None
        self._kept = {}
        self.revision += 1

    def _changed_below(self):
        for child in self.children.values():
            child._forget_results()
            child._changed_below()

    def addGlobalDV(self, dvName, value, func, lower=None, upper=None, scale=1.0, config=None, prependName=True):
        """Adds variables that a function applies to the reference axes.

        value : float, or array (n,): the values at rest
        func : function (array (n,), DVGeometry), which changes extractCoef() by restoreCoef(), and .coef of
            rot_x, rot_y, rot_z, rot_theta, scale, scale_x, scale_y and scale_z of the axes. It is called with
            complex numbers for derivatives
        lower, upper, scale : float, or array (n,), for optimisers
        config : str or list of str: the configurations for which the variables count; all by default
        """
        name = self._named(dvName, prependName)
        self.DV_listGlobal[name] = _Global(name, value, lower, upper, scale, config, function=func)
        self._changed()

    def _add_local(self, name, matrix, lower, upper, scale, config):
        count = matrix.shape[1]
        # Frozen vertices have empty rows.
        matrix = (scipy.sparse.diags(np.repeat(~self._frozen, 3).astype(float)) @ matrix).tocsr()
        matrix.eliminate_zeros()
        self.DV_listLocal[name] = _Local(name, np.zeros(count), lower, upper, scale, config, matrix=matrix)
        self._changed()
        return count

    def addLocalDV(self, dvName, lower=None, upper=None, scale=1.0, axis="y", volList=None, pointSelect=None,
                   config=None, prependName=True, vertices=None, design=None):
        """Adds a variable for each vertex and each direction of `axis`. Returns their number.

        axis : "x", "y", "z", or several: "xy"
        pointSelect : object with getPoints(positions), which returns points and their numbers, as pyGeo's
        vertices : array (K,) of int; all by default
        design : DesignVariables: links, mirror images and units, in place of axis and vertices. Frozen vertices
            do not move with their link or their mirror image
        """
        if volList is not None:
            raise ValueError("volList: the blocks are one lattice; give `vertices`")
        given = [each is not None for each in (vertices, pointSelect, design)]
        if sum(given) > 1:
            raise ValueError("vertices: expected one of vertices, pointSelect and design")
        name = self._named(dvName, prependName)
        count = len(self.lattice.positions)
        if design is not None and design.matrix().shape[0] != 3 * count:
            raise ValueError(f"design: expected variables of {count} vertices, got {design.matrix().shape[0] // 3}")
        if design is None:
            design = DesignVariables(count)
            if pointSelect is not None:
                vertices = pointSelect.getPoints(self.lattice.positions)[1]
            chosen = np.zeros(count, bool)
            chosen[slice(None) if vertices is None else chosen_vertices("vertices", vertices, count)] = True
            design.freeze(np.flatnonzero(~chosen | self._frozen))
            for c in {0, 1, 2} - self._directions(axis):
                design.freeze(np.arange(count), c)
        return self._add_local(name, design.matrix().csr(), lower, upper, scale, config)

    @staticmethod
    def _directions(axis):
        """The numbers of the directions in a word."""
        letters = list(axis.lower()) if isinstance(axis, str) else []
        if not letters or len(set(letters)) < len(letters) or not set(letters) <= set("xyz"):
            raise ValueError(f"axis: expected x, y, z or several of them, such as xy; got {axis!r}")
        return {"xyz".index(each) for each in letters}

    def addShapeFunctionDV(self, dvName, shapes, lower=None, upper=None, scale=1.0, config=None, prependName=True):
        """Adds a variable for each shape, which moves several vertices. Returns the number of variables.

        shapes : dict from vertices to displacements, 3 float each, for a value of 1; or a list of such dicts.
            Frozen vertices do not move
        """
        name = self._named(dvName, prependName)
        shapes = [shapes] if isinstance(shapes, dict) else list(shapes)
        matrix = scipy.sparse.lil_matrix((3 * len(self.lattice.positions), len(shapes)))
        for column, shape in enumerate(shapes):
            for vertex, vector in shape.items():
                if isinstance(vertex, (bool, np.bool_)) or not isinstance(vertex, (int, np.integer)):
                    raise ValueError(f"shapes[{column}]: expected integers as vertices, got {vertex!r}")
                if not 0 <= vertex < len(self.lattice.positions):
                    raise ValueError(f"shapes[{column}]: there is no vertex {vertex}")
                vector = np.asarray(vector, dtype=float)
                if vector.shape != (3,) or not np.isfinite(vector).all():
                    raise ValueError(f"shapes[{column}]: expected 3 finite numbers for vertex {vertex}, got {vector}")
                matrix[3 * int(vertex):3 * int(vertex) + 3, column] = vector.reshape(3, 1)
        return self._add_local(name, matrix.tocsr(), lower, upper, scale, config)

    def addSpanwiseLocalDV(self, dvName, spanIndex, axis="y", lower=None, upper=None, scale=1.0, pointSelect=None,
                           volList=None, config=None):
        """Adds a variable for each line of vertices along a direction of a lattice that is a box; the vertices of a
        line move alike. Returns the number of variables.

        spanIndex : "i", "j" or "k": the direction of the lines
        axis : "x", "y" or "z": the direction in which they move
        """
        if volList is not None or pointSelect is not None:
            raise ValueError("pointSelect: lines go through the whole box; give addShapeFunctionDV() the shapes")
        lines = np.moveaxis(self.getLocalIndex(0), letter("spanIndex", spanIndex, "ijk"), -1)
        vector = np.eye(3)[letter("axis", axis, "xyz")]
        shapes = [{vertex: vector for vertex in line if not self._frozen[vertex]}
                  for line in lines.reshape(-1, lines.shape[-1])]
        return self.addShapeFunctionDV(dvName, [shape for shape in shapes if shape], lower, upper, scale, config)

    def getLocalIndex(self, iVol=0):
        """Returns the vertices of a lattice that is a box by their places in it: array (I, J, K) of int."""
        if iVol != 0:
            raise ValueError("iVol: the blocks are one lattice; choose vertices by their positions")
        return self.lattice.grid

    def _groups(self):
        """All groups of variables, of this lattice and then of its children."""
        groups = OrderedDict((*self.DV_listGlobal.items(), *self.DV_listLocal.items()))
        for child in self.children.values():
            groups.update(child._groups())
        return groups

    def getVarNames(self, pyOptSparse=False):
        """Returns the names of all groups of variables, of the children, too."""
        return list(self._groups())

    def getNDV(self):
        """Returns the number of all variables, of the children, too."""
        return sum(group.nVal for group in self._groups().values())

    def getValues(self):
        """Returns the values of all variables: dict from names to arrays, for setDesignVars()."""
        return {name: group.value.copy() for name, group in self._groups().items()}

    def setDesignVars(self, dvDict):
        """Sets variables. Names that are not variables of this lattice or its children are ignored.

        dvDict : dict from names to float or arrays. If one of them is wrong, none is set
        """
        checked = []
        for name, group in self._groups().items():
            if name not in dvDict:
                continue
            values = np.array(dvDict[name], dtype=float).ravel()
            if len(values) != group.nVal:
                raise ValueError(f"{name}: expected {group.nVal} values, got {len(values)}")
            if not np.isfinite(values).all():
                raise ValueError(f"{name}: expected finite numbers")
            checked.append((group, values))
        for group, values in checked:
            group.value = values
        self._changed()
        self._changed_below()

    def addVariablesPyOpt(self, optProb, globalVars=True, localVars=True, ignoreVars=(), freezeVars=(), **_):
        """Adds the variables to a problem of pyOptSparse, with bounds and scales.

        ignoreVars, freezeVars : list of names: groups to leave out, and groups to keep at their values
        """
        for name, group in self._groups().items():
            if name in ignoreVars or not (globalVars if isinstance(group, _Global) else localVars):
                continue
            frozen = name in freezeVars
            optProb.addVarGroup(name, group.nVal, "c", value=group.value.copy(), scale=group.scale,
                                lower=group.value.copy() if frozen else group.lower,
                                upper=group.value.copy() if frozen else group.upper)

    # Positions and derivatives.

    def positions(self, config=None):
        """Returns the vertices of the lattice for the variables as they are set: array (V, 3)."""
        return self._pose(self.lattice.positions, self._rest_nodes(), config)

    def _pose(self, rest, nodes, config):
        pose = np.array(rest)
        if self.axis:
            state = self._state(nodes, {name: group.value for name, group in self.DV_listGlobal.items()}, config)
            for name, part in self._ranges().items():
                chosen, axis = self._axes[name]
                pose[chosen] = axis.moved_to(rest[chosen], nodes[part]).positions(state[part])
        for group in self.DV_listLocal.values():
            if group.applies(config):
                pose += (group.matrix @ group.value).reshape(-1, 3)
        return pose

    def update(self, ptSetName, childDelta=True, config=None):
        """Returns the points for the variables as they are set: array (N, 3).

        ptSetName : name of the points; config : str, see addGlobalDV()
        """
        rest = self.lattice.positions
        moved = self.points[ptSetName] + self._displacements(ptSetName, rest, rest, self._rest_nodes(), config)
        self.updated[ptSetName] = True
        transfer = self._transfer.get(ptSetName)
        return moved if transfer is None else transfer(moved, mode="fwd", applyDisplacement=True)

    def _displacements(self, name, start, rest, nodes, config):
        """The displacements of points from where `start` has them, with this lattice and its axes at rest at `rest`
        and `nodes`, and of the children."""
        pose = self._pose(rest, nodes, config)
        change = self._bindings[name] @ (pose - start)
        for key, child in self.children.items():
            if name in child.points:
                places, deformation = self._carried[key]
                carried = places + deformation @ (pose - self.lattice.positions)
                count = len(child.lattice.positions)
                change = change + child._displacements(name, carried[:count], carried[:count], carried[count:], config)
        return change

    def writeTecplot(self, fileName, solutionTime=None):
        """Writes the lattice for the variables as they are set, as a .vtu for ParaView and Tecplot: the extension of
        fileName becomes .vtu. Returns the path."""
        path = pathlib.Path(fileName).with_suffix(".vtu")
        self.lattice.with_positions(self.positions()).write(path)
        return path
