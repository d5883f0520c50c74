//! Adaptive Gauss-Legendre quadrature over an edge.

use super::scalar::{Mask, Scalar};

/// The means of K functions over the edge from `a` to `b`, by one quadrature. `f` receives the
/// point and the share of the edge before it, which is the derivative of the point by `b`.
///
/// An edge is resolved if the last two Legendre coefficients of the first function, one even and
/// one odd, are below a hundredth of the square root of a rounding relative to its mean size,
/// because they decrease at least as fast as the square root of the error. Other edges are
/// bisected. The means are NaN if bisection does not resolve the function, as at a pole. Features
/// between the nodes are missed.
#[inline]
pub fn mean<T: Scalar, const K: usize>(a: T, b: T, f: impl Fn(T, T) -> [T; K]) -> [T; K] {
    let part = panel([a, b], [T::zero(), T::one()], &f);
    if part.is_resolved() {
        return part.means;
    }
    in_parts([a, b], &part, &f).unwrap_or([T::from_f64(f64::NAN); K])
}

/// The largest tail of a resolved function, in square roots of a rounding. With 1 the error of a
/// component whose share of the function is A is up to 1/A roundings; with a hundredth a component
/// of A = 1e-4 has an error of one rounding.
const LARGEST_TAIL: f64 = 0.01;
/// The tail of a function that underflows: below it, values have fewer digits than their type.
const UNDERFLOW: f64 = f64::MIN_POSITIVE / f64::EPSILON;
/// The largest number of successive bisections: 2⁻⁵⁰ of an edge is near its rounding in `f64`.
const MOST_HALVINGS: usize = 50;
/// The largest number of bisections in all: enough for a few hundred periods of an angle.
const MOST_PARTS: usize = 8192;
/// The largest tail, as a share of the function, that is taken for rounding if it does not decrease
/// with the width of a part.
const NOISE_SHARE: f64 = 1e-3;
/// The number of bisections after which a tail that does not decrease is taken for rounding at any
/// size.
const HALVINGS_BEFORE_NOISE: i32 = 12;
/// The number of bisections over which the tail of rounding errors does not decrease. The tail of a
/// function may stay as it is once by coincidence, on a long part.
const GENERATIONS: usize = 4;
/// The decrease over these generations that random errors may show. A smooth function decreases by
/// 2⁻⁷ at each bisection.
const DECREASE_BY_CHANCE: f64 = 1.0 / 16.0;

/// The quadrature over part of an edge.
struct Panel<T, const K: usize> {
    means: [T; K],
    /// The mean of the first function's size.
    size: T,
    /// The size of its last two Legendre coefficients.
    tail: T,
    /// The change of the function by a rounding of the points, in unit roundoffs.
    noise: T,
}

impl<T: Scalar, const K: usize> Panel<T, K> {
    #[inline(always)]
    fn is_resolved(&self) -> bool {
        let unit = T::from_f64(T::EPSILON);
        let tail = T::from_f64(LARGEST_TAIL) * unit.sqrt();
        let rounding = T::from_f64(64.0) * unit * self.noise + T::from_f64(UNDERFLOW);
        self.tail.le(tail.mul_add(self.size, rounding)).all()
    }
}

/// The quadrature over the part of the edge between two shares of it.
#[inline]
fn panel<T: Scalar, const K: usize>(
    [a, b]: [T; 2],
    [from, to]: [T; 2],
    f: &(impl Fn(T, T) -> [T; K] + ?Sized),
) -> Panel<T, K> {
    let rule: &[[f64; 6]] = if T::IS_EXTENDED { &NODES_16 } else { &NODES_8 };
    let (length, share) = (b - a, to - from);
    let (width, centre) = (length * share, from + share.half());
    let middle = a + length * centre;
    let mut panel =
        Panel { means: [T::zero(); K], size: T::zero(), tail: T::zero(), noise: T::zero() };
    let [mut odd, mut even, mut spread] = [T::zero(); 3];
    for &[x, x_low, weight, weight_low, by_odd, by_even] in rule {
        let x = T::from_f64(x) + T::from_f64(x_low);
        let weight = T::from_f64(weight) + T::from_f64(weight_low);
        let (offset, ahead) = (x * width, x * share);
        let (before, after) =
            (f(middle - offset, centre - ahead), f(middle + offset, centre + ahead));
        panel.means = std::array::from_fn(|k| weight.mul_add(before[k] + after[k], panel.means[k]));
        panel.size = weight.mul_add(before[0].abs() + after[0].abs(), panel.size);
        odd = T::from_f64(by_odd).mul_add(after[0] - before[0], odd);
        even = T::from_f64(by_even).mul_add(after[0] + before[0], even);
        spread += (after[0] - before[0]).abs();
    }
    let still = width.abs().le(T::zero());
    panel.noise = middle.abs() * spread / T::select(still, T::one(), width.abs());
    panel.tail = T::select(still, T::zero(), odd.abs() + even.abs());
    panel
}

/// A part of an edge that is not resolved yet.
#[derive(Clone, Copy)]
struct Open<T> {
    /// Its beginning, as a share of the edge.
    from: f64,
    /// The number of bisections that led to it.
    depth: i32,
    /// Its last two Legendre coefficients, and those of the parts it was bisected from, the last
    /// one first.
    tails: [T; GENERATIONS],
}

