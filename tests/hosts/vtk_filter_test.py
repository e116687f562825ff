#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The VTK filter (hosts/vtk) gives what the program gives. Skipped without VTK's Python module.

    vtk_filter_test.py PATH_OF_ESPALIER FOLDER_OF_THE_PYTHON_MODULE
"""

import contextlib
import io
import pathlib
import sys
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TOP / "tests/cli"), str(TOP / "hosts/vtk"), *sys.argv[2:3]]
import program  # noqa: E402
from program import CliTest  # noqa: E402

try:
    import vtkmodules.vtkIOXML as vtk_io
    from vtkmodules.vtkFiltersSources import vtkSphereSource
    from vtkmodules.vtkCommonCore import vtkIdList, vtkObject
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
    from vtkmodules.util import numpy_support
    import numpy as np
    from espalier_vtk import EspalierDeform
    MISSING = None
except ImportError as error:
    MISSING = str(error)


@unittest.skipIf(MISSING, MISSING)
class VtkFilter(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "cylinder", "--sectors", 5, "--core", "polygon", "--layers", 2, "-o",
                         "rest.vtu")
        self.run_program("pose", "rest.vtu", "--twist", "z", 50, "--move", 0.1, 0.2, 0.3, "-o", "pose.vtu")

    def read(self, name):
        reader = (vtk_io.vtkXMLPolyDataReader if name.endswith(".vtp") else vtk_io.vtkXMLUnstructuredGridReader)()
        reader.SetFileName(str(self.path / name))
        reader.Update()
        return reader.GetOutput()

    def write(self, name, data, writer):
        writer.SetFileName(str(self.path / name))
        writer.SetInputData(data)
        writer.Write()

    def positions(self, data):
        return numpy_support.vtk_to_numpy(data.GetPoints().GetData()).astype(float)

    def filter(self, model, **settings):
        deform = EspalierDeform()
        for port, data in enumerate((model, self.read("rest.vtu"), self.read("pose.vtu"))):
            deform.SetInputDataObject(port, data)
        for name, value in settings.items():
            getattr(deform, "Set" + name)(value)
        deform.Update()
        return deform

    def test_a_volume_gives_what_the_program_gives(self):
        """A mesh of polyhedra, which keeps its cells and arrays."""
        self.run_program("refine", "rest.vtu", "-n", 2, "-o", "model.vtu")
        for settings, options in (({"Level": 3}, ["-n", 3]), ({"Limit": True}, ["--limit"]),
                                  ({"Level": 1, "Outside": "nearest"}, ["-n", 1, "--outside", "nearest"])):
            self.run_program("deform", "model.vtu", "--rest", "rest.vtu", "--to", "pose.vtu", *options, "-o",
                             "out.vtu", "--quiet")
            expected = self.positions(self.read("out.vtu"))
            deform = self.filter(self.read("model.vtu"), **settings)
            output = deform.GetOutputDataObject(0)
            self.assertIsInstance(output, vtkUnstructuredGrid)
            self.assertEqual(output.GetNumberOfCells(), self.read("model.vtu").GetNumberOfCells())
            # Kernels for different numbers of rows add in different orders.
            self.assertLess(np.abs(self.positions(output) - expected).max(), 1e-14)
            self.assertEqual(output.GetPointData().GetArray("espalier_status").GetNumberOfTuples(),
                             len(expected))

    def test_a_surface_of_floats_stays_one(self):
        source = vtkSphereSource()
        source.SetRadius(0.4)
        source.SetCenter(0, 0, 0.5)
        source.Update()
        output = self.filter(source.GetOutput()).GetOutputDataObject(0)
        self.assertEqual(output.GetClassName(), "vtkPolyData")
        self.assertEqual(output.GetPoints().GetDataType(), source.GetOutput().GetPoints().GetDataType())
        self.assertEqual(output.GetNumberOfPolys(), source.GetOutput().GetNumberOfPolys())
        self.assertIsNotNone(output.GetPointData().GetArray("Normals"))

    def test_normals_of_points_turn_as_in_the_program(self):
        source = vtkSphereSource()
        source.SetRadius(0.4)
        source.SetCenter(0, 0, 0.5)
        source.Update()
        self.write("sphere.vtp", source.GetOutput(), vtk_io.vtkXMLPolyDataWriter())
        self.run_program("deform", "sphere.vtp", "--rest", "rest.vtu", "--to", "pose.vtu", "-o", "out.vtp",
                         "--quiet")
        normals = lambda data: numpy_support.vtk_to_numpy(data.GetPointData().GetNormals())
        expected = normals(self.read("out.vtp"))
        deform = self.filter(self.read("sphere.vtp"))
        turned = normals(deform.GetOutputDataObject(0))
        # Both round to floats.
        self.assertLess(np.abs(turned - expected).max(), 1e-7)
        at_rest = normals(self.read("sphere.vtp"))
        self.assertGreater(np.abs(turned - at_rest).max(), 0.01)
        deform.SetKeepNormals(True)
        deform.Update()
        np.testing.assert_array_equal(normals(deform.GetOutputDataObject(0)), at_rest)

    def test_a_new_pose_keeps_the_binding(self):
        self.run_program("refine", "rest.vtu", "-n", 1, "-o", "model.vtu")
        deform = self.filter(self.read("model.vtu"))
        binding = deform.GetBinding()
        moved = self.read("rest.vtu")
        deform.SetInputDataObject(2, moved)
        deform.Update()
        self.assertIs(deform.GetBinding(), binding)
        np.testing.assert_array_equal(self.positions(deform.GetOutputDataObject(0)),
                                      self.positions(self.read("model.vtu")))
        deform.SetLevel(2)
        deform.Update()
        self.assertIsNot(deform.GetBinding(), binding)

    def assert_error(self, deform, expected):
        """The output is empty, and GetError() says why."""
        output = deform.GetOutputDataObject(0)
        self.assertEqual((output.GetNumberOfPoints(), output.GetNumberOfCells()), (0, 0))
        self.assertRegex(deform.GetError(), expected)

    def test_an_error_leaves_an_empty_output(self):
        """VTK prints the error; the model must not pass as deformed."""
        self.run_program("refine", "rest.vtu", "-n", 1, "-o", "model.vtu")
        model, rest = self.read("model.vtu"), self.read("rest.vtu")
        self.run_program("shape", "cube", "-o", "cube.vtu")
        with self.printed_errors():
            deform = self.filter(model, Level=99)
            self.assert_error(deform, "level")
            # A correct input after an error.
            deform.SetLevel(2)
            deform.Update()
            self.assertIsNone(deform.GetError())
            good = self.positions(deform.GetOutputDataObject(0))
            self.assertEqual(len(good), model.GetNumberOfPoints())
            # A lattice that does not hold the model, and the first lattice again.
            deform.SetOutside("error")
            deform.SetInputDataObject(1, self.read("cube.vtu"))
            deform.SetInputDataObject(2, self.read("cube.vtu"))
            deform.Update()
            self.assert_error(deform, "outside")
            deform.SetOutside("keep")
            deform.SetInputDataObject(1, rest)
            deform.SetInputDataObject(2, self.read("pose.vtu"))
            deform.Update()
            np.testing.assert_array_equal(self.positions(deform.GetOutputDataObject(0)), good)

    def test_a_pose_with_other_cells_is_refused(self):
        self.run_program("refine", "rest.vtu", "-n", 1, "-o", "model.vtu")
        deform = self.filter(self.read("model.vtu"))
        rest = self.read("rest.vtu")
        fewer = vtkUnstructuredGrid()
        fewer.SetPoints(rest.GetPoints())
        import espalier_vtk
        for cell in espalier_vtk.cells_of(rest)[1:]:
            self.insert_polyhedron(fewer, cell)
        other = vtkUnstructuredGrid()
        other.SetPoints(rest.GetPoints())
        for cell in espalier_vtk.cells_of(rest)[::-1]:
            self.insert_polyhedron(other, cell)
        with self.printed_errors():
            for pose in (fewer, other):
                self.assertEqual(pose.GetNumberOfPoints(), rest.GetNumberOfPoints())
                deform.SetInputDataObject(2, pose)
                deform.Update()
                self.assert_error(deform, "the cells of the pose are not the cells of the lattice at rest")
        # The same cells, written in another way.
        same = vtkUnstructuredGrid()
        same.SetPoints(rest.GetPoints())
        for cell in espalier_vtk.cells_of(rest):
            self.insert_polyhedron(same, cell)
        deform.SetInputDataObject(2, same)
        deform.Update()
        self.assertIsNone(deform.GetError())

    def insert_polyhedron(self, grid, cell):
        stream = vtkIdList()
        for number in (len(cell), *(number for loop in cell for number in (len(loop), *loop))):
            stream.InsertNextId(number)
        grid.InsertNextCell(42, stream)

    @contextlib.contextmanager
    def printed_errors(self):
        """Keeps VTK's messages out of the output of the test."""
        vtkObject.GlobalWarningDisplayOff()
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                yield
        finally:
            vtkObject.GlobalWarningDisplayOn()

    def test_a_mesh_without_cells_of_a_volume_is_no_lattice(self):
        import espalier_vtk
        grid = vtkUnstructuredGrid()
        with self.assertRaisesRegex(ValueError, "the lattice has no cells of a volume"):
            espalier_vtk.lattice_of(grid)


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    sys.argv[1:] = sys.argv[2:]
    unittest.main()
