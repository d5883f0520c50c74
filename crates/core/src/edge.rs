//! The mean of a function along an edge: a divided difference of its antiderivative without the cancellation.
//!
//! `[V(b) - V(a)] / (b - a)` loses `1e-16 |V| / |b - a|`, and is 0/0 at a turning point. The same number is the mean
//! of V' over the edge. Where V is written for every scalar, [`of_potential`] gives it exactly, in slope
//! arithmetic. Where V' alone is known, Gauss-Legendre quadrature gives it as far as its nodes resolve V'
//! ([`by_quadrature`]): on the edge, else on its halves and their halves, else not at all.

use crate::{Line, Mask, Scalar, Slope};

/// The mean slope of `potential` over the edge from `a` to `b`, exact to roundings, and its derivative by `b`.
///
/// The derivative is [V'(b) - mean]/(b - a), so that Newton's iteration converges on long edges too.
#[inline]
pub fn of_potential<T: Scalar>(a: T, b: T, potential: impl Fn(Slope<T>) -> Slope<T>) -> Line<T> {
    let value = potential(Slope::between(a, b)).slope;
    bent(a, b, value, |at| potential(Slope::between(at, at)).slope)
}

/// The mean of `f` over the edge from `a` to `b`, and its derivative by `b`.
///
/// Eight nodes for `f64`, exact for polynomials of degree 15; sixteen, exact to degree 31, where the scalar
/// resolves more. See [`mean`] for what is done where they do not resolve `f`; the derivative is as in [`of_potential`].
#[inline]
pub fn by_quadrature<T: Scalar>(a: T, b: T, f: impl Fn(T) -> T) -> Line<T> {
    let [value] = mean(a, b, |at, _| [f(at)]);
    bent(a, b, value, f)
}

/// A mean with its derivative by b.
#[inline]
fn bent<T: Scalar>(a: T, b: T, value: T, f: impl Fn(T) -> T) -> Line<T> {
    let width = b - a;
    // On an edge shorter than this the slope would be rounding noise: it is half of f' there. An angle far from 0 is rounded
    // the more, but f varies over a radian there too: between the roundings of a and 1, the slope is best near their mean.
    let reach = (a + T::from_f64(1e-7) * (T::one() + a.abs()).sqrt()) - a;
    let short = width.abs().lt(reach);
    let step = T::select(short, reach, width);
    let rise = (f(a + step) - T::select(short, f(a), value)) / step;
    Line { value, slope: T::select(short, rise.half(), rise) }
}

/// The means of some functions over the edge from `a` to `b`, by the same quadrature. `f` is given the point and the share of the
/// edge before it, which is what the point moves by as `b` does.
///
/// The edge is resolved where the last two Legendre coefficients of the first function, one even and one
/// odd, are below the square root of a rounding beside its mean size: they fall at least as the square
/// root of the error does. Where it is not, each half is taken by itself. Where halves of halves do not
/// end it, as at a pole, the means are NaN. What lies between all nodes is not seen.
#[inline]
pub fn mean<T: Scalar, const K: usize>(a: T, b: T, f: impl Fn(T, T) -> [T; K]) -> [T; K] {
    let part = panel([a, b], [T::zero(), T::one()], &f);
    if part.is_resolved() {
        return part.means;
    }
    in_parts([a, b], &part, &f).unwrap_or([T::from_f64(f64::NAN); K])
}

/// Halvings after which an edge is not resolved.
const DEEPEST: usize = 50;
/// Parts divided after which an edge is not resolved: enough for a few hundred turns of an angle.
const MOST: usize = 8192;
/// Tails below this share of a function that do not fall are its roundings.
const FAINT: f64 = 1e-3;
/// Halvings after which tails that do not fall are roundings, however large.
const NOISY: i32 = 12;

/// The quadrature over part of an edge.
struct Panel<T, const K: usize> {
    means: [T; K],
    /// The mean of the first function's size.
    size: T,
    /// The size of its last two Legendre coefficients.
    tail: T,
    /// What its values may be off by, where the points they are taken at are rounded.
    noise: T,
}

impl<T: Scalar, const K: usize> Panel<T, K> {
    #[inline(always)]
    fn is_resolved(&self) -> bool {
        let unit = T::from_f64(T::EPSILON);
        self.tail.le(unit.sqrt().mul_add(self.size, T::from_f64(64.0) * unit * self.noise)).all()
    }
}

