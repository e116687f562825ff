# SPDX-License-Identifier: Apache-2.0
"""Draws a wing with less induced drag, by examples/wing_design.py."""

import pathlib
import re
import shutil
import sys

import numpy as np

from chart import line_chart
from gallery_parts import AMBER, BLUE, PALE_SKY, Figure, Look, Mesh, extent, render
from geometry_files import LatticeFile
from images import captioned, column, legend, row
from picture import GHOST, LATTICE, Drawing

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "examples"))
from wing_mesh import make_mesh  # noqa: E402

# From behind and above, along the trailing edge.
BEHIND = Look((1, 0.7, 0.35), up=(0, 1, 0), height=190, occlusion=False, margin=0.03)


def draw_wing(program):
    module = pathlib.Path(shutil.which("espalier", path=program.search)).resolve().parents[1] / "python"
    printed = program.run_any("wing_design.py --work .", {"PYTHONPATH": str(module)})
    program.note("it makes wing.su2; wing_design.py takes the mesh of another wing as an argument")
    program.note("if python3 is not Debian's: /usr/bin/python3 examples/wing_design.py ...")
    lines = printed.splitlines()
    for name, value in zip(("points", "cells"), re.findall("[0-9]+", lines[0])):
        program.numbers[name] = f"{int(value):,}"
    program.numbers["less"] = re.match("([0-9.]+) %", lines[-1])[1]
    program.numbers["ratio"] = f"{min(float(line.split()[4]) for line in lines[2:-1]):.2f}"
    _, _, markers = make_mesh()
    loops = [face[1:] for face in markers["wing"]]
    rest, pose = (LatticeFile(program.file(f"{name}.vtu")) for name in ("rest", "pose"))
    before, after = (points_of(program.file(f"{name}.su2")) for name in ("wing", "optimised"))
    moved = np.linalg.norm(pose.points - rest.points, axis=1) > 1e-9
    # One layer of the lattice on each side of the wing would hide it: the layer below it.
    heights = np.unique(np.round(rest.points[:, 1], 9))
    layer = np.isclose(rest.points[:, 1], heights[np.searchsorted(heights, -0.1) - 1])
    shown = rest.edges[(layer & moved)[rest.edges].all(axis=1)]
    line = 0.0022 * extent(before, BEHIND)
    drawings = []
    for points, lattice in ((before, rest), (after, pose)):
        drawing = Drawing().add_faces(*used(points, loops), PALE_SKY, smooth=True)
        drawing.add_edges(*used(lattice.points, shown), LATTICE, line)
        drawings.append(drawing.add_points(lattice.points[np.unique(shown)], LATTICE, 2.2 * line))
    images, _ = render(drawings, BEHIND)
    wings = column([captioned(image, caption, 17) for image, caption in zip(
        images, ("The wing, and a layer of its lattice", "With less induced drag at the same lift"))])
    place, first, last = np.loadtxt(program.file("strips.txt")).T
    span = 3.0
    width = np.gradient(place)
    ellipse = np.sqrt(1 - (place / span) ** 2)
    ellipse *= (first * width).sum() / (ellipse * width).sum()
    curves = [(np.stack([place / span, y], axis=1), colour, thickness) for y, colour, thickness in
              ((ellipse, AMBER, 7), (first, GHOST, 2), (last, BLUE, 2))]
    chart = line_chart(curves, [0, 0.2, 0.4, 0.6, 0.8, 1], [0, 0.1, 0.2, 0.3, 0.4], "share of the half span", "circulation",
                       (520, wings.shape[0]))
    picture = row([wings, chart], gap=24)
    return column([picture, legend([(LATTICE, "lattice", "line"), (PALE_SKY, "wing", "area"), (GHOST, "before", "line"),
                                    (AMBER, "ellipse", "line"), (BLUE, "after", "line")], picture.shape[1], size=17)],
                  gap=6)


def used(points, loops):
    """Points of faces, and the faces by their numbers."""
    numbers, inverse = np.unique(np.concatenate(loops), return_inverse=True)
    ends = np.cumsum([len(loop) for loop in loops])
    mesh = Mesh(points[numbers], [part.tolist() for part in np.split(inverse, ends[:-1])])
    return mesh.points, mesh.loops if len(set(map(len, loops))) > 1 else np.array(mesh.loops)


def points_of(path):
    """The points of a mesh of SU2."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("NPOIN="))
    count = int(lines[first].split("=")[1])
    return np.array([line.split()[:3] for line in lines[first + 1:first + 1 + count]], float)


FIGURES = [
    Figure(
        "wing", "A wing gets less induced drag", "examples/wing_design.py",
        "A straight wing of aspect ratio 6 in a lattice whose outer vertices stay. Twenty variables turn, stretch, bend and "
        "thicken its sections. A panel method and a lifting line compute lift and induced drag; Dᵀ carries their gradients by "
        "the {points} points of the mesh to the variables. In ten steps the induced drag falls by {less} % at the same lift, "
        "and no section gets thinner. An ellipse is the best distribution of the circulation for a span. On six of eight "
        "strips the circulation is within 2 % of it; on the two at the tip it stays 9 % and 41 % above. All {cells} cells of "
        "the mesh are valid in each step: the smallest ratio of volumes is {ratio}.",
        draw_wing),
]
