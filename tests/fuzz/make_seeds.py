#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the seeds of the fuzz targets: corpus/TARGET/seed-*.

    tests/fuzz/make_seeds.py ESPALIER

ESPALIER is the program, which writes the lattices and the bound model. The inputs of topology, embedding,
limit, payload and npz have the layout that the code of these targets reads. There are more seeds in
tests/io: files that VTK, NumPy and SciPy have written.
"""
import base64
import io
import json
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

CORPUS = Path(__file__).resolve().parent / "corpus"


def put(target, name, content):
    folder = CORPUS / target
    folder.mkdir(parents=True, exist_ok=True)
    data = content if isinstance(content, bytes) else content.encode()
    (folder / f"seed-{name}").write_bytes(data)


def lattices(espalier, folder):
    shapes = {
        "box": ["box", "--cells", "2", "1", "1"],
        "pyramid": ["pyramid", "--sides", "4"],
        "prism": ["prism", "--sides", "5"],
    }
    for name, arguments in shapes.items():
        for kind in ("ovm", "vtu", "vtk"):
            path = folder / f"{name}.{kind}"
            subprocess.run([espalier, "shape", *arguments, "-o", path], check=True,
                           stdout=subprocess.DEVNULL)
            put(kind, name, path.read_bytes())
    put("vtu_model", "box", (folder / "box.vtu").read_bytes())
    for kind in ("obj", "ply"):
        mesh = folder / f"editor.{kind}"
        subprocess.run([espalier, "refine", folder / "box.vtu", "-n", "0", "-o", mesh], check=True,
                       stdout=subprocess.DEVNULL)
        put("editor_mesh", kind, mesh.read_bytes())
    # A surface with normals, in the formats of VTK.
    model = folder / "model.obj"
    model.write_text("v 0 0 0\nv 1 0.25 0\nv 0.5 0.125 0\nv 0 1 0\nvn 0 0 1\n"
                     "f 1//1 2//1 3//1 4//1\nf 1//1 4//1 3//1\n")
    for target, kind in (("vtp", "vtp"), ("vtk_model", "vtk"), ("vtu_model", "vtu")):
        surface = folder / f"surface.{kind}"
        subprocess.run([espalier, "deform", model, "--rest", folder / "box.vtu", "--to",
                        folder / "box.vtu", "-o", surface], check=True, stdout=subprocess.DEVNULL)
        put(target, "surface", surface.read_bytes())


def marked_lattice():
    put("ovm", "marks", """OVM ASCII
Vertices
4
0 0 0
1 0 0
0 1 0
0 0 1
Edges
6
0 1
1 2
2 0
0 3
1 3
2 3
Faces
4
3 0 2 4
3 0 8 7
3 2 10 9
3 4 6 11
Polyhedra
1
4 1 2 4 6
VProp double "espalier:vertex_sharpness"
-1
10
0
2.5
EProp double "espalier:edge_sharpness"
-1
10
0
2.5
-1
1
VProp vec2f "uv"
0 0
0 1
1 0
1 1
VProp string "name"
a
b
c
d
""")


def models():
    put("obj", "triangles", """# a comment
mtllib a.mtl
o thing
v 0 0 0
v 1 0 0 1
v 0 1.5e-3 0 0.1 0.2 0.3
vt 0 0
vn 0 0 1
f 1/1/1 2/1/1 \\
  -1//1
""")
    put("obj", "normals", """vn 0 1 0
v 0 0 0
v 1 0 0
f 1//1 2//1 1//2
v 0 1 0
vn 0.6 0 0.8 # the last \\
f 1//1 2//-1 -1/2/-2 \\
 -2//2
vn 0 0 1
f 1//3 2//3 3//1
surf 0 1 0 1 1//1 2//-1 9//3 1//9
""")
    put("obj_mesh", "tags", """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 2 0
v 1 2 0
f 1 2 3 4
f 4 3 6 5
t crease 2/1/0 3 2 1.5
t crease 4/2/0 0 1 1 2 0.5 10
t corner 1/1/0 4 2
t hole 1/0/0 0
t interpolateboundary 1/0/0 1
t creasemethod 0/0/1 chaikin
t smoothtriangles 0/0/1 smooth
""")
    put("obj_mesh", "triangle", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//1 -1\n")
    put("obj_mesh", "curve", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3 1\n")
    header = """ply
