//! Sums of ridge polynomials. A ridge polynomial is a polynomial in one linear form of the
//! coordinates.
//!
//! Only factors c ℓᵏ are multiplied out. (q1 - 1)^4 stays a fourth power of q1 - 1 and (q1^2 - 1)^2
//! a square of q1² - 1, so that no digits are lost near q1 = 1.

use crate::graph::{Graph, Input, Kinds, Node, Term};
use std::collections::HashMap;

/// The largest degree of a ridge polynomial.
const LARGEST_DEGREE: usize = 16;

/// A linear form ℓ = Σ a_i q_i + b of one or two coordinates, with closed a_i and b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Form {
    /// i and a_i
    first: (u32, Node),
    second: Option<(u32, Node)>,
    /// b
    pub offset: Node,
}

impl Form {
    /// The coordinates and their weights.
    pub fn weights(self) -> impl Iterator<Item = (u32, Node)> + Clone {
        std::iter::once(self.first).chain(self.second)
    }
}

/// The variable y of a ridge polynomial: y = ℓ, or y = ℓ² + c.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Base {
    /// ℓ
    pub form: Form,
    /// The closed node c if y = ℓ² + c; none if y = ℓ.
    pub shift: Option<Node>,
}

/// A ridge polynomial Σ c_k yᵏ.
#[derive(Clone, Debug)]
pub struct Ridge {
    /// y
    pub base: Base,
    /// The closed nodes c_0, c_1, ..; at least one.
    pub coefficients: Vec<Node>,
}

impl Graph {
    /// The node as a sum of one or more ridge polynomials, if it is written as one.
    pub fn ridges(&mut self, of: Node) -> Option<Vec<Ridge>> {
        let mut known: HashMap<Node, Ridge> = HashMap::new();
        for node in self.cone(&[of], Kinds::ALL) {
            if let Some(ridge) = self.ridge(node, &known) {
                known.insert(node, ridge);
            }
        }
        let (mut constant, one) = (self.number(0.0), self.number(1.0));
        let (mut ridges, mut places) = (Vec::<Ridge>::new(), HashMap::new());
        // Each pending term with its factor.
        let mut stack = vec![(of, one)];
        while let Some((node, factor)) = stack.pop() {
            if self.closed(node) {
                let term = self.product(factor, node);
                constant = self.sum(constant, term);
                continue;
            }
            if let Some(ridge) = known.get(&node) {
                let ridge = self.times(ridge, factor);
                let place = *places.entry(ridge.base).or_insert(ridges.len());
                match ridges.get_mut(place) {
                    Some(sum) => {
                        sum.coefficients = self.sums(&sum.coefficients, &ridge.coefficients);
                    }
                    None => ridges.push(ridge),
                }
                continue;
            }
            match self.term(node) {
                Term::Sum(a, b) => stack.extend([(b, factor), (a, factor)]),
                Term::Difference(a, b) => stack.extend([(b, self.negative(factor)), (a, factor)]),
                Term::Negative(a) => stack.push((a, self.negative(factor))),
                Term::Product(c, a) | Term::Product(a, c) if self.closed(c) => {
                    stack.push((a, self.product(factor, c)));
                }
                Term::Quotient(a, c) if self.closed(c) => stack.push((a, self.quotient(factor, c))),
                _ => return None,
            }
        }
        match ridges.first_mut() {
            Some(first) => first.coefficients[0] = self.sum(first.coefficients[0], constant),
            None => ridges.push(Ridge { coefficients: vec![constant], ..self.coordinate(0) }),
        }
        Some(ridges)
    }

    /// The node as one ridge polynomial, given the operands that are.
    fn ridge(&mut self, node: Node, known: &HashMap<Node, Ridge>) -> Option<Ridge> {
        match self.term(node) {
            Term::Input(Input::Coordinate(j)) => Some(self.coordinate(j)),
            Term::Negative(a) => {
                let minus = self.number(-1.0);
                Some(self.times(known.get(&a)?, minus))
            }
            Term::Sum(a, b) => {
                let one = self.number(1.0);
                self.ridge_sum(a, b, one, known)
            }
            Term::Difference(a, b) => {
                let minus = self.number(-1.0);
                self.ridge_sum(a, b, minus, known)
            }
            Term::Product(a, b) if self.closed(a) => Some(self.times(known.get(&b)?, a)),
            Term::Product(a, b) if self.closed(b) => Some(self.times(known.get(&a)?, b)),
            Term::Product(a, b) => self.ridge_product(known.get(&a)?, known.get(&b)?),
            Term::Quotient(a, b) if self.closed(b) => {
                let ridge = known.get(&a)?;
                let coefficients =
                    ridge.coefficients.iter().map(|&x| self.quotient(x, b)).collect();
                Some(Ridge { base: ridge.base, coefficients })
            }
            _ => None,
        }
    }

