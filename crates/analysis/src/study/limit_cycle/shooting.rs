//! Shooting: the equations of a cycle, and Newton's method for them.
//!
//! ```text
//! Φ_h^n(z) - z = 0        h = T/n
//! ```
//!
//! The unknowns are z = (q, p), the period T unless the system has one in t, and a parameter λ
//! along a branch. Conditions that are linear in the unknowns make up for those in excess of the
//! equations. The n steps are taken in 106 bits, so that the equations are evaluated to the
//! rounding of z. Their derivatives by z are products of the Jacobians of steps ([`Tangent`]);
//! those by T and λ are differences of whole cycles, and only direct the corrections.

use super::CycleFailure;
use super::multipliers::Determinant;
use crate::Model;
use crate::progress::Progress;
use crate::study::section::nearest;
use crate::study::tangent::Tangent;
use afterbay_core::{InputError, IntegrateError, Quad, RunError, Scalar, State, with_motors};
use afterbay_methods::registry::Row;
use faer::{Col, Mat};

/// Corrections below this share of the size of the unknowns are roundings.
const SETTLED: f64 = 1e-14;
/// Corrections that no longer fall are accepted below this share: the equations are then solved to
/// their roundings.
const LARGEST_ROUNDING: f64 = 1e-9;
/// The longest correction, relative to the size of the unknowns.
const LONGEST: f64 = 0.3;
/// The most corrections. Newton's method takes about six from a guess with an error of 1 %.
const MOST_CORRECTIONS: usize = 30;
/// Singular values below this share of the largest count as 0.
pub(super) const SINGULAR: f64 = 1e-11;
/// The largest factor by which T may differ from the first guess.
const PERIOD_FACTOR: f64 = 1.5;
/// The displacement for the derivative by a parameter, relative to its scale: the square root of
/// the rounding of `f64`, in which parameters are given.
const BY_PARAMETER: f64 = 1.5e-8;
/// Steps between two looks at whether the user wants to stop.
const STEPS_BETWEEN_LOOKS: u64 = 64;

/// The equations of cycles of a method.
pub(super) struct Shooting<'a> {
    /// The system, with the values of all parameters but λ.
    pub(super) model: &'a Model,
    pub(super) row: &'static Row,
    /// The name of λ, if there is one.
    pub(super) parameter: Option<&'a str>,
    /// The number of periods in time of the system in a cycle; none if T is unknown.
    pub(super) multiple: Option<u64>,
    /// n
    pub(super) steps: u64,
    /// The sizes of the unknowns, by which they are measured.
    pub(super) scales: Vec<f64>,
    pub(super) progress: &'a dyn Progress,
}

/// A condition on the unknowns x: normal · (x - at) = 0, both measured by the scales.
#[derive(Clone)]
pub(super) struct Condition {
    pub(super) normal: Vec<f64>,
    pub(super) at: Vec<f64>,
}

/// A run over n steps, and its derivatives.
#[derive(Clone)]
pub(super) struct Image {
    /// The states (q, p) at the ends of the steps, the start included.
    pub(super) path: Vec<Vec<f64>>,
    pub(super) period: f64,
    /// Φ(z) - z, less whole turns.
    pub(super) residual: Vec<f64>,
    /// ∂Φ/∂z
    pub(super) monodromy: Mat<f64>,
    /// det ∂Φ/∂z
    pub(super) determinant: Determinant,
    /// The derivatives of the residual by the unknowns, times their scales.
    pub(super) matrix: Mat<f64>,
}

/// A solution of the equations.
pub(super) struct Solved {
    pub(super) x: Vec<f64>,
    pub(super) image: Image,
    /// The least singular value of the equations over the largest.
    pub(super) ratio: f64,
    /// The number of corrections.
    pub(super) corrections: usize,
}