format {} 1.0
comment made by hand
element vertex 3
property float x
property double y
property float z
property uchar red
element face 1
property list uchar int vertex_indices
end_header
"""
    put("ply", "ascii", header.format("ascii") + "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n")
    for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        rows = b"".join(struct.pack(order + "fdfB", i, 2 * i, 3 * i, i) for i in range(3))
        rows += struct.pack(order + "B3i", 3, 0, 1, 2)
        put("ply", name, header.format(name).encode() + rows)
    header = header.replace("property uchar red", "property float nx\nproperty float nz\n"
                            "property double tx\nproperty float ny\nproperty double ty\n"
                            "property double tz")
    put("ply", "directions-ascii", header.format("ascii") + """0 0 0 0 1 1 0 0 0
1 0 0 0.6 0.8 0 0 1 0
0 1 0 nan x 0 1e300 -0 1e39
3 0 1 2
""")
    rows = b"".join(struct.pack(">fdfffdfdd", i, 2 * i, 3 * i, 0.6, 0.8, i, 0, 2, 1)
                    for i in range(3))
    put("ply", "directions-binary", header.format("binary_big_endian").encode() + rows +
        struct.pack(">B3i", 3, 0, 1, 2))
    names = ["x", "y", "z", *(f"scale_{i}" for i in range(3)), *(f"rot_{i}" for i in range(4)),
             *(f"f_rest_{i}" for i in range(9))]
    header = ("ply\nformat {} 1.0\nelement vertex 2\n" +
              "".join(f"property float {name}\n" for name in names) + "end_header\n")
    splat = [0, 0, 0, -1, -2, -3, 1, 0.5, 0, -0.5, *range(9)]
    put("ply", "splats-ascii", header.format("ascii") +
        " ".join(map(str, splat)) + "\n" + "1 " * 6 + "0 " * 10 + "nan\n")
    put("ply", "splats-binary", header.format("binary_little_endian").encode() +
        struct.pack("<38f", *splat, *splat))
    numbers = struct.pack("<I6f", 24, 1, 0, 0, 0.6, 0, 0.8)
    put("vtu_model", "directions", b"""<VTKFile type="UnstructuredGrid" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="2" NumberOfCells="0">
<PointData Normals="n"><DataArray type="Float64" Name="Tangents" NumberOfComponents="3">
0 1 0 nan 0 1</DataArray>
<DataArray type="Float32" Name="n" NumberOfComponents="3" format="appended" offset="0"/></PointData>
<Points><DataArray type="Int8" NumberOfComponents="3">0 0 0 1 2 3</DataArray></Points>
<Cells/></Piece></UnstructuredGrid><AppendedData encoding="raw">
_""" + numbers + b"</AppendedData></VTKFile>")
    vtk = "# vtk DataFile Version {}\na title\n{}\nDATASET {}\n"
    put("vtk_model", "ascii", vtk.format("2.0", "ASCII", "POLYDATA") + """FIELD f 1
TimeValue 1 1 float
0
POINTS 4 float
0 0 0 1 0 0 1 1 0 0 1 0
VERTICES 1 2
1 0
LINES 1 3
2 0 1
POLYGONS 1 5
4 0 1 2 3
TRIANGLE_STRIPS 1 5
4 0 1 2 3
CELL_DATA 4
SCALARS s int
LOOKUP_TABLE default
1 2 3 4
POINT_DATA 4
COLOR_SCALARS c 1
0 0 1 1
NORMALS n float
0 0 1 0 0 1 nan 0 1 1 0 0
FIELD g 1
Tangents 3 4 double
1 0 0 1 0 0 0 0 0 1e300 0 0
""")
    put("vtk_model", "offsets", vtk.format("5.1", "ASCII", "UNSTRUCTURED_GRID") + """POINTS 3 double
0 0 0 1 0 0 0 1 0
METADATA
INFORMATION 0

