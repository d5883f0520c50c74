//! What follows from the form of an expression alone: degrees, signs, and where it is not analytic.

use super::function::Function;
use super::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

/// The least and the largest degree of the monomials of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Degrees {
    pub(crate) least: u32,
    pub(crate) most: u32,
}

impl Degrees {
    const NONE: Self = Self { least: 0, most: 0 };

    /// Are all monomials of this degree?
    pub(crate) fn are(self, degree: u32) -> bool {
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
    /// The degrees of a node as a polynomial in the inputs of these kinds, if it is one; what else there is may be any function. The zero
    /// has degree 0.
    pub(crate) fn degrees(&self, of: Node, kinds: Kinds) -> Option<Degrees> {
        self.degrees_in(of, kinds, |_| true)
    }

    /// The same in one input.
    pub(crate) fn degrees_by(&self, of: Node, by: Input) -> Option<Degrees> {
        self.degrees_in(of, Kinds::ALL, |input| input == by)
    }

    fn degrees_in(&self, of: Node, kinds: Kinds, counts: impl Fn(Input) -> bool) -> Option<Degrees> {
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
                Term::Divided(_, a, b) | Term::Bend(_, a, b) if !(constant(a) && constant(b)) => None,
                _ => Some(Degrees::NONE),
            };
            degrees.insert(node, found);
        }
        degrees.get(&of).copied().unwrap_or(Some(Degrees::NONE))
    }

    /// The nodes between whose zeros the others are analytic: x of |x|, √x and ln x.
    pub(crate) fn kinks(&self, of: &[Node]) -> Vec<Node> {
        let mut kinks: Vec<Node> = self
            .cone(of, Kinds::ALL)
            .into_iter()
            .filter_map(|node| match self.term(node) {
                Term::Of(Function::Abs | Function::Sign | Function::Sqrt | Function::Log, x) => Some(x),
                _ => None,
            })
            .collect();
        kinks.sort_unstable();
        kinks.dedup();
        kinks
    }

    /// The sign of a node beside that of one input, given what is known of the closed nodes.
    pub(crate) fn sign(&self, of: Node, beside: Input, closed: impl Fn(Node) -> Sign) -> Sign {
        let mut signs: HashMap<Node, Sign> = HashMap::new();
        let cone = self.cone(&[of], Kinds::ALL);
        for node in cone {
            let at = |x: Node| {
                if self.closed(x) { closed(x) } else { signs.get(&x).copied().unwrap_or(Sign::Unknown) }
            };
            let sign = match self.term(node) {
                Term::Input(input) if input == beside => Sign::Along,
                Term::Negative(a) => at(a).opposite(),
                Term::Sum(a, b) => at(a).plus(at(b)),
                Term::Difference(a, b) => at(a).plus(at(b).opposite()),
                Term::Product(a, b) if a == b && at(a) != Sign::Zero => Sign::NotNegative,
                Term::Product(a, b) => at(a).times(at(b)),
                // Where the divisor is 0 there is no number.
                Term::Quotient(a, b) if at(b) != Sign::Zero => at(a).times(at(b)),
                Term::Of(function, a) => at(a).under(function),
                _ => Sign::Unknown,
            };
            signs.insert(node, sign);
        }
        if self.closed(of) { closed(of) } else { signs.get(&of).copied().unwrap_or(Sign::Unknown) }
    }
}

/// The sign of a number for all states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    Zero,
    NotNegative,
    NotPositive,
    /// Not of the other sign than a number it is compared with.
    Along,
    /// Not of the same sign as that.
    Against,
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

    /// Of a function of it.
    fn under(self, function: Function) -> Self {
        match function {
            Function::Abs if self == Self::Zero => Self::Zero,
            Function::Abs
            | Function::Sqrt
            | Function::Exp
            | Function::Cosh
            | Function::Sech
            | Function::Acos => Self::NotNegative,
            // Odd, and monotone.
            Function::Sign | Function::Sinh | Function::Tanh | Function::Asin | Function::Atan => self,
            Function::Log | Function::Sin | Function::Cos => Self::Unknown,
        }
    }
}
