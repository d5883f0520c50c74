//! Sums of ridge polynomials Σ W(y) along each coordinate, where y = ℓ or ℓ² + d, ℓ = a q_j + b q_i + c.
//!
//! As ℓ goes from r to s the mean of ∂W/∂q_j is a W[r, s], and the divided difference W[r, s] is what (W(ℓ) - W(r))/(ℓ - r) is at s;
//! for W(ℓ² + d) it is (r + s) W[r² + d, s² + d]. Horner's rule gives that quotient without a difference. Up to the fourth degree all
//! is written out; where there are many coordinates, what does not depend on the one before is done for some at once.

use afterbay_core::{Line, Scalar};
use afterbay_expression::{Graph, Node, Ridge};
use std::ops::Range;

/// A ridge polynomial along a coordinate.
#[derive(Debug)]
struct Link {
    /// i, unless b = 0
    other: Option<usize>,
    /// Among all numbers a, b, c and the coefficients of W, from w_0 to w_2, w_4 or a higher one; of y = ℓ² + d a, b, c, d, w_0, w_1
    /// and w_2, seven in all.
    numbers: Range<usize>,
}

/// What is wanted of all coordinates at once: the sums, or their derivatives by q_j.
#[derive(Clone, Copy)]
pub(super) enum Wanted {
    Slopes,
    Values,
}

/// The links of every coordinate.
#[derive(Debug)]
pub(super) struct Links {
    links: Vec<Link>,
    /// Where those of coordinate j end.
    ends: Vec<usize>,
    blocks: Vec<Block>,
}

/// Coordinates in a block.
const WIDE: usize = 8;
/// Numbers of each of its links and coordinates.
const COLUMNS: usize = 8;

/// Coordinates in a row with as many links each, of which cubics are wanted.
#[derive(Debug)]
struct Block {
    first: usize,
    /// Of each link, for all coordinates.
    others: Vec<Others>,
    /// a, b, c, the coefficients of a cubic and its factor of each link, each for all coordinates.
    numbers: Range<usize>,
}

/// i of links side by side.
#[derive(Debug)]
enum Others {
    /// One after the other from here.
    Row(usize),
    Any([usize; WIDE]),
}

impl Links {
    /// The ridges along each coordinate, their numbers added to `numbers`. None if one is of two others, or of a high degree in ℓ² + d.
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
        while first + WIDE <= along.len() {
            let block =
                Block::new(graph, numbers, first, std::array::from_fn(|i| links.of(first + i)), wanted);
            first += if block.is_some() { WIDE } else { 1 };
            links.blocks.extend(block);
        }
        Some(links)
    }

    #[inline(always)]
    fn of(&self, j: usize) -> &[Link] {
        let start = if j == 0 { 0 } else { self.ends[j - 1] };
        &self.links[start..self.ends[j]]
    }

    /// The derivatives of the sum, of links made for slopes.
    #[inline(always)]
    pub(super) fn slopes<T: Scalar>(&self, numbers: &[T], q: &[T], to: &mut [T]) {
        if !self.blocks.is_empty() {
            return self.in_blocks(numbers, q, Wanted::Slopes, to);
        }
        for (j, to) in to.iter_mut().enumerate() {
            *to = self.slope(numbers, q, j, q[j]);
        }
    }

    /// The sums, of links made for values.
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
                let mut sums = [T::zero(); WIDE];
                block.add(numbers, q, &mut sums);
                to[block.first..block.first + WIDE].copy_from_slice(&sums);
            }
        }
    }

    /// All sums in one, of links made for values.
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
        let mut sums = [T::zero(); WIDE];
        for (single, block) in self.runs() {
            for j in single {
                sums[j % WIDE] += self.value(numbers, q, j).value;
            }
            if let Some(block) = block {
                block.add(numbers, q, &mut sums);
            }
        }
        sums.into_iter().fold(T::zero(), |sum, x| sum + x)
    }

    /// The coordinates one by one before each block, and those after the last.
    fn runs(&self) -> impl Iterator<Item = (Range<usize>, Option<&Block>)> {
        let starts = std::iter::once(0).chain(self.blocks.iter().map(|block| block.first + WIDE));
        let ends = self.blocks.iter().map(|block| (block.first, Some(block)));
        starts.zip(ends.chain([(self.ends.len(), None)])).map(|(start, (end, block))| (start..end, block))
    }

    /// The derivative of the sum by q_j, at q with q_j moved to `at`.
    #[inline(always)]
    pub(super) fn slope<T: Scalar>(&self, numbers: &[T], q: &[T], j: usize, at: T) -> T {
        let mut sum = T::zero();
        for link in self.of(j) {
            let (a, slope) = match numbers[link.numbers.clone()] {
                [a, b, c, _, w1, w2] => (a, (w2 + w2).mul_add(a.mul_add(at, link.rest(b, c, q)), w1)),
                [a, b, c, d, _, w1, w2] => {
                    let form = a.mul_add(at, link.rest(b, c, q));
                    (a, (form + form) * (w2 + w2).mul_add(form.mul_add(form, d), w1))
                }
                [a, b, c, _, w1, w2, w3, w4] => {
                    (a, cubic(by_form([w1, w2, w3, w4]), a.mul_add(at, link.rest(b, c, q))))
                }
                ref numbers => {
                    let (a, rest, coefficients) = link.parts(numbers, q);
                    (a, horner(coefficients, a.mul_add(at, rest)).slope)
                }
            };
            sum = a.mul_add(slope, sum);
        }
        sum
    }

    /// The mean of that derivative from q to q with q_j moved to `to`, and its own derivative by `to`.
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
                    (a, Line { value: sum * mean, slope: (sum * (w2 * s)).mul_add(T::from_f64(2.0), mean) })
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
                    (a, divided(coefficients, a.mul_add(q[j], rest), a.mul_add(to, rest)))
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
                    (a, Line { value, slope: cubic(by_form([w1, w2, w3, w4]), form) })
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

