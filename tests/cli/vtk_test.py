#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Models that VTK writes are deformed with their normals, and VTK reads models that Espalier converts.
Skipped if there is no VTK.

    vtk_test.py PATH_OF_ESPALIER
"""

import unittest

import sys

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None

import program
from program import CliTest

# A pentagon that is not convex, a square and a triangle, with one normal for each point.
FIGURE = """v 0 0 0
v 0.5 0.25 0
v 1 0 0
v 1 1 0
v 0 1 0
v 1 2 0
v 0 2 0
v 0.5 3 0.1
vn 0 0 1
vn 0 0.6 0.8
f 1//1 2//1 3//1 4//1 5//1
f 5//1 4//1 6//2 7//2
f 7//2 6//2 8//2
"""
LOOPS = [[0, 1, 2, 3, 4], [4, 3, 5, 6], [6, 5, 7]]


@unittest.skipUnless(vtk, "VTK is not installed")
class Vtk(CliTest):
    def path_of(self, name):
        return str(self.path / name)

    def read(self, reader, name):
        reader.SetFileName(self.path_of(name))
        reader.Update()
        self.assertEqual(reader.GetErrorCode(), 0)
        return reader.GetOutput()

    def quarter_turn(self):
        """Makes a box around the ball of radius 1, and its pose: a quarter turn about z."""
        self.run_program("shape", "box", "--min", -2, -2, -2, "--max", 2, 2, 2, "-o", "rest.ovm")
        self.write_pose("pose.ovm", "rest.ovm", lambda p: (-p[1], p[0], p[2]))

    def ball(self, is_grid, precision):
        source = vtk.vtkSphereSource()
        source.SetThetaResolution(7)
        source.SetPhiResolution(5)
        source.SetOutputPointsPrecision(precision)
        strips = vtk.vtkStripper()  # VTK writes strips and triangles into separate sections
        strips.SetInputConnection(source.GetOutputPort())
        strips.SetMaximumLength(3)
        strips.Update()
        if not is_grid:
            return strips.GetOutput()
        grid = vtk.vtkAppendFilter()
        grid.AddInputData(source.GetOutput())
        grid.Update()
        return grid.GetOutput()

    def assert_turned(self, before, after):
        for name, points in (("points", lambda d: d.GetPoints().GetData()),
                             ("normals", lambda d: d.GetPointData().GetNormals())):
            old, new = vtk_to_numpy(points(before)), vtk_to_numpy(points(after))
            self.assertEqual(old.dtype, new.dtype, name)
            # Float32 has 2^-24 = 6e-8, and the coordinates are below 1.
            bound = 1e-7 if old.dtype == "float32" else 1e-14
            self.assertLess(abs(new - old[:, [1, 0, 2]] * (-1, 1, 1)).max(), bound, name)

    def test_normals_that_vtk_writes_are_carried(self):
        self.quarter_turn()
        writers = [(vtk.vtkPolyDataWriter, vtk.vtkPolyDataReader, False, "vtk"),
                   (vtk.vtkUnstructuredGridWriter, vtk.vtkUnstructuredGridReader, True, "vtk"),
                   (vtk.vtkXMLPolyDataWriter, vtk.vtkXMLPolyDataReader, False, "vtp"),
                   (vtk.vtkXMLUnstructuredGridWriter, vtk.vtkXMLUnstructuredGridReader, True, "vtu")]
        for writer_type, reader_type, is_grid, extension in writers:
            for precision in (vtk.vtkAlgorithm.SINGLE_PRECISION, vtk.vtkAlgorithm.DOUBLE_PRECISION):
                for is_binary in (False, True):
                    for version in (42, 51) if extension == "vtk" else (None,):
                        with self.subTest(writer=writer_type, binary=is_binary, version=version,
                                          precision=precision):
                            writer = writer_type()
                            writer.SetFileName(self.path_of("in." + extension))
                            writer.SetInputData(self.ball(is_grid, precision))
                            if version is None:
                                writer.SetDataMode(writer.Binary if is_binary else writer.Ascii)
                            else:
                                writer.SetFileVersion(version)
                                writer.SetFileType(2 if is_binary else 1)
                            self.assertEqual(writer.Write(), 1)
                            before = self.read(reader_type(), "in." + extension)
                            out = self.deform("in." + extension, "rest.ovm", "pose.ovm", "--limit",
                                              "--quiet", out="out." + extension)
                            self.assertEqual(out.stderr, "")
                            after = self.read(reader_type(), "out." + extension)
                            self.assertEqual(after.GetNumberOfCells(), before.GetNumberOfCells())
                            self.assert_turned(before, after)
                            # And into another format of VTK.
                            other = "vtp" if extension == "vtk" else "vtk"
                            self.deform("in." + extension, "rest.ovm", "pose.ovm", "--limit",
                                        "--quiet", out="other." + other)
                            reader = (vtk.vtkXMLPolyDataReader if other == "vtp"
                                      else vtk.vtkPolyDataReader)
                            surface = self.read(reader(), "other." + other)
                            triangles = vtk.vtkTriangleFilter()
                            triangles.SetInputData(before if not is_grid else surface)
                            triangles.Update()
                            self.assertEqual(surface.GetNumberOfCells(),
                                             triangles.GetOutput().GetNumberOfCells())
                            self.assertEqual(surface.GetPoints().GetDataType(), vtk.VTK_DOUBLE)

    def test_vtk_reads_models_in_the_formats_that_they_are_converted_to(self):
        self.run_program("shape", "box", "--min", -9, -9, -9, "--max", 9, 9, 9, "-o", "rest.ovm")
        self.put("figure.obj", FIGURE)
        points = [tuple(map(float, line.split()[1:])) for line in FIGURE.splitlines()
                  if line.startswith("v ")]
        normals = [(0, 0, 1)] * 5 + [(0, 0.6, 0.8)] * 3
        readers = {"obj": vtk.vtkOBJReader, "ply": vtk.vtkPLYReader, "stl": vtk.vtkSTLReader,
                   "vtp": vtk.vtkXMLPolyDataReader, "vtu": vtk.vtkXMLUnstructuredGridReader,
                   "vtk": vtk.vtkPolyDataReader}
        # First into PLY, which has the same data, so that every format is a target.
        self.deform("figure.obj", "rest.ovm", "rest.ovm", out="source.ply")
        for extension, reader_type in readers.items():
            with self.subTest(extension=extension):
                source = "figure.obj" if extension == "ply" else "source.ply"
                self.deform(source, "rest.ovm", "rest.ovm", out="out." + extension)
                data = self.read(reader_type(), "out." + extension)
                if extension == "stl":
                    mass = vtk.vtkMassProperties()
                    self.assertEqual(data.GetNumberOfCells(), 3 + 2 + 1)
                    self.assertEqual(data.GetNumberOfPoints(), 8)
                    mass.SetInputData(data)
                    # The pentagon has the area 1 - 1/8, the square 1, and the triangle
                    # sqrt(1 + 0.01) / 2.
                    self.assertAlmostEqual(mass.GetSurfaceArea(), 1.875 + 1.01 ** 0.5 / 2, 6)
                    continue
                read = vtk_to_numpy(data.GetPoints().GetData())
                # VTK's readers of .obj and .ply round to floats.
                self.assertLess(abs(read - points).max(), 1e-7)
                loops = [[data.GetCell(cell).GetPointId(i)
                          for i in range(data.GetCell(cell).GetNumberOfPoints())]
                         for cell in range(data.GetNumberOfCells())]
                self.assertEqual(loops, LOOPS)
                array = data.GetPointData().GetNormals()
                self.assertIsNotNone(array)
                self.assertLess(abs(vtk_to_numpy(array) - normals).max(), 1e-7)

    def test_vtk_reads_points_without_faces(self):
        self.run_program("shape", "box", "--min", -9, -9, -9, "--max", 9, 9, 9, "-o", "rest.ovm")
        self.put("cloud.obj", "v 0 0 0\nv 1 2 3\n")
        for extension, reader_type in (("ply", vtk.vtkPLYReader), ("vtp", vtk.vtkXMLPolyDataReader),
                                       ("vtu", vtk.vtkXMLUnstructuredGridReader),
                                       ("vtk", vtk.vtkPolyDataReader)):
            with self.subTest(extension=extension):
                self.deform("cloud.obj", "rest.ovm", "rest.ovm", out="out." + extension)
                data = self.read(reader_type(), "out." + extension)
                self.assertEqual((data.GetNumberOfPoints(), data.GetNumberOfCells()), (2, 0))
                self.assertEqual(data.GetPoint(1), (1, 2, 3))


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
