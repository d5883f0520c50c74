//! [`qd::Quad`]: the unevaluated sum of two `f64`, for seeing below the rounding of `f64`.
//!
//! Sums and products are the crate's, and so are their errors, given here as measured in units of
//! 2⁻¹⁰⁶ = 1.2e-32. The functions are written here: the crate has no sine, cosine or `exp_m1`, its
//! `exp` is off by up to 740 units at |x| = 650 (ln 2 in two parts is not enough to reduce so large
//! an argument) and its `sqrt` by 8.

use super::scalar::Scalar;
use super::two_sum::two_sum;
use qd::Quad;
use std::f64::consts::{FRAC_PI_2, LN_2, SQRT_2};

/// π/2 as a sum of three `f64`, each the one nearest to the rest after those before it.
const FRAC_PI_2_PARTS: [f64; 3] = [FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591698e-33];
/// ln 2, likewise.
const LN_2_PARTS: [f64; 3] = [LN_2, 2.3190468138462996e-17, 5.707708438416212e-34];
/// The largest angle that is not reduced again: π/4, and a little for its rounding.
const LARGEST_REDUCED: f64 = 0.79;

/// 1/n! for n from 0: enough that the first term left out of any series below is under 1e-33.
pub(super) const INVERSE_FACTORIALS: [Quad; 29] = {
    let mut inverses = [Quad::ONE; 29];
    let mut factorial = Quad::ONE;
    let mut n = 1;
    while n < inverses.len() {
        // Exact: without its powers of two, 28! fits in 73 bits.
        factorial = factorial.const_mul(Quad::from_f64(n as f64));
        inverses[n] = factorial.const_recip();
        n += 1;
    }
    inverses
};

/// Σ wʲ / (first + step j)!, by Horner's rule. From the term j = `large` on, which must be below
/// 1e-17 of the first, the terms are summed in `f64`.
fn series(w: Quad, first: usize, step: usize, large: usize) -> Quad {
    let (terms, small_terms) = INVERSE_FACTORIALS[first..].split_at(step * large);
    let small_terms = small_terms.iter().step_by(step).rev();
    let rest = small_terms.fold(0.0, |sum, c| f64::mul_add(sum, w.0, c.0));
    let terms = terms.iter().step_by(step).rev();
    terms.fold(Quad::from_f64(rest), |sum, &c| sum.mul_add(w, c))
}

/// The whole number k nearest to x / period, and x - k period.
///
/// The product of k and a part of the period is exact, and the accurate difference is good to 3
/// units of itself. The difference of the operator is not when terms cancel. In addition the tail
/// of the period is lost, 1e-49 k.
fn reduce(x: Quad, period: [f64; 3]) -> (f64, Quad) {
    let k = (x.0 / period[0]).round();
    let subtract = |r: Quad, part| r.sub_accurate(Quad::from_f64(k) * Quad::from_f64(part));
    (k, period.into_iter().fold(x, subtract))
}

/// k and p with eˣ = 2ᵏ (1 + p), |p| < 0.42: e^r - 1 by its series, where r = x - k ln 2.
fn exp_reduced(x: Quad) -> (i32, Quad) {
    let (k, r) = reduce(x, LN_2_PARTS);
    (k as i32, r + r * r * series(r, 2, 1, 13))
}

/// 1/(2n + 1) for n from 0: enough that the first term left out of the logarithm below is under
/// 1e-34 of it.
pub(super) const INVERSE_ODDS: [Quad; 22] = {
    let mut inverses = [Quad::ONE; 22];
    let mut n = 1;
    while n < inverses.len() {
        inverses[n] = Quad::from_f64((2 * n + 1) as f64).const_recip();
        n += 1;
    }
    inverses
};

/// 2ᵏ x, in two factors: 2ᵏ alone overflows before the result does.
fn scale(x: Quad, k: i32) -> Quad {
    let (a, b) = (2f64.powi(k / 2), 2f64.powi(k - k / 2));
    Quad(x.0 * a * b, x.1 * a * b)
}

impl Scalar for Quad {
    type Mask = bool;

