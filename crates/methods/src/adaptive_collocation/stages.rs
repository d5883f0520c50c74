//! Sweeps over the stages of Gauss collocation.
//!
//! ```text
//! p_i = p0 - h Σ a_ij f_j        q_i = q0 + h Σ a_ij v_j
//! v = ∂H/∂p                      f = ∂H/∂q + D(q, p, v)
//! ```
//!
//! If v = p, q_i = q0 + h τ_i p0 - h² Σ a_il a_lj f_j is computed directly. The functions are not
//! inlined, for the reason given in `points`.

use super::gauss::{Columns, Gauss, weighted};
use super::slopes::Slopes;
use crate::kernels::reductions::{max_norm, see_size};
use crate::points::{dissipation, gradient};
use afterbay_core::{Quantity, Scalar, State, StepFailure, System, Vector, larger_or_nan};
use std::array::from_fn;
use std::ops::Range;

/// The change in a sweep that is rounding, in roundings of the entries. A choice.
pub(super) const SWEEP_ROUNDINGS: f64 = 4.0;

/// The number of degrees of freedom computed side by side. With fewer, the nodes are computed side
/// by side.
const BLOCK: usize = 8;

/// The system at the nodes. With one degree of freedom each array is a vector of the processor,
/// and takes about twice the time where it crosses a cache line.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Stages<V, const K: usize> {
    pub(super) q: [V; K],
    pub(super) p: [V; K],
    /// ∂H/∂p and ∂H/∂q + D, from which the positions were computed.
    pub(super) v: [V; K],
    pub(super) f: [V; K],
    /// D_j v_j, the rates of the reservoirs.
    pub(super) loss: [V; K],
    hq: [V; K],
    hp: [V; K],
    d: [V; K],
}

/// `start + t_i h rate + factor Σ_j m_ij x_j` at the nodes.
struct Position<'a, V: Vector, const K: usize> {
    columns: &'a Columns<V::Scalar, K>,
    start: &'a V,
    rate: Option<(&'a V, [V::Scalar; K])>,
    factor: V::Scalar,
}

impl<V: Vector, const K: usize> Position<'_, V, K> {
    #[inline(never)]
    fn place(&self, from: &[V; K], to: &mut [V; K]) {
        let Self { columns, start, rate, factor } = self;
        let n = V::LEN.unwrap_or(start.as_slice().len());
        let start = &start.as_slice()[..n];
        let blocks = n / BLOCK;
        for block in 0..blocks {
            let d = block * BLOCK;
            let mut sums = [[V::Scalar::zero(); BLOCK]; K];
            for j in 0..K {
                let x: [V::Scalar; BLOCK] = from_fn(|b| from[j].as_slice()[d + b]);
                for (sums, &entry) in sums.iter_mut().zip(&columns[j]) {
                    for b in 0..BLOCK {
                        sums[b] = entry.mul_add(x[b], sums[b]);
                    }
                }
            }
            for i in 0..K {
                let mut base: [V::Scalar; BLOCK] = from_fn(|b| start[d + b]);
                if let Some((rate, times)) = rate {
                    let rate = &rate.as_slice()[d..d + BLOCK];
                    base = from_fn(|b| times[i].mul_add(rate[b], base[b]));
                }
                let to = &mut to[i].as_mut_slice()[d..d + BLOCK];
                for b in 0..BLOCK {
                    to[b] = factor.mul_add(sums[i][b], base[b]);
                }
            }
        }
        for d in blocks * BLOCK..n {
            let at = self.at(d, from_fn(|j| from[j].as_slice()[d]));
            for i in 0..K {
                to[i].as_mut_slice()[d] = at[i];
            }
        }
    }

    /// Evaluates one degree of freedom. Two partial sums shorten the chain of dependent operations.
    #[inline(always)]
    fn at(&self, d: usize, x: [V::Scalar; K]) -> [V::Scalar; K] {
        let mut sums = [[V::Scalar::zero(); K]; 2];
        for (j, column) in self.columns.iter().enumerate() {
            for (sum, &entry) in sums[j % 2].iter_mut().zip(column) {
                *sum = entry.mul_add(x[j], *sum);
            }
        }
        let mut at = [self.start.as_slice()[d]; K];
        if let Some((rate, times)) = &self.rate {
            for i in 0..K {
                at[i] = times[i].mul_add(rate.as_slice()[d], at[i]);
            }
        }
        for i in 0..K {
            at[i] = self.factor.mul_add(sums[0][i] + sums[1][i], at[i]);
        }
        at
    }
}

