//! The cost of a step according to the registry, compared with counted evaluations, for every row.

use crate::bind::separable;
use crate::catalog::{As, oscillator};
use afterbay_core::{
    Coupling, Curvature, Dissipation, DissipationForm, Effort, Grid, InputError, Line, Separable,
    State, System,
};
use afterbay_methods::registry::{Cost, FIXED, Needs, Row, find};
use afterbay_systems::FputChain;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A system that counts the evaluations for each degree of freedom.
#[derive(Clone)]
struct Counted {
    system: FputChain<f64>,
    /// The number of evaluations of ∂H/∂q for one degree of freedom, of D, and of ∂H/∂q for all
    /// together.
    asked: Arc<[AtomicU64; 3]>,
}

impl Counted {
    fn new(n: usize, beta: f64) -> Self {
        Self { system: FputChain::new(n, beta, 0.1).unwrap(), asked: Arc::default() }
    }
    fn count(&self, what: usize, n: usize) {
        self.asked[what].fetch_add(n as u64, Relaxed);
    }
    /// Returns the counts since the last call.
    fn take(&self) -> [u64; 3] {
        [0, 1, 2].map(|what| self.asked[what].swap(0, Relaxed))
    }
}

impl System<f64> for Counted {
    fn dof(&self) -> usize {
        self.system.dof()
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        self.system.energy(q, p)
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        self.count(0, q.len());
        self.count(2, 1);
        self.system.gradient(q, p, hq, hp);
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        self.count(1, q.len());
        self.system.dissipation(q, p, v, d);
    }
    fn dissipation_form(&self) -> DissipationForm {
        System::<f64>::dissipation_form(&self.system)
    }
    fn coupling(&self) -> Coupling {
        System::<f64>::coupling(&self.system)
    }
}

impl Separable<f64> for Counted {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        self.count(0, 1);
        self.system.partial(q, j, at)
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        self.count(0, 1);
        self.system.divided_difference(q, j, to)
    }
    fn has_exact_divided_differences(&self) -> bool {
        Separable::<f64>::has_exact_divided_differences(&self.system)
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        self.count(1, 1);
        self.system.dissipation_of(q, p, j)
    }
}

impl Curvature<f64> for Counted {
    fn curvature(
        &self,
        q: &[f64],
        p: &[f64],
        put: impl FnMut(afterbay_core::Block, usize, usize, f64),
    ) {
        self.system.curvature(q, p, put);
    }
    fn is_linear(&self) -> bool {
        Curvature::<f64>::is_linear(&self.system)
    }
}

/// The evaluations per degree of freedom in each step, as counted and as reported by the method.
struct Asked {
    asked: Vec<[f64; 2]>,
    /// The number of evaluations for all degrees of freedom together.
    together: u64,
    effort: Effort,
    end: State<Vec<f64>>,
}

const STEPS: u32 = 40;

/// A run over the chain of n masses; `None` if the method does not apply.
fn ask(row: &Row, n: usize, beta: f64, h: f64) -> Option<Asked> {
    let system = Counted::new(n, beta);
    let run = match separable(row, system.clone()) {
        Ok(run) => run,
        Err(InputError::Unsupported { .. }) => return None,
        Err(error) => panic!("{}: {error}", row.name),
    };
    let wave = |a: f64| (0..n).map(|j| (a * (j + 1) as f64).cos()).collect();
    let mut state = State::new(wave(0.7), wave(1.9)).unwrap();
    let (mut asked, mut together) = (Vec::new(), 0);
    let grid = Grid::of(h, u64::from(STEPS)).unwrap();
    let effort = run.run(grid, &mut state, 1, &mut |step, _| {
        let [force, friction, all] = system.take();
        // Before the first step no result is available for reuse.
        if step > 0 {
            asked.push([force, friction].map(|count| count as f64 / n as f64));
            together += all;
        }
        ControlFlow::Continue(())
    });
    Some(Asked { asked, together, effort: effort.unwrap().effort, end: state })
}

impl Asked {
    /// Whether a condition on the evaluations of force and friction holds in every step.
    fn every(&self, so: impl Fn([f64; 2]) -> bool) -> bool {
        self.asked.iter().all(|&asked| so(asked))
    }

    /// The mean numbers of evaluations and iterations per step reported by the method.
    fn a_step(&self) -> [f64; 2] {
        let Effort { evaluations, iterations } = self.effort;
        [evaluations, iterations].map(|count| count as f64 / f64::from(STEPS))
    }
}

/// The runs of a row on the linear and on the nonlinear chain, with one mass if the method takes no
/// more.
fn chains(row: &Row, h: f64) -> [Option<Asked>; 2] {
    let n = if row.needs == Needs::OneDegree { 1 } else { 3 };
    [0.0, 1.0].map(|beta| ask(row, n, beta, h))
}

