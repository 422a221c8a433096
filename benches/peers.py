#!/usr/bin/env python3
"""What NumPy and SciPy take for the same work, on one thread: best of several runs, in microseconds.

usage: OPENBLAS_NUM_THREADS=1 python3 benches/peers.py [expm] [eig] [full] [lsim] [sweep] [eigsh] [frf]

Prints a name and a time a line; all sections if none is named. `cargo bench --bench limits` reads it
where PEERS_PYTHON names the Python to run it with. Chains between two walls: unit masses, springs
from 1e3 to 1.1e4, dampers from 0 to 1, h = 0.01; the one of three masses has h = 1.
"""
import sys
import time

import numpy as np
import scipy.linalg
import scipy.signal
import scipy.sparse
import scipy.sparse.linalg


def best(body, seconds=0.5):
    body()
    began, least = time.perf_counter(), float("inf")
    while time.perf_counter() - began < seconds:
        start = time.perf_counter()
        body()
        least = min(least, time.perf_counter() - start)
    return least * 1e6


def chain(n):
    """M, C, K and h."""
    if n == 3:
        k, c = np.array([6.0, 7, 4, 1]), np.array([1, 0.2, 0.1, 2])
        m, h = np.array([6.0, 9, 5]), 1.0
    else:
        i = np.arange(n + 1)
        k = 1e3 + 1e4 * (i * 0.6180339887498949 % 1)
        c = i * 0.4142135623730951 % 1
        m, h = np.ones(n), 0.01
    matrix = lambda v: np.diag(v[:-1] + v[1:]) - np.diag(v[1:-1], 1) - np.diag(v[1:-1], -1)
    return np.diag(m), matrix(c), matrix(k), h


def state_matrix(m, c, k):
    n, d = len(m), np.diag(m)[:, None]
    return np.block([[np.zeros((n, n)), np.eye(n)], [-k / d, -c / d]])


def expm():
    for n in (3, 20, 100, 200):
        m, c, k, h = chain(n)
        a = state_matrix(m, c, k) * h
        yield f"expm {2 * n}", best(lambda: scipy.linalg.expm(a))
        yield f"product {2 * n}", best(lambda: a @ a)


def eig():
    for n in (3, 20, 100, 200, 500):
        m, c, k, _ = chain(n)
        a, zero, one = state_matrix(m, c, k), np.zeros((n, n)), np.eye(n)
        left, right = np.block([[zero, one], [-k, -c]]), np.block([[one, zero], [zero, m]])
        yield f"eig {n}", best(lambda: np.linalg.eig(a))
        yield f"eig(A, B) {n}", best(lambda: scipy.linalg.eig(left, right))
        yield f"eigh {n}", best(lambda: scipy.linalg.eigh(k, m))


def definite(n, seed, shift):
    i = np.arange(n)
    numbers = (i * i * 31 + i * 7919)[:, None] + (i * i * 17 + i * 104729) + np.outer(i, i) * 13 + seed
    g = numbers % 10007 / 10007 - 0.5
    return g @ g.T * 12 / n + shift * np.eye(n)


