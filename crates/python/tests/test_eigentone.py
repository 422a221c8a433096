"""The package against SciPy, against closed forms, and against the command line bit for bit."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.signal

import eigentone

ROOT = Path(__file__).resolve().parents[3]
CAR = ROOT / "crates/eigentone/command/templates/quarter-car.json"
M = np.diag([2.0, 1.0, 1.5])
K = np.array([[3.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 4.0]])
C = np.array([[0.3, -0.1, 0.0], [-0.1, 0.2, 0.0], [0.0, 0.0, 0.4]])


def first_order():
    inverse = np.linalg.inv(M)
    return np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ K, -inverse @ C]])


def test_modes_are_those_of_scipy():
    modes = eigentone.modes(M, C, K)
    assert (len(modes), modes.bounds, modes.complete, modes.infinite) == (3, "proven", True, 0)
    own = np.sort_complex(modes.eigenvalues)
    assert np.allclose(own, np.sort_complex(scipy.linalg.eigvals(first_order())), rtol=1e-12)
    assert np.all(modes.eigenvalue_bounds <= 2e-16 * np.abs(modes.eigenvalues))
    for root, shape in zip(modes.roots, modes.shapes.T):
        residual = (root**2 * M + root * C + K) @ shape
        assert np.abs(residual).max() < 1e-14
        assert np.abs(shape).max() == 1.0


def test_undamped_modes_take_no_c():
    modes = eigentone.modes(M, None, K)
    squares = scipy.linalg.eigh(K, M, eigvals_only=True)
    assert np.allclose(modes.natural_frequencies**2, squares, rtol=1e-13)
    assert np.all(modes.damping_ratios == 0)


def test_matrices_and_their_scene_agree_bit_for_bit():
    one, other = eigentone.modes(M, C, K), eigentone.modes(eigentone.scene(M, C, K))
    assert np.array_equal(one.eigenvalues, other.eigenvalues)
    assert np.array_equal(one.shapes, other.shapes)
    assert one.names == other.names == ["x1", "x2", "x3"]


def test_other_layouts_of_the_same_matrices_agree():
    expected = eigentone.modes(M, C, K).eigenvalues
    for given in (np.asfortranarray(K), K.tolist(), np.repeat(K, 2, axis=0)[::2]):
        assert np.array_equal(eigentone.modes(M, C, given).eigenvalues, expected)


def test_a_motion_is_that_of_the_exponential():
    x0, v0 = [1.0, 0.0, -0.5], [0.0, 2.0, 0.0]
    motion = eigentone.response(eigentone.scene(M, C, K, x0=x0, v0=v0, step=0.5, end=10))
    assert motion.bounds == "proven" and motion.displacement.shape == (3, 21)
    for k, time in enumerate(motion.time):
        state = scipy.linalg.expm(first_order() * time) @ np.array(x0 + v0)
        assert np.abs(motion.displacement[:, k] - state[:3]).max() < 1e-13
        assert np.abs(motion.velocity[:, k] - state[3:]).max() < 1e-13
    some = eigentone.response(eigentone.scene(M, C, K, x0=x0, v0=v0, step=0.5, end=10), steps=[20, 3])
    assert np.array_equal(some.displacement, motion.displacement[:, [20, 3]])


def test_frequency_responses_solve_the_equations():
    frequency = np.linspace(0.1, 4, 7)
    found = eigentone.frf(eigentone.scene(M, C, K), frequency, inputs="x1")
    for k, w in enumerate(frequency):
        column = np.linalg.solve(K + 1j * w * C - w**2 * M, [1, 0, 0])
        for i in range(3):
            assert abs(found.values["x1", f"x{i + 1}"][k] - column[i]) < 1e-14
    assert found.bounds == "proven"
    pole = eigentone.frf(eigentone.scene([[1.0]], None, [[4.0]]), 2.0)
    assert np.isnan(pole.values["x1", "x1"][0])


def test_exponentials_are_those_of_scipy():
    rng = np.random.default_rng(7)
    for n in (1, 2, 5, 12):
        a = rng.normal(size=(n, n))
        found = eigentone.expm(a)
        expected = scipy.linalg.expm(a)
        assert np.abs(found.matrix - expected).sum(axis=0).max() <= 1e-13 * np.linalg.norm(expected, 1)
        # An estimate from the condition number.
        assert found.bound <= 1e-13 * np.linalg.norm(expected, 1)


def test_held_matrices_are_those_of_scipy():
    plant = eigentone.state_space(eigentone.scene(M, C, K), inputs="x1")
    held = eigentone.discretise(eigentone.scene(M, C, K), 0.1, inputs="x1")
    a, b, c, d, _ = scipy.signal.cont2discrete(
        tuple(matrix.values for matrix in (plant.A, plant.B, plant.C, plant.D)), 0.1
    )
    for own, other in zip((held.A, held.B, held.C, held.D), (a, b, c, d)):
        assert np.abs(own.values - other).max() < 1e-14
    assert held.inputs == plant.inputs and held.states == plant.states


def test_the_scene_of_a_quarter_car_has_outputs():
    motion = eigentone.response(CAR)
    body, wheel = motion.of("body"), motion.of("wheel")
    assert np.abs(motion.of("travel") - (body - wheel)).max() < 1e-15
    assert eigentone.frf(CAR, 10.0).values["road", "comfort"].shape == (1,)


@pytest.mark.skipif("EIGENTONE" not in os.environ, reason="EIGENTONE names the program to compare with")
def test_a_quarter_car_is_that_of_the_command_line_bit_for_bit():
    def said(*arguments):
        return json.loads(subprocess.check_output([os.environ["EIGENTONE"], *arguments, str(CAR), "--json"]))

    table, motion = said("modes"), said("response")
    modes, moved = eigentone.modes(CAR), eigentone.response(json.loads(CAR.read_text()))
    assert [complex(root["re"], root["im"]) for root in table["eigenvalues"]] == modes.eigenvalues.tolist()
    assert [root["bound"] for root in table["eigenvalues"]] == modes.eigenvalue_bounds.tolist()
    for i, name in enumerate(moved.names):
        assert motion["displacement"][name] == moved.displacement[i].tolist()
        assert motion["velocity"][name] == moved.velocity[i].tolist()
    assert motion["displacement_bound"] == moved.displacement_bound.tolist()
    for name, values in motion["outputs"].items():
        assert values == moved.outputs[name].tolist()
        assert motion["output_bound"][name] == moved.output_bounds[name].tolist()


@pytest.mark.parametrize(
    "ask, message",
    [
        (lambda: eigentone.modes(M, None, K[:2]), "2"),
        (lambda: eigentone.modes(M, None, K * np.nan), "finite"),
        (lambda: eigentone.modes({"masses": []}), "masses"),
        (lambda: eigentone.modes({"mases": []}), "did you mean"),
        (lambda: eigentone.modes(M, None, K, precision="exact"), "certified"),
        (lambda: eigentone.response(eigentone.scene(M, C, K)), "time"),
        (lambda: eigentone.frf(eigentone.scene(M, C, K), 1.0, inputs="x9"), "x9"),
        (lambda: eigentone.expm([[1.0, 2.0]]), "square"),
        (lambda: eigentone.discretise(eigentone.scene(M, C, K), 0.1, hold="second"), "first"),
        (lambda: eigentone.discretise(eigentone.scene(M, C, K), -1.0), "greater than 0"),
    ],
)
def test_what_is_wrong_is_a_value_error_that_says_so(ask, message):
    with pytest.raises(ValueError, match=message):
        ask()