/// The distance between the ends of two runs over the linear chain.
fn apart(row: &Row) -> f64 {
    let [found, exact] =
        [row, find("linear-exact").unwrap()].map(|row| ask(row, 3, 0.0, 0.5).unwrap().end);
    let parts = found.q.iter().zip(&exact.q).chain(found.p.iter().zip(&exact.p));
    parts.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// Whether a step of the method has this cost.
fn costs(row: &Row, cost: Cost) -> bool {
    let runs: Vec<Asked> = chains(row, 0.1).into_iter().flatten().collect();
    match cost {
        // Methods with a tolerance are not tested here.
        Cost::Nodes | Cost::Stages => false,
        Cost::Explicit(evaluations) => {
            let each = f64::from(evaluations);
            // The first step may also evaluate at the initial state.
            let right = |run: &Asked| {
                let [first, others @ ..] = &run.asked[..] else { return false };
                let extra = first[0] - each;
                (extra == 0.0 || extra == 1.0)
                    && others.iter().all(|&asked| asked == [each; 2])
                    && run.a_step() == [each + extra / f64::from(STEPS), 0.0]
            };
            runs.len() == 2 && runs.iter().all(right)
        }
        Cost::Relaxed(evaluations) => {
            let [once, twice] =
                [evaluations, 2 * evaluations - 1].map(|count| [f64::from(count); 2]);
            let seen = |what: [f64; 2]| runs.iter().any(|run| run.asked.contains(&what));
            let right = |run: &Asked| {
                let sum: f64 = run.asked.iter().map(|[force, _]| force).sum();
                run.every(|asked| asked == once || asked == twice)
                    && (run.effort.evaluations as f64, run.effort.iterations) == (sum, 0)
            };
            runs.len() == 2 && seen(once) && seen(twice) && runs.iter().all(right)
        }
        Cost::Kicks(kicks) => {
            let kicks = f64::from(kicks);
            let right = |run: &Asked| {
                run.every(|asked| asked == [kicks + 1.0, kicks])
                    && run.a_step() == [kicks + 1.0, 0.0]
            };
            runs.len() == 2 && runs.iter().all(right)
        }
        Cost::Sweeps(sweeps) => {
            let sweeps = f64::from(sweeps);
            // Steps so short that every equation takes two evaluations.
            let right = |run: &Asked| {
                run.together == 0
                    && run.every(|[force, _]| force == 2.0 * sweeps)
                    && run.a_step() == [2.0 * sweeps; 2]
            };
            match closed(row) {
                Some(evaluations) if runs.is_empty() => evaluations == sweeps,
                _ => runs.len() == 2 && chains(row, 1e-9).iter().flatten().all(right),
            }
        }
        Cost::Modes(modes) => {
            let iterated = |run: &Asked| run.a_step()[1] > 1.0 && row.needs == Needs::Curvature;
            runs.len() == 2 && turns_like(row, modes) && runs.iter().all(iterated)
        }
        Cost::Paths => {
            let [linear, nonlinear] = &runs[..] else { return false };
            linear.a_step()[1] == 1.0 && nonlinear.a_step()[1] > 1.0 && apart(row) < 1e-12
        }
        Cost::Flow => {
            // The first step computes the tables.
            let right = |run: &Asked| {
                run.asked[1..].iter().all(|&asked| asked == [0.0; 2]) && run.a_step() == [1.0, 0.0]
            };
            !runs.is_empty() && runs.iter().all(right)
        }
    }
}

/// Whether a long step of the undamped oscillator is the (s, s) Padé approximant P(z)/P(-z) with
/// `P = Σ_k (2s-k)! s!/((2s)! k! (s-k)!) z^k`. This is so exactly if q' is a polynomial with s
/// coefficients.
fn turns_like(row: &Row, stages: u32) -> bool {
    let h = 8.0;
    let (mut term, mut even, mut odd) = (1.0, 1.0, 0.0);
    for k in 1..=stages {
        let [s, j] = [f64::from(stages), f64::from(k)];
        term *= (s - j + 1.0) / ((2.0 * s - j + 1.0) * j) * h;
        // The powers of i h.
        match k % 4 {
            0 => even += term,
            1 => odd += term,
            2 => even -= term,
            _ => odd -= term,
        }
    }
    let angle = 2.0 * f64::atan2(odd, even);
    let run = oscillator(1.0, 0.0).bind::<f64>(row, As::Linear);
    let mut state = State::new([1.0], [0.0]).unwrap();
    let Ok(Ok(_)) = run.map(|run| run.step(h, &mut state)) else { return false };
    (state.q[0] - angle.cos()).abs() < 1e-9 && (state.p[0] + angle.sin()).abs() < 1e-9
}

#[test]
fn a_step_costs_what_its_row_says_and_nothing_else() {
    let counts = || 1..=40_u32;
    let kinds = [Cost::Explicit, Cost::Relaxed, Cost::Kicks, Cost::Sweeps, Cost::Modes];
    let all: Vec<Cost> =
        kinds.iter().flat_map(|kind| counts().map(kind)).chain([Cost::Paths, Cost::Flow]).collect();
    for row in FIXED {
        let found: Vec<Cost> = all.iter().copied().filter(|&cost| costs(row, cost)).collect();
        println!("{:24} {found:?}", row.name);
        assert_eq!(found, [row.cost], "{}", row.name);
    }
}

/// The evaluations of a closed form on the damped oscillator; `None` if equations are solved.
fn closed(row: &Row) -> Option<f64> {
    let mut state = State::new([0.7], [0.4]).unwrap();
    let run = oscillator(1.0, 0.1).bind::<f64>(row, As::Linear).unwrap();
    let effort = run.step(0.1, &mut state).unwrap();
    (effort.iterations == 0).then_some(effort.evaluations as f64)
}
