//! Divided differences of a potential over an edge.
//!
//! The quotient `[V(b) - V(a)] / (b - a)` has an error of `1e-16 |V| / |b - a|` and is 0/0 at a
//! turning point. It equals the mean of V' over the edge. [`of_potential`] computes it from a V
//! written for every scalar, by slope arithmetic, exact to roundings. [`by_quadrature`] computes it
//! from V', by Gauss-Legendre quadrature that subdivides the edge where needed.

use crate::numbers::line::Line;
use crate::numbers::quadrature::mean;
use crate::numbers::scalar::Scalar;
use crate::numbers::slope::Slope;

/// The divided difference V[a, b] of `potential`, exact to roundings, and its derivative by `b`.
///
/// The derivative is (V'(b) - V[a, b])/(b - a), with which Newton's method converges on long edges
/// too.
#[inline]
pub fn of_potential<T: Scalar>(a: T, b: T, potential: impl Fn(Slope<T>) -> Slope<T>) -> Line<T> {
    let value = potential(Slope::between(a, b)).slope;
    with_derivative(a, b, value, |at| potential(Slope::between(at, at)).slope)
}

/// The mean of `f` over the edge from `a` to `b`, and its derivative by `b`, as in
/// [`of_potential`].
///
/// The quadrature has eight nodes for `f64`, exact for polynomials of degree 15, and sixteen for
/// scalars with more digits, exact to degree 31. [`mean`] states how edges are subdivided.
#[inline]
pub fn by_quadrature<T: Scalar>(a: T, b: T, f: impl Fn(T) -> T) -> Line<T> {
    let [value] = mean(a, b, |at, _| [f(at)]);
    with_derivative(a, b, value, f)
}

/// The width of an edge at 0, in the units of the coordinate, below which the derivative by b is
/// taken over this width instead. For f and its derivatives of size 1, the quotient over an edge of
/// width w has the rounding error 1e-16/w, and f'/2 in its place the error w: they are equal at
/// 1e-8. A choice, beyond that for the sake of f with larger rounding errors.
const SHORTEST_EDGE: f64 = 1e-7;

/// A mean with its derivative by b.
#[inline]
fn with_derivative<T: Scalar>(a: T, b: T, value: T, f: impl Fn(T) -> T) -> Line<T> {
    let width = b - a;
    // On a shorter edge the quotient would be rounding noise. f'/2 replaces it, with f' a
    // difference quotient over the shortest edge. The rounding error of a grows with |a|, while f
    // is assumed to vary over a length of 1: their geometric mean is best.
    let shortest = (a + T::from_f64(SHORTEST_EDGE) * (T::one() + a.abs()).sqrt()) - a;
    let short = width.abs().lt(shortest);
    let step = T::select(short, shortest, width);
    let rise = (f(a + step) - T::select(short, f(a), value)) / step;
    Line { value, slope: T::select(short, rise.half(), rise) }
}

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
        for (b, bound) in
            [(0.7, 1e-6), (0.7 + 1e-12, 1e-6), (0.7 - 1e-5, 1e-9), (0.9, 1e-9), (2.7, 1e-9)]
        {
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
            let exact =
                b / 2.0 * (1.0 + b / 3.0 * (1.0 + b / 4.0 * (1.0 + b / 5.0 * (1.0 + b / 6.0))));
            let found = by_quadrature(0.0, b, rough).value;
            assert!(
                (found - exact).abs() < 3e-16 + 1e-10 * exact.abs(),
                "{b:e}: {found:e} {exact:e}"
            );
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
