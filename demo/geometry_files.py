# SPDX-License-Identifier: Apache-2.0
"""Reads models (.obj) and lattices (.vtu) for the pictures, as VTK objects."""

import pathlib

import numpy as np
import vtk
from vtk.util import numpy_support

CLAY = (0.80, 0.77, 0.72)


def read_model(path):
    """Returns the faces of an OBJ file as vtkPolyData with smooth normals. Cells have the colour Kd
    of their material, or a clay colour if they have none."""
    if not pathlib.Path(path).is_file():
        raise SystemExit(f"{path}: no such file")
    folder = pathlib.Path(path).parent
    points, faces, colours, known, colour = [], [], [], {}, CLAY
    with open(path, encoding="utf-8") as file:
        for line in file:
            word, _, rest = line.partition(" ")
            if word == "v":
                points.append(rest.split()[:3])
            elif word == "f":
                faces.append([int(corner.partition("/")[0]) for corner in rest.split()])
                colours.append(colour)
            elif word == "usemtl":
                colour = known.get(rest.strip(), CLAY)
            elif word == "mtllib":
                known.update(read_materials(folder / rest.strip()))
    if not faces:
        raise SystemExit(f"{path}: not an .obj file with faces")
    count = len(points)
    loops = [[v - 1 if v > 0 else count + v for v in face] for face in faces]
    model = surface(np.array(points, float), loops)
    scalars = numpy_support.numpy_to_vtk((np.array(colours) * 255).astype(np.uint8), deep=1)
    model.GetCellData().SetScalars(scalars)
    return with_normals(model)


def with_normals(data):
    """The same polygons with smooth normals at their points."""
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SplittingOff()
    normals.ConsistencyOff()
    normals.Update()
    return normals.GetOutput()


def read_materials(path):
    materials, name = {}, None
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            words = line.split()
            if words[:1] == ["newmtl"]:
                name = words[1]
            elif words[:1] == ["Kd"]:
                materials[name] = tuple(float(w) for w in words[1:4])
    return materials


def vtk_points(points):
    vertices = vtk.vtkPoints()
    vertices.SetData(numpy_support.numpy_to_vtk(np.ascontiguousarray(points), deep=1))
    return vertices


def surface(points, loops):
    """vtkPolyData of polygons."""
    data = vtk.vtkPolyData()
    data.SetPoints(vtk_points(points))
    stream = np.array([v for loop in loops for v in (len(loop), *loop)], np.int64)
    cells = vtk.vtkCellArray()
    cells.ImportLegacyFormat(numpy_support.numpy_to_vtkIdTypeArray(stream, deep=1))
    data.SetPolys(cells)
    return data


def points_of(shown):
    """The points of a model or a lattice, n × 3."""
    if isinstance(shown, LatticeFile):
        return shown.points
    return numpy_support.vtk_to_numpy(shown.GetPoints().GetData()).astype(float)


class LatticeFile:
    """A lattice to draw: points, cells (each a list of faces), edges (pairs of points) with their
    strata, and the faces of its boundary.

    Strata are as in MacCracken & Joy 1996, figure 5: 0 corner, 1 sharp, 2 boundary, 3 inside. An
    edge in a single cell is sharp, on every level, unless marks in the file change that.
    """

    def __init__(self, path):
        if not pathlib.Path(path).is_file():
            raise SystemExit(f"{path}: no such file")
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
        if grid.GetNumberOfCells() == 0:
            raise SystemExit(f"{path}: not a readable .vtu file, or one without cells")
        self.points = numpy_support.vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
        self.cells = [cell_faces(grid, cell) for cell in range(grid.GetNumberOfCells())]
        self.boundary = boundary_of(self.cells)
        self._find_edges(edge_marks(grid))
        self._find_point_strata(grid)

    def _find_edges(self, marks):
        count = {}
        for faces in self.cells:
            for edge in edges_of(faces):
                count[edge] = count.get(edge, 0) + 1
        outer = edges_of(self.boundary)
        edges = sorted(count)
        self.edges = np.array(edges)
        self.edge_strata = np.array([
            3 if edge not in outer else 1 if marks.get(edge, count[edge] == 1) else 2
            for edge in edges])

    def _find_point_strata(self, grid):
        """A point is sharp if it is on two sharp edges, and a corner if on more, or in one cell."""
        count = len(self.points)
        sharp_edges = np.bincount(self.edges[self.edge_strata == 1].ravel(), minlength=count)
        point_cells = np.zeros(count, int)
        for faces in self.cells:
            point_cells[list({v for face in faces for v in face})] += 1
        outer = np.zeros(count, bool)
        outer[[v for face in self.boundary for v in face]] = True
        single = point_cells == 1
        stored = grid.GetPointData().GetArray("espalier:vertex_sharpness")
        if stored is not None:
            marks = numpy_support.vtk_to_numpy(stored)
            single = np.where(marks < 0, single, marks > 0)
        self.point_strata = np.where(outer, np.where(sharp_edges == 2, 1, 2), 3)
        self.point_strata[single | (sharp_edges > 2)] = 0


def boundary_of(cells):
    """Returns the faces that belong to one cell only."""
    loops, count = {}, {}
    for face in (face for faces in cells for face in faces):
        key = tuple(sorted(face))
        loops[key] = face
        count[key] = count.get(key, 0) + 1
    return [loops[key] for key, cells_of_face in count.items() if cells_of_face == 1]


def edges_of(loops):
    """The edges of loops of points, each with the lower number first."""
    return {(min(a, b), max(a, b)) for loop in loops for a, b in zip(loop, loop[1:] + loop[:1])}


def edge_marks(grid):
    """Returns for each marked edge of the file if it is sharp."""
    pairs, sharpness = (grid.GetFieldData().GetArray("espalier:edge_" + name)
                        for name in ("vertices", "sharpness"))
    if pairs is None or sharpness is None:
        return {}
    return {(min(a, b), max(a, b)): s > 0
            for (a, b), s in zip(numpy_support.vtk_to_numpy(pairs).reshape(-1, 2).tolist(),
                                 numpy_support.vtk_to_numpy(sharpness).tolist())}


def cell_faces(grid, index):
    """The faces of a cell as lists of points. VTK's edge filter would triangulate polyhedra."""
    if grid.GetCellType(index) == vtk.VTK_POLYHEDRON:
        stream = vtk.vtkIdList()
        grid.GetFaceStream(index, stream)
        faces, at = [], 1
        for _ in range(stream.GetId(0)):
            size = stream.GetId(at)
            faces.append([stream.GetId(at + 1 + i) for i in range(size)])
            at += size + 1
        return faces
    cell = grid.GetCell(index)
    faces = []
    for i in range(cell.GetNumberOfFaces()):
        ids = cell.GetFace(i).GetPointIds()
        faces.append([ids.GetId(k) for k in range(ids.GetNumberOfIds())])
    return faces
