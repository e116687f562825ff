# SPDX-License-Identifier: Apache-2.0
from collections import OrderedDict
from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

def chosen_vertices(name: str, values: ArrayLike, count: int) -> NDArray[np.int_]: ...
def letter(name: str, value: str, letters: str) -> int: ...

class _Curve:
    coef: NDArray[Any]
    k: int
    def __init__(self, coef: NDArray[Any]) -> None: ...
    @property
    def X(self) -> NDArray[Any]: ...
    @property
    def s(self) -> NDArray[np.float64]: ...

class ReferenceAxes:
    DV_listGlobal: OrderedDict[str, Any]
    axis: OrderedDict[str, dict[str, Any]]
    coef: NDArray[Any]
    rot_x: OrderedDict[str, _Curve]
    rot_y: OrderedDict[str, _Curve]
    rot_z: OrderedDict[str, _Curve]
    rot_theta: OrderedDict[str, _Curve]
    scale: OrderedDict[str, _Curve]
    scale_x: OrderedDict[str, _Curve]
    scale_y: OrderedDict[str, _Curve]
    scale_z: OrderedDict[str, _Curve]
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
