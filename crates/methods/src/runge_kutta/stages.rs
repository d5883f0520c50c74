//! The stages of an explicit Runge-Kutta step, and their weighted sums.

use super::tableau::{Tableau, Terms, number};
use crate::kernels::reductions::{larger, see_size};
use afterbay_core::{Scalar, State, System, Vector};
use std::array::from_fn;
use std::ops::{Range, RangeTo};

/// The largest number of stages of a tableau.
const STAGES: usize = 16;

/// The parts of the state: q, p and w.
pub(crate) const Q: usize = 0;
pub(crate) const P: usize = 1;
pub(crate) const W: usize = 2;

/// The slopes of q, p and w at the stages.
#[derive(Clone, Debug)]
pub(crate) struct Stages<V: Vector> {
    /// `[∂H/∂p, -∂H/∂q - D, D_j ∂H/∂p_j]`
    slopes: [[V; 3]; STAGES],
    /// ∂H/∂q at the start, and at the stage computed last.
    pub(crate) start: V,
    pub(crate) hq: V,
    /// The point of a stage, and D there.
    q: V,
    p: V,
    d: V,
    zero: V,
    dissipative: bool,
}

impl<V: Vector> Stages<V> {
    /// Memory for the first `stages` stages.
    pub(crate) fn new<S: System<V::Scalar> + ?Sized>(system: &S, stages: usize) -> Self {
        let n = system.dof();
        let zeros = || V::zeros(n);
        Self {
            slopes: from_fn(|i| from_fn(|_| V::zeros(if i < stages { n } else { 0 }))),
            start: zeros(),
            hq: zeros(),
            q: zeros(),
            p: zeros(),
            d: zeros(),
            zero: zeros(),
            dissipative: !system.dissipation_form().zero,
        }
    }

    /// Whether the reservoirs have slopes.
    pub(crate) fn is_dissipative(&self) -> bool {
        self.dissipative
    }

    /// The slopes of q and p at the stage.
    pub(crate) fn slopes(&self, stage: usize) -> [&V; 2] {
        let [q, p, _] = &self.slopes[stage];
        [q, p]
    }

    /// ∂H/∂p at the stage.
    pub(crate) fn velocity(&self, stage: usize) -> &V {
        &self.slopes[stage][Q]
    }

    /// Computes the first stage, which is the state itself.
    #[inline]
    pub(crate) fn begin<S: System<V::Scalar> + ?Sized>(&mut self, system: &S, state: &State<V>) {
        self.evaluate_at(system, 0, [&state.q, &state.p]);
        self.start.as_mut_slice().copy_from_slice(self.hq.as_slice());
    }

    /// Computes the other stages of the step h from `state`.
    #[inline]
    pub(crate) fn advance<B, S>(&mut self, system: &S, h: V::Scalar, state: &State<V>)
    where
        B: Tableau,
        S: System<V::Scalar> + ?Sized,
    {
        self.advance_seen::<B, S>(system, h, state, |_, _| {});
    }

