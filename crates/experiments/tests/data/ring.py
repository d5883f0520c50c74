"""Prints the coupling k of a ring of three of Van der Pol's oscillators (mu = 1) at which its common motion loses its stability, for
tests/suite/limit_cycle/branches.rs. Needs scipy.

The two modes of wave number 1 are stretched by 3 k. Both have the multiplier 1 where

    x'' + (q^2 - 1) x' + (1 + 2 q q' + 3 k) x = 0

has it along the cycle q of one oscillator: det(M - 1) = 0 for the matrix M of a period."""

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

# Period and amplitude, by van_der_pol.py.
PERIOD, AMPLITUDE = 6.66328685932313, 2.008619860874843


def slopes(t, z, s):
    q, p, a, b, c, d = z
    force = lambda x, y: -(q * q - 1) * y - (1 + 2 * q * p + s) * x
    return [p, (1 - q * q) * p - q, b, force(a, b), d, force(c, d)]


def determinant(s):
    start = [AMPLITUDE, 0, 1, 0, 0, 1]
    end = solve_ivp(slopes, (0, PERIOD), start, "DOP853", rtol=1e-13, atol=1e-14, args=(s,)).y[:, -1]
    a, b, c, d = end[2:]
    return (a - 1) * (d - 1) - b * c


print(brentq(determinant, 0.35, 0.45, xtol=1e-14) / 3)
