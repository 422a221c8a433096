"""The compiled part; use the functions of the package."""

from typing import List, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

def modes_of_matrices(mass: Real, damping: Optional[Real], stiffness: Real, accuracy: str) -> tuple: ...
def modes_of_scene(text: str, file: str, accuracy: str) -> tuple: ...
def response(text: str, file: str, steps: Optional[List[int]], accuracy: str) -> tuple: ...
def frf(
    text: str,
    file: str,
    frequencies: List[float],
    inputs: Optional[List[str]],
    outputs: Optional[List[str]],
    of: str,
    accuracy: str,
) -> Tuple[List[Tuple[str, str, bool, Complex, Real]], str]: ...
def expm(a: Real) -> Tuple[Real, float, str]: ...
def state_space(
    text: str,
    file: str,
    inputs: Optional[List[str]],
    outputs: Optional[List[str]],
    held: Optional[Tuple[float, str]],
) -> Tuple[List[str], List[str], List[str], List[Tuple[Real, Real]], List[str]]: ...
