//! Derivatives as terms of the same graph, by the chain rule backwards.

use crate::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

impl Graph {
    /// The derivatives of a node by the inputs `by`, which are of these kinds. Inputs of other
    /// kinds are held constant. By adjoints: the chain rule is applied from the node back to its
    /// inputs.
    pub fn gradient(&mut self, of: Node, kinds: Kinds, by: &[Input]) -> Vec<Node> {
        let (zero, one) = (self.number(0.0), self.number(1.0));
        let mut adjoints = HashMap::from([(of, one)]);
        for node in self.cone(&[of], kinds).into_iter().rev() {
            let Some(&adjoint) = adjoints.get(&node) else { continue };
            let mut parts = [None; 2];
            match self.term(node) {
                Term::Negative(a) => parts[0] = Some((a, self.negative(adjoint))),
                Term::Sum(a, b) => parts = [Some((a, adjoint)), Some((b, adjoint))],
                Term::Difference(a, b) => {
                    parts = [Some((a, adjoint)), Some((b, self.negative(adjoint)))];
                }
                Term::Product(a, b) => {
                    parts =
                        [Some((a, self.product(adjoint, b))), Some((b, self.product(adjoint, a)))];
                }
                Term::Quotient(a, b) => {
                    let by_a = self.quotient(adjoint, b);
                    let by_b = self.product(by_a, node);
                    parts = [Some((a, by_a)), Some((b, self.negative(by_b)))];
                }
                Term::Of(function, a) => {
                    let slope = self.slope(function, a, node);
                    parts[0] = Some((a, self.product(adjoint, slope)));
                }
                Term::Divided(function, a, b) => {
                    let [by_a, by_b] = [(b, a), (a, b)].map(|(from, to)| {
                        if !self.depends(to, kinds) {
                            return None;
                        }
                        let derivative = self.divided_derivative(function, from, to);
                        Some((to, self.product(adjoint, derivative)))
                    });
                    parts = [by_a, by_b];
                }
                // Used in Newton's method only; its own derivative is never needed.
                Term::DividedDerivative(..) => {}
                Term::Constant(_) | Term::Pi | Term::Parameter(_) | Term::Input(_) => {}
            }
            for (operand, part) in parts.into_iter().flatten() {
                if self.depends(operand, kinds) {
                    let sum = adjoints.get(&operand).map_or(part, |&before| self.sum(before, part));
                    adjoints.insert(operand, sum);
                }
            }
        }
        let of = |input: &Input| {
            let node = self.input(*input);
            adjoints.get(&node).copied().unwrap_or(zero)
        };
        by.iter().map(of).collect()
    }
}
