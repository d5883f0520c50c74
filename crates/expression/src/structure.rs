//! Properties that the form of an expression shows: degrees, signs, summands, and points where it
//! is not analytic.

use crate::function::Function;
use crate::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::{HashMap, HashSet};

/// The least and the largest degree of the monomials of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degrees {
    /// The least degree.
    pub least: u32,
    /// The largest degree.
    pub most: u32,
}

impl Degrees {
    const NONE: Self = Self { least: 0, most: 0 };

    /// Whether all monomials have this degree.
    pub fn are(self, degree: u32) -> bool {
        self.least == degree && self.most == degree
    }

    fn plus(self, other: Self) -> Self {
        let least = self.least.saturating_add(other.least);
        Self { least, most: self.most.saturating_add(other.most) }
    }

    fn or(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }
}

impl Graph {
    /// The degrees of a node as a polynomial in the inputs of these kinds, if it is one. It may
    /// depend on other inputs in any way. The constant 0 has degree 0.
    pub fn degrees(&self, of: Node, kinds: Kinds) -> Option<Degrees> {
        self.degrees_in(of, kinds, |_| true)
    }

    /// The degrees of a node as a polynomial in one input, if it is one.
    pub fn degrees_by(&self, of: Node, by: Input) -> Option<Degrees> {
        self.degrees_in(of, Kinds::ALL, |input| input == by)
    }

    fn degrees_in(
        &self,
        of: Node,
        kinds: Kinds,
        counts: impl Fn(Input) -> bool,
    ) -> Option<Degrees> {
        let mut degrees: HashMap<Node, Option<Degrees>> = HashMap::new();
        for node in self.cone(&[of], kinds) {
            let at = |x: Node| degrees.get(&x).copied().unwrap_or(Some(Degrees::NONE));
            let constant = |x: Node| at(x) == Some(Degrees::NONE);
            let found = match self.term(node) {
                Term::Input(input) if counts(input) => Some(Degrees { least: 1, most: 1 }),
                Term::Negative(a) => at(a),
                Term::Sum(a, b) | Term::Difference(a, b) => at(a).zip(at(b)).map(|(a, b)| a.or(b)),
                Term::Product(a, b) => at(a).zip(at(b)).map(|(a, b)| a.plus(b)),
                Term::Quotient(a, b) if constant(b) => at(a),
                Term::Quotient(..) => None,
                Term::Of(_, a) if !constant(a) => None,
                Term::Divided(_, a, b) | Term::DividedDerivative(_, a, b)
                    if !(constant(a) && constant(b)) =>
                {
                    None
                }
                _ => Some(Degrees::NONE),
            };
            degrees.insert(node, found);
        }
        degrees.get(&of).copied().unwrap_or(Some(Degrees::NONE))
    }

    /// The terms whose sum the node is, with their signs. Closed factors of sums are distributed.
    pub fn summands(&mut self, of: Node) -> Vec<Node> {
        let one = self.number(1.0);
        let (mut summands, mut stack) = (Vec::new(), vec![(of, one)]);
        while let Some((node, factor)) = stack.pop() {
            match self.term(node) {
                Term::Sum(a, b) => stack.extend([(b, factor), (a, factor)]),
                Term::Difference(a, b) => stack.extend([(b, self.negative(factor)), (a, factor)]),
                Term::Negative(a) => stack.push((a, self.negative(factor))),
                Term::Product(c, a) if self.closed(c) && self.is_sum(a) => {
                    stack.push((a, self.product(factor, c)));
                }
                Term::Quotient(a, c) if self.closed(c) && self.is_sum(a) => {
                    stack.push((a, self.quotient(factor, c)));
                }
                _ if self.is_zero(node) => {}
                _ => summands.push(self.product(factor, node)),
            }
        }
        summands
    }

    /// Whether the node is a sum or a difference.
    fn is_sum(&self, node: Node) -> bool {
        matches!(self.term(node), Term::Sum(..) | Term::Difference(..))
    }

    /// The functions at whose zeros `of` may not be analytic: x of |x|, √x, ln x and powers of
    /// max(x, 0), and x - ⌊x⌋ and x - ⌊x⌋ - 1 of ⌊x⌋. Where x is constant between jumps, as in
    /// |⌊t⌋|, they are left out: it then changes at those jumps alone, and may be 0 all along.
    pub fn kinks(&mut self, of: &[Node]) -> Vec<Node> {
        let one = self.number(1.0);
        let cone = self.cone(of, Kinds::ALL);
        let levels = self.levels(&cone);
        let mut kinks = Vec::new();
        for node in cone {
            match self.term(node) {
                Term::Of(_, x) if levels.contains(&x) => {}
                Term::Of(
                    Function::Abs
                    | Function::Sign
                    | Function::Sqrt
                    | Function::Log
                    | Function::Truncated(_),
                    x,
                ) => kinks.push(x),
                Term::Of(Function::Fraction, _) => {
                    kinks.extend([node, self.difference(node, one)]);
                }
                _ => {}
            }
        }
        kinks.sort_unstable();
        kinks.dedup();
        kinks
    }

