//! The growth of tangent vectors over steps.

use crate::Model;
use crate::study::outcome::Ending;
use crate::study::stability::balance;
use crate::study::tangent::Tangent;
use afterbay_core::{
    Block, InputError, IntegrateError, Quad, RunError, Scalar, SecondDerivatives, State, StateRef,
};
use faer::Mat;
use nalgebra::DMatrix;
use std::sync::Arc;

/// The reason why the growth over a run ends before its time.
#[derive(Clone, Debug)]
pub(super) enum Stop {
    /// The run, or a step from a displaced state, failed.
    Run(IntegrateError),
    /// The Jacobian of the step that begins at t is singular to rounding.
    Singular { t: f64 },
}

impl Stop {
    /// This failure, with the number of its step counted from the start of the run. It is that of a
    /// part of the run which began after `steps` steps.
    pub(super) fn after(self, steps: u64) -> Self {
        match self {
            Self::Run(IntegrateError::Run(error)) => {
                Self::Run(RunError { step: error.step + steps, ..error }.into())
            }
            other => other,
        }
    }

    /// The ending of the run.
    pub(super) fn ending(&self) -> Ending {
        match self {
            Self::Run(error) => Ending::of(&Err::<(), _>(error.clone()), 0, 0),
            Self::Singular { t } => Ending {
                outcome: "singular-step",
                failure: Some(format!(
                    "the Jacobian of the step from t = {t:?} is singular: at least one exponent is \
                     minus infinity, take another step"
                )),
            },
        }
    }
}

/// Sums over the steps of an interval.
#[derive(Clone, Debug)]
pub(super) struct Growth {
    pub(super) steps: u64,
    /// Σ ln |R_ii|
    pub(super) logs: Vec<f64>,
    /// Σ ln |det J|
    pub(super) log_det: f64,
    /// The sum of the mean divergence of each step; none for a system without second derivatives.
    pub(super) divergence: Option<f64>,
    /// The largest difference of each entry of (q, p) from where the measurement begins, an angle
    /// less its whole turns.
    pub(super) farthest: Vec<f64>,
}

impl Growth {
    /// No steps, with `size` tangent vectors.
    pub(super) fn new(size: usize) -> Self {
        let [logs, farthest] = [(); 2].map(|()| vec![0.0; size]);
        Self { steps: 0, logs, log_det: 0.0, divergence: Some(0.0), farthest }
    }
}

/// Units are powers of 2 to this power, 2^20. They are 1 in a motion whose entries have about equal
/// sizes, so that exponents there do not depend on the choice.
const POWER: f64 = 20.0;

/// Orthonormal tangent vectors, with each entry of (q, p) in a unit of its own: sizes that differ
/// by many powers of ten, as in SI units, would mix in the rounding of an orthonormalization.
pub(super) struct Frame {
    vectors: Mat<f64>,
    /// The units; none before the first step.
    units: Option<Vec<f64>>,
}

impl Frame {
    /// The unit vectors of 2N dimensions.
    pub(super) fn new(size: usize) -> Self {
        Self { vectors: Mat::identity(size, size), units: None }
    }

    /// Takes one step from a state, and adds the growth of the vectors in it to the sums.
    ///
    /// # Errors
    /// [`Stop`]; the vectors and the sums are then unchanged.
    pub(super) fn step(
        &mut self,
        tangent: &Tangent,
        divergence: &Divergence,
        h: f64,
        from: StateRef<'_, f64>,
        growth: &mut Growth,
    ) -> Result<(), Stop> {
        let mut state = lifted(from);
        let mut jacobian =
            tangent.step_with_jacobian(Quad::from_f64(h), &mut state).map_err(Stop::Run)?;
        let units = self.units.get_or_insert_with(|| units_of(&jacobian));
        put_in_units(&mut jacobian, units);
        let qr = (&jacobian * &self.vectors).qr();
        let diagonal = qr.thin_R().diagonal();
        let size = growth.logs.len();
        let logs: Vec<f64> = (0..size).map(|i| diagonal[i].abs().ln()).collect();
        // The sum of logarithms does not overflow where the determinant would.
        let pivots = jacobian.partial_piv_lu();
        let log_det: f64 = pivots.U().diagonal().column_vector().iter().map(|x| x.abs().ln()).sum();
        if !(logs.iter().all(|log| log.is_finite()) && log_det.is_finite()) {
            return Err(Stop::Singular { t: from.t });
        }
        self.vectors = qr.compute_thin_Q();
        growth.logs.iter_mut().zip(logs).for_each(|(sum, log)| *sum += log);
        growth.log_det += log_det;
        growth.steps += 1;
        let [q, p] =
            [&state.q, &state.p].map(|part| part.iter().map(|x| x.to_f64()).collect::<Vec<_>>());
        let ends = [divergence.at(from.q, from.p), divergence.at(&q, &p)];
        growth.divergence = match (growth.divergence, ends) {
            (Some(sum), [Some(start), Some(end)]) => Some(sum + f64::midpoint(start, end)),
            _ => None,
        };
        Ok(())
    }
}

/// The units of the entries of (q, p), relative to that of q1, in which displacements of all of
/// them change each other by about as much in a step, among the powers of 2^[`POWER`].
fn units_of(jacobian: &Mat<f64>) -> Vec<f64> {
    let size = jacobian.nrows();
    let off_diagonal = |i, j| if i == j { 0.0 } else { jacobian[(i, j)] };
    let Some((_, sizes)) = balance(&mut DMatrix::from_fn(size, size, off_diagonal)) else {
        return vec![1.0; size];
    };
    let unit = |own: &f64| (POWER * ((own / sizes[0]).log2() / POWER).round()).exp2();
    let usable = |unit: f64| if unit.is_finite() && unit > 0.0 { unit } else { 1.0 };
    sizes.iter().map(unit).map(usable).collect()
}

/// Puts a Jacobian in the given units, powers of 2.
fn put_in_units(jacobian: &mut Mat<f64>, units: &[f64]) {
    for (i, own) in units.iter().enumerate() {
        for (j, unit) in units.iter().enumerate() {
            jacobian[(i, j)] *= unit / own;
        }
    }
}

/// A state in 106 bits.
fn lifted(state: StateRef<'_, f64>) -> State<Vec<Quad>> {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect();
    let StateRef { q, p, w, t } = state;
    State { q: lift(q), p: lift(p), w: lift(w), t: Quad::from_f64(t) }
}

/// The divergence of the equations.
pub(super) struct Divergence {
    system: Option<Arc<dyn SecondDerivatives<f64>>>,
    /// The number of degrees of freedom that are not motors.
    dof: usize,
}

impl Divergence {
    /// The divergence of a model; its value is not known without second derivatives.
    ///
    /// # Errors
    /// Those of [`Model::system`].
    pub(super) fn new(model: &Model) -> Result<Self, InputError> {
        Ok(Self { system: model.system::<f64>()?.second_derivatives(), dof: model.degrees() })
    }

    /// -Σ ∂D_j/∂p_j at (q, p), which include the motors.
    fn at(&self, q: &[f64], p: &[f64]) -> Option<f64> {
        let system = self.system.as_ref()?;
        let mut sum = 0.0;
        system.each(q, p, &mut |entries| {
            for &(block, row, column, value) in entries {
                if block == Block::Dp && row == column && row < self.dof {
                    sum -= value;
                }
            }
        });
        Some(sum)
    }
}
