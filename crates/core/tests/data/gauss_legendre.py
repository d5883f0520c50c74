"""Prints the tables of src/numbers/quadrature.rs: nodes 1/2 +- x and weights w of the Gauss-Legendre
rule on [0, 1], each as two doubles that sum to it; then what the values at the nodes are summed with
for the Legendre coefficients of odd and even order n - 1 and n - 2. Needs mpmath."""

from mpmath import cos, findroot, legendre, mp, mpf, pi

mp.dps = 60


def split(value):
    high = float(value)
    return high, float(value - mpf(high))


for n in (8, 16):
    print(f"{n} nodes")
    for i in range(n // 2):
        # Tricomi's bracket around the i-th zero of P_n.
        low, high = cos(pi * (i + 1) / (n + mpf(1) / 2)), cos(pi * (i + mpf(1) / 2) / (n + mpf(1) / 2))
        x = findroot(lambda t: legendre(n, t), (low, high), solver="anderson", tol=1e-100)
        slope = n * (x * legendre(n, x) - legendre(n - 1, x)) / (x * x - 1)
        weight = 2 / ((1 - x * x) * slope * slope)
        tail = [float((2 * k + 1) * weight / 2 * legendre(k, x)) for k in (n - 1, n - 2)]
        print("    [%r, %r, %r, %r, %r, %r]," % (*split(x / 2), *split(weight / 2), *tail))
