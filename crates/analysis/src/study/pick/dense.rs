//! The reference at any time, by Hermite interpolation of degree 7 between its states.

use crate::Solution;
use crate::measured::Doubt;
use crate::progress::Progress;
use crate::solution::apart;
use crate::study::Problem;
use crate::study::kept::LargestEnergy;
use afterbay_core::{InputError, IntegrateError, StateRef, System};

/// Equally spaced states with the slopes of q, p and w.
pub(super) struct Dense {
    exact: Solution<f64>,
    spacing: f64,
    slopes: Vec<f64>,
    /// The error of the interpolation in each cell between two states.
    cells: Vec<Doubt>,
}

/// The number of states at first, and the most numbers stored.
const FEWEST: usize = 256;
const MOST_NUMBERS: usize = 1 << 22;
/// The interpolation error aimed at, as a share of the wanted error.
const SHARE: f64 = 1e-3;
/// The least interpolation error aimed at, as a share of the largest number: its rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// States are no longer added if the interpolation error does not fall below this share of its
/// former value, and misses the goal in few of many cells. These cells contain kinks.
const LEAST_FALL: f64 = 0.25;
/// The share of the cells below which they are few.
const FEW_CELLS: f64 = 0.02;
/// The number of cells from which on they are many.
const MANY_CELLS: usize = 1 << 14;
/// The parts of a run in which the resolution is examined, and the number of parts without it that
/// counts.
const PARTS: usize = 64;
const FEWEST_PARTS: usize = 4;
/// The relative difference of two times, below which it is their rounding.
const SAME_TIME: f64 = 4.0 * f64::EPSILON;
/// The least factor by which the number of states grows at once.
const LEAST_LEAP: f64 = 1.5;
/// The largest one.
const LARGEST_LEAP: f64 = 16.0;

impl Dense {
    /// Raises the number of states until the interpolation resolves errors of `bound` in every
    /// cell, except beside kinks.
    ///
    /// # Errors
    /// Errors of the reference.
    pub(super) fn new(
        problem: &Problem,
        bound: f64,
        progress: &dyn Progress,
    ) -> Result<Self, IntegrateError> {
        let system = problem.model.system::<f64>()?;
        let most = (MOST_NUMBERS / (6 * problem.model.dof())).max(FEWEST);
        let goal = |exact: &Solution<f64>| {
            (SHARE * bound).max(ROUNDING * exact.sizes().into_iter().fold(0.0, f64::max))
        };
        let (mut count, mut before, mut last) = (FEWEST, None::<Self>, None::<f64>);
        loop {
            let spacing = problem.end / count as f64;
            let exact = match (problem.solution(spacing, count, progress), before.take()) {
                (Ok(exact), _) => exact,
                (Err(error), None) | (Err(error @ IntegrateError::Interrupted), _) => {
                    return Err(error);
                }
                // If more states cannot be computed, the result with fewer is used.
                (Err(_), Some(before)) => return Ok(before),
            };
            let goal = goal(&exact);
            let dense = Self::of(&*system, exact, spacing);
            // More states do not help where a slope is not a number.
            let worst = dense.cells.iter().map(|doubt| doubt.most()).fold(0.0, f64::max);
            let misses = dense.cells.iter().filter(|doubt| doubt.most() > goal).count();
            // Eight times as many states divide the error by 8⁸, except beside a kink.
            let factor = (1.2 * (worst / goal).powf(0.125)).clamp(LEAST_LEAP, LARGEST_LEAP);
            let next = 2 * (0.5 * count as f64 * factor).ceil() as usize;
            let falls = last.is_none_or(|last| worst < LEAST_FALL * last);
            let at_kinks =
                !falls && count >= MANY_CELLS && (misses as f64) < FEW_CELLS * count as f64;
            if misses == 0 || at_kinks || next > most {
                return Ok(dense);
            }
            (last, before, count) = (Some(worst), Some(dense), next);
        }
    }

