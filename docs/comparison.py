"""What NumPy and SciPy make of the scenes whose answers are known to 34 digits: the table of comparison.md.

    python docs/comparison.py        needs numpy and scipy, and runs for a minute

Eigenvalues: scipy.linalg.eig of the first companion pencil of lambda^2 M + lambda C + K. Motion: scipy.linalg.expm of
the state matrix bordered by the loads' own laws, stepped from sample to sample. Both are what a careful user
would write; the matrices are assembled in doubles.
"""

import json
import pathlib

import numpy as np
import scipy
from scipy.linalg import eig, expm
from scipy.optimize import linear_sum_assignment

TESTS = pathlib.Path(__file__).parent.parent / "tests"


def matrices(scene):
    names = [mass["name"] for mass in scene.get("masses", [])]
    given = scene.get("matrices", {})
    if not names:
        names = [f"x{i + 1}" for i in range(len(next(iter(given.values()))))]
    n = len(names)
    index = {name: i for i, name in enumerate(names)}
    parts = {kind: np.array(given.get(kind, np.zeros((n, n))), float) for kind in ("mass", "damping", "stiffness")}
    for mass in scene.get("masses", []):
        parts["mass"][index[mass["name"]], index[mass["name"]]] += mass["mass"]
    for list_name, kind in (("springs", "stiffness"), ("dampers", "damping")):
        for element in scene.get(list_name, []):
            ends = [index[end] for end in element["between"] if end != "ground"]
            for i in ends:
                for j in ends:
                    parts[kind][i, j] += element[kind] * (1 if i == j else -1)
    return index, parts["mass"], parts["damping"], parts["stiffness"]


def eigenvalue_error(scene, truth):
    """The worst |found - true| / |true| over the roots that are not 0."""
    _, m, c, k = matrices(scene)
    n = len(m)
    zero, one = np.zeros((n, n)), np.eye(n)
    found = eig(np.block([[zero, one], [-k, -c]]), np.block([[one, zero], [zero, m]]), right=False)
    # A root of multiplicity m stands in m rows.
    true = np.array([complex(float(re), float(im)) for re, im, _ in truth["eigenvalues"]])
    found = found[np.isfinite(found)]
    if len(found) < len(true):
        return np.inf
    with np.errstate(over="ignore"):
        cost = abs(found[None, :] - true[:, None]) / np.maximum(abs(true[:, None]), 1e-300)
    rows, columns = linear_sum_assignment(np.minimum(cost, 1e12))
    moving = [i for i in range(len(rows)) if true[rows[i]] != 0]
    return max(cost[rows[i], columns[i]] for i in moving)


def motion_error(scene, truth):
    """The worst error of a displacement, relative to the largest one of its instant."""
    index, m, c, k = matrices(scene)
    n = len(m)
    loads = scene.get("loads", [])
    size = 2 * n + 1 + 2 * len(loads)
    a = np.zeros((size, size))
    z = np.zeros(size)
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -np.linalg.solve(m, k)
    a[n : 2 * n, n : 2 * n] = -np.linalg.solve(m, c)
    z[2 * n] = 1
    for position, load in enumerate(loads):
        direction = np.linalg.solve(m, np.eye(n)[index[load["on"]]])
        if "step" in load and load["step"].get("start", 0) == 0:
            a[n : 2 * n, 2 * n] += direction * load["step"]["force"]
        elif "impulse" in load and load["impulse"].get("at", 0) == 0:
            z[n : 2 * n] += direction * load["impulse"]["magnitude"]
        elif "harmonic" in load:
            at, law = 2 * n + 1 + 2 * position, load["harmonic"]
            a[n : 2 * n, at] = direction * law["amplitude"]
            a[at, at + 1], a[at + 1, at] = law["frequency"], -law["frequency"]
            z[at], z[at + 1] = np.sin(law.get("phase", 0)), np.cos(law.get("phase", 0))
        else:
            return None
    for name, start in scene.get("initial", {}).items():
        z[index[name]] += start.get("displacement", 0)
        z[n + index[name]] += start.get("velocity", 0)
    step = expm(a * scene["time"]["step"])
    samples = {row["step"]: [float(x) for x in row["displacement"]] for row in truth["response"]}
    worst, at = 0.0, 0
    for sample in sorted(samples):
        for _ in range(sample - at):
            z = step @ z
        at = sample
        largest = max(map(abs, samples[sample]))
        if largest > 0:
            worst = max(worst, max(abs(z[:n] - samples[sample])) / largest)
    return worst


def shown(error):
    return "–" if error is None else "lost" if not error < 0.5 else f"{error:.0e}".replace("e-0", "e-")


def main():
    print(f"NumPy {np.__version__}, SciPy {scipy.__version__}\n")
    print("| scene | eigenvalues | displacement |\n|---|--:|--:|")
    for folder in ("gallery", "extreme"):
        for path in sorted((TESTS / folder / "scenes").glob("*.json")):
            scene = json.loads(path.read_text())
            truth = json.loads((TESTS / folder / "truth" / path.name).read_text())
            _, m, _, _ = matrices(scene)
            if np.linalg.matrix_rank(m) < len(m) and 0 in np.diag(m):
                continue
            moves = folder == "gallery" and "time" in scene
            motion = motion_error(scene, truth) if moves else None
            print(f"| {path.stem} | {shown(eigenvalue_error(scene, truth))} | {shown(motion)} |")


main()
