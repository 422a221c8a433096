"""Eigenpairs of K x = w2 M x or (l2 M + l C + K) x = 0 by SLEPc, for the command that starts this on every rank.

Usage: slepc.py DIRECTORY. There are request.json and the matrices it names, in PETSc's binary format; answer.bin is
written there by the first rank, under another name until it is complete. What goes wrong is one line on standard error.
"""

import json
import os
import sys
import traceback


def say(text):
    sys.stderr.write("eigentone: " + text + "\n")
    sys.stderr.flush()


try:
    import petsc4py

    petsc4py.init()
    from petsc4py import PETSc
    import slepc4py

    slepc4py.init()
    from slepc4py import SLEPc
    import numpy
except ImportError as error:
    say("import failed: " + str(error))
    sys.exit(1)

COMM = PETSc.COMM_WORLD


def load(directory, name):
    matrix = PETSc.Mat().create(COMM)
    matrix.setType("aij")
    viewer = PETSc.Viewer().createBinary(os.path.join(directory, name), "r", COMM)
    matrix.load(viewer)
    viewer.destroy()
    return matrix


def direct(st, kind):
    """Shift and invert by a factor of MUMPS, which serves any number of ranks."""
    st.setType(SLEPc.ST.Type.SINVERT)
    ksp = st.getKSP()
    ksp.setType("preonly")
    pc = ksp.getPC()
    pc.setType(kind)
    pc.setFactorSolverType("mumps")


def undamped(mass, stiffness, shift, count, tolerance):
    """Eigenvalues w2 nearest to the shift; None where K - shift M has no factor."""
    eps = SLEPc.EPS().create(COMM)
    eps.setOperators(stiffness, mass)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(shift)
    eps.setDimensions(nev=count)
    eps.setTolerances(tol=tolerance, max_it=1000)
    direct(eps.getST(), "cholesky")
    try:
        eps.solve()
    except PETSc.Error as error:
        # Zero pivots and what a factor cannot do; anything else is for the caller.
        if error.ierr in (71, 76, 91):
            return None
        raise
    return eps


def squares(eps):
    return [eps.getEigenvalue(i).real for i in range(eps.getConverged())]


def held_apart(mass, stiffness, count, tolerance):
    """The lowest, from a shift below 0 of about a tenth of the largest looked for where K is singular or nearly so."""
    eps = undamped(mass, stiffness, 0.0, count, tolerance)
    found = [abs(value) for value in squares(eps)] if eps else []
    if found and min(found) > 1e-8 * max(found):
        return eps
    weights, rates = mass.getDiagonal(), stiffness.getDiagonal()
    heavy = weights.getArray() != 0.0
    rates.setArray(numpy.divide(rates.getArray(), weights.getArray(), out=0.0 * rates.getArray(), where=heavy))
    shift = -1e-6 * rates.norm(PETSc.NormType.INFINITY)
    for _ in range(12):
        eps = undamped(mass, stiffness, shift, count, 1e-4)
        found = [abs(value) for value in squares(eps)] if eps else []
        if not found:
            shift *= 100.0
            continue
        largest = max(found)
        if largest == 0.0 or 0.01 <= -shift / largest <= 1.0:
            return undamped(mass, stiffness, shift, count, tolerance)
        shift = -0.1 * largest
    return None


def quadratic(matrices, shift, count, tolerance):
    """Roots of l2 M + l C + K nearest to the shift."""
    mass, damping, stiffness = matrices
    pep = SLEPc.PEP().create(COMM)
    pep.setOperators([stiffness, damping, mass])
    pep.setProblemType(SLEPc.PEP.ProblemType.GENERAL)
    pep.setType(SLEPc.PEP.Type.TOAR)
    pep.setScale(SLEPc.PEP.Scale.SCALAR)
    pep.setWhichEigenpairs(SLEPc.PEP.Which.TARGET_MAGNITUDE)
    pep.setTarget(shift)
    pep.setDimensions(nev=count)
    pep.setTolerances(tol=tolerance, max_it=1000)
    direct(pep.getST(), "lu")
    pep.solve()
    return pep


