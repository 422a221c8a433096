"""Vibrating systems M x'' + C x' + K x = f(t), with proven bounds.

A system is given as matrices M, C and K, or as a scene: a dict of the shape that the page "The scene file" of
eigentone's book describes, or the path of such a JSON file. Frequencies are in rad/s. Bounds are absolute and include the
rounding to double; where there is none they are NaN. ``bounds`` says whether they are ``"proven"`` or only
``"estimated"``. What is wrong with an input raises ``ValueError`` with what would be right.

>>> import eigentone
>>> modes = eigentone.modes([[2.0, 0.0], [0.0, 1.0]], None, [[2.2, -0.2], [-0.2, 0.2]])
>>> len(modes), modes.bounds
(2, 'proven')
"""

import json as _json
import os as _os
from dataclasses import dataclass as _dataclass
from typing import Dict, List, Tuple

import numpy as _np

from . import _eigentone

__all__ = [
    "BoundedMatrix",
    "Exponential",
    "Functions",
    "Modes",
    "Motion",
    "StateSpace",
    "discretise",
    "expm",
    "frf",
    "modes",
    "response",
    "scene",
    "state_space",
]


@_dataclass(frozen=True)
class Modes:
    """Modes in order of |lambda|: one for each conjugate pair or real root."""

    names: List[str]
    """The coordinates, the rows of ``shapes``."""
    eigenvalues: _np.ndarray
    """Every finite root, conjugates and repeats included, in 1/s."""
    eigenvalue_bounds: _np.ndarray
    """How far each of them may be off."""
    real_bounds: _np.ndarray
    """How far the real part of each may be off."""
    infinite: int
    """How many of the 2n roots are infinite."""
    roots: _np.ndarray
    """The root of each mode, the one with Im >= 0."""
    natural_frequencies: _np.ndarray
    """|lambda| of each mode, in rad/s."""
    damping_ratios: _np.ndarray
    """NaN for real roots."""
    time_constants: _np.ndarray
    """In s; NaN where nothing decays or grows."""
    motions: List[str]
    """``oscillating``, ``decaying``, ``growing``, ``rigid`` or ``doubtful``."""
    shapes: _np.ndarray
    """A column for each mode, its largest entry 1."""
    shape_bounds: _np.ndarray
    """How far each entry may be off."""
    bounds: str
    """``proven`` or ``estimated``."""
    complete: bool
    """Whether it is proved that no root is missing."""

    def __len__(self) -> int:
        return len(self.roots)


@_dataclass(frozen=True)
class Motion:
    """A motion at the instants asked for."""

    names: List[str]
    """The coordinates, the rows of ``displacement`` and ``velocity``."""
    time: _np.ndarray
    displacement: _np.ndarray
    velocity: _np.ndarray
    displacement_bound: _np.ndarray
    """One for each instant, over all coordinates."""
    velocity_bound: _np.ndarray
    outputs: Dict[str, _np.ndarray]
    """The scene's outputs by name."""
    output_bounds: Dict[str, _np.ndarray]
    bounds: str
    method: str

    def of(self, name: str) -> _np.ndarray:
        """The displacement of a coordinate, or an output."""
        if name in self.outputs:
            return self.outputs[name]
        return self.displacement[self.names.index(name)]


@_dataclass(frozen=True)
class Functions:
    """Frequency response functions at the same frequencies."""

    frequency: _np.ndarray
    """In rad/s."""
    values: Dict[Tuple[str, str], _np.ndarray]
    """H by (from, to); NaN at an undamped natural frequency."""
    value_bounds: Dict[Tuple[str, str], _np.ndarray]
    bounds: str


@_dataclass(frozen=True)
class Exponential:
    """A matrix exponential."""

    matrix: _np.ndarray
    bound: float
    """Of the error, in the 1-norm."""
    bounds: str


@_dataclass(frozen=True)
class BoundedMatrix:
    """A matrix, and how far each of its entries may be off."""

    values: _np.ndarray
    bound: _np.ndarray


@_dataclass(frozen=True)
class StateSpace:
    """x' = A x + B u, or x[k+1] = A x[k] + B u[k]; y = C x + D u."""

    A: BoundedMatrix
    B: BoundedMatrix
    C: BoundedMatrix
    D: BoundedMatrix
    states: List[str]
    inputs: List[str]
    outputs: List[str]


def _matrix(matrix):
    return _np.ascontiguousarray(matrix, dtype=_np.float64)


