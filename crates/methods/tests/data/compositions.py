"""Prints the tables of src/increment/composition.rs, each coefficient as two doubles that sum to it. Needs mpmath.

Suzuki 1990 (order 4) in closed form. Order 6: McLachlan 1995, nine stages; Yoshida 1990, seven. Order 8: Kahan and Li
1997, seventeen stages. As collected in Hairer, Lubich, Wanner, Geometric Numerical Integration, section V.3.2. The outer
coefficients are printed to twenty digits there; the middle one makes the sum 1. Blanes and Moan 2002 (S6 and S10) are
splittings A B A ..; alternating sweeps of half the total length follow from them (McLachlan 1995)."""

from mpmath import mp, mpf

mp.dps = 60


def split(value):
    high = float(value)
    return high, float(value - mpf(high))


def show(name, values):
    print(name)
    for value in values:
        print("    [%r, %r]," % split(value))


def symmetric(outer):
    return [*outer, 1 - 2 * sum(outer), *reversed(outer)]


def alternating(a, b):
    """Fractions of sweeps from the coefficients of a symmetric splitting A a1, B b1, A a2 ..; all of them."""
    steps = [x for pair in zip(a, b) for x in pair] + [a[-1]]
    fractions = [steps[0]]
    for step in steps[1:-1]:
        fractions.append(step - fractions[-1])
    return fractions


if __name__ == "__main__":
    first = 1 / (4 - mpf(4) ** (mpf(1) / 3))
    show("SUZUKI", symmetric([first, first]))
    show("YOSHIDA_6", symmetric([mpf(x) for x in ("0.78451361047755726382", "0.23557321335935813368", "-1.17767998417887100695")]))
    show("MCLACHLAN_6", symmetric([mpf(x) for x in ("0.39216144400731413928", "0.33259913678935943860", "-0.70624617255763935981", "0.08221359629355080023")]))
    show("KAHAN_LI_8", symmetric([mpf(x) for x in ("0.13020248308889008088", "0.56116298177510838456", "-0.38947496264484728641", "0.15884190655515560090", "-0.39590389413323757734", "0.18453964097831570709", "0.25837438768632204729", "0.29501172360931029887")]))
    a = [mpf(x) for x in ("0.0792036964311957", "0.353172906049774", "-0.0420650803577195")]
    b = [mpf(x) for x in ("0.209515106613362", "-0.143851773179818")]
    a = symmetric(a)
    b = [*b, mpf(1) / 2 - sum(b)]
    show("BLANES_MOAN_4", alternating(a, [*b, *reversed(b)]))
    a = [mpf(x) for x in ("0.0502627644003922", "0.413514300428344", "0.0450798897943977", "-0.188054853819569", "0.541960678450780")]
    b = [mpf(x) for x in ("0.148816447901042", "-0.132385865767784", "0.067307604692185", "0.432666402578175")]
    a = symmetric(a)
    b = [*b, mpf(1) / 2 - sum(b)]
    show("BLANES_MOAN_6", alternating(a, [*b, *reversed(b)]))
