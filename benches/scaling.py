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
k = scipy.sparse.load_npz(sys.argv[1]).tocsc()
values = scipy.sparse.linalg.eigsh(k, k=10, sigma=0, return_eigenvectors=True)[0]
"""


def path(n):
    return scipy.sparse.diags([-numpy.ones(n - 1), 2 * numpy.ones(n), -numpy.ones(n - 1)], [-1, 0, 1])


def grid(sides):
    """Masses of 1 joined to their neighbours by springs of 1, held at the rim."""
    whole = scipy.sparse.csr_matrix((1, 1))
    for side in sides:
        whole = scipy.sparse.kronsum(path(side), whole, format="csr")
    whole.sort_indices()
    whole.eliminate_zeros()
    return whole


def petsc(matrix, file):
    n = matrix.shape[0]
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
    models = [("chain", [n]) for n in (10_000, 100_000, 1_000_000)]
    models += [("grid", [side] * 2) for side in (100, 200, 500, 1000)]
    models += [("block", [side] * 3) for side in (20, 30, 40, 50)]
    print("| model | n | this program | SciPy | SLEPc, 1 rank | SLEPc, 2 ranks |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, sides in models:
            k = grid(sides)
            n = k.shape[0]
            join = lambda file: os.path.join(folder, file)
            petsc(k, join("k.petsc"))
            petsc(scipy.sparse.identity(n, format="csr"), join("m.petsc"))
            scipy.sparse.save_npz(join("k.npz"), k)
            with open(join("scene.json"), "w") as out:
                out.write('{"matrices": {"mass": "m.petsc", "stiffness": "k.petsc"}}')
            modes = [program, "modes", join("scene.json"), "--lowest", "10", "--memory-limit", "20"]
            runs = [modes, [sys.executable, "-c", PEER, join("k.npz")]]
            runs += [modes + ["--engine", "slepc", "--no-factor", "--ranks", ranks] for ranks in "12"]
            cells = []
            for run in runs:
                took = timed(run, limit)
                cells.append("–" if took is None else f"{took[0]:.2f} s, {took[1]:.0f} MB")
            shape = " × ".join(map(str, sides))
            print(f"| {name} {shape} | {n} | " + " | ".join(cells) + " |", flush=True)


main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 300.0)
