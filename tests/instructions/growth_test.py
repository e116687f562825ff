#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Doubles inputs that are made to be slow, and requires at most 2.5 times the instructions.

Each input is of a kind that once took the square of its size. The test counts instructions under valgrind and not time,
so it gives the same answer on a busy machine. It needs valgrind, and is skipped without it.

usage: growth_test.py PROGRAM [KIND...]
"""

import concurrent.futures
import math
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

# Twice the work, its logarithm, and tables that are a power of two in size. The square would be four times.
MAX_GROWTH = 2.5
SKIPPED = 77


def gmsh_tags(size):
    """Tags that are multiples of a number of buckets that libstdc++ chooses for a table of `size`."""
    buckets = {2000: 2357, 4000: 5087}[size]
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n%s$EndNodes\n$Elements\n1\n1 2 0 %d %d %d\n$EndElements\n" % (
        size, "".join(f"{(i + 1) * buckets} {i % 7} {i % 11} {i % 13}\n" for i in range(size)),
        buckets, 2 * buckets, 3 * buckets)


def plot3d_weld(size, far=1e7):
    """A block of size * 16 * 16 points in the unit cube, and a cell far away from it."""
    shape = (size, 16, 16)
    text = "2\n%d %d %d\n2 2 2\n" % shape
    for axis in range(3):
        stride = math.prod(shape[:axis])
        text += " ".join("%.4g" % (i // stride % shape[axis] / 15) for i in range(math.prod(shape))) + "\n"
    return text + "".join(" ".join("%.17g" % (far + (i >> axis & 1)) for i in range(8)) + "\n" for axis in range(3))


def su2_cells(size):
    """Tetrahedra whose edges from a to a + d have one bucket in the table of far::ComplexBuilder, for all d."""
    cells = [(i, i + 1, i + 2, i + 3) for i in range(0, 4 * size - 1, 4) if i + 3 < 4 * size - 1]
    points = 4 * size - 1
    for d in range(5, points // 2):
        a = (777 - d * 0x9E3779B97F4A7C15) % (4 * size)
        if a + d + 3 < points:
            cells.append((a, a + d, a + d + 1, a + d + 3))
    cells.append((points - 4, points - 3, points - 2, points - 1))
    return (f"NDIME= 3\nNELEM= {len(cells)}\n" + "".join("10 %d %d %d %d\n" % cell for cell in cells)
            + f"NPOIN= {points}\n" + "".join(f"{i % 101} {i % 89} {i % 97}\n" for i in range(points)) + "NMARK= 0\n")


def vtu_attributes(size, offset=0):
    array = '<DataArray type="%s" Name="%s" NumberOfComponents="%d" format="ascii">%s</DataArray>'
    return ('<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">'
            "<PointData>" + "".join(array % ("Float32", f"name {i}", 1, "0 0 0 0") for i in range(size)) + "</PointData><Points>"
            + array % ("Float32", "Points", 3, f"{offset} 0 0 1 0 0 0 1 0 0 0 1") + "</Points><Cells>"
            + array % ("Int32", "connectivity", 1, "0 1 2 3") + array % ("Int32", "offsets", 1, "4")
            + array % ("UInt8", "types", 1, "10") + "</Cells></Piece></UnstructuredGrid></VTKFile>")


def vtp_pieces(size):
    """Pieces on one line."""
    array = '<DataArray type="%s" Name="%s" NumberOfComponents="%d" format="ascii">%s</DataArray>'
    piece = ('<Piece NumberOfPoints="3" NumberOfPolys="1"><Points>'
             + array % ("Float32", "Points", 3, "0 0 0 1 0 0 0 1 0") + "</Points><Polys>"
             + array % ("Int32", "connectivity", 1, "0 1 2") + array % ("Int32", "offsets", 1, "3") + "</Polys></Piece>")
    return f'<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>{piece * size}</PolyData></VTKFile>'


def vtp_arrays(size):
    array = '<DataArray type="Float32" Name="name %d" format="ascii">0 0 0</DataArray>\n'
    return vtp_pieces(1).replace("<Points>", "<PointData>" + "".join(array % i for i in range(size)) + "</PointData><Points>")


def vtk_arrays(size):
    return ("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n"
            f"POINT_DATA 3\nFIELD f {size}\n" + "".join(f"name{i} 1 3 float\n0 0 0\n" for i in range(size)))


def ply_properties(size):
    names = "".join(f"property uchar name{i}\n" for i in range(size))
    row = " 0" * size + "\n"
    return ("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + names
            + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            + "0 0 0" + row + "1 0 0" + row + "0 1 0" + row + "3 0 1 2\n")


def polygon(corners):
    corners = list(corners)
    return "".join("v %.9g %.9g 0\n" % corner for corner in corners) + "f " + " ".join(
        str(i + 1) for i in range(len(corners))) + "\n"


def comb(size):
    teeth = [(i, i % 2 * 100) for i in range(size)]
    return polygon([(size, -1), *reversed(teeth), (0, -1)][::-1])


def spiral(size):
    """Both sides of a band that winds around its inner end, with four corners a turn."""
    def side(width):
        return [((i + 4 + width) * math.cos(i * math.pi / 2), (i + 4 + width) * math.sin(i * math.pi / 2))
                for i in range(size // 2)]
    return polygon(side(1) + side(0)[::-1])


def star(size):
    numbers = random.Random(7)
    return polygon((r * math.cos(2 * math.pi * i / size), r * math.sin(2 * math.pi * i / size))
                   for i, r in ((i, numbers.uniform(0.05, 1)) for i in range(size)))


DEFORM = ["deform", "INPUT", "--rest", "rest.ovm", "--to", "rest.ovm", "-n", "1", "--outside", "keep", "--quiet",
          "--threads", "1"]

# For each kind: the function that makes the input, its size, the name of the file, and the arguments of the program.
KINDS = {
    "gmsh tags": (gmsh_tags, 2000, "a.msh", ["info", "--model", "INPUT", "--threads", "1"]),
    "plot3d weld": (plot3d_weld, 4, "a.xyz", ["info", "-n", "0", "INPUT", "--threads", "1"]),
    "su2 cells": (su2_cells, 1024, "a.su2", ["pose", "INPUT", "--move", "0", "0", "1", "-o", "out.ovm", "--threads", "1"]),
    "vtu attributes": (vtu_attributes, 500, "a.vtu", ["shape", "merge", "INPUT", "OTHER", "-o", "out.vtu"]),
    "vtp pieces": (vtp_pieces, 200, "a.vtp", [*DEFORM[:4], "--to", "pose.ovm", *DEFORM[6:], "-o", "/dev/null"]),
    "vtp arrays": (vtp_arrays, 500, "a.vtp", [*DEFORM, "-o", "out.obj"]),
    "vtk arrays": (vtk_arrays, 500, "a.vtk", [*DEFORM, "-o", "out.obj"]),
    "ply properties": (ply_properties, 500, "a.ply", [*DEFORM, "-o", "out.obj"]),
    "comb": (comb, 1000, "a.obj", [*DEFORM, "-o", "out.stl"]),
    "spiral": (spiral, 500, "a.obj", [*DEFORM, "-o", "out.stl"]),
    "star": (star, 1000, "a.obj", [*DEFORM, "-o", "out.stl"]),
}


def instructions(program, arguments, folder):
    counts = folder / "counts"
    # Without caches, cachegrind takes a third of the time of callgrind.
    run = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no", "--branch-sim=no",
                          f"--cachegrind-out-file={counts}", program, *arguments],
                         cwd=folder, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{' '.join(arguments)} failed under valgrind:\n{run.stderr}")
    return int(re.search(r"^summary: (\d+)$", counts.read_text(), re.MULTILINE)[1])


def growth(program, kind, start):
    """Returns how many times more instructions an input of twice the size takes, without the start of the program."""
    make, size, name, arguments = KINDS[kind]
    counts = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for file, top in (("rest.ovm", 1), ("pose.ovm", 2)):
            subprocess.run([program, "shape", "box", "--min", "-1", "-1", "-1", "--max", "1", "1", str(top), "-o", file],
                           cwd=folder, check=True, capture_output=True)
        for times in (1, 2):
            names = {"INPUT": name, "OTHER": "other" + name}
            (folder / name).write_text(make(times * size))
            if "OTHER" in arguments:
                (folder / names["OTHER"]).write_text(make(times * size, 2))
            counts.append(instructions(program, [names.get(word, word) for word in arguments], folder) - start)
    return counts[1] / counts[0], counts[1]


def main():
    program, kinds = os.path.abspath(sys.argv[1]), sys.argv[2:] or list(KINDS)
    if not shutil.which("valgrind"):
        print("skipped: valgrind is not installed")
        return SKIPPED
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        start = instructions(program, ["--version"], pathlib.Path(folder))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for kind, (factor, count) in zip(kinds, pool.map(lambda kind: growth(program, kind, start), kinds)):
            print(f"{kind}: {factor:.2f} times the instructions, {count:,}", flush=True)
            if factor > MAX_GROWTH:
                failed.append(kind)
    if failed:
        print("too many instructions for twice the input:", ", ".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