    /// Interpolates an even number of cells, at least eight.
    fn of(system: &dyn System<f64>, exact: Solution<f64>, spacing: f64) -> Self {
        let n = system.dof();
        let mut slopes = vec![0.0; 3 * n * exact.len()];
        let mut force = vec![0.0; n];
        for (state, slopes) in exact.states().zip(slopes.chunks_mut(3 * n)) {
            let (dq, rest) = slopes.split_at_mut(n);
            let (dp, dw) = rest.split_at_mut(n);
            system.gradient(state.q, state.p, &mut force, dq);
            system.dissipation(state.q, state.p, dq, dw);
            for (((dp, dw), dq), force) in dp.iter_mut().zip(dw).zip(dq).zip(&force) {
                *dp = -(force + *dw);
                *dw *= *dq;
            }
        }
        let cells = vec![Doubt::default(); exact.len() - 1];
        let mut dense = Self { exact, spacing, slopes, cells };
        let mut z = vec![0.0; 3 * n];
        // The error of the interpolation from every second state bounds that from all states.
        for i in 0..dense.cells.len() / 2 {
            dense.between(i as f64 + 0.5, 2, &mut z);
            let exact = dense.exact.at(2 * i + 1);
            let found = StateRef { q: &z[..n], p: &z[n..2 * n], w: &z[2 * n..], t: exact.t };
            let [q, p, w] = apart(found, exact, dense.exact.motors());
            dense.cells[2 * i..2 * i + 2].fill(Doubt { q, p, w });
        }
        dense
    }

    /// Writes q, p and w at a time, in units of `stride` spacings, interpolated from every
    /// `stride`-th state.
    fn between(&self, at: f64, stride: usize, z: &mut [f64]) {
        let last = self.cells.len() / stride;
        let first = (at.floor() as usize).saturating_sub(1).min(last.saturating_sub(3));
        let s = at - first as f64;
        z.fill(0.0);
        for (k, slope_of_basis) in [-11.0 / 6.0, -0.5, 0.5, 11.0 / 6.0].into_iter().enumerate() {
            let x = k as f64;
            let basis: f64 =
                (0..4).filter(|&m| m != k).map(|m| (s - m as f64) / (x - m as f64)).product();
            let square = basis * basis;
            let of_value = (1.0 - 2.0 * (s - x) * slope_of_basis) * square;
            let of_slope = (s - x) * square * self.spacing * stride as f64;
            let node = (first + k) * stride;
            let state = self.exact.at(node);
            let values = state.q.iter().chain(state.p).chain(state.w);
            let slopes = &self.slopes[node * z.len()..(node + 1) * z.len()];
            for ((z, value), slope) in z.iter_mut().zip(values).zip(slopes) {
                *z += of_value * value + of_slope * slope;
            }
        }
    }

    /// Writes q, p and w at time t, and returns the doubt of the reference and that of the
    /// interpolation, which is zero at the times of the states.
    pub(super) fn at(&self, t: f64, z: &mut [f64]) -> [Doubt; 2] {
        let at = (t / self.spacing).clamp(0.0, self.cells.len() as f64);
        let node = at.round();
        if (at - node).abs() <= SAME_TIME * at {
            let state = self.exact.at(node as usize);
            z.copy_from_slice(&[state.q, state.p, state.w].concat());
            return [self.exact.doubt_at(node as usize), Doubt::default()];
        }
        let cell = (at as usize).min(self.cells.len() - 1);
        self.between(at, 1, z);
        [self.exact.doubt_at(cell).larger(self.exact.doubt_at(cell + 1)), self.cells[cell]]
    }