    /// The polynomial q_j.
    fn coordinate(&mut self, j: u32) -> Ridge {
        let (zero, one) = (self.number(0.0), self.number(1.0));
        self.first_power(Form { first: (j, one), second: None, offset: zero })
    }

    /// The polynomial ℓ.
    fn first_power(&mut self, form: Form) -> Ridge {
        let coefficients = vec![self.number(0.0), self.number(1.0)];
        Ridge { base: Base { form, shift: None }, coefficients }
    }

    fn times(&mut self, ridge: &Ridge, factor: Node) -> Ridge {
        let coefficients = ridge.coefficients.iter().map(|&x| self.product(factor, x)).collect();
        Ridge { base: ridge.base, coefficients }
    }

    fn sums(&mut self, a: &[Node], b: &[Node]) -> Vec<Node> {
        let zero = self.number(0.0);
        let at = |x: &[Node], k: usize| x.get(k).copied().unwrap_or(zero);
        (0..a.len().max(b.len())).map(|k| self.sum(at(a, k), at(b, k))).collect()
    }

    /// a + sign b
    fn ridge_sum(
        &mut self,
        a: Node,
        b: Node,
        sign: Node,
        known: &HashMap<Node, Ridge>,
    ) -> Option<Ridge> {
        if self.closed(a) {
            let mut ridge = self.times(known.get(&b)?, sign);
            ridge.coefficients[0] = self.sum(a, ridge.coefficients[0]);
            return Some(ridge);
        }
        if self.closed(b) {
            let mut ridge = known.get(&a)?.clone();
            let b = self.product(sign, b);
            ridge.coefficients[0] = self.sum(ridge.coefficients[0], b);
            return Some(ridge);
        }
        let (a, b) = (known.get(&a)?, known.get(&b)?);
        let b = self.times(b, sign);
        if a.base == b.base {
            return Some(Ridge {
                base: a.base,
                coefficients: self.sums(&a.coefficients, &b.coefficients),
            });
        }
        let (a, b) = (self.linear_form(a)?, self.linear_form(&b)?);
        let mut weights: Vec<(u32, Node)> = a.weights().collect();
        for (j, weight) in b.weights() {
            match weights.iter_mut().find(|x| x.0 == j) {
                Some(known) => known.1 = self.sum(known.1, weight),
                None => weights.push((j, weight)),
            }
        }
        weights.sort_unstable_by_key(|x| x.0);
        let (first, second) = match weights[..] {
            [first] => (first, None),
            [first, second] => (first, Some(second)),
            _ => return None,
        };
        let offset = self.sum(a.offset, b.offset);
        Some(self.first_power(Form { first, second, offset }))
    }

    fn ridge_product(&mut self, a: &Ridge, b: &Ridge) -> Option<Ridge> {
        if (self.is_monomial(a) || self.is_monomial(b))
            && let Some(product) = self.multiplied(a, b)
        {
            return Some(product);
        }
        // Both may be powers of the same ℓ + b or ℓ² + c.
        let [a, b] =
            [a, b].map(|x| if self.is_monomial(x) { Some(x.clone()) } else { self.whole(x) });
        self.multiplied(&a?, &b?)
    }

    /// The product of two polynomials in the same variable.
    fn multiplied(&mut self, a: &Ridge, b: &Ridge) -> Option<Ridge> {
        let count = a.coefficients.len() + b.coefficients.len() - 1;
        if a.base != b.base || count > LARGEST_DEGREE + 1 {
            return None;
        }
        let mut coefficients = vec![self.number(0.0); count];
        for (i, &x) in a.coefficients.iter().enumerate() {
            for (k, &y) in b.coefficients.iter().enumerate() {
                let product = self.product(x, y);
                coefficients[i + k] = self.sum(coefficients[i + k], product);
            }
        }
        Some(Ridge { base: a.base, coefficients })
    }

