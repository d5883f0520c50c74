//! The exact flow of linear systems, by tables and by series, with 1 to 40 degrees of freedom.

use crate::bind::Curved;
use crate::catalog::{As, Both, Built, chain, duffing, oscillator, ring};
use crate::many::{InSeries, errors, reference, start};
use afterbay_core::{
    Block, Curvature, DissipationForm, Grid, InputError, Method, Passive, Quad, Scalar, State,
    StateRef, StepFailure, System,
};
use afterbay_methods::LinearExact;
use afterbay_methods::registry::{FIXED, Run};
use afterbay_systems::FputChain;
use afterbay_systems::catalog::Expandable;
use allocation_counter::measure;
use proptest::prelude::*;
use std::ops::ControlFlow;

/// H = Σ [p_j²/2 + (1 + j/4) q_j²/2 + f q_j] + Σ [(q_{j+1} - q_j)²/2 + q_j p_{j+1}/4], D_j = c v_j
/// + (v_{j+1} + v_{j-1}) c/4: not separable, friction that couples velocities, a constant force.
#[derive(Clone, Copy)]
struct Web {
    n: usize,
    f: f64,
    c: f64,
}

impl<T: Scalar> System<T> for Web {
    fn dof(&self) -> usize {
        self.n
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let x = T::from_f64;
        let own = |j: usize| {
            (p[j] * p[j] + x(1.0 + j as f64 / 4.0) * q[j] * q[j]).half() + x(self.f) * q[j]
        };
        let bodies = (0..self.n).fold(T::zero(), |sum, j| sum + own(j));
        (1..self.n).fold(bodies, |sum, j| {
            let r = q[j] - q[j - 1];
            sum + (r * r).half() + q[j - 1] * p[j] * x(0.25)
        })
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let x = T::from_f64;
        for j in 0..self.n {
            (hq[j], hp[j]) = (x(1.0 + j as f64 / 4.0) * q[j] + x(self.f), p[j]);
        }
        for j in 1..self.n {
            let r = q[j] - q[j - 1];
            hq[j] += r;
            hq[j - 1] += p[j] * x(0.25) - r;
            hp[j] += q[j - 1] * x(0.25);
        }
    }
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        let c = T::from_f64(self.c);
        for j in 0..self.n {
            d[j] = c * v[j];
            if j > 0 {
                d[j] += c * v[j - 1] * T::from_f64(0.25);
            }
            if j + 1 < self.n {
                d[j] += c * v[j + 1] * T::from_f64(0.25);
            }
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::InSum, coupled: true, ..DissipationForm::GENERAL }
    }
}

impl<T: Scalar> Curvature<T> for Web {
    fn curvature(&self, _q: &[T], _p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let x = T::from_f64;
        for j in 0..self.n {
            let bonds = usize::from(j > 0) + usize::from(j + 1 < self.n);
            put(Block::Hqq, j, j, x(1.0 + j as f64 / 4.0 + bonds as f64));
            put(Block::Hpp, j, j, T::one());
            if j > 0 {
                put(Block::Hqq, j, j - 1, -T::one());
                put(Block::Hqq, j - 1, j, -T::one());
                put(Block::Hqp, j - 1, j, x(0.25));
            }
            // D is not evaluated.
        }
    }
    fn is_linear(&self) -> bool {
        true
    }
}

fn from(n: usize) -> [Vec<f64>; 2] {
    [
        (0..n).map(|j| (0.9 * j as f64 + 0.3).sin()).collect(),
        (0..n).map(|j| (1.7 * j as f64 + 1.1).cos()).collect(),
    ]
}

/// Takes one step with a new workspace.
fn step(system: &Curved<f64>, h: f64, state: &mut State<Vec<f64>>) -> Result<(), StepFailure> {
    LinearExact.step(system, h, state, &mut LinearExact.workspace(system).unwrap()).map(drop)
}

/// Compares one step to h, and steps of h/8, with the Taylor series.
fn exact<T: Scalar>(name: &str, system: &Curved<T>, series: &InSeries<T>, h: f64) {
    let [q, p] = from(system.dof());
    let exact = reference(series, [&q, &p], T::from_f64(h), 1).pop().unwrap();
    let mut workspace = LinearExact.workspace(system).unwrap();
    for (parts, allowed) in [(1, 40.0), (8, 80.0)] {
        let mut state = start::<T>([&q, &p]);
        for _ in 0..parts {
            LinearExact
                .step(system, T::from_f64(h / f64::from(parts)), &mut state, &mut workspace)
                .unwrap();
        }
        let found = errors(&state, &exact);
        println!("{name} h = {h}, {parts} steps: {found:?}");
        let allowed = allowed
            * (1.0 + h * 4.0)
            * T::EPSILON
            * (1.0 + exact.w.iter().fold(0.0, |a: f64, w| a.max(w.to_f64().abs())));
        assert!(found.iter().all(|&error| error < allowed), "{name} {h} {parts}: {found:?}");
    }
}

