"""LSODA, of numbalsoda, beside afterbay, with right-hand sides compiled by numba.

Each line of stdin asks for a run: SCENE METHOD TOLERANCE REPEATS SHOW. The answer is, if SHOW is 1,
the line `state Y..` of the end, since the library does not show its steps, then
`done SECONDS STEPS EVALUATIONS Y..` with the least time of the repetitions, or `failed REASON`. Y is
q, then p, then w. The library counts neither steps nor evaluations: both are 0.
"""

import functools
import math
import sys
import time

import numpy as np
from numba import cfunc
from numbalsoda import lsoda, lsoda_sig


def van_der_pol(mu):
    @cfunc(lsoda_sig)
    def rates(t, y, dy, _):
        d = mu * (y[0] * y[0] - 1.0) * y[1]
        dy[0] = y[1]
        dy[1] = -y[0] - d
        dy[2] = d * y[1]

    return rates


@cfunc(lsoda_sig)
def oscillator(t, y, dy, _):
    d = 0.1 * y[1]
    dy[0] = y[1]
    dy[1] = -y[0] - d
    dy[2] = d * y[1]


@cfunc(lsoda_sig)
def duffing(t, y, dy, _):
    d = 0.1 * y[1]
    dy[0] = y[1]
    dy[1] = y[0] - y[0] * y[0] * y[0] - d
    dy[2] = d * y[1]


@cfunc(lsoda_sig)
def pendulum(t, y, dy, _):
    sin, cos = math.sin(y[0] - y[1]), math.cos(y[0] - y[1])
    inverse = 1.0 / (1.0 + sin * sin)
    u, v = (y[2] - cos * y[3]) * inverse, (2.0 * y[3] - cos * y[2]) * inverse
    whirl = sin * u * v
    dy[0] = u
    dy[1] = v
    dy[2] = -whirl - 2.0 * math.sin(y[0]) - 0.1 * u
    dy[3] = whirl - math.sin(y[1]) - 0.1 * v
    dy[4] = 0.1 * u * u
    dy[5] = 0.1 * v * v


def chain(n):
    @cfunc(lsoda_sig)
    def rates(t, y, dy, _):
        left = y[0] + y[0] * y[0] * y[0]
        for j in range(n):
            r = (y[j + 1] if j < n - 1 else 0.0) - y[j]
            right = r + r * r * r
            p = y[n + j]
            dy[j] = p
            dy[n + j] = right - left - 0.01 * p
            dy[2 * n + j] = 0.01 * p * p
            left = right

    start = np.sin(np.pi * np.arange(1, n + 1) / (n + 1))
    return rates, [*start, *np.zeros(2 * n)], 100.0


SCENES = {
    "A": lambda: (oscillator, [2.3, -3.1, 0.0], 100.0),
    "B": lambda: (duffing, [1.5, 0.5, 0.0], 50.0),
    "C1": lambda: (van_der_pol(1.0), [2.0, 0.0, 0.0], 50.0),
    "C2": lambda: (van_der_pol(1000.0), [2.0, 0.0, 0.0], 2000.0),
    "D64": lambda: chain(64),
    "E": lambda: (pendulum, [1.5, -0.5, 0.0, 0.0, 0.0, 0.0], 5.0),
}


@functools.cache
def compiled(scene):
    return SCENES[scene]()


def answer(scene, method, tolerance, repeats, show):
    if method != "lsoda":
        raise ValueError("no such method")
    rates, start, end = compiled(scene)
    address, start, times = rates.address, np.array(start), np.array([0.0, end])
    seconds = float("inf")
    for _ in range(repeats):
        clock = time.perf_counter()
        y, success = lsoda(address, start, times, rtol=tolerance, atol=tolerance, mxstep=100_000_000)
        seconds = min(seconds, time.perf_counter() - clock)
    if not success:
        raise RuntimeError("no success")
    last = [*map(repr, y[-1].tolist())]
    if show:
        print("state", *last)
    print("done", repr(seconds), 0, 0, *last)


for line in sys.stdin:
    scene, method, tolerance, repeats, show = line.split()
    try:
        answer(scene, method, float(tolerance), int(repeats), show == "1")
    except Exception as error:
        print("failed", str(error).replace("\n", " "))
    sys.stdout.flush()
