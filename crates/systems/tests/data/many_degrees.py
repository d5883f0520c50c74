"""Prints the table many_degrees.csv: end states of the systems with many degrees of freedom.

    python3 many_degrees.py > many_degrees.csv

Needs mpmath, takes minutes. A row has the system, the time, the
degree of freedom from 0, and q, p, w of it, each as two floats that sum to it to more than 30 digits. The rows of
t = 0 are the initial state, exact floats, like every parameter below.

mpmath's odefun, a Taylor method of its own choice of degree and step, integrates with 36 digits and again with 44;
the rows are printed if the two agree to 1e-31. What is integrated are the equations of motion in velocities, for the
pendulum those of Lagrange with the mass matrix solved numerically: neither H nor its derivatives appear, and the
momenta are made of the velocities at the end. w_j' = D_j v_j is integrated with them, not taken from the energy.
"""

import sys

import mpmath
from mpmath import mpf


def fput_chain(beta, c):
    """q_i'' = f(q_{i+1} - q_i) - f(q_i - q_{i-1}) - c v_i with f(r) = r + beta r^3 and fixed ends."""

    def acceleration(q, v):
        ends = [mpf(0), *q, mpf(0)]
        bonds = [b - a for a, b in zip(ends, ends[1:])]
        tension = [r + beta * r**3 for r in bonds]
        drag = [c * x for x in v]
        return [t1 - t0 - d for t0, t1, d in zip(tension, tension[1:], drag)], drag

    return acceleration


def van_der_pol_ring(mu, coupling):
    """q_i'' = -q_i + coupling (q_{i+1} - 2 q_i + q_{i-1}) + mu (1 - q_i^2) v_i, indices around the ring."""

    def acceleration(q, v):
        n = len(q)
        drag = [-mu * (1 - x**2) * y for x, y in zip(q, v)]
        bend = [q[(i + 1) % n] - 2 * q[i] + q[i - 1] for i in range(n)]
        return [coupling * b - x - d for b, x, d in zip(bend, q, drag)], drag

    return acceleration


def mass_matrix(q, m1=1, m2=1, l1=1, l2=1):
    off = m2 * l1 * l2 * mpmath.cos(q[0] - q[1])
    return mpmath.matrix([[(m1 + m2) * l1**2, off], [off, m2 * l2**2]])


def damped_double_pendulum(g, c1, c2, m1=1, m2=1, l1=1, l2=1):
    """Lagrange's equations of two point masses on rods, angles from the downward vertical, torques -c_j v_j."""

    def acceleration(q, v):
        drag = [c1 * v[0], c2 * v[1]]
        whirl = m2 * l1 * l2 * mpmath.sin(q[0] - q[1])
        torque = [
            -whirl * v[1] ** 2 - (m1 + m2) * g * l1 * mpmath.sin(q[0]) - drag[0],
            whirl * v[0] ** 2 - m2 * g * l2 * mpmath.sin(q[1]) - drag[1],
        ]
        return list(mpmath.lu_solve(mass_matrix(q), torque)), drag

    return acceleration


def end_states(acceleration, mass, q, p, times, digits):
    """(q, p, w) at the times, computed with so many digits."""
    mpmath.mp.dps = digits
    n = len(q)
    q, p = [mpf(x) for x in q], [mpf(x) for x in p]
    v = list(mpmath.lu_solve(mass(q), p)) if mass else p

    def field(_, y):
        q, v = y[:n], y[n : 2 * n]
        a, drag = acceleration(q, v)
        return [*v, *a, *(d * x for d, x in zip(drag, v))]

    flow = mpmath.odefun(field, 0, [*q, *v, *([mpf(0)] * n)])
    states = []
    for t in times:
        y = flow(t)
        q, v, w = y[:n], y[n : 2 * n], y[2 * n :]
        states.append((q, list(mass(q) * mpmath.matrix(v)) if mass else v, w))
    return states


def split(value):
    """The nearest float to the value, then to what is left."""
    high = float(value)
    return repr(high), repr(float(value - mpf(high)))


def scenes():
    """Parameters go through mpf, so that 0.05 is the float and not the fraction."""
    eight = [float(mpmath.sin(mpmath.pi * i / 9)) for i in range(1, 9)]
    yield "fput-chain", fput_chain(mpf(1.0), mpf(0.05)), None, eight, [0.0] * 8, [5, 20]
    ring_q, ring_p = [1.1, -0.4, 0.25, 0.9, -1.6], [0.3, 0.8, -1.2, 0.05, 0.6]
    yield "van-der-pol-ring", van_der_pol_ring(mpf(1.0), mpf(0.3)), None, ring_q, ring_p, [5, 10]
    pendulum = damped_double_pendulum(mpf(9.81), mpf(0.1), mpf(0.2))
    yield "damped-double-pendulum", pendulum, mass_matrix, [1.2, -0.7], [0.3, 0.5], [2, 5]


print("system,t,dof,q_hi,q_lo,p_hi,p_lo,w_hi,w_lo")
for name, acceleration, mass, q, p, times in scenes():
    coarse = end_states(acceleration, mass, q, p, times, 36)
    fine = end_states(acceleration, mass, q, p, times, 44)
    pairs = [(x, y) for a, b in zip(coarse, fine) for s, r in zip(a, b) for x, y in zip(s, r)]
    worst = max(abs(x - y) for x, y in pairs)
    print(f"{name}: 36 and 44 digits agree to {mpmath.nstr(worst, 2)}", file=sys.stderr, flush=True)
    assert worst < mpf(10) ** -31, name
    start = ([mpf(x) for x in q], [mpf(x) for x in p], [mpf(0)] * len(q))
    for t, (q, p, w) in zip([0, *times], [start, *fine]):
        for j in range(len(q)):
            print(name, t, j, *split(q[j]), *split(p[j]), *split(w[j]), sep=",", flush=True)
