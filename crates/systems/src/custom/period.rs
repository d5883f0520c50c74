//! The periods of coordinates and of the time: functions are periodic in an input that occurs only
//! in sines, cosines and fractional parts of frequencies that are multiples of one. A sine changes
//! its sign after half a period, so that its square has half the period. A potential may have a
//! term that is linear in a coordinate as well: its force is constant, as that of a torque.

use super::Custom;
use afterbay_expression::{Function, Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

/// The dependence of a term on one input, a coordinate or the time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Dependence {
    /// It does not depend on the input.
    Constant,
    /// It is the input times this number, plus a term without the input.
    Affine(f64),
    /// It is periodic with this angular frequency.
    Periodic(f64),
    /// It is periodic with this angular frequency, and changes its sign after half a period.
    Alternating(f64),
    /// It is periodic with this angular frequency but for a multiple of the input.
    Tilted(f64),
    /// Any other dependence.
    Other,
}

/// The largest relative deviation of the ratio of two frequencies from a whole number. A choice:
/// some thousand roundings.
const WHOLE_RATIO_TOLERANCE: f64 = 1e-12;

impl Dependence {
    /// The dependence of any function of two terms.
    fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Constant, x) | (x, Self::Constant) => match x {
                Self::Affine(_) | Self::Tilted(_) => Self::Other,
                Self::Alternating(frequency) => Self::Periodic(frequency),
                x => x,
            },
            (a, b) => common(a, b).map_or(Self::Other, |(base, _)| Self::Periodic(base)),
        }
    }

    /// The dependence of a product or a quotient of two terms that depend on the input.
    fn product(self, other: Self) -> Self {
        let alternate = [self, other].iter().all(|x| matches!(x, Self::Alternating(_)));
        match common(self, other) {
            // Half a period of the base is this number of half periods of each factor.
            Some((base, halves)) if alternate => {
                let stays = (halves[0] + halves[1]) % 2.0 == 0.0;
                if stays { Self::Periodic(2.0 * base) } else { Self::Alternating(base) }
            }
            Some((base, _)) => Self::Periodic(base),
            None => Self::Other,
        }
    }

    /// The dependence of a function of a term.
    fn under(self, function: Function) -> Self {
        match (function, self) {
            (Function::Sin | Function::Cos, Self::Affine(rate)) => Self::Alternating(rate.abs()),
            (Function::Fraction, Self::Affine(rate)) => {
                Self::Periodic(std::f64::consts::TAU * rate.abs())
            }
            (_, Self::Affine(_) | Self::Tilted(_)) => Self::Other,
            (
                Function::Abs | Function::Cos | Function::Cosh | Function::Sech,
                Self::Alternating(f),
            ) => Self::Periodic(2.0 * f),
            (
                Function::Sign
                | Function::Sin
                | Function::Asin
                | Function::Atan
                | Function::Sinh
                | Function::Tanh,
                Self::Alternating(f),
            ) => Self::Alternating(f),
            (_, Self::Alternating(frequency)) => Self::Periodic(frequency),
            (_, course) => course,
        }
    }

    /// The dependence of a + sign b.
    fn plus(self, other: Self, sign: f64) -> Self {
        match (self, other) {
            (Self::Constant, Self::Constant) => Self::Constant,
            (Self::Affine(a), Self::Affine(b)) => Self::affine(a + sign * b),
            (Self::Affine(a), Self::Constant) => Self::Affine(a),
            (Self::Constant, Self::Affine(b)) => Self::Affine(sign * b),
            (Self::Tilted(f), Self::Constant | Self::Affine(_))
            | (Self::Constant | Self::Affine(_), Self::Tilted(f))
            | (Self::Affine(_), Self::Periodic(f) | Self::Alternating(f))
            | (Self::Periodic(f) | Self::Alternating(f), Self::Affine(_)) => Self::Tilted(f),
            (Self::Tilted(a), b) | (b, Self::Tilted(a)) => {
                let both = common(Self::Periodic(a), b.level());
                both.map_or(Self::Other, |(base, _)| Self::Tilted(base))
            }
            (Self::Alternating(_), Self::Alternating(_)) => match common(self, other) {
                Some((base, [a, b])) if a % 2.0 == 1.0 && b % 2.0 == 1.0 => Self::Alternating(base),
                _ => self.with(other),
            },
            _ => self.with(other),
        }
    }

    /// The dependence without a multiple of the input.
    fn level(self) -> Self {
        match self {
            Self::Affine(_) => Self::Constant,
            Self::Tilted(frequency) => Self::Periodic(frequency),
            other => other,
        }
    }

    fn affine(rate: f64) -> Self {
        if rate == 0.0 { Self::Constant } else { Self::Affine(rate) }
    }

    /// The dependence of the term times a factor, which is a number if it is known.
    fn times(self, number: Option<f64>) -> Self {
        match (self, number) {
            (Self::Affine(rate), Some(number)) => Self::affine(rate * number),
            (Self::Affine(_) | Self::Tilted(_), None) => Self::Other,
            _ => self,
        }
    }
}

/// The highest frequency of which those of two periodic terms are multiples, and these multiples.
fn common(a: Dependence, b: Dependence) -> Option<(f64, [f64; 2])> {
    use Dependence::{Alternating, Periodic};
    let (Periodic(a) | Alternating(a)) = a else { return None };
    let (Periodic(b) | Alternating(b)) = b else { return None };
    let low = a.min(b);
    let multiples = whole_multiples(a.max(b) / low, WHOLE_RATIO_TOLERANCE)?;
    Some((low / multiples[0], multiples))
}

