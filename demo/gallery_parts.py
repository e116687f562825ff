# SPDX-License-Identifier: Apache-2.0
"""Shared by the figures of the gallery: running the program, meshes, panels with the same view."""

import os
import shlex
import subprocess
from dataclasses import dataclass
from typing import Callable

import numpy as np

from images import captioned, row
from picture import Studio, View

# Colours by Okabe and Ito, which colour-blind readers can distinguish.
RED, GREEN, BLUE = (0.84, 0.37, 0.00), (0.00, 0.62, 0.45), (0.00, 0.45, 0.70)
DARK = (0.30, 0.31, 0.34)
#: Pale colours of surfaces, on which lines in the colours above are visible.
PALE_SKY, PALE_ORANGE = (0.72, 0.87, 0.95), (0.97, 0.82, 0.58)
AMBER, STONE = (0.97, 0.74, 0.30), (0.88, 0.87, 0.84)


@dataclass
class Figure:
    """A figure of the gallery. `draw` takes a Program and returns an image. A {name} in the caption
    is replaced by the value that `draw` stored in the program's `numbers`."""

    name: str
    title: str
    source: str
    caption: str
    draw: Callable


class Program:
    """Runs espalier and the examples in a folder. Records the commands, and numbers that figures
    measure."""

    def __init__(self, places, folder):
        """`places` are the folders of espalier and of the examples, and of their Python."""
        self.folder = folder
        self.search = os.pathsep.join([*map(str, places), os.environ["PATH"]])
        self.commands, self.numbers = [], {}

    def write(self, mesh, name, word="f"):
        """Writes a mesh for the program to read, and notes it once."""
        mesh.write(self.file(name), word)
        self.note(f"{name}: {len(mesh.points)} points, written by the script")
        return mesh

    def note(self, text):
        """Adds a comment on the origin of a file to the commands, once."""
        if f"# {text}" not in self.commands:
            self.commands.append(f"# {text}")

    def run(self, command):
        """Runs `espalier COMMAND`, and returns what it printed."""
        return self.run_any(f"espalier {command}")

    def run_any(self, command, environment=None):
        """Runs a command: espalier, an example, or a launcher of one."""
        self.commands.append(command)
        done = subprocess.run(shlex.split(command), cwd=self.folder, text=True,
                              capture_output=True, check=False,
                              env={**os.environ, "PATH": self.search, **(environment or {})})
        if done.returncode:
            raise SystemExit(f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def file(self, name):
        return self.folder / name


@dataclass
class Mesh:
    """Points, and faces or lines as lists of points."""

    points: np.ndarray
    loops: list

    def __post_init__(self):
        # VTK's tubes would round integer points.
        self.points = np.asarray(self.points, float)

    @classmethod
    def read(cls, path):
        """Reads the `v`, `f` and `l` lines of an OBJ file that the program wrote."""
        points, loops = [], []
        for line in path.read_text(encoding="utf-8").splitlines():
            word, _, rest = line.partition(" ")
            if word == "v":
                points.append([float(x) for x in rest.split()[:3]])
            elif word in ("f", "l"):
                loops.append([int(v) - 1 for v in rest.split()])
        return cls(points, loops)

    def write(self, path, word="f"):
        lines = [" ".join(["v", *(f"{x:.17g}" for x in p)]) for p in self.points]
        lines += [" ".join([word, *(str(v + 1) for v in loop)]) for loop in self.loops]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    @property
    def edges(self):
        return np.array(sorted({(min(a, b), max(a, b)) for loop in self.loops
                                for a, b in zip(loop, loop[1:] + loop[:1])}))


@dataclass
class Look:
    """The view of all panels of a picture."""

    direction: tuple
    up: tuple = (0, 0, 1)
    height: int = 300
    occlusion: bool = True
    margin: float = 0.04


def render(drawings, look, points=None):
    """Returns images of drawings from one view that contains all their points (or the given ones),
    and the studio that made them."""
    if points is None:
        points = [p for drawing in drawings for p in drawing.points]
    view = View.around(points, look.direction, look.up, margin=look.margin)
    studio = Studio(view, look.height, look.occlusion)
    return [studio.render(drawing) for drawing in drawings], studio


def panels(drawings, captions, look, size=17, points=None, gap=16, width=0):
    """Returns drawings side by side with the same view, a caption under each, each at least `width`
    wide."""
    images, _ = render(drawings, look, points)
    images = [centred(image, max(width, image.shape[1])) for image in images]
    return row([captioned(image, caption, size) for image, caption in zip(images, captions)], gap)


def centred(image, width):
    """An image in the middle of a wider one."""
    spare = width - image.shape[1]
    return np.pad(image, [(0, 0), (spare // 2, spare - spare // 2), (0, 0)], constant_values=1)


def extent(points, look):
    """Returns the height of the window that contains all points, the unit of line widths."""
    return View.around([points], look.direction, look.up, margin=look.margin).extent
