//! After which length of a coordinate V and D recur: they do where the coordinate occurs in sines
//! and cosines of one frequency, or of its multiples, alone.

use super::Custom;
use afterbay_expression::{Function, Input, Kinds, Node, Term};
use std::collections::HashMap;

/// How a term depends on one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Course {
    /// Not at all.
    Still,
    /// It is the coordinate times a number, and what does not depend on it.
    Affine(f64),
    /// It recurs with this angular frequency.
    Recurs(f64),
    /// In another way.
    Other,
}

/// Two frequencies are in a whole ratio if they are within this share of it.
const WHOLE: f64 = 1e-12;

impl Course {
    /// The course of anything made of two terms.
    fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Still, x) | (x, Self::Still) => match x {
                Self::Affine(_) => Self::Other,
                x => x,
            },
            (Self::Recurs(a), Self::Recurs(b)) => {
                let (low, high) = (a.min(b), a.max(b));
                let ratio = (high / low).round();
                let whole = (high - ratio * low).abs() <= WHOLE * high;
                if whole { Self::Recurs(low) } else { Self::Other }
            }
            _ => Self::Other,
        }
    }

    /// The course of a sum, `sign` before the second term.
    fn plus(self, other: Self, sign: f64) -> Self {
        match (self, other) {
            (Self::Still, Self::Still) => Self::Still,
            (Self::Affine(a), Self::Affine(b)) => Self::affine(a + sign * b),
            (Self::Affine(a), Self::Still) => Self::Affine(a),
            (Self::Still, Self::Affine(b)) => Self::Affine(sign * b),
            _ => self.with(other),
        }
    }

    fn affine(rate: f64) -> Self {
        if rate == 0.0 { Self::Still } else { Self::Affine(rate) }
    }

    /// The course of the term times a number, if its factor is one.
    fn times(self, number: Option<f64>) -> Self {
        match (self, number) {
            (Self::Affine(rate), Some(number)) => Self::affine(rate * number),
            (Self::Affine(_), None) => Self::Other,
            _ => self,
        }
    }
}

impl Custom<f64> {
    /// The period of each coordinate: V and every D_i are the same where q_j is larger by it. None
    /// where q_j occurs anywhere but in sines and cosines of linear forms, where their frequencies
    /// are not multiples of the lowest, and where q_j does not occur. As far as the form shows it.
    pub fn periods(&self) -> Vec<Option<f64>> {
        let (graph, roots) = (&self.shape.graph, &self.shape.fields);
        let nodes = graph.all(roots);
        let circular = |node: &Node| matches!(graph.term(*node), Term::Of(Function::Sin | Function::Cos, _));
        if !nodes.iter().any(circular) {
            return vec![None; self.shape.dof];
        }
        let closed: Vec<Node> = nodes.iter().copied().filter(|&x| graph.closed(x)).collect();
        let numbers = graph.evaluate(&closed, &self.parameters, |_| 0.0);
        let moving = graph.cone(roots, Kinds::COORDINATES);
        (0..self.shape.dof).map(|j| self.period(j as u32, &moving, &numbers)).collect()
    }

    fn period(&self, j: u32, nodes: &[Node], numbers: &HashMap<Node, f64>) -> Option<f64> {
        let graph = &self.shape.graph;
        let mut courses: HashMap<Node, Course> = HashMap::with_capacity(nodes.len());
        for &node in nodes {
            let at = |x: Node| courses.get(&x).copied().unwrap_or(Course::Still);
            let number = |x: Node| numbers.get(&x).copied();
            let course = match graph.term(node) {
                Term::Input(Input::Coordinate(i)) if i == j => Course::Affine(1.0),
                Term::Negative(a) => at(a).times(Some(-1.0)),
                Term::Sum(a, b) => at(a).plus(at(b), 1.0),
                Term::Difference(a, b) => at(a).plus(at(b), -1.0),
                Term::Product(a, b) => match (at(a), at(b)) {
                    (a, Course::Still) => a.times(number(b)),
                    (Course::Still, b) => b.times(number(a)),
                    (a, b) => a.with(b),
                },
                Term::Quotient(a, b) => match (at(a), at(b)) {
                    (a, Course::Still) => a.times(number(b).map(f64::recip)),
                    (a, b) => a.with(b),
                },
                Term::Of(function, a) => match (function, at(a)) {
                    (Function::Sin | Function::Cos, Course::Affine(rate)) => Course::Recurs(rate.abs()),
                    (_, Course::Affine(_)) => Course::Other,
                    (_, course) => course,
                },
                Term::Constant(_) | Term::Pi | Term::Parameter(_) | Term::Input(_) => Course::Still,
                // Slopes along an edge: V and D_j have none.
                term @ (Term::Divided(..) | Term::Bend(..)) => {
                    let still = term.operands().all(|x| at(x) == Course::Still);
                    if still { Course::Still } else { Course::Other }
                }
            };
            courses.insert(node, course);
        }
        let roots = self.shape.fields.iter().filter_map(|root| courses.get(root).copied());
        match roots.fold(Course::Still, Course::with) {
            Course::Recurs(frequency) => Some(std::f64::consts::TAU / frequency),
            Course::Still | Course::Affine(_) | Course::Other => None,
        }
    }
}
