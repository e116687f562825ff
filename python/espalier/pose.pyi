# SPDX-License-Identifier: Apache-2.0
from typing import Literal, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Lattice

_Axis = str | Sequence[float]
_Falloff = Literal["linear", "smooth"]
_Array = NDArray[np.float64]

def move(
    positions: ArrayLike, offset: Sequence[float], *, weights: ArrayLike | None = None
) -> _Array: ...
def displace(
    positions: ArrayLike, displacements: ArrayLike, *, weights: ArrayLike | None = None
) -> _Array: ...
def rotate(
    positions: ArrayLike,
    axis: _Axis,
    angle: float,
    *,
    weights: ArrayLike | None = None,
    center: Sequence[float] | None = None,
) -> _Array: ...
def scale(
    positions: ArrayLike,
    factors: float | Sequence[float],
    *,
    weights: ArrayLike | None = None,
    center: Sequence[float] | None = None,
) -> _Array: ...
def twist(
    positions: ArrayLike,
    axis: _Axis,
    angle: float,
    *,
    weights: ArrayLike | None = None,
    center: Sequence[float] | None = None,
    range: Sequence[float] | None = None,
) -> _Array: ...
def bend(
    positions: ArrayLike,
    axis: _Axis,
    angle: float,
    toward: _Axis,
    *,
    weights: ArrayLike | None = None,
    center: Sequence[float] | None = None,
    range: Sequence[float] | None = None,
) -> _Array: ...
def taper(
    positions: ArrayLike,
    axis: _Axis,
    factor: float,
    *,
    weights: ArrayLike | None = None,
    center: Sequence[float] | None = None,
    range: Sequence[float] | None = None,
) -> _Array: ...
def mirror(
    rest: ArrayLike,
    positions: ArrayLike,
    axis: Literal["x", "y", "z"],
    *,
    weights: ArrayLike | None = None,
    plane: float | None = None,
) -> _Array: ...
def select_box(
    positions: ArrayLike,
    corner: Sequence[float],
    opposite: Sequence[float],
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_ball(
    positions: ArrayLike,
    center: Sequence[float],
    radius: float,
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_half_space(
    positions: ArrayLike,
    point: Sequence[float],
    normal: Sequence[float],
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_end(
    positions: ArrayLike,
    direction: _Axis,
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_numbers(
    positions: ArrayLike,
    numbers: ArrayLike,
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_limb(
    lattice: Lattice,
    point: Sequence[float],
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_beyond(
    lattice: Lattice,
    face: int | Sequence[float],
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def select_near(
    lattice: Lattice,
    point: Sequence[float],
    radius: float,
    *,
    falloff: _Falloff = "linear",
    falloff_radius: float = 0.0,
) -> _Array: ...
def grow(lattice: Lattice, weights: ArrayLike, steps: int = 1) -> _Array: ...
def without_held(lattice: Lattice, weights: ArrayLike | None = None) -> _Array: ...
def border(lattice: Lattice, weights: ArrayLike) -> list[float]: ...