def beam(n):
    """A beam clamped at one end, with a dashpot at a third of its length."""
    l = 20 / n
    k = [[12, 6 * l, -12, 6 * l], [6 * l, 4 * l * l, -6 * l, 2 * l * l]]
    k += [[-12, -6 * l, 12, -6 * l], [6 * l, 2 * l * l, -6 * l, 4 * l * l]]
    m = [[156, 22 * l, 54, -13 * l], [22 * l, 4 * l * l, 13 * l, -3 * l * l]]
    m += [[54, 13 * l, 156, -22 * l], [-13 * l, -3 * l * l, -22 * l, 4 * l * l]]
    mass, damping, stiffness = np.zeros((3, n + 2, n + 2))
    for at in range(0, n, 2):
        mass[at : at + 4, at : at + 4] += 7.8 * l / 420 * np.array(m)
        stiffness[at : at + 4, at : at + 4] += 2.1e5 / l**3 * np.array(k)
    damping[n // 6 * 2 + 2, n // 6 * 2 + 2] = 50
    return mass[2:, 2:], damping[2:, 2:], stiffness[2:, 2:]


def full():
    """Full matrices and finite elements: state matrix and all its modes, or `lsim` with all states."""
    matrices = lambda n: (definite(n, 1, 1), 0.05 * definite(n, 2, 0.1), 100 * definite(n, 3, 0.5))

    def states(m, c, k):
        factor, n = scipy.linalg.cho_factor(m), len(m)
        lower = [-scipy.linalg.cho_solve(factor, k), -scipy.linalg.cho_solve(factor, c)]
        return np.block([[np.zeros((n, n)), np.eye(n)], lower])

    for n in (50, 100, 200, 300):
        m, c, k = matrices(n)
        yield f"full, damped {n}", best(lambda: np.linalg.eig(states(m, c, k)))
        yield f"full, undamped {n}", best(lambda: scipy.linalg.eigh(k, m))
    for n in (100, 200, 400, 600):
        m, c, k = beam(n)
        yield f"beam with a dashpot {n}", best(lambda: np.linalg.eig(states(m, c, k)))
    for n in (50, 100, 200):
        m, c, k = matrices(n)
        a, b = states(m, c, k), np.vstack([np.zeros((n, 3)), np.linalg.inv(m)[:, :3]])
        t = np.arange(2001) * 0.01
        u = np.sin(np.outer(t, [3, 4, 5]))
        system = (a, b, np.eye(2 * n), np.zeros((2 * n, 3)))
        yield f"full, 2000 held steps {n}", best(lambda: scipy.signal.lsim(system, u, t, interp=False))


def lsim():
    m, c, k, _ = chain(3)
    a, n = state_matrix(m, c, k), 3
    b = np.vstack([np.zeros((n, n)), np.linalg.inv(m)])
    out, feed = np.hstack([np.eye(n), np.zeros((n, n))]), np.zeros((n, n))
    for count in (201, 100001):
        t, u = np.arange(count) * 0.1, np.tile([3.0, 9, 12], (count, 1))
        run = lambda: scipy.signal.lsim((a, b, out, feed), u, t, X0=[6, 7, 8, 0, 0, 0])
        yield f"lsim {count}", best(run)


def sweep():
    """One design of three masses: its modes and 200 instants."""
    times = np.arange(200) * 0.1
    forces = np.tile([3.0, 9, 12], (200, 1))

    def design():
        m, c, k, _ = chain(3)
        a = state_matrix(m, c, k)
        b = np.vstack([np.zeros((3, 3)), np.linalg.inv(m)])
        out, feed = np.eye(6), np.zeros((6, 3))
        np.linalg.eig(a)
        scipy.signal.lsim((a, b, out, feed), forces, times, X0=[6, 7, 8, 0, 0, 0])

    yield "sweep", best(design)


def eigsh():
    for n in (100_000, 1_000_000):
        k = 1e4
        stiffness = scipy.sparse.diags(
            [np.full(n - 1, -k), np.full(n, 2 * k), np.full(n - 1, -k)], [-1, 0, 1], format="csc"
        )
        mass = scipy.sparse.identity(n, format="csc")
        start = time.perf_counter()
        found = scipy.sparse.linalg.eigsh(stiffness, 20, M=mass, sigma=0.0)[0]
        spent = time.perf_counter() - start
        exact = 2 * np.sqrt(k) * np.sin(np.arange(1, 21) * np.pi / (2 * (n + 1)))
        assert np.max(abs(np.sqrt(found) - exact) / exact) < 1e-6
        yield f"eigsh {n}", spent * 1e6


def frf():
    for n in (50, 200):
        random = np.random.default_rng(1)
        joins = np.triu(random.random((n, n)), 1)
        stiffness = np.diag(10 + (joins + joins.T).sum(0)) - joins - joins.T
        joins = np.triu(0.05 * random.random((n, n)) * (random.random((n, n)) < 0.2), 1)
        damping = np.diag((joins + joins.T).sum(0)) - joins - joins.T
        mass, force = np.diag(0.5 + random.random(n)), np.eye(n)[:, 0]

        def solve():
            for omega in np.linspace(15 / 200, 15, 200):
                np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, force)

        # A tenth of the frequencies.
        yield f"frf {n}, 2000 frequencies", 10 * best(solve)


SECTIONS = {section.__name__: section for section in (expm, eig, full, lsim, sweep, eigsh, frf)}

if __name__ == "__main__":
    for name in sys.argv[1:] or SECTIONS:
        if name not in SECTIONS:
            sys.exit(f"{name} is no section: there are {', '.join(SECTIONS)}")
        for what, microseconds in SECTIONS[name]():
            print(what, f"{microseconds:.3f}", flush=True)
