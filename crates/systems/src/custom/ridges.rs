//! Sums of ridge polynomials Σ W(y) along each coordinate, where y = ℓ or y = ℓ² + d with the
//! linear form ℓ = a q_j + b q_i + c.
//!
//! As ℓ goes from r to s, the divided difference along q_j is a W[r, s]. W[r, s] is the value at s
//! of the polynomial (W(ℓ) - W(r))/(ℓ - r), whose coefficients Horner's rule gives without a
//! difference. For W(ℓ² + d) it is (r + s) W[r² + d, s² + d]. Degrees up to 4 are written out. With
//! many coordinates, eight are evaluated in SIMD lanes.

mod block;
mod link;

pub(super) use link::Wanted;

use afterbay_core::{Line, Scalar};
use afterbay_expression::{Graph, Node, Ridge};
use block::{Block, WIDTH};
use link::{Link, cubic, cubic_derivative, divided_difference, horner};
use std::ops::Range;

/// The ridge polynomials of every coordinate.
#[derive(Debug)]
pub(super) struct Links {
    links: Vec<Link>,
    /// The end of the links of coordinate j.
    ends: Vec<usize>,
    blocks: Vec<Block>,
}

impl Links {
    /// The links of the ridges along each coordinate, with their numbers appended to `numbers`.
    /// None if a ridge depends on two other coordinates or has a degree above 2 in ℓ² + d.
    pub(super) fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        along: &[Vec<&Ridge>],
        wanted: Wanted,
    ) -> Option<Self> {
        let mut links = Self { links: Vec::new(), ends: Vec::new(), blocks: Vec::new() };
        for (j, ridges) in along.iter().enumerate() {
            for ridge in ridges {
                links.links.push(Link::new(graph, numbers, ridge, j)?);
            }
            links.ends.push(links.links.len());
        }
        let mut first = 0;
        while first + WIDTH <= along.len() {
            let block = Block::new(
                graph,
                numbers,
                first,
                std::array::from_fn(|i| links.of(first + i)),
                wanted,
            );
            first += if block.is_some() { WIDTH } else { 1 };
            links.blocks.extend(block);
        }
        Some(links)
    }

    #[inline(always)]
    fn of(&self, j: usize) -> &[Link] {
        let start = if j == 0 { 0 } else { self.ends[j - 1] };
        &self.links[start..self.ends[j]]
    }

    /// The derivatives of the sum by each coordinate, for links made with [`Wanted::Slopes`].
    #[inline(always)]
    pub(super) fn slopes<T: Scalar>(&self, numbers: &[T], q: &[T], to: &mut [T]) {
        if !self.blocks.is_empty() {
            return self.in_blocks(numbers, q, Wanted::Slopes, to);
        }
        for (j, to) in to.iter_mut().enumerate() {
            *to = self.slope(numbers, q, j, q[j]);
        }
    }

    /// The sum along each coordinate, for links made with [`Wanted::Values`].
    #[inline(always)]
    pub(super) fn values<T: Scalar>(&self, numbers: &[T], q: &[T], to: &mut [T]) {
        if !self.blocks.is_empty() {
            return self.in_blocks(numbers, q, Wanted::Values, to);
        }
        for (j, to) in to.iter_mut().enumerate() {
            *to = self.value(numbers, q, j).value;
        }
    }

    #[inline(never)]
    fn in_blocks<T: Scalar>(&self, numbers: &[T], q: &[T], wanted: Wanted, to: &mut [T]) {
        for (single, block) in self.runs() {
            for j in single {
                to[j] = match wanted {
                    Wanted::Slopes => self.slope(numbers, q, j, q[j]),
                    Wanted::Values => self.value(numbers, q, j).value,
                };
            }
            if let Some(block) = block {
                let mut sums = [T::zero(); WIDTH];
                block.add(numbers, q, &mut sums);
                to[block.first..block.first + WIDTH].copy_from_slice(&sums);
            }
        }
    }

    /// The sum over all coordinates, for links made with [`Wanted::Values`].
    #[inline(always)]
    pub(super) fn total<T: Scalar>(&self, numbers: &[T], q: &[T]) -> T {
        if !self.blocks.is_empty() {
            return self.total_in_blocks(numbers, q);
        }
        (0..q.len()).fold(
            T::zero(),
            #[inline(always)]
            |sum, j| sum + self.value(numbers, q, j).value,
        )
    }

    #[inline(never)]
    fn total_in_blocks<T: Scalar>(&self, numbers: &[T], q: &[T]) -> T {
        let mut sums = [T::zero(); WIDTH];
        for (single, block) in self.runs() {
            for j in single {
                sums[j % WIDTH] += self.value(numbers, q, j).value;
            }
            if let Some(block) = block {
                block.add(numbers, q, &mut sums);
            }
        }
        sums.into_iter().fold(T::zero(), |sum, x| sum + x)
    }

    /// Each block with the single coordinates before it, then the single coordinates after the
    /// last.
    fn runs(&self) -> impl Iterator<Item = (Range<usize>, Option<&Block>)> {
        let starts = std::iter::once(0).chain(self.blocks.iter().map(|block| block.first + WIDTH));
        let ends = self.blocks.iter().map(|block| (block.first, Some(block)));
        starts
            .zip(ends.chain([(self.ends.len(), None)]))
            .map(|(start, (end, block))| (start..end, block))
    }

    /// The derivative of the sum by q_j, at q with q_j moved to `at`.
    #[inline(always)]
    pub(super) fn slope<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize, at: T) -> T {
        let mut sum = T::zero();
        for link in self.of(j) {
            let (a, slope) = match numbers[link.numbers.clone()] {
                [a, b, c, _, w1, w2] => {
                    (a, (w2 + w2).mul_add(a.mul_add(at, link.rest(b, c, q)), w1))
                }
                [a, b, c, d, _, w1, w2] => {
                    let form = a.mul_add(at, link.rest(b, c, q));
                    (a, (form + form) * (w2 + w2).mul_add(form.mul_add(form, d), w1))
                }
                [a, b, c, _, w1, w2, w3, w4] => (
                    a,
                    cubic(cubic_derivative([w1, w2, w3, w4]), a.mul_add(at, link.rest(b, c, q))),
                ),
                ref numbers => {
                    let (a, rest, coefficients) = link.parts(numbers, q);
                    (a, horner(coefficients, a.mul_add(at, rest)).slope)
                }
            };
            sum = a.mul_add(slope, sum);
        }
        sum
    }

    /// The divided difference over the edge from q to q with q_j moved to `to`, and its derivative
    /// by `to`.
    #[inline(always)]
    pub(super) fn mean<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize, to: T) -> Line<T> {
        let mut sum = Line { value: T::zero(), slope: T::zero() };
        for link in self.of(j) {
            let (a, mean) = match numbers[link.numbers.clone()] {
                [a, b, c, _, w1, w2] => {
                    let rest = link.rest(b, c, q);
                    let (r, s) = (a.mul_add(q[j], rest), a.mul_add(to, rest));
                    (a, Line { value: w2.mul_add(s, w2.mul_add(r, w1)), slope: w2 })
                }
                [a, b, c, d, _, w1, w2] => {
                    let rest = link.rest(b, c, q);
                    let (r, s) = (a.mul_add(q[j], rest), a.mul_add(to, rest));
                    let mean = w2.mul_add(r.mul_add(r, d) + s.mul_add(s, d), w1);
                    let sum = r + s;
                    (
                        a,
                        Line {
                            value: sum * mean,
                            slope: (sum * (w2 * s)).mul_add(T::from_f64(2.0), mean),
                        },
                    )
                }
                [a, b, c, _, w1, w2, w3, w4] => {
                    let rest = link.rest(b, c, q);
                    let (r, s) = (a.mul_add(q[j], rest), a.mul_add(to, rest));
                    // The quotient is h0 + h1 ℓ + h2 ℓ² + w4 ℓ³.
                    let h2 = w4.mul_add(r, w3);
                    let h1 = h2.mul_add(r, w2);
                    let h0 = h1.mul_add(r, w1);
                    let slope = (w4 + w4 + w4).mul_add(s, h2 + h2).mul_add(s, h1);
                    (a, Line { value: cubic([h0, h1, h2, w4], s), slope })
                }
                ref numbers => {
                    let (a, rest, coefficients) = link.parts(numbers, q);
                    (
                        a,
                        divided_difference(
                            coefficients,
                            a.mul_add(q[j], rest),
                            a.mul_add(to, rest),
                        ),
                    )
                }
            };
            sum.value = a.mul_add(mean.value, sum.value);
            sum.slope = (a * a).mul_add(mean.slope, sum.slope);
        }
        sum
    }

    /// The sum at q, and its derivative by q_j.
    #[inline(always)]
    pub(super) fn value<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize) -> Line<T> {
        let mut sum = Line { value: T::zero(), slope: T::zero() };
        for link in self.of(j) {
            let (a, line) = match numbers[link.numbers.clone()] {
                [a, b, c, w0, w1, w2] => {
                    let form = a.mul_add(q[j], link.rest(b, c, q));
                    let value = w2.mul_add(form, w1).mul_add(form, w0);
                    (a, Line { value, slope: (w2 + w2).mul_add(form, w1) })
                }
                [a, b, c, d, w0, w1, w2] => {
                    let form = a.mul_add(q[j], link.rest(b, c, q));
                    let y = form.mul_add(form, d);
                    let value = w2.mul_add(y, w1).mul_add(y, w0);
                    (a, Line { value, slope: (form + form) * (w2 + w2).mul_add(y, w1) })
                }
                [a, b, c, w0, w1, w2, w3, w4] => {
                    let form = a.mul_add(q[j], link.rest(b, c, q));
                    let value = cubic([w1, w2, w3, w4], form).mul_add(form, w0);
                    (a, Line { value, slope: cubic(cubic_derivative([w1, w2, w3, w4]), form) })
                }
                ref numbers => {
                    let (a, rest, coefficients) = link.parts(numbers, q);
                    (a, horner(coefficients, a.mul_add(q[j], rest)))
                }
            };
            sum.value += line.value;
            sum.slope = a.mul_add(line.slope, sum.slope);
        }
        sum
    }
}
