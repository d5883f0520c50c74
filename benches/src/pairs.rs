//! The pairs: a run through the public API, and the run it is compared with.

use crate::by_hand::{self, Task};
use afterbay_analysis::Model;
use afterbay_core::{Grid, IntegrateError, Method, State, StateRef, System, Vector, integrate};
use afterbay_methods::{Leapfrog, ModDg, Rk4, registry};
use afterbay_systems::{DAMPED_OSCILLATOR, DUFFING, DampedOscillator, Duffing};
use nalgebra::SVector;
use std::hint::black_box;
use std::ops::ControlFlow;

/// The number of steps in a run.
pub const STEPS: u64 = 10_000;

/// One run of [`STEPS`] steps. Returns the final (q, p, w), or `None` if it fails.
pub type Run = Box<dyn Fn() -> Option<[f64; 3]>>;

/// The aspect that a pair measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The generic step for one system.
    Step,
    /// The same step in another storage.
    Storage,
    /// D = 0, compared with conservative code without a reservoir.
    Conservative,
    /// Method and system behind dynamic dispatch, as in a scene.
    Dispatch,
}

impl Subject {
    /// The name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Storage => "storage",
            Self::Conservative => "conservative",
            Self::Dispatch => "dispatch",
        }
    }

    /// The largest acceptable ratio.
    pub fn bar(self) -> f64 {
        if self == Self::Conservative { 1.02 } else { 1.05 }
    }
}

/// A run timed twice: through the API and by a loop written by hand.
pub struct Pair {
    /// The aspect measured.
    pub subject: Subject,
    /// The method, the system and further distinctions.
    pub name: String,
    /// The run through the public API.
    pub generic: Run,
    /// The run written by hand for this system.
    pub by_hand: Run,
}

const TASK: Task = Task { h: 0.01, steps: STEPS, q: 2.3, p: -3.1 };
const WELLS: Task = Task { h: 0.01, steps: STEPS, q: 1.2, p: 0.4 };

/// A run through [`integrate`] without an observer.
fn generic<V, S, M>(task: Task, method: M, system: S) -> Run
where
    V: Vector<Scalar = f64>,
    S: System<f64> + Copy + 'static,
    M: Method<V, S> + 'static,
{
    Box::new(move || {
        run::<V>(task, |grid, state| {
            integrate(&method, &black_box(system), grid, state, &mut ()).map(drop)
        })
    })
}

/// A run through the registry, without intermediate output.
fn dispatched(task: Task, method: registry::Run<f64>) -> Run {
    Box::new(move || {
        run::<[f64; 1]>(task, |grid, state| {
            let show = &mut |_, _: StateRef<'_, f64>| ControlFlow::Continue(());
            black_box(&method).run(grid, state, u64::MAX, show).map(drop)
        })
    })
}

fn run<V: Vector<Scalar = f64>>(
    task: Task,
    run: impl Fn(Grid<f64>, &mut State<V>) -> Result<(), IntegrateError>,
) -> Option<[f64; 3]> {
    let Task { h, steps, q, p } = black_box(task);
    let vector = |x| {
        let mut vector = V::zeros(1);
        vector.as_mut_slice()[0] = x;
        vector
    };
    let mut state = State::new(vector(q), vector(p)).ok()?;
    run(Grid::of(h, steps).ok()?, &mut state).ok()?;
    Some(black_box([state.q.as_slice()[0], state.p.as_slice()[0], state.w.as_slice()[0]]))
}

fn by_hand<S: Copy + 'static>(task: Task, system: S, run: fn(S, Task) -> Option<[f64; 3]>) -> Run {
    Box::new(move || black_box(run(black_box(system), black_box(task))))
}