    /// b + c ℓ, or a + s ℓ² with a constant s, as a variable of which powers are taken.
    fn whole(&mut self, ridge: &Ridge) -> Option<Ridge> {
        if let Some(form) = self.linear_form(ridge) {
            return Some(self.first_power(form));
        }
        let (Base { form, shift: None }, &[a, b, s]) = (ridge.base, &ridge.coefficients[..]) else {
            return None;
        };
        let number = self.constant(s).is_some_and(f64::is_normal);
        (number && self.is_zero(b)).then(|| {
            let base = Base { form, shift: Some(self.quotient(a, s)) };
            Ridge { base, coefficients: vec![b, s] }
        })
    }

    /// Whether the polynomial is c yᵏ.
    fn is_monomial(&self, ridge: &Ridge) -> bool {
        let below = &ridge.coefficients[..ridge.coefficients.len() - 1];
        below.iter().all(|&x| self.is_zero(x))
    }

    /// b + c ℓ as a linear form.
    fn linear_form(&mut self, ridge: &Ridge) -> Option<Form> {
        let (Base { form, shift: None }, &[b, c]) = (ridge.base, &ridge.coefficients[..]) else {
            return None;
        };
        let mut scale = |(j, weight): (u32, Node)| (j, self.product(c, weight));
        let (first, second) = (scale(form.first), form.second.map(scale));
        let offset = self.product(c, form.offset);
        Some(Form { first, second, offset: self.sum(b, offset) })
    }
}

#[cfg(test)]
mod tests {
    use crate::*;

    /// Degrees of what a node is the sum of, and whether in a square.
    fn degrees(build: impl Fn(&mut Graph, [Node; 2]) -> Node) -> Option<Vec<(usize, bool)>> {
        let mut graph = Graph::default();
        let q = [0, 1].map(|j| graph.input(Input::Coordinate(j)));
        let node = build(&mut graph, q);
        let ridges = graph.ridges(node)?;
        Some(ridges.iter().map(|x| (x.coefficients.len() - 1, x.base.shift.is_some())).collect())
    }

    fn power(graph: &mut Graph, of: Node, exponent: f64) -> Node {
        let exponent = graph.number(exponent);
        graph.power(of, exponent)
    }

    #[test]
    fn a_power_of_a_sum_is_not_multiplied_out() {
        for (inner, outer, found) in
            [(1.0, 4.0, (4, false)), (2.0, 2.0, (2, true)), (2.0, 3.0, (3, true))]
        {
            let well = |graph: &mut Graph, q: [Node; 2]| {
                let (x, one) = (power(graph, q[0], inner), graph.number(1.0));
                let base = graph.difference(x, one);
                power(graph, base, outer)
            };
            assert_eq!(degrees(well), Some(vec![found]), "(q1^{inner} - 1)^{outer}");
        }
    }

    #[test]
    fn a_factor_goes_to_every_term() {
        let both = |graph: &mut Graph, q: [Node; 2]| {
            let squares = q.map(|x| power(graph, x, 2.0));
            let (k, sum) = (graph.parameter(0), graph.sum(squares[0], squares[1]));
            graph.product(k, sum)
        };
        assert_eq!(degrees(both), Some(vec![(2, false); 2]));
        let even = |graph: &mut Graph, q: [Node; 2]| {
            let (square, k) = (power(graph, q[0], 2.0), graph.parameter(0));
            let sum = graph.sum(k, square);
            graph.product(square, sum)
        };
        assert_eq!(degrees(even), Some(vec![(4, false)]));
    }

    #[test]
    fn a_difference_is_one_form_and_a_product_is_none() {
        let bond = |graph: &mut Graph, [a, b]: [Node; 2]| {
            let length = graph.difference(b, a);
            let [square, fourth] = [2.0, 4.0].map(|n| power(graph, length, n));
            graph.sum(square, fourth)
        };
        assert_eq!(degrees(bond), Some(vec![(4, false)]));
        assert_eq!(degrees(|graph, [a, b]| graph.product(a, b)), None);
        assert_eq!(degrees(|graph, [a, _]| power(graph, a, 17.0)), None);
        assert_eq!(degrees(|graph, _| graph.number(2.0)), Some(vec![(0, false)]));
    }
}
