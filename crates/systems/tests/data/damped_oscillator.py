"""Prints the table damped_oscillator.csv: the exact flow of q' = p, p' = -k q - b p, w' = b p².

    python3 damped_oscillator.py > damped_oscillator.csv

Needs mpmath. A row has k, b, h and the state (q, p), all exact floats, and what the flow over h makes of it: the
increments of q, p, w and the new q, p, each as two floats that sum to it to more than 31 digits. The last columns
are what rounding may be measured against: |M - I| |z| and |M| |z| for z = (q, p) and its matrix M = exp(A h),
|.| taken entry by entry.

Everything comes from the matrix exponential with 120 digits, which knows no regimes; w is H(before) - H(after).
"""

import mpmath
from mpmath import mpf

mpmath.mp.dps = 120


def split(value):
    """The nearest float to the value, then to what is left."""
    high = float(value)
    return high, float(value - mpf(high))


def near_critical(difference):
    """The float b nearest to b²/4 - 1 = difference."""
    return float(2 * mpmath.sqrt(1 + mpf(difference)))


def energy(k, q, p):
    return (p * p + mpf(k) * q * q) / 2


pairs = [
    (1.0, 0.0),
    (1.0, 0.1),
    (1.0, -0.1),
    (1.0, 1e-9),
    (0.3, 0.7),
    (1e4, 3.0),
    (1e-4, 0.019),
    *((1.0, near_critical(sign * 10.0**-digits)) for digits in (3, 9, 15) for sign in (-1, 1)),
    (1.0, 2.0),
    (0.25, -1.0),
    (1.0, 3.0),
    (1.0, -3.0),
    (0.01, 5.0),
    (1.0, 200.0),
    (1.0, -200.0),
]
steps = [1e-6, 0.01, 0.7, 20.0, -1e-6, -0.3, -20.0]
states = [(2.3, -3.1), (1.0, 0.0), (0.1, -20.0)]

names = ["dq", "dp", "dw", "q1", "p1"]
print("k,b,h,q,p", *(f"{name}_{part}" for name in names for part in ("hi", "lo")), sep=",", end="")
print(",size_dq,size_dp,size_q1,size_p1")
for k, b in pairs:
    for h in steps:
        if b * h < -600:
            continue  # grows beyond the largest float
        flow = mpmath.expm(mpmath.matrix([[0, 1], [-mpf(k), -mpf(b)]]) * mpf(h), method="taylor")
        change = flow - mpmath.eye(2)
        for q, p in states:
            z = mpmath.matrix([q, p])
            dq, dp = change * z
            q1, p1 = flow * z
            dw = energy(k, mpf(q), mpf(p)) - energy(k, q1, p1)
            values = [part for value in (dq, dp, dw if b else mpf(0), q1, p1) for part in split(value)]
            sizes = [*(change.apply(abs) * z.apply(abs)), *(flow.apply(abs) * z.apply(abs))]
            print(*map(repr, [k, b, h, q, p, *values, *map(float, sizes)]), sep=",")