/// The means by bisection of the edge; none if that takes too many parts. `whole` is the panel of
/// the undivided edge.
///
/// If both halves of a part have tails about as large as its own, the tails are taken for rounding
/// errors and the halves are accepted after [`HALVINGS_BEFORE_NOISE`] bisections. A half with a
/// tail that is small beside the function is accepted where it has not decreased for
/// [`GENERATIONS`]. Functions that oscillate that fast within a part are also taken for noise;
/// the balance of K reveals them.
///
/// `f` is a trait object, so that this is compiled once for each scalar and K, and not for each
/// function.
#[cold]
#[inline(never)]
fn in_parts<T: Scalar, const K: usize>(
    edge: [T; 2],
    whole: &Panel<T, K>,
    f: &dyn Fn(T, T) -> [T; K],
) -> Option<[T; K]> {
    // Depth first, so that there are no more open parts than bisections of one part.
    let first = Open { from: 0.0, depth: 0, tails: [whole.tail; GENERATIONS] };
    let mut open = [first; MOST_HALVINGS + 2];
    let (mut count, mut sums) = (1_usize, [T::zero(); K]);
    // The largest share of a part in the mean size, so far. Parts beside which it is large are
    // resolved sooner: flanks of a narrow peak need not be resolved each to its own rounding.
    let mut largest = whole.size;
    for _ in 0..MOST_PARTS {
        let Some(last) = count.checked_sub(1) else { return Some(sums) };
        count = last;
        let Open { from, depth, tails } = open[last];
        let (tail, oldest) = (tails[0], tails[GENERATIONS - 1]);
        if depth as usize == MOST_HALVINGS {
            return None;
        }
        let share = 0.5_f64.powi(depth + 1);
        let halves = [from, from + share]
            .map(|from| (from, panel(edge, [from, from + share].map(T::from_f64), f)));
        for (_, half) in &halves {
            let size = half.size * T::from_f64(share);
            largest = T::select(largest.lt(size), size, largest);
        }
        let done = halves.each_ref().map(|(_, half)| {
            // The error of a part, at most: it is about that large at a jump of the function.
            let rest = half.tail * T::from_f64(share);
            half.is_resolved() || rest.le(T::from_f64(16.0 * T::EPSILON) * largest).all()
        });
        let stays = halves.iter().all(|(_, half)| {
            let (four, limit) = (T::from_f64(4.0) * half.tail, T::from_f64(1.5) * tail);
            tail.le(four).and(half.tail.le(limit)).all()
        });
        let noisy = stays && depth + 1 >= HALVINGS_BEFORE_NOISE;
        let is_noise = |half: &Panel<T, K>| {
            let small = half.tail.le(T::from_f64(NOISE_SHARE) * half.size);
            let level = T::from_f64(DECREASE_BY_CHANCE) * oldest;
            depth as usize + 1 >= GENERATIONS && small.and(level.le(half.tail)).all()
        };
        for ((from, half), done) in halves.into_iter().zip(done).rev() {
            if done || noisy || is_noise(&half) {
                let weight = T::from_f64(share);
                sums = std::array::from_fn(|k| weight.mul_add(half.means[k], sums[k]));
            } else {
                let [a, b, c, _] = tails;
                open[count] = Open { from, depth: depth + 1, tails: [half.tail, a, b, c] };
                count += 1;
            }
        }
    }
    None
}

// A row belongs to a pair of nodes 1/2 ± x of [0, 1]: x and the weight of each node, both as sums
// of two f64, and the factors for the Legendre coefficients of odd and even order n - 1 and n - 2.
// The rows are printed by tests/data/gauss_legendre.py.
const NODES_8: [[f64; 6]; 4] = [
    [
        0.48014492824876814,
        -2.77442533954214e-17,
        0.05061426814518813,
        2.431871133231763e-19,
        0.11769245644771356,
        0.2098921910670323,
    ],
    [
        0.39833323870681336,
        5.812859914874862e-18,
        0.11119051722668724,
        -5.753650714613641e-18,
        -0.3778969370845921,
        -0.5591073831433646,
    ],
    [
        0.2627662049581645,
        -2.4999537888879484e-18,
        0.15685332293894363,
        9.134300218895555e-18,
        0.6317745531190048,
        0.6166048635025358,
    ],
    [
        0.0917173212478249,
        -1.4483841034929523e-18,
        0.181341891689181,
        -3.62383661760509e-18,
        -0.7849065579218132,
        -0.26738967142620357,
    ],
];

const NODES_16: [[f64; 6]; 8] = [
    [
        0.49470046749582497,
        -2.957047783234961e-18,
        0.013576229705877048,
        -7.8077335135818e-19,
        0.03278130486396174,
        0.06270545045312347,
    ],
    [
        0.4722875115366163,
        -1.2095034071222413e-17,
        0.031126761969323947,
        -3.845132261302852e-19,
        -0.1122209124505884,
        -0.20493540387013992,
    ],
    [
        0.4328156011939159,
        -5.6578389899249184e-18,
        0.04757925584124639,
        -4.391501798543696e-19,
        0.21159853063188444,
        0.3541214949557947,
    ],
    [
        0.3777022041775015,
        1.7620542947215177e-17,
        0.06231448562776694,
        -2.4207649011602476e-18,
        -0.31691961779722083,
        -0.46284478766452636,
    ],
    [
        0.3089381222013219,
        -1.1061760986731832e-17,
        0.07479799440828837,
        -1.9438099418708503e-18,
        0.41664037702596135,
        0.49770223675171826,
    ],
    [
        0.22900838882861368,
        8.331202085479629e-18,
        0.08457825969750127,
        1.1616496647822395e-18,
        -0.5008933497159644,
        -0.4435406121078921,
    ],
    [
        0.14080177538962946,
        -1.0979395626296066e-18,
        0.09130170752246179,
        2.5451132554526036e-18,
        0.5617461448292791,
        0.305833437439604,
    ],
    [
        0.04750625491881872,
        -1.6379738777165486e-19,
        0.09472530522753425,
        -2.941921747791332e-18,
        -0.5936159289428018,
        -0.10904181595768207,
    ],
];