    /// The times between which the interpolation errs by more than `most` in half of the cells, not
    /// only at kinks; none if this is a small share of the run.
    pub(super) fn unresolved(&self, most: f64) -> Option<[f64; 2]> {
        let size = self.cells.len().div_ceil(PARTS);
        let is_known = |cell: &&Doubt| cell.most() <= most;
        let unknown = |part: &[Doubt]| 2 * part.iter().filter(is_known).count() < part.len();
        let unknown: Vec<usize> = (self.cells.chunks(size).enumerate())
            .filter_map(|(i, part)| unknown(part).then_some(i))
            .collect();
        let [.., last] = unknown[..] else { return None };
        let node = |part: usize| (part * size).min(self.cells.len()) as f64 * self.spacing;
        (unknown.len() >= FEWEST_PARTS).then(|| [node(unknown[0]), node(last + 1)])
    }

    /// The state at the end.
    pub(super) fn end(&self) -> StateRef<'_, f64> {
        self.exact.at(self.cells.len())
    }

    /// The doubt at the end.
    pub(super) fn doubt_at_end(&self) -> Doubt {
        self.exact.doubt_at(self.cells.len())
    }

    /// The largest doubt of the reference.
    pub(super) fn doubt(&self) -> Doubt {
        self.exact.doubt()
    }

    /// The largest |q_j|, |p_j| and |w_j| of the solution.
    pub(super) fn sizes(&self) -> [f64; 3] {
        self.exact.sizes()
    }

    /// The largest of all these.
    pub(super) fn size(&self) -> f64 {
        self.sizes().into_iter().fold(0.0, f64::max)
    }

    /// The largest energy along the solution.
    pub(super) fn largest_energy(&self, problem: &Problem) -> Result<LargestEnergy, InputError> {
        let (system, mut largest) = (problem.model.system::<f64>()?, LargestEnergy::default());
        self.exact.states().for_each(|state| largest.see(&*system, state));
        Ok(largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;
    use afterbay_core::{ExactFlow, State};
    use afterbay_systems::{DAMPED_OSCILLATOR, DampedOscillator};

    #[test]
    fn the_reference_between_its_states_is_within_its_doubt() {
        let system = DampedOscillator::new(1.0, 0.3).expect("a system");
        let exact = |t: f64| {
            let mut state = State::new([2.3], [-3.1]).expect("a state");
            system.flow(t, &mut state);
            state
        };
        for count in [64, 256, 1024] {
            let spacing = 20.0 / f64::from(count);
            let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.3]);
            let mut solution = Solution::with_room(&model, count as usize + 1);
            (0..=count).for_each(|i| solution.push(exact(f64::from(i) * spacing).state_ref()));
            let (dense, mut z) = (Dense::of(&system, solution, spacing), [0.0; 3]);
            let worst = dense.cells.iter().map(|doubt| doubt.most()).fold(0.0, f64::max);
            for t in (0..=777).map(|i| 20.0 / 777.0 * f64::from(i)) {
                let ([_, between], state) = (dense.at(t, &mut z), exact(t));
                let off = (z[0] - state.q[0]).abs().max((z[1] - state.p[0]).abs());
                assert!(off <= between.qp() + 1e-14, "{count}: {off:e} at t = {t}");
                assert!((z[2] - state.w[0]).abs() <= between.w + 1e-14, "{count}: at t = {t}");
            }
            // At its states the reference is known without interpolation.
            for i in [0, 1, 7, count] {
                let [_, between] = dense.at(f64::from(i) * spacing, &mut z);
                let state = dense.exact.at(i as usize);
                assert_eq!(between, Doubt::default(), "{count}: state {i}");
                assert_eq!(z, [state.q[0], state.p[0], state.w[0]]);
            }
            // Errors fall with the motion, where they are no roundings.
            if count < 1024 {
                let [begin, end] = dense.unresolved(worst / 100.0).expect("a long stretch");
                assert!(begin == 0.0 && (5.0..20.0).contains(&end), "{count}: {begin} to {end}");
            }
            assert_eq!(dense.unresolved(worst), None);
            // Degree 7: the error falls as the eighth power of the spacing.
            assert!(worst < 20.0 * spacing.powi(8) + 1e-13, "{count}: {worst:e}");
        }
    }
}
