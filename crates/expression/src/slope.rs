//! Divided differences as terms of the same graph, by the rules of slope arithmetic.
//!
//! A divided difference `f[a, b] = (f(b) - f(a)) / (b - a)` obeys rules without the difference,
//!
//! ```text
//! (u + v)[] = u[] + v[]        (u v)[] = u[] v̄ + ū v[]
//! (u/v)[] = (u[] - (u(a)/v(a)) v[]) / v(b)
//! √u[] = u[] / (√u(a) + √u(b))        φ(u)[] = φ[u(a), u(b)] u[]        ū = (u(a) + u(b))/2
//! ```
//!
//! with the φ[a, b] of [`afterbay_core::divided`], so that the mean slope of every expression
//! over an edge is exact to a few roundings, however short or long the edge is. Over an edge of
//! length 0 it is the derivative.
//! (Slopes as in Krawczyk and Neumaier, SIAM J. Numer. Anal. 22 (1985) 604, for one real edge.)

use crate::function::Function;
use crate::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

impl Graph {
    /// The divided difference of a node along one input, from its value to [`Input::End`]; the
    /// derivative where the two are equal.
    pub fn divided_difference(&mut self, of: Node, along: Input) -> Node {
        let (zero, one) = (self.number(0.0), self.number(1.0));
        // The value at the end and the divided difference of each node that changes along the edge.
        let mut changed: HashMap<Node, (Node, Node)> = HashMap::new();
        for node in self.cone(&[of], Kinds::of(along)) {
            let at = |x: Node| changed.get(&x).copied().unwrap_or((x, zero));
            let moves = |x: &Node| changed.contains_key(x);
            let term = self.term(node);
            let pair = match term {
                Term::Input(input) if input == along => (self.input(Input::End), one),
                _ if !term.operands().any(|x| moves(&x)) => continue,
                Term::Negative(a) => {
                    let (end, slope) = at(a);
                    (self.negative(end), self.negative(slope))
                }
                Term::Sum(a, b) => {
                    let (a, b) = (at(a), at(b));
                    (self.sum(a.0, b.0), self.sum(a.1, b.1))
                }
                Term::Difference(a, b) => {
                    let (a, b) = (at(a), at(b));
                    (self.difference(a.0, b.0), self.difference(a.1, b.1))
                }
                Term::Product(a, b) => {
                    let ends = (at(a), at(b));
                    let value = self.product(ends.0.0, ends.1.0);
                    let mean = [self.mean(a, ends.0.0), self.mean(b, ends.1.0)];
                    let parts = [self.product(ends.0.1, mean[1]), self.product(mean[0], ends.1.1)];
                    (value, self.sum(parts[0], parts[1]))
                }
                Term::Quotient(a, b) => {
                    let (a, b) = (at(a), at(b));
                    let lost = self.product(node, b.1);
                    let slope = self.difference(a.1, lost);
                    (self.quotient(a.0, b.0), self.quotient(slope, b.0))
                }
                Term::Of(Function::Sqrt, a) => {
                    let (end, slope) = at(a);
                    let root = self.of(Function::Sqrt, end);
                    let sum = self.sum(node, root);
                    (root, self.quotient(slope, sum))
                }
                Term::Of(function, a) => {
                    let (end, slope) = at(a);
                    let divided = self.divided(function, a, end);
                    (self.of(function, end), self.product(divided, slope))
                }
                Term::Divided(..)
                | Term::DividedDerivative(..)
                | Term::Constant(_)
                | Term::Pi
                | Term::Parameter(_)
                | Term::Input(_) => continue,
            };
            changed.insert(node, pair);
        }
        changed.get(&of).map_or(zero, |pair| pair.1)
    }

    fn mean(&mut self, start: Node, end: Node) -> Node {
        let (sum, half) = (self.sum(start, end), self.number(0.5));
        self.product(half, sum)
    }
}