impl Shooting<'_> {
    /// 2N
    pub(super) fn size(&self) -> usize {
        2 * self.model.degrees()
    }

    /// Whether T is unknown.
    pub(super) fn free(&self) -> bool {
        self.multiple.is_none()
    }

    /// The system at the unknowns.
    ///
    /// # Errors
    /// [`CycleFailure::Model`]
    pub(super) fn model_at(&self, x: &[f64]) -> Result<Model, CycleFailure> {
        match (self.parameter, x.last()) {
            (Some(name), Some(&value)) => Ok(self.model.with(name, value)?),
            _ => Ok(self.model.clone()),
        }
    }

    /// T at the unknowns.
    ///
    /// # Errors
    /// [`CycleFailure::NoPeriodInTime`]
    pub(super) fn period(&self, model: &Model, x: &[f64]) -> Result<f64, CycleFailure> {
        match self.multiple {
            None => Ok(x[self.size()]),
            Some(multiple) => {
                let period = model.drive_period().ok_or(CycleFailure::NoPeriodInTime)?;
                Ok(multiple as f64 * period)
            }
        }
    }

    /// The step, in 106 bits.
    fn step(&self, period: f64) -> Quad {
        Quad::from_f64(period) / Quad::from_f64(self.steps as f64)
    }

    /// The end of n steps from z.
    fn end(&self, model: &Model, h: Quad, z: &[f64]) -> Result<State<Vec<Quad>>, CycleFailure> {
        let tangent = Tangent::new(model, self.row)?;
        let mut state = start(model, z)?;
        self.each_step(h, |_| tangent.step(h, &mut state))?;
        Ok(state)
    }

    fn each_step(
        &self,
        h: Quad,
        mut step: impl FnMut(u64) -> Result<(), IntegrateError>,
    ) -> Result<(), CycleFailure> {
        for k in 0..self.steps {
            if k % STEPS_BETWEEN_LOOKS == 0 && self.progress.stopped() {
                return Err(IntegrateError::Interrupted.into());
            }
            step(k).map_err(|error| match error {
                IntegrateError::Run(error) => {
                    IntegrateError::Run(RunError { step: k + 1, t: k as f64 * h.to_f64(), ..error })
                }
                other => other,
            })?;
        }
        Ok(())
    }

    /// The run from the unknowns, with all derivatives.
    ///
    /// # Errors
    /// The failure of a step.
    pub(super) fn image(&self, x: &[f64]) -> Result<Image, CycleFailure> {
        let (size, model) = (self.size(), self.model_at(x)?);
        let (z, period) = (&x[..size], self.period(&model, x)?);
        let h = self.step(period);
        let tangent = Tangent::new(&model, self.row)?;
        let mut state = start(&model, z)?;
        let mut monodromy = Mat::<f64>::identity(size, size);
        let mut determinant = Determinant::default();
        let mut path = vec![z.to_vec()];
        self.each_step(h, |_| {
            let jacobian = tangent.step_with_jacobian(h, &mut state)?;
            determinant = determinant.times(jacobian.determinant());
            monodromy = jacobian * &monodromy;
            path.push(numbers(&state, size / 2).map(Scalar::to_f64).collect());
            Ok(())
        })?;
        let turns = model.periods();
        let turned = |(i, off): (usize, f64)| match turns.get(i).copied().flatten() {
            Some(period) if i < size / 2 => nearest(off, period),
            _ => off,
        };
        let off =
            numbers(&state, size / 2).zip(z).map(|(end, &z)| (end - Quad::from_f64(z)).to_f64());
        let residual: Vec<f64> = off.enumerate().map(turned).collect();
        let mut matrix = Mat::zeros(size, x.len());
        for j in 0..size {
            for i in 0..size {
                matrix[(i, j)] = monodromy[(i, j)] - if i == j { 1.0 } else { 0.0 };
            }
        }
        let mut put = |column: usize, other: State<Vec<Quad>>, d: Quad| {
            let changes = numbers(&other, size / 2).zip(numbers(&state, size / 2));
            for (i, (other, end)) in changes.enumerate() {
                matrix[(i, column)] = ((other - end) / d).to_f64();
            }
        };
        if self.free() {
            let d = h * Quad::from_f64(f64::EPSILON);
            let by_step = d * Quad::from_f64(self.steps as f64);
            put(size, self.end(&model, h + d, z)?, by_step);
        }
        if self.parameter.is_some() {
            let last = x.len() - 1;
            let mut other = x.to_vec();
            other[last] += BY_PARAMETER * self.scales[last].max(x[last].abs());
            let model = self.model_at(&other)?;
            let end = self.end(&model, self.step(self.period(&model, &other)?), z)?;
            put(last, end, Quad::from_f64(other[last] - x[last]));
        }
        for (j, scale) in self.scales.iter().enumerate() {
            matrix.col_mut(j).iter_mut().for_each(|entry| *entry *= scale);
        }
        Ok(Image { path, period, residual, monodromy, determinant, matrix })
    }

    /// Solves the equations and the conditions by Newton's method from x. There must be as many
    /// conditions as unknowns in excess of 2N.
    ///
    /// # Errors
    /// The failure of a step, [`CycleFailure::NotConverged`], [`CycleFailure::PeriodLost`] and
    /// [`CycleFailure::NotFinite`].
    pub(super) fn solve(
        &self,
        mut x: Vec<f64>,
        conditions: &[Condition],
    ) -> Result<Solved, CycleFailure> {
        let (mut last, guess) = (f64::INFINITY, x.get(self.size()).copied());
        let mut corrections = 0;
        loop {
            let image = self.image(&x)?;
            let (correction, ratio) = self.correction(&image, &x, conditions)?;
            let length = correction.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            if length <= SETTLED || (length >= 0.5 * last && length <= LARGEST_ROUNDING) {
                return Ok(Solved { x, image, ratio, corrections });
            }
            if !length.is_finite() || corrections == MOST_CORRECTIONS {
                return Err(CycleFailure::NotConverged {
                    correction: length,
                    iterations: corrections,
                });
            }
            let share = (LONGEST / length).min(1.0);
            for ((x, by), scale) in x.iter_mut().zip(&correction).zip(&self.scales) {
                *x += share * by * scale;
            }
            if let Some(guess) = guess.filter(|_| self.free()) {
                let period = x[self.size()];
                if !(guess / PERIOD_FACTOR..=guess * PERIOD_FACTOR).contains(&period) {
                    return Err(CycleFailure::PeriodLost { guess, period });
                }
            }
            last = length;
            corrections += 1;
        }
    }

    /// The correction of Newton's method, measured by the scales, and the ratio of the singular
    /// values. In directions in which the equations are singular there is no correction.
    fn correction(
        &self,
        image: &Image,
        x: &[f64],
        conditions: &[Condition],
    ) -> Result<(Vec<f64>, f64), CycleFailure> {
        let (size, all) = (self.size(), x.len());
        let matrix = Mat::from_fn(all, all, |i, j| match i.checked_sub(size) {
            None => image.matrix[(i, j)] / self.scales[i],
            Some(i) => conditions[i].normal[j],
        });
        let right = Col::from_fn(all, |i| match i.checked_sub(size) {
            None => -image.residual[i] / self.scales[i],
            Some(i) => {
                let Condition { normal, at } = &conditions[i];
                let off =
                    x.iter().zip(at).zip(&self.scales).map(|((x, at), scale)| (at - x) / scale);
                normal.iter().zip(off).map(|(normal, off)| normal * off).sum()
            }
        });
        let svd = matrix.svd().map_err(|_| CycleFailure::NotFinite)?;
        let values: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let (most, least) = (values[0], values[all - 1]);
        let mut parts = svd.U().transpose() * right;
        for (i, value) in values.iter().enumerate() {
            parts[i] = if *value > SINGULAR * most { parts[i] / value } else { 0.0 };
        }
        let correction = svd.V() * parts;
        Ok((correction.iter().copied().collect(), least / most))
    }
}