/// Applies the matrix to the values at the nodes.
pub(super) fn extrapolate<V: Vector, const K: usize>(
    columns: &Columns<V::Scalar, K>,
    zero: &V,
    from: &[V; K],
    to: &mut [V; K],
) {
    Position { columns, start: zero, rate: None, factor: V::Scalar::one() }.place(from, to);
}

impl<V: Vector, const K: usize> Stages<V, K> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || -> [V; K] { from_fn(|_| V::zeros(n)) };
        let [q, p, v, f, loss] = [zeros(), zeros(), zeros(), zeros(), zeros()];
        Self { q, p, v, f, loss, hq: zeros(), hp: zeros(), d: zeros() }
    }

    /// Computes q at the nodes from v.
    pub(super) fn place_q(&mut self, gauss: &Gauss<V::Scalar, K>, h: V::Scalar, state: &State<V>) {
        Position { columns: &gauss.once, start: &state.q, rate: None, factor: h }
            .place(&self.v, &mut self.q);
    }

    /// Takes one sweep. Returns the largest changes of q, p and energies.
    #[inline]
    pub(super) fn sweep<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        gauss: &Gauss<V::Scalar, K>,
        h: V::Scalar,
        state: &State<V>,
    ) -> [f64; 3] {
        let n = state.dof();
        let Self { q, p, v, f, loss, hq, hp, d } = self;
        let steps = gauss.nodes.map(|t| h * t);
        Position { columns: &gauss.once, start: &state.p, rate: None, factor: -h }.place(f, p);
        let mut moved_q = 0.0;
        let (weights, free) = (&gauss.weights, n - system.motors());
        if system.unit_mass() {
            let rate = Some((&state.p, steps));
            Position { columns: &gauss.twice, start: &state.q, rate, factor: -(h * h) }.place(f, q);
            gradient(system, q, p, hq, hp);
            dissipation(system, q, p, p, d);
            add(hq, d);
        } else {
            gradient(system, q, p, hq, hp);
            exchange(weights, hp, v, 0..n);
            Position { columns: &gauss.once, start: &state.q, rate: None, factor: h }.place(v, q);
            gradient(system, q, p, hq, hp);
            moved_q = exchange(weights, hp, v, 0..free);
            if free < n {
                exchange(weights, hp, v, free..n);
            }
            dissipation(system, q, p, v, d);
            add(hq, d);
        }
        let moved_p = exchange(weights, hq, f, 0..free);
        let supplied = if free < n { exchange(weights, hq, f, free..n) } else { 0.0 };
        let moved_w = if system.dissipation_form().zero {
            0.0
        } else {
            multiply(d, if system.unit_mass() { p } else { v }, n);
            exchange(weights, d, loss, 0..n)
        };
        let length = h.to_f64().abs();
        if system.unit_mass() {
            // q follows from the forces without the velocities.
            moved_q = 0.5 * length * moved_p;
        }
        [length * moved_q, length * moved_p, length * larger_or_nan(moved_w, supplied)]
    }

    /// Whether changes of q, p and energies in a sweep are roundings of their sizes in the step,
    /// with `free` degrees of freedom before motors. The tolerance does not show this: where an
    /// entry is far below the largest of the run, the error allowed for it is far above its
    /// rounding.
    pub(super) fn are_roundings(
        &self,
        moved: [f64; 3],
        h: V::Scalar,
        state: &State<V>,
        free: usize,
    ) -> bool {
        let last = K - 1;
        let [q, p] = [(&state.q, &self.q[last]), (&state.p, &self.p[last])].map(|(start, at)| {
            let ((start, supplied), at) = (start.as_slice().split_at(free), at.as_slice());
            [
                max_norm(start).max(max_norm(&at[..free])),
                max_norm(supplied).max(max_norm(&at[free..])),
            ]
        });
        let gain = h.to_f64().abs() * max_norm(self.loss[last].as_slice());
        let sizes = [q[0], p[0], max_norm(state.w.as_slice()).max(gain).max(p[1])];
        let largest = SWEEP_ROUNDINGS * V::Scalar::EPSILON;
        moved.iter().zip(sizes).all(|(&moved, size)| moved <= largest * size)
    }

    /// Computes p and q at the nodes from the given forces and velocities, and then the losses
    /// D_j v_j there.
    pub(super) fn place_and_dissipate<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        gauss: &Gauss<V::Scalar, K>,
        h: V::Scalar,
        state: &State<V>,
    ) {
        Position { columns: &gauss.once, start: &state.p, rate: None, factor: -h }
            .place(&self.f, &mut self.p);
        self.place_q(gauss, h, state);
        let Self { q, p, v, loss, .. } = self;
        if !system.dissipation_form().zero {
            dissipation(system, q, p, v, loss);
            multiply(loss, v, state.dof());
        }
    }
}

