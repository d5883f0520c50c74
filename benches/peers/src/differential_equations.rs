//! `differential-equations`: dop853, rkv988e (Verner's 9(8) pair, 16 stages) and radau5, with
//! states in arrays, and for the chain in vectors.
//!
//! The solver writes to an output that stores nothing. It computes the stages of the interpolant
//! nevertheless; this cannot be switched off. Of the two pairs of order 9, rkv988e has fewer of
//! these stages. radau5 uses the Jacobian in closed form; its matrices are dense. Tolerances are
//! passed to it as vectors, because version 0.7.0 rescales a scalar one once for every entry of y.

use super::measure::{Line, Run, Spent, Watch};
use super::{Field, Scene, tolerances};
use ::differential_equations::control::ControlFlag;
use ::differential_equations::interpolate::Interpolation;
use ::differential_equations::linalg::Matrix;
use ::differential_equations::methods::{ExplicitRungeKutta, ImplicitRungeKutta};
use ::differential_equations::ode::{ODE, OrdinaryNumericalMethod, solve_ode};
use ::differential_equations::solout::Solout;
use ::differential_equations::solution::Solution;
use ::differential_equations::traits::State;

const STEPS: usize = 50_000_000;

struct Rates<F>(F);

impl<F: Field, Y: State<f64> + AsRef<[f64]> + AsMut<[f64]>> ODE<f64, Y> for Rates<F> {
    #[inline(always)]
    fn diff(&self, _t: f64, y: &Y, dy: &mut Y) {
        self.0.rates(y.as_ref(), dy.as_mut());
    }

    fn jacobian(&self, _t: f64, y: &Y, jacobian: &mut Matrix<f64>) {
        let y = y.as_ref();
        let (mut unit, mut column) = (vec![0.0; y.len()], vec![0.0; y.len()]);
        for j in 0..y.len() {
            unit[j] = 1.0;
            self.0.derivative(y, &unit, &mut column);
            unit[j] = 0.0;
            column.iter().enumerate().for_each(|(i, &entry)| jacobian[(i, j)] = entry);
        }
    }
}

/// An output that stores nothing, and shows each step to a watcher.
struct Look<'a>(Option<Watch<'a>>);

impl<Y: State<f64> + AsRef<[f64]>> Solout<f64, Y> for Look<'_> {
    fn solout<I: Interpolation<f64, Y> + ?Sized>(
        &mut self,
        _t: f64,
        _before: f64,
        y: &Y,
        _y_before: &Y,
        _interpolator: &mut I,
        _solution: &mut Solution<f64, Y>,
    ) -> ControlFlag<f64, Y> {
        if let Some(watch) = &mut self.0 {
            watch(y.as_ref());
        }
        ControlFlag::Continue
    }
}

/// The run of a method, which `make` creates anew each time.
fn run<F, Y, S>(field: F, start: Y, end: f64, make: impl Fn() -> S + 'static) -> Run
where
    F: Field,
    Y: Storage,
    S: OrdinaryNumericalMethod<f64, Y> + Interpolation<f64, Y>,
{
    Box::new(move |last, watch| {
        let mut method = make();
        let solution = solve_ode(&mut method, &Rates(field), 0.0, end, &start, &mut Look(watch))
            .map_err(|error| reason(&format!("{error:?}")))?;
        last.copy_from_slice(method.y().as_ref());
        Ok(Spent {
            steps: solution.steps.accepted as u64,
            evaluations: solution.evals.function as u64,
            iterations: (solution.evals.newton > 0).then_some(solution.evals.newton as u64),
            seconds: None,
        })
    })
}

/// The name of an error, without the state it contains.
fn reason(error: &str) -> String {
    error.split(['{', '(']).next().unwrap_or_default().trim().to_owned()
}

/// The storage of the library's states.
pub trait Storage: State<f64> + AsRef<[f64]> + AsMut<[f64]> + 'static {}

impl<Y: State<f64> + AsRef<[f64]> + AsMut<[f64]> + 'static> Storage for Y {}

fn explicit<F: Field, Y: Storage>(scene: &Scene, field: F, start: Y) -> Vec<Line> {
    let end = scene.problem.end;
    let again = start.clone();
    let eighth = Line::peer("de-dop853", tolerances(), move |tolerance| {
        Ok(run(field, start.clone(), end, move || {
            ExplicitRungeKutta::dop853()
                .rtol(tolerance)
                .atol(tolerance)
                .max_steps(STEPS)
                .max_rejects(STEPS)
        }))
    });
    let ninth = Line::peer("de-rkv988e", tolerances(), move |tolerance| {
        Ok(run(field, again.clone(), end, move || {
            ExplicitRungeKutta::rkv988e()
                .rtol(tolerance)
                .atol(tolerance)
                .max_steps(STEPS)
                .max_rejects(STEPS)
        }))
    });
    vec![eighth, ninth]
}

/// radau5 with y in N numbers on the stack. With vectors, version 0.7.0 panics, since it creates
/// its stages with length 0.
pub fn radau5<const N: usize, F: Field>(scene: &Scene, field: F) -> Line {
    let (start, end) = (stack::<N>(scene), scene.problem.end);
    Line::peer("de-radau5", tolerances(), move |tolerance| {
        let each = move || vec![tolerance; N];
        Ok(run(field, start, end, move || {
            ImplicitRungeKutta::radau5()
                .rtol(each())
                .atol(each())
                .max_steps(STEPS)
                .max_rejects(1000)
        }))
    })
}

/// The three methods with y in N numbers on the stack.
pub fn lines<const N: usize, F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    let mut lines = explicit(scene, field, stack::<N>(scene));
    lines.push(radau5::<N, F>(scene, field));
    lines
}

/// The explicit methods with y on the heap.
pub fn dynamic<F: Field>(scene: &Scene, field: F) -> Vec<Line> {
    explicit(scene, field, scene.start())
}

fn stack<const N: usize>(scene: &Scene) -> [f64; N] {
    let start = scene.start();
    std::array::from_fn(|j| start[j])
}
