//! The functions an expression may call: their names, values in any scalar, and derivatives.

use crate::graph::{Graph, Node};
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

impl Graph {
    /// The function of that name at x; none if there is no such function.
    pub fn call(&mut self, name: &str, x: Node) -> Option<Node> {
        let function = match name {
            "abs" => Function::Abs,
            "sqrt" => Function::Sqrt,
            "exp" => Function::Exp,
            "log" | "ln" => Function::Log,
            "sin" => Function::Sin,
            "cos" => Function::Cos,
            "tan" => {
                let (sin, cos) = (self.of(Function::Sin, x), self.of(Function::Cos, x));
                return Some(self.quotient(sin, cos));
            }
            "asin" => Function::Asin,
            "acos" => Function::Acos,
            "atan" => Function::Atan,
            "sinh" => Function::Sinh,
            "cosh" => Function::Cosh,
            "tanh" => Function::Tanh,
            _ => return None,
        };
        Some(self.of(function, x))
    }

    /// The function with jumps of that name at x; none if there is no such function.
    pub(crate) fn call_with_jumps(&mut self, name: &str, x: Node) -> Option<Node> {
        match name {
            "sign" => Some(self.of(Function::Sign, x)),
            "floor" => {
                let fraction = self.of(Function::Fraction, x);
                Some(self.difference(x, fraction))
            }
            _ => None,
        }
    }

    /// The remainder of a by b, between 0 and b; a/b for b = 0, which is not finite.
    pub fn remainder(&mut self, a: Node, b: Node) -> Node {
        let quotient = self.quotient(a, b);
        if self.is_zero(b) {
            return quotient;
        }
        let fraction = self.of(Function::Fraction, quotient);
        self.product(b, fraction)
    }

    /// The larger of two finite numbers, exactly. With d = b - a it is a (1 - sign d)/2 + b (1 +
    /// sign d)/2, in which the smaller one has the factor 0; and (d + |d|)/2 if a is 0. A number
    /// near or beyond overflow makes it, or its divided difference, NaN.
    pub fn max(&mut self, a: Node, b: Node) -> Node {
        let (a, b) = if self.is_zero(b) { (b, a) } else { (a, b) };
        let (d, half) = (self.difference(b, a), self.number(0.5));
        if self.is_zero(a) {
            let size = self.of(Function::Abs, d);
            let twice = self.sum(d, size);
            return self.product(half, twice);
        }
        let sign = self.of(Function::Sign, d);
        let shift = self.product(half, sign);
        let (of_a, of_b) = (self.difference(half, shift), self.sum(half, shift));
        let (of_a, of_b) = (self.product(of_a, a), self.product(of_b, b));
        self.sum(of_a, of_b)
    }

    /// min(a, b) = -max(-a, -b)
    pub fn min(&mut self, a: Node, b: Node) -> Node {
        let (a, b) = (self.negative(a), self.negative(b));
        let max = self.max(a, b);
        self.negative(max)
    }

    /// f'(x), given x and f(x).
    pub(crate) fn slope(&mut self, function: Function, x: Node, value: Node) -> Node {
        let one = self.number(1.0);
        match function {
            Function::Abs => self.of(Function::Sign, x),
            Function::Sign => self.number(0.0),
            Function::Fraction => one,
            Function::Sqrt => {
                let half = self.number(0.5);
                self.quotient(half, value)
            }
            Function::Exp => value,
            Function::Log => self.quotient(one, x),
            Function::Sin => self.of(Function::Cos, x),
            Function::Cos => {
                let sin = self.of(Function::Sin, x);
                self.negative(sin)
            }
            Function::Asin | Function::Acos => {
                // 1 - x² is one fused instruction with one rounding. The derivative of (1 - x)(1 +
                // x) would cancel.
                let square = self.product(x, x);
                let rest = self.difference(one, square);
                let root = self.of(Function::Sqrt, rest);
                let slope = self.quotient(one, root);
                if function == Function::Asin { slope } else { self.negative(slope) }
            }
            Function::Atan => {
                let square = self.product(x, x);
                let sum = self.sum(one, square);
                self.quotient(one, sum)
            }
            Function::Sinh => self.of(Function::Cosh, x),
            Function::Cosh => self.of(Function::Sinh, x),
            Function::Tanh => {
                // 1 - tanh² would cancel, and cosh² would overflow at |x| > 355.
                let sech = self.of(Function::Sech, x);
                self.product(sech, sech)
            }
            Function::Sech => {
                let tanh = self.of(Function::Tanh, x);
                let product = self.product(tanh, value);
                self.negative(product)
            }
            Function::Truncated(power) => {
                let [a, b, n] = power.exponent_parts().map(|part| self.number(part));
                let first = self.quotient(a, b);
                let exponent = self.difference(first, n);
                let lower = self.of(Function::Truncated(power.lower()), x);
                self.product(exponent, lower)
            }
        }
    }
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
