"""Prints the table slopes.csv: random expressions V of q1 and q2, edges of q1 between two floats, the
divided difference [V(b) - V(a)]/(b - a), and the sum of the magnitudes of the terms it is made of.

    python3 slopes.py > slopes.csv

Needs mpmath. Values are computed with 700 digits, as an edge may be 1e-300 wide. The sum of magnitudes
is what an evaluation by the rules of slope arithmetic may be off by, in roundings, to first order: each
operation adds the size of its result, and passes on what its operands are off by.
"""

import random

import mpmath
from mpmath import mpf

mpmath.mp.dps = 700
random.seed(2025)

Q2 = mpf(0.75)
ZERO, ONE = mpf(0), mpf(1)

FUNCTIONS = {
    "sin": (mpmath.sin, mpmath.cos, lambda x: -mpmath.sin(x)),
    "cos": (mpmath.cos, lambda x: -mpmath.sin(x), lambda x: -mpmath.cos(x)),
    "tan": (mpmath.tan, lambda x: mpmath.sec(x) ** 2, lambda x: 2 * mpmath.tan(x) * mpmath.sec(x) ** 2),
    "exp": (mpmath.exp, mpmath.exp, mpmath.exp),
    "log": (mpmath.log, lambda x: 1 / x, lambda x: -1 / x**2),
    "sqrt": (mpmath.sqrt, lambda x: 1 / (2 * mpmath.sqrt(x)), lambda x: -1 / (4 * x * mpmath.sqrt(x))),
    "sinh": (mpmath.sinh, mpmath.cosh, mpmath.sinh),
    "cosh": (mpmath.cosh, mpmath.sinh, mpmath.cosh),
    "tanh": (mpmath.tanh, lambda x: mpmath.sech(x) ** 2, lambda x: -2 * mpmath.tanh(x) * mpmath.sech(x) ** 2),
    "asin": (mpmath.asin, lambda x: 1 / mpmath.sqrt(1 - x * x), lambda x: x / (1 - x * x) ** mpf(1.5)),
    "acos": (mpmath.acos, lambda x: -1 / mpmath.sqrt(1 - x * x), lambda x: -x / (1 - x * x) ** mpf(1.5)),
    "atan": (mpmath.atan, lambda x: 1 / (1 + x * x), lambda x: -2 * x / (1 + x * x) ** 2),
    "abs": (abs, mpmath.sign, lambda x: ZERO),
}


class Undefined(Exception):
    pass


class Edge:
    """Values at the ends, the divided difference, and the magnitudes of each."""

    def __init__(self, a, b, s, ea=ZERO, eb=ZERO, es=ZERO):
        self.a, self.b, self.s, self.ea, self.eb, self.es = a, b, s, ea, eb, es
        if max(abs(a), abs(b), abs(s)) > mpf(10) ** 40:
            raise Undefined

    def add(self, other, sign):
        a, b, s = self.a + sign * other.a, self.b + sign * other.b, self.s + sign * other.s
        return Edge(a, b, s, self.ea + other.ea + abs(a), self.eb + other.eb + abs(b), self.es + other.es + abs(s))

    def mul(self, other):
        (a, b), (c, d) = (self.a, self.b), (other.a, other.b)
        mean, mean_off = (a + b) / 2, (self.ea + self.eb + abs(a) + abs(b)) / 2
        other_mean, other_off = (c + d) / 2, (other.ea + other.eb + abs(c) + abs(d)) / 2
        s = mean * other.s + other_mean * self.s
        es = abs(mean) * other.es + mean_off * abs(other.s) + abs(other_mean) * self.es + other_off * abs(self.s)
        es += abs(mean * other.s) + abs(other_mean * self.s) + abs(s)
        return Edge(a * c, b * d, s, abs(a) * other.ea + abs(c) * self.ea + abs(a * c),
                    abs(b) * other.eb + abs(d) * self.eb + abs(b * d), es)

    def div(self, other):
        (a, b), (c, d) = (self.a, self.b), (other.a, other.b)
        if c * d <= 0 or min(abs(c), abs(d)) < mpf(10) ** -30:
            raise Undefined
        ea = (self.ea + abs(a / c) * other.ea) / abs(c) + abs(a / c)
        eb = (self.eb + abs(b / d) * other.eb) / abs(d) + abs(b / d)
        top = self.s - a / c * other.s
        s = top / d
        es = (self.es + abs(a / c) * other.es + ea * abs(other.s) + abs(a / c * other.s) + abs(top)) / abs(d)
        es += abs(s) * (other.eb / abs(d) + 1)
        return Edge(a / c, b / d, s, ea, eb, es)

    def under(self, name):
        f, first, second = FUNCTIONS[name]
        a, b = self.a, self.b
        low, high = min(a, b), max(a, b)
        if name in ("log", "sqrt") and low <= 0 or name in ("asin", "acos") and max(abs(a), abs(b)) >= 1:
            raise Undefined
        if name == "abs" and a == b == 0:
            raise Undefined
        if name == "tan" and mpmath.floor(low / mpmath.pi + 0.5) != mpmath.floor(high / mpmath.pi + 0.5):
            raise Undefined
        if max(abs(a), abs(b)) > 80 and name in ("exp", "sinh", "cosh") or max(abs(a), abs(b)) > 10**6:
            raise Undefined
        ends = f(a), f(b)
        if a == b:
            divided, by_a, by_b = first(a), second(a) / 2, second(a) / 2
        else:
            divided = (ends[1] - ends[0]) / (b - a)
            by_a, by_b = (divided - first(a)) / (b - a), (first(b) - divided) / (b - a)
        off = abs(by_a) * self.ea + abs(by_b) * self.eb + 6 * abs(divided)
        if name in ("tan",):
            # As the quotient of sine and cosine.
            off += 6 * abs(divided) + 6 * (1 + abs(ends[0])) * abs(mpmath.sec(b))
        s = divided * self.s
        return Edge(*ends, s, abs(first(a)) * self.ea + 3 * abs(ends[0]), abs(first(b)) * self.eb + 3 * abs(ends[1]),
                    off * abs(self.s) + abs(divided) * self.es + abs(s))

    def power(self, n):
        if n == 0:
            return Edge(ONE, ONE, ZERO)
        if n < 0 and self.a * self.b <= 0:
            raise Undefined
        result = self
        for _ in range(abs(n) - 1):
            result = result.mul(self)
        return Edge(ONE, ONE, ZERO).div(result) if n < 0 else result


