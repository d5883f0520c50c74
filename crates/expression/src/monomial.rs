//! Polynomials written as sums of monomials. Products of sums are not multiplied out.

use crate::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The largest degree of a monomial.
const LARGEST_DEGREE: usize = 16;

/// A monomial c Π q_i.
#[derive(Clone, Debug)]
pub struct Monomial {
    /// c, a closed node.
    pub coefficient: Node,
    /// The indices i in ascending order, each as often as its power.
    pub factors: Vec<u32>,
}

impl Graph {
    /// The node as a sum of monomials, if it is written as one. Only closed factors are multiplied
    /// out, so that no digits are lost where the terms of a product cancel.
    pub fn monomials(&mut self, of: Node) -> Option<Vec<Monomial>> {
        let one = self.number(1.0);
        let mut known: HashMap<Node, Monomial> = HashMap::new();
        for node in self.cone(&[of], Kinds::ALL) {
            if let Some(monomial) = self.monomial(node, &known) {
                known.insert(node, monomial);
            }
        }
        let (mut sum, mut stack) = (Vec::<Monomial>::new(), vec![(of, one)]);
        let mut places: HashMap<Vec<u32>, usize> = HashMap::new();
        while let Some((node, factor)) = stack.pop() {
            let monomial = match (known.get(&node), self.term(node)) {
                (Some(known), _) => known.clone(),
                _ if self.closed(node) => Monomial { coefficient: node, factors: Vec::new() },
                (_, Term::Sum(a, b)) => {
                    stack.extend([(b, factor), (a, factor)]);
                    continue;
                }
                (_, Term::Difference(a, b)) => {
                    stack.extend([(b, self.negative(factor)), (a, factor)]);
                    continue;
                }
                (_, Term::Negative(a)) => {
                    stack.push((a, self.negative(factor)));
                    continue;
                }
                (_, Term::Product(c, a) | Term::Product(a, c)) if self.closed(c) => {
                    stack.push((a, self.product(factor, c)));
                    continue;
                }
                (_, Term::Quotient(a, c)) if self.closed(c) => {
                    stack.push((a, self.quotient(factor, c)));
                    continue;
                }
                _ => return None,
            };
            let coefficient = self.product(factor, monomial.coefficient);
            match places.entry(monomial.factors.clone()) {
                Entry::Occupied(place) => {
                    let known = &mut sum[*place.get()].coefficient;
                    *known = self.sum(*known, coefficient);
                }
                Entry::Vacant(place) => {
                    place.insert(sum.len());
                    sum.push(Monomial { coefficient, ..monomial });
                }
            }
        }
        Some(sum)
    }

    /// The node as one monomial, given the operands that are monomials.
    fn monomial(&mut self, node: Node, known: &HashMap<Node, Monomial>) -> Option<Monomial> {
        let one = self.number(1.0);
        let scaled = |graph: &mut Self, a: &Node, by: Node| {
            let monomial = known.get(a)?;
            let coefficient = graph.product(by, monomial.coefficient);
            Some(Monomial { coefficient, factors: monomial.factors.clone() })
        };
        match self.term(node) {
            Term::Input(Input::Coordinate(j)) => {
                Some(Monomial { coefficient: one, factors: vec![j] })
            }
            Term::Negative(a) => {
                let minus = self.number(-1.0);
                scaled(self, &a, minus)
            }
            Term::Product(c, a) | Term::Product(a, c) if self.closed(c) => scaled(self, &a, c),
            Term::Product(a, b) => {
                let (a, b) = (known.get(&a)?, known.get(&b)?);
                let mut factors = [&a.factors[..], &b.factors[..]].concat();
                factors.sort_unstable();
                let coefficient = self.product(a.coefficient, b.coefficient);
                (factors.len() <= LARGEST_DEGREE).then_some(Monomial { coefficient, factors })
            }
            Term::Quotient(a, c) if self.closed(c) => {
                let monomial = known.get(&a)?;
                let coefficient = self.quotient(monomial.coefficient, c);
                Some(Monomial { coefficient, factors: monomial.factors.clone() })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::*;

    fn power(graph: &mut Graph, of: Node, exponent: f64) -> Node {
        let exponent = graph.number(exponent);
        graph.power(of, exponent)
    }

    #[test]
    fn products_of_sums_are_left_alone() {
        let mut graph = Graph::default();
        let [x, y] = [0, 1].map(|j| graph.input(Input::Coordinate(j)));
        let (square, sum) = (power(&mut graph, x, 2.0), graph.sum(x, y));
        let (mixed, three) = (graph.product(square, y), graph.number(3.0));
        let both = graph.difference(mixed, sum);
        let scaled = graph.quotient(both, three);
        let monomials = graph.monomials(scaled).unwrap();
        let factors: Vec<&[u32]> = monomials.iter().map(|x| &x.factors[..]).collect();
        assert_eq!(factors, [&[0, 0, 1][..], &[0], &[1]]);
        let squared = graph.product(sum, sum);
        assert!(graph.monomials(squared).is_none());
        let large = power(&mut graph, x, 17.0);
        assert!(graph.monomials(large).is_none());
    }
}
