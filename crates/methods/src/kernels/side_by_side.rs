//! Sweeps over the members of a tile, eight members of one colour side by side.
//!
//! The equation of a member is solved in lanes by two evaluations; by more if a lane needs them;
//! and one member at a time if the lanes do not converge together. A lane computes the numbers of a
//! single member, so all three give the same bits.

use super::tile::{TILE, Tile};
use crate::increment::{Composition, Member, Stride, advance};
use afterbay_core::solver::{Equation, Newton, Root, Solver};
use afterbay_core::{EndMembers, Scalar, Separable, State, StepFailure, Uniform, f64x8};
use bytemuck::{bytes_of, pod_read_unaligned};
use std::array::from_fn;

/// The number of members updated at a time.
const LANES: usize = 8;

/// The parameters of the steps, shared by all tiles.
pub(super) struct Steps<'a, S: Uniform + ?Sized> {
    pub(super) system: &'a S,
    pub(super) lanes: &'a S::Lanes,
    pub(super) ends: Option<&'a EndMembers>,
    pub(super) h: f64,
    pub(super) count: usize,
    pub(super) dissipative: bool,
    pub(super) old: &'a State<Vec<f64>>,
}

impl<S: Uniform + ?Sized> Steps<'_, S> {
    /// Moves the members from `first` on, tile by tile. Returns the number of evaluations.
    pub(super) fn carry(
        &self,
        composition: &Composition,
        tile: &mut Tile,
        first: usize,
        [q, p, w]: [&mut [f64]; 3],
    ) -> Result<u64, StepFailure> {
        let mut evaluations = 0;
        let sweeps = composition.sweeps();
        let new = q.chunks_mut(TILE).zip(p.chunks_mut(TILE)).zip(w.chunks_mut(TILE));
        for (i, ((q, p), w)) in new.enumerate() {
            let mut changes = self.count * sweeps.next_multiple_of(2);
            tile.load(self.old, first + i * TILE, q.len(), changes);
            for _ in 0..self.count {
                for (sweep, fraction) in composition.fractions::<f64>().enumerate() {
                    for colour in if sweep % 2 == 0 { [0, 1] } else { [1, 0] } {
                        evaluations += self.sweep(fraction * self.h, tile, colour, changes)?;
                        // The next sweep begins with the colour with which this one ends.
                        changes -= usize::from(colour == sweep % 2);
                    }
                }
                // The next step begins with that colour too if the number of sweeps is even.
                changes -= sweeps % 2;
            }
            tile.store([q, p, w])?;
        }
        Ok(evaluations)
    }

    /// Updates the members of one colour: the tile's own, and beyond its ends as many as there are
    /// changes of colour to come.
    #[inline]
    fn sweep(
        &self,
        h: f64,
        tile: &mut Tile,
        colour: usize,
        beyond: usize,
    ) -> Result<u64, StepFailure> {
        let mut range = tile.range(colour, beyond);
        let mut evaluations = 0;
        if let Some([first, last]) = self.ends {
            let n = self.old.q.len();
            if !range.is_empty() && tile.member(colour, range.start).is_multiple_of(n) {
                evaluations += self.end(&**first, h, tile, [colour, range.start])?;
                range.start += 1;
            }
            if !range.is_empty() && tile.member(colour, range.end - 1) % n == n - 1 {
                evaluations += self.end(&**last, h, tile, [colour, range.end - 1])?;
                range.end -= 1;
            }
        }
        let mut member = tile.member(colour, range.start);
        let [[q, beside], [p, _], [w, _]] = [&mut tile.q, &mut tile.p, &mut tile.w]
            .map(|[even, odd]| if colour == 0 { [even, odd] } else { [odd, even] });
        let left = &beside[range.start + colour - 1..range.end + colour - 1];
        let right = &beside[range.start + colour..range.end + colour];
        let (left, left_rest) = left.as_chunks();
        let (right, right_rest) = right.as_chunks();
        let (q, q_rest) = q[range.clone()].as_chunks_mut();
        let (p, p_rest) = p[range.clone()].as_chunks_mut();
        let (w, w_rest) = w[range].as_chunks_mut();
        // Members that need more iterations are often adjacent.
        let mut ordinary = true;
        for ((((q, p), w), left), right) in q.iter_mut().zip(p).zip(w).zip(left).zip(right) {
            evaluations += self.lanes(h, member, [left, right], [q, p, w], &mut ordinary)?;
            member += 2 * LANES;
        }
        if !q_rest.is_empty() {
            // Lanes without a member repeat the last one.
            let fill = |rest: &[f64]| -> [f64; LANES] { from_fn(|k| rest[k.min(rest.len() - 1)]) };
            let (mut q, mut p, mut w) = (fill(q_rest), fill(p_rest), fill(w_rest));
            let beside = [&fill(left_rest), &fill(right_rest)];
            evaluations +=
                self.lanes(h, member, beside, [&mut q, &mut p, &mut w], &mut ordinary)?;
            for (rest, lanes) in [(q_rest, q), (p_rest, p), (w_rest, w)] {
                let len = rest.len();
                rest.copy_from_slice(&lanes[..len]);
            }
        }
        Ok(evaluations)
    }

    /// Updates the first or the last member of a chain, whose equation differs from the others'.
    #[cold]
    fn end(
        &self,
        end: &dyn Separable<f64>,
        h: f64,
        tile: &mut Tile,
        [colour, entry]: [usize; 2],
    ) -> Result<u64, StepFailure> {
        let dof = tile.member(colour, entry) % self.old.q.len();
        let beside = &tile.q[1 - colour];
        let (left, right) = (beside[entry + colour - 1], beside[entry + colour]);
        let (mut window, mut momenta) =
            ([left, tile.q[colour][entry], right], [0.0, tile.p[colour][entry], 0.0]);
        let beside = [&mut window[..], &mut momenta];
        let (stride, member) = (Stride { h, largest_q: 0.0 }, Member { index: 1, dof });
        let moved = advance(end, &Newton, stride, member, beside, self.dissipative)?;
        tile.q[colour][entry] = moved.q;
        tile.p[colour][entry] = moved.p;
        tile.w[colour][entry] += moved.dw;
        Ok(moved.evaluations)
    }

    /// Updates eight members between the given neighbours: `member` and every second one after it.
    #[inline(always)]
    fn lanes(
        &self,
        h: f64,
        member: usize,
        beside: [&[f64; LANES]; 2],
        moved: [&mut [f64; LANES]; 3],
        ordinary: &mut bool,
    ) -> Result<u64, StepFailure> {
        let [q, p, w] = moved;
        if *ordinary
            && let Some(evaluations) = self.together(&Ordinary, h, member, beside, [q, p, w])
        {
            return Ok(evaluations);
        }
        let evaluations = self.carefully(h, member, beside, [q, p, w])?;
        *ordinary = evaluations <= 2 * LANES as u64;
        Ok(evaluations)
    }

    /// Updates the lanes if two evaluations may not be enough.
    #[cold]
    #[inline(never)]
    fn carefully(
        &self,
        h: f64,
        member: usize,
        beside: [&[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Result<u64, StepFailure> {
        match self.together(&Direct, h, member, beside, [q, p, w]) {
            Some(evaluations) => Ok(evaluations),
            None => self.one_by_one(h, member, beside.map(|x| *x), [q, p, w]),
        }
    }

    /// Solves all lanes together, if every lane converges.
    #[inline(always)]
    fn together(
        &self,
        solver: &impl Solver,
        h: f64,
        member: usize,
        [left, right]: [&[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Option<u64> {
        let zero = f64x8::from_f64(0.0);
        // One load each; passed by value, the arrays would go through the stack.
        let load = |x: &[f64; LANES]| -> f64x8 { pod_read_unaligned(bytes_of(x)) };
        let (mut window, mut momenta) = ([load(left), load(q), load(right)], [zero, load(p), zero]);
        let beside = [&mut window[..], &mut momenta];
        let stride = Stride { h: f64x8::from_f64(h), largest_q: zero };
        let member = Member { index: 1, dof: member };
        let moved = advance(self.lanes, solver, stride, member, beside, self.dissipative).ok()?;
        (*q, *p) = (moved.q.to_array(), moved.p.to_array());
        if self.dissipative {
            *w = (load(w) + moved.dw).to_array();
        }
        Some(LANES as u64 * moved.evaluations)
    }

    /// Solves each member alone.
    #[cold]
    #[inline(never)]
    fn one_by_one(
        &self,
        h: f64,
        member: usize,
        [left, right]: [[f64; LANES]; 2],
        [q, p, w]: [&mut [f64; LANES]; 3],
    ) -> Result<u64, StepFailure> {
        let mut evaluations = 0;
        let stride = Stride { h, largest_q: 0.0 };
        for k in 0..LANES {
            let dof = (member + 2 * k) % self.old.q.len();
            let (mut window, mut momenta) = ([left[k], q[k], right[k]], [0.0, p[k], 0.0]);
            let beside = [&mut window[..], &mut momenta];
            let member = Member { index: 1, dof };
            let moved = advance(self.system, &Newton, stride, member, beside, self.dissipative)?;
            (q[k], p[k]) = (moved.q, moved.p);
            w[k] += moved.dw;
            evaluations += moved.evaluations;
        }
        Ok(evaluations)
    }
}

/// Newton's iteration with exactly two evaluations.
struct Ordinary;

impl Solver for Ordinary {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let root = Newton::ordinary(start, equation);
        root.ok_or(StepFailure::NewtonStalled { dof, iterations: 2, update: 0.0 })
    }
}

/// Newton's direct iteration; if a lane does not converge, each member is solved alone.
struct Direct;

impl Solver for Direct {
    #[inline(always)]
    fn solve<T: Scalar>(
        &self,
        dof: usize,
        start: T,
        equation: impl Equation<T>,
    ) -> Result<Root<T>, StepFailure> {
        let root = Newton::direct(start, equation);
        root.ok_or(StepFailure::NewtonStalled { dof, iterations: 0, update: 0.0 })
    }
}
