"""Prints the rows of src/relaxed/tableau.rs for DOP853, each coefficient as two doubles that sum to it. Needs mpmath.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, second edition, section II.5: the twelve stages of order 8.
As published the coefficients have up to thirty digits, and miss the 200 order conditions by what is printed first. Newton's
method on those conditions, with the shortest correction (there are more coefficients than independent conditions), takes the
miss below 1e-50."""

from math import prod

from mpmath import eye, lu_solve, matrix, mp, mpf, norm

mp.dps = 90

A = {
    2: {1: "5.26001519587677318785587544488e-2"},
    3: {1: "1.97250569845378994544595329183e-2", 2: "5.91751709536136983633785987549e-2"},
    4: {1: "2.95875854768068491816892993775e-2", 3: "8.87627564304205475450678981324e-2"},
    5: {
        1: "2.41365134159266685502369798665e-1",
        3: "-8.84549479328286085344864962717e-1",
        4: "9.24834003261792003115737966543e-1",
    },
    6: {
        1: "3.7037037037037037037037037037e-2",
        4: "1.70828608729473871279604482173e-1",
        5: "1.25467687566822425016691814123e-1",
    },
    7: {
        1: "3.7109375e-2",
        4: "1.70252211019544039314978060272e-1",
        5: "6.02165389804559606850219397283e-2",
        6: "-1.7578125e-2",
    },
    8: {
        1: "3.70920001185047927108779319836e-2",
        4: "1.70383925712239993810214054705e-1",
        5: "1.07262030446373284651809199168e-1",
        6: "-1.53194377486244017527936158236e-2",
        7: "8.27378916381402288758473766002e-3",
    },
    9: {
        1: "6.24110958716075717114429577812e-1",
        4: "-3.36089262944694129406857109825",
        5: "-8.68219346841726006818189891453e-1",
        6: "2.75920996994467083049415600797e1",
        7: "2.01540675504778934086186788979e1",
        8: "-4.34898841810699588477366255144e1",
    },
    10: {
        1: "4.77662536438264365890433908527e-1",
        4: "-2.48811461997166764192642586468",
        5: "-5.90290826836842996371446475743e-1",
        6: "2.12300514481811942347288949897e1",
        7: "1.52792336328824235832596922938e1",
        8: "-3.32882109689848629194453265587e1",
        9: "-2.03312017085086261358222928593e-2",
    },
    11: {
        1: "-9.3714243008598732571704021658e-1",
        4: "5.18637242884406370830023853209",
        5: "1.09143734899672957818500254654",
        6: "-8.14978701074692612513997267357",
        7: "-1.85200656599969598641566180701e1",
        8: "2.27394870993505042818970056734e1",
        9: "2.49360555267965238987089396762",
        10: "-3.0467644718982195003823669022",
    },
    12: {
        1: "2.27331014751653820792359768449",
        4: "-1.05344954667372501984066689879e1",
        5: "-2.00087205822486249909675718444",
        6: "-1.79589318631187989172765950534e1",
        7: "2.79488845294199600508499808837e1",
        8: "-2.85899827713502369474065508674",
        9: "-8.87285693353062954433549289258",
        10: "1.23605671757943030647266201528e1",
        11: "6.43392746015763530355970484046e-1",
    },
}
B = {
    1: "5.42937341165687622380535766363e-2",
    6: "4.45031289275240888144113950566",
    7: "1.89151789931450038304281599044",
    8: "-5.8012039600105847814672114227",
    9: "3.1116436695781989440891606237e-1",
    10: "-1.52160949662516078556178806805e-1",
    11: "2.01365400804030348374776537501e-1",
    12: "4.47106157277725905176885569043e-2",
}
STAGES = 12
# The coefficients that are not zero, row by row, the weights as row 13.
PLACES = [(i, j) for i in A for j in A[i]] + [(STAGES + 1, j) for j in B]


def trees(order):
    """Rooted trees by order, each as the sorted tuple of its branches."""
    by_order = {1: [()]}
    for n in range(2, order + 1):
        found = set()
        for first in range(1, n):
            for branch in by_order[first]:
                if first == n - 1:
                    found.add((branch,))
                else:
                    for rest in by_order[n - first]:
                        found.add(tuple(sorted((branch, *rest))))
        by_order[n] = sorted(found)
    return [tree for n in by_order for tree in by_order[n]]


def size(tree):
    return 1 + sum(size(branch) for branch in tree)


def density(tree):
    return size(tree) * prod(density(branch) for branch in tree)


TREES = trees(8)


def misses(x):
    """Sum_i b_i Phi_i - 1/gamma of every tree."""
    rows = {i: [] for i in range(1, STAGES + 2)}
    for (i, j), value in zip(PLACES, x):
        rows[i].append((j, value))
    known = {}

    def below(tree):
        """Sum_j a_ij Phi_j for each i, and the sum with b_j."""
        if tree not in known:
            branches = [below(branch) for branch in tree]
            phi = [prod((branch[i] for branch in branches), start=mpf(1)) for i in range(1, STAGES + 1)]
            known[tree] = [0] + [sum((a * phi[j - 1] for j, a in rows[i]), mpf(0)) for i in range(1, STAGES + 2)]
        return known[tree]

    return matrix([below(tree)[STAGES + 1] - mpf(1) / density(tree) for tree in TREES])


def split(value):
    high = float(value)
    return high, float(value - mpf(high))


if __name__ == "__main__":
    x = [mpf((A.get(i) or B)[j]) for i, j in PLACES]
    assert len(TREES) == 200
    for _ in range(3):
        miss = misses(x)
        print("# the order conditions are missed by %s" % mp.nstr(norm(miss, mp.inf), 3))
        step = mpf(10) ** -45
        columns = []
        for k in range(len(x)):
            moved = [value + step if i == k else value for i, value in enumerate(x)]
            columns.append((misses(moved) - miss) / step)
        slopes = matrix(len(TREES), len(x))
        for k, column in enumerate(columns):
            for row in range(len(TREES)):
                slopes[row, k] = column[row]
        normal = slopes.T * slopes + mpf(10) ** -36 * eye(len(x))
        change = lu_solve(normal, -(slopes.T * miss))
        print("# and the coefficients moved by up to %s" % mp.nstr(norm(change, mp.inf), 3))
        x = [value + change[k] for k, value in enumerate(x)]
    print("# in the end by %s" % mp.nstr(norm(misses(x), mp.inf), 3))
    for (i, j), value in zip(PLACES, x):
        print("%2d %2d  [%r, %r]," % (i, j, *split(value)))
