"""The package against SciPy, against closed forms, and against the command line bit for bit."""

import json
import os
import subprocess
import warnings
from decimal import Decimal
from fractions import Fraction
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


# A mass of 1 kg on a spring of 4 N/m and a rough table, let go at 1 m: each half swing loses 2 F/k = 0.25 m, until it
# holds at 0.
ROUGH = {
    "masses": [{"name": "m", "mass": 1}],
    "springs": [{"between": ["ground", "m"], "stiffness": 4}],
    "frictions": [{"between": ["ground", "m"], "force": 0.5}],
    "initial": {"m": {"displacement": 1}},
    "time": {"end": 7, "step": 0.125},
}
# Two masses on each other, pulled so that either friction may give way.
PILED = {
    "masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 1}],
    "frictions": [{"between": pair, "force": 1, "static": 2} for pair in (["ground", "a"], ["a", "b"])],
    "loads": [{"on": "b", "step": {"force": 2.5}}],
    "time": {"end": 1, "step": 0.5},
}


def test_a_friction_is_followed_from_event_to_event():
    motion = eigentone.response(ROUGH)
    assert motion.bounds == "proven"
    expected = []
    for time in motion.time:
        half, phase = divmod(2 * time, np.pi)
        expected.append(0 if half >= 4 else (-1) ** half * (0.125 + (0.875 - 0.25 * half) * np.cos(phase)))
    assert np.abs(motion.displacement[0] - expected).max() < 1e-15
    assert [(event.kind, event.element) for event in motion.events] == [
        (kind, "frictions[0]") for kind in ("slip", "slip", "slip", "stick")
    ]
    for k, event in enumerate(motion.events):
        assert abs(event.time - (k + 1) * np.pi / 2) <= event.bound + 1e-15
    assert eigentone.response(NAMED).events == []


@pytest.mark.parametrize(
    "ask",
    [
        lambda: eigentone.modes(ROUGH),
        lambda: eigentone.frf(ROUGH, 1.0),
        lambda: eigentone.state_space(ROUGH),
        lambda: eigentone.discretise(ROUGH, 0.1),
    ],
)
def test_what_leaves_frictions_out_says_so(ask):
    with pytest.warns(UserWarning, match="without its frictions") as said:
        ask()
    assert said[0].filename == __file__


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


@pytest.mark.skipif("EIGENTONE" not in os.environ, reason="EIGENTONE names the program to compare with")
def test_a_friction_is_that_of_the_command_line_bit_for_bit(tmp_path):
    file = tmp_path / "rough.json"
    file.write_text(json.dumps(ROUGH))
    said = json.loads(subprocess.check_output([os.environ["EIGENTONE"], "response", str(file), "--json"]))
    moved = eigentone.response(file)
    assert said["displacement"]["m"] == moved.displacement[0].tolist()
    assert said["displacement_bound"] == moved.displacement_bound.tolist()
    events = [(event["time"], event["bound"], event["what"], event["element"]) for event in said["events"]]
    assert events == [(event.time, event.bound, event.kind, event.element) for event in moved.events]


# A mass without dampers but those on a shaker, whose velocity the acceleration of the mass then follows.
SHAKEN = {
    "masses": [{"name": "m", "mass": 1}],
    "supports": ["shaker"],
    "springs": [{"between": ["shaker", "m"], "stiffness": 4}],
    "dampers": [{"between": ["shaker", "m"], "damping": 0.5}],
    "outputs": [{"name": "shock", "acceleration": {"m": 1}}],
}
# An output has the name of its mass.
NAMED = {
    "masses": [{"name": "a", "mass": 1}],
    "springs": [{"between": ["ground", "a"], "stiffness": 4}],
    "outputs": [{"name": "a", "velocity": {"a": 1}}],
    "initial": {"a": {"displacement": 1}},
    "time": {"end": 1, "step": 0.5},
}


