# SPDX-License-Identifier: Apache-2.0
"""Runs the program on input that would take more memory than --max-memory allows."""

import base64
import math
import os
import struct
import subprocess
import sys
import unittest
import zlib

import program
from program import CliTest

TRILLION = 10**12


def vtu(points, count, compressor=""):
    return f"""<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64"{compressor}>
<UnstructuredGrid><Piece NumberOfPoints="{count}" NumberOfCells="1">
<Points>{points}</Points>
<Cells></Cells>
</Piece></UnstructuredGrid></VTKFile>
"""


class MemoryTest(CliTest):
    def lattice(self, name="box.ovm", cells=(2, 2, 2)):
        self.run_program("shape", "box", "--cells", *cells, "-o", name)
        return name

    def points(self, count, z=0.5):
        lines = [f"v {(i % 10) / 10 + 0.05} {(i // 10 % 10) / 10 + 0.05} {z}" for i in range(count)]
        self.put("points.obj", "\n".join(lines))
        return "points.obj"

    def test_a_level_that_cannot_be_is_refused_at_once(self):
        self.lattice()
        self.assertRegex(self.error_of("refine", "box.ovm", "-n", 15, "-o", "out.ovm"),
                         r"^espalier: box.ovm: level 15 would have more than 2147483647 entities")
        self.assertRegex(
            self.error_of("refine", "box.ovm", "-n", 7, "-o", "out.ovm", "--max-memory", "1GB"),
            r"^espalier: box.ovm: level 7 takes about 2.\d GB of memory; the limit is 1.0 GB, of which "
            r"\S+ MB are in use \(while refining\)\n$")
        self.assertFalse((self.path / "out.ovm").exists())

    def test_the_option_is_of_every_command_and_takes_units(self):
        self.lattice()
        for size in ("500MB", "1GiB", "2000000000", "1g"):
            self.run_program("info", "box.ovm", "--max-memory", size)
        # 2^64 bytes are 16 EiB.
        for size in ("0", "-1", "ten", "1XB", "nan", "inf", "1e308", "1e-310", "0.5", "16EiB", ""):
            self.assertEqual(self.error_of("info", "box.ovm", "--max-memory", size, code=2),
                             "espalier: --max-memory: expected a size above 0, such as 500MB or 4GB, "
                             f"got {size or 'nothing'}\n")
        for command in (["info"], ["shape", "box"], ["shape", "merge"], ["shape", "around"], ["pose"],
                        ["refine"], ["stencils"],
                        ["bind"], ["apply"], ["deform"], ["bench"], ["fit"], ["check"], ["page"],
                        ["compare"]):
            self.assertIn("--max-memory", self.run_program(*command, "--help").stdout)

    def test_claims_are_refused_before_memory_is_taken(self):
        claims = {
            "a.ovm": f"OVM ASCII\nVertices\n{TRILLION}\n0 0 0\n",
            "b.ovm": "OVM ASCII\nVertices\n99999999999999999999999\n",
            "a.vtk": "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     f"POINTS {TRILLION} float\n0 0 0\n",
            "b.vtk": "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
                     f"POINTS {2**63} double\n0 0 0\n",
            "a.vtu": vtu('<DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0'
                         "</DataArray>", TRILLION),
            "b.vtu": vtu('<DataArray type="Float32" NumberOfComponents="3" format="binary">'
                         + base64.b64encode(struct.pack("<Q", TRILLION)).decode()
                         + "</DataArray>", TRILLION),
            "a.su2": f"NDIME= 3\nNPOIN= {TRILLION}\n0 0 0\n",
            "a.mesh": f"MeshVersionFormatted 2\nDimension 3\nVertices {TRILLION}\n0 0 0 0\n",
            "a.msh": f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{TRILLION}\n1 0 0 0\n",
            "b.msh": f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {TRILLION} 1 1\n3 1 0 {TRILLION}\n",
            "a.xyz": f"1\n{TRILLION} 1 1\n0 0 0\n",
            "points": f"FoamFile {{ class vectorField; }}\n{TRILLION}\n((0 0 0))\n",
        }
        for name, text in claims.items():
            self.put(name, text)
            error = self.error_of("info", name, "--max-memory", "50MB")
            self.assertTrue(error.startswith(f"espalier: {name}:"), error)
            self.assertNotIn("out of memory", error)
        models = {
            "a.ply": f"ply\nformat ascii 1.0\nelement vertex {TRILLION}\nproperty float x\n"
                     "property float y\nproperty float z\nend_header\n0 0 0\n",
            "b.ply": f"ply\nformat binary_little_endian 1.0\nelement vertex {2**63}\n"
                     "property double x\nproperty double y\nproperty double z\nend_header\n0",
            "c.vtk": "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\n"
                     f"POINTS {2**62} float\n0 0 0\n",
            "d.vtk": "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n"
                     f"0 0 0\nPOLYGONS 1 {TRILLION}\n3 0 0 0\n",
            "c.vtp": vtu('<DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0'
                         "</DataArray>", TRILLION).replace("UnstructuredGrid", "PolyData"),
            "a.stl": b"binary".ljust(80) + struct.pack("<I", 2**32 - 1) + bytes(50),
        }
        self.lattice()
        for name, content in models.items():
            data = content if isinstance(content, bytes) else content.encode()
            (self.path / name).write_bytes(data)
            error = self.error_of("bind", name, "--rest", "box.ovm", "-o", "out.espb",
                                  "--max-memory", "50MB")
            self.assertTrue(error.startswith(f"espalier: {name}:"), error)
            self.assertNotIn("out of memory", error)

    def test_a_zlib_bomb(self):
        size = 300_000_000
        packed = zlib.compress(bytes(size), 9)
        header = struct.pack("<4Q", 1, size, 0, len(packed))
        array = ('<DataArray type="Float64" NumberOfComponents="3" format="binary">'
                 + base64.b64encode(header).decode() + base64.b64encode(packed).decode()
                 + "</DataArray>")
        self.put("bomb.vtu", vtu(array, size // 24, ' compressor="vtkZLibDataCompressor"'))
        self.assertRegex(self.error_of("info", "bomb.vtu", "--max-memory", "100MB"),
                         r"^espalier: bomb.vtu:4: the array '': its data takes about 300.0 MB")

    def test_what_is_not_known_beforehand_is_stopped(self):
        # The points are outside, and the tolerance is so wide that each of them may be in every cell of level 9.
        # Timing decides which comes first: the memory in use exceeds the limit, the system refuses memory, or the
        # program is about to refine cells or to make a table, and knows that this takes more than the limit leaves.
        self.lattice()
        points = self.points(1000, z=1.5)
        peak, error = self.peak_and_error("bind", points, "--rest", "box.ovm", "-n", 9, "--tolerance", 1,
                                          "-o", "out.espb", "--max-memory", "200MB")
        self.assertRegex(error, r"^espalier: (out of memory|.* takes about .* of memory)\b.*"
                                r"\bthe limit is 200\.0 MB\b.*\n$")
        self.assertRegex(error, r"\bwhile binding\b")
        self.assertLess(peak, 2 * 200e6)  # without the limit, it is several times as much
        self.assertFalse((self.path / "out.espb").exists())

    def peak_and_error(self, *arguments):
        """Returns the peak memory of a run in bytes, and its message."""
        with open(self.path / "error", "w+") as error:
            process = subprocess.Popen([program.ESPALIER, *map(str, arguments)], cwd=self.path,
                                       stdout=subprocess.DEVNULL, stderr=error)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            error.seek(0)
            text = error.read()
        self.assertEqual(process.returncode, 1, text)
        return 1024 * usage.ru_maxrss, text

    @staticmethod
    def cube_mesh():
        corners = [f"v {i & 1} {i >> 1 & 1} {i >> 2}" for i in range(8)]
        faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "2 4 8 6", "1 5 7 3"]
        return "\n".join([*corners, *("f " + face for face in faces)]) + "\n"

    def test_comparing_is_refused_before_memory_is_taken(self):
        if "--html" not in self.run_program("compare", "--help").stdout:
            self.skipTest("espalier was built without OpenSubdiv")
        self.lattice(cells=(4, 4, 4))
        self.put("cube.obj", self.cube_mesh())
        self.run_program("compare", "box.ovm", "-n", 4, "--max-memory", "400MB")
        self.run_program("compare", "cube.obj", "-n", 7, "--max-memory", "400MB")
        # Memory in megabytes. Refining the box takes 63, the whole comparison 155. For the cube, the
        # process holds 16 before OpenSubdiv refines it, 44 after, 55 before its table is made, and 85
        # while the table is made.
        for name, level, limit, step in [
                ("box.ovm", 4, 90, "matching level 4 with OpenSubdiv's"),
                ("cube.obj", 7, 35, "OpenSubdiv's topology of levels 1 to 7"),
                ("cube.obj", 7, 70, "OpenSubdiv's stencil table of levels 1 to 7")]:
            peak, error = self.peak_and_error("compare", name, "-n", level, "--max-memory",
                                              f"{limit}MB", "--quiet")
            self.assertRegex(error, rf"^espalier: {name}: {step} takes about \S+ MB of memory; the "
                                    rf"limit is {limit}.0 MB, of which \S+ MB are in use "
                                    r"\(while comparing\)\n$")
            self.assertLess(peak, limit * 1e6, error)

    def test_long_rows_are_refused_before_they_are_made(self):
        # A row of D has 3,000 weights. D takes 720 MB, and as much again while its rows are gathered.
        self.run_program("shape", "prism", "--sides", 1500, "-o", "prism.vtu")
        points = [(0.9 * i / 20000 * math.cos(i), 0.9 * i / 20000 * math.sin(i), i / 25000 - 0.4)
                  for i in range(20000)]
        self.put("points.obj", "".join("v %g %g %g\n" % point for point in points))
        peak, error = self.peak_and_error("bind", "points.obj", "--rest", "prism.vtu", "-n", 2,
                                          "-o", "out.espb", "--max-memory", "500MB")
        self.assertRegex(error, r"^espalier: binding 20000 points with some 3000 weights each takes "
                                r"about 1\.\d GB of memory; the limit is 500.0 MB, of which \S+ MB are "
                                r"in use \(while binding\)\n$")
        self.assertLess(peak, 250e6)  # 100 held: no group was bound
        self.assertFalse((self.path / "out.espb").exists())
        # One pose needs no D.
        self.run_program("deform", "points.obj", "--rest", "prism.vtu", "--to", "prism.vtu", "-n",
                         2, "-o", "out.obj", "--max-memory", "500MB")
        self.assertEqual(self.bytes("out.obj"), self.bytes("points.obj"))

    def test_a_file_larger_than_memory_is_not_read(self):
        self.lattice()
        with open(self.path / "large.obj", "wb") as file:
            file.truncate(2**40)  # nothing of it is on disk
        arguments = ["bind", "large.obj", "--rest", "box.ovm", "-o", "out.espb"]
        self.assertRegex(self.error_of(*arguments, "--max-memory", "1GB"),
                         r"^espalier: large.obj: takes about 1.1 TB of memory")
        # A device does not say how long it is.
        (self.path / "endless.ovm").symlink_to("/dev/zero")
        self.assertRegex(self.error_of("info", "endless.ovm", "--max-memory", "300MB"),
                         r"^espalier: endless.ovm: takes about ")

    def test_a_table_of_bezier_weights(self):
        self.lattice(cells=(15, 15, 15))
        points = self.points(10_000)  # 41 million weights
        self.assertRegex(self.error_of("bind", points, "--rest", "box.ovm", "--basis", "bezier",
                                       "-o", "out.espb", "--max-memory", "200MB"),
                         r"a table of 10000 rows takes about 491.5 MB of memory")


if __name__ == "__main__":
    program.ESPALIER = sys.argv.pop(1)
    unittest.main()