def tree(depth):
    kind = random.random()
    if depth == 0 or kind < 0.12:
        number = random.choice([0.5, 1.0, 2.0, 3.0, round(random.uniform(0.1, 3), 3)])
        leaf = random.choice(["q1"] * 5 + ["q2", number])
        return leaf
    if kind < 0.55:
        return (random.choice("++--**/"), tree(depth - 1), tree(depth - 1))
    if kind < 0.65:
        return ("^", tree(depth - 1), random.choice([-3, -2, -1, 2, 3, 4, 5]))
    if kind < 0.72:
        return ("real", tree(depth - 1), random.choice([0.5, 1.5, -0.5, 2.5, 1.3, -0.7]))
    return (random.choice(list(FUNCTIONS)), tree(depth - 1))


def text(x):
    match x:
        case str():
            return x
        case float():
            return repr(x)
        case ("real", y, n) | ("^", y, n):
            return f"({text(y)})^({n})"
        case (op, y, z):
            return f"({text(y)} {op} {text(z)})"
        case (name, y):
            return f"{name}({text(y)})"


def edge(x, a, b):
    match x:
        case "q1":
            return Edge(mpf(a), mpf(b), ONE)
        case "q2":
            return Edge(Q2, Q2, ZERO)
        case float():
            return Edge(mpf(x), mpf(x), ZERO)
        case ("^", y, n):
            return edge(y, a, b).power(n)
        case ("real", y, n):
            y, exact = edge(y, a, b), mpf(n)
            if (2 * n) % 1 == 0:
                whole, root = y.power(int(abs(n) - 0.5)), y.under("sqrt")
                power = whole.mul(root)
                return Edge(ONE, ONE, ZERO).div(power) if n < 0 else power
            logarithm = y.under("log").mul(Edge(exact, exact, ZERO))
            return logarithm.under("exp")
        case (op, y, z):
            y, z = edge(y, a, b), edge(z, a, b)
            return {"+": lambda: y.add(z, 1), "-": lambda: y.add(z, -1), "*": lambda: y.mul(z), "/": lambda: y.div(z)}[op]()
        case (name, y):
            return edge(y, a, b).under(name)


def rows(count):
    print("a,b,slope,magnitude,potential")
    while count > 0:
        x = tree(random.choice([1, 2, 3, 4]))
        if "q1" not in text(x):
            continue
        scale = random.choice([0.3, 1, 1, 2, 5, 30])
        a = float(random.uniform(-1, 1) * scale)
        width = random.choice([0, 1e-300, 1e-100, 1e-20, 1e-13, 1e-9, 1e-6, 1e-3, 0.03, 0.3, 1, 3, 20, 300, 1000])
        if 0 < width < 1e-17:
            a = random.choice([0.0, width, -3 * width, 1e3 * width])
        b = float(a + random.choice([-1, 1]) * width)
        try:
            found = edge(x, a, b)
        except (Undefined, ZeroDivisionError, ValueError):
            continue
        if not isinstance(found.s, mpmath.mpf) or found.s == 0 or abs(found.s) < 1e-250:
            continue
        # What cancels to nothing is no slope to compare.
        if found.es > mpf(10) ** 6 * abs(found.s) or found.es > mpf(10) ** 30:
            continue
        print(f"{a!r},{b!r},{float(found.s)!r},{float(found.es + abs(found.s))!r},{text(x)}")
        count -= 1


rows(900)
