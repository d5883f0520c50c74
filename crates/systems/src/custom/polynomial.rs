//! Polynomials of degree 4 or less in one coordinate, with coefficients that depend on the others.

use afterbay_core::{Line, Scalar};
use afterbay_expression::{Graph, Monomial, Node};
use std::ops::Range;

/// The largest degree, and the number of coefficients from the power 1 on.
const DEGREE: usize = 4;

/// Σ c_k q_jᵏ, where c_k is a constant plus a sum of products of other coordinates.
#[derive(Debug)]
pub(super) struct Polynomial {
    /// The range, among all numbers, of the constant parts of c_1 to c_4 and the factors of the
    /// mixed monomials.
    numbers: Range<usize>,
    mixed: Box<[Mixed]>,
}

/// A product of other coordinates in a c_k.
#[derive(Debug)]
struct Mixed {
    /// k - 1
    place: usize,
    others: Box<[u32]>,
}

impl Polynomial {
    /// The monomials as a polynomial in q_j; none if the degree is too high.
    pub(super) fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        monomials: &[Monomial],
        j: u32,
    ) -> Option<Self> {
        let (mut constant, mut mixed) = ([graph.number(0.0); DEGREE], Vec::new());
        let mut factors = Vec::new();
        for Monomial { coefficient, factors: all } in monomials {
            let others: Box<[u32]> = all.iter().copied().filter(|&i| i != j).collect();
            let Some(place) = (all.len() - others.len()).checked_sub(1) else { continue };
            let part = constant.get_mut(place)?;
            if others.is_empty() {
                *part = graph.sum(*part, *coefficient);
            } else {
                factors.push(*coefficient);
                mixed.push(Mixed { place, others });
            }
        }
        let start = numbers.len();
        numbers.extend(constant.into_iter().chain(factors));
        Some(Self { numbers: start..numbers.len(), mixed: mixed.into() })
    }

    /// The divided difference over the edge from q to q with q_j moved to `to`, and its derivative
    /// by `to`.
    #[inline(always)]
    pub(super) fn mean<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize, to: T) -> Line<T> {
        let numbers = &numbers[self.numbers.clone()];
        let Some((constant, factors)) = numbers.split_first_chunk::<DEGREE>() else {
            return Line { value: T::zero(), slope: T::zero() };
        };
        let mut c = *constant;
        for (mixed, &factor) in self.mixed.iter().zip(factors) {
            let product = match *mixed.others {
                [i] => factor * q[i as usize],
                [i, k] => factor * q[i as usize] * q[k as usize],
                ref others => others.iter().fold(factor, |product, &i| product * q[i as usize]),
            };
            // Without indexed writes, so that c stays in registers.
            c = std::array::from_fn(|k| if k == mixed.place { c[k] + product } else { c[k] });
        }
        // c1 + c2 (a + b) + c3 (a² + ab + b²) + c4 (a + b)(a² + b²) from a to b.
        let (from, [c1, c2, c3, c4]) = (q[j], c);
        let (sum, squares) = (from + to, from.mul_add(from, to * to));
        let even = c3.mul_add(from.mul_add(to, squares), c1);
        let value = sum.mul_add(c4.mul_add(squares, c2), even);
        let slope = c4.mul_add((to + to).mul_add(sum, squares), c3.mul_add(sum + to, c2));
        Line { value, slope }
    }
}
