# SPDX-License-Identifier: Apache-2.0
"""The mesh of a half wing, as a file of SU2: what examples/wing_design.py takes if it is given no mesh.

The wing is straight, with one section from the plane of symmetry, z = 0, to its tip. Rings of hexahedra are around the
section; beyond the tip, the section itself is filled with hexahedra and two rows of wedges.
"""

import numpy as np

from panel_method import naca

HEXAHEDRON, WEDGE, QUAD, TRIANGLE = 12, 13, 9, 5  # SU2's numbers of cells and faces


def rings(section, layers, radius):
    """Points around a section: array (layers + 1, points), from the section to a circle. Lines from the section to the
    circle do not cross, since the points of naca() are below and above evenly spaced points of a circle."""
    outer = 0.5 + radius * np.exp(2j * np.pi * np.arange(len(section)) / len(section))
    share = np.linspace(0, 1, layers + 1)[:, None] ** 2.2
    return (1 - share) * section + share * outer


def make_mesh(span=3.0, stations=20, beyond=6, layers=9, panels=48, radius=3.0):
    """Returns points, an array (N, 3), cells and faces of markers, as lists of SU2's number and vertices."""
    section = naca(0.02, 0.12, panels)
    plane = rings(section, layers, radius)
    z = np.append(np.linspace(0, span, stations + 1), span * (1 + np.linspace(0, 0.8, beyond + 1)[1:]))
    points = np.array([(p.real, p.imag, height) for height in z for p in plane.ravel()])

    def number(k, layer, i):
        return (k * (layers + 1) + layer) * panels + i % panels

    cells, wing, symmetry, far = [], [], [], []
    pairs = [(i, panels - i) for i in range(panels // 2 + 1)]  # points above, and below
    filling = [[(a, 0), (b, 0), (c, 0), (d, 0)] for (a, d), (b, c) in zip(pairs, pairs[1:])]
    for loop in filling:  # the loops at both edges are triangles
        loop[:] = [corner for n, corner in enumerate(loop) if (corner[0] % panels, 0) not in
                   [(before[0] % panels, 0) for before in loop[:n]]]
    around = [[(i, layer), (i, layer + 1), (i + 1, layer + 1), (i + 1, layer)]
              for layer in range(layers) for i in range(panels)]

    def face(k, loop):
        return [QUAD if len(loop) == 4 else TRIANGLE] + [number(k, layer, i) for i, layer in loop]

    for k in range(len(z) - 1):
        for loop in around + (filling if k >= stations else []):
            cells.append([HEXAHEDRON if len(loop) == 4 else WEDGE, *face(k, loop)[1:], *face(k + 1, loop)[1:]])
        for i in range(panels):
            far.append([QUAD, number(k, layers, i), number(k, layers, i + 1), number(k + 1, layers, i + 1),
                        number(k + 1, layers, i)])
            if k < stations:
                wing.append([QUAD, number(k, 0, i + 1), number(k, 0, i), number(k + 1, 0, i), number(k + 1, 0, i + 1)])
    wing += [face(stations, loop) for loop in filling]
    symmetry += [face(0, loop[::-1]) for loop in around]
    far += [face(len(z) - 1, loop) for loop in around + filling]
    return points, cells, {"wing": wing, "symmetry": symmetry, "far": far}


def write_su2(path, points, cells, markers):
    lines = ["NDIME= 3", f"NELEM= {len(cells)}"]
    lines += [" ".join(map(str, cell)) + f" {n}" for n, cell in enumerate(cells)]
    lines.append(f"NPOIN= {len(points)}")
    lines += [f"{x:.17g} {y:.17g} {z:.17g} {n}" for n, (x, y, z) in enumerate(points)]
    lines.append(f"NMARK= {len(markers)}")
    for name, faces in markers.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(faces)}"]
        lines += [" ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def read_triangles(path, marker):
    """Returns the faces of a marker of a mesh of SU2 as triangles: array (F, 3)."""
    triangles, left, name = [], 0, None
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split("%")[0].replace("=", "= ").split()
        if left > 0 and words:
            left -= 1
            if name == marker:
                corners = [int(word) for word in words[1:5 if int(words[0]) == QUAD else 4]]
                triangles += [[corners[0], b, c] for b, c in zip(corners[1:], corners[2:])]
        elif words and words[0] == "MARKER_TAG=":
            name = words[1]
        elif words and words[0] == "MARKER_ELEMS=":
            left = int(words[1])
    if not triangles:
        raise ValueError(f"{path} has no faces of a marker {marker}")
    return np.array(triangles)
