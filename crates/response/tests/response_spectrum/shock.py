"""Writes shock.txt: largest motions of damped one-mass systems under a half-sine shock from the closed form with 60 digits,
y = Im(H e^(i omega_p t)) + e^(-zeta omega t) (A cos omega_d t + B sin omega_d t) in it and free after it. Needs mpmath and
NumPy. A line has the base, frequency, ratio, displacement and absolute acceleration."""

import numpy as np
from mpmath import mp, mpf, mpc, pi, exp, sqrt, fabs, findroot, nstr

mp.dps = 60
FORCE, DURATION = mpf(9.0), mpf(0.011)


class Free:
    """e^(-zeta omega t) (A cos omega_d t + B sin omega_d t) from y and y', as Re(c e^(pole t))."""

    def __init__(self, omega, ratio, y, v):
        self.pole = mpc(-ratio * omega, omega * sqrt(1 - ratio ** 2))
        self.c = mpc(y, -(v - self.pole.real * y) / self.pole.imag)
        self.driven = mpc(0)
        self.turn = mpc(0)

    def at(self, t, order):
        free = self.c * self.pole ** order * exp(self.pole * t)
        return free.real + (self.driven * self.turn ** order * exp(self.turn * t)).imag

    def rough(self, t, order):
        free = complex(self.c * self.pole ** order) * np.exp(complex(self.pole) * t)
        driven = complex(self.driven * self.turn ** order) * np.exp(complex(self.turn) * t)
        return free.real + driven.imag


def shocked(omega, ratio):
    turn = mpc(0, pi / DURATION)
    driven = -FORCE / (turn ** 2 + 2 * ratio * omega * turn + omega ** 2)
    motion = Free(omega, ratio, -driven.imag, -(driven * turn).imag)
    motion.driven, motion.turn = driven, turn
    return motion


def largest(form, pieces):
    best, rough = mpf(0), 0.0
    grids = []
    for motion, length, count in pieces:
        t = np.linspace(0.0, float(length), count)
        values = np.abs(sum(float(a) * motion.rough(t, k) for k, a in enumerate(form)))
        grids.append(values)
        rough = max(rough, values.max())
    for (motion, length, count), values in zip(pieces, grids):
        value = lambda t, more: sum(a * motion.at(t, k + more) for k, a in enumerate(form))
        for k in np.nonzero(values >= rough * (1 - 1e-3))[0]:
            if values[k] < max(values[max(k - 1, 0)], values[min(k + 1, count - 1)]):
                continue
            t = length * int(k) / (count - 1)
            best = max(best, fabs(value(t, 0)))
            root = findroot(lambda s: value(s, 1), (t, t + length / count / 3), tol=1e-90, verify=False)
            if 0 <= root <= length:
                best = max(best, fabs(value(root, 0)))
    return best


for k in range(200):
    f = float(0.05 / DURATION * 10 ** (mpf(k) / 199 * 3))
    ratio = 0.05
    omega, zeta = 2 * pi * mpf(f), mpf(ratio)
    motion = shocked(omega, zeta)
    after = Free(omega, zeta, motion.at(DURATION, 0), motion.at(DURATION, 1))
    pieces = [(motion, DURATION, 400 + int(80 * f * DURATION)), (after, 1 / mpf(f), 400)]
    forms = [[mpf(1)], [omega ** 2, 2 * zeta * omega]]
    print("half-sine", repr(f), repr(ratio), *(nstr(largest(form, pieces), 25) for form in forms))
