//! Truncated powers, of which forces of contact are made: `x₊^c` is x^c for x > 0, and 0 elsewhere.
//!
//! A power of max(x, 0) by the product rule has derivatives 0·∞ where x ≤ 0. Those of a truncated
//! power are truncated powers again: `(x₊^c)' = c x₊^(c-1)`.
//!
//! With s = √a and t = √b, for a, b > 0 and a whole n,
//!
//! ```text
//! (b^(n+1/2) - a^(n+1/2))/(b - a) = (t^2n + t^(2n-1) s + .. + s^2n)/(s + t)
//! ```
//!
//! which has no subtraction. Other powers are e^(c ln x), with the divided differences of both
//! functions. Where only one end is positive, nothing cancels in the quotient itself.

use afterbay_core::{Line, Mask, Scalar, divided};

/// The exponent a/b - n of a power of the positive part of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TruncatedPower {
    /// The bits of a and b. The first power is positive, and no whole number.
    fraction: [u64; 2],
    /// The number n of derivatives.
    lowered: u32,
}

/// The largest power that is computed by products. A choice.
const LARGEST_BY_PRODUCTS: f64 = 64.0;

impl TruncatedPower {
    /// The truncated power of the exponent a/b. None if that is not positive, whole, or not finite.
    pub(crate) fn new([a, b]: [f64; 2]) -> Option<Self> {
        let exponent = a / b;
        let fits = exponent.is_finite() && exponent > 0.0 && exponent.fract() != 0.0;
        fits.then_some(Self { fraction: [a, b].map(f64::to_bits), lowered: 0 })
    }

    /// The power that the derivative contains.
    pub(crate) fn lower(self) -> Self {
        Self { lowered: self.lowered + 1, ..self }
    }

    /// a, b and n of the exponent.
    pub(crate) fn exponent_parts(self) -> [f64; 3] {
        let [a, b] = self.fraction.map(f64::from_bits);
        [a, b, f64::from(self.lowered)]
    }

    /// The exponent. In a scalar of more digits than f64 it has them too.
    pub(crate) fn exponent<T: Scalar>(self) -> T {
        let [a, b, n] = self.exponent_parts().map(T::from_f64);
        a / b - n
    }

    /// n of an exponent n + 1/2.
    fn whole_part(self) -> Option<i32> {
        let exponent: f64 = self.exponent();
        let half = (exponent - 0.5).fract() == 0.0 && exponent.abs() <= LARGEST_BY_PRODUCTS;
        half.then_some((exponent - 0.5) as i32)
    }

    /// x₊^c
    pub(crate) fn at<T: Scalar>(self, x: T) -> T {
        let zero = T::zero();
        // For x > 0 this is x. It also gives a root for an interval that reaches below 0.
        let size = x.abs();
        let power = match self.whole_part() {
            Some(n) if n < 0 => (whole_power(size, n.unsigned_abs() - 1) * size.sqrt()).recip(),
            Some(n) => whole_power(size, n.unsigned_abs()) * size.sqrt(),
            None => (self.exponent::<T>() * size.ln()).exp(),
        };
        let nothing = T::select(x.le(zero), zero, x * zero);
        T::select(zero.lt(x), power, nothing)
    }

    /// The divided difference from a to b, for c > 0, and its derivative by b.
    pub(crate) fn divided<T: Scalar>(self, a: T, b: T) -> Line<T> {
        let (zero, one) = (T::zero(), T::one());
        let exponent = self.exponent::<T>();
        let (rest, both) = ((b - a).abs().le(zero), zero.lt(a).and(zero.lt(b)));
        let width = T::select(rest, one, b - a);
        let inside = match self.whole_part() {
            Some(n) => {
                let [s, t] = [a.abs().sqrt(), b.abs().sqrt()];
                let (mut sum, mut power) = (one, one);
                for _ in 0..2 * n.unsigned_abs() {
                    power *= s;
                    sum = sum.mul_add(t, power);
                }
                sum / (s + t)
            }
            None => {
                let [c, d] = [a, b].map(|x| exponent * x.abs().ln());
                let logarithm = divided::ln(a.abs(), b.abs()).value;
                exponent * divided::exp(c, d).value * logarithm
            }
        };
        let apart = (self.at(b) - self.at(a)) / width;
        let value = T::select(both, inside, apart);
        // On a short edge the quotient would cancel, and ½ φ'' is accurate to (b - a)².
        let lower = self.lower();
        let middle = (a + b + b) / T::from_f64(3.0);
        let bend = (exponent * (exponent - one)).half() * lower.lower().at(middle);
        let short = (b - a).abs().le(T::from_f64(T::EPSILON.cbrt()) * b.abs());
        let slope = (exponent * lower.at(b) - value) / width;
        let none = rest.and(b.le(zero));
        let slope = T::select(short.and(both), bend, slope);
        Line { value, slope: T::select(none, zero, slope) }
    }
}

