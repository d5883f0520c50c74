//! The flow of a linear equation as a Taylor series in time, using only products with the matrix.
//!
//! ```text
//! u' = A u        y(τ) = ∫_0^τ u = Σ_k t_k        t_0 = τ u(0)        t_k = τ/(k+1) A t_{k-1}
//! ```
//!
//! The time is divided into spans short enough for the series to converge to rounding. In each span
//! y is evaluated at Gauss nodes, so that integrals of quadratic functions along the flow are
//! accurate to rounding too. No matrix norm is needed: the terms of the series determine the length
//! of a span, separately for q and p and thus independently of their units.

use crate::legendre::{gauss, narrow};
use afterbay_core::{Mask, Quad, Quantity, Scalar, StepFailure, Vector, larger_or_nan};
use std::sync::LazyLock;

/// The largest number of spans, and hence about the largest h |A|. A choice: a limit of
/// the work.
const MOST_SPANS: f64 = 1000.0;

/// y(h), and the terms of the series in the current span.
#[derive(Clone, Debug)]
pub(crate) struct LinearFlow<V: Vector> {
    terms: Vec<[V; 2]>,
    /// Nodes in [0, 1] and weights
    nodes: Vec<[V::Scalar; 2]>,
    /// u at the start; to be set before calling `follow`
    pub(crate) u: [V; 2],
    /// y at the end of the current span
    pub(crate) y: [V; 2],
    at: [V; 2],
}

/// Rules for a span, for 16 and for 31 digits. Computing them takes as long as a hundred steps.
static RULES: [LazyLock<Vec<[Quad; 2]>>; 2] =
    [LazyLock::new(|| gauss(10)), LazyLock::new(|| gauss(16))];

/// Gauss nodes in [0, 1] and their weights, sufficient for a span.
pub(crate) fn nodes<T: Scalar>() -> Vec<[T; 2]> {
    let [short, long] = &RULES;
    let rule = if T::IS_EXTENDED { long } else { short };
    let pair = |&[x, weight]: &[Quad; 2]| {
        let [x, weight] = [narrow::<T>(x).half(), narrow(weight)];
        [[T::one().half() - x, weight], [T::one().half() + x, weight]]
    };
    rule.iter().flat_map(pair).collect()
}

/// The number of terms of the series. The last is a rounding of the first where |A| τ is about 1.4.
pub(crate) fn terms<T: Scalar>() -> usize {
    if T::IS_EXTENDED { 32 } else { 20 }
}

