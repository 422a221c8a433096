"""Writes truth.txt: largest motions of one-mass systems on shaken bases with 40 digits; peaks between samples are roots of
the slope, found from a fine grid in doubles. Needs mpmath and NumPy. A line has the base, frequency, ratio, displacement
and absolute acceleration."""

import numpy as np
from mpmath import mp, mpf, matrix, expm, pi, findroot, zeros, sqrt, fabs, inf

mp.dps = 40
RECORD = [0.0, 0.5, -1.25, 2.0, 0.75, -3.0, 1.5, 0.25, -0.5, 2.5, -1.0, 0.125, 0.0, -0.75, 0.5, 0.0]
STEP = 0.02
HALF_SINE = (9.0, 0.011)


class System:
    def __init__(self, f, ratio, kind, unit):
        self.w = 2 * pi * mpf(f)
        self.ratio = mpf(ratio)
        g = zeros(5)
        g[0, 1] = 1
        g[1, 0] = -self.w ** 2
        g[1, 1] = -2 * self.ratio * self.w
        g[1, 2] = -1
        if kind == "straight":
            g[2, 3] = 1
        else:
            g[2, 3], g[3, 2] = pi / mpf(unit), -pi / mpf(unit)
        self.g = g
        self.rough = np.array(g.tolist(), dtype=float)

    def at(self, state, t):
        return expm(self.g * t, method="taylor") * state

    def forms(self):
        return [matrix([[1, 0, 0, 0, 0]]), matrix([[self.w ** 2, 2 * self.ratio * self.w, 0, 0, 0]])]


def rough_samples(system, state, length, count):
    """Values of both forms on a grid, by powers of one small map in doubles."""
    from scipy.linalg import expm as quick
    small = quick(system.rough * (float(length) / count))
    z = np.array([float(x) for x in state])
    out = [z]
    for _ in range(count):
        z = small @ z
        out.append(z)
    return np.array(out)


def largest(system, pieces):
    answers = []
    grids = []
    for state, length in pieces:
        count = int(min(20000, max(64, 40 * float(system.w * length))))
        grids.append((state, length, count, rough_samples(system, state, length, count)))
    for form in system.forms():
        row = np.array([float(x) for x in form])
        slope = form * system.g
        best_rough = max(np.abs(g[3] @ row).max() for g in grids)
        best = mpf(0)
        for state, length, count, samples in grids:
            values = np.abs(samples @ row)
            for k in np.nonzero(values >= best_rough * (1 - 1e-3))[0]:
                lo, hi = max(k - 1, 0), min(k + 1, count)
                if values[k] < max(values[lo], values[hi]):
                    continue
                t = mpf(length) * int(k) / count
                best = max(best, fabs((form * system.at(state, t))[0]))
                try:
                    root = findroot(lambda s: (slope * system.at(state, s))[0], (t, t + mpf(length) / count / 3), tol=1e-60, verify=False)
                except (ValueError, ZeroDivisionError):
                    continue
                if 0 <= root <= mpf(length):
                    best = max(best, fabs((form * system.at(state, root))[0]))
        answers.append(best)
    return answers


def free_length(system):
    return mpf(1.3) * pi / system.w / sqrt(max(mpf("1e-3"), fabs(1 - system.ratio ** 2))) + 8 / system.w


def line(base, f, ratio, answers):
    print(base, repr(f), repr(ratio), *(mp.nstr(x, 25) for x in answers))


for hold in ["zero", "first"]:
    for ratio in [0.0, 0.05, 1.0, 3.0]:
        for f in [0.03, 0.4, 2.0, 7.0, 25.0, 90.0, 700.0]:
            system = System(f, ratio, "straight", STEP)
            state = matrix([0, 0, 0, 0, 0])
            pieces = []
            h = mpf(STEP)
            for k in range(len(RECORD) - (hold == "first")):
                a = mpf(RECORD[k])
                b = (mpf(RECORD[k + 1]) - a) / h if hold == "first" else mpf(0)
                state = matrix([state[0], state[1], a, b, 0])
                pieces.append((state, h))
                state = system.at(state, h)
            state = matrix([state[0], state[1], 0, 0, 0])
            pieces.append((state, free_length(system)))
            line("record-" + hold, f, ratio, largest(system, pieces))

force, duration = HALF_SINE
for k in range(200):
    f = float(0.05 / duration * 10 ** (mpf(k) / 199 * 3))
    for ratio in [0.0] if k % 20 else [0.0, 0.05, 1.5]:
        system = System(f, ratio, "sine", duration)
        state = matrix([0, 0, 0, mpf(force), 0])
        pieces = [(state, mpf(duration))]
        state = system.at(state, mpf(duration))
        pieces.append((matrix([state[0], state[1], 0, 0, 0]), free_length(system)))
        line("half-sine", f, ratio, largest(system, pieces))
