//! A polynomial of degree 4 or less along one coordinate, its coefficients made of the others.

use crate::expression::graph::{Graph, Node};
use crate::expression::monomial::Monomial;
use afterbay_core::{Line, Scalar};
use std::ops::Range;

/// Coefficients, from the power 1 on.
const COUNT: usize = 4;

/// Σ c_k q_jᵏ along q_j, where c_k is a number and a sum of products of other coordinates.
#[derive(Debug)]
pub(super) struct Polynomial {
    /// Among all numbers the constant parts of c_1 to c_4, and the factor of each mixed monomial.
    numbers: Range<usize>,
    mixed: Box<[Mixed]>,
}

/// Part of a c_k.
#[derive(Debug)]
struct Mixed {
    /// k - 1
    place: usize,
    others: Box<[u32]>,
}

impl Polynomial {
    /// What the monomials are along q_j; none where the degree is too high.
    pub(super) fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        monomials: &[Monomial],
        j: u32,
    ) -> Option<Self> {
        let (mut constant, mut mixed) = ([graph.number(0.0); COUNT], Vec::new());
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

    /// The divided difference from q to q with q_j moved to `to`, and its derivative by `to`.
    #[inline(always)]
    pub(super) fn mean<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize, to: T) -> Line<T> {
        let numbers = &numbers[self.numbers.clone()];
        let Some((constant, factors)) = numbers.split_first_chunk::<COUNT>() else {
            return Line { value: T::zero(), slope: T::zero() };
        };
        let mut c = *constant;
        for (mixed, &factor) in self.mixed.iter().zip(factors) {
            let product = match *mixed.others {
                [i] => factor * q[i as usize],
                [i, k] => factor * q[i as usize] * q[k as usize],
                ref others => others.iter().fold(factor, |product, &i| product * q[i as usize]),
            };
            c[mixed.place % COUNT] += product;
        }
        // The quotient is h0 + h1 x + h2 x² + c4 x³ at the end.
        let (from, [c1, c2, c3, c4]) = (q[j], c);
        let h2 = c4.mul_add(from, c3);
        let h1 = h2.mul_add(from, c2);
        let h0 = h1.mul_add(from, c1);
        let value = c4.mul_add(to, h2).mul_add(to, h1).mul_add(to, h0);
        let slope = (c4 + c4 + c4).mul_add(to, h2 + h2).mul_add(to, h1);
        Line { value, slope }
    }
}