/// x^n
fn whole_power<T: Scalar>(x: T, n: u32) -> T {
    (0..u32::BITS - n.leading_zeros()).rev().fold(T::one(), |power, bit| {
        let square = power * power;
        if n >> bit & 1 == 1 { square * x } else { square }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Quad, f64x8};

    fn power(exponent: f64) -> TruncatedPower {
        TruncatedPower::new([exponent, 1.0]).expect("no whole number")
    }

    #[test]
    fn values_are_powers_and_0_below_0() {
        for exponent in [0.5, 1.5, 2.5, 63.5, 0.3, 1.6, 4.0 / 3.0] {
            for lowered in 0..3 {
                let power = (0..lowered).fold(power(exponent), |power, _| power.lower());
                for x in [-3.0_f64, -1e-300, -0.0, 1e-8, 0.7, 1.0, 9.3] {
                    let expected = if x > 0.0 { x.powf(power.exponent::<f64>()) } else { 0.0 };
                    let found = power.at(x);
                    let off = (found - expected).abs();
                    assert!(off <= 1e-13 * expected, "{exponent} - {lowered}, {x}: {found}");
                    let lanes = power.at(f64x8::from([x, 1.0, -1.0, 2.0, x, x, 0.0, x]));
                    let last = lanes.as_array()[7];
                    assert!((last - found).abs() <= 1e-14 * found, "{last} {found}");
                }
                assert!(power.at(f64::NAN).is_nan());
            }
        }
        for exponent in [2.0, -0.5, 0.0, f64::INFINITY, f64::NAN] {
            assert_eq!(TruncatedPower::new([exponent, 1.0]), None);
        }
        assert_eq!(
            (TruncatedPower::new([6.0, 3.0]), TruncatedPower::new([1.0, 0.0])),
            (None, None)
        );
    }

    #[test]
    fn a_third_has_all_digits() {
        let power = TruncatedPower::new([4.0, 3.0]).expect("no whole number");
        let x = power.at(Quad::from_f64(2.0));
        let off = (x * x * x - Quad::from_f64(16.0)).to_f64().abs();
        assert!(off < 1e-28, "{off}");
    }

    #[test]
    fn divided_differences_are_quotients_in_more_digits() {
        for exponent in [0.5, 1.5, 2.5, 7.5, 1.6, 4.0 / 3.0] {
            let power = power(exponent);
            for a in [-1.0, -1e-9, 0.0, 1e-9, 0.3, 1.0, 2.0] {
                for b in [-2.0, -1e-7, 0.0, 1e-12, 1e-9, 0.3, 0.3 + 1e-9, 1.0 + 1e-4, 5.0] {
                    let Line { value, slope } = power.divided(a, b);
                    let [x, y] = [a, b].map(Quad::from_f64);
                    let exact = |y: Quad| match y == x {
                        true => power.exponent::<Quad>() * power.lower().at(x),
                        false => (power.at(y) - power.at(x)) / (y - x),
                    };
                    let of_b = exact(y);
                    let off = (Quad::from_f64(value) - of_b).to_f64().abs();
                    assert!(off <= 1e-14 * value.abs(), "{exponent}: {a}, {b}: {value} {of_b:?}");
                    assert!(!slope.is_nan(), "{exponent}: {a}, {b}");
                    // The derivative, where a difference of it has enough digits.
                    let step = Quad::from_f64(1e-9 * b.abs().max(1e-9));
                    if a != b && (b - a).abs() > 1e-7 && b != 0.0 {
                        let expected = (exact(y + step) - exact(y - step)) / (step + step);
                        let off = (Quad::from_f64(slope) - expected).to_f64().abs();
                        let bound = 1e-6 * (slope.abs() + value.abs() / (b - a).abs());
                        assert!(off <= bound, "{exponent}: {a}, {b}: {slope} {expected:?}");
                    }
                }
            }
        }
    }
}
