#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs long commands, and requires that a host could cancel each of them at any time.

polled_program.cpp is the program with a host that is asked at each poll (base/progress.h) and measures the time of the
processor between two polls. That is how long Ctrl-C waits, for example in Python. Time of the processor does not depend
on what else runs; instructions would depend on it even less, but only valgrind counts them everywhere, and it takes
fifty times as long. `info` is not here: its loops are the program's own, which a signal ends at once.

Ctrl-C is to take less than half a second, with any input. A stage without polls takes the longer the larger its input
is, and the inputs here are small. So the test requires much less.

usage: polls_test.py PROGRAM [NAME...]
"""

import os
import pathlib
import random
import subprocess
import sys
import tempfile

# Seconds between two polls. Most polls are a few milliseconds apart; 0.06 s passed between those of a cage, and of `io`,
# which the preset `test` does not optimize, on a busy machine. Before these steps were polled, 0.24 s or more passed.
LIMIT = 0.2
# A page that the system has to clear, or a cache that another program has emptied, may make one run slow. A missing
# poll makes all runs slow.
RUNS = 3


def grid(size):
    """Returns the points and the hexahedra of a cube of size³ cells."""
    n = size + 1
    points = [(i / size, j / size, k / size) for k in range(n) for j in range(n) for i in range(n)]
    steps = (0, 1, n + 1, n)
    corners = [*steps, *(n * n + step for step in steps)]
    cells = [[i + n * (j + n * k) + corner for corner in corners]
             for k in range(size) for j in range(size) for i in range(size)]
    return points, cells


def lines(rows):
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


def su2(size):
    points, cells = grid(size)
    return (f"NDIME= 3\nNELEM= {len(cells)}\n" + lines((12, *cell) for cell in cells)
            + f"NPOIN= {len(points)}\n" + lines(points) + "NMARK= 0\n")


def gmsh(size):
    points, cells = grid(size)
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n"
            + lines((i + 1, *point) for i, point in enumerate(points)) + f"$EndNodes\n$Elements\n{len(cells)}\n"
            + lines((i + 1, 5, 2, 1, 1, *(corner + 1 for corner in cell)) for i, cell in enumerate(cells))
            + "$EndElements\n")


def medit(size):
    points, cells = grid(size)
    return (f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n" + lines((*point, 0) for point in points)
            + f"Hexahedra\n{len(cells)}\n" + lines((*(corner + 1 for corner in cell), 0) for cell in cells) + "End\n")


def plot3d(size):
    points, _ = grid(size)
    return f"1\n{size + 1} {size + 1} {size + 1}\n" + "".join(
        lines([point[axis]] for point in points) for axis in range(3))


def openfoam(folder, size):
    """Writes a case, whose faces are between two cells, or of one."""
    points, cells = grid(size)
    sides = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
    found = {}
    for number, cell in enumerate(cells):
        for side in sides:
            loop = [cell[i] for i in side]
            found.setdefault(min(loop), {}).setdefault(frozenset(loop), [loop]).append(number)
    faces = [face for least in found.values() for face in least.values()]
    faces.sort(key=lambda face: (len(face) == 2, face[1], face[-1]))
    inner = sum(len(face) == 3 for face in faces)
    mesh = folder / "case/constant/polyMesh"
    mesh.mkdir(parents=True)
    (folder / "case/system").mkdir()

    def write(name, kind, rows):
        (mesh / name).write_text(f"FoamFile\n{{\nformat ascii;\nclass {kind};\nobject {name};\n}}\n{len(rows)}\n(\n"
                                 + "\n".join(rows) + "\n)\n")
    write("points", "vectorField", ["(%r %r %r)" % point for point in points])
    write("faces", "faceList", ["4(%d %d %d %d)" % tuple(face[0]) for face in faces])
    write("owner", "labelList", [str(face[1]) for face in faces])
    write("neighbour", "labelList", [str(face[2]) for face in faces[:inner]])
    write("boundary", "polyBoundaryMesh",
          [f"walls\n{{\ntype wall;\nnFaces {len(faces) - inner};\nstartFace {inner};\n}}"])


def loose_points(count):
    """Points on a sphere: no side of a box is near many of them."""
    numbers = random.Random(1)
    rows = []
    for _ in range(count):
        point = [numbers.gauss(0, 1) for _ in range(3)]
        size = sum(x * x for x in point) ** 0.5
        rows.append(("v", *(x / size for x in point)))
    return lines(rows)


DEFORM = ["--rest", "rest.vtu", "--to", "pose.vtu", "-n", "2"]

# Commands that make inputs.
PREPARE = [
    "shape box --cells 3 3 3 --min -1.1 -1.1 -1.1 --max 1.1 1.1 1.1 -o rest.vtu",
    "pose rest.vtu --twist z 20 -o pose.vtu",
    "shape torus -o torus.vtu",
    "refine torus.vtu -n 4 -o model.obj",
    "deform model.obj --rest rest.vtu --to rest.vtu -n 1 --outside nearest -o model.ply",
    "deform model.obj --rest rest.vtu --to rest.vtu -n 1 --outside nearest -o model.stl",
    "deform model.obj --rest rest.vtu --to rest.vtu -n 1 --outside nearest -o model.vtp",
    "shape box --cells 40 40 40 -o box.vtu",
    "shape box --cells 40 40 40 -o box.ovm",
    "shape box --cells 40 40 40 --min 1 0 0 --max 2 1 1 -o beside.vtu",
    "shape box --cells 12 12 12 -o small.vtu",
    "pose small.vtu --twist z 20 -o twisted.vtu",
    "refine torus.vtu -n 3 -o small.obj",
    "deform small.obj --rest rest.vtu --to pose.vtu -n 2 --outside nearest -o small.ply",
    "bind model.obj --rest rest.vtu -n 2 --outside nearest -o model.espb",
]

# For each name: the arguments of the program.
COMMANDS = {
    "cage": "shape cage model.obj --vertices 100 -o out.vtu",
    "around": "shape around sphere.obj --oriented -o out.vtu",
    "around in many cells": "shape around torus.vtu --cells 40 -o out.vtu",
    "merge": "shape merge box.vtu beside.vtu -o out.vtu",
    "pose": "pose box.vtu --select ball 0 0 0 1 --falloff smooth 1 --twist z 20 -o out.vtu",
    "bind": "bind model.obj --rest rest.vtu -n 4 --outside nearest -o out.espb",
    "bind to the limit": "bind model.obj --rest rest.vtu --limit --outside nearest -o out.espb",
    "bind by a basis": "bind model.obj --rest rest.vtu --basis bezier --outside nearest -o out.espb",
    "apply": "apply model.espb --to pose.vtu -o out.obj",
    **{f"deform {name} to {output}": ["deform", name, *DEFORM, "--outside", "nearest", "-o", output] for name, output in [
        ("model.obj", "out.obj"), ("model.obj", "out.ply"), ("model.obj", "out.stl"), ("model.obj", "out.vtp"),
        ("model.obj", "out.glb"), ("model.obj", "out.pc2"), ("model.ply", "out.ply"), ("model.stl", "out.stl"),
        ("model.vtp", "out.vtp"), ("cube.su2", "out.su2"), ("cube.msh", "out.msh"), ("cube.mesh", "out.mesh"),
        ("cube.xyz", "out.xyz"), ("case", "points"), ("box.vtu", "out.vtu")]},
    "fit": "fit small.obj --rest rest.vtu --targets small.ply --smoothing laplacian --outside nearest -o out.vtu",
    "check": "check pose.vtu --rest rest.vtu -n 4",
    "check the limit": "check twisted.vtu --rest small.vtu --limit -n 1",
    "refine": "refine rest.vtu -n 4 -o out.vtu",
    "refine to .ovm": "refine rest.vtu -n 4 -o out.ovm",
    "refine from .ovm": "refine box.ovm -n 1 -o out.vtk",
    "refine to a mesh": "refine torus.vtu -n 4 -o out.obj",
    "stencils": "stencils rest.vtu -n 4 -o out.npz",
    "stencils as text": "stencils rest.vtu -n 3 -o out.mtx",
    "stencils of points": "stencils rest.vtu --points model.obj --limit --gradients --outside nearest -o out.npz",
}


def prepare(program, folder):
    for name, text in [("cube.su2", su2(36)), ("cube.msh", gmsh(36)), ("cube.mesh", medit(36)), ("cube.xyz", plot3d(36)),
                       ("sphere.obj", loose_points(200_000))]:
        (folder / name).write_text(text)
    openfoam(folder, 30)
    for command in PREPARE:
        run(program, command.split(), folder)


def run(program, arguments, folder, **more):
    done = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, **more)
    if done.returncode not in (0, 3):  # 3: cells are inverted
        sys.exit(f"{' '.join(arguments)} failed:\n{done.stderr}")


def measure(program, arguments, folder):
    """Returns the longest time between two polls, when it ended, and the whole time, of the best of RUNS runs."""
    best = None
    for _ in range(RUNS):
        polls = folder / "polls"
        run(program, arguments, folder, env={**os.environ, "ESPALIER_TEST_POLLS": str(polls)})
        got = tuple(map(float, polls.read_text().split()))
        best = min(best or got, got)
        if best[0] <= LIMIT:
            break
    return best


def main():
    program, names = os.path.abspath(sys.argv[1]), sys.argv[2:] or list(COMMANDS)
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        prepare(program, folder)
        for name in names:
            command = COMMANDS[name]
            longest, end, whole = measure(program, command.split() if isinstance(command, str) else command, folder)
            print(f"{name}: {longest:.3f} s between two polls, after {end:.2f} of {whole:.2f} s", flush=True)
            if longest > LIMIT:
                failed.append(f"{name} cannot be cancelled for {longest:.3f} s")
    if failed:
        print(f"expected at most {LIMIT} s between two calls of checkCancelled() (base/progress.h):", *failed, sep="\n  ")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