fn everywhere<T: Both + Expandable>(sizes: &[usize]) {
    for h in [1e-3, 0.5, 20.0] {
        for &n in sizes {
            let chain = chain(n, 0.0, 0.25);
            exact::<T>(&format!("chain {n}"), &*chain.curved(), &*chain.series(), h);
        }
        let ring = ring(5, 0.0, 0.5);
        exact::<T>("ring", &*ring.curved(), &*ring.series(), h);
        for n in [1, 3] {
            for f in [0.0, 0.75] {
                let web = Web { n, f, c: 0.5 };
                exact::<T>(&format!("web {n}"), &web, &web, h);
            }
        }
    }
}

#[test]
fn one_step_or_many_are_the_exact_flow() {
    everywhere::<f64>(&[1, 3, 13, 40]);
}

#[test]
fn one_step_or_many_are_the_exact_flow_in_31_digits() {
    everywhere::<Quad>(&[1, 3]);
}

/// The Taylor series, with friction that couples velocities and a constant force.
#[test]
fn what_is_too_large_for_tables_is_exact_too() {
    let web = Web { n: 14, f: 0.75, c: 0.5 };
    exact::<f64>("web 14", &web, &web, 3.0);
    exact::<Quad>("web 14", &web, &web, 0.5);
}

#[test]
fn a_hundred_times_units_in_one_step() {
    let ends = |system: Built, h: f64, q: f64, p: f64| {
        let mut state = State::new(vec![q], vec![p]).unwrap();
        let mut exact = state.clone();
        step(&*system.curved(), h, &mut state).unwrap();
        system.abilities::<f64>().exact_flow().unwrap().carry(h, &mut exact);
        println!("{state:?} {exact:?}");
        [(state.q, exact.q), (state.p, exact.p), (state.w, exact.w)].map(|(a, b)| [a[0], b[0]])
    };
    for [a, b] in ends(oscillator(1.0, 0.1), 100.0, 2.3, -3.1) {
        assert!((a - b).abs() < 1e-13, "{a:?} {b:?}");
    }
    // Fast and slow motion, in very different units.
    for [a, b] in ends(oscillator(1e6, 2e5), 0.1, 1.0, 1.0) {
        assert!((a - b).abs() < 1e-10 * b.abs(), "{a:?} {b:?}");
    }
}