/// The least whole numbers m and n with n/m equal to a ratio that is at least 1. Frequencies in
/// this ratio are m and n times one; m times the longer period is n times the shorter. None if m
/// would be above twelve, a choice.
pub fn whole_multiples(ratio: f64, tolerance: f64) -> Option<[f64; 2]> {
    (1..=12).map(f64::from).find_map(|m| {
        let n = (m * ratio).round();
        ((m * ratio - n).abs() <= tolerance * n).then_some([m, n])
    })
}

impl Custom<f64> {
    /// The period of each coordinate, in its unit, if the form shows one: all ∂V/∂q_i and D_i are
    /// the same at q_j and at q_j plus the period. q_j then occurs only in sines and cosines of
    /// linear forms, whose frequencies are multiples of one. V may contain a multiple of q_j as
    /// well.
    pub fn periods(&self) -> Vec<Option<f64>> {
        let shape = &self.shape;
        periods(&shape.graph, &shape.fields, shape.dof, &self.parameters)
    }
}

/// The period of each coordinate in these functions of (q, p, v), the first of which is V or H.
pub(super) fn periods(
    graph: &Graph,
    roots: &[Node],
    dof: usize,
    parameters: &[f64],
) -> Vec<Option<f64>> {
    let nodes = graph.all(roots);
    let circular =
        |node: &Node| matches!(graph.term(*node), Term::Of(Function::Sin | Function::Cos, _));
    if !nodes.iter().any(circular) {
        return vec![None; dof];
    }
    let closed: Vec<Node> = nodes.iter().copied().filter(|&x| graph.closed(x)).collect();
    let numbers = graph.evaluate(&closed, parameters, &|_| 0.0);
    let moving = graph.cone(roots, Kinds::COORDINATES);
    let by = |j| Input::Coordinate(j as u32);
    let period_by = |j| {
        let mut all = dependences(graph, roots, by(j), &moving, &numbers);
        // The force of a multiple of a coordinate is constant. So is the power of a multiple of the
        // time, which is the last coordinate of a system with a clock.
        all[0] = all[0].level();
        period(all)
    };
    (0..dof).map(period_by).collect()
}

/// The period of these functions in t, which is the end of an edge in them.
pub(super) fn in_time(graph: &Graph, roots: &[Node], parameters: &[f64]) -> Option<f64> {
    let nodes = graph.all(roots);
    let closed: Vec<Node> = nodes.iter().copied().filter(|&x| graph.closed(x)).collect();
    let numbers = graph.evaluate(&closed, parameters, &|_| 0.0);
    period(dependences(graph, roots, Input::End, &graph.cone(roots, Kinds::END), &numbers))
}

/// The dependence of each root on an input.
fn dependences(
    graph: &Graph,
    roots: &[Node],
    by: Input,
    nodes: &[Node],
    numbers: &HashMap<Node, f64>,
) -> Vec<Dependence> {
    let mut courses: HashMap<Node, Dependence> = HashMap::with_capacity(nodes.len());
    for &node in nodes {
        let at = |x: Node| courses.get(&x).copied().unwrap_or(Dependence::Constant);
        let number = |x: Node| numbers.get(&x).copied();
        let course = match graph.term(node) {
            Term::Input(input) if input == by => Dependence::Affine(1.0),
            Term::Negative(a) => at(a).times(Some(-1.0)),
            Term::Sum(a, b) => at(a).plus(at(b), 1.0),
            Term::Difference(a, b) => at(a).plus(at(b), -1.0),
            Term::Product(a, b) => match (at(a), at(b)) {
                (a, Dependence::Constant) => a.times(number(b)),
                (Dependence::Constant, b) => b.times(number(a)),
                (a, b) => a.product(b),
            },
            Term::Quotient(a, b) => match (at(a), at(b)) {
                (a, Dependence::Constant) => a.times(number(b).map(f64::recip)),
                (Dependence::Constant, Dependence::Affine(_) | Dependence::Tilted(_)) => {
                    Dependence::Other
                }
                (Dependence::Constant, b) => b,
                (a, b) => a.product(b),
            },
            Term::Of(function, a) => at(a).under(function),
            Term::Constant(_) | Term::Pi | Term::Parameter(_) | Term::Input(_) => {
                Dependence::Constant
            }
            // V and D_j contain no divided differences.
            term @ (Term::Divided(..) | Term::DividedDerivative(..)) => {
                let still = term.operands().all(|x| at(x) == Dependence::Constant);
                if still { Dependence::Constant } else { Dependence::Other }
            }
        };
        courses.insert(node, course);
    }
    roots.iter().map(|root| courses.get(root).copied().unwrap_or(Dependence::Constant)).collect()
}

/// The period of functions with these dependences.
fn period(all: Vec<Dependence>) -> Option<f64> {
    use Dependence::{Affine, Alternating, Constant, Other, Periodic, Tilted};
    match all.into_iter().fold(Constant, Dependence::with) {
        Periodic(frequency) | Alternating(frequency) => Some(std::f64::consts::TAU / frequency),
        Constant | Affine(_) | Tilted(_) | Other => None,
    }
}