    /// Computes the other stages as `advance` does, and passes the point (q, p) of each to `see`.
    #[inline]
    pub(crate) fn advance_seen<B, S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        mut see: impl FnMut(&[V::Scalar], &[V::Scalar]),
    ) where
        B: Tableau,
        S: System<V::Scalar> + ?Sized,
    {
        // Unrolled, so that the coefficients of each stage are constants for the compiler.
        macro_rules! stages {
            ($($stage:literal)*) => {
                $(if $stage < B::ROWS.len() {
                    self.stage::<B, S, $stage>(system, h, state);
                    see(self.q.as_slice(), self.p.as_slice());
                })*
            };
        }
        stages!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15);
    }

    #[inline]
    fn stage<B, S, const I: usize>(&mut self, system: &S, h: V::Scalar, state: &State<V>)
    where
        B: Tableau,
        S: System<V::Scalar> + ?Sized,
    {
        let row = B::ROWS[I];
        combine::<V, Q>(row, &self.slopes, h, &state.q, &mut self.q);
        combine::<V, P>(row, &self.slopes, h, &state.p, &mut self.p);
        self.evaluate_slopes(system, I);
    }

    /// Computes the slopes at (q, p), in the place of a stage.
    #[inline]
    pub(crate) fn evaluate_at<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        stage: usize,
        [q, p]: [&V; 2],
    ) {
        self.q.as_mut_slice().copy_from_slice(q.as_slice());
        self.p.as_mut_slice().copy_from_slice(p.as_slice());
        self.evaluate_slopes(system, stage);
    }

    /// The point (q, p) of the stage computed last.
    pub(crate) fn point(&self) -> [&V; 2] {
        [&self.q, &self.p]
    }

    /// Computes the slopes at the point of a stage.
    #[inline(always)]
    fn evaluate_slopes<S: System<V::Scalar> + ?Sized>(&mut self, system: &S, stage: usize) {
        let Self { slopes, hq, q, p, d, dissipative, .. } = self;
        let [v, force, loss] = &mut slopes[stage];
        let (q, p, hq) = (q.as_slice(), p.as_slice(), hq.as_mut_slice());
        let n = V::LEN.unwrap_or(q.len());
        let (v, force) = (&mut v.as_mut_slice()[..n], &mut force.as_mut_slice()[..n]);
        system.gradient(q, p, hq, v);
        let hq = &hq[..n];
        if *dissipative {
            system.dissipation(q, p, v, d.as_mut_slice());
            let (d, loss) = (&d.as_slice()[..n], &mut loss.as_mut_slice()[..n]);
            for j in 0..n {
                force[j] = -(hq[j] + d[j]);
                loss[j] = d[j] * v[j];
            }
        } else {
            for j in 0..n {
                force[j] = -hq[j];
            }
        }
    }

    /// Computes `factor` times the sum of the slopes of q, p or w with these coefficients.
    #[inline(always)]
    pub(crate) fn sum<const PART: usize>(&self, terms: Terms, factor: V::Scalar, to: &mut V) {
        combine::<V, PART>(terms, &self.slopes, factor, &self.zero, to);
    }

    /// The largest absolute value among these entries of the sum of the slopes of q, p or w with
    /// these coefficients, NaN if one is not finite.
    #[inline(always)]
    pub(crate) fn largest_sum<const PART: usize>(
        &self,
        terms: Terms,
        entries: Range<usize>,
    ) -> f64 {
        largest_sum::<V, PART>(terms, &self.slopes, entries)
    }

    /// The largest absolute entry of the sum in each lane, of the entries of a range. Comparisons
    /// ignore NaN.
    #[inline(always)]
    pub(crate) fn largest_in_lanes<const PART: usize>(
        &self,
        terms: Terms,
        entries: RangeTo<usize>,
    ) -> V::Scalar {
        (0..entries.end).fold(V::Scalar::zero(), |most, j| {
            larger(most, &sum_of_block::<V, PART, 1>(terms, &self.slopes, j)[0])
        })
    }

    /// Computes `start` plus `factor` times the sum of the slopes of q, p or w with these
    /// coefficients.
    #[inline(always)]
    pub(crate) fn add<const PART: usize>(
        &self,
        terms: Terms,
        factor: V::Scalar,
        start: &V,
        to: &mut V,
    ) {
        combine::<V, PART>(terms, &self.slopes, factor, start, to);
    }
}