def test_numbers_of_any_type_are_the_nearest_doubles():
    def root(k, m=((1,),)):
        return eigentone.modes(m, None, k).natural_frequencies[0]

    whole = [[4]], np.array([[4]], ">f8"), np.array([[4]], "f4"), np.array([[np.longdouble(4)]]), [[Fraction(4)]]
    for given in (*whole, [[Decimal(4)]], np.array([[4]], object), np.ma.masked_array([[4.0]])):
        assert root(given) == 2
    assert root([[True]]) == 1 and root([[2**82]], [[2**80]]) == 2
    packed = np.zeros(1, np.dtype([("a", "i1"), ("k", "f8", (1, 1))]))["k"][0]
    packed[:] = 4
    assert not packed.flags.aligned and root(packed) == 2
    read_only = np.array([[4.0]])
    read_only.setflags(write=False)
    assert root(read_only) == 2
    for number in (np.longdouble(1), np.float32(1), np.int8(1), Fraction(1), Decimal(1), np.array(1.0)):
        scene = {**NAMED, "masses": [{"name": "a", "mass": number}]}
        assert eigentone.modes(scene).natural_frequencies[0] == 2


def test_steps_are_whole_numbers():
    scene = eigentone.scene(M, C, K, x0=[1, 0, 0], step=0.5, end=2)
    for steps in ([2.0, 3], np.array([2, 3], "u1"), iter([2, np.float32(3)])):
        assert eigentone.response(scene, steps=steps).time.tolist() == [1.0, 1.5]


def test_an_output_with_the_name_of_a_mass_hides_nothing():
    plant = eigentone.state_space(NAMED)
    assert plant.outputs == ["a displacement", "a"] and plant.C.values.tolist() == [[1, 0], [0, 1]]
    values = eigentone.frf(NAMED, 1.0).values
    assert abs(values["a", "a displacement"][0] - 1 / 3) < 1e-15 and abs(values["a", "a"][0] - 1j / 3) < 1e-15
    motion = eigentone.response(NAMED)
    assert motion.displacement[0, 0] == 1 and motion.outputs["a"][0] == 0


def test_outputs_come_in_the_order_of_their_names():
    assert eigentone.state_space(CAR, outputs=["travel", "body"]).outputs == ["travel", "body displacement"]


