"""Writes truth.txt: discrete forms and process noise of the systems in main.rs, by exponentials with 120 digits and,
for the noise, the exponential of Van Loan with as many digits as it loses. Needs mpmath."""

from mpmath import mp, mpf, matrix, eye, expm, zeros

mp.dps = 120


def discrete(a, b, c, d, h):
    n, m = a.rows, b.cols
    w = zeros(n + 2 * m)
    w[:n, :n] = a * h
    w[:n, n:n + m] = b * h
    w[n:n + m, n + m:] = eye(m)
    e = expm(w, method="taylor")
    ad, g1, g2 = e[:n, :n], e[:n, n:n + m], e[:n, n + m:]
    return {"A": ad, "B": g1, "BF": g1 - g2 + ad * g2, "DF": d + c * g2}


def noise(a, b, w, h):
    n = a.rows
    v = zeros(2 * n)
    v[:n, :n] = -a * h
    v[:n, n:] = b * w * b.T * h
    v[n:, n:] = a.T * h
    e = expm(v, method="taylor")
    return e[n:, n:].T * e[:n, n:]


def full(m, c, k):
    n = m.rows
    a = zeros(2 * n)
    for i in range(n):
        a[i, n + i] = 1
    a[n:, :n] = -(m ** -1) * k
    a[n:, n:] = -(m ** -1) * c
    return a


def rows(name, what, x):
    for i in range(x.rows):
        for j in range(x.cols):
            print(name, what, i, j, mp.nstr(x[i, j], 40))


def case(name, a, b, c, d, h, w):
    for what, x in discrete(a, b, c, d, h).items():
        rows(name, what, x)
    rows(name, "Q", noise(a, b, w, h))


h = mpf(0.01)
a = full(matrix([[2]]), matrix([[1]]), matrix([[8]]))
case("oscillator", a, matrix([[0], [mpf(1) / 2]]), matrix([[1, 0]]), matrix([[0]]), h, matrix([[3]]))

# Body and wheel on a tyre with a damper: the state of the wheel is v − (50/59) u.
m = matrix([[290, 0], [0, 59]])
c = matrix([[1000, -1000], [-1000, 1050]])
k = matrix([[16812, -16812], [-16812, 16812 + 190000]])
a = full(m, c, k)
p = matrix([0, 0, 0, mpf(50) / 59])
b = zeros(4, 2)
b[3, 0] = mpf(190000) / 59
b[:, 0] = b[:, 0] + a * p
b[2, 1] = mpf(1) / 290
out = zeros(3, 4)
out[0, :] = a[2, :]
out[1, 0], out[1, 1] = 1, -1
out[2, 1] = 190000
d = zeros(3, 2)
d[0, 0], d[0, 1] = a[2, 3] * p[3], mpf(1) / 290
d[2, 0] = -190000
case("car", a, b, out, d, mpf(0.05), matrix([[mpf(0.5), mpf(0.25)], [mpf(0.25), 2]]))

# λh = −1e6 beside −1e-6.
a = full(matrix([[1]]), matrix([[mpf(10) ** 6]]), matrix([[1]]))
b = matrix([[0], [1]])
cd = (matrix([[1, 0]]), matrix([[0]]))
e = discrete(a, b, *cd, mpf(1))
for what, x in e.items():
    rows("slow", what, x)
# Steady covariance less what is carried on: P = diag(1/2ck, 1/2cm).
steady = matrix([[mpf(1) / (2 * 10 ** 6), 0], [0, mpf(1) / (2 * 10 ** 6)]])
rows("slow", "Q", steady - e["A"] * steady * e["A"].T)

# A mass on a dashpot and a spring in line, the node between them without mass.
a = matrix([[0, 1, 0], [0, 0, mpf(-3)], [0, 1, mpf(-3) / mpf(0.5)]])
a[1, 2] = mpf(-3)
b = matrix([[0, 0], [1, 1], [0, 1 / mpf(0.5)]])
case("maxwell", a, b, matrix([[0, 0, 1]]), zeros(1, 2), mpf(0.25), eye(2))

# Two storeys on a soil that is moved by its acceleration.
m = matrix([[2, 0], [0, 1]])
c = matrix([[3, -1], [-1, 1]])
k = matrix([[500, -200], [-200, 200]])
a = zeros(6)
a[:4, :4] = full(m, c, k)
a[2, 4], a[2, 5] = mpf(300) / 2, mpf(2) / 2
a[4, 5] = 1
b = matrix([0, 0, 0, 0, 0, 1])
out = zeros(2, 6)
out[0, :] = a[3, :]
out[1, 0], out[1, 4] = 1, -1
case("quake", a, b, out, zeros(2, 1), mpf(0.02), matrix([[1]]))

# Frequencies from 1 to 1e6, undamped, a long step.
m = eye(2)
k = matrix([[1 + mpf(10) ** 12, -mpf(10) ** 12], [-mpf(10) ** 12, mpf(10) ** 12]])
a = full(m, zeros(2), k)
b = matrix([[0], [0], [0], [1]])
case("stiff", a, b, matrix([[1, 0, 0, 0]]), matrix([[0]]), mpf(7), matrix([[1]]))


def stationary(a, b, w):
    """A P + P Aᵀ = −B W Bᵀ as one linear system."""
    n = a.rows
    big, right = zeros(n * n), zeros(n * n, 1)
    rate = b * w * b.T
    for i in range(n):
        for j in range(n):
            for k in range(n):
                big[i * n + j, k * n + j] += a[i, k]
                big[i * n + j, i * n + k] += a[j, k]
            right[i * n + j] = -rate[i, j]
    p = mp.lu_solve(big, right)
    return matrix([[p[i * n + j] for j in range(n)] for i in range(n)])


# A car of which only the body is pushed, and masses with frequencies 1e6 apart that hardly anything damps.
m = matrix([[290, 0], [0, 59]])
c = matrix([[1000, -1000], [-1000, 1050]])
k = matrix([[16812, -16812], [-16812, 16812 + 190000]])
rows("pushed", "P", stationary(full(m, c, k), matrix([0, 0, mpf(1) / 290, 0]), matrix([[2]])))
c = matrix([[mpf(1e-9), 0], [0, 0]])
k = matrix([[1 + mpf(10) ** 12, -mpf(10) ** 12], [-mpf(10) ** 12, mpf(10) ** 12]])
rows("faint", "P", stationary(full(eye(2), c, k), matrix([0, 0, 0, 1]), matrix([[1]])))
