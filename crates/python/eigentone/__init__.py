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
import warnings as _warnings
from dataclasses import dataclass as _dataclass, fields as _fields
from decimal import Decimal as _Decimal
from numbers import Complex as _Complex, Real as _Real
from typing import Dict, List, Tuple

import numpy as _np

from . import _eigentone

__all__ = [
    "BoundedMatrix",
    "Event",
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
class Event:
    """What happens at once in a motion with frictions, stops, impacts or controlled dampers."""

    time: float
    """In s."""
    bound: float
    """How far the time may be off."""
    kind: str
    """``stick``, ``slip``, ``contact``, ``release``, ``impact`` or ``switch``."""
    element: str
    """Of what in the scene, as ``frictions[0]``."""


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
    events: List[Event]
    """Those up to the last instant, in order of time; none in a linear scene."""
    bounds: str
    method: str

    def of(self, name: str) -> _np.ndarray:
        """The displacement of a coordinate, or an output; ``ValueError`` for a name that both have."""
        if name in self.outputs:
            if name in self.names:
                raise ValueError(f"{name!r} is a coordinate and an output: take its row of displacement, or of outputs")
            return self.outputs[name]
        if name not in self.names:
            raise ValueError(f"{name!r} is neither a coordinate nor an output: known are {[*self.names, *self.outputs]}")
        return self.displacement[self.names.index(name)]


@_dataclass(frozen=True)
class Functions:
    """Frequency response functions at the same frequencies."""

    frequency: _np.ndarray
    """In rad/s."""
    values: Dict[Tuple[str, str], _np.ndarray]
    """H by (from, to); NaN at an undamped natural frequency. If an output of the scene has the name of what it reaches, as
    "a", the motion of that is to "a displacement", or what ``quantity`` is."""
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


# What errors call it.
_SCENE = "scene"


def _double(value, what):
    """The double nearest to a number of any type."""
    # NumPy has differences of times among the integers.
    if isinstance(value, (_Complex, _Decimal, _np.bool_)) and not isinstance(value, _np.timedelta64):
        if isinstance(value, _Complex) and not isinstance(value, _Real):
            hysteretic = '; give hysteretic damping by the "loss_factor" of springs in a scene'
            raise ValueError(f"{what} has complex numbers: they must be real{hysteretic if what in ('K', _SCENE) else ''}")
        try:
            return float(value)
        except OverflowError:
            raise ValueError(f"{what} has a number beyond the largest double, 1.79e308") from None
    right = "numbers, texts, lists, dicts and arrays have a place there" if what == _SCENE else "real numbers belong there"
    raise ValueError(f"{what} has a {type(value).__name__.rstrip('_')} in it: {right}")


_FLOAT = _np.dtype(_np.float64)
_SHAPES = ("a number", "a list of numbers", "a matrix, a list of rows")


def _real(given, what, *dimensions):
    """An array of doubles of so many dimensions; of any, if none is named."""
    if type(given) is _np.ndarray and given.dtype is _FLOAT and given.ndim in dimensions and given.flags.aligned:
        return given
    try:
        array = _np.asarray(given)
    except ValueError:
        raise ValueError(f"{what} has rows of several lengths: they must have one") from None
    if any(_np.ma.is_masked(part) for part in (given if isinstance(given, (list, tuple)) else [given])):
        raise ValueError(f"{what} has masked entries: give numbers for them")
    if array.dtype.kind in "biuf":
        with _np.errstate(over="ignore"):
            array = array.astype(_np.float64)
    else:
        array = _np.array([_double(value, what) for value in array.flat], _np.float64).reshape(array.shape)
    if dimensions and array.ndim not in dimensions:
        right = " or ".join(_SHAPES[dimension] for dimension in dimensions)
        raise ValueError(f"{what} has the shape {array.shape}: it must be {right}")
    return array


def _reals(given, what):
    """The same of a list, or whatever may be gone through."""
    known = isinstance(given, (_np.ndarray, list)) or not hasattr(given, "__iter__")
    return _real(given if known else list(given), what, 1)


def scene(M, C=None, K=None, x0=None, v0=None, step=None, end=None, **more):
    """A scene of matrices: its coordinates are x1, x2, ... ; ``more`` are other keys of it, such as ``loads``."""
    made, start = {}, {}
    matrices = {"mass": (M, "M"), "damping": (C, "C"), "stiffness": (K, "K")}
    given = {key: _real(*matrix, 2).tolist() for key, matrix in matrices.items() if matrix[0] is not None}
    if given:
        made["matrices"] = given
    count = max(map(len, given.values()), default=0)
    for key, values, what in (("displacement", x0, "x0"), ("velocity", v0, "v0")):
        if values is None:
            continue
        values = _reals(values, what).tolist()
        if len(values) != count:
            raise ValueError(f"{what} has the length {len(values)}: it must have that of the matrices, {count}")
        for i, value in enumerate(values):
            start.setdefault(f"x{i + 1}", {})[key] = value
    if start:
        made["initial"] = start
    if step is not None or end is not None:
        if step is None or end is None:
            raise ValueError("step and end belong together: give both or none")
        made["time"] = {"end": float(_real(end, "end", 0)), "step": float(_real(step, "step", 0))}
    for key, by in (("matrices", "M, C and K"), ("initial", "x0 and v0"), ("time", "step and end")):
        if key in made and key in more:
            raise ValueError(f"{key} is given twice, by {by} too: give it once")
    made.update(more)
    return made


def _plain(value):
    """What JSON does not know: arrays and numbers."""
    array = _np.asarray(value)
    # What holds one object would return to here.
    known = array.dtype.kind in "biuU" or (array.dtype.kind == "O" and array.ndim > 0)
    if known and not _np.ma.is_masked(value):
        return array.tolist()
    return _real(value, _SCENE).tolist()


def _text(given):
    """The JSON text of a scene and what errors call it."""
    if isinstance(given, dict):
        try:
            return _json.dumps(given, default=_plain), _SCENE
        except TypeError as error:
            raise ValueError(f"scene: it cannot be written as JSON: {error}") from None
    if isinstance(given, (str, _os.PathLike)):
        path = _os.fspath(given)
        with open(path, encoding="utf-8") as file:
            return file.read(), path
    raise ValueError("a scene is a dict or the path of a JSON file; matrices are given as M, C, K")


def _names(given, what):
    """Names as a list; None stands for all."""
    if given is None:
        return None
    names = [given] if isinstance(given, str) or not hasattr(given, "__iter__") else list(given)
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{what} are {names}: give a name or a list of names, or leave them out")
    return names


_OF_MODES = tuple(field.name for field in _fields(Modes))


def _modes(answer):
    roots, of_modes, bounds, complete = answer
    made = object.__new__(Modes)
    # All fields at once: a frozen dataclass sets them one by one, which takes longer than one mode.
    made.__dict__.update(zip(_OF_MODES, (*roots, *of_modes, bounds, complete)))
    return made


def modes(system, C=None, K=None, *, precision="certified"):
    """Eigenvalues, damping and shapes of a scene, or of M, C and K; C may be None.

    ``precision`` is ``"certified"``, bounds proven with as many digits as that takes, or ``"double"``, estimates.
    """
    if K is None or isinstance(system, (dict, str)):
        if C is not None or K is not None:
            raise ValueError("a scene stands alone; matrices are given as M, C, K, of which C may be None")
        return _modes(_eigentone.modes_of_scene(*_text(system), precision))
    damping = None if C is None else _real(C, "C", 2)
    return _modes(_eigentone.modes_of_matrices(_real(system, "M", 2), damping, _real(K, "K", 2), precision))


def response(scene, *, steps=None, precision="certified"):
    """The motion of a scene at every instant of its ``time``, or at those sample indices.

    Frictions, stops, impacts and controlled dampers are followed from event to event; ``modes``, ``frf``, ``state_space``
    and ``discretise`` leave them out, and a ``UserWarning`` says so.
    """
    if steps is not None:
        steps = _reals(steps, "steps")
        for step in steps[~((steps >= 0) & (steps < 2**53) & (steps % 1 == 0))]:
            raise ValueError(f"steps has {step}: it must be of whole numbers from 0 on, the indices of instants")
        steps = steps.astype(_np.uint64).tolist()
    answer = _eigentone.response(*_text(scene), steps, precision)
    *motion, outputs, events, bounds, method = answer
    values = {name: value for name, value, _ in outputs}
    output_bounds = {name: bound for name, _, bound in outputs}
    return Motion(*motion, values, output_bounds, [Event(*event) for event in events], bounds, method)


def frf(scene, frequency, *, inputs=None, outputs=None, quantity="displacement", precision="certified"):
    """Frequency responses per unit force on a name, or per unit displacement of a support.

    Without ``inputs``, of what the scene drives, else its supports, else all coordinates; without ``outputs``, of all
    coordinates, points and outputs of the scene.
    """
    inputs, outputs = _names(inputs, "inputs"), _names(outputs, "outputs")
    frequency = _np.atleast_1d(_real(frequency, "frequency", 0, 1))
    found, bounds = _eigentone.frf(*_text(scene), frequency.tolist(), inputs, outputs, quantity, precision)
    own = {end for _, end, is_output, _, _ in found if is_output}
    values, value_bounds = {}, {}
    for start, end, is_output, value, bound in found:
        if end in own and not is_output:
            end = f"{end} {quantity}"
            if end in own:
                raise ValueError(f"{end!r} is what an output and a motion would be called: rename the output")
        values[start, end], value_bounds[start, end] = value, bound
    return Functions(frequency, values, value_bounds, bounds)


def expm(A):
    """The exponential of a real square matrix, with a bound of its error."""
    return Exponential(*_eigentone.expm(_real(A, "A", 2)))


def _state_space(scene, inputs, outputs, held):
    inputs, outputs = _names(inputs, "inputs"), _names(outputs, "outputs")
    states, inputs, outputs, matrices, raised = _eigentone.state_space(*_text(scene), inputs, outputs, held)
    for note in raised:
        _warnings.warn(note, stacklevel=3)
    return StateSpace(*(BoundedMatrix(*each) for each in matrices), states, inputs, outputs)


def state_space(scene, *, inputs=None, outputs=None):
    """The continuous matrices A, B, C and D; ``inputs`` and ``outputs`` as in ``frf``.

    The input of a support is the derivative of it that the scene's ``motions`` give, else its displacement. Where an output
    follows a derivative of that, the input is its velocity or acceleration instead, and a ``UserWarning`` says so.
    """
    return _state_space(scene, inputs, outputs, None)


def discretise(scene, step, *, hold="zero", inputs=None, outputs=None):
    """The exact discrete matrices for inputs that keep each sample (``"zero"``) or run straight between (``"first"``).

    Inputs and outputs are those of ``state_space``.
    """
    return _state_space(scene, inputs, outputs, (float(_real(step, "step", 0)), hold))