CELLS 2 3
OFFSETS vtktypeint64
0 3
CONNECTIVITY vtktypeint64
0 1 2
CELL_TYPES 1
5
POINT_DATA 3
GLOBAL_IDS i vtkIdType
1 2 3
""")
    points = struct.pack(">9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    put("vtk_model", "binary", vtk.format("3.0", "BINARY", "POLYDATA").encode() +
        b"POINTS 3 float\n" + points + b"\nPOLYGONS 1 4\n" + struct.pack(">4i", 3, 0, 1, 2) +
        b"\nPOINT_DATA 3\nNORMALS Normals float\n" + points + b"\n")
    put("vtp", "pieces", """<VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt64">
<PolyData><Piece NumberOfPoints="3" NumberOfPolys="1" NumberOfStrips="1"><PointData>
<DataArray type="Float32" Name="Normals" NumberOfComponents="3">0 0 1 0 0 1 0 0 1</DataArray>
</PointData><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0</DataArray></Points>
<Polys><DataArray type="Int32" Name="connectivity" format="binary">""" +
        base64.b64encode(struct.pack("<Q3i", 48, 0, 1, 2)).decode() + """</DataArray>
<DataArray type="Int32" Name="offsets">3</DataArray></Polys>
<Strips><DataArray type="Int32" Name="connectivity">0 1 2</DataArray>
<DataArray type="Int32" Name="offsets">3</DataArray></Strips></Piece>
<Piece NumberOfPoints="1" NumberOfVerts="1"><Points><DataArray type="Float64" NumberOfComponents="3">
5 5 5</DataArray></Points><Verts><DataArray type="Int64" Name="connectivity">0</DataArray>
<DataArray type="Int64" Name="offsets">1</DataArray></Verts></Piece></PolyData></VTKFile>
""")
    squares = ("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
               "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 5 5 0\nvt 6\n"
               "f 1/1 2/2 3/3 4/4\nf 2/-2 5/-1 6/3 3/3\n")
    put("obj_mesh", "textures", squares + "t facevaryinginterpolateboundary 1/0/0 2\n")
    for mode in range(6):
        put("face_varying", f"squares-{mode}", chr(mode) + squares + "t crease 2/1/0 1 2 1.5\n")
    put("stl", "ascii", """solid thing
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid thing
""")
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 7)
    put("stl", "binary", b"binary".ljust(80) + struct.pack("<I", 2) + 2 * facet)
    put("stl", "trailing", b"solid".ljust(80) + struct.pack("<I", 1) + facet + b"more")
    put("stl", "joined", """solidthing
facet normal nan nan nan
outer loop
vertex nan nan nan
vertex inf nan nan
vertex nan -inf nan
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolidthing
""")
    put("obj", "unknown", "v nan 0 0\nfoo bar\nv 0 0 0\nv 1 0 0\nv 0 1 0\n$x 1\nf 2 3 4\n")
    put("obj_mesh", "unknown", "v 0 0 0\nfoo bar\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    put("ply", "strips", """ply
format ascii 1.0
exported by hand
element vertex 5
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
nan 0 inf
7 0 1 2 3 -1 1 2
""")
    for target, points in (("vtk", "0 0 0"), ("vtk_model", "nan 0 0")):
        put(target, "grid", vtk.format("3.0", "ASCII", "STRUCTURED_GRID") + "DIMENSIONS 3 2 2\n"
            "POINTS 12 float\n" + points + " 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0 0 0 1 1 0 1 2 0 1 0 1 1 "
            "1 1 1 2 1 1\n")
    put("vtk", "pentagonal", vtk.format("3.0", "ASCII", "UNSTRUCTURED_GRID") + """POINTS 10 float
1 0 0 0.3 1 0 -0.8 0.6 0 -0.8 -0.6 0 0.3 -1 0 1 0 1 0.3 1 1 -0.8 0.6 1 -0.8 -0.6 1 0.3 -1 1
CELLS 1 11
10 0 1 2 3 4 5 6 7 8 9
CELL_TYPES 1
15
""")
    put("vtu_model", "no-end", b"""<VTKFile type="UnstructuredGrid" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="2" NumberOfCells="0"><Points>
