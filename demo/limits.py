# SPDX-License-Identifier: Apache-2.0
"""Prints the tables of docs/limits.md: how far levels are from the limit on the models of the demo,
and what each costs. With a second argument, also draws the error of level 2 of the star.

  limits.py FOLDER [PICTURE.png]    `espalier` must be on the path
"""

import json
import math
import pathlib
import shlex
import subprocess
import sys

import numpy as np

from images import column, legend, write_png
from picture import Drawing, Studio, View

SCENES = {"star": "disk", "barbell": "block", "figure": "figure"}
LEVELS = range(1, 7)
#: The width of a band of colour: an error, as a fraction of the size of the model.
BAND = 1e-3
COLOURS = ((0.93, 0.95, 0.97), (0.99, 0.91, 0.72), (0.98, 0.76, 0.45), (0.94, 0.55, 0.28),
           (0.84, 0.30, 0.18), (0.62, 0.09, 0.16))
HERE = pathlib.Path(__file__).resolve().parent


def run(folder, *command):
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


def make_lattices(folder, scene):
    """Makes the rest and the pose, by the commands that the gallery prints."""
    for line in run(folder, sys.executable, HERE / "scenes.py", scene).splitlines():
        if line.startswith("espalier shape"):
            run(folder, *shlex.split(line))


def points_of(path):
    with open(path, encoding="utf-8") as lines:
        return [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith("v ")]


def faces_of(path):
    with open(path, encoding="utf-8") as lines:
        return [[int(corner.split("/")[0]) - 1 for corner in line.split()[1:]]
                for line in lines if line.startswith("f ")]


def deform(folder, scene, *options):
    """The deformed points, the seconds of binding on one thread, and the entries a row."""
    report = json.loads(run(folder, "espalier", "deform", f"{SCENES[scene]}.obj", "--rest",
                            f"{scene}-rest.vtu", "--to", f"{scene}-posed.vtu", "-o", "limits.obj",
                            "--threads", "1", "--report", "json", *options))
    seconds = {stage["name"]: stage["seconds"] for stage in report["stages"]}
    inside = report["points"]["inside"]
    return points_of(folder / "limits.obj"), seconds["binding"], report["matrix"]["entries"] / inside


def size_of(points):
    """Diagonal of the bounding box."""
    return math.dist(*([pick(axis) for axis in zip(*points)] for pick in (min, max)))


def errors_of(points, limit):
    return [math.dist(p, q) for p, q in zip(points, limit)]


def print_table(folder, scene):
    limit, _, _ = deform(folder, scene, "--limit", "--tolerance", "1e-10")
    size = size_of(limit)
    print(f"\n| {scene}, {len(limit):,} points | mean error | improvement | largest error "
          "| binding, s | entries a row |")
    print("|---|---|---|---|---|---|")
    before = None
    for name, options in [*((f"level {n}", ("-n", str(n))) for n in LEVELS),
                          ("`--limit`", ("--limit",))]:
        points, seconds, weights = deform(folder, scene, *options)
        errors = [error / size for error in errors_of(points, limit)]
        mean = sum(errors) / len(errors)
        ratio = f"{before / mean:.1f}" if before and name.startswith("level") else ""
        text = [f"{x:.1e}" if name.startswith("level") else "" for x in (mean, max(errors))]
        print(f"| {name} | {text[0]} | {ratio} | {text[1]} | {seconds:.2f} | {weights:.0f} |")
        before = mean


def draw_error(folder, scene, level, path):
    """The deformed model of a level, coloured by its distance from the limit."""
    limit, _, _ = deform(folder, scene, "--limit", "--tolerance", "1e-10")
    points, _, _ = deform(folder, scene, "-n", str(level))
    error = np.array(errors_of(points, limit)) / size_of(limit)
    points, faces = np.array(points), faces_of(folder / f"{SCENES[scene]}.obj")
    bands = np.minimum([int(error[face].mean() / BAND) for face in faces], len(COLOURS) - 1)
    view = View.around([points], direction=(0.12, -0.25, 1), up=(1, 0, 0))
    drawing = Drawing()
    for band, colour in enumerate(COLOURS):
        drawing.add_faces(points, [face for face, of in zip(faces, bands) if of == band], colour)
    image = Studio(view, 640, occlusion=False).render(drawing)
    entries = [(colour, f"{band} to {band + 1}" if band + 1 < len(COLOURS) else f"{band} and more",
                "area") for band, colour in enumerate(COLOURS)]
    write_png(path, column([image, legend(entries, image.shape[1], size=14)]))


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    for scene in SCENES:
        make_lattices(folder, scene)
        print_table(folder, scene)
    if len(sys.argv) > 2:
        draw_error(folder, "star", 2, sys.argv[2])


if __name__ == "__main__":
    main()
