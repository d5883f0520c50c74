"""Prints the table divided.csv: divided differences between two floats, the values as two floats.

    python3 divided.py > divided.csv

Needs mpmath. With widths down to 1e-300 beside arguments of 1000 the quotient of differences needs
more digits than the arguments have, so that it is computed with 700; what is printed has 60 and more.
"""

import random

import mpmath
from mpmath import mpf

mpmath.mp.dps = 700
random.seed(12)

WIDTHS = [0.0, 1e-300, 1e-200, 1e-100, 1e-30, 1e-16, 1e-12, 1e-8, 1e-5, 1e-3, 0.02, 0.1, 0.3, 0.49,
          0.51, 0.9, 1.0, 2.0, 3.3, 7.0, 40.0, 150.0, 1000.0]

FUNCTIONS = {
    "sin": (mpmath.sin, mpmath.cos, -1000, 1000),
    "cos": (mpmath.cos, lambda x: -mpmath.sin(x), -1000, 1000),
    "exp": (mpmath.exp, mpmath.exp, -700, 700),
    "sinh": (mpmath.sinh, mpmath.cosh, -700, 700),
    "cosh": (mpmath.cosh, mpmath.sinh, -700, 700),
    "tanh": (mpmath.tanh, lambda x: mpmath.sech(x) ** 2, -300, 300),
    "ln": (mpmath.log, lambda x: 1 / x, 0, 1000),
    "sqrt": (mpmath.sqrt, lambda x: 1 / (2 * mpmath.sqrt(x)), 0, 1000),
    "atan": (mpmath.atan, lambda x: 1 / (1 + x * x), -1000, 1000),
    "asin": (mpmath.asin, lambda x: 1 / mpmath.sqrt(1 - x * x), -1, 1),
    "acos": (mpmath.acos, lambda x: -1 / mpmath.sqrt(1 - x * x), -1, 1),
    "abs": (abs, mpmath.sign, -1000, 1000),
}

STARTS = [0.0, 1e-300, -1e-300, 1e-160, 1e-20, -1e-9, 1e-4, 0.3, -0.7, 0.999, 1.0, -1.0, 1.5707963,
          2.5, -6.3, 37.7, -88.8, 345.6, -512.3, 699.0, 999.5]


def rows():
    print("function,a,b,high,low")
    for name, (f, slope, least, most) in FUNCTIONS.items():
        seen = set()
        for start in STARTS + [random.uniform(-3, 3) for _ in range(6)]:
            for width in random.sample(WIDTHS, 9) + [0.0]:
                a = float(start)
                b = float(start + random.choice([-1, 1]) * width)
                inside = all(least <= x <= most for x in (a, b))
                # A kink or a pole at an end.
                if name in ("ln", "sqrt") and min(a, b) <= 0:
                    continue
                if name in ("asin", "acos") and max(abs(a), abs(b)) >= 1:
                    continue
                if name == "abs" and a == b == 0:
                    continue
                if not inside or (a, b) in seen:
                    continue
                seen.add((a, b))
                x, y = mpf(a), mpf(b)
                value = slope(x) if a == b else (f(y) - f(x)) / (y - x)
                high = float(value)
                low = float(value - mpf(high))
                # What underflows has no digits to compare.
                if high != 0 and abs(high) < 1e-290:
                    continue
                print(f"{name},{a!r},{b!r},{high!r},{low!r}")


rows()