impl Link {
    fn new(graph: &mut Graph, numbers: &mut Vec<Node>, ridge: &Ridge, j: usize) -> Option<Self> {
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

    /// Its column in a block, where what is wanted of it is a cubic.
    fn column(&self, graph: &mut Graph, numbers: &[Node], wanted: Wanted) -> Option<[Node; COLUMNS]> {
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
    fn rest<T: Scalar>(&self, b: T, c: T, q: &[T]) -> T {
        match self.other {
            Some(i) => b.mul_add(q[i], c),
            None => c,
        }
    }

    /// a, b q_i + c, and the coefficients.
    fn parts<'a, T: Scalar>(&self, numbers: &'a [T], q: &[T]) -> (T, T, &'a [T]) {
        match numbers {
            &[a, b, c, ref coefficients @ ..] => (a, self.rest(b, c, q), coefficients),
            _ => (T::zero(), T::zero(), &[]),
        }
    }
}

impl Block {
    /// The coordinates from `first` on, if they make one.
    fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        first: usize,
        rows: [&[Link]; WIDE],
        wanted: Wanted,
    ) -> Option<Self> {
        let (mut others, mut columns) = (Vec::new(), Vec::new());
        for k in 0..rows[0].len() {
            let mut of_link = Vec::with_capacity(WIDE);
            for row in rows {
                of_link.push(row.get(k)?.column(graph, numbers, wanted)?);
            }
            columns.extend((0..COLUMNS).flat_map(|i| of_link.iter().map(move |column| column[i])));
            let any: [usize; WIDE] = std::array::from_fn(|i| rows[i][k].other.unwrap_or(first + i));
            let row = any.is_sorted_by(|a, b| a + 1 == *b);
            others.push(if row { Others::Row(any[0]) } else { Others::Any(any) });
        }
        let alike = rows.iter().all(|row| row.len() == rows[0].len());
        alike.then(|| {
            let start = numbers.len();
            numbers.extend(columns);
            Self { first, others, numbers: start..numbers.len() }
        })
    }

    /// Adds what is wanted of each coordinate to its sum.
    #[inline(always)]
    fn add<T: Scalar>(&self, numbers: &[T], q: &[T], sums: &mut [T; WIDE]) {
        let Some(at) = q[self.first..].first_chunk::<WIDE>() else { return };
        let (columns, _) = numbers[self.numbers.clone()].as_chunks::<WIDE>();
        let (columns, _) = columns.as_chunks::<COLUMNS>();
        for (others, [a, b, c, c0, c1, c2, c3, factor]) in self.others.iter().zip(columns) {
            let other = match others {
                Others::Row(start) => q[*start..].first_chunk().copied().unwrap_or(*at),
                Others::Any(any) => any.map(|i| q[i]),
            };
            for i in 0..WIDE {
                let form = a[i].mul_add(at[i], b[i].mul_add(other[i], c[i]));
                sums[i] = factor[i].mul_add(cubic([c0[i], c1[i], c2[i], c3[i]], form), sums[i]);
            }
        }
    }
}

/// The coefficients of W' for those of W from w_1 to w_4.
#[inline(always)]
fn by_form<T: Scalar>([w1, w2, w3, w4]: [T; 4]) -> [T; 4] {
    let twice = w4 + w4;
    [w1, w2 + w2, w3 + w3 + w3, twice + twice]
}

/// c_0 + c_1 x + c_2 x² + c_3 x³, no more than three operations one after the other.
#[inline(always)]
fn cubic<T: Scalar>([c0, c1, c2, c3]: [T; 4], x: T) -> T {
    (x * x).mul_add(c3.mul_add(x, c2), c1.mul_add(x, c0))
}

/// Σ c_k xᵏ and its derivative.
#[inline(never)]
fn horner<T: Scalar>(coefficients: &[T], x: T) -> Line<T> {
    let zero = Line { value: T::zero(), slope: T::zero() };
    coefficients.iter().rev().fold(zero, |Line { value, slope }, &c| Line {
        value: value.mul_add(x, c),
        slope: slope.mul_add(x, value),
    })
}

/// (Σ c_k sᵏ - Σ c_k rᵏ) / (s - r) and its derivative by s.
#[inline(never)]
fn divided<T: Scalar>(coefficients: &[T], r: T, s: T) -> Line<T> {
    let mut quotient = T::zero();
    let mut line = Line { value: quotient, slope: quotient };
    for &c in coefficients.iter().skip(1).rev() {
        quotient = quotient.mul_add(r, c);
        line = Line { value: line.value.mul_add(s, quotient), slope: line.slope.mul_add(s, line.value) };
    }
    line
}
