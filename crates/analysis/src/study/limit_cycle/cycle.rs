//! A cycle: its amplitude and its stability.

use super::CycleFailure;
use super::multipliers::{Complex, multipliers};
use super::shooting::{Image, Shooting};
use crate::Model;
use crate::study::zero::at_zero;
use afterbay_core::{State, StateRef, with_motors};
use afterbay_methods::registry::Row;
use serde::{Deserialize, Serialize};

/// The distance of a multiplier from 1.
fn off([re, im]: &Complex) -> f64 {
    (re - 1.0).hypot(*im)
}

/// A cycle of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cycle {
    /// The value of the parameter along a branch.
    pub value: Option<f64>,
    /// The step, T/n.
    pub h: f64,
    /// T
    pub period: f64,
    /// Its number of periods of the drive; none without a drive.
    pub multiple: Option<u64>,
    /// q and p of one of its states; under a drive, that at the start of its period.
    pub start: [Vec<f64>; 2],
    /// max |q_j| of each degree of freedom, at steps and at turning points between them, without
    /// whole turns of an angle. Of an angle that gains whole turns in a cycle, it is
    /// (max - min)/2 of q_j less its uniform rotation.
    pub amplitude: Vec<f64>,
    /// The eigenvalues of ∂Φ/∂z, the largest first.
    pub multipliers: Vec<Complex>,
    /// Multipliers below this are roundings of the largest, and are not known; none if all are
    /// known.
    pub lost_below: Option<f64>,
}

impl Cycle {
    /// The cycle that solves the equations at the unknowns x.
    pub(super) fn of(
        shooting: &Shooting<'_>,
        x: &[f64],
        image: &Image,
    ) -> Result<Self, CycleFailure> {
        let (model, n) = (shooting.model_at(x)?, shooting.size() / 2);
        let (q, p) = x[..2 * n].split_at(n);
        let h = image.period / shooting.steps as f64;
        let (multipliers, lost_below) =
            multipliers(&image.monodromy, image.determinant, &shooting.scales)?;
        Ok(Self {
            value: shooting.parameter.and(x.last().copied()),
            h,
            period: image.period,
            multiple: shooting.multiple,
            start: [q.to_vec(), p.to_vec()],
            amplitude: amplitude(&model, shooting.row, h, &image.path)?,
            multipliers,
            lost_below,
        })
    }

    /// The multipliers but the one that every cycle without a drive has, whose displacement is
    /// along the cycle: the nearest to 1.
    pub fn nontrivial(&self) -> Vec<Complex> {
        let mut all = self.multipliers.clone();
        self.trivial().map(|nearest| all.remove(nearest));
        all
    }

    /// The distance from 1 of the multiplier along a cycle without a drive, which is 1 for a
    /// solution of the equations of motion.
    pub fn off_along(&self) -> Option<f64> {
        self.trivial().map(|nearest| off(&self.multipliers[nearest]))
    }

    /// The index of the multiplier along a cycle without a drive.
    fn trivial(&self) -> Option<usize> {
        let all = &self.multipliers;
        let nearest = (0..all.len()).min_by(|&a, &b| off(&all[a]).total_cmp(&off(&all[b])));
        nearest.filter(|_| self.multiple.is_none())
    }

    /// A multiplier, if it is not lost in the roundings of the largest.
    pub fn known(&self, [re, im]: Complex) -> Option<Complex> {
        let lost = self.lost_below.is_some_and(|bound| re.hypot(im) < bound);
        (!lost).then_some([re, im])
    }

    /// Whether small displacements of the cycle decay.
    pub fn is_stable(&self) -> bool {
        self.nontrivial().iter().all(|[re, im]| re.hypot(*im) < 1.0)
    }
}

/// max |q_j| over a cycle, or (max - min)/2 of q_j less its uniform rotation
/// ([`Cycle::amplitude`]). Where the velocity ∂H/∂p_j less that of the rotation changes its sign
/// within a step, the state at which it is 0 counts as well.
fn amplitude(
    model: &Model,
    row: &'static Row,
    h: f64,
    path: &[Vec<f64>],
) -> Result<Vec<f64>, CycleFailure> {
    let (run, n, motors) = (model.bind(row)?, model.degrees(), model.motors().count());
    let system = model.system::<f64>()?;
    let periods = model.periods();
    let rotation = rotation(&periods, h, path);
    let velocities = |state: StateRef<'_, f64>| {
        let (mut hq, mut hp) = (vec![0.0; n + motors], vec![0.0; n + motors]);
        system.gradient(state.q, state.p, &mut hq, &mut hp);
        hp.iter().zip(&rotation).map(|(v, rate)| v - rate).collect::<Vec<_>>()
    };
    let state = |k: usize| {
        let (q, p) = path[k].split_at(n);
        let t = h * k as f64;
        with_motors(&State { q: q.to_vec(), p: p.to_vec(), w: vec![0.0; n], t }, motors)
    };
    let mut range = vec![[f64::INFINITY, f64::NEG_INFINITY]; n];
    let mut widen = |j: usize, state: StateRef<'_, f64>| {
        let (q, [least, most]) = (state.q[j] - rotation[j] * state.t, &mut range[j]);
        (*least, *most) = (least.min(q), most.max(q));
    };
    let mut before = state(0);
    let mut last = velocities(before.state_ref());
    for k in 1..path.len() {
        let after = state(k);
        let now = velocities(after.state_ref());
        for j in 0..n {
            widen(j, after.state_ref());
            if last[j] * now[j] < 0.0 {
                let velocity = |state: StateRef<'_, f64>| velocities(state)[j];
                let turn = at_zero(&run, h, velocity, &before, after.state_ref());
                widen(j, turn.state_ref());
            }
        }
        (before, last) = (after, now);
    }
    let amplitude = |(j, &[least, most]): (usize, &[f64; 2])| {
        if rotation[j] != 0.0 {
            return 0.5 * (most - least);
        }
        let middle = 0.5 * (least + most);
        let turns = periods[j].map_or(0.0, |period| period * (middle / period).round());
        (least - turns).abs().max((most - turns).abs())
    };
    Ok(range.iter().enumerate().map(amplitude).collect())
}

/// The mean velocity of each coordinate that gains whole periods in a cycle; 0 for the others.
fn rotation(periods: &[Option<f64>], h: f64, path: &[Vec<f64>]) -> Vec<f64> {
    let time = h * (path.len() - 1) as f64;
    let gained = |(j, period): (usize, &Option<f64>)| {
        let gain = path[path.len() - 1][j] - path[0][j];
        period.map_or(0.0, |period| period * (gain / period).round() / time)
    };
    periods.iter().enumerate().map(gained).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trivial_multiplier_is_left_out() {
        let cycle = |multiple| Cycle {
            value: None,
            h: 0.1,
            period: 1.0,
            multiple,
            start: [vec![0.0], vec![0.0]],
            amplitude: vec![1.0],
            multipliers: vec![[-1.2, 0.0], [1.0 + 1e-9, 0.0], [0.3, 0.0]],
            lost_below: None,
        };
        assert_eq!(cycle(None).nontrivial(), [[-1.2, 0.0], [0.3, 0.0]]);
        assert_eq!(cycle(Some(1)).nontrivial().len(), 3);
        assert!((cycle(None).off_along().unwrap() - 1e-9).abs() < 1e-15);
        assert_eq!(cycle(Some(1)).off_along(), None);
        assert!(!cycle(None).is_stable());
    }
}