<DataArray type="Float32" NumberOfComponents="3" format="appended" offset="0"/></Points>
<Cells/></Piece></UnstructuredGrid><AppendedData encoding="raw">
_""" + struct.pack("<I6f", 24, float("nan"), 0, 0, 0.6, 0, 0.8))
    put("ovm", "no-ascii", (CORPUS / "ovm/seed-marks").read_text().replace("OVM ASCII", "OVM"))
    put("targets", "two", "# point x y z\n3 0 0 1\n99 1e-3 -2.5 7  # far\n")
    put("displacements", "csv", "vertex,dx,dy,dz\n3,0,0,1\n99,1e-3,-2.5,7\n")
    head = b"{'descr': '<f4', 'fortran_order': True, 'shape': (2, 4), }\n"
    put("displacements", "npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head
        + struct.pack("<8f", 3, 99, 0, 1e-3, 0, -2.5, 1, 7))


def bound_model(espalier, folder):
    cube = folder / "cube.ovm"
    subprocess.run([espalier, "shape", "cube", "-o", cube], check=True,
                   stdout=subprocess.DEVNULL)
    model = folder / "points.obj"
    model.write_text("v 0.1 0.2 0.3\nv 5 5 5\nv 0 0 0\n")
    bound = folder / "a.espb"
    subprocess.run([espalier, "bind", model, "--rest", cube, "-n", "1", "-o", bound],
                   check=True, stdout=subprocess.DEVNULL)
    put("espb", "cube", bound.read_bytes())
    # This model has normals, so the bound model has gradients.
    model.write_text("v 0.1 0.2 0.3\nv 5 5 5\nv 0 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n")
    subprocess.run([espalier, "bind", model, "--rest", cube, "--limit", "-o", bound],
                   check=True, stdout=subprocess.DEVNULL)
    put("espb", "gradients", bound.read_bytes())


def meshes():
    points = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
    lines = "\n".join(points)
    put("su2", "tetrahedron", f"""NDIME= 3 % a comment
