# SPDX-License-Identifier: Apache-2.0
"""A filter for VTK and ParaView that deforms points by a lattice of Espalier.

    from espalier_vtk import EspalierDeform

    deform = EspalierDeform()
    deform.SetInputDataObject(0, model)        # any vtkPointSet: a surface, a volume mesh, a curvilinear grid
    deform.SetInputDataObject(1, rest)         # the lattice at rest: a vtkUnstructuredGrid around the model
    deform.SetInputDataObject(2, pose)         # the same lattice with its points moved
    deform.SetLevel(3)                         # or SetLimit(True)
    deform.Update()
    moved = deform.GetOutputDataObject(0)

The output is the model with moved points; its active normals and tangents of points turn with it, unless
SetKeepNormals(True). Normals of cells are left out, since they would be wrong. Its point data has the array "espalier_status": 0 for points inside
the lattice, 1 for points outside, 2 for points that could not be placed. The binding is kept: a new pose
costs one sparse product.

VTK lets no exception out of Update(): on an error it prints the error, and the output is empty. GetError()
returns the message of the last update, and None if there was no error.

The file is also a plugin of ParaView (Tools > Manage Plugins > Load New); then the filter "Espalier Deform" is in
the menu Filters, and EspalierDeform() is in paraview.simple. Python must find the modules espalier and numpy.
"""

import numpy as np
from vtkmodules.util import numpy_support
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkPointSet, vtkUnstructuredGrid

import espalier

# The faces of VTK's cells, and the order of a voxel's points as a hexahedron.
LOOPS = {
    10: ((0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)),
    12: ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)),
    13: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    14: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
VOXEL, HEXAHEDRON, POLYHEDRON = 11, 12, 42
VOXEL_ORDER = (0, 1, 3, 2, 4, 5, 7, 6)


def positions_of(points):
    """Returns the positions of a vtkPointSet: array (N, 3) of float64."""
    if points.GetNumberOfPoints() == 0:
        return np.zeros((0, 3))
    return numpy_support.vtk_to_numpy(points.GetPoints().GetData()).astype(np.float64)


def cells_of(grid):
    """Returns the volume cells of a grid as loops of points. Other cells are skipped.

    Raises a ValueError for a volume cell that is not of the types 10 to 14 and 42."""
    from vtkmodules.vtkCommonCore import vtkIdList
    cells = []
    numbers = vtkIdList()
    for cell in range(grid.GetNumberOfCells()):
        kind = grid.GetCellType(cell)
        if kind == POLYHEDRON:
            grid.GetFaceStream(cell, numbers)
            stream = [numbers.GetId(i) for i in range(numbers.GetNumberOfIds())]
            loops, at = [], 1
            for _ in range(stream[0]):
                loops.append(stream[at + 1:at + 1 + stream[at]])
                at += 1 + stream[at]
            cells.append(loops)
            continue
        if grid.GetCell(cell).GetCellDimension() < 3:
            continue
        grid.GetCellPoints(cell, numbers)
        points = [numbers.GetId(i) for i in range(numbers.GetNumberOfIds())]
        if kind == VOXEL:
            kind, points = HEXAHEDRON, [points[i] for i in VOXEL_ORDER]
        if kind not in LOOPS:
            raise ValueError(f"the lattice: cell {cell} is of VTK's type {kind}; expected 10, 11, 12, 13, 14 "
                             "or 42")
        cells.append([[points[i] for i in loop] for loop in LOOPS[kind]])
    return cells


def lattice_of(grid):
    """Returns a lattice and the numbers of its points in the grid. Points that no cell uses are left out."""
    cells = cells_of(grid)
    if not cells:
        raise ValueError("the lattice has no cells of a volume")
    used = sorted({point for cell in cells for loop in cell for point in loop})
    number = {point: i for i, point in enumerate(used)}
    cells = [[[number[point] for point in loop] for loop in cell] for cell in cells]
    return espalier.Lattice(positions_of(grid)[used], cells), used