impl<V: Vector, const K: usize> Stages<V, K> {
    /// The degree of freedom whose forces differ most from those of the last sweep.
    #[cold]
    pub(super) fn restless<S: System<V::Scalar> + ?Sized>(&mut self, system: &S) -> usize {
        let Self { q, p, v, f, hq, hp, d, .. } = self;
        gradient(system, q, p, hq, hp);
        dissipation(system, q, p, if system.unit_mass() { p } else { v }, d);
        let n = q[0].as_slice().len();
        let moved = |j: usize| -> f64 {
            let change = |i: usize| hq[i].as_slice()[j] + d[i].as_slice()[j] - f[i].as_slice()[j];
            (0..K).map(|i| change(i).abs().to_f64()).sum()
        };
        (1..n).fold((0, moved(0)), |most, j| if moved(j) > most.1 { (j, moved(j)) } else { most }).0
    }

    /// The first force or velocity that is not finite, at the nodes or at the end.
    #[cold]
    pub(super) fn not_finite(&self, end: &Slopes<V>) -> StepFailure {
        let parts = [
            (Quantity::Force, &self.f, &end.f),
            (Quantity::Velocity, &self.v, &end.v),
            (Quantity::Reservoir, &self.loss, &end.loss),
        ];
        let all = parts.into_iter().flat_map(|(what, nodes, end)| {
            nodes.iter().chain([end]).map(move |x| (what, x.as_slice()))
        });
        StepFailure::non_finite(&all.collect::<Vec<_>>())
    }
}

#[inline(never)]
fn add<V: Vector, const K: usize>(to: &mut [V; K], d: &[V; K]) {
    for i in 0..K {
        let (to, d) = (to[i].as_mut_slice(), d[i].as_slice());
        for j in 0..V::LEN.unwrap_or(to.len()) {
            to[j] += d[j];
        }
    }
}

#[inline(never)]
fn multiply<V: Vector, const K: usize>(to: &mut [V; K], v: &[V; K], n: usize) {
    for i in 0..K {
        let (to, v) = (to[i].as_mut_slice(), v[i].as_slice());
        for j in 0..V::LEN.unwrap_or(n) {
            to[j] *= v[j];
        }
    }
}

/// Copies these entries of `from` to `to`. Returns the largest Σ b_i |change| of one, NaN if one is
/// not finite.
#[inline(never)]
fn exchange<V: Vector, const K: usize>(
    weights: &[V::Scalar; K],
    from: &[V; K],
    to: &mut [V; K],
    entries: Range<usize>,
) -> f64 {
    let (mut largest, mut d) = ([0.0; 2], entries.start);
    while d + BLOCK <= entries.end {
        let mut sums = [V::Scalar::zero(); BLOCK];
        for i in 0..K {
            let from = &from[i].as_slice()[d..d + BLOCK];
            let to = &mut to[i].as_mut_slice()[d..d + BLOCK];
            for b in 0..BLOCK {
                sums[b] = weights[i].mul_add((from[b] - to[b]).abs(), sums[b]);
            }
            to.copy_from_slice(from);
        }
        largest = sums.into_iter().fold(largest, |most, sum| see_size(most, sum.to_f64()));
        d += BLOCK;
    }
    for d in d..entries.end {
        let changes: [V::Scalar; K] =
            from_fn(|i| (from[i].as_slice()[d] - to[i].as_slice()[d]).abs());
        for i in 0..K {
            to[i].as_mut_slice()[d] = from[i].as_slice()[d];
        }
        largest = see_size(largest, weighted(weights, changes).to_f64());
    }
    largest[0] + largest[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_systems::FputChain;

    #[test]
    fn the_force_that_changed_most_is_found() {
        let system = FputChain::new(3, 1.0, 0.5).unwrap();
        let mut stages = Stages::<[f64; 3], 4>::new(3);
        stages.q = [[0.3, -0.2, 0.7]; 4];
        stages.p = [[1.0, 2.0, -3.0]; 4];
        // This computes the forces.
        stages.restless(&system);
        for changed in 0..3 {
            for i in 0..4 {
                stages.f[i] = from_fn(|j| stages.hq[i][j] + stages.d[i][j]);
            }
            stages.f[2][changed] += 1e-3;
            assert_eq!(stages.restless(&system), changed);
        }
    }
}