/// The functions over the part of the edge between two shares of it.
#[inline]
fn panel<T: Scalar, const K: usize>(
    [a, b]: [T; 2],
    [from, to]: [T; 2],
    f: &impl Fn(T, T) -> [T; K],
) -> Panel<T, K> {
    let rule: &[[f64; 6]] = if T::EPSILON < 1e-20 { &NODES_16 } else { &NODES_8 };
    let (length, share) = (b - a, to - from);
    let (width, centre) = (length * share, from + share.half());
    let middle = a + length * centre;
    let mut panel = Panel { means: [T::zero(); K], size: T::zero(), tail: T::zero(), noise: T::zero() };
    let [mut odd, mut even, mut spread] = [T::zero(); 3];
    for &[x, x_low, weight, weight_low, by_odd, by_even] in rule {
        let x = T::from_f64(x) + T::from_f64(x_low);
        let weight = T::from_f64(weight) + T::from_f64(weight_low);
        let (offset, ahead) = (x * width, x * share);
        let (before, after) = (f(middle - offset, centre - ahead), f(middle + offset, centre + ahead));
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

/// A part of an edge whose nodes did not resolve the function.
#[derive(Clone, Copy)]
struct Open<T> {
    /// Where it begins, as a share of the edge.
    from: f64,
    /// It is the edge halved so often.
    depth: i32,
    /// Its last two Legendre coefficients.
    tail: T,
}

/// The means by as many parts of the edge as it takes; none where it takes too many. `whole` is the
/// panel of the undivided edge.
///
/// Where both halves of a part have tails about as large as its own, these are roundings of the function,
/// and are taken: at once where they are small beside it, else after [`NOISY`] halvings. Functions
/// that turn so often within a part are taken for noise as well; K tells.
#[cold]
#[inline(never)]
fn in_parts<T: Scalar, const K: usize>(
    edge: [T; 2],
    whole: &Panel<T, K>,
    f: &impl Fn(T, T) -> [T; K],
) -> Option<[T; K]> {
    // Depth first, so that no more parts are open than there are halvings.
    let first = Open { from: 0.0, depth: 0, tail: whole.tail };
    let mut open = [first; DEEPEST + 2];
    let (mut count, mut sums) = (1_usize, [T::zero(); K]);
    for _ in 0..MOST {
        let Some(last) = count.checked_sub(1) else { return Some(sums) };
        count = last;
        let Open { from, depth, tail } = open[last];
        if depth as usize == DEEPEST {
            return None;
        }
        let share = 0.5_f64.powi(depth + 1);
        let halves =
            [from, from + share].map(|from| (from, panel(edge, [from, from + share].map(T::from_f64), f)));
        let done = halves.each_ref().map(|(_, half)| {
            // What a part can still be off by, where a jump of the function lies in it.
            let rest = half.tail * T::from_f64(share);
            half.is_resolved() || rest.le(T::from_f64(16.0 * T::EPSILON) * whole.size).all()
        });
        let noisy = halves.iter().all(|(_, half)| {
            let faint = half.tail.le(T::from_f64(FAINT) * half.size).all() || depth + 1 >= NOISY;
            let stays = tail.le(T::from_f64(4.0) * half.tail).and(half.tail.le(T::from_f64(1.5) * tail));
            faint && stays.all()
        });
        for ((from, half), done) in halves.into_iter().zip(done).rev() {
            if done || noisy {
                let weight = T::from_f64(share);
                sums = std::array::from_fn(|k| weight.mul_add(half.means[k], sums[k]));
            } else {
                open[count] = Open { from, depth: depth + 1, tail: half.tail };
                count += 1;
            }
        }
    }
    None
}

// A row is a pair of nodes 1/2 +- x of [0, 1] and the weight of each, as sums of two doubles, and what gives the Legendre coefficients
// of odd and even order n - 1 and n - 2 (tests/data/gauss_legendre.py prints them).
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

#[cfg(test)]
mod tests {
    use super::*;
    use qd::Quad;

    /// ∫_0^1 (c + x)^k dx = [(c+1)^(k+1) - c^(k+1)] / (k+1)
    fn moment<T: Scalar>(c: T, k: u32) -> (T, T) {
        let power = |x: T, n: u32| (0..n).fold(T::one(), |y, _| y * x);
        let exact = (power(c + T::one(), k + 1) - power(c, k + 1)) / T::from_f64(f64::from(k + 1));
        (by_quadrature(c, c + T::one(), |x| power(x, k)).value, exact)
    }

    #[test]
    fn polynomials_are_exact() {
        for k in 0..16 {
            let (found, exact) = moment(-0.3_f64, k);
            assert!((found - exact).abs() < 1e-15, "{k}: {found} {exact}");
        }
        for k in 0..32 {
            let (found, exact) = moment(Quad::from_f64(-0.3), k);
            assert!((found - exact).abs().to_f64() < 1e-31, "{k}: {found:?} {exact:?}");
        }
        // Higher degrees take two halves.
        assert!((moment(-0.3_f64, 24).0 - moment(-0.3_f64, 24).1).abs() < 1e-15);
    }

    #[test]
    fn a_turning_point_is_an_ordinary_point() {
        let at = |b: f64| by_quadrature(0.7, b, f64::sin);
        assert_eq!(at(0.7).value, 0.7_f64.sin());
        let exact = |b: f64| ((b + 0.7) / 2.0).sin() * sinc((b - 0.7) / 2.0);
        for b in [0.7, 0.7 + 1e-12, 0.7 - 1e-5, 0.9_f64] {
            assert!((at(b).value - exact(b)).abs() < 2e-16, "{b}");
        }
        // Long edges too have the slope of their mean.
        for (b, bound) in [(0.7, 1e-6), (0.7 + 1e-12, 1e-6), (0.7 - 1e-5, 1e-9), (0.9, 1e-9), (2.7, 1e-9)] {
            let slope = (exact(b + 1e-5) - exact(b - 1e-5)) / 2e-5;
            assert!((at(b).slope - slope).abs() < bound, "{b}: {} {slope}", at(b).slope);
        }
    }

    #[test]
    fn an_angle_far_from_zero_has_its_slope() {
        for turns in [1e3, 1e5, 1e7] {
            let a = 0.3 + std::f64::consts::TAU * turns;
            for b in [a, a + 1e-6, a + 1e-3] {
                let (slope, exact) = (by_quadrature(a, b, f64::sin).slope, a.cos() / 2.0);
                assert!((slope - exact).abs() < 1e-3, "{turns} {}: {slope} {exact}", b - a);
            }
        }
    }

    fn sinc(x: f64) -> f64 {
        if x == 0.0 { 1.0 } else { x.sin() / x }
    }

    /// A mean of f with antiderivative F, beside the quotient in twice the digits.
    fn off(a: f64, b: f64, f: fn(f64) -> f64, antiderivative: fn(Quad) -> Quad) -> f64 {
        let [x, y] = [a, b].map(Quad::from_f64);
        let exact = (antiderivative(y) - antiderivative(x)) / (y - x);
        (Quad::from_f64(by_quadrature(a, b, f).value) - exact).to_f64().abs()
    }

    #[test]
    fn long_edges_are_taken_in_parts() {
        for b in [1.0, 20.3, 200.0, -511.0] {
            // The points are rounded as the angle is.
            let bound = 1e-14 + 2e-16 * b.abs();
            assert!(off(0.3, b, f64::sin, |x| -x.sin_cos().1) < bound, "{b}");
        }
        let bell = |x: f64| 1.0 / (1.0 + 1e4 * x * x);
        let arc = |x: Quad| (x * Quad::from_f64(100.0)).atan() / Quad::from_f64(100.0);
        assert!(off(-1.0, 0.3, bell, arc) < 1e-14);
        assert!(off(-1.0, 0.7, f64::abs, |x| x.half() * x.abs()) < 1e-14);
        assert!(off(-1.0, 0.7, f64::signum, Quad::abs) < 1e-14);
    }

    /// e^q - 1 without `exp_m1`: near 0 it is steps of a rounding of 1.
    #[test]
    fn roundings_of_the_function_are_no_features() {
        let rough = |x: f64| x.exp() - 1.0;
        for b in [1e-2, 1e-3, -4e-10, 1e-12, 1e-15] {
            let exact = b / 2.0 * (1.0 + b / 3.0 * (1.0 + b / 4.0 * (1.0 + b / 5.0 * (1.0 + b / 6.0))));
            let found = by_quadrature(0.0, b, rough).value;
            assert!((found - exact).abs() < 3e-16 + 1e-10 * exact.abs(), "{b:e}: {found:e} {exact:e}");
        }
    }

    #[test]
    fn a_pole_has_no_mean() {
        for pole in [|x: f64| 1.0 / (x * x), |x: f64| 1.0 / x, |x: f64| x.powi(-3)] {
            assert!(by_quadrature(-1.0, 0.3, pole).value.is_nan());
            assert!(by_quadrature(0.2, 0.3, pole).value.is_finite());
        }
    }

    #[test]
    fn a_potential_gives_its_mean() {
        for (a, b) in [(0.3, 0.3), (0.3, 0.3 + 1e-12), (0.3, 0.9), (0.3, 40.0)] {
            let exact = by_quadrature(a, b, |x: f64| x.sin() + x);
            let found = of_potential(a, b, |x| x * x.half() - x.sin_cos().1);
            assert!((found.value - exact.value).abs() < 1e-14, "{a} {b}: {found:?} {exact:?}");
            assert!((found.slope - exact.slope).abs() < 1e-6, "{a} {b}: {found:?} {exact:?}");
        }
    }
}
