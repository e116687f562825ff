# SPDX-License-Identifier: Apache-2.0
from collections import OrderedDict
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import DesignVariables, Lattice, Refiner, _Path, _Sparse
from ._reference_axes import ReferenceAxes
from ._sensitivities import Sensitivities

_Floats = NDArray[np.float64]
_Config = str | Sequence[str] | None
_Bound = ArrayLike | None

class DVGeometry(ReferenceAxes, Sensitivities):
    DV_listLocal: OrderedDict[str, Any]
    JT: dict[str, _Sparse | None]
    children: OrderedDict[str, DVGeometry]
    isChild: bool
    lattice: Lattice
    name: str | None
    points: OrderedDict[str, _Floats]
    ptSetNames: list[str]
    revision: int
    updated: dict[str, bool]
    def __init__(
        self,
        lattice: _Path | Lattice | Refiner,
        *,
        child: bool = False,
        faceFreeze: Mapping[str, Sequence[str]] | None = None,
        name: str | None = None,
        frozen: ArrayLike = (),
        move_held: bool = False,
        **options: Any,
    ) -> None: ...
    def addPointSet(
        self,
        points: ArrayLike,
        ptName: str,
        origConfig: bool = True,
        coordXfer: Callable[..., Any] | None = None,
        activeChildren: Sequence[str] | None = None,
        deformation: _Sparse | None = None,
        **options: Any,
    ) -> None: ...
    def pointSetUpToDate(self, ptSetName: str) -> bool: ...
    def addChild(self, childDVGeo: DVGeometry) -> None: ...
    def addGlobalDV(
        self,
        dvName: str,
        value: ArrayLike,
        func: Callable[[Any, DVGeometry], object],
        lower: _Bound = None,
        upper: _Bound = None,
        scale: _Bound = 1.0,
        config: _Config = None,
        prependName: bool = True,
    ) -> None: ...
    def addLocalDV(
        self,
        dvName: str,
        lower: _Bound = None,
        upper: _Bound = None,
        scale: _Bound = 1.0,
        axis: str = "y",
        volList: None = None,
        pointSelect: Any = None,
        config: _Config = None,
        prependName: bool = True,
        vertices: ArrayLike | None = None,
        design: DesignVariables | None = None,
    ) -> int: ...
    def addShapeFunctionDV(
        self,
        dvName: str,
        shapes: Mapping[int, ArrayLike] | Sequence[Mapping[int, ArrayLike]],
        lower: _Bound = None,
        upper: _Bound = None,
        scale: _Bound = 1.0,
        config: _Config = None,
        prependName: bool = True,
    ) -> int: ...
    def addSpanwiseLocalDV(
        self,
        dvName: str,
        spanIndex: str,
        axis: str = "y",
        lower: _Bound = None,
        upper: _Bound = None,
        scale: _Bound = 1.0,
        pointSelect: None = None,
        volList: None = None,
        config: _Config = None,
    ) -> int: ...
    def getLocalIndex(self, iVol: int = 0) -> NDArray[np.int32]: ...
    def getVarNames(self, pyOptSparse: bool = False) -> list[str]: ...
    def getNDV(self) -> int: ...
    def getValues(self) -> dict[str, _Floats]: ...
    def setDesignVars(self, dvDict: Mapping[str, ArrayLike]) -> None: ...
    def addVariablesPyOpt(
        self,
        optProb: Any,
        globalVars: bool = True,
        localVars: bool = True,
        ignoreVars: Sequence[str] = (),
        freezeVars: Sequence[str] = (),
        **_: object,
    ) -> None: ...
    def positions(self, config: str | None = None) -> _Floats: ...
    def update(
        self, ptSetName: str, childDelta: bool = True, config: str | None = None
    ) -> _Floats: ...
    def writeTecplot(self, fileName: _Path, solutionTime: float | None = None) -> Path: ...
