"""Prints the table quad_functions.csv: functions at points given as two floats, the values as three.

    python3 quad_functions.py > quad_functions.csv

Needs mpmath. The values are computed with 80 digits and split so that the three floats sum to them to more
than 45. Every float is printed so that it reads back exactly.
"""

import random

import mpmath
from mpmath import mpf

mpmath.mp.dps = 80
random.seed(1)


def split(value, parts):
    """The nearest float to the value, then to what is left, and so on."""
    floats = []
    for _ in range(parts):
        floats.append(float(value - mpmath.fsum(map(mpf, floats))))
    return floats


def points(numbers):
    """Each as a float, and again with a low part that no float has."""
    for x in numbers:
        yield (float(x), 0.0)
        yield tuple(split(mpf(float(x)) * (1 + mpf(random.uniform(-1, 1)) * mpf(2) ** -53), 2))


small = [0.0, 1e-30, -3e-20, 1e-9, -2e-5, 0.001, 0.03, -0.1]
moderate = [
    0.3, -0.34657359, 0.3465736, 0.5, -0.69, 0.7853981, -0.7853982, 1.0, -1.0397, 1.04, 1.9, -3.0, 7.0,
]
large = [-12.5, 33.3, 61.7, -70.1, 99.9, -150.0, 250.25, -366.6, 499.0]
angles = [-500.5, 640.0, 999.9, -1000.1, 4321.0, 9999.9, -1e4]
# As floats, and as near to a zero of the sine or cosine as two floats come.
quadrants = [1, -1, 2, 3, -4, 5, 11, -22, 101, 355, -636, 710, 6366]
near = [tuple(split(n * mpmath.pi / 2, parts) + [0.0] * (2 - parts)) for n in quadrants for parts in (1, 2)]
real = list(points(small + moderate + large))
circle = real + list(points(angles)) + near
squares = [0.0, 1e-200, 3e-20, 1e-5, 0.3, 0.99999, 1.0, 1.0011, 1.4, 2.0, 2.1, 3.99, 4.0, 7e10, 1e150]
roots = list(points(squares))
positive = list(points([1e-300, 4e-310, 1e-200, 1e-9, 0.03, 0.5, 0.6, 0.7071, 0.70711, 0.9, 0.999, 1 - 1e-9, 1.0, 1 + 1e-12,
                        1.0001, 1.3, 1.41421, 1.41422, 2.0, 2.8, 3.0, 10.0, 777.7, 1e9, 1e150, 1e300]))
positive = [x for x in positive if x[0] > 1e-280 or x[1] == 0.0]
slopes = real + list(points([1e5, -3e9, 1e16, -1e40, 1e300]))
arcs = list(points(small + [0.2, -0.4, 0.5, -0.7, 0.9, -0.99, 0.999]))

bases = [x for x in real if abs(x[0]) > 1e-4]

print("function,x_hi,x_lo,value_hi,value_mid,value_lo")
for name, function, where in [
    ("sqrt", mpmath.sqrt, roots),
    ("exp", mpmath.exp, real),
    ("exp_m1", mpmath.expm1, real),
    ("sin", mpmath.sin, circle),
    ("cos", mpmath.cos, circle),
    ("ln", mpmath.log, positive),
    ("atan", mpmath.atan, slopes),
    ("tan", mpmath.tan, arcs),
    ("asin", mpmath.asin, arcs),
    ("acos", mpmath.acos, arcs),
    ("sinh", mpmath.sinh, real),
    ("cosh", mpmath.cosh, real),
    ("tanh", mpmath.tanh, real),
    ("powi 13", lambda x: x**13, bases),
    ("powi -6", lambda x: x**-6, bases),
]:
    for x in where:
        assert x[0] + x[1] == x[0]
        value = function(mpf(x[0]) + mpf(x[1]))
        parts = split(value, 3)
        assert abs(value - mpmath.fsum(map(mpf, parts))) <= mpf(10) ** -46 * abs(value), (name, x)
        print(name, *map(repr, [*x, *parts]), sep=",")