/// Every pair. The first is RK4 for the damped oscillator, the reference of the others.
pub fn pairs() -> Vec<Pair> {
    use Subject::{Conservative, Dispatch, Step, Storage};
    type Fixed = [f64; 1];
    type Static = SVector<f64, 1>;
    type Heap = Vec<f64>;

    let oscillator = DampedOscillator::new(1.0, 0.1).expect("parameters in range");
    let duffing = |alpha, beta, c| Duffing::new(alpha, beta, c).expect("finite parameters");
    let (single, double, free) =
        (duffing(1.0, 0.5, 0.1), duffing(-1.0, 1.0, 0.02), duffing(1.0, 0.5, 0.0));
    let conservative = crate::conservative::Conservative(free);
    let hand_oscillator = by_hand::Oscillator { k: 1.0, b: 0.1 };
    let hand_single = by_hand::Duffing { alpha: 1.0, beta: 0.5, c: 0.1 };
    let hand_double = by_hand::Duffing { alpha: -1.0, beta: 1.0, c: 0.02 };
    let hand_free = by_hand::Duffing { c: 0.0, ..hand_single };

    let oscillator_by =
        |run: fn(by_hand::Oscillator, Task) -> _| by_hand(TASK, hand_oscillator, run);
    let single_by = |run: fn(by_hand::Duffing, Task) -> _| by_hand(TASK, hand_single, run);
    let double_by = |run: fn(by_hand::Duffing, Task) -> _| by_hand(WELLS, hand_double, run);
    let free_by = |run: fn(by_hand::Duffing, Task) -> _| by_hand(TASK, hand_free, run);
    let linear = |name| {
        let row = registry::find(name).expect("a registered method");
        let model = Model::of(&DAMPED_OSCILLATOR, &[1.0, 0.1]);
        dispatched(TASK, model.bind(row).expect("a method for linear systems"))
    };
    let nonlinear = |name| {
        let row = registry::find(name).expect("a registered method");
        let model = Model::of(&DUFFING, &[1.0, 0.5, 0.1]);
        dispatched(TASK, model.bind(row).expect("a method for any system"))
    };
    let [hand_leapfrog, hand_rk4, hand_moddg, hand_newton] = [
        by_hand::Oscillator::leapfrog,
        by_hand::Oscillator::rk4,
        by_hand::Oscillator::moddg,
        by_hand::Oscillator::moddg_by_newton,
    ];
    let [leapfrog, rk4, moddg] =
        [by_hand::Duffing::leapfrog, by_hand::Duffing::rk4, by_hand::Duffing::moddg];
    let [free_leapfrog, free_rk4, free_moddg] = [
        by_hand::Duffing::conservative_leapfrog,
        by_hand::Duffing::conservative_rk4,
        by_hand::Duffing::conservative_moddg,
    ];
    let rows = [
        (
            Step,
            "rk4, damped oscillator",
            generic::<Fixed, _, _>(TASK, Rk4, oscillator),
            oscillator_by(hand_rk4),
        ),
        (
            Step,
            "leapfrog, damped oscillator",
            generic::<Fixed, _, _>(TASK, Leapfrog, oscillator),
            oscillator_by(hand_leapfrog),
        ),
        (
            Step,
            "moddg, damped oscillator",
            generic::<Fixed, _, _>(TASK, ModDg::linear(), oscillator),
            oscillator_by(hand_moddg),
        ),
        (
            Step,
            "moddg by Newton, damped oscillator",
            generic::<Fixed, _, _>(TASK, ModDg::newton(), oscillator),
            oscillator_by(hand_newton),
        ),
        (Step, "rk4, Duffing", generic::<Fixed, _, _>(TASK, Rk4, single), single_by(rk4)),
        (
            Step,
            "leapfrog, Duffing",
            generic::<Fixed, _, _>(TASK, Leapfrog, single),
            single_by(leapfrog),
        ),
        (
            Step,
            "moddg, Duffing",
            generic::<Fixed, _, _>(TASK, ModDg::newton(), single),
            single_by(moddg),
        ),
        (
            Step,
            "rk4, Duffing, two wells",
            generic::<Fixed, _, _>(WELLS, Rk4, double),
            double_by(rk4),
        ),
        (
            Step,
            "leapfrog, Duffing, two wells",
            generic::<Fixed, _, _>(WELLS, Leapfrog, double),
            double_by(leapfrog),
        ),
        (
            Step,
            "moddg, Duffing, two wells",
            generic::<Fixed, _, _>(WELLS, ModDg::newton(), double),
            double_by(moddg),
        ),
        (
            Storage,
            "leapfrog, damped oscillator, SVector",
            generic::<Static, _, _>(TASK, Leapfrog, oscillator),
            oscillator_by(hand_leapfrog),
        ),
        (
            Storage,
            "moddg, damped oscillator, SVector",
            generic::<Static, _, _>(TASK, ModDg::linear(), oscillator),
            oscillator_by(hand_moddg),
        ),
        (
            Storage,
            "leapfrog, Duffing, SVector",
            generic::<Static, _, _>(TASK, Leapfrog, single),
            single_by(leapfrog),
        ),
        (
            Storage,
            "moddg, Duffing, SVector",
            generic::<Static, _, _>(TASK, ModDg::newton(), single),
            single_by(moddg),
        ),
        (
            Storage,
            "leapfrog, damped oscillator, Vec",
            generic::<Heap, _, _>(TASK, Leapfrog, oscillator),
            oscillator_by(hand_leapfrog),
        ),
        (
            Storage,
            "moddg, damped oscillator, Vec",
            generic::<Heap, _, _>(TASK, ModDg::linear(), oscillator),
            oscillator_by(hand_moddg),
        ),
        (
            Storage,
            "leapfrog, Duffing, Vec",
            generic::<Heap, _, _>(TASK, Leapfrog, single),
            single_by(leapfrog),
        ),
        (
            Storage,
            "moddg, Duffing, Vec",
            generic::<Heap, _, _>(TASK, ModDg::newton(), single),
            single_by(moddg),
        ),
        (
            Conservative,
            "rk4, no dissipation",
            generic::<Fixed, _, _>(TASK, Rk4, conservative),
            free_by(free_rk4),
        ),
        (
            Conservative,
            "leapfrog, no dissipation",
            generic::<Fixed, _, _>(TASK, Leapfrog, conservative),
            free_by(free_leapfrog),
        ),
        (
            Conservative,
            "moddg, no dissipation",
            generic::<Fixed, _, _>(TASK, ModDg::newton(), conservative),
            free_by(free_moddg),
        ),
        (
            Conservative,
            "rk4, Duffing, c = 0",
            generic::<Fixed, _, _>(TASK, Rk4, free),
            free_by(free_rk4),
        ),
        (
            Conservative,
            "leapfrog, Duffing, c = 0",
            generic::<Fixed, _, _>(TASK, Leapfrog, free),
            free_by(free_leapfrog),
        ),
        (
            Conservative,
            "moddg, Duffing, c = 0",
            generic::<Fixed, _, _>(TASK, ModDg::newton(), free),
            free_by(free_moddg),
        ),
        (Dispatch, "rk4, damped oscillator", linear("rk4"), oscillator_by(hand_rk4)),
        (Dispatch, "leapfrog, damped oscillator", linear("leapfrog"), oscillator_by(hand_leapfrog)),
        (Dispatch, "moddg, damped oscillator", linear("moddg"), oscillator_by(hand_moddg)),
        (Dispatch, "rk4, Duffing", nonlinear("rk4"), single_by(rk4)),
        (Dispatch, "leapfrog, Duffing", nonlinear("leapfrog"), single_by(leapfrog)),
        (Dispatch, "moddg, Duffing", nonlinear("moddg"), single_by(moddg)),
    ];
    rows.into_iter()
        .map(|(subject, name, generic, by_hand)| Pair {
            subject,
            name: name.to_owned(),
            generic,
            by_hand,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_of_a_pair_end_in_the_same_state() {
        for pair in pairs() {
            let ends = [(pair.generic)().unwrap(), (pair.by_hand)().unwrap()];
            for (a, b) in ends[0].into_iter().zip(ends[1]) {
                assert!((a - b).abs() < 1e-9, "{}, {}: {ends:?}", pair.subject.name(), pair.name);
            }
        }
    }
}