/// Checks that K changes by no more than 16 (1 + h |A|) roundings of its terms, and that no
/// reservoir of a passive system decreases.
fn checked(
    system: &Curved<f64>,
    rate: f64,
    h: f64,
    q: &[f64],
    p: &[f64],
) -> Result<(), TestCaseError> {
    let mut state = State::new(q.to_vec(), p.to_vec()).unwrap();
    let mut workspace = LinearExact.workspace(system).unwrap();
    let scale = |state: &State<Vec<f64>>| {
        let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        rate * rate * squares(&state.q)
            + squares(&state.p)
            + state.w.iter().map(|w| w.abs()).sum::<f64>()
    };
    for _ in 0..5 {
        let before = state.clone();
        LinearExact.step(system, h, &mut state, &mut workspace).unwrap();
        let size = f64::EPSILON / 2.0 * (scale(&before) + scale(&state));
        let off = (state.total(system) - before.total(system)).abs() / (size + f64::MIN_POSITIVE);
        prop_assert!(off < 16.0 * (1.0 + h * rate), "K is off by {} roundings", off);
        prop_assert!(!system.dissipation_form().passive.violated(&before.w, &state.w));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn k_and_w_are_right(
        h in (-6.0..2.0_f64).prop_map(|x| 10f64.powf(x)),
        k in (-2.0..2.0_f64).prop_map(|x| 10f64.powf(x)),
        c in -0.05..3.0_f64, z in prop::array::uniform6(-2.0..2.0),
    ) {
        // For active systems the step is limited, since overflow leaves no K to check.
        let h = if c < 0.0 { h.min(10.0) } else { h };
        checked(&*oscillator(k, c).curved(), k.sqrt().max(1.0) + c.abs(), h, &z[..1], &z[3..4])?;
        checked(&*chain(3, 0.0, c).curved(), 2.0 + c.abs(), h, &z[..3], &z[3..])?;
    }
}

/// K of the damped oscillator over a million steps changes by less than h |A| roundings per step.
#[test]
fn k_does_not_run_away() {
    let system = &*oscillator(1.0, 0.0).curved::<f64>();
    let mut state = State::new(vec![1.0], vec![0.5]).unwrap();
    let mut workspace = LinearExact.workspace(system).unwrap();
    let before = state.total(system);
    for _ in 0..1_000_000 {
        LinearExact.step(system, 0.01, &mut state, &mut workspace).unwrap();
    }
    let drift = (state.total(system) - before).abs() / before;
    println!("K moves by {drift:e} in 1e6 steps of 0.01");
    assert!(drift < 1e4 * f64::EPSILON, "{drift:e}");
}

/// The table of one run may or may not be reused by the next. The results are the same to the bit.
#[test]
fn runs_of_a_bound_method_do_not_feel_each_other() {
    for row in FIXED {
        let bind = || oscillator(1.0, 0.3).bind(row, As::Linear).unwrap();
        let end = |run: &Run<f64>, h: f64, within: bool| {
            let mut state = State::new([1.0], [0.5]).unwrap();
            let grid = Grid::new(h, 3.0).unwrap();
            let mut look = |_: u64, _: StateRef<'_, f64>| {
                if within {
                    let mut other = State::new([0.2], [-0.5]).unwrap();
                    run.run(grid, &mut other, u64::MAX, &mut |_, _| ControlFlow::Continue(()))
                        .unwrap();
                }
                ControlFlow::Continue(())
            };
            run.run(grid, &mut state, 1, &mut look).unwrap();
            run.step(h, &mut state).unwrap();
            state
        };
        let bound = bind();
        for (h, within) in
            [(0.1, false), (0.1, false), (0.3, false), (0.3, true), (0.1, true), (0.1, false)]
        {
            assert_eq!(end(&bound, h, within), end(&bind(), h, false), "{} {h}", row.name);
        }
    }
}

#[test]
fn what_is_not_linear_is_refused() {
    let workspace = |beta: f64| {
        Method::<Vec<f64>, _>::workspace(&LinearExact, &*duffing(1.0, beta, 0.1).curved::<f64>())
            .map(drop)
    };
    let error = workspace(0.5).unwrap_err();
    assert!(matches!(error, InputError::Unsupported { method: "linear-exact", .. }), "{error}");
    assert_eq!(workspace(0.0), Ok(()));
}

#[test]
fn steps_that_are_too_long_fail_by_name() {
    let chain = chain(20, 0.0, 0.1).curved();
    let [q, p] = from(20);
    let mut state = start::<f64>([&q, &p]);
    let before = state.clone();
    let failure = step(&*chain, 1e5, &mut state).unwrap_err();
    assert!(matches!(failure, StepFailure::TooLong { .. }), "{failure}");
    assert_eq!(state, before);
    // A solution that overflows.
    let active = oscillator(1.0, -1.0).curved();
    let mut state = State::new(vec![1.0], vec![0.5]).unwrap();
    let before = state.clone();
    let failure = step(&*active, 1e4, &mut state).unwrap_err();
    assert!(matches!(failure, StepFailure::NonFinite { .. }), "{failure}");
    assert_eq!(state, before);
}

/// Nor does the erasure of the type of the system.
#[test]
fn steps_allocate_nothing_and_storage_does_not_matter() {
    for n in [1, 3, 20] {
        let chain = &*chain(n, 0.0, 0.1).curved::<f64>();
        let [q, p] = from(n);
        let mut state = start::<f64>([&q, &p]);
        let mut workspace = LinearExact.workspace(chain).unwrap();
        let allocated = measure(|| {
            for h in [0.1, 0.1, 3.0] {
                LinearExact.step(chain, h, &mut state, &mut workspace).unwrap();
            }
        });
        assert_eq!(allocated.count_total, 0);
    }
    let chain = FputChain::new(3, 0.0, 0.1).unwrap();
    let mut stack = State::new([0.5, -0.3, 0.8], [0.2, 0.7, -0.4]).unwrap();
    let mut heap = State::new(stack.q.to_vec(), stack.p.to_vec()).unwrap();
    LinearExact.step(&chain, 0.3, &mut stack, &mut LinearExact.workspace(&chain).unwrap()).unwrap();
    step(&chain, 0.3, &mut heap).unwrap();
    assert_eq!((stack.q.to_vec(), stack.p.to_vec(), stack.w.to_vec()), (heap.q, heap.p, heap.w));
}
