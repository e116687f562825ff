# SPDX-License-Identifier: Apache-2.0
from typing import Any, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _Sparse
from ._derivatives import Derivatives

_Floats = NDArray[np.float64]

class Sensitivities(Derivatives):
    def computeTotalJacobian(self, ptSetName: str, config: str | None = None) -> _Sparse: ...
    def totalSensitivity(
        self, dIdpt: ArrayLike, ptSetName: str, comm: Any = None, config: str | None = None
    ) -> dict[str, _Floats]: ...
    def totalSensitivityProd(
        self, vec: Mapping[str, ArrayLike], ptSetName: str, config: str | None = None
    ) -> _Floats: ...
    def totalSensitivityTransProd(
        self, vec: ArrayLike, ptSetName: str, config: str | None = None
    ) -> dict[str, _Floats]: ...
    def convertSensitivityToDict(
        self, dIdx: ArrayLike, out1D: bool = False
    ) -> dict[str, _Floats]: ...
    def convertDictToSensitivity(self, dIdxDict: Mapping[str, ArrayLike]) -> _Floats: ...