def have_same_cells(one, other):
    """Returns True if two grids have the same volume cells, in the same order. Costs little if VTK stores the
    cells of both in the same way."""
    def arrays(grid):
        cells = grid.GetCells()
        stored = (grid.GetCellTypesArray(), cells.GetOffsetsArray(), cells.GetConnectivityArray(), grid.GetFaces())
        return [np.zeros(0) if array is None else numpy_support.vtk_to_numpy(array) for array in stored]

    if 0 not in (one.GetNumberOfCells(), other.GetNumberOfCells()) and all(
            np.array_equal(a, b) for a, b in zip(arrays(one), arrays(other))):
        return True
    return cells_of(one) == cells_of(other)


def directions_of(model):
    """Returns the active normals and tangents of the points: the array, the function that turns it, and the
    method that makes an array the active one."""
    data = model.GetPointData()
    known = ((data.GetNormals(), espalier.carry_normals, "SetNormals"),
             (data.GetTangents(), espalier.carry_tangents, "SetTangents"))
    return [each for each in known if each[0] is not None and each[0].GetNumberOfComponents() == 3]


class EspalierDeform(VTKPythonAlgorithmBase):
    """Moves the points of a model as a lattice around it moves."""

    def __init__(self):
        super().__init__(nInputPorts=3, nOutputPorts=1, outputType="vtkPointSet")
        self._level = 3
        self._limit = False
        self._outside = "keep"
        self._keep_normals = False
        self._binding = None
        self._bound_to = None  # what the binding depends on
        self._error = None

    def FillInputPortInformation(self, port, information):
        information.Set(self.INPUT_REQUIRED_DATA_TYPE(), "vtkPointSet" if port == 0 else "vtkUnstructuredGrid")
        return 1

    def RequestDataObject(self, request, inputs, outputs):
        model = vtkPointSet.GetData(inputs[0])
        output = outputs.GetInformationObject(0)
        current = output.Get(vtkPointSet.DATA_OBJECT())
        if model is not None and (current is None or current.GetClassName() != model.GetClassName()):
            output.Set(vtkPointSet.DATA_OBJECT(), model.NewInstance())
        return 1

    def SetLevel(self, level):
        """Sets how many times the lattice is refined, 1 to 15."""
        self._set("_level", int(level))

    def GetLevel(self):
        return self._level

    def SetLimit(self, limit):
        """Sets whether to bind to the limit of refinement instead of a level."""
        self._set("_limit", bool(limit))

    def GetLimit(self):
        return self._limit

    def SetOutside(self, outside):
        """Sets what happens to points outside the lattice: "keep", "nearest" or "error"."""
        self._set("_outside", str(outside))

    def GetOutside(self):
        return self._outside

    def SetKeepNormals(self, keep):
        """Sets whether normals and tangents stay as they are."""
        self._set("_keep_normals", bool(keep))

    def GetKeepNormals(self):
        return self._keep_normals

    def GetBinding(self):
        """Returns the espalier.Binding of the last update; None before."""
        return self._binding

    def GetError(self):
        """Returns the message of the error of the last update; None if there was none."""
        return self._error

    def _set(self, name, value):
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    def RequestData(self, request, inputs, outputs):
        self._error = None
        try:
            self._deform(vtkPointSet.GetData(inputs[0]),
                         *(vtkUnstructuredGrid.GetData(inputs[port]) for port in (1, 2)),
                         vtkPointSet.GetData(outputs))
        except Exception as error:
            self._error = str(error)
            raise
        return 1

    def _bind(self, points, rest, gradients, key):
        """Binds the points to the lattice, unless they are bound to it already."""
        if key == self._bound_to:
            return
        lattice, used = lattice_of(rest)
        options = {"limit": True} if self._limit else {"level": self._level}
        binding = espalier.bind(lattice, points, outside=self._outside, gradients=gradients, **options)
        self._used, self._binding, self._bound_to = used, binding, key

    def _deform(self, model, rest, pose, output):
        """Fills the output, or raises an error before it does."""
        points = positions_of(model)
        directions = [] if self._keep_normals else directions_of(model)
        self._bind(points, rest, bool(directions),
                   (model.GetPoints().GetMTime() if len(points) else 0, rest.GetMTime(),
                    self._level, self._limit, self._outside, bool(directions)))
        if pose.GetNumberOfPoints() != rest.GetNumberOfPoints():
            raise ValueError(f"the pose has {pose.GetNumberOfPoints()} points; the lattice at rest has "
                             f"{rest.GetNumberOfPoints()}")
        if not have_same_cells(rest, pose):
            raise ValueError("the cells of the pose are not the cells of the lattice at rest; move the points "
                             "of the lattice at rest to make a pose")
        posed = positions_of(pose)[self._used]
        moved = self._binding.deform(posed)
        statuses = numpy_support.numpy_to_vtk(np.asarray(self._binding.statuses, dtype=np.uint8), deep=True)
        statuses.SetName("espalier_status")
        output.ShallowCopy(model)
        if len(points):
            moved_points = vtkPoints()
            moved_points.SetDataType(model.GetPoints().GetDataType())
            array = numpy_support.numpy_to_vtk(moved, deep=True, array_type=model.GetPoints().GetDataType())
            array.SetName("Points")
            moved_points.SetData(array)
            output.SetPoints(moved_points)
        output.GetPointData().AddArray(statuses)
        if directions:
            gradients = self._binding.gradients(posed)
        for array, carry, activate in directions:
            turned = numpy_support.numpy_to_vtk(carry(gradients, numpy_support.vtk_to_numpy(array)), deep=True,
                                                array_type=array.GetDataType())
            turned.SetName(array.GetName())
            getattr(output.GetPointData(), activate)(turned)
        if not self._keep_normals and output.GetCellData().GetNormals() is not None:
            output.GetCellData().RemoveArray(output.GetCellData().GetNormals().GetName())