    /// 5 units, the bound of the error of a product. The largest errors observed are 3.8 units for
    /// a product and 2.2 for a quotient. A sum is off by up to 3 units of |a| + |b|, not of itself,
    /// because the low parts are added with a rounding of their own. A difference of nearly equal
    /// numbers may therefore keep far fewer digits.
    const EPSILON: f64 = 1.25 * f64::EPSILON * f64::EPSILON;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Quad(x, 0.0)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.0
    }
    /// The product and the sum with one normalisation, at the end. The operators normalise twice,
    /// and the crate does not inline them.
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let product = self.0 * a.0;
        let low = self.0.mul_add(a.0, -product);
        let low = self.1.mul_add(a.0, self.0.mul_add(a.1, low));
        let [sum, lost] = two_sum(product, b.0);
        let low = lost + (low + b.1);
        let high = sum + low;
        Quad(high, low - (high - sum))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Quad::abs(self)
    }
    /// Part by part, exact.
    #[inline(always)]
    fn half(self) -> Self {
        Quad(self.0 * 0.5, self.1 * 0.5)
    }
    /// The remainder of the first quotient is exact. The result is good to 3 units of itself.
    #[inline]
    fn over(self, divisor: f64) -> Self {
        let high = self.0 / divisor;
        let low = (high.mul_add(-divisor, self.0) + self.1) / divisor;
        let sum = high + low;
        Quad(sum, low - (sum - high))
    }
    /// √self by one step of Newton's method from the root of the high part, good to 3 units of
    /// itself.
    fn sqrt(self) -> Self {
        if self.0 == 0.0 {
            return Quad::ZERO;
        }
        let root = Quad::from_f64(self.0.sqrt());
        root + Quad::from_f64(self.sub_accurate(root * root).0 / (2.0 * root.0))
    }
    /// e^self as 2ᵏ e^r with |r| ≤ ½ ln 2, good to 2 units of itself. Below x = -635 the low part
    /// underflows and the accuracy goes down to that of `f64`.
    fn exp(self) -> Self {
        match self.0 {
            x if x > 710.0 => Quad::INFINITY,
            x if x < -746.0 => Quad::ZERO,
            _ => {
                let (k, p) = exp_reduced(self);
                scale(p.add_accurate(Quad::ONE), k)
            }
        }
    }
    /// e^self - 1 as 2ᵏ ((e^r - 1) + (1 - 2⁻ᵏ)), whose bracket is the series itself near 0: good to
    /// 3 units of itself everywhere.
    fn exp_m1(self) -> Self {
        match self.0 {
            x if x > 710.0 => Quad::INFINITY,
            x if x < -80.0 => -Quad::ONE,
            _ => {
                let (k, p) = exp_reduced(self);
                scale(p.add_accurate(Quad::ONE.sub_accurate(Quad::from_f64(2f64.powi(-k)))), k)
            }
        }
    }
    /// `k ln 2 + 2 artanh z`, z = (m - 1)/(m + 1), of self = 2ᵏ m with m between √½ and √2: near 1,
    /// where k = 0, nothing is lost. Good to 3 units of itself. Below 1e-291 the low part has
    /// underflowed, and the accuracy goes down to that of `f64`.
    fn ln(self) -> Self {
        match self.0 {
            x if x < 0.0 || !x.is_finite() => Quad::from_f64(x.ln()),
            0.0 => Quad::NEG_INFINITY,
            x => {
                // A first power of two makes subnormal numbers normal.
                let shift = if x < 1e-291 { 1000 } else { 0 };
                let lifted = scale(self, shift);
                let exponent = ((lifted.0.to_bits() >> 52) & 0x7ff) as i32 - 1023;
                let m = scale(lifted, -exponent);
                let (m, k) =
                    if m.0 > SQRT_2 { (scale(m, -1), exponent + 1) } else { (m, exponent) };
                let z = m.sub_accurate(Quad::ONE) / m.add_accurate(Quad::ONE);
                let w = z * z;
                let sum = INVERSE_ODDS.iter().rev().fold(Quad::ZERO, |sum, &c| sum.mul_add(w, c));
                let [a, b, _] = LN_2_PARTS;
                (z + z) * sum + Quad(a, b) * Quad::from_f64(f64::from(k - shift))
            }
        }
    }
    /// One step of Newton's method from the angle y of the high part,
    /// `y + (x cos y - sin y)/(cos y + x sin y)`: the remaining error is the third power of an
    /// error of 1e-16. Good to 4 units of itself.
    fn atan(self) -> Self {
        let y = Quad::from_f64(self.0.atan());
        if self.0.is_infinite() {
            let [a, b, _] = FRAC_PI_2_PARTS;
            return if self.0 < 0.0 { -Quad(a, b) } else { Quad(a, b) };
        }
        let (sin, cos) = y.sin_cos();
        y.add_accurate((self * cos).sub_accurate(sin) / (cos + self * sin))
    }
    /// If the high part is a whole number, the low part decides.
    fn floor(self) -> Self {
        let floor = self.0.floor();
        let low = if floor == self.0 { self.1.floor() } else { 0.0 };
        Quad::from_f64(floor) + Quad::from_f64(low)
    }
    /// The Taylor series at r = self - k π/2, |r| ≤ π/4, turned by k quadrants: good to 2 units of
    /// 1 for |self| up to 1e4, to 4 up to 1e16, and beyond that to 1e-48 |self|.
    fn sin_cos(self) -> (Self, Self) {
        let (mut k, mut r) = reduce(self, FRAC_PI_2_PARTS);
        // k has 53 bits, so that a large angle leaves more than a quadrant.
        while r.0.abs() > LARGEST_REDUCED {
            let (quadrants, left) = reduce(r, FRAC_PI_2_PARTS);
            (k, r) = (k % 4.0 + quadrants, left);
        }
        let w = -(r * r);
        let sin = r + r * w * series(w, 3, 2, 8);
        let cos = Quad::ONE + w * series(w, 2, 2, 9);
        match (k % 4.0) as i64 & 3 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        // The operator: the method of that name ignores the low parts of equal high parts.
        self <= other
    }
    /// Whether both parts are finite: an overflow leaves an infinite high part with a low part that
    /// is NaN.
    #[inline(always)]
    fn is_finite(self) -> bool {
        Quad::is_finite(self)
    }
    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points with 48 digits of the values, from `quad_functions.py` beside it.
    const TABLE: &str = include_str!("../../tests/data/quad_functions.csv");

    #[test]
    fn functions_agree_with_the_table() {
        let mut worst = std::collections::BTreeMap::new();
        for line in TABLE.lines().skip(1) {
            let (name, numbers) = line.split_once(',').unwrap();
            let numbers: Vec<f64> = numbers.split(',').map(|x| x.parse().unwrap()).collect();
            let &[x_hi, x_lo, hi, mid, lo] = numbers.as_slice() else {
                panic!("five numbers in {line}")
            };
            let x = Quad(x_hi, x_lo);
            let value = match name {
                "sqrt" => Scalar::sqrt(x),
                "exp" => Scalar::exp(x),
                "exp_m1" => x.exp_m1(),
                "sin" => x.sin_cos().0,
                "cos" => x.sin_cos().1,
                "ln" => Scalar::ln(x),
                "atan" => x.atan(),
                "tan" => x.tan(),
                "asin" => x.asin(),
                "acos" => x.acos(),
                "sinh" => x.sinh(),
                "cosh" => x.cosh(),
                "tanh" => x.tanh(),
                "powi 13" => Scalar::powi(x, 13),
                "powi -6" => Scalar::powi(x, -6),
                _ => panic!("no function called {name}"),
            };
            // The accurate differences, and the large part first: the rest then has a negligible
            // error.
            let error = value.sub_accurate(Quad(hi, mid)).sub_accurate(Quad(lo, 0.0)).0;
            let size = if hi == 0.0 || matches!(name, "sin" | "cos") { 1.0 } else { hi.abs() };
            let error = error.abs() / size;
            // A power adds the errors of its factors.
            let bound = if name.starts_with("powi") { 2e-31 } else { 4e-32 };
            assert!(error < bound, "{name}({x_hi:e} + {x_lo:e}) is off by {error:e}");
            let entry = worst.entry(name).or_insert((0, 0.0));
            *entry = (entry.0 + 1, f64::max(entry.1, error));
        }
        assert!(worst.len() == 15 && worst.values().all(|&(points, _)| points >= 24), "{worst:?}");
    }

    #[test]
    fn a_multiply_add_is_as_good_as_its_terms() {
        let numbers = [Quad(1.0 / 3.0, 1.7e-17), Quad(-0.7, 3.1e-17), Quad(5e7, -2.9e-9)];
        for a in numbers {
            for b in numbers {
                let product = a * b;
                let near = product * Quad(1.0, 3e-20);
                for c in [Quad::ONE, Quad(-4e9, 2e-7), -product, -near, Quad::from_f64(1e-30)] {
                    let exact = product.add_accurate(c);
                    let off = a.mul_add(b, c).sub_accurate(exact).0.abs();
                    let bound = <Quad as Scalar>::EPSILON * (product.0.abs() + c.0.abs());
                    assert!(off <= bound, "{a:?} {b:?} {c:?}: {off:e}, not {bound:e}");
                }
            }
        }
    }

    #[test]
    fn a_quotient_by_a_short_number_times_it_is_the_dividend() {
        let hard = [(1.0000000000000546, 1.0784175021358962e-16), (1.0000000099440702, 1.0961e-16)];
        let easy = [(1.0 / 3.0, 1.7e-17), (-0.7, 3.1e-17), (5e7, -2.9e-9), (1.0, 0.0)];
        for x in hard.into_iter().chain(easy).map(|(high, low)| Quad(high, low)) {
            for k in [1.0, 2.0, 3.0, 7.0, 13.0, 23.0, -49.0, 1.0 / 3.0, 1.949890219245363, 1e100] {
                let quotient = x.over(k);
                // The product of k and a part of the quotient is exact as a sum of two numbers.
                let rest = [quotient.0, quotient.1].into_iter().fold(x, |rest, part| {
                    let product = part * k;
                    let rest = rest.sub_accurate(Quad::from_f64(product));
                    rest.sub_accurate(Quad::from_f64(part.mul_add(k, -product)))
                });
                let off = rest.0.abs() / x.0.abs();
                assert!(off <= 3.7e-32, "{x:?} by {k}: off by {off:e}");
            }
        }
        assert!(!Scalar::is_finite(Quad::ONE.over(0.0)));
    }

    #[test]
    fn large_angles_stay_on_the_circle() {
        for x in [1e16, -3e18, 1e22, 1e40, -1e100, 1.7e300] {
            let (sin, cos) = Quad(x, x.abs() * 1e-17).sin_cos();
            let off = (sin * sin + cos * cos).sub_accurate(Quad::ONE).0.abs();
            assert!(off <= 4.0 * <Quad as Scalar>::EPSILON, "at {x:e} off by {off:e}");
        }
        // With 400 bits, by mpmath.
        let (sin, cos) = Quad::from_f64(1e22).sin_cos();
        let off = |x: Quad, [high, low]: [f64; 2]| x.sub_accurate(Quad(high, low)).0.abs();
        assert!(off(sin, [-0.8522008497671888, -6.7806825896773284e-18]) < 1e-25);
        assert!(off(cos, [0.523214785395139, -4.7143201076575164e-17]) < 1e-25);
    }

    #[test]
    fn what_is_not_finite_is_seen() {
        let (zero, one, huge) = (Quad::zero(), Quad::one(), Quad::from_f64(1e200));
        let big = Quad::from_f64(1000.0);
        for x in
            [huge * huge, huge * huge - huge * huge, one / zero, zero / zero, Quad(1.0, f64::NAN)]
        {
            assert!(!Scalar::is_finite(x), "{x:?}");
            assert!(!Scalar::is_finite(Scalar::sqrt(x)), "√{x:?}");
            assert!(!Scalar::is_finite(x.sin_cos().0), "sin {x:?}");
            assert!(!Scalar::is_finite(x.exp_m1()), "exp_m1 {x:?}");
        }
        for x in
            [Scalar::sqrt(-one), Scalar::exp(big), big.exp_m1(), Scalar::exp(Quad::from_f64(709.9))]
        {
            assert!(!Scalar::is_finite(x), "{x:?}");
        }
        assert!(Scalar::is_finite(Scalar::exp(Quad::from_f64(709.7))));
        assert_eq!((Scalar::exp(-big), (-big).exp_m1(), Scalar::sqrt(zero)), (zero, -one, zero));
    }

    #[test]
    fn comparisons_see_the_low_part() {
        let (a, b) = (Quad(1.0, -1e-20), Quad(1.0, 1e-20));
        assert!(Scalar::lt(a, b) && Scalar::le(a, a) && !Scalar::lt(a, a) && !Scalar::le(b, a));
        assert_eq!((Scalar::select(Scalar::lt(a, b), b, a), Scalar::abs(-a)), (b, a));
    }
}
