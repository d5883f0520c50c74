//! A cycle: its amplitude and its multipliers.

use super::CycleFailure;
use super::shooting::{Image, Shooting};
use crate::Model;
use afterbay_core::{State, with_motors};
use afterbay_methods::registry::{Row, Run};
use faer::Mat;
use serde::Serialize;

/// The halvings of a step in search of a turning point: all that `f64` resolves.
const HALVINGS: usize = 53;

/// A complex number, as its real and imaginary parts.
pub type Complex = [f64; 2];

/// A cycle of a method.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
    /// max |q_j| of each degree of freedom, at steps and at turning points between them.
    pub amplitude: Vec<f64>,
    /// The eigenvalues of ∂Φ/∂z, the largest first.
    pub multipliers: Vec<Complex>,
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
        Ok(Self {
            value: shooting.parameter.and(x.last().copied()),
            h,
            period: image.period,
            multiple: shooting.multiple,
            start: [q.to_vec(), p.to_vec()],
            amplitude: amplitude(&model, shooting.row, h, &image.path)?,
            multipliers: multipliers(&image.monodromy)?,
        })
    }

    /// The multipliers but the one that every cycle without a drive has, whose displacement is along
    /// the cycle: the nearest to 1.
    pub fn nontrivial(&self) -> Vec<Complex> {
        let mut all = self.multipliers.clone();
        if self.multiple.is_none() {
            let off = |[re, im]: &Complex| (re - 1.0).hypot(*im);
            let nearest = (0..all.len()).min_by(|&a, &b| off(&all[a]).total_cmp(&off(&all[b])));
            nearest.map(|nearest| all.remove(nearest));
        }
        all
    }

    /// Whether small displacements of the cycle decay.
    pub fn is_stable(&self) -> bool {
        self.nontrivial().iter().all(|[re, im]| re.hypot(*im) < 1.0)
    }
}

/// The eigenvalues of a matrix, the largest first.
fn multipliers(matrix: &Mat<f64>) -> Result<Vec<Complex>, CycleFailure> {
    let values = matrix.eigenvalues().map_err(|_| CycleFailure::NoMultipliers)?;
    let mut values: Vec<Complex> = values.iter().map(|z| [z.re, z.im]).collect();
    if values.iter().flatten().any(|x| !x.is_finite()) {
        return Err(CycleFailure::NoMultipliers);
    }
    let size = |[re, im]: &Complex| re.hypot(*im);
    values.sort_by(|a, b| size(b).total_cmp(&size(a)).then(b[1].total_cmp(&a[1])));
    Ok(values)
}

/// max |q_j| over a cycle. Between two steps at which ∂H/∂p_j has opposite signs, bisection finds the
/// shorter step at whose end it is 0.
fn amplitude(
    model: &Model,
    row: &'static Row,
    h: f64,
    path: &[Vec<f64>],
) -> Result<Vec<f64>, CycleFailure> {
    let (run, n, motors) = (model.bind(row)?, model.degrees(), model.driven().len());
    let system = model.system::<f64>()?;
    let (mut hq, mut hp) = (vec![0.0; n + motors], vec![0.0; n + motors]);
    let mut velocities = |state: &State<Vec<f64>>| {
        system.gradient(&state.q, &state.p, &mut hq, &mut hp);
        hp[..n].to_vec()
    };
    let state = |k: usize| {
        let (q, p) = path[k].split_at(n);
        let t = h * k as f64;
        let state = State { q: q.to_vec(), p: p.to_vec(), w: vec![0.0; n], t };
        with_motors(&state, motors)
    };
    let mut most: Vec<f64> =
        (0..n).map(|j| path.iter().map(|z| z[j].abs()).fold(0.0, f64::max)).collect();
    let mut before = velocities(&state(0));
    for k in 1..path.len() {
        let after = velocities(&state(k));
        for j in (0..n).filter(|&j| before[j] * after[j] < 0.0) {
            let turn = turning_point(&run, h, &state(k - 1), |state| {
                (velocities(state)[j] > 0.0) == (before[j] > 0.0)
            });
            most[j] = turn.map_or(most[j], |turn| most[j].max(turn.q[j].abs()));
        }
        before = after;
    }
    Ok(most)
}

/// The end of the longest step from a state at which `holds`, which holds at the start. None where a
/// shorter step fails.
fn turning_point(
    run: &Run<f64>,
    h: f64,
    from: &State<Vec<f64>>,
    mut holds: impl FnMut(&State<Vec<f64>>) -> bool,
) -> Option<State<Vec<f64>>> {
    let (mut low, mut high, mut found) = (0.0, 1.0, None);
    for _ in 0..HALVINGS {
        let share = f64::midpoint(low, high);
        let mut state = from.clone();
        run.step(share * h, &mut state).ok()?;
        if holds(&state) {
            (low, found) = (share, Some(state));
        } else {
            high = share;
        }
    }
    found
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
        };
        assert_eq!(cycle(None).nontrivial(), [[-1.2, 0.0], [0.3, 0.0]]);
        assert_eq!(cycle(Some(1)).nontrivial().len(), 3);
        assert!(!cycle(None).is_stable());
    }

    #[test]
    fn multipliers_fall() {
        let turn = Mat::from_fn(2, 2, |i, j| [[0.0, -0.5], [0.5, 0.0]][i][j]);
        let found = multipliers(&turn).unwrap();
        assert!((found[0][1] - 0.5).abs() < 1e-15 && (found[1][1] + 0.5).abs() < 1e-15);
    }
}