try:
    from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
except ImportError:
    pass
else:
    @smproxy.filter(name="EspalierDeform", label="Espalier Deform")
    @smhint.xml('<ShowInMenu category="Alphabetical"/>')
    @smproperty.input(name="Pose", port_index=2)
    @smdomain.datatype(dataTypes=["vtkUnstructuredGrid"], composite_data_supported=False)
    @smproperty.input(name="Rest", port_index=1)
    @smdomain.datatype(dataTypes=["vtkUnstructuredGrid"], composite_data_supported=False)
    @smproperty.input(name="Input", port_index=0)
    @smdomain.datatype(dataTypes=["vtkPointSet"], composite_data_supported=False)
    class ParaViewEspalierDeform(EspalierDeform):
        """The filter with the properties that ParaView shows."""

        @smproperty.intvector(name="Level", default_values=3)
        @smdomain.intrange(min=1, max=15)
        def SetLevel(self, level):
            super().SetLevel(level)

        @smproperty.xml('<IntVectorProperty name="Limit" command="SetLimit" number_of_elements="1" '
                        'default_values="0"><BooleanDomain name="bool"/></IntVectorProperty>')
        def SetLimit(self, limit):
            super().SetLimit(limit)

        @smproperty.xml('<IntVectorProperty name="KeepNormals" command="SetKeepNormals" number_of_elements="1" '
                        'default_values="0"><BooleanDomain name="bool"/></IntVectorProperty>')
        def SetKeepNormals(self, keep):
            super().SetKeepNormals(keep)

        @smproperty.xml('<StringVectorProperty name="Outside" command="SetOutside" number_of_elements="1" '
                        'default_values="keep"><StringListDomain name="list"><String value="keep"/>'
                        '<String value="nearest"/><String value="error"/></StringListDomain>'
                        '</StringVectorProperty>')
        def SetOutside(self, outside):
            super().SetOutside(outside)
