//! New terms of a graph, simplified where that is exact.
//!
//! Exact for finite numbers are x + 0, x - x, x·1, x·0, √(x x) and changes of sign, and factors
//! that are powers of two, which move out of products. Constants are folded only where the result
//! is exact: 1/3 is computed in the scalar the expression is evaluated in.

use crate::function::Function;
use crate::graph::{Graph, Input, Node, Term};
use crate::truncated_power::TruncatedPower;

impl Graph {
    /// The constant x.
    pub fn number(&mut self, x: f64) -> Node {
        // -0 and 0 become one node.
        self.insert(Term::Constant((x + 0.0).to_bits()))
    }

    /// π
    pub fn pi(&mut self) -> Node {
        self.insert(Term::Pi)
    }

    /// The parameter of this index.
    pub fn parameter(&mut self, index: u32) -> Node {
        self.insert(Term::Parameter(index))
    }

    /// An input.
    pub fn input(&mut self, input: Input) -> Node {
        self.insert(Term::Input(input))
    }

    /// φ(x)
    pub fn of(&mut self, function: Function, x: Node) -> Node {
        match (function, self.term(x)) {
            // √(a²) = |a|: at a = 0 its derivative is a sign, where that of the root would be 0/0.
            (Function::Sqrt, Term::Product(a, b)) if a == b => {
                self.insert(Term::Of(Function::Abs, a))
            }
            (Function::Sqrt, _) => match self.truncated_power(x, TruncatedPower::new([1.0, 2.0])) {
                Some(power) => power,
                None => self.insert(Term::Of(function, x)),
            },
            _ => self.insert(Term::Of(function, x)),
        }
    }

    /// φ[a, b]
    pub(crate) fn divided(&mut self, function: Function, a: Node, b: Node) -> Node {
        self.insert(Term::Divided(function, a, b))
    }

    /// The derivative of φ[a, b] by b. A program computes it with φ[a, b], which is added too.
    pub(crate) fn divided_derivative(&mut self, function: Function, a: Node, b: Node) -> Node {
        self.insert(Term::Divided(function, a, b));
        self.insert(Term::DividedDerivative(function, a, b))
    }

    /// -a
    pub fn negative(&mut self, a: Node) -> Node {
        match self.term(a) {
            Term::Constant(bits) => self.number(-f64::from_bits(bits)),
            Term::Negative(b) => b,
            Term::Difference(b, c) => self.difference(c, b),
            Term::Product(b, c) if self.constant(b).is_some() => {
                let b = self.negative(b);
                self.product(b, c)
            }
            _ => self.insert(Term::Negative(a)),
        }
    }

    /// a + b
    pub fn sum(&mut self, a: Node, b: Node) -> Node {
        if let (Some(x), Some(y)) = (self.constant(a), self.constant(b)) {
            let sum = x + y;
            let back = sum - x;
            if sum.is_finite() && (x - (sum - back)) + (y - back) == 0.0 {
                return self.number(sum);
            }
        }
        match (self.term(a), self.term(b)) {
            _ if self.is_zero(a) => b,
            _ if self.is_zero(b) => a,
            _ if a == b => {
                let two = self.number(2.0);
                self.product(two, a)
            }
            (_, Term::Negative(b)) => self.difference(a, b),
            (Term::Negative(a), _) => self.difference(b, a),
            _ => self.insert(Term::Sum(a.min(b), a.max(b))),
        }
    }

    /// a - b
    pub fn difference(&mut self, a: Node, b: Node) -> Node {
        match (self.term(a), self.term(b)) {
            _ if a == b => self.number(0.0),
            _ if self.is_zero(b) => a,
            _ if self.is_zero(a) => self.negative(b),
            (_, Term::Constant(_)) if self.constant(a).is_some() => {
                let b = self.negative(b);
                self.sum(a, b)
            }
            (_, Term::Negative(b)) => self.sum(a, b),
            (Term::Negative(a), _) => {
                let sum = self.sum(a, b);
                self.negative(sum)
            }
            _ => self.insert(Term::Difference(a, b)),
        }
    }

    /// a b
    pub fn product(&mut self, a: Node, b: Node) -> Node {
        let (a, b) = if self.first(b, a) { (b, a) } else { (a, b) };
        if let (Some(x), Some(y)) = (self.constant(a), self.constant(b))
            && let Some(product) = exact_product(x, y)
        {
            return self.number(product);
        }
        let scale = self.constant(a);
        match (self.term(a), self.term(b)) {
            _ if scale == Some(0.0) => a,
            _ if scale == Some(1.0) => b,
            _ if scale == Some(-1.0) => self.negative(b),
            (Term::Negative(a), _) => {
                let product = self.product(a, b);
                self.negative(product)
            }
            (_, Term::Negative(b)) => {
                let product = self.product(a, b);
                self.negative(product)
            }
            // 2ᵏ (c x) = (2ᵏ c) x
            (_, Term::Product(c, x)) if scale.is_some_and(power_of_two) && self.closed(c) => {
                let factor = self.product(a, c);
                // The product of the two numbers is not exact.
                if self.constant(c).is_some() && self.constant(factor).is_none() {
                    return self.insert(Term::Product(a, b));
                }
                self.product(factor, x)
            }
            // a (2ᵏ x) = 2ᵏ (a x)
            (_, Term::Product(c, x)) if self.scales(c) && !self.closed(b) => {
                let product = self.product(a, x);
                self.product(c, product)
            }
            (Term::Product(c, x), _) if self.scales(c) && !self.closed(a) => {
                let product = self.product(x, b);
                self.product(c, product)
            }
            _ => self.insert(Term::Product(a, b)),
        }
    }

