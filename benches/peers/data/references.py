"""Checks references.csv with another library, heyoka (Taylor integrators by just-in-time compilation), in 113 bits.

    pip install heyoka numpy
    python3 benches/peers/data/references.py [--rows] [SCENE ...]

The equations of motion are written down here once more: in velocities for the pendulum, with Lagrange's equations solved
for the accelerations, so that neither H nor its derivatives appear. w_j' = D_j v_j is integrated with them, not taken from
the energy. Prints for each scene how far the table is from heyoka's end state, as a part of the largest of |q| and |p|, and of
the largest |w|. With `--rows` it prints heyoka's end states themselves, rounded, as rows of the table: that of C2 is made so.
"""

import csv
import math
import pathlib
import sys

import heyoka as hy
import numpy as np

real = hy.real128
TOLERANCE = 1e-33


def oscillator(force, drag):
    q, p, w = hy.make_vars("q", "p", "w")
    return [(q, p), (p, -force(q) - drag(q, p)), (w, drag(q, p) * p)]


def chain(n, c=0.01):
    q, p, w = ([hy.make_vars(f"{name}{j}") for j in range(n)] for name in "qpw")
    bonds = [b - a for a, b in zip([0.0, *q[:-1]], q)] + [-q[-1]]
    # No powers: heyoka's derivative of one is not finite where a bond is exactly 0, as the middle one is.
    tension = [r + r * r * r for r in bonds]
    rates = [(x, v) for x, v in zip(q, p)]
    rates += [(v, right - left - real(c) * v) for v, left, right in zip(p, tension, tension[1:])]
    return rates + [(e, real(c) * v * v) for e, v in zip(w, p)]


def pendulum(c=0.1):
    """Two unit masses on unit rods, unit gravity. M a = f with M = [2, C; C, 1], C = cos(a - b)."""
    a, b, u, v, w1, w2 = hy.make_vars("a", "b", "u", "v", "w1", "w2")
    c = real(c)
    cos, sin = hy.cos(a - b), hy.sin(a - b)
    f = -sin * v * v - 2.0 * hy.sin(a) - c * u
    g = sin * u * u - hy.sin(b) - c * v
    det = 2.0 - cos * cos
    du, dv = (f - cos * g) / det, (2.0 * g - cos * f) / det
    return [(a, u), (b, v), (u, du), (v, dv), (w1, c * u * u), (w2, c * v * v)]


def momenta(y):
    """q, p, w from q, v, w of the pendulum."""
    a, b, u, v = y[:4]
    cos = np.cos(a - b)
    return np.array([a, b, 2 * u + cos * v, cos * u + v, y[4], y[5]])


def sine(n):
    return [math.sin(math.pi * i / (n + 1)) for i in range(1, n + 1)]


B = real(0.1)
SCENES = {
    "A": (oscillator(lambda q: q, lambda q, p: B * p), [2.3, -3.1, 0.0], 100.0),
    "B": (oscillator(lambda q: q * q * q - q, lambda q, p: B * p), [1.5, 0.5, 0.0], 50.0),
    "C1": (oscillator(lambda q: q, lambda q, p: -(1.0 - q * q) * p), [2.0, 0.0, 0.0], 50.0),
    "C2": (oscillator(lambda q: q, lambda q, p: -1000.0 * (1.0 - q * q) * p), [2.0, 0.0, 0.0], 2000.0),
    "D64": (chain(64), sine(64) + [0.0] * 128, 100.0),
    "D1024": (chain(1024), sine(1024) + [0.0] * 2048, 100.0),
    "E": (pendulum(), [1.5, -0.5, 0.0, 0.0, 0.0, 0.0], 5.0),
}


def table():
    """The end states of references.csv, q, p and w one after the other."""
    with open(pathlib.Path(__file__).with_name("references.csv")) as file:
        rows = list(csv.DictReader(file))
    return {
        name: [real(float(row[x])) for x in "qpw" for row in rows if row["scene"] == name] for name in SCENES
    }


known = table()
for name in [name for name in sys.argv[1:] if name in SCENES] or SCENES:
    equations, start, end = SCENES[name]
    flow = hy.taylor_adaptive(
        equations, [real(x) for x in start], fp_type=real, tol=real(TOLERANCE), compact_mode=len(start) > 12
    )
    outcome, *_ = flow.propagate_until(real(end))
    assert outcome == hy.taylor_outcome.time_limit, (name, outcome)
    found = momenta(flow.state) if name == "E" else flow.state
    if "--rows" in sys.argv:
        dof = len(found) // 3
        for j in range(dof):
            print(name, j, *(repr(float(x)) for x in found[j::dof]), sep=",", flush=True)
        continue
    off = [abs(a - b) for a, b in zip(found, known[name])]
    split = 2 * len(off) // 3
    part = [float(max(off[i:j]) / max(abs(x) for x in found[i:j])) for i, j in ((0, split), (split, len(off)))]
    print(f"{name}: off by {part[0]:.1e} of (q, p) and {part[1]:.1e} of w", flush=True)