class Answer:
    """Pairs on their way into a file, which the first rank writes."""

    MAGIC = b"EIGENT\x01\n"

    def __init__(self, directory, n):
        self.name = os.path.join(directory, "answer.bin")
        self.count = 0
        self.file = None
        if COMM.getRank() == 0:
            self.file = open(self.name + ".part", "wb")
            self.file.write(self.MAGIC)
            self.file.write(numpy.array([n, 0], dtype="<u8").tobytes())

    def add(self, value, real, imaginary):
        """One pair; without an imaginary part where that is None."""
        parts = [real] if imaginary is None else [real, imaginary]
        whole = []
        for part in parts:
            scatter, full = PETSc.Scatter.toZero(part)
            scatter.scatter(part, full, False, PETSc.Scatter.Mode.FORWARD)
            whole.append(numpy.array(full.getArray()))
            scatter.destroy()
            full.destroy()
        self.count += 1
        if self.file is None:
            return
        if imaginary is None and numpy.iscomplexobj(whole[0]):
            whole = [whole[0].real, whole[0].imag]
        self.file.write(numpy.array([len(whole)], dtype="<u8").tobytes())
        self.file.write(numpy.array([value.real, value.imag], dtype="<f8").tobytes())
        for part in whole:
            self.file.write(numpy.ascontiguousarray(part.real, dtype="<f8").tobytes())

    def keep(self):
        if self.file is None:
            return
        self.file.seek(len(self.MAGIC) + 8)
        self.file.write(numpy.array([self.count], dtype="<u8").tobytes())
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        os.replace(self.name + ".part", self.name)


def main(directory):
    with open(os.path.join(directory, "request.json")) as file:
        request = json.load(file)
    is_complex = numpy.issubdtype(PETSc.ScalarType, numpy.complexfloating)
    names = request["matrices"]
    stiffness = load(directory, names["stiffness"])
    mass = load(directory, names["mass"])
    count, tolerance = request["count"], request["tolerance"]
    answer = Answer(directory, mass.getSize()[0])
    if "damping" not in names:
        for matrix in (stiffness, mass):
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            matrix.setOption(PETSc.Mat.Option.HERMITIAN, True)
        target = request["target"]
        if target == 0.0:
            eps = held_apart(mass, stiffness, count, tolerance)
        else:
            eps = undamped(mass, stiffness, target * target, count, tolerance)
            if eps is None:
                eps = undamped(mass, stiffness, target * target * (1.0 + 1e-6), count, tolerance)
        if eps is None:
            say("no factor: K - s M has none near the frequency looked for")
            return 1
        vector = mass.createVecRight()
        for i in range(eps.getConverged()):
            value = eps.getEigenpair(i, vector).real
            root = complex(0.0, value**0.5) if value >= 0.0 else complex((-value) ** 0.5, 0.0)
            answer.add(root, vector, None)
    else:
        damping = load(directory, names["damping"])
        target = request["target"]
        if target == 0.0:
            eps = held_apart(mass, stiffness, count, 1e-4)
            found = [abs(value) for value in squares(eps)] if eps else []
            held = [value for value in found if value > 1e-8 * max(found)]
            shift = 0.1 * min(held) ** 0.5 if held else 1.0
            shifts = [shift]
        else:
            shifts = [target * complex(-1e-3, 1.0), target * complex(-0.7, 0.7), complex(-target, 0.0)]
            shifts = [shift * (1.0 + 1e-4) for shift in shifts]
        for shift in shifts:
            pep = quadratic((mass, damping, stiffness), shift, request["roots"], tolerance)
            real, imaginary = mass.createVecRight(), mass.createVecRight()
            for i in range(pep.getConverged()):
                value = pep.getEigenpair(i, real, imaginary)
                if value.imag >= 0.0 or is_complex:
                    answer.add(value, real, None if is_complex else imaginary)
            pep.destroy()
    answer.keep()
    return 0


try:
    status = main(sys.argv[1])
except OSError as error:
    say("%s: %s; name a directory with more room by --scratch" % (error.filename or "the answer cannot be written", error.strerror))
    status = 1
except Exception as error:
    text = traceback.format_exc().strip().splitlines()
    say("failed: " + " | ".join(line.strip() for line in text[-4:]))
    status = 1
if status != 0:
    # Other ranks may wait for this one: the launcher ends them.
    os._exit(status)
