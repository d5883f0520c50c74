//! The mean of a function along an edge: a divided difference of its antiderivative without the cancellation.
//!
//! `[V(b) - V(a)] / (b - a)` loses `1e-16 |V| / |b - a|`, and is 0/0 at a turning point. The same number is the mean
//! of V' over the edge, and Gauss-Legendre quadrature gives it with no cancellation, no branch and no special case.

use crate::{Line, Scalar};

/// The mean of `f` over the edge from `a` to `b`, and its derivative by `b`.
///
/// Eight nodes for `f64`, exact for polynomials of degree 15; sixteen, exact to degree 31, where the scalar
/// resolves more. The slope is that of the mean, [f(b) - mean] / (b - a), so that Newton's iteration converges on long edges too.
#[inline]
pub fn by_quadrature<T: Scalar>(a: T, b: T, f: impl Fn(T) -> T) -> Line<T> {
    let width = b - a;
    let [value] = mean(a, b, |at, _| [f(at)]);
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
#[inline]
pub fn mean<T: Scalar, const K: usize>(a: T, b: T, f: impl Fn(T, T) -> [T; K]) -> [T; K] {
    let rule: &[[f64; 4]] = if T::EPSILON < 1e-20 { &NODES_16 } else { &NODES_8 };
    let (width, half) = (b - a, T::one().half());
    let middle = a + width.half();
    rule.iter().fold([T::zero(); K], |sums, &[x, x_low, weight, weight_low]| {
        let x = T::from_f64(x) + T::from_f64(x_low);
        let weight = T::from_f64(weight) + T::from_f64(weight_low);
        let offset = x * width;
        let (before, after) = (f(middle - offset, half - x), f(middle + offset, half + x));
        std::array::from_fn(|k| weight.mul_add(before[k] + after[k], sums[k]))
    })
}

// A row is a pair of nodes 1/2 +- x of [0, 1] and the weight of each, as sums of two doubles
// (tests/data/gauss_legendre.py prints them).
const NODES_8: [[f64; 4]; 4] = [
    [0.48014492824876814, -2.77442533954214e-17, 0.05061426814518813, 2.431871133231763e-19],
    [0.39833323870681336, 5.812859914874862e-18, 0.11119051722668724, -5.753650714613641e-18],
    [0.2627662049581645, -2.4999537888879484e-18, 0.15685332293894363, 9.134300218895555e-18],
    [0.0917173212478249, -1.4483841034929523e-18, 0.181341891689181, -3.62383661760509e-18],
];

const NODES_16: [[f64; 4]; 8] = [
    [0.49470046749582497, -2.957047783234961e-18, 0.013576229705877048, -7.8077335135818e-19],
    [0.4722875115366163, -1.2095034071222413e-17, 0.031126761969323947, -3.845132261302852e-19],
    [0.4328156011939159, -5.6578389899249184e-18, 0.04757925584124639, -4.391501798543696e-19],
    [0.3777022041775015, 1.7620542947215177e-17, 0.06231448562776694, -2.4207649011602476e-18],
    [0.3089381222013219, -1.1061760986731832e-17, 0.07479799440828837, -1.9438099418708503e-18],
    [0.22900838882861368, 8.331202085479629e-18, 0.08457825969750127, 1.1616496647822395e-18],
    [0.14080177538962946, -1.0979395626296066e-18, 0.09130170752246179, 2.5451132554526036e-18],
    [0.04750625491881872, -1.6379738777165486e-19, 0.09472530522753425, -2.941921747791332e-18],
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
        assert!((moment(-0.3_f64, 16).0 - moment(-0.3_f64, 16).1).abs() > 1e-11);
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
}
