"""Ten lowest modes of growing models: this program, SciPy, and SLEPc on one and two ranks, one after the other.

Usage: scaling.py EIGENTONE [LIMIT]. Prints rows of the table in docs/scaling.md: seconds and the most memory of a process.
Runs under a Python with SciPy; a peer that is missing, or takes longer than LIMIT seconds (300), leaves a dash.
"""

import os
import struct
import subprocess
import sys
import tempfile

import numpy
import scipy.sparse

PEER = """
import sys, numpy, scipy.sparse, scipy.sparse.linalg
k, m = (scipy.sparse.load_npz(file).tocsc() for file in sys.argv[1:3])
plain = (m - scipy.sparse.identity(m.shape[0])).nnz == 0
values = scipy.sparse.linalg.eigsh(k, k=10, M=None if plain else m, sigma=0, return_eigenvectors=True)[0]
"""


def path(n):
    return scipy.sparse.diags([-numpy.ones(n - 1), 2 * numpy.ones(n), -numpy.ones(n - 1)], [-1, 0, 1])


def grid(sides):
    """Masses of 1 joined to their neighbours by springs of 1, held at the rim."""
    whole = scipy.sparse.csr_matrix((1, 1))
    for side in sides:
        whole = scipy.sparse.kronsum(path(side), whole, format="csr")
    return scipy.sparse.identity(whole.shape[0]), whole


def hermite(h):
    """A beam of length h by cubic polynomials: its integrals of w w, w' w' and w'' w''."""
    mass = [[156, 22 * h, 54, -13 * h], [0, 4 * h * h, 13 * h, -3 * h * h], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h * h]]
    slope = [[36, 3 * h, -36, 3 * h], [0, 4 * h * h, -3 * h, -h * h], [0, 0, 36, -3 * h], [0, 0, 0, 4 * h * h]]
    bend = [[12, 6 * h, -12, 6 * h], [0, 4 * h * h, -6 * h, 2 * h * h], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h * h]]
    whole = lambda upper: numpy.triu(upper) + numpy.triu(upper, 1).T
    return whole(mass) * (h / 420), whole(slope) / (30 * h), whole(bend) / h**3


def along(element, count):
    """The matrix of so many elements of two nodes with two coordinates each."""
    at = 2 * numpy.arange(count)[:, None, None]
    rows = at + numpy.arange(4)[None, :, None] + 0 * element[None]
    columns = at + numpy.arange(4)[None, None, :] + 0 * element[None]
    values = numpy.broadcast_to(element, rows.shape)
    order = 2 * (count + 1)
    return scipy.sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), (order, order))


def beam(sides):
    """A cantilever."""
    [count] = sides
    mass, _, bend = (along(element, count)[2:, 2:] for element in hermite(1 / count))
    return 3.1 * mass, 1500 * bend


def plate(sides):
    """A clamped plate of Bogner, Fox and Schmit's elements, four coordinates a node."""
    parts = [[along(element, side)[2:-2, 2:-2] for element in hermite(1 / side)] for side in sides]
    (mass, slope, bend), (other_mass, other_slope, other_bend) = parts
    product = scipy.sparse.kron
    stiffness = product(bend, other_mass) + product(mass, other_bend) + 2 * product(slope, other_slope)
    return product(mass, other_mass), stiffness


def truss(sides):
    """Nodes of a block joined by bars along its edges and the diagonals of its faces, held at the lowest."""
    nodes = numpy.arange(numpy.prod(sides)).reshape(sides)
    order = 3 * nodes.size
    mass, stiffness = numpy.zeros(order), scipy.sparse.csr_matrix((order, order))
    for way in [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (0, 1, 1), (0, 1, -1), (1, 0, 1), (1, 0, -1)]:
        first = nodes[tuple(slice(max(0, -d), side - max(0, d)) for d, side in zip(way, sides))].ravel()
        last = nodes[tuple(slice(max(0, d), side - max(0, -d)) for d, side in zip(way, sides))].ravel()
        length = numpy.linalg.norm(way)
        pull = numpy.concatenate([-numpy.array(way), way]) / length
        places = numpy.concatenate([3 * first[:, None] + range(3), 3 * last[:, None] + range(3)], axis=1)
        rows, columns = numpy.repeat(places, 6, axis=1), numpy.tile(places, 6)
        values = numpy.tile(numpy.outer(pull, pull).ravel() * (2e8 / length), (len(first), 1))
        stiffness += scipy.sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), (order, order))
        numpy.add.at(mass, places.ravel(), 0.039 * length)
    free = (nodes % sides[2] > 0).ravel().repeat(3)
    return scipy.sparse.diags(mass[free]), stiffness[free][:, free]


def petsc(matrix, file):
    n = matrix.shape[0]
    matrix.sort_indices()
    matrix.eliminate_zeros()
    with open(file, "wb") as out:
        out.write(struct.pack(">4i", 1211216, n, n, matrix.nnz))
        out.write(numpy.diff(matrix.indptr).astype(">i4").tobytes())
        out.write(matrix.indices.astype(">i4").tobytes())
        out.write(matrix.data.astype(">f8").tobytes())


def timed(command, limit):
    """Seconds and megabytes of a command; None where it fails or takes too long."""
    wrapped = ["/usr/bin/time", "-f", "%e %M", *command]
    try:
        done = subprocess.run(wrapped, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0:
        sys.stderr.write(" ".join(command) + ": " + done.stderr[-300:] + "\n")
        return None
    seconds, kilobytes = done.stderr.strip().splitlines()[-1].split()
    return float(seconds), float(kilobytes) / 1e3


def main(program, limit):
    models = [("chain", grid, [n]) for n in (10_000, 100_000, 1_000_000)]
    models += [("grid", grid, [side] * 2) for side in (100, 200, 500, 1000)]
    models += [("block", grid, [side] * 3) for side in (20, 30, 40, 50)]
    models += [("beam", beam, [2_000]), ("beam", beam, [20_000]), ("plate", plate, [106, 107]), ("truss", truss, [12, 13, 21])]
    print("| model | n | this program | SciPy | SLEPc, 1 rank | SLEPc, 2 ranks |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, make, sides in models:
            m, k = (scipy.sparse.csr_matrix(matrix) for matrix in make(sides))
            # As exactly symmetric as its doubles can be.
            m, k = (m + m.T) / 2, (k + k.T) / 2
            n = k.shape[0]
            join = lambda file: os.path.join(folder, file)
            petsc(k, join("k.petsc"))
            petsc(m, join("m.petsc"))
            scipy.sparse.save_npz(join("k.npz"), k)
            scipy.sparse.save_npz(join("m.npz"), m)
            with open(join("scene.json"), "w") as out:
                out.write('{"matrices": {"mass": "m.petsc", "stiffness": "k.petsc"}}')
            modes = [program, "modes", join("scene.json"), "--lowest", "10", "--memory-limit", "20"]
            runs = [modes, [sys.executable, "-c", PEER, join("k.npz"), join("m.npz")]]
            runs += [modes + ["--engine", "slepc", "--no-factor", "--ranks", ranks] for ranks in "12"]
            cells = []
            for run in runs:
                took = timed(run, limit)
                cells.append("–" if took is None else f"{took[0]:.2f} s, {took[1]:.0f} MB")
            shape = " × ".join(map(str, sides))
            print(f"| {name} {shape} | {n} | " + " | ".join(cells) + " |", flush=True)


main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 300.0)
