#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Cells and faces of second order, judged by Gmsh and VTK.

    second_order_test.py FOLDER_OF_THE_PYTHON_MODULE

Gmsh's plugin AnalyseMeshQuality bounds the Jacobian determinant of each element by Bernstein coefficients. Of
pyramids it reports 0 where they are valid (4.8.4); for them Gmsh's own shape functions are sampled instead. VTK
gives the place of each point in its types of cells.
"""

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

try:
    import gmsh
    import vtk
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

import gmsh_agreement

sys.path.insert(0, sys.argv.pop())
import espalier  # noqa: E402  (the path comes first)

# The types of Gmsh and their names.
KINDS = {9: "triangle of 6", 10: "quadrangle of 9", 16: "quadrangle of 8", 11: "tetrahedron of 10",
         12: "hexahedron of 27", 17: "hexahedron of 20", 13: "prism of 18", 18: "prism of 15",
         14: "pyramid of 14", 19: "pyramid of 13"}
PYRAMIDS = (14, 19)
POSES = 500


def write_gmsh(path, element, points):
    """Writes one element for each row of points (elements, nodes, 3)."""
    count, nodes = points.shape[:2]
    with open(path, "w") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{count * nodes}\n")
        for i, (x, y, z) in enumerate(points.reshape(-1, 3)):
            file.write(f"{i + 1} {x!r} {y!r} {z!r}\n")
        file.write(f"$EndNodes\n$Elements\n{count}\n")
        for i in range(count):
            numbers = " ".join(str(i * nodes + k + 1) for k in range(nodes))
            file.write(f"{i + 1} {element} 2 1 1 {numbers}\n")
        file.write("$EndElements\n")


def element_properties(element):
    """The dimension of a type of elements, and the places of its nodes."""
    _, dimension, _, nodes, places, _ = gmsh.model.mesh.getElementProperties(element)
    return dimension, np.reshape(places, (nodes, dimension))


def smallest_determinants(element, dimension, path):
    """The smallest determinant of each element of a file."""
    gmsh.open(str(path))
    if element in PYRAMIDS:
        steps = np.linspace(-1, 1, 29)
        places = [(x * (1 - z), y * (1 - z), z) for z in np.linspace(0, 0.999, 15) for x in steps for y in steps]
        _, determinants, _ = gmsh.model.mesh.getJacobians(element, np.ravel(places))
        return np.reshape(determinants, (POSES, -1)).min(axis=1)
    for name, value in {"JacobianDeterminant": 1, "CreateView": 1, "DimensionOfElements": dimension}.items():
        gmsh.plugin.setNumber("AnalyseMeshQuality", name, value)
    gmsh.plugin.run("AnalyseMeshQuality")
    for view in gmsh.view.getTags():
        kind, tags, values, *_ = gmsh.view.getModelData(view, 0)
        if kind == "ElementData" and len(tags) == POSES:
            return np.array([value[0] for value in values])
    raise AssertionError("Gmsh made no view of determinants")


def write_ball(path, dimension, options):
    """A ball or a disk with a hole, of second order, with curved edges."""
    gmsh.model.add("ball")
    if dimension == 3:
        gmsh.model.occ.addSphere(0, 0, 0, 1)
        gmsh.model.occ.addSphere(0.1, 0, 0, 0.4)
        gmsh.model.occ.cut([(3, 1)], [(3, 2)])
    else:
        gmsh.model.occ.addDisk(0, 0, 0, 1, 0.7)
        gmsh.model.occ.addDisk(0.1, 0, 0, 0.3, 0.3)
        gmsh.model.occ.cut([(2, 1)], [(2, 2)])
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.CharacteristicLengthMin", 0.5 if dimension == 3 else 0.2)
    gmsh.option.setNumber("Mesh.CharacteristicLengthMax", 0.5 if dimension == 3 else 0.2)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    if options:
        gmsh.option.setNumber(*options)
    gmsh.model.mesh.generate(dimension)
    gmsh.model.mesh.setOrder(2)
    # A group, because a file without groups has the elements of all dimensions.
    gmsh.model.addPhysicalGroup(dimension, [tag for _, tag in gmsh.model.getEntities(dimension)])
    gmsh.write(str(path))


class SecondOrder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_gmsh_finds_the_same_folded_elements(self):
        random = np.random.default_rng(20261129)
        for element, name in KINDS.items():
            with self.subTest(name):
                dimension, places = gmsh_agreement.in_gmsh(element_properties, element)
                straight = np.zeros((len(places), 3))
                straight[:, :dimension] = places
                rest = straight + 4 * np.arange(POSES)[:, None, None] * [1, 0, 0]
                noise = random.uniform(-1, 1, rest.shape) * np.linspace(0.02, 0.35, POSES)[:, None, None]
                noise[:, :, dimension:] = 0
                pose = rest + noise
                write_gmsh(self.folder / "rest.msh", element, rest)
                write_gmsh(self.folder / "pose.msh", element, pose)
                check = espalier.MeshCheck(espalier.read_model(self.folder / "rest.msh"))
                self.assertEqual(len(check.bad_at_rest), 0)
                ours = np.zeros(POSES, bool)
                ours[check.check(pose.reshape(-1, 3)).inverted] = True
                smallest = gmsh_agreement.in_gmsh(smallest_determinants, element, dimension, self.folder / "pose.msh")
                self.assertTrue(10 < ours.sum() < POSES - 10, ours.sum())
                # Samples miss folds that are smaller than their distance; they never find one too many.
                self.assertFalse(np.any(~ours & (smallest <= 0)))
                missed = ours & (smallest > 0)
                if element in PYRAMIDS:
                    self.assertTrue(np.all(smallest[missed] < 0.01), smallest[missed])
                else:
                    self.assertEqual(missed.sum(), 0)
                print(f"{name}: {POSES} poses, {ours.sum()} folded, {missed.sum()} missed by samples")

    def test_gmsh_finds_the_same_folded_elements_of_whole_meshes(self):
        poses = 12
        for name, dimension, largest, options in (
                ("tetrahedra", 3, 0.6, ()), ("hexahedra", 3, 0.6, ("Mesh.SubdivisionAlgorithm", 2)),
                ("triangles", 2, 0.8, ()), ("quadrangles", 2, 0.8, ("Mesh.SubdivisionAlgorithm", 1))):
            with self.subTest(name):
                path = self.folder / f"{name}.msh"
                gmsh_agreement.in_gmsh(write_ball, path, dimension, options)
                _, types, bad, folds, folded, differences = gmsh_agreement.compare(espalier, path, poses, largest=largest)
                self.assertEqual(differences, [])
                # Both find the same elements folded at rest, where curved edges meet thin elements.
                self.assertEqual(len(types), 1)
                self.assertLess(bad, sum(types.values()) // 10)
                self.assertTrue(0 < folds < poses, folds)
                print(f"{name}: {types}, {poses} poses, {folds} fold {folded} elements")

    def test_the_points_of_vtk_are_where_vtk_has_them(self):
        for number in (22, 23, 28, 24, 25, 29, 26, 32, 27):
            with self.subTest(vtk.vtkCellTypes.GetClassNameFromTypeId(number)):
                cell = vtk.vtkGenericCell()
                cell.SetCellType(number)
                count = cell.GetNumberOfPoints()
                places = np.reshape([cell.GetParametricCoords()[i] for i in range(3 * count)], (count, 3)) \
                    if cell.GetParametricCoords() else None
                grid = vtk.vtkUnstructuredGrid()
                points = vtk.vtkPoints()
                points.SetDataTypeToDouble()
                for place in places:
                    points.InsertNextPoint(*place)
                grid.SetPoints(points)
                grid.InsertNextCell(number, count, list(range(count)))
                writer = vtk.vtkXMLUnstructuredGridWriter()
                writer.SetFileName(str(self.folder / "a.vtu"))
                writer.SetInputData(grid)
                writer.Write()
                check = espalier.MeshCheck(espalier.read_model(self.folder / "a.vtu"))
                self.assertEqual((check.cell_count, check.not_checked, len(check.bad_at_rest)), (1, {}, 0))
                # An affine map has the same determinant everywhere, if each point is where VTK has it.
                axes = np.array([[1, 0.5, 0], [-0.25, 1, 0], [0.25, 0, 2 if cell.GetCellDimension() == 3 else 1]])
                determinant = np.linalg.det(axes)
                self.assertAlmostEqual(check.check(places @ axes).smallest[1], determinant, delta=1e-9)


if __name__ == "__main__":
    unittest.main()
