#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A case of OpenFOAM from start to end: turns the aerofoil of a tutorial by a lattice, and runs a solver.

    openfoam_foil.py TUTORIAL [CASE] [--degrees 4] [--iterations 40]

TUTORIAL is the folder incompressible/simpleFoam/airFoil2D of OpenFOAM's tutorials (in Debian's package
openfoam-examples: /usr/share/doc/openfoam-examples/examples/incompressible/simpleFoam/airFoil2D). CASE is the
folder to make (foil); the case at rest is made beside it (foil-rest). The steps:

1. copy the case, and read its mesh;
2. make a lattice around the aerofoil, and bind the points of the mesh to it: the matrix D;
3. turn the inner vertices of the lattice, and hold the outer ones, so that the mesh stays smooth;
4. prove that no cell is inverted, or else turn by nine tenths of the largest step that inverts none;
5. write the points, and let checkMesh and simpleFoam judge them;
6. compute how the area of the aerofoil depends on each lattice vertex, by D, and check it by differences.
"""

import argparse
import gzip
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys

import espalier
import numpy as np

# Debian's programs do not set this.
ENVIRONMENT = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}

FORCES = """
functions
{
    forceCoeffs
    {
        type forceCoeffs; libs ("libforces.so"); patches (walls); rho rhoInf; rhoInf 1;
        liftDir (-0.139 0.990 0); dragDir (0.990 0.139 0); CofR (0 0 0); pitchAxis (0 0 1);
        magUInf 26; lRef 35; Aref 1.75; writeControl timeStep; writeInterval 1;
    }
}
"""


def run(case, program):
    """Runs a program of OpenFOAM in a case, and returns what it prints."""
    result = subprocess.run([program], cwd=case, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)
    if result.returncode != 0:
        sys.exit(f"{program} failed:\n{result.stdout[-2000:]}")
    return result.stdout


def copy_case(tutorial, case, iterations):
    """Copies a tutorial, of which Debian compresses some files, and sets the number of iterations."""
    shutil.copytree(tutorial, case)
    for path in case.rglob("*.gz"):
        path.with_suffix("").write_bytes(gzip.decompress(path.read_bytes()))
        path.unlink()
    control = case / "system/controlDict"
    text = re.sub(r"endTime .*;", f"endTime {iterations};", control.read_text())
    control.write_text(re.sub(r"writeInterval .*;", f"writeInterval {iterations};", text) + FORCES)


def patch_faces(case, name):
    """Returns the faces of a patch: array (F, 4) of points."""
    mesh = case / "constant/polyMesh"
    patch = re.search(rf"\b{name}\s*{{([^}}]*)}}", (mesh / "boundary").read_text()).group(1)
    first = int(re.search(r"startFace\s+(\d+)", patch).group(1))
    count = int(re.search(r"nFaces\s+(\d+)", patch).group(1))
    faces = re.findall(r"4\((\d+) (\d+) (\d+) (\d+)\)", (mesh / "faces").read_text())
    return np.array(faces[first:first + count], dtype=int)


def area(points, faces):
    """Returns the area of the section of a body whose wall is one layer of quadrilaterals along z, and its
    derivative by all points: 1/2 of the integral of (x, y) · n over the wall, divided by its thickness. The
    normals of the wall point into the body."""
    a, b, c, d = (points[faces[:, i]] for i in range(4))
    thickness = np.ptp(points[faces.ravel(), 2])
    # The area vector of a quadrilateral is half the cross product of its diagonals.
    p, q = c - a, d - b
    normal = 0.5 * np.cross(p, q)
    middle = (a + b + c + d) / 4
    value = -0.5 * np.sum(middle[:, :2] * normal[:, :2]) / thickness
    # Derivatives: the middle moves by a quarter of each corner; d(½ p × q) = ½ (dp × q + p × dq).
    flat_middle = np.column_stack([middle[:, :2], np.zeros(len(faces))])
    flat_normal = np.column_stack([normal[:, :2], np.zeros(len(faces))])
    by_p, by_q = 0.5 * np.cross(q, flat_middle), 0.5 * np.cross(flat_middle, p)
    gradient = np.zeros_like(points)
    for i, part in enumerate((-by_p, -by_q, by_p, by_q)):
        np.add.at(gradient, faces[:, i], part + flat_normal / 4)
    gradient[:, 2] = 0  # The thickness is given.
    return value, -0.5 * gradient / thickness


def lattice_around(foil):
    """Returns a box of cells around points, wide enough for its outer layers to be held."""
    low, high = foil.min(axis=0), foil.max(axis=0)
    size = high - low
    margin = np.array([0.6 * size[0], 3 * size[1], 0.5 * size[2]])
    return espalier.shapes.box(cells=(8, 8, 1), min=low - margin, max=high + margin)


def turned(lattice, degrees):
    """Returns the vertices of a lattice, turned about z. The inner ones turn by all of the angle, and the two
    outer layers by nothing, so that the mesh around the lattice continues without a bend."""
    positions = lattice.positions.copy()
    low, high = positions.min(axis=0), positions.max(axis=0)
    middle = (low + high) / 2
    # 1 in the middle, 0 in the two outer layers of the 9 along x and y.
    place = np.abs(positions - middle)[:, :2] / (high - low)[:2] * 8
    share = np.clip((3 - place.max(axis=1)) / 1, 0, 1)
    angle = -np.radians(degrees) * share
    x, y = (positions - middle)[:, 0], (positions - middle)[:, 1]
    positions[:, 0] = middle[0] + np.cos(angle) * x - np.sin(angle) * y
    positions[:, 1] = middle[1] + np.sin(angle) * x + np.cos(angle) * y
    return positions


def solve(case):
    """Runs the solver. Returns the coefficients of drag and lift in its last iteration."""
    run(case, "simpleFoam")
    lines = next(case.glob("postProcessing/forceCoeffs/*/coefficient.dat")).read_text().splitlines()
    header = next(line for line in lines if "Cl" in line).lstrip("# ").split()
    values = dict(zip(header, map(float, lines[-1].split())))
    return values["Cd"], values["Cl"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("tutorial", type=pathlib.Path)
    parser.add_argument("case", type=pathlib.Path, nargs="?", default=pathlib.Path("foil"))
    parser.add_argument("--degrees", type=float, default=4)
    parser.add_argument("--iterations", type=int, default=40)
    options = parser.parse_args()
    rest_case, case = options.case.with_name(options.case.name + "-rest"), options.case
    for folder in (rest_case, case):
        copy_case(options.tutorial, folder, options.iterations)

    model = espalier.read_model(case)
    walls = patch_faces(case, "walls")
    lattice = lattice_around(model.positions[np.unique(walls)])
    binding = espalier.bind(lattice, model.positions, level=3)
    print(f"mesh                {len(model.positions)} points; {len(binding.kept)} of them outside the lattice")

    pose = turned(lattice, options.degrees)
    check = espalier.MeshCheck(model)
    moved = binding.deform(pose)
    validity, step = check.check(moved), check.largest_step(moved)
    print(f"cells               {check.cell_count}; the pose inverts {len(validity.inverted)}; worst volume "
          f"ratio {validity.smallest[1]:.3f}")
    if step.length < 1:
        # At the whole step a cell has no volume left, so stop before.
        print(f"largest step        {step.length:.6f} of the pose; {0.9 * step.length:.6f} is written")
        pose = lattice.positions + 0.9 * step.length * (pose - lattice.positions)
        moved = binding.deform(pose)
    before, after = check.quality(model.positions), check.quality(moved)
    for name in ("non_orthogonality", "skewness"):
        print(f"{name:<19} {before[name]:.3f} before, {after[name]:.3f} after")
    model.write(case, moved)
    print("checkMesh           " + re.search(r"(Min volume = \S+)\.", run(case, "checkMesh")).group(1))

    for name, folder in (("at rest", rest_case), ("turned", case)):
        drag, lift = solve(folder)
        print(f"simpleFoam          {name}: drag {drag:.4f}, lift {lift:.4f} after {options.iterations} "
              "iterations")

    # The area of the section by the vertices of the lattice: D transposed, times its derivative by the points.
    value, by_points = area(moved, walls)
    by_lattice = binding.adjoint(by_points)
    print(f"area                {value:.6f}; at rest {area(model.positions, walls)[0]:.6f}")
    # The area is quadratic in the points, and the points are linear in the lattice, so that central differences
    # have no error but rounding.
    largest, h = 0.0, 0.5
    for vertex in np.argsort(-np.abs(by_lattice[:, 1]))[:10]:
        for axis in (0, 1):
            ends = []
            for sign in (1, -1):
                changed = pose.copy()
                changed[vertex, axis] += sign * h
                ends.append(area(binding.deform(changed), walls)[0])
            largest = max(largest, abs((ends[0] - ends[1]) / (2 * h) - by_lattice[vertex, axis]))
    print(f"sensitivity         largest derivative {np.abs(by_lattice).max():.4f}; differs by {largest:.1e} from "
          "central differences")
    if not largest <= 1e-10 * max(1.0, float(np.abs(by_lattice).max())):
        sys.exit("the sensitivity is wrong")


if __name__ == "__main__":
    main()