    /// The order of the factors of a product: constants, other closed nodes, then the older node.
    fn first(&self, a: Node, b: Node) -> bool {
        let key = |x: Node| (self.constant(x).is_none(), !self.closed(x), x);
        key(a) < key(b)
    }

    fn scales(&self, node: Node) -> bool {
        self.constant(node).is_some_and(power_of_two)
    }

    /// a/b
    pub fn quotient(&mut self, a: Node, b: Node) -> Node {
        if let Some(y) = self.constant(b).filter(|&y| y != 0.0) {
            if power_of_two(y) {
                let inverse = self.number(y.recip());
                return self.product(a, inverse);
            }
            if let Some(x) = self.constant(a)
                && let Some(quotient) = exact_quotient(x, y)
            {
                return self.number(quotient);
            }
        }
        match (self.term(a), self.term(b)) {
            (Term::Negative(a), _) => {
                let quotient = self.quotient(a, b);
                self.negative(quotient)
            }
            (_, Term::Negative(b)) => {
                let quotient = self.quotient(a, b);
                self.negative(quotient)
            }
            (Term::Product(c, x), _) if self.scales(c) => {
                let quotient = self.quotient(x, b);
                self.product(c, quotient)
            }
            _ => self.insert(Term::Quotient(a, b)),
        }
    }

    /// a^b: by repeated squaring where b is a whole number, with a square root where 2b is one, and
    /// as e^(b ln a) otherwise. Powers of max(x, 0) and |x| are truncated powers, which have
    /// derivatives at 0.
    pub fn power(&mut self, a: Node, b: Node) -> Node {
        let truncated = self.fraction(b).and_then(TruncatedPower::new);
        if let Some(power) = self.truncated_power(a, truncated) {
            return power;
        }
        if let (Term::Of(Function::Abs, x), Some(power)) = (self.term(a), truncated)
            && power.exponent::<f64>() > 1.0
        {
            let opposite = self.negative(x);
            let sides = [x, opposite].map(|x| self.of(Function::Truncated(power), x));
            return self.sum(sides[0], sides[1]);
        }
        match self.constant(b) {
            Some(exponent)
                if exponent.abs() <= LARGEST_POWER && (2.0 * exponent).fract() == 0.0 =>
            {
                let size = exponent.abs();
                let mut power = self.whole_power(a, size.trunc() as u64);
                if size.fract() != 0.0 {
                    let root = self.of(Function::Sqrt, a);
                    power = self.product(power, root);
                }
                if exponent < 0.0 {
                    let one = self.number(1.0);
                    power = self.quotient(one, power);
                }
                power
            }
            _ => {
                let log = self.of(Function::Log, a);
                let exponent = self.product(b, log);
                self.of(Function::Exp, exponent)
            }
        }
    }

    /// A constant, or a quotient of two, as the quotient of two numbers.
    fn fraction(&self, node: Node) -> Option<[f64; 2]> {
        match self.term(node) {
            Term::Quotient(a, b) => Some([self.constant(a)?, self.constant(b)?]),
            _ => Some([self.constant(node)?, 1.0]),
        }
    }

    /// a to a power as a truncated power, if a is max(x, 0).
    fn truncated_power(&mut self, a: Node, power: Option<TruncatedPower>) -> Option<Node> {
        let (x, power) = (self.of_positive_part(a)?, power?);
        Some(self.of(Function::Truncated(power), x))
    }

    /// x of a node that is max(x, 0) = (x + |x|)/2 ([`Graph::max`]).
    fn of_positive_part(&self, node: Node) -> Option<Node> {
        let Term::Product(half, twice) = self.term(node) else { return None };
        let size = |node: Node| match self.term(node) {
            Term::Of(Function::Abs, x) => Some(x),
            _ => None,
        };
        let x = match self.term(twice) {
            Term::Sum(a, b) => [(a, b), (b, a)].into_iter().find(|&(a, b)| size(a) == Some(b))?.1,
            // (-y) + |-y|
            Term::Difference(a, y) => size(a).filter(|&x| self.term(x) == Term::Negative(y))?,
            _ => return None,
        };
        (self.constant(half) == Some(0.5)).then_some(x)
    }

    fn whole_power(&mut self, a: Node, n: u64) -> Node {
        let mut power = self.number(1.0);
        for bit in (0..u64::BITS - n.leading_zeros()).rev() {
            power = self.product(power, power);
            if n >> bit & 1 == 1 {
                power = self.product(power, a);
            }
        }
        power
    }
}

/// The largest exponent that is treated as a whole number. Every f64 above 2⁵³ ≈ 9e15 is even, and
/// the power of any number but ±1 is 0 or infinite there.
const LARGEST_POWER: f64 = 9e15;

/// Below this size the remainder of a product or quotient may underflow: 2⁻⁵³ of it nears the
/// smallest normal f64, 2e-308.
const SMALLEST: f64 = 1e-290;

/// Whether x is ±2ᵏ, so that a product with it is exact.
fn power_of_two(x: f64) -> bool {
    x.is_normal() && x.to_bits() << 12 == 0
}

/// x y, if that has no rounding error.
fn exact_product(x: f64, y: f64) -> Option<f64> {
    let product = x * y;
    let large = product.abs() > SMALLEST || x == 0.0 || y == 0.0;
    (product.is_finite() && large && x.mul_add(y, -product) == 0.0).then_some(product)
}

/// x/y, if that has no rounding error.
fn exact_quotient(x: f64, y: f64) -> Option<f64> {
    let quotient = x / y;
    let large = quotient.abs() > SMALLEST && x.abs() > SMALLEST || x == 0.0;
    (quotient.is_finite() && large && quotient.mul_add(y, -x) == 0.0).then_some(quotient)
}
