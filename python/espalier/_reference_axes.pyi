# SPDX-License-Identifier: Apache-2.0
from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

def chosen_vertices(name: str, values: ArrayLike, count: int) -> NDArray[np.int_]: ...
def letter(name: str, value: str, letters: str) -> int: ...

class ReferenceAxes:
    def __init__(self) -> None: ...
    def addRefAxis(
        self,
        name: str,
        curve: Any = None,
        xFraction: float | None = None,
        yFraction: float | None = None,
        zFraction: float | None = None,
        volumes: None = None,
        rotType: int = 5,
        axis: str | ArrayLike | None = "x",
        alignIndex: str | None = None,
        rotAxisVar: None = None,
        rot0ang: float | None = None,
        rot0axis: Sequence[float] = (1, 0, 0),
        includeVols: Sequence[int] = (),
        ignoreInd: ArrayLike = (),
        raySize: float = 1.5,
        vertices: ArrayLike | None = None,
    ) -> int: ...
    def extractCoef(self, axisID: str) -> NDArray[Any]: ...
    def restoreCoef(self, coef: ArrayLike, axisID: str) -> None: ...
    def extractS(self, axisID: str) -> NDArray[np.float64]: ...