/// max |Σ a_k slope_k| over these entries, NaN if one is not finite.
#[inline(always)]
fn largest_sum<V: Vector, const PART: usize>(
    terms: Terms,
    slopes: &[[V; 3]; STAGES],
    entries: Range<usize>,
) -> f64 {
    if let Some(n) = V::LEN {
        // A constant number of entries lets the loop be unrolled.
        let entries = if entries == (0..n) { 0..n } else { entries };
        let largest = entries.fold([0.0; 2], |largest, j| {
            see(largest, sum_of_block::<V, PART, 1>(terms, slopes, j)[0])
        });
        return largest[0] + largest[1];
    }
    let (mut largest, mut done, n) = ([0.0; 2], entries.start, entries.end);
    largest_in_blocks::<V, PART, 16>(terms, slopes, &mut largest, &mut done, n);
    largest_in_blocks::<V, PART, 1>(terms, slopes, &mut largest, &mut done, n);
    largest[0] + largest[1]
}

/// Adds the blocks of WIDTH numbers that remain after the first `done` to the largest number so
/// far.
#[inline(never)]
fn largest_in_blocks<V: Vector, const PART: usize, const WIDTH: usize>(
    terms: Terms,
    slopes: &[[V; 3]; STAGES],
    largest: &mut [f64; 2],
    done: &mut usize,
    n: usize,
) {
    let mut lanes = [[0.0; 2]; WIDTH];
    while *done + WIDTH <= n {
        let sums = sum_of_block::<V, PART, WIDTH>(terms, slopes, *done);
        lanes = from_fn(|b| see(lanes[b], sums[b]));
        *done += WIDTH;
    }
    for [most, poison] in lanes {
        *largest = [if most > largest[0] { most } else { largest[0] }, largest[1] + poison];
    }
}

/// [`see_size`] for |x|.
#[inline(always)]
fn see<T: Scalar>(found: [f64; 2], x: T) -> [f64; 2] {
    see_size(found, x.to_f64().abs())
}

/// Σ a_k slope_k of WIDTH numbers from the index `from`.
#[inline(always)]
fn sum_of_block<V: Vector, const PART: usize, const WIDTH: usize>(
    terms: Terms,
    slopes: &[[V; 3]; STAGES],
    from: usize,
) -> [V::Scalar; WIDTH] {
    terms.iter().fold([V::Scalar::zero(); WIDTH], |sums, &(k, a)| {
        let (a, x) = (number::<V::Scalar>(a), &slopes[k][PART].as_slice()[from..from + WIDTH]);
        from_fn(|b| a.mul_add(x[b], sums[b]))
    })
}

/// start + factor Σ a_k slope_k
#[inline(always)]
fn combine<V: Vector, const PART: usize>(
    terms: Terms,
    slopes: &[[V; 3]; STAGES],
    factor: V::Scalar,
    start: &V,
    to: &mut V,
) {
    if let Some(n) = V::LEN {
        // The number of terms is a constant for the compiler.
        for j in 0..n {
            let [sum] = sum_of_block::<V, PART, 1>(terms, slopes, j);
            to.as_mut_slice()[j] = factor.mul_add(sum, start.as_slice()[j]);
        }
    } else {
        let (start, to) = (start.as_slice(), to.as_mut_slice());
        let mut done = 0;
        done = combine_blocks::<V, PART, 32>(terms, slopes, factor, start, to, done);
        done = combine_blocks::<V, PART, 8>(terms, slopes, factor, start, to, done);
        combine_blocks::<V, PART, 1>(terms, slopes, factor, start, to, done);
    }
}

/// Combines as many blocks of WIDTH numbers as remain after the first `done` numbers. Returns the
/// number of entries done.
#[inline(never)]
fn combine_blocks<V: Vector, const PART: usize, const WIDTH: usize>(
    terms: Terms,
    slopes: &[[V; 3]; STAGES],
    factor: V::Scalar,
    start: &[V::Scalar],
    to: &mut [V::Scalar],
    mut done: usize,
) -> usize {
    for (to, start) in
        to[done..].as_chunks_mut::<WIDTH>().0.iter_mut().zip(start[done..].as_chunks::<WIDTH>().0)
    {
        let sums = sum_of_block::<V, PART, WIDTH>(terms, slopes, done);
        *to = from_fn(|b| factor.mul_add(sums[b], start[b]));
        done += WIDTH;
    }
    done
}
