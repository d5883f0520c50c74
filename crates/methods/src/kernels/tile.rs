//! A tile of a chain or a ring: consecutive members and their neighbours on both sides, stored by
//! colour.

use super::reductions::all_finite;
use afterbay_core::{Quantity, State, StepFailure};
use std::ops::Range;

/// The number of members of a tile, even. q, p and w of both colours take 24 KiB.
pub(super) const TILE: usize = 1024;

/// A tile. Entry e of colour c is the member `first - margin + 2 e + c`.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) q: [Vec<f64>; 2],
    pub(super) p: [Vec<f64>; 2],
    pub(super) w: [Vec<f64>; 2],
    /// The number of members of the system, and whether it is a ring.
    n: usize,
    ring: bool,
    /// The number of neighbours on either side, even.
    margin: usize,
    /// The first of the tile's own members, and their number.
    first: usize,
    len: usize,
}

impl Tile {
    /// Creates a tile of a system of `n` members, for steps with up to `changes` changes of colour,
    /// an even number.
    pub(super) fn new(n: usize, ring: bool, changes: usize) -> Self {
        let margin = changes + 2;
        let zeros =
            || [0; 2].map(|_| vec![0.0; (TILE.min(n.next_multiple_of(2)) + 2 * margin) / 2]);
        Self { q: zeros(), p: zeros(), w: zeros(), n, ring, margin, first: 0, len: 0 }
    }

    /// Loads the members `first..first + len` and the neighbours needed for that many changes of
    /// colour.
    pub(super) fn load(
        &mut self,
        state: &State<Vec<f64>>,
        first: usize,
        len: usize,
        changes: usize,
    ) {
        (self.first, self.len, self.margin) = (first, len, changes + 2);
        let window = len.next_multiple_of(2) + 2 * self.margin;
        let edge = self.member(0, 0);
        for (to, from) in
            [(&mut self.q, &state.q), (&mut self.p, &state.p), (&mut self.w, &state.w)]
        {
            if self.ring {
                let mut at = 0;
                while at < window {
                    let member = (edge + at) % self.n;
                    let run = (self.n - member).min(window - at);
                    deal(&from[member..member + run], to, at / 2);
                    at += run;
                }
            } else {
                let before = self.margin.saturating_sub(first);
                let members = &from
                    [first + before - self.margin..from.len().min(first + window - self.margin)];
                if members.len() < window {
                    // The walls; entries beyond them are never read.
                    for (colour, to) in to.iter_mut().enumerate() {
                        to[..before / 2].fill(0.0);
                        to[(before + members.len() + 1 - colour) / 2..].fill(0.0);
                    }
                }
                deal(members, to, before / 2);
            }
        }
    }

    /// The entries of one colour that belong to the tile or to `beyond` members on either side of
    /// it.
    pub(super) fn range(&self, colour: usize, beyond: usize) -> Range<usize> {
        let (mut start, mut end) = (self.margin - beyond, self.margin + self.len + beyond);
        if !self.ring {
            start = start.max(self.margin.saturating_sub(self.first));
            end = end.min(self.margin + self.n - self.first);
        }
        (start + 1 - colour) / 2..(end + 1 - colour) / 2
    }

    /// The index of the member stored at an entry, plus a multiple of n.
    pub(super) fn member(&self, colour: usize, entry: usize) -> usize {
        (self.first + self.n * self.margin + 2 * entry + colour) - self.margin
    }

    /// Writes the tile's own members back.
    ///
    /// # Errors
    /// [`StepFailure::NonFinite`]
    pub(super) fn store(&self, new: [&mut [f64]; 3]) -> Result<(), StepFailure> {
        let quantities = [Quantity::Coordinate, Quantity::Momentum, Quantity::Reservoir];
        for ((from, to), quantity) in
            [&self.q, &self.p, &self.w].into_iter().zip(new).zip(quantities)
        {
            let [even, odd] = from.each_ref().map(|colour| &colour[self.margin / 2..]);
            let (pairs, last) = to.as_chunks_mut::<2>();
            for ((pair, &even), &odd) in pairs.iter_mut().zip(even).zip(odd) {
                *pair = [even, odd];
            }
            if let ([last], Some(&even)) = (last, even.get(self.len / 2)) {
                *last = even;
            }
            if !all_finite(to)
                && let Some(j) = to.iter().position(|x| !x.is_finite())
            {
                return Err(StepFailure::NonFinite { quantity, dof: self.first + j, value: to[j] });
            }
        }
        Ok(())
    }
}

/// Distributes the members to their colours, from entry `at` on.
fn deal(members: &[f64], [even, odd]: &mut [Vec<f64>; 2], at: usize) {
    let (even, odd) = (&mut even[at..], &mut odd[at..]);
    let (pairs, last) = members.as_chunks::<2>();
    for ((&[a, b], even), odd) in pairs.iter().zip(&mut *even).zip(odd) {
        (*even, *odd) = (a, b);
    }
    if let (&[last], Some(even)) = (last, even.get_mut(pairs.len())) {
        *even = last;
    }
}
