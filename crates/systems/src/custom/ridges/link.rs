//! One ridge polynomial along one coordinate.

use afterbay_core::{Line, Scalar};
use afterbay_expression::{Graph, Node, Ridge};
use std::ops::Range;

/// The numbers of a link in a column of a block: a, b, c, the coefficients of a cubic, and its
/// factor.
pub(super) const COLUMNS: usize = 8;

/// The quantity that blocks evaluate: the sums, or their derivatives by q_j.
#[derive(Clone, Copy)]
pub(in crate::custom) enum Wanted {
    Slopes,
    Values,
}

/// A ridge polynomial along a coordinate.
#[derive(Debug)]
pub(super) struct Link {
    /// i, if b ≠ 0.
    pub(super) other: Option<usize>,
    /// The range, among all numbers, of a, b, c and the coefficients of W, from w_0 to w_2, w_4 or
    /// a higher one. For y = ℓ² + d these are the seven numbers a, b, c, d, w_0, w_1, w_2.
    pub(super) numbers: Range<usize>,
}

impl Link {
    pub(super) fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        ridge: &Ridge,
        j: usize,
    ) -> Option<Self> {
        let (start, zero) = (numbers.len(), graph.number(0.0));
        let (mut own, mut other) = (zero, None);
        let form = ridge.base.form;
        for (i, weight) in form.weights() {
            match i as usize {
                i if i == j => own = weight,
                i if other.is_none() => other = Some((i, weight)),
                _ => return None,
            }
        }
        let (other, weight) = other.unzip();
        numbers.extend([own, weight.unwrap_or(zero), form.offset]);
        numbers.extend(ridge.base.shift);
        numbers.extend(&ridge.coefficients);
        let count = ridge.coefficients.len();
        let padded = match ridge.base.shift {
            Some(_) if count > 3 => return None,
            _ if count <= 3 => 3,
            _ => count.max(5),
        };
        numbers.resize(numbers.len() + (padded - count), zero);
        Some(Self { other, numbers: start..numbers.len() })
    }

    /// The column of the link in a block, if the quantity wanted is a cubic in ℓ.
    pub(super) fn column(
        &self,
        graph: &mut Graph,
        numbers: &[Node],
        wanted: Wanted,
    ) -> Option<[Node; COLUMNS]> {
        let &[a, b, c, ref w @ ..] = &numbers[self.numbers.clone()] else { return None };
        let plain = w.len() != 4;
        let (coefficients, factor) = match wanted {
            Wanted::Values => (w.to_vec(), graph.number(1.0)),
            Wanted::Slopes => {
                let mut slope = |(k, &w): (usize, &Node)| {
                    let k = graph.number(k as f64);
                    graph.product(k, w)
                };
                (w.iter().enumerate().skip(1).map(&mut slope).collect(), a)
            }
        };
        let zero = graph.number(0.0);
        let at = |k: usize| coefficients.get(k).copied().unwrap_or(zero);
        let cubic = plain && coefficients.iter().skip(4).all(|&x| graph.is_zero(x));
        cubic.then(|| [a, b, c, at(0), at(1), at(2), at(3), factor])
    }

    /// b q_i + c
    #[inline(always)]
    pub(super) fn rest<T: Scalar>(&self, b: T, c: T, q: &[T]) -> T {
        match self.other {
            Some(i) => b.mul_add(q[i], c),
            None => c,
        }
    }

    /// a, b q_i + c, and the coefficients.
    pub(super) fn parts<'a, T: Scalar>(&self, numbers: &'a [T], q: &[T]) -> (T, T, &'a [T]) {
        match numbers {
            &[a, b, c, ref coefficients @ ..] => (a, self.rest(b, c, q), coefficients),
            _ => (T::zero(), T::zero(), &[]),
        }
    }
}

/// The coefficients of W', given those of W from w_1 to w_4.
#[inline(always)]
pub(super) fn cubic_derivative<T: Scalar>([w1, w2, w3, w4]: [T; 4]) -> [T; 4] {
    let twice = w4 + w4;
    [w1, w2 + w2, w3 + w3 + w3, twice + twice]
}

/// c_0 + c_1 x + c_2 x² + c_3 x³, in a chain of three dependent operations.
#[inline(always)]
pub(super) fn cubic<T: Scalar>([c0, c1, c2, c3]: [T; 4], x: T) -> T {
    (x * x).mul_add(c3.mul_add(x, c2), c1.mul_add(x, c0))
}

/// Σ c_k xᵏ and its derivative.
#[inline(never)]
pub(super) fn horner<T: Scalar>(coefficients: &[T], x: T) -> Line<T> {
    let zero = Line { value: T::zero(), slope: T::zero() };
    coefficients.iter().rev().fold(zero, |Line { value, slope }, &c| Line {
        value: value.mul_add(x, c),
        slope: slope.mul_add(x, value),
    })
}

/// (Σ c_k sᵏ - Σ c_k rᵏ) / (s - r) and its derivative by s.
#[inline(never)]
pub(super) fn divided_difference<T: Scalar>(coefficients: &[T], r: T, s: T) -> Line<T> {
    let mut quotient = T::zero();
    let mut line = Line { value: quotient, slope: quotient };
    for &c in coefficients.iter().skip(1).rev() {
        quotient = quotient.mul_add(r, c);
        line = Line {
            value: line.value.mul_add(s, quotient),
            slope: line.slope.mul_add(s, line.value),
        };
    }
    line
}
