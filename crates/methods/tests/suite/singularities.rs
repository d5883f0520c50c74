//! No method steps across a singularity of V or D, given as an expression, or of V as `Formulas`.

use crate::bind::by_force;
use crate::k_on_expressions::{bind, custom};
use afterbay_core::{
    Formulas, FromFormulas, Grid, IntegrateError, RunError, Scalar, Separable, State, StateRef,
    StepFailure, System,
};
use afterbay_methods::registry::{FIXED, Row, Run, find};
use std::ops::ControlFlow;

/// V = 1/q² for one degree of freedom, 1/(q1 - q2)² for two.
struct Repelling {
    n: usize,
}

impl Formulas for Repelling {
    fn dof(&self) -> usize {
        self.n
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let r = if self.n == 1 { q[0] } else { q[0] - q[1] };
        T::one() / (r * r)
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
        T::from_f64(0.1) * v[j]
    }
}

/// Checks that steps across the singularity fail with `AcrossSingularity`, and that no state lies
/// beyond it. The coordinate named begins where the step does, but for methods `within_step`.
/// Returns the numbers of runs that failed so and of the others.
fn no_step_crosses(
    bind: impl Fn(&Row) -> Option<Run<f64>>,
    n: usize,
    system: &dyn Separable<f64>,
    within_step: fn(&Row) -> bool,
) -> [u32; 2] {
    let [mut refused, mut stayed] = [0; 2];
    for row in FIXED {
        let Some(run) = bind(row) else { continue };
        for h in [0.01, 0.3, 1.0, 4.0] {
            let (q, p) =
                if n == 1 { (vec![1.0], vec![-9.0]) } else { (vec![1.0, 0.0], vec![-9.0, 0.0]) };
            let mut state = State::new(q, p).unwrap();
            let mut beyond = false;
            let mut show = |_: u64, at: StateRef<'_, f64>| {
                beyond |= if n == 1 { at.q[0] <= 0.0 } else { at.q[0] <= at.q[1] };
                ControlFlow::Continue(())
            };
            let outcome = run.run(Grid { h, steps: 20 }, &mut state, 1, &mut show);
            assert!(!beyond, "{}, h = {h}, {n}", row.name);
            match outcome {
                Err(IntegrateError::Run(RunError {
                    failure: StepFailure::AcrossSingularity { dof, from, to },
                    ..
                })) => {
                    let is_start = state.q[dof] == from || within_step(row);
                    assert!(dof < n && from != to && is_start, "{}", row.name);
                    refused += 1;
                }
                _ => stayed += 1,
            }
            assert!(system.energy(&state.q, &state.p).is_finite());
        }
    }
    [refused, stayed]
}

#[test]
fn no_method_steps_across_a_singularity() {
    for n in [1, 2] {
        let written = custom(if n == 1 { "1/q1^2" } else { "1/(q1 - q2)^2" }, "c*p", n, 0.1);
        let system = written.separable();
        let found = no_step_crosses(|row| bind(row, &written), n, &*system, |_| false);
        println!("{n}: {found:?}");
        assert!(found[0] > 5 && found[1] > 20, "{found:?}");
        // Increments stay on their side of the pole, so that no step of theirs is refused.
        let found = formulas_do_not_cross(n);
        println!("{n}: {found:?} of formulas");
        assert!(found[2] > 2 && found[..2] == [0, 0], "{found:?}");
    }
}

/// The exact motion creeps towards the pole of D: with u = p - c/q and V = q²/2, u' = -q, so that p
/// would have to grow beyond all bounds.
#[test]
fn no_method_steps_across_a_singularity_of_the_dissipation() {
    for (n, dissipation) in [(1, "c*v1/q1^2"), (2, "c*p/(q1 - q2)^2")] {
        let potential = if n == 1 { "q1^2/2" } else { "(q1 - q2)^2/2" };
        let written = custom(potential, dissipation, n, 0.02);
        // The edge of an increment begins where the one before it has ended.
        let within = |row: &Row| row.name.starts_with("increment");
        let found = no_step_crosses(|row| bind(row, &written), n, &*written.separable(), within);
        println!("{n}: {found:?}");
        assert!(found[0] > 20, "{found:?}");
    }
    // Denominators that stay above zero have no pole.
    for dissipation in ["c*v1/(1 + q1^2)", "c*v1/sqrt(q1^2 + v1^2 + 1)", "c*v1*(2 + cos(q1))"] {
        let written = custom("q1^2/2", dissipation, 1, 0.02);
        assert!(!System::<f64>::may_be_singular(&*written.separable()), "{dissipation}");
    }
}

