"""Prints period, amplitude and nontrivial multiplier of Van der Pol's cycle, for tests/suite/limit_cycle.rs. Needs mpmath.

q' = p, p' = mu (1 - q^2) p - q. The cycle is symmetric, so that half of it leads from (a, 0) to (-a, 0): the secant method finds a.
The product of both multipliers is exp of the integral of the divergence mu (1 - q^2), and the other one is 1. Each step is a
Taylor series with ORDER terms in 40 digits."""

from mpmath import exp, mp, mpf

mp.dps = 40
ORDER, STEP = 40, mpf(1) / 20


def series(mu, q, p):
    """Coefficients of q, p and the divergence in t."""
    qs, ps, squares, divergence = [q], [p], [], []
    for n in range(ORDER):
        squares.append(sum(qs[i] * qs[n - i] for i in range(n + 1)))
        divergence.append(mu * ((1 if n == 0 else 0) - squares[n]))
        ps_next = (sum(divergence[i] * ps[n - i] for i in range(n + 1)) - qs[n]) / (n + 1)
        qs.append(ps[n] / (n + 1))
        ps.append(ps_next)
    return qs, ps, divergence


def at(coefficients, t):
    total = mpf(0)
    for c in reversed(coefficients):
        total = total * t + c
    return total


def half(mu, a):
    """q, the time and the integral of the divergence where p is 0 again after (a, 0)."""
    q, p, time, integral = a, mpf(0), mpf(0), mpf(0)
    while True:
        qs, ps, divergence = series(mu, q, p)
        integrated = [mpf(0)] + [c / (n + 1) for n, c in enumerate(divergence)]
        step, after = STEP, at(ps, STEP)
        ends = time > 0 and after >= 0
        if ends:
            slope = [n * c for n, c in enumerate(ps)][1:]
            step = STEP / 2
            for _ in range(60):
                step -= at(ps, step) / at(slope, step)
        q, p = at(qs, step), at(ps, step)
        time, integral = time + step, integral + at(integrated, step)
        if ends:
            return q, time, integral


def cycle(mu):
    a, b = mpf(2), mpf("2.01")
    off_a, off_b = half(mu, a)[0] + a, half(mu, b)[0] + b
    while abs(off_b) > mpf(10) ** -36 and a != b:
        a, b, off_a = b, b - off_b * (b - a) / (off_b - off_a), off_b
        off_b = half(mu, b)[0] + b
    _, time, integral = half(mu, b)
    return 2 * time, b, exp(2 * integral)


for mu in ["0.05", "1", "2"]:
    names = ["period", "amplitude", "multiplier"]
    print("mu =", mu, *(f"{name} {mp.nstr(x, 20)}" for name, x in zip(names, cycle(mpf(mu)))))
