"""heyoka beside afterbay: its Taylor integrator, compiled at run time.

Each line of stdin asks for a run: SCENE METHOD TOLERANCE REPEATS SHOW. The answer is, if SHOW is 1,
a line `state Y..` after each step, then `done SECONDS STEPS EVALUATIONS Y..` with the least time of
the repetitions, or `failed REASON`. Y is q, then p, then w. A Taylor step evaluates no right-hand
side, so EVALUATIONS is 0.
"""

import functools
import sys
import time

import heyoka as hy
import numpy as np


def one(force, dissipation, q, p, end):
    """q' = p, p' = force - D, w' = D p."""
    x, y, w = hy.make_vars("q", "p", "w")
    d = dissipation(x, y)
    return [(x, y), (y, force(x) - d), (w, d * y)], [q, p, 0.0], end


def van_der_pol(mu, end):
    return one(lambda q: -q, lambda q, p: mu * (q * q - 1.0) * p, 2.0, 0.0, end)


def chain(n):
    """FPUT-beta chain between walls."""
    q, p, w = ([hy.make_vars(f"{name}{j}") for j in range(n)] for name in "qpw")
    ends = [0.0, *q, 0.0]
    stretch = [right - left for left, right in zip(ends, ends[1:])]
    tension = [r + r * r * r for r in stretch]
    start = np.sin(np.pi * np.arange(1, n + 1) / (n + 1))
    equations = (
        list(zip(q, p))
        + [(p[j], tension[j + 1] - tension[j] - 0.01 * p[j]) for j in range(n)]
        + [(w[j], 0.01 * (p[j] * p[j])) for j in range(n)]
    )
    return equations, [*start, *np.zeros(2 * n)], 100.0


def pendulum():
    """Two unit rods with unit masses, g = 1 and friction 0.1 in both joints."""
    a, b, p, r, wa, wb = hy.make_vars("a", "b", "p", "r", "wa", "wb")
    sin, cos = hy.sin(a - b), hy.cos(a - b)
    inverse = 1.0 / (1.0 + sin * sin)
    u, v = (p - cos * r) * inverse, (2.0 * r - cos * p) * inverse
    whirl = sin * u * v
    equations = [
        (a, u),
        (b, v),
        (p, -whirl - 2.0 * hy.sin(a) - 0.1 * u),
        (r, whirl - hy.sin(b) - 0.1 * v),
        (wa, 0.1 * (u * u)),
        (wb, 0.1 * (v * v)),
    ]
    return equations, [1.5, -0.5, 0.0, 0.0, 0.0, 0.0], 5.0


SCENES = {
    "A": lambda: one(lambda q: -q, lambda q, p: 0.1 * p, 2.3, -3.1, 100.0),
    "B": lambda: one(lambda q: q - q * q * q, lambda q, p: 0.1 * p, 1.5, 0.5, 50.0),
    "C1": lambda: van_der_pol(1.0, 50.0),
    "C2": lambda: van_der_pol(1000.0, 2000.0),
    "D64": lambda: chain(64),
    "D1024": lambda: chain(1024),
    "E": pendulum,
}


@functools.lru_cache(maxsize=16)
def compiled(scene, tolerance):
    equations, start, end = SCENES[scene]()
    # Without its compact mode the code of a long chain takes minutes to compile.
    compact = len(start) > 300
    return hy.taylor_adaptive(equations, list(start), tol=tolerance, compact_mode=compact), start, end


def answer(scene, method, tolerance, repeats, show):
    if method != "taylor":
        raise ValueError("no such method")
    integrator, start, end = compiled(scene, tolerance)
    seconds = float("inf")
    for _ in range(repeats):
        integrator.time = 0.0
        integrator.state[:] = start
        clock = time.perf_counter()
        outcome = integrator.propagate_until(end)
        seconds = min(seconds, time.perf_counter() - clock)
    if outcome[0] != hy.taylor_outcome.time_limit:
        raise RuntimeError(str(outcome[0]))
    last = integrator.state.copy()
    if show:
        integrator.time = 0.0
        integrator.state[:] = start

        def see(taylor):
            print("state", *map(repr, taylor.state.tolist()))
            return True

        integrator.propagate_until(end, callback=see)
    print("done", repr(seconds), outcome[3], 0, *map(repr, last.tolist()))


for line in sys.stdin:
    scene, method, tolerance, repeats, show = line.split()
    try:
        answer(scene, method, float(tolerance), int(repeats), show == "1")
    except Exception as error:
        print("failed", str(error).replace("\n", " "))
    sys.stdout.flush()