/// Runs increments and RK4 on [`Formulas`], and returns at how many h each is refused.
fn formulas_do_not_cross(n: usize) -> [usize; 3] {
    ["increment-2", "increment-4", "rk4"].map(|name| {
        let steps = [0.01, 0.1, 0.3, 1.0, 4.0].into_iter();
        steps.filter(|&h| formulas_are_refused(name, n, h)).count()
    })
}

/// Whether a step of a method on [`Formulas`] is refused since it would cross the singularity.
fn formulas_are_refused(name: &str, n: usize, h: f64) -> bool {
    let run = by_force(find(name).unwrap(), FromFormulas(Repelling { n })).unwrap();
    let (q, p) = if n == 1 { (vec![1.0], vec![-9.0]) } else { (vec![1.0, 0.0], vec![-9.0, 0.0]) };
    let (mut state, mut beyond) = (State::new(q, p).unwrap(), false);
    let outcome = run.run(Grid { h, steps: 20 }, &mut state, 1, &mut |_, at| {
        beyond |= if n == 1 { at.q[0] <= 0.0 } else { at.q[0] <= at.q[1] };
        ControlFlow::Continue(())
    });
    assert!(!beyond, "{name}, h = {h}, {n}");
    let Err(IntegrateError::Run(error)) = outcome else { return false };
    matches!(error.failure, StepFailure::AcrossSingularity { .. })
}

/// A function that a step may cross: it is finite everywhere, although an interval enclosure does
/// not show it.
struct Touching;

impl Formulas for Touching {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        (q[0] * q[0] + q[1] * q[1]).sqrt() + T::one() / (T::one() + q[0] * q[0])
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], _v: &[T], _j: usize) -> T {
        T::zero()
    }
}

#[test]
fn a_root_at_zero_is_no_singularity() {
    let system = FromFormulas(Touching);
    let crossed =
        |from: [f64; 2], to: [f64; 2]| System::<f64>::is_singular_between(&system, &from, &to);
    for (from, to) in
        [([-1.0, 0.0], [1.0, 0.0]), ([-3.0, 1.0], [7.0, -2.0]), ([1.0, 1.0], [-1.0, -1.0])]
    {
        assert!(!crossed(from, to) && !crossed(to, from), "{from:?} {to:?}");
    }
    assert!(!Separable::<f64>::is_singular_along(&system, &[-1.0, 0.0], 0, 2.0));
}

/// The coordinate that meets the singularity is named, not the one that moves furthest.
#[test]
fn the_coordinate_that_meets_a_singularity_is_named() {
    for (potential, named) in [("-1/q1 + 0*q2 + 0*q3", 0), ("0*q1 - 1/q2 + 0*q3", 1)] {
        let system = custom(potential, "0*c*p", 3, 1.0);
        let mut run_refused = 0;
        for row in FIXED {
            let Some(run) = bind(row, &system) else { continue };
            let (mut q, mut p) = (vec![0.0; 3], vec![50.0; 3]);
            (q[named], p[named]) = (1.0, -1.0);
            let mut state = State::new(q, p).unwrap();
            let mut show = |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
            let outcome = run.run(Grid { h: 0.1, steps: 20 }, &mut state, 1, &mut show);
            if let Err(IntegrateError::Run(RunError {
                failure: StepFailure::AcrossSingularity { dof, .. },
                ..
            })) = outcome
            {
                assert_eq!(dof, named, "{}, {potential}", row.name);
                run_refused += 1;
            }
        }
        assert!(run_refused > 5, "{run_refused}");
    }
}