/// The direction that a matrix with one row less than columns sends to 0, of length 1.
///
/// # Errors
/// [`CycleFailure::NotFinite`]
pub(super) fn null_vector(matrix: &Mat<f64>) -> Result<Vec<f64>, CycleFailure> {
    let svd = matrix.svd().map_err(|_| CycleFailure::NotFinite)?;
    let vectors = svd.V();
    Ok(vectors.col(vectors.ncols() - 1).iter().copied().collect())
}

/// The state z at the start of a period in time.
fn start(model: &Model, z: &[f64]) -> Result<State<Vec<Quad>>, InputError> {
    let lift = |part: &[f64]| part.iter().map(|&x| Quad::from_f64(x)).collect();
    let (q, p) = z.split_at(model.degrees());
    Ok(with_motors(&State::new(lift(q), lift(p))?, model.motors().count()))
}

/// q and p of the degrees of freedom that are not motors.
fn numbers(state: &State<Vec<Quad>>, n: usize) -> impl Iterator<Item = Quad> + '_ {
    state.q[..n].iter().chain(&state.p[..n]).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_that_are_not_finite_are_told_from_multipliers_that_are_not_known() {
        let failure = null_vector(&Mat::from_fn(1, 2, |_, _| f64::NAN)).expect_err("no direction");
        let ending = failure.ending().expect("no invalid input");
        assert_eq!(ending.outcome, "not-converged");
        assert!(ending.failure.is_some_and(|why| why.contains("equations of the cycle")));
    }
}
