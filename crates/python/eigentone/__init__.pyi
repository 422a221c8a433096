from dataclasses import dataclass
from os import PathLike
from typing import Any, Dict, Iterable, List, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Scene = Union[Dict[str, Any], str, PathLike[str]]
Names = Union[str, Iterable[str], None]

@dataclass(frozen=True)
class Modes:
    names: List[str]
    eigenvalues: Complex
    eigenvalue_bounds: Real
    real_bounds: Real
    infinite: int
    roots: Complex
    natural_frequencies: Real
    damping_ratios: Real
    time_constants: Real
    motions: List[str]
    shapes: Complex
    shape_bounds: Real
    bounds: str
    complete: bool
    def __len__(self) -> int: ...

@dataclass(frozen=True)
class Motion:
    names: List[str]
    time: Real
    displacement: Real
    velocity: Real
    displacement_bound: Real
    velocity_bound: Real
    outputs: Dict[str, Real]
    output_bounds: Dict[str, Real]
    bounds: str
    method: str
    def of(self, name: str) -> Real: ...

@dataclass(frozen=True)
class Functions:
    frequency: Real
    values: Dict[Tuple[str, str], Complex]
    value_bounds: Dict[Tuple[str, str], Real]
    bounds: str

@dataclass(frozen=True)
class Exponential:
    matrix: Real
    bound: float
    bounds: str

@dataclass(frozen=True)
class BoundedMatrix:
    values: Real
    bound: Real

@dataclass(frozen=True)
class StateSpace:
    A: BoundedMatrix
    B: BoundedMatrix
    C: BoundedMatrix
    D: BoundedMatrix
    states: List[str]
    inputs: List[str]
    outputs: List[str]

def scene(
    M: ArrayLike,
    C: Optional[ArrayLike] = None,
    K: Optional[ArrayLike] = None,
    x0: Optional[Union[ArrayLike, Iterable[float]]] = None,
    v0: Optional[Union[ArrayLike, Iterable[float]]] = None,
    step: Optional[float] = None,
    end: Optional[float] = None,
    **more: Any,
) -> Dict[str, Any]: ...
def modes(
    system: Union[Scene, ArrayLike],
    C: Optional[ArrayLike] = None,
    K: Optional[ArrayLike] = None,
    *,
    precision: str = "certified",
) -> Modes: ...
def response(
    scene: Scene, *, steps: Optional[Iterable[int]] = None, precision: str = "certified"
) -> Motion: ...
def frf(
    scene: Scene,
    frequency: ArrayLike,
    *,
    inputs: Names = None,
    outputs: Names = None,
    quantity: str = "displacement",
    precision: str = "certified",
) -> Functions: ...
def expm(A: ArrayLike) -> Exponential: ...
def state_space(scene: Scene, *, inputs: Names = None, outputs: Names = None) -> StateSpace: ...
def discretise(
    scene: Scene,
    step: float,
    *,
    hold: str = "zero",
    inputs: Names = None,
    outputs: Names = None,
) -> StateSpace: ...