NELEM= 1
10 0 1 2 3 0
NPOIN= 4
{lines}
NMARK= 1
MARKER_TAG= wall
MARKER_ELEMS= 1
5 0 2 1
""")
    put("su2", "plane", "NZONE= 1\nIZONE= 1\nNDIME= 2\nNELEM= 1\n9 0 1 2 3\nNPOIN= 4\n0 0\n1 0\n1 1\n0 1\n")
    put("bdf", "fields", "BEGIN BULK\n"
        "GRID           1              0.      0.      0. $ a\n"
        "GRID*                  2                              1.              0.*\n*                     0.\n"
        "GRID*   3                               0.              1.              \nGRID,4,,,,1.+0\n"
        "CTETRA         1       1       1       2       3       4\nCQUAD4,2,1,1,2,3,4\nENDDATA\n")
    put("bdf", "curved", "".join(f"GRID,{i},,{i}.,{i * i}.\n" for i in range(1, 11))
        + "CTETRA,1,1,1,2,3,4,5,6,\n,7,8,9,10\nCTRIA6,2,1,1,2,3,4,,6\nINCLUDE 'a'\n")
    put("inp", "parts", "*Heading\n*Part, name=a\n*Node\n1, 0, 0, 0\n2, 1, 0., 0\n3, 0, 1.d0, 0\n4, 0, 0, 1\n"
        "*Element, type=C3D4,\n elset=b\n1, 1, 2,\n3, 4\n*End Part\n*Instance, name=c\n1., 0, 0\n*End Instance\n")
    put("inp", "plane", "*NODE\n1, 0, 0\n2, 1, 0\n3, 0, 1\n** no\n*ELEMENT, TYPE=CPS3\n1, 1, 2, 3\n")
    put("inp", "sets", "*NODE, NSET=all\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=a\n"
        "1, 1, 2, 3, 4\n*NSET, NSET=n, GENERATE\n1, 4, 2\n*ELSET, ELSET=b\na, 1\n*SURFACE, NAME=s\nb, S2\n1, S1\n"
        "*SURFACE, TYPE=NODE, NAME=t\nn, 1.\n")
    node = "".join(f"{i:10}         1         1        11\n{x:25.16E}{y:25.16E}{z:25.16E}\n"
                   for i, (x, y, z) in enumerate(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)), 1))
    put("unv", "tetrahedron", f"    -1\n  2411\n{node}    -1\n    -1\n  2412\n"
        "         1       111         2         1         7         4\n         1         2         3         4\n"
        "         2        21         2         1         7         2\n         0         0         0\n"
        "         1         2\n         3        91         2         1         7         3\n"
        "         1         2         3\n    -1\n    -1\n  2467\n"
        "         1         0         0         0         0         0         0         3\nwall\n"
        "         8         3         0         0         7         4         0         0\n"
        "         8         1         0         0\n    -1\n")
    put("unv", "old", "    -1\n    15\n"
        + "".join(f"{i:10}         0         0         8{x:13.5E}{y:13.5E}  0.00000D+00\n"
                  for i, (x, y) in enumerate(((0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)), 1))
        + "    -1\n    -1\n   780\n 1 42 1 1 1 1 7 6\n 1 4 2 5 3 6\n    -1\n    -1\n  2432\n 5 0 0 0 0 0 0 1\n\n 8 1\n"
        "    -1\n    -1\n  2420\n1\npart\n 0 1 8\nname\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n    -1\n")
    head = '(0 "text (")\n(2 3)\n(10 (0 1 4 0))\n'
    faces = ((1, 2, 3), (1, 4, 2), (2, 4, 3), (3, 4, 1))
    put("fluent", "text", head + "(10 (1 1 4 1 3)(0 0 0\n1 0 0\n0 1 0\n0 0 1))\n(12 (2 1 1 1 2))\n(13 (3 1 2 3 3)(\n"
        + "".join(f"{a} {b} {c} 1 0\n" for a, b, c in faces[:2]) + "))\n(13 (4 3 4 7 0)(\n"
        + "".join(f"3 {a} {b} {c} 1 0\n" for a, b, c in faces[2:]) + "))\n(18 (1 1 3 4)(1 3))\n(45 (3 wall a)())\n")
    put("fluent", "plane", "(2 2)\n(10 (1 1 4 1 2)(0 0 1 0 1 1 0 1))\n(13 (2 1 4 3 2)(1 2 1 0 2 3 1 0 3 4 1 0 4 1 1 0))\n"
        "(12 (3 1 1 1 3))\n(39 (2 symmetry b)())\n")
    put("fluent", "binary", head.encode() + b"(3010 (1 1 4 1 3)("
        + struct.pack("<12d", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1) + b")\nEnd of Binary Section   3010)\n(3013 (3 1 4 3 3)("
        + b"".join(struct.pack("<5i", a, b, c, 1, 0) for a, b, c in faces) + b")\nEnd of Binary Section   3013)\n")
    put("mesh", "tetrahedron", "MeshVersionFormatted 2\nDimension 3\nVertices 4\n"
        + "".join(f"{p} 1\n" for p in points)
        + "Corners 1\n1\nTriangles 1\n1 3 2 0\nTetrahedra 1\n1 2 3 4 0\nEnd\n")
    put("mesh", "plane", "MeshVersionFormatted 1 Dimension 2 # two\nVertices 3 0 0 0 1 0 0 0 1 0 "
        "Triangles 1 1 2 3 0 EdgesP2 1 1 2 3 0")
    numbered = "".join(f"{i + 1} {p}\n" for i, p in enumerate(points))
    put("msh", "2", f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n{numbered}$EndNodes\n$Elements\n2\n"
        "1 4 2 0 1 1 2 3 4\n7 2 1 0 1 3 2\n$EndElements\n")
    put("msh", "4", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 4 3 9\n3 1 0 3\n3\n5\n9\n"
        + "\n".join(points[:3]) + "\n2 1 1 1\n4\n0 0 1 0.5 0.5\n$EndNodes\n"
        "$Elements\n1 1 1 1\n3 1 4 1\n1 3 5 9 4\n$EndElements\n")
    doubles = [struct.pack("<3d", *map(float, p.split())) for p in points]
    one = struct.pack("<i", 1)
    put("msh", "2-binary", b"$MeshFormat\n2.2 1 8\n" + one + b"\n$EndMeshFormat\n$Nodes\n4\n"
        + b"".join(struct.pack("<i", i + 1) + d for i, d in enumerate(doubles))
        + b"\n$EndNodes\n$Elements\n1\n" + struct.pack("<10i", 4, 1, 2, 1, 0, 1, 1, 2, 3, 4)
        + b"\n$EndElements\n")
    put("msh", "4-binary", b"$MeshFormat\n4.1 1 8\n" + one + b"\n$EndMeshFormat\n$Entities\n"
        + struct.pack("<4Q", 0, 0, 0, 0) + b"\n$EndEntities\n$Nodes\n"
        + struct.pack("<4Q3iQ4Q", 1, 4, 1, 4, 3, 1, 0, 4, 1, 2, 3, 4) + b"".join(doubles)
        + b"\n$EndNodes\n$Elements\n" + struct.pack("<4Q3iQ5Q", 1, 1, 1, 1, 3, 1, 4, 1, 1, 1, 2, 3, 4)
        + b"\n$EndElements\n")
    cube = [[(i >> axis & 1) for i in range(8)] for axis in range(3)]
    flat = [c for axis in cube for c in axis]
    put("plot3d", "text", "1\n2 2 2\n" + "\n".join(" ".join(map(str, axis)) for axis in cube) + "\n")
    put("plot3d", "plane", "2, 2\n0 1.0D0 0 1\n0 0 1 1\n")
    data = struct.pack("<24d", *flat)
    record = lambda content: struct.pack("<i", len(content)) + content + struct.pack("<i", len(content))
    put("plot3d", "records", record(one) + record(struct.pack("<3i", 2, 2, 2)) + record(data))
    put("plot3d", "plain-float", struct.pack(">3i24f8i", 2, 2, 2, *flat, *8 * [1]))

    def foam(kind, text, binary=False):
        arch = b'arch "LSB;label=32;scalar=64"; ' if binary else b""
        return (b"/* \\ */\nFoamFile { version 2.0; format " + (b"binary; " if binary else b"ascii; ") + arch
                + b"class " + kind.encode() + b"; }\n// *\n" + text)

    put("foam", "text", foam("vectorField", b"4\n(\n" + b"".join(f"({p})\n".encode() for p in points) + b")\n"))
    put("foam", "binary", foam("vectorField", b"4\n(" + b"".join(doubles) + b")\n// end\n", True))
    put("foam_lists", "faces", foam("faceList", b"2(3(0 1 2) 4(3 2 1 0))"))
    put("foam_lists", "compact", foam("faceCompactList", b"2\n(" + struct.pack("<2i", 0, 3) + b")\n3\n("
                                      + struct.pack("<3i", 0, 1, 2) + b")", True))
    put("foam_lists", "labels", foam("labelList", b"3(7 0 2)"))
    put("foam_lists", "uniform", foam("labelList", b"12{0}"))


def matrices():
    put("mtx", "real", "%%MatrixMarket matrix coordinate real general\n% two\n3 4 3\n"
                       "1 1 0.5\n3 4 -1e-3\n1 2 0.5\n")
    put("mtx", "integer", "%%MatrixMarket matrix coordinate integer general\n2 2 1\n2 1 -7\n")


def arrays():
    """Writes the arrays of a matrix as npz_fuzz.cpp reads them, and the matrix as PETSc writes it."""
    matrix = {
        "indptr": np.array([0, 2, 2, 3], dtype="<i4"),
        "indices": np.array([0, 1, 3], dtype="<i4"),
        "data": np.array([0.5, 0.25, -1]),
        "shape": np.array([3, 4]),
        "format": np.array(b"csr"),
    }
    parts = []
    for array in matrix.values():
        part = io.BytesIO()
        np.save(part, array)
        parts.append(part.getvalue())
    put("npz", "arrays", b"<>".join(parts))
    for bits, code in ((32, "i"), (64, "q")):
        head = struct.pack(f">4{code}", 1211216, 3, 4, 3)
        rows = struct.pack(f">3{code}", 2, 0, 1) + struct.pack(f">3{code}", 0, 1, 3)
        put("petsc", f"{bits}-bit", head + rows + struct.pack(">3d", 0.5, 0.25, -1))


def payloads():
    numbers = struct.pack("<6d", *range(6))
    packed = zlib.compress(numbers)
    blocks = struct.pack("<4Q", 1, 32768, len(numbers), len(packed))
    put("payload", "raw", bytes([2]) + struct.pack("<Q", len(numbers)) + numbers)
    put("payload", "raw-big-32", bytes([1]) + struct.pack(">I", len(numbers)) + numbers)
    put("payload", "zlib", bytes([6]) + blocks + packed)
    put("payload", "base64",
        bytes([10]) + base64.b64encode(struct.pack("<Q", len(numbers)) + numbers))
    put("payload", "base64-zlib", bytes([14]) + base64.b64encode(blocks) + base64.b64encode(packed))


def topologies():
    def options(dimension, built, rules=0, boundary=0, edges=(), vertices=(), holes=()):
        head = [dimension - 1, built, rules, boundary, 0, 0, 0, len(edges)]
        for tail, end, sharpness in edges:
            head += [tail, end, sharpness]
        head.append(len(vertices))
        for vertex, sharpness in vertices:
            head += [vertex, sharpness]
        head.append(2 * len(holes))
        return bytes([*head, *holes])

    counts = (4, 5, 6, 8)
    for kind, count in enumerate(counts):
        put("topology", f"standard-{kind}",
            options(3, 1, kind % 2) + bytes([count, kind, *range(count)]))
    boxes = bytes([12, 3, *range(8), 3, *range(4, 12)])
    put("topology", "boxes", options(3, 1) + boxes)
    put("topology", "boxes-open", options(3, 1, boundary=2) + boxes)
    put("topology", "boxes-edge-only", options(3, 1, boundary=1) + boxes)
    put("topology", "boxes-marked",
        options(3, 1, edges=[(0, 1, 5), (4, 5, 0), (8, 9, 3)], vertices=[(0, 0), (4, 5)]) + boxes)
    # A prism over a pentagon: seven loops.
    loops = [(4, 3, 2, 1, 0), (5, 6, 7, 8, 9), (0, 1, 6, 5), (1, 2, 7, 6), (2, 3, 8, 7),
             (3, 4, 9, 8), (4, 0, 5, 9)]
    prism = bytes([10, len(loops)]) + b"".join(bytes([len(loop), *loop]) for loop in loops)
    put("topology", "prism", options(3, 1) + prism)
    quads = bytes([6, 4, 0, 1, 2, 3, 4, 3, 2, 5, 4])
    for rules in range(3):
        put("topology", f"mesh-{rules}",
            options(2, 1, rules, edges=[(3, 2, 1)], vertices=[(0, 2)], holes=[0]) + quads)
    put("topology", "curve", options(1, 1) + bytes([3, 0, 0, 1, 0, 1, 2, 0, 2, 0]))
    # A triangle as relations: three edges of two vertices, one face of three edges.
    edges = b"".join(bytes([2, a, 0, b, 1]) for a, b in ((0, 1), (1, 2), (2, 0)))
    put("topology", "relations", options(2, 0) + bytes([3, 3]) + edges + bytes([1, 3, 0, 1, 1, 1, 2, 1]))


def bindings(target):
    cube = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0), (0, 0, 4), (4, 0, 4), (4, 4, 4), (0, 4, 4)]
    points = [(2, 2, 2), (1, 2, 3), (0, 0, 0), (9, 0, 0)]

    def integers(places):
        return b"".join(struct.pack("3b", *place) for place in places)

    def doubles(places):
        return b"".join(struct.pack("<3d", *place) for place in places)

    grid, anywhere = bytes([3, 0]), bytes([0, 0])
    for outside in range(3):
        head = bytes([3, 0, outside, 0])
        put(target, f"cube-{outside}", head + grid + integers(cube) + grid + integers(points))
    put(target, "cube-doubles", bytes([3, 0, 1, 0]) + anywhere + doubles(cube) + anywhere +
        doubles([(1, 2, 3), (float("nan"), 0, 0), (float("inf"), 1, 1), (1e308, 1e308, -1e308)]))
    put(target, "huge", bytes([3, 0, 1, 0, 3, 1]) + integers(cube) + bytes([3, 1]) +
        integers(points))
    put(target, "tiny", bytes([3, 0, 1, 0, 3, 3]) + integers(cube) + bytes([3, 3]) +
        integers(points))
    turned = [(x, y, -z) for x, y, z in cube]
    put(target, "inside-out", bytes([3, 0, 1, 0]) + grid + integers(turned) + grid +
        integers(points))
    folded = cube[:6] + [cube[7], cube[6]]
    put(target, "folded", bytes([3, 0, 1, 0]) + grid + integers(folded) + grid +
        integers(points))
    flat = [(x, y, 0) for x, y, z in cube]
    put(target, "flat", bytes([3, 0, 1, 0]) + grid + integers(flat) + grid +
        integers(points))
    pyramid = cube[:4] + [(2, 2, 4)]
    put(target, "pyramid", bytes([1, 1, 1, 0]) + grid + integers(pyramid) + grid +
        integers(points))
    tower = cube + [(x, y, z + 4) for x, y, z in cube[4:]]
    put(target, "tower", bytes([4, 0, 1, 1]) + struct.pack("<f", 0.01) + grid +
        integers(tower) + grid + integers(points))


def gltf():
    """A skinned triangle with a morph target, and one of quantised, sparse and interleaved numbers."""
    data = b""
    views, accessors = [], []

    def add(numbers, code, shape, width, **more):
        nonlocal data
        data += b"\0" * (-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(numbers) * struct.calcsize(code)})
        types = {"f": 5126, "B": 5121, "h": 5122, "H": 5123}
        accessors.append({"bufferView": len(views) - 1, "componentType": types[code], "count": len(numbers) // width,
                          "type": shape, **more})
        data += struct.pack(f"<{len(numbers)}{code}", *numbers)
        return len(accessors) - 1

    corners = [0, 0, 0, 1, 0, 0, 0, 1, 0]
    position = add(corners, "f", "VEC3", 3, min=[0, 0, 0], max=[1, 1, 0])
    normal = add([0, 0, 1] * 3, "f", "VEC3", 3)
    tangent = add([1, 0, 0, -1] * 3, "f", "VEC4", 4)
    target = add([0, 0, 1] * 3, "f", "VEC3", 3)
    joints = add([0, 1, 0, 0] * 3, "B", "VEC4", 4)
    weights = add([0.5, 0.5, 0, 0] * 3, "f", "VEC4", 4)
    small = add([0, 0, 0, 32767, 0, 0, 0, 32767, 0], "h", "VEC3", 3, normalized=True)
    strip = add([0, 1, 2], "H", "SCALAR", 1)
    sparse = add([0] * 9, "f", "VEC3", 3)
    where = add([2], "B", "SCALAR", 1)
    accessors[sparse]["sparse"] = {"count": 1, "indices": {"bufferView": where, "componentType": 5121},
                                   "values": {"bufferView": target}}
    binds = add([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] * 2, "f", "MAT4", 16)
    root = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, "skin": 0}, {"translation": [0, 0, 1]},
                  {"rotation": [0, 0, 0.6, 0.8], "scale": [1, 2, 3], "children": [0, 1, 3, 4]},
                  {"mesh": 1}, {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 5, 6, 7, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": position, "NORMAL": normal, "TANGENT": tangent,
                                                   "JOINTS_0": joints, "WEIGHTS_0": weights},
                                    "targets": [{"POSITION": target}]}]},
                   {"primitives": [{"attributes": {"POSITION": small}, "indices": strip, "mode": 5},
                                   {"attributes": {"POSITION": sparse}, "mode": 6}]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": binds}],
        "bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": len(data)}]}
    head = json.dumps(root).encode()
    head += b" " * (-len(head) % 4)
    body = data + b"\0" * (-len(data) % 4)
    put("gltf", "binary", b"glTF" + struct.pack("<III", 2, 28 + len(head) + len(body), len(head)) + b"JSON" + head +
        struct.pack("<I", len(body)) + b"BIN\0" + body)
    root["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    put("gltf", "text", json.dumps(root))


def main():
    espalier = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        lattices(espalier, Path(folder))
        bound_model(espalier, Path(folder))
    marked_lattice()
    models()
    gltf()
    meshes()
    matrices()
    arrays()
    payloads()
    topologies()
    bindings("embedding")
    bindings("limit")


if __name__ == "__main__":
    main()
