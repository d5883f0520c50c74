//! `diffsol`: tsit45 and bdf with nalgebra's dense matrices, and for the chain with faer's sparse
//! matrices and a coloured Jacobian.
//!
//! Steps are taken one by one, so that no output is stored. The evaluations are the calls of the
//! right-hand side that the solver counts.

use super::measure::{Line, Run, Spent, Watch};
use super::{Field, Scene, tolerances};
use ::diffsol::matrix::MatrixRef;
use ::diffsol::vector::VectorRef;
use ::diffsol::{
    DefaultDenseMatrix, DefaultSolver, FaerSparseLU, FaerSparseMat, LinearSolver, Matrix,
    NalgebraLU, NalgebraMat, OdeBuilder, OdeEquationsImplicit, OdeSolverMethod, OdeSolverProblem,
    OdeSolverStopReason, Op, Vector,
};

#[derive(Clone, Copy)]
enum Kind {
    Tsit45,
    Bdf,
}

macro_rules! lines {
    ($scene:expr, $field:expr, $matrix:ty, $solver:ty) => {{
        let line = |method, kind| {
            let (start, end, field) = ($scene.start(), $scene.problem.end, $field);
            Line::peer(method, tolerances(), move |tolerance| {
                let (size, start) = (start.len(), start.clone());
                let problem = OdeBuilder::<$matrix>::new()
                    .rtol(tolerance)
                    .atol([tolerance])
                    .rhs_implicit(
                        move |y: &[f64], _: &[f64], _: f64, dy: &mut [f64]| field.rates(y, dy),
                        move |y: &[f64], _: &[f64], _: f64, v: &[f64], jv: &mut [f64]| {
                            field.derivative(y, v, jv)
                        },
                    )
                    .init(move |_: &[f64], _: f64, y: &mut [f64]| y.copy_from_slice(&start), size)
                    .build()
                    .map_err(|error| error.to_string())?;
                let run: Run = Box::new(move |last, watch| {
                    follow::<_, $solver>(&problem, kind, end, last, watch)
                });
                Ok(run)
            })
        };
        vec![line("diffsol-tsit45", Kind::Tsit45), line("diffsol-bdf", Kind::Bdf)]
    }};
}

/// Both methods with dense matrices.
pub fn dense<F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    lines!(scene, field, NalgebraMat<f64>, NalgebraLU<f64>)
}

/// Both methods with sparse matrices.
pub fn sparse<F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    lines!(scene, field, FaerSparseMat<f64>, FaerSparseLU<f64>)
}

fn follow<E, L>(
    problem: &OdeSolverProblem<E>,
    kind: Kind,
    end: f64,
    last: &mut [f64],
    watch: Option<Watch<'_>>,
) -> Result<Spent, String>
where
    E: OdeEquationsImplicit<T = f64>,
    E::V: DefaultDenseMatrix,
    E::M: Matrix + DefaultSolver,
    L: LinearSolver<E::M>,
    for<'a> &'a E::V: VectorRef<E::V>,
    for<'a> &'a E::M: MatrixRef<E::M>,
{
    let before = problem.eqn.rhs().statistics().number_of_calls;
    let (steps, iterations) = match kind {
        Kind::Tsit45 => {
            carry(problem.tsit45().map_err(|error| error.to_string())?, end, last, watch)
        }
        Kind::Bdf => {
            carry(problem.bdf::<L>().map_err(|error| error.to_string())?, end, last, watch)
        }
    }?;
    let evaluations = (problem.eqn.rhs().statistics().number_of_calls - before) as u64;
    Ok(Spent {
        steps,
        evaluations,
        iterations: matches!(kind, Kind::Bdf).then_some(iterations),
        seconds: None,
    })
}

/// Runs to the end. Returns the numbers of accepted steps and of Newton iterations.
fn carry<'a, E, S>(
    mut solver: S,
    end: f64,
    last: &mut [f64],
    mut watch: Option<Watch<'_>>,
) -> Result<(u64, u64), String>
where
    E: OdeEquationsImplicit<T = f64> + 'a,
    S: OdeSolverMethod<'a, E>,
{
    solver.set_stop_time(end).map_err(|error| error.to_string())?;
    loop {
        let why = solver.step().map_err(|error| error.to_string())?;
        if let Some(watch) = &mut watch {
            watch(&solver.state().y.clone_as_vec());
        }
        if why == OdeSolverStopReason::TstopReached {
            break;
        }
    }
    last.copy_from_slice(&solver.state().y.clone_as_vec());
    let counted = solver.get_statistics();
    Ok((counted.number_of_steps as u64, counted.number_of_nonlinear_solver_iterations as u64))
}
