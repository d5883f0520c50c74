//! Eight coordinates with equal numbers of links, evaluated in SIMD lanes.

use super::link::{COLUMNS, Link, Wanted, cubic};
use afterbay_core::Scalar;
use afterbay_expression::{Graph, Node};
use std::ops::Range;

/// The number of coordinates in a block, and of SIMD lanes.
pub(super) const WIDTH: usize = 8;

/// Successive coordinates with equal numbers of links, for which cubics are wanted.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) first: usize,
    /// The other coordinates of each link, in all lanes.
    others: Vec<Others>,
    /// The range, among all numbers, of the columns of each link, in all lanes.
    numbers: Range<usize>,
}

/// The other coordinate i in each lane.
#[derive(Debug)]
enum Others {
    /// Successive coordinates from this one on.
    Row(usize),
    Any([usize; WIDTH]),
}

impl Block {
    /// The block of coordinates from `first` on, if their links are alike.
    pub(super) fn new(
        graph: &mut Graph,
        numbers: &mut Vec<Node>,
        first: usize,
        rows: [&[Link]; WIDTH],
        wanted: Wanted,
    ) -> Option<Self> {
        let (mut others, mut columns) = (Vec::new(), Vec::new());
        for k in 0..rows[0].len() {
            let mut of_link = Vec::with_capacity(WIDTH);
            for row in rows {
                of_link.push(row.get(k)?.column(graph, numbers, wanted)?);
            }
            columns.extend((0..COLUMNS).flat_map(|i| of_link.iter().map(move |column| column[i])));
            let any: [usize; WIDTH] =
                std::array::from_fn(|i| rows[i][k].other.unwrap_or(first + i));
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

    /// Adds the wanted quantity of each coordinate to its sum.
    #[inline(always)]
    pub(super) fn add<T: Scalar>(&self, numbers: &[T], q: &[T], sums: &mut [T; WIDTH]) {
        let Some(at) = q[self.first..].first_chunk::<WIDTH>() else { return };
        let (columns, _) = numbers[self.numbers.clone()].as_chunks::<WIDTH>();
        let (columns, _) = columns.as_chunks::<COLUMNS>();
        for (others, [a, b, c, c0, c1, c2, c3, factor]) in self.others.iter().zip(columns) {
            let other = match others {
                Others::Row(start) => q[*start..].first_chunk().copied().unwrap_or(*at),
                Others::Any(any) => any.map(|i| q[i]),
            };
            for i in 0..WIDTH {
                let form = a[i].mul_add(at[i], b[i].mul_add(other[i], c[i]));
                sums[i] = factor[i].mul_add(cubic([c0[i], c1[i], c2[i], c3[i]], form), sums[i]);
            }
        }
    }
}