def scene(M, C=None, K=None, x0=None, v0=None, step=None, end=None, **more):
    """A scene of matrices: its coordinates are x1, x2, ... ; ``more`` are other keys of it, such as ``loads``."""
    rows = {"mass": M, "damping": C, "stiffness": K}
    given = {kind: _matrix(rows[kind]).tolist() for kind in rows if rows[kind] is not None}
    made = {"matrices": given}
    start = {}
    for key, values in (("displacement", x0), ("velocity", v0)):
        for i, value in enumerate([] if values is None else values):
            start.setdefault(f"x{i + 1}", {})[key] = float(value)
    if start:
        made["initial"] = start
    if step is not None or end is not None:
        if step is None or end is None:
            raise ValueError("step and end belong together: give both or none")
        made["time"] = {"end": float(end), "step": float(step)}
    made.update(more)
    return made


def _plain(value):
    """Arrays and numbers of NumPy as JSON has them."""
    if isinstance(value, _np.ndarray):
        return value.tolist()
    if isinstance(value, _np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no place in a scene")


def _text(given):
    """The JSON text of a scene and what errors call it."""
    if isinstance(given, dict):
        return _json.dumps(given, default=_plain), "scene"
    if isinstance(given, (str, _os.PathLike)):
        path = _os.fspath(given)
        with open(path, encoding="utf-8") as file:
            return file.read(), path
    raise TypeError("a scene is a dict or the path of a JSON file; matrices are given as M, C, K")


def _names(text, key):
    return [entry["name"] for entry in _json.loads(text).get(key, [])]


def _ends(text, file, inputs, outputs):
    """The names asked for; without any, what the scene drives, or every coordinate."""
    data = _json.loads(text)
    if inputs is None:
        driven = [load["on"] for load in data.get("loads", [])]
        driven += [motion["of"] for motion in data.get("motions", [])]
        inputs = list(dict.fromkeys(driven)) or data.get("supports", [])
    if outputs is None or not inputs:
        names = _eigentone.modes_of_scene(text, file, "double")[0][0]
        inputs = inputs or names
        if outputs is None:
            outputs = names + _names(text, "points") + _names(text, "outputs")
    one = lambda names: [names] if isinstance(names, str) else list(names)
    return one(inputs), one(outputs)


def _modes(answer):
    roots, of_modes, bounds, complete = answer
    return Modes(*roots, *of_modes, bounds, complete)


def modes(system, C=None, K=None, *, precision="certified"):
    """Eigenvalues, damping and shapes of a scene, or of M, C and K; C may be None.

    ``precision`` is ``"certified"``, bounds proven with as many digits as that takes, or ``"double"``, estimates.
    """
    if K is None and isinstance(system, (dict, str, _os.PathLike)):
        if C is not None:
            raise TypeError("a scene stands alone; matrices are given as M, C, K")
        return _modes(_eigentone.modes_of_scene(*_text(system), precision))
    if K is None:
        raise TypeError("matrices are given as M, C, K; C may be None, K may not")
    damping = None if C is None else _matrix(C)
    return _modes(_eigentone.modes_of_matrices(_matrix(system), damping, _matrix(K), precision))


def response(scene, *, steps=None, precision="certified"):
    """The motion of a scene at every instant of its ``time``, or at those sample indices."""
    steps = None if steps is None else [int(step) for step in steps]
    answer = _eigentone.response(*_text(scene), steps, precision)
    *motion, outputs, bounds, method = answer
    values = {name: value for name, value, _ in outputs}
    return Motion(*motion, values, {name: bound for name, _, bound in outputs}, bounds, method)


def frf(scene, frequency, *, inputs=None, outputs=None, quantity="displacement", precision="certified"):
    """Frequency responses per unit force on a name, or per unit displacement of a support."""
    text, file = _text(scene)
    inputs, outputs = _ends(text, file, inputs, outputs)
    frequency = _np.atleast_1d(_np.asarray(frequency, dtype=_np.float64))
    found, bounds = _eigentone.frf(text, file, frequency.tolist(), inputs, outputs, quantity, precision)
    values = {(start, end): value for start, end, value, _ in found}
    return Functions(frequency, values, {(start, end): bound for start, end, _, bound in found}, bounds)


def expm(A):
    """The exponential of a real square matrix, with a bound of its error."""
    return Exponential(*_eigentone.expm(_matrix(A)))


def _state_space(scene, inputs, outputs, held):
    text, file = _text(scene)
    inputs, outputs = _ends(text, file, inputs, outputs)
    states, inputs, outputs, matrices = _eigentone.state_space(text, file, inputs, outputs, held)
    return StateSpace(*(BoundedMatrix(*each) for each in matrices), states, inputs, outputs)


def state_space(scene, *, inputs=None, outputs=None):
    """The continuous matrices A, B, C and D."""
    return _state_space(scene, inputs, outputs, None)


def discretise(scene, step, *, hold="zero", inputs=None, outputs=None):
    """The exact discrete matrices for inputs that keep each sample (``"zero"``) or run straight between (``"first"``)."""
    return _state_space(scene, inputs, outputs, (float(step), hold))
