# SPDX-License-Identifier: Apache-2.0
from typing import Literal, Sequence

from numpy.typing import ArrayLike

from . import Lattice, Model

_Core = Literal["wedges", "polygon"]

def box(
    cells: Sequence[int] = ..., min: Sequence[float] = ..., max: Sequence[float] = ...
) -> Lattice: ...
def around(
    points: ArrayLike,
    *,
    cells: int | Sequence[int] | None = None,
    cell_size: float = 0.0,
    margin: float = 0.05,
    oriented: bool = False,
    symmetry: Literal["x", "y", "z"] | None = None,
    symmetry_at: float = 0.0,
) -> Lattice: ...
def cage(
    model: Model | Sequence[Model] | ArrayLike,
    faces: ArrayLike | Sequence[ArrayLike] | None = None,
    *,
    vertices: int = 200,
    cell_size: float = 0.0,
    margin: float = 0.0,
    shell: float = 0.0,
    keep_apart: bool = False,
    symmetric: Literal["auto", "none", "x", "y", "z", "xy", "xz", "yz", "xyz"] = "auto",
    symmetry: float = 1e-4,
) -> Lattice: ...
def collar(
    lattice: Lattice,
    *,
    layers: int = 3,
    reach: float = 0.0,
    until: Sequence[Sequence[float]] | None = None,
    open: str | Sequence[str] = "",
    held: int = 0,
) -> Lattice: ...
def cylinder(
    *,
    sectors: int = 8,
    rings: int = 1,
    core: _Core = "wedges",
    layers: int = 1,
    radius: float = 1.0,
    start: Sequence[float] = ...,
    end: Sequence[float] = ...,
) -> Lattice: ...
def torus(
    *,
    segments: int = 8,
    section: Literal["grid", "disk"] = "grid",
    grid_cells: int = 1,
    sides: int = 6,
    rings: int = 1,
    core: _Core = "wedges",
    major_radius: float = 1.0,
    minor_radius: float = 0.4,
) -> Lattice: ...
def star(
    *,
    points: int = 5,
    rings: int = 1,
    core: _Core = "wedges",
    layers: int = 1,
    inner_radius: float = 0.5,
    outer_radius: float = 1.0,
    height: float = 0.25,
) -> Lattice: ...
def barbell(
    *,
    end_segments: int = 6,
    bar_segments: int = 2,
    bar_across: int = 2,
    rings: int = 1,
    core: _Core = "wedges",
    layers: int = 1,
    end_radius: float = 1.0,
    bar_length: float = 2.0,
    bar_half_width: float = 0.4,
    roundness: float = 1.0,
    height: float = 0.5,
) -> Lattice: ...
def arm(
    *,
    joints: ArrayLike = ...,
    segments: int = 2,
    sides: int = 4,
    rings: int = 1,
    core: _Core = "polygon",
    up: Sequence[float] = ...,
) -> Lattice: ...
def tetrahedron(*, radius: float = 1.0) -> Lattice: ...
def cube(*, radius: float = 1.0) -> Lattice: ...
def octahedron(*, radius: float = 1.0) -> Lattice: ...
def dodecahedron(*, radius: float = 1.0) -> Lattice: ...
def icosahedron(*, radius: float = 1.0) -> Lattice: ...
def prism(*, sides: int = 4, radius: float = 1.0, height: float = 1.0) -> Lattice: ...
def pyramid(*, sides: int = 4, radius: float = 1.0, height: float = 1.0) -> Lattice: ...
def bipyramid(*, sides: int = 4, radius: float = 1.0, height: float = 1.0) -> Lattice: ...
def merge(lattices: Sequence[Lattice], *, tolerance: float = 1e-9) -> Lattice: ...