def test_supports_are_inputs_by_what_moves_them():
    for quantity in ("velocity", "acceleration"):
        moved = {**SHAKEN, "motions": [{"of": "shaker", quantity: {"ramp": {"rate": 1}}}]}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert eigentone.discretise(moved, 0.1).inputs == [f"shaker {quantity}"]
    with pytest.warns(UserWarning, match='output "shock" .* the velocity of shaker') as said:
        plant = eigentone.state_space(SHAKEN)
    assert said[0].filename == __file__
    assert plant.inputs == ["shaker velocity"] and plant.outputs == ["m displacement", "shock"]
    assert eigentone.state_space(SHAKEN, outputs="m").inputs == ["shaker displacement"]


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
        (lambda: eigentone.modes(M, None, K * (1 + 0.1j)), "K has complex numbers: .*real; .*loss_factor"),
        (lambda: eigentone.modes(M, None, (K * (1 + 0.1j)).tolist()), "complex"),
        (lambda: eigentone.modes({"matrices": {"mass": M, "stiffness": K * 1j}}), "real; .*loss_factor"),
        (lambda: eigentone.modes({"masses": [{"name": "a", "mass": 1j}]}), "real"),
        (lambda: eigentone.expm(np.array([[1j]])), "A has complex numbers: they must be real"),
        (lambda: eigentone.frf(eigentone.scene(M, C, K), np.array([1j, 2.0])), "frequency .* real"),
        (lambda: eigentone.scene(M * 1j), "M .* real"),
        (lambda: eigentone.scene(M, C, K, x0=np.array([1j, 0, 0])), "x0 .* real"),
        (lambda: eigentone.modes(M, None, np.array([["2000-01-01"] * 3] * 3, "M8[D]")), "K has a datetime64"),
        (lambda: eigentone.modes(M.astype("m8[s]"), None, K), "M has a timedelta64"),
        (lambda: eigentone.modes(np.ma.masked_equal(M, 2.0), None, K), "M has masked entries"),
        (lambda: eigentone.modes([np.ma.masked_equal(row, 2.0) for row in M], None, K), "M has masked entries"),
        (lambda: eigentone.modes({"matrices": {"mass": np.ma.masked_equal(M, 2.0)}}), "masked"),
        (lambda: eigentone.modes(M.astype(str).astype(object), None, K), "M has a str in it: real numbers"),
        (lambda: eigentone.modes([["1"]], None, [[1]]), "M has a str in it"),
        (lambda: eigentone.modes([[None]], None, [[1]]), "M has a NoneType in it"),
        (lambda: eigentone.modes([[10**400]], None, [[1]]), "largest double"),
        (lambda: eigentone.modes([[1, 2], [3]], None, K), "M has rows of several lengths"),
        (lambda: eigentone.modes(M[0], None, K), r"M has the shape \(3,\): it must be a matrix"),
        (lambda: eigentone.modes(M, None, 4.0), r"K has the shape \(\)"),
        (lambda: eigentone.modes(M, M[None], K), r"C has the shape \(1, 3, 3\)"),
        (lambda: eigentone.expm([1.0, 2.0]), "A has the shape"),
        (lambda: eigentone.modes(NAMED, None, K), "stands alone"),
        (lambda: eigentone.modes(M), "matrices are given as M, C, K"),
        (lambda: eigentone.modes(M, C), "matrices are given as M, C, K"),
        (lambda: eigentone.modes(M, None, K, precision=None), "precision is None"),
        (lambda: eigentone.modes({"masses": {1}}), "has a set in it"),
        (lambda: eigentone.modes({(1, 2): []}), "tuple"),
        (lambda: eigentone.response(5), "a dict or the path"),
        (lambda: eigentone.response(NAMED, steps=[2.9999999]), "2.9999999: it must be of whole numbers"),
        (lambda: eigentone.response(NAMED, steps=[0.3 / 0.1]), "whole numbers"),
        (lambda: eigentone.response(NAMED, steps=[-1]), "from 0 on"),
        (lambda: eigentone.response(NAMED, steps=[10**30]), "from 0 on, the indices"),
        (lambda: eigentone.response(NAMED, steps=[np.nan]), "whole numbers"),
        (lambda: eigentone.response(NAMED, steps=["1"]), "steps has a str"),
        (lambda: eigentone.response(NAMED, steps=1), "steps .* must be a list"),
        (lambda: eigentone.response(NAMED).of("a"), "a coordinate and an output"),
        (
            lambda: eigentone.response({**ROUGH, "frictions": [{"between": ["ground", "m"], "force": -1}]}),
            r"frictions\[0\].force",
        ),
        (lambda: eigentone.response(PILED), r"what frictions\[[01]\] does next: .*at once"),
        (lambda: eigentone.response(NAMED).of("b"), "known are"),
        (
            lambda: eigentone.frf(
                {**NAMED, "outputs": [*NAMED["outputs"], {"name": "a displacement", "displacement": {"a": 2}}]}, 1.0
            ),
            "rename the output",
        ),
        (lambda: eigentone.scene(M, C, K, x0=[1, 0, 0], initial={}), "initial is given twice, by x0 and v0"),
        (lambda: eigentone.scene(M, C, K, step=1, end=2, time={}), "time is given twice, by step and end"),
        (lambda: eigentone.scene(M, C, K, matrices={}), "matrices is given twice, by M, C and K"),
        (lambda: eigentone.scene(M, C, K, x0=[1]), "x0 has the length 1: .* 3"),
        (lambda: eigentone.scene(M, C, K, v0=[1, 2, 3, 4]), "v0 has the length 4: .* 3"),
        (lambda: eigentone.scene(M, C, K, step="1", end=2), "step has a str"),
        (lambda: eigentone.frf({**NAMED, "loads": [{"step": {"force": 1}}]}, 1.0), 'the key "on" is missing'),
        (lambda: eigentone.frf({**NAMED, "loads": 5}, 1.0), "loads: expected a list"),
        (lambda: eigentone.discretise({**NAMED, "loads": None}, 1.0), "loads: expected a list"),
        (lambda: eigentone.frf(NAMED, [[1.0], [2.0]]), "must be a number or a list of numbers"),
        (lambda: eigentone.frf(NAMED, 1.0, inputs=[]), r"inputs are \[\]"),
        (lambda: eigentone.frf(NAMED, 1.0, outputs=[]), "leave them out"),
        (lambda: eigentone.discretise(NAMED, 1.0, inputs=[]), "leave them out"),
        (lambda: eigentone.state_space(NAMED, outputs=()), "leave them out"),
        (lambda: eigentone.state_space(NAMED, outputs=[1]), r"outputs are \[1\]: give a name"),
        (lambda: eigentone.state_space(NAMED, inputs=5), r"inputs are \[5\]: give a name"),
        (lambda: eigentone.discretise(NAMED, np.array([0.1, 0.2])), "step .* must be a number"),
        (lambda: eigentone.discretise(NAMED, 0.1, hold=None), "hold is None"),
    ],
)
def test_what_is_wrong_is_a_value_error_that_says_so(ask, message):
    with pytest.raises(ValueError, match=message):
        ask()