impl<V: Vector> LinearFlow<V> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || [V::zeros(n), V::zeros(n)];
        Self {
            terms: (0..terms::<V::Scalar>()).map(|_| zeros()).collect(),
            nodes: nodes(),
            u: zeros(),
            y: zeros(),
            at: zeros(),
        }
    }

    /// Integrates y from 0 over the time h. `multiply` computes A x. `show` receives (weight, y) at
    /// each Gauss node; the weights sum to h.
    ///
    /// Returns the number of products, or `None` if h |A| is larger than about 1000 or not finite.
    pub(crate) fn follow(
        &mut self,
        h: V::Scalar,
        mut multiply: impl FnMut([&[V::Scalar]; 2], [&mut [V::Scalar]; 2]),
        mut show: impl FnMut(V::Scalar, [&[V::Scalar]; 2]),
    ) -> Option<u64> {
        let zero = V::Scalar::zero();
        self.y.iter_mut().for_each(|part| part.as_mut_slice().fill(zero));
        let (mut ahead, mut spans, mut products) = (h, 1.0, 0);
        while spans > 0.0 {
            let mut span = ahead / V::Scalar::from_f64(spans);
            let count = self.expand(span, &mut multiply);
            products += count as u64 - 1;
            loop {
                let more = self.excess(count);
                if more.is_nan() || more * spans > MOST_SPANS {
                    return None;
                }
                if more <= 1.0 {
                    break;
                }
                spans = (spans * more).ceil();
                let shorter = ahead / V::Scalar::from_f64(spans);
                self.shrink(count, shorter / span);
                span = shorter;
            }
            for i in 0..self.nodes.len() {
                let [node, weight] = self.nodes[i];
                self.place(node, count);
                let [q, p] = &self.at;
                show(weight * span, [q.as_slice(), p.as_slice()]);
            }
            self.advance(span, count);
            ahead -= span;
            spans -= 1.0;
        }
        Some(products)
    }

    /// The reason for a failed `follow`: u is not finite, or the time is too long.
    #[cold]
    pub(crate) fn too_long(&self) -> StepFailure {
        let parts =
            [(Quantity::Force, self.u[1].as_slice()), (Quantity::Velocity, self.u[0].as_slice())];
        let finite = parts.iter().all(|(_, part)| part.iter().all(|x| x.is_finite().all()));
        if finite {
            StepFailure::TooLong { limit: MOST_SPANS }
        } else {
            StepFailure::non_finite(&parts)
        }
    }

    /// Computes the terms at the end of the span until they are negligible, and returns their
    /// number.
    fn expand(
        &mut self,
        span: V::Scalar,
        multiply: &mut impl FnMut([&[V::Scalar]; 2], [&mut [V::Scalar]; 2]),
    ) -> usize {
        for (term, u) in self.terms[0].iter_mut().zip(&self.u) {
            term.as_mut_slice()
                .iter_mut()
                .zip(u.as_slice())
                .for_each(|(term, &u)| *term = span * u);
        }
        let mut largest = self.sizes(0);
        for k in 1..self.terms.len() {
            let (before, after) = self.terms.split_at_mut(k);
            let ([q, p], [next_q, next_p]) = (&before[k - 1], &mut after[0]);
            multiply([q.as_slice(), p.as_slice()], [next_q.as_mut_slice(), next_p.as_mut_slice()]);
            let share = span / V::Scalar::from_f64((k + 1) as f64);
            for part in &mut after[0] {
                part.as_mut_slice().iter_mut().for_each(|x| *x *= share);
            }
            let now = self.sizes(k);
            let small = |i: usize| now[i] <= V::Scalar::EPSILON / 16.0 * largest[i];
            if small(0) && small(1) {
                return k + 1;
            }
            largest = [0, 1].map(|i| largest[i].max(now[i]));
        }
        self.terms.len()
    }

    /// The factor by which the span is too long.
    fn excess(&self, count: usize) -> f64 {
        if count < self.terms.len() {
            return 1.0;
        }
        let last = self.sizes(count - 1);
        let largest = (0..count).fold([0.0_f64; 2], |most, k| {
            let now = self.sizes(k);
            [0, 1].map(|i| larger_or_nan(most[i], now[i]))
        });
        // If the terms grow throughout, their ratio estimates |A| span divided by their number.
        let one = |i: usize| {
            let share = last[i] / (V::Scalar::EPSILON * largest[i]);
            if last[i] == 0.0 { 1.0 } else { share.powf(1.0 / (count - 1) as f64) }
        };
        [1.0, one(0), one(1)].into_iter().fold(0.0, larger_or_nan)
    }

    /// The largest absolute entries of a term, or NaN if an entry is NaN.
    fn sizes(&self, k: usize) -> [f64; 2] {
        [0, 1].map(|i| {
            let sizes = self.terms[k][i].as_slice().iter().map(|x| x.to_f64().abs());
            sizes.fold(0.0, larger_or_nan)
        })
    }

    /// Rescales the terms to a span shortened by this factor.
    fn shrink(&mut self, count: usize, share: V::Scalar) {
        let mut power = share;
        for term in &mut self.terms[..count] {
            for part in term {
                part.as_mut_slice().iter_mut().for_each(|x| *x *= power);
            }
            power *= share;
        }
    }

    /// Evaluates y at the fraction `node` of the span.
    fn place(&mut self, node: V::Scalar, count: usize) {
        for i in [0, 1] {
            let at = self.at[i].as_mut_slice();
            at.fill(V::Scalar::zero());
            for term in self.terms[..count].iter().rev() {
                let term = &term[i].as_slice()[..at.len()];
                for (at, &term) in at.iter_mut().zip(term) {
                    *at = (*at + term) * node;
                }
            }
            at.iter_mut().zip(self.y[i].as_slice()).for_each(|(at, &y)| *at += y);
        }
    }

    /// Advances y and u to the end of the span.
    fn advance(&mut self, span: V::Scalar, count: usize) {
        for i in [0, 1] {
            let (u, y, at) =
                (self.u[i].as_mut_slice(), self.y[i].as_mut_slice(), self.at[i].as_mut_slice());
            u.fill(V::Scalar::zero());
            at.fill(V::Scalar::zero());
            for (k, term) in self.terms[..count].iter().enumerate().rev() {
                let order = V::Scalar::from_f64((k + 1) as f64);
                for (j, &term) in term[i].as_slice().iter().enumerate() {
                    at[j] += term;
                    u[j] = order.mul_add(term, u[j]);
                }
            }
            for j in 0..y.len() {
                y[j] += at[j];
                u[j] = u[j] / span;
            }
        }
    }
}
