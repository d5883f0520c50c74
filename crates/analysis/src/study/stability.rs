//! Stability where methods fail: a verdict for every (h, parameter), and for linear systems the spectral radius of the
//! step beside it.

use super::{Problem, outcome};
use crate::progress::Progress;
use crate::{Model, Subject};
use afterbay_core::{Effort, Grid, InputError, IntegrateError, State, StepFailure};
use afterbay_methods::registry::{self, Row, Run};
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

/// The most steps a run may have.
const MOST_STEPS: f64 = 1e7;

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
        let by_value = self
            .values
            .par_iter()
            .map(|&value| {
                let problem = Problem { model: (self.model)(value), ..self.problem.clone() };
                let columns = self
                    .steps
                    .iter()
                    .map(|&h| self.column(&problem, methods, value, h))
                    .collect::<Result<Vec<_>, _>>();
                progress.advance();
                columns
            })
            .collect::<Result<Vec<_>, _>>()?;
        let of_method =
            |i: usize| by_value.iter().flatten().map(move |cells: &Vec<StabilityRow>| cells[i].clone());
        Ok((0..methods.len()).flat_map(of_method).collect())
    }

    /// How many steps of size h a run takes.
    fn steps_of(&self, h: f64) -> Result<u64, InputError> {
        Grid::<f64>::of(h, self.least_steps)?;
        let steps = (self.problem.end / h).ceil();
        if steps.is_nan() || steps > MOST_STEPS {
            return Err(InputError::Budget { steps, limit: MOST_STEPS });
        }
        Ok((steps as u64).max(self.least_steps))
    }

    /// The cells of every method at one value and step.
    fn column(
        &self,
        problem: &Problem,
        methods: &[&'static Row],
        value: f64,
        h: f64,
    ) -> Result<Vec<StabilityRow>, IntegrateError> {
        let subject = problem.model.subject::<f64>()?;
        let count = self.steps_of(h)?;
        let exact = reference(problem, &*subject, h, count)?;
        let initial = problem.start()?.energy(&*subject);
        methods
            .iter()
            .map(|row| {
                let method = problem.model.bind(row)?;
                let (found, steps_done, result) = energies(problem, &*subject, &method, h, count, 1)?;
                let verdict = match &result {
                    Err(IntegrateError::Input(error)) => return Err(error.clone().into()),
                    Err(IntegrateError::Run(error)) => match error.failure {
                        StepFailure::NonFinite { .. } => Verdict::NotFinite,
                        StepFailure::Pole { .. } | StepFailure::Singular { .. } => Verdict::Pole,
                        StepFailure::NotContracting { .. }
                        | StepFailure::NewtonStalled { .. }
                        | StepFailure::Unresolved { .. }
                        | StepFailure::TooLong { .. }
                        | StepFailure::NoRelaxationRoot { .. }
                        | StepFailure::Vanishes { .. } => Verdict::NoConvergence,
                    },
                    Ok(_) if !found.largest.is_finite() => Verdict::NotFinite,
                    Ok(_) => match exact {
                        Some(exact) if found.largest > GROWTH * exact.largest => Verdict::Growing,
                        Some(exact) if found.agrees(&exact, initial, TOLERANCE) => Verdict::Right,
                        _ => Verdict::Wrong,
                    },
                };
                Ok(StabilityRow {
                    method: row.name,
                    h,
                    parameter: self.parameter,
                    value,
                    verdict,
                    spectral_radius: if subject.is_linear() { spectral_radius(&method, h)? } else { None },
                    steps_done,
                    outcome: outcome::word(&result),
                })
            })
            .collect()
    }
}

/// The energy along a run: its sum over the second half, and its largest size.
#[derive(Clone, Copy, Debug)]
struct Energies {
    sum: f64,
    largest: f64,
}

impl Energies {
    /// Are the two the same within the tolerance? What has decayed below any number counts as the smallest one.
    fn agrees(&self, exact: &Self, initial: f64, tolerance: f64) -> bool {
        let [found, exact, initial] = [self.sum, exact.sum, initial].map(|energy| energy.max(1e-300).ln());
        (found - exact).abs() <= tolerance * (1.0 + (exact - initial).abs())
    }

    /// Nothing seen yet.
    const NONE: Self = Self { sum: 0.0, largest: 0.0 };

    /// Takes in the energy after `step` of `count` steps.
    fn see(&mut self, step: u64, count: u64, energy: f64) {
        self.largest = self.largest.max(energy.abs());
        if 2 * step >= count {
            self.sum += energy;
        }
    }
}

/// Runs a method over `count` steps of size h, each cut in `parts`, and looks at the energy at the whole ones.
fn energies(
    problem: &Problem,
    subject: &dyn Subject<f64>,
    method: &Run<f64>,
    h: f64,
    count: u64,
    parts: u64,
) -> Result<(Energies, u64, Result<Effort, IntegrateError>), IntegrateError> {
    let mut state = problem.start()?;
    let (mut seen, mut steps_done) = (Energies::NONE, 0);
    let grid = Grid::of(h / parts as f64, count * parts)?;
    let result = method.run(grid, &mut state, parts, &mut |step, state| {
        steps_done = step / parts;
        seen.see(steps_done, count, state.energy(subject));
        ControlFlow::Continue(())
    });
    Ok((seen, steps_done, result))
}

/// The energies of the exact solution at the same times: from the exact flow, else from RK4 with its step cut until
/// cutting it further changes a hundredth of the tolerance at most. None where the solution leaves the numbers.
fn reference(
    problem: &Problem,
    subject: &dyn Subject<f64>,
    h: f64,
    count: u64,
) -> Result<Option<Energies>, IntegrateError> {
    if subject.is_linear() {
        let Ok(states) = subject.solution(&problem.start()?, h, count as usize) else { return Ok(None) };
        let mut energies = Energies::NONE;
        (0..).zip(states.states()).for_each(|(step, state)| energies.see(step, count, state.energy(subject)));
        return Ok(Some(energies));
    }
    let Some(rk4) = registry::find("rk4") else { return Ok(None) };
    let method = problem.model.bind(rk4)?;
    let initial = problem.start()?.energy(subject);
    let mut parts = (h / COARSEST).ceil() as u64;
    let mut before: Option<Energies> = None;
    while h / parts as f64 > FINEST {
        let (found, _, result) = energies(problem, subject, &method, h, count, parts)?;
        let found = result.is_ok().then_some(found);
        if let Some((before, found)) = before.zip(found)
            && found.agrees(&before, initial, TOLERANCE / 100.0)
        {
            return Ok(Some(found));
        }
        before = found;
        parts *= 2;
    }
    Ok(None)
}

/// The first and the last step RK4 is tried with for a reference.
const COARSEST: f64 = 0.02;
const FINEST: f64 = 1e-5;

/// The spectral radius of one step from its action on (1, 0) and (0, 1); none where the step is not linear.
fn spectral_radius(method: &Run<f64>, h: f64) -> Result<Option<f64>, InputError> {
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
