//! `ode_solvers`: Dopri5 and Dop853, with states in static vectors, and for the chain in dynamic
//! ones.
//!
//! `OutputType::Sparse` stores the state after each step without interpolation; the library has no
//! option to store less. The stiffness test is off and the number of steps practically unlimited,
//! so that stiff runs end where the tolerance permits.

use super::measure::{Line, Run, Spent, Watch};
use super::{Field, Scene, tolerances};
use ::ode_solvers::{DVector, Dop853, Dopri5, OutputType, SVector, System};

struct Rates<F>(F);

impl<F: Field, const N: usize> System<f64, SVector<f64, N>> for Rates<F> {
    #[inline(always)]
    fn system(&self, _t: f64, y: &SVector<f64, N>, dy: &mut SVector<f64, N>) {
        self.0.rates(&y.data.0[0], &mut dy.data.0[0]);
    }
}

impl<F: Field> System<f64, DVector<f64>> for Rates<F> {
    #[inline]
    fn system(&self, _t: f64, y: &DVector<f64>, dy: &mut DVector<f64>) {
        self.0.rates(y.as_slice(), dy.as_mut_slice());
    }
}

const STEPS: u32 = 50_000_000;

/// Creates a solver with the library's defaults except for the settings above, runs it, and
/// observes the result.
macro_rules! run {
    (
        $solver:ident, ($safety:expr, $beta:expr, $least:expr, $most:expr),
        $field:expr, $start:expr, $end:expr, $tolerance:expr
    ) => {{
        let (field, start, end): (_, _, f64) = ($field, $start, $end);
        let tolerance: f64 = $tolerance;
        let run: Run =
            Box::new(move |last: &mut [f64], watch: Option<Watch<'_>>| -> Result<Spent, String> {
                let mut solver = $solver::from_param(
                    Rates(field),
                    0.0,
                    end,
                    end,
                    start.clone(),
                    tolerance,
                    tolerance,
                    $safety,
                    $beta,
                    $least,
                    $most,
                    end,
                    0.0,
                    STEPS,
                    STEPS,
                    OutputType::Sparse,
                );
                let spent = solver.integrate().map_err(|error| error.to_string())?;
                let states = solver.y_out();
                if let Some(watch) = watch {
                    states.iter().for_each(|y| watch(y.as_slice()));
                }
                last.copy_from_slice(states.last().ok_or("no state")?.as_slice());
                let (steps, evaluations) = (spent.accepted_steps.into(), spent.num_eval.into());
                Ok(Spent { steps, evaluations, iterations: None, seconds: None })
            });
        run
    }};
}

macro_rules! lines {
    ($scene:expr, $field:expr, $start:expr) => {{
        let (field, end, start) = ($field, $scene.problem.end, $start);
        let again = start.clone();
        vec![
            line("ode_solvers-dopri5", move |tolerance| {
                run!(Dopri5, (0.9, 0.04, 0.2, 10.0), field, again.clone(), end, tolerance)
            }),
            line("ode_solvers-dop853", move |tolerance| {
                run!(Dop853, (0.9, 0.0, 0.333, 6.0), field, start.clone(), end, tolerance)
            }),
        ]
    }};
}

/// Both methods with y in N numbers on the stack.
pub fn lines<const N: usize, F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    lines!(scene, field, SVector::<f64, N>::from_column_slice(&scene.start()))
}

/// Both methods with y on the heap.
pub fn dynamic<F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    lines!(scene, field, DVector::from_vec(scene.start()))
}

fn line(method: &'static str, bind: impl Fn(f64) -> Run + 'static) -> Line {
    Line::peer(method, tolerances(), move |tolerance| Ok(bind(tolerance)))
}