    /// The nodes among these that are constant between jumps: ⌊x⌋, signs, and functions of these
    /// two. The operands of a node must come before it.
    fn levels(&self, nodes: &[Node]) -> HashSet<Node> {
        let mut levels = HashSet::new();
        for &node in nodes {
            let term = self.term(node);
            let jumps = match term {
                Term::Of(Function::Sign, _) => true,
                Term::Difference(x, fraction) => {
                    self.term(fraction) == Term::Of(Function::Fraction, x)
                }
                _ => false,
            };
            let is_level = |x: Node| self.closed(x) || levels.contains(&x);
            let is_input = matches!(term, Term::Input(_));
            if jumps || (!is_input && term.operands().all(is_level)) {
                levels.insert(node);
            }
        }
        levels
    }

    /// The functions at whose zeros `of` may be singular: divisors, and x of ln x.
    pub fn poles(&self, of: &[Node]) -> Vec<Node> {
        let mut poles: Vec<Node> = self
            .cone(of, Kinds::ALL)
            .into_iter()
            .filter_map(|node| match self.term(node) {
                Term::Quotient(_, x) | Term::Of(Function::Log, x) => Some(x),
                _ => None,
            })
            .collect();
        poles.sort_unstable();
        poles.dedup();
        poles
    }

    /// The sign of a node, by its form. It may be relative to the sign of the input `beside`;
    /// `closed` gives the signs of closed nodes.
    pub fn sign(&self, of: Node, beside: Input, closed: &dyn Fn(Node) -> Sign) -> Sign {
        let mut signs: HashMap<Node, Sign> = HashMap::new();
        let cone = self.cone(&[of], Kinds::ALL);
        for node in cone {
            let at = |x: Node| {
                if self.closed(x) {
                    closed(x)
                } else {
                    signs.get(&x).copied().unwrap_or(Sign::Unknown)
                }
            };
            let sign = match self.term(node) {
                Term::Input(input) if input == beside => Sign::Along,
                Term::Negative(a) => at(a).opposite(),
                Term::Sum(a, b) => at(a).plus(at(b)),
                Term::Difference(a, b) => at(a).plus(at(b).opposite()),
                Term::Product(a, b) if a == b && at(a) != Sign::Zero => Sign::NotNegative,
                Term::Product(a, b) => at(a).times(at(b)),
                // A quotient by 0 is not a number, so that a divisor of one sign is taken for
                // nonzero.
                Term::Quotient(a, b) if at(b) != Sign::Zero => at(a).times(at(b)),
                Term::Of(function, a) => at(a).under(function),
                _ => Sign::Unknown,
            };
            signs.insert(node, sign);
        }
        if self.closed(of) { closed(of) } else { signs.get(&of).copied().unwrap_or(Sign::Unknown) }
    }
}

/// The sign of a node at every state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// = 0
    Zero,
    /// ≥ 0
    NotNegative,
    /// ≤ 0
    NotPositive,
    /// Its product with the input it is compared with is ≥ 0.
    Along,
    /// Its product with that input is ≤ 0.
    Against,
    /// The form does not show its sign.
    Unknown,
}

impl Sign {
    fn opposite(self) -> Self {
        match self {
            Self::NotNegative => Self::NotPositive,
            Self::NotPositive => Self::NotNegative,
            Self::Along => Self::Against,
            Self::Against => Self::Along,
            Self::Zero | Self::Unknown => self,
        }
    }

    fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Zero, sign) | (sign, Self::Zero) => sign,
            (a, b) if a == b => a,
            _ => Self::Unknown,
        }
    }

    fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Zero, _) | (_, Self::Zero) => Self::Zero,
            (Self::Unknown, _) | (_, Self::Unknown) => Self::Unknown,
            (Self::NotNegative, sign) | (sign, Self::NotNegative) => sign,
            (Self::NotPositive, sign) | (sign, Self::NotPositive) => sign.opposite(),
            (a, b) if a == b => Self::NotNegative,
            _ => Self::NotPositive,
        }
    }

    /// The sign of the function at a number of this sign.
    fn under(self, function: Function) -> Self {
        match function {
            Function::Abs if self == Self::Zero => Self::Zero,
            Function::Abs
            | Function::Sqrt
            | Function::Exp
            | Function::Cosh
            | Function::Sech
            | Function::Acos
            | Function::Fraction
            | Function::Truncated(_) => Self::NotNegative,
            // Odd and increasing functions.
            Function::Sign | Function::Sinh | Function::Tanh | Function::Asin | Function::Atan => {
                self
            }
            Function::Log | Function::Sin | Function::Cos => Self::Unknown,
        }
    }
}
