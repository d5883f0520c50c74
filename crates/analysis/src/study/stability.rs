//! Stability where methods fail: a verdict for every (h, parameter), and for linear systems the spectral radius of the
//! step beside it.

use super::{Problem, outcome};
use crate::Model;
use crate::progress::Progress;
use afterbay_core::{Grid, InputError, IntegrateError, State};
use afterbay_methods::registry::{Row, Run};
use nalgebra::Matrix2;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::ControlFlow;

/// How a run behaved beside the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Bounded, with the energy of the exact solution: its mean over the second half of the run is within
    /// [`TOLERANCE`].
    Right,
    /// Bounded, with another energy than the exact solution.
    Wrong,
    /// The energy has grown to more than [`GROWTH`] times the largest the exact solution has.
    Growing,
    /// A number was not finite.
    NotFinite,
    /// The nonlinear solver found no solution.
    NoConvergence,
    /// δ met its pole, or the step equation was singular.
    Pole,
}

impl Verdict {
    /// Every verdict, from good to bad.
    pub const ALL: [Self; 6] =
        [Self::Right, Self::Wrong, Self::Growing, Self::NotFinite, Self::NoConvergence, Self::Pole];

    /// In words, for a legend.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Right => "bounded, right energy",
            Self::Wrong => "bounded, wrong energy",
            Self::Growing => "growing",
            Self::NotFinite => "not finite",
            Self::NoConvergence => "solver did not converge",
            Self::Pole => "pole or singular",
        }
    }
}

/// |ln(E/E_exact)| ≤ TOLERANCE (1 + |ln(E_exact/E_0)|) is right: 10 % of the decay (or growth) in logarithm, and 10 % of
/// the energy where there is none.
pub const TOLERANCE: f64 = 0.1;

/// Energy beyond this multiple of the exact solution's largest is growing.
pub const GROWTH: f64 = 1e3;

/// A row of `stability.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityRow {
    /// Name of the method.
    pub method: &'static str,
    /// The step.
    pub h: f64,
    /// Name of the parameter that is varied.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// Of the matrix of one step, where the step is linear.
    pub spectral_radius: Option<f64>,
    /// Steps done.
    pub steps_done: u64,
    /// How the run ended.
    pub outcome: &'static str,
}

/// A map over steps and the values of one parameter.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// Where runs start, and the time each one covers (rounded up to whole steps, [`Map::least_steps`] at least).
    pub problem: Problem,
    /// The parameter that is varied.
    pub parameter: &'static str,
    /// Its values.
    pub values: &'a [f64],
    /// The steps.
    pub steps: &'a [f64],
    /// The model at a value of the parameter.
    pub model: fn(f64) -> Model,
    /// The least number of steps of a run.
    pub least_steps: u64,
}

impl Map<'_> {
    /// The cells, method after method, value after value, step after step.
    ///
    /// # Errors
    /// Those of the input. What goes wrong in a cell is its verdict.
    pub fn run(
        &self,
        methods: &[&'static Row],
        progress: &dyn Progress,
    ) -> Result<Vec<StabilityRow>, IntegrateError> {
        let columns: Vec<_> =
            methods.iter().flat_map(|&row| self.values.iter().map(move |&value| (row, value))).collect();
        let rows = columns
            .par_iter()
            .map(|&(row, value)| {
                let problem = Problem { model: (self.model)(value), ..self.problem };
                let cells = self
                    .steps
                    .iter()
                    .map(|&h| self.cell(&problem, row, value, h))
                    .collect::<Result<Vec<_>, _>>();
                progress.advance();
                cells
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(rows.into_iter().flatten().collect())
    }

    fn cell(
        &self,
        problem: &Problem,
        row: &'static Row,
        value: f64,
        h: f64,
    ) -> Result<StabilityRow, IntegrateError> {
        let subject = problem.model.subject::<f64>()?;
        let method = subject.bind(row)?;
        let count = ((problem.end / h).ceil() as u64).max(self.least_steps);
        let exact = subject.solution(&problem.start()?, h, count as usize);
        let exact: Option<Vec<f64>> =
            exact.ok().map(|states| states.iter().map(|state| state.energy(&*subject)).collect());

        let mut state = problem.start()?;
        let initial = state.energy(&*subject);
        let ceiling =
            exact.iter().flatten().fold(initial.abs(), |max, energy| max.max(energy.abs())) * GROWTH;
        let (mut steps_done, mut sum, mut largest) = (0, 0.0, 0.0_f64);
        let result = method.run(Grid::of(h, count)?, &mut state, 1, &mut |step, state| {
            let energy = state.energy(&*subject);
            steps_done = step;
            largest = largest.max(energy.abs());
            if 2 * step >= count {
                sum += energy;
            }
            ControlFlow::Continue(())
        });
        let verdict = match &result {
            Err(IntegrateError::Input(error)) => return Err(error.clone().into()),
            Err(IntegrateError::Run(error)) => match outcome::step_word(&error.failure) {
                "not-finite" => Verdict::NotFinite,
                "pole" | "singular" => Verdict::Pole,
                _ => Verdict::NoConvergence,
            },
            Ok(_) if !largest.is_finite() => Verdict::NotFinite,
            Ok(_) if largest > ceiling => Verdict::Growing,
            Ok(_) => match exact {
                Some(exact) if agrees(sum, exact[(count as usize).div_ceil(2)..].iter().sum(), initial) => {
                    Verdict::Right
                }
                _ => Verdict::Wrong,
            },
        };
        Ok(StabilityRow {
            method: row.name,
            h,
            parameter: self.parameter,
            value,
            verdict,
            spectral_radius: if subject.is_linear() { spectral_radius(&*method, h)? } else { None },
            steps_done,
            outcome: outcome::word(&result),
        })
    }
}

/// Are the two sums of energies over the same steps the same, within the tolerance? What has decayed below any number
/// counts as the smallest one.
fn agrees(sum: f64, exact: f64, initial: f64) -> bool {
    let [sum, exact, initial] = [sum, exact, initial].map(|energy| energy.max(1e-300).ln());
    (sum - exact).abs() <= TOLERANCE * (1.0 + (exact - initial).abs())
}

/// The spectral radius of one step from its action on (1, 0) and (0, 1); none where the step is not linear.
fn spectral_radius(method: &dyn Run<[f64; 1]>, h: f64) -> Result<Option<f64>, InputError> {
    let image = |q: f64, p: f64| -> Result<Option<[f64; 2]>, InputError> {
        let mut state = State::new([q], [p])?;
        Ok(method.step(h, &mut state).ok().map(|_| [state.q[0], state.p[0]]))
    };
    let (Some(a), Some(b), Some(both)) = (image(1.0, 0.0)?, image(0.0, 1.0)?, image(1.0, 1.0)?) else {
        return Ok(None);
    };
    let size = a.iter().chain(&b).fold(1.0, |max: f64, x| max.max(x.abs()));
    if (0..2).any(|i| (a[i] + b[i] - both[i]).abs() > 1e-9 * size) {
        return Ok(None);
    }
    let eigenvalues = Matrix2::new(a[0], b[0], a[1], b[1]).complex_eigenvalues();
    Ok(Some(eigenvalues.iter().map(|z| z.re.hypot(z.im)).fold(0.0, f64::max)))
}
