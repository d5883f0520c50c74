//! Calls of functions, as nodes of a graph.

use crate::function::Function;
use crate::graph::{Graph, Node};

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
