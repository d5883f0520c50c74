//! The functions an expression may call: their names, values in any scalar, and derivatives.

use crate::truncated_power::TruncatedPower;
use afterbay_core::{Line, Scalar, divided};

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Function {
    /// |x|
    Abs,
    /// The sign of x, -1, 0 or 1: the derivative of |x|.
    Sign,
    /// x - ⌊x⌋, of which ⌊x⌋ and remainders are made. A text cannot name it.
    Fraction,
    /// √x
    Sqrt,
    /// eˣ
    Exp,
    /// The natural logarithm.
    Log,
    /// sin x
    Sin,
    /// cos x
    Cos,
    /// The inverse sine.
    Asin,
    /// The inverse cosine.
    Acos,
    /// The inverse tangent.
    Atan,
    /// sinh x
    Sinh,
    /// cosh x
    Cosh,
    /// tanh x
    Tanh,
    /// 1/cosh x, of which the derivative of tanh is the square. A text cannot name it.
    Sech,
    /// A power of max(x, 0). A text cannot name it.
    Truncated(TruncatedPower),
}

/// The functions of two numbers that a text may call, with what they are.
pub const FUNCTIONS_OF_TWO: [(&str, &str); 3] = [
    ("min", "the smaller of two numbers"),
    ("max", "the larger of two numbers"),
    ("mod", "the remainder x - y floor(x/y), of the time in a drive"),
];

/// The functions of one number that jump, with what they are.
pub const FUNCTIONS_WITH_JUMPS: [(&str, &str); 2] = [
    ("sign", "the sign, -1, 0 or 1, of a function of the time in a drive"),
    ("floor", "the largest whole number not above x, where x depends on the time in a drive"),
];

/// The functions of one number that a text may call, with what they are.
pub const FUNCTIONS: [(&str, &str); 14] = [
    ("abs", "the absolute value"),
    ("sqrt", "the square root"),
    ("exp", "the exponential function"),
    ("log", "the natural logarithm"),
    ("ln", "the natural logarithm"),
    ("sin", "the sine"),
    ("cos", "the cosine"),
    ("tan", "the tangent, the quotient of sine and cosine"),
    ("asin", "the inverse sine"),
    ("acos", "the inverse cosine"),
    ("atan", "the inverse tangent"),
    ("sinh", "the hyperbolic sine"),
    ("cosh", "the hyperbolic cosine"),
    ("tanh", "the hyperbolic tangent"),
];

/// The names of all functions.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|function| function.0)
}

impl Function {
    /// f(x), from the operations of [`Scalar`], without cancellation.
    #[inline]
    pub fn at<T: Scalar>(self, x: T) -> T {
        let (zero, one) = (T::zero(), T::one());
        match self {
            Self::Abs => x.abs(),
            Self::Sign => T::select(x.lt(zero), -one, T::select(zero.lt(x), one, x * zero)),
            Self::Fraction => x - x.floor(),
            Self::Sqrt => x.sqrt(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Sech => {
                let e = (-x.abs()).exp();
                (e + e) / e.mul_add(e, one)
            }
            Self::Tanh => x.tanh(),
            Self::Truncated(power) => power.at(x),
        }
    }

    /// f[a, b] and its derivative by b, without cancellation for any b - a.
    #[inline]
    pub fn divided<T: Scalar>(self, a: T, b: T) -> Line<T> {
        match self {
            Self::Abs => divided::abs(a, b),
            Self::Sqrt => divided::sqrt(a.sqrt(), b.sqrt()),
            Self::Exp => divided::exp(a, b),
            Self::Log => divided::ln(a, b),
            Self::Sin => divided::sin(a, b),
            Self::Cos => divided::cos(a, b),
            Self::Asin => divided::asin(a, b),
            Self::Acos => divided::acos(a, b),
            Self::Atan => divided::atan(a, b),
            Self::Sinh => divided::sinh(a, b),
            Self::Cosh => divided::cosh(a, b),
            Self::Tanh => divided::tanh(a, b),
            Self::Truncated(power) => power.divided(a, b),
            Self::Sign => {
                let still = (b - a).abs().le(T::zero());
                let run = T::select(still, T::one(), b - a);
                let value = (self.at(b) - self.at(a)) / run;
                Line { value, slope: -value / run }
            }
            // No potential contains these: a plain quotient will do.
            Self::Fraction | Self::Sech => {
                let still = (b - a).abs().le(T::zero());
                let rise = (self.at(b) - self.at(a)) / T::select(still, T::one(), b - a);
                Line { value: rise, slope: T::zero() }
            }
        }
    }
}
