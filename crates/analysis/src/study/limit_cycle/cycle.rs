//! A cycle: its amplitude and its multipliers.

use super::CycleFailure;
use super::shooting::{Image, Shooting};
use crate::Model;
use crate::study::zero::at_zero;
use afterbay_core::{State, StateRef, with_motors};
use afterbay_methods::registry::Row;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// The size of a multiplier, relative to the matrix, below which the determinant gives it better:
/// half of its digits are lost.
const SMALL: f64 = 1e-8;
/// The size below which it is lost in roundings. A choice: those of a product of thousands of
/// matrices.
const LOST: f64 = 1e-12;

/// A complex number, as its real and imaginary parts.
pub type Complex = [f64; 2];

pub(super) fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// A determinant, by its sign and the logarithm of its size, which may be below all numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Determinant {
    sign: f64,
    logarithm: f64,
}

impl Default for Determinant {
    /// 1
    fn default() -> Self {
        Self { sign: 1.0, logarithm: 0.0 }
    }
}

impl Determinant {
    /// The determinant of a product with a matrix of determinant x.
    pub(super) fn times(self, x: f64) -> Self {
        Self { sign: self.sign * x.signum(), logarithm: self.logarithm + x.abs().ln() }
    }

    /// Its quotient by x.
    fn over(self, x: f64) -> f64 {
        self.sign * x.signum() * (self.logarithm - x.abs().ln()).exp()
    }
}

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

/// The eigenvalues of a matrix, the largest first, and the bound below which they are not known.
/// They are computed in units in which all entries are of about one size. A small one that is the
/// least follows from the determinant, if the others are known: the rounding errors of eigenvalues
/// are relative to the largest.
fn multipliers(
    matrix: &Mat<f64>,
    determinant: Determinant,
    units: &[f64],
) -> Result<(Vec<Complex>, Option<f64>), CycleFailure> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let scaled = Mat::from_fn(rows, columns, |i, j| matrix[(i, j)] * (units[j] / units[i]));
    let values = scaled.eigenvalues().map_err(|_| CycleFailure::NoMultipliers)?;
    let mut values: Vec<Complex> = values.iter().map(|z| [z.re, z.im]).collect();
    if values.iter().flatten().any(|x| !x.is_finite()) {
        return Err(CycleFailure::NoMultipliers);
    }
    let size = |[re, im]: &Complex| re.hypot(*im);
    values.sort_by(|a, b| size(b).total_cmp(&size(a)).then(b[1].total_cmp(&a[1])));
    let norm = scaled.norm_l2();
    let below = |share: f64| values.iter().filter(|value| size(value) < share * norm).count();
    let (small, lost) = (below(SMALL), below(LOST));
    if let Some(([_, 0.0], others)) = values.split_last()
        && small > 0
        && lost <= 1
    {
        let others = others.iter().fold([1.0, 0.0], |all, value| product(all, *value))[0];
        let least = determinant.over(others);
        if least != 0.0 && least.is_finite() {
            let last = values.len() - 1;
            values[last] = [least, 0.0];
            return Ok((values, None));
        }
    }
    Ok((values, (lost > 0).then_some(LOST * norm)))
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

    #[test]
    fn multipliers_fall() {
        let turn = Mat::from_fn(2, 2, |i, j| [[0.0, -0.5], [0.5, 0.0]][i][j]);
        let determinant = Determinant::default().times(0.25);
        let (found, lost) = multipliers(&turn, determinant, &[1.0; 2]).unwrap();
        assert_eq!(lost, None);
        assert!((found[0][1] - 0.5).abs() < 1e-15 && (found[1][1] + 0.5).abs() < 1e-15);
    }

    #[test]
    fn multipliers_do_not_depend_on_units() {
        let entry = |i: usize, j: usize| ((3 * i + 5 * j) as f64).sin();
        let exact =
            multipliers(&Mat::from_fn(4, 4, entry), Determinant::default(), &[1.0; 4]).unwrap().0;
        let units = [1e-7, 1.0, 1e7, 3e3];
        let other = Mat::from_fn(4, 4, |i, j| entry(i, j) * units[i] / units[j]);
        let found = multipliers(&other, Determinant::default(), &units).unwrap().0;
        for (a, b) in found.iter().zip(&exact) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-14, "{found:?} {exact:?}");
        }
    }

    /// In coordinates in which no entry shows a multiplier.
    #[test]
    fn a_multiplier_below_the_roundings_follows_from_the_determinant_or_is_not_known() {
        let turned = |values: [f64; 3]| {
            let entry = |i: usize, j: usize| {
                [[1.0, 2.0, 2.0], [2.0, 1.0, -2.0], [2.0, -2.0, 1.0]][i][j] / 3.0
            };
            let along =
                |i: usize, j: usize| (0..3).map(|k| entry(i, k) * values[k] * entry(j, k)).sum();
            let determinant = values.into_iter().fold(Determinant::default(), Determinant::times);
            multipliers(&Mat::from_fn(3, 3, along), determinant, &[1.0; 3]).unwrap()
        };
        let (found, lost) = turned([1.0, 0.3, -1e-40]);
        assert!((found[2][0] / -1e-40 - 1.0).abs() < 1e-12 && lost.is_none(), "{found:?}");
        let (found, lost) = turned([1.0, 1e-20, 1e-40]);
        let bound = lost.expect("two are lost");
        assert!(found[1][0].abs() < bound && bound < 1e-11 && found[0][0] > bound);
    }
}
