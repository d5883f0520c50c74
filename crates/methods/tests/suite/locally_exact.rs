//! The locally exact discrete gradient: order 2 in q, p and w, exact where the system is linear, K,
//! passivity, symmetry, failures.

use crate::bind::{Curved, curved};
use crate::catalog::{
    As, Both, Built, chain, duffing, oscillator, pendulum, ring, van_der_pol, written_general,
};
use crate::many::orders::check_orders;
use crate::many::{InSeries, errors, exact_end, reference, start};
use crate::systems::{self, Springs, Twisted};
use afterbay_core::{
    Block, Coupling, Curvature, DissipationForm, Method, Passive, Quad, State, StepFailure, System,
};
use afterbay_methods::LocallyExact;
use afterbay_methods::registry::{Run, find};
use afterbay_systems::catalog::Expandable;
use afterbay_systems::{DampedDoublePendulum, DissipationText, GeneralDescription};
use allocation_counter::measure;
use proptest::prelude::*;

const THREE: [&[f64]; 2] = [&[0.5, -0.3, 0.8], &[0.2, 0.7, -0.4]];
const TWO: [&[f64]; 2] = [&[0.6, -0.4], &[0.3, 0.5]];

fn swing(c: f64) -> Built {
    pendulum([1.0, 0.75], [1.0, 0.5], 3.0, [c, 0.25])
}

fn orders<T: Both + Expandable>(counts: [u64; 4], tolerance: f64) {
    let row = find("locally-exact").unwrap();
    let check = |name: &str, run: &Run<T>, series: &InSeries<T>, from: [&[f64]; 2]| {
        check_orders(name, (run, series), from, (2.0, counts), (2.0, tolerance));
    };
    for (name, system, from) in [
        ("chain", chain(3, 0.5, 0.25), THREE),
        ("ring", ring(3, 0.75, 0.5), THREE),
        ("pendulum", swing(0.125), TWO),
    ] {
        check(name, &system.bind(row, As::Curved).unwrap(), &*system.series(), from);
    }
    // Friction that couples velocities, with H not separable.
    let twisted = Twisted { c: 0.25, offset: 0.0 };
    check("twisted", &curved(row, twisted).unwrap(), &twisted, TWO);
    let four: [&[f64]; 2] = [&[0.5, -0.3, 0.8, 0.1], &[0.2, 0.7, -0.4, 0.9]];
    for springs in [Springs::dense(4, 0.2), Springs::ring(4, 0.2)] {
        check("springs", &curved(row, springs.clone()).unwrap(), &springs, four);
    }
}

#[test]
fn order_two_on_many_degrees() {
    orders::<f64>([100, 140, 200, 280], 0.1);
}

#[test]
fn order_two_in_31_digits() {
    orders::<Quad>([140, 180, 230, 300], 0.05);
}

/// Compares many steps of a linear system, each up to the period, with the Taylor series.
fn exact<T: Both + Expandable>(system: &Built, h: f64) {
    let n = system.dof();
    let q: Vec<f64> = (0..n).map(|j| (0.9 * j as f64 + 0.3).sin()).collect();
    let from: [&[f64]; 2] = [&q, &q];
    let exact = reference(&*system.series(), from, T::from_f64(h), 10);
    let run = system.bind::<T>(find("locally-exact").unwrap(), As::Curved).unwrap();
    let mut state = start::<T>(from);
    for exact in &exact[1..] {
        let effort = run.step(T::from_f64(h), &mut state).unwrap();
        let found = errors(&state, exact);
        assert!(
            found.iter().all(|&error| error < 400.0 * (1.0 + h) * T::EPSILON),
            "{h} {n}: {found:?}"
        );
        assert_eq!(effort.iterations, 1);
    }
}

#[test]
fn exact_on_linear_systems() {
    // h = π is a pole of tanh: the oscillator turns by half a period.
    for h in [0.01, 0.7, std::f64::consts::PI, 9.0] {
        for n in [1, 3, 20] {
            exact::<f64>(&chain(n, 0.0, 0.25), h);
        }
        exact::<Quad>(&chain(3, 0.0, 0.25), h);
        exact::<f64>(&oscillator(1.0, 0.0), h);
    }
    // A magnetic field, with friction that depends on v, not on p.
    let magnetic = written_general(&GeneralDescription {
        hamiltonian: "((p1 + q2/2)^2 + (p2 - q1/2)^2)/2 + (q1^2 + q2^2)/2".into(),
        dissipation: DissipationText::Forces(vec!["0.3*v1".into(), "0.3*v2".into()]),
        ..GeneralDescription::default()
    });
    for h in [0.01, 0.7, 3.0] {
        exact::<f64>(&magnetic, h);
    }
    // Overdamped: the midpoint rule reverses the sign of the fast component, while this method
    // damps it.
    exact::<f64>(&oscillator(1.0, 200.0), 0.1);
}

/// |ΔK| in roundings of its terms along the step.
fn drift(system: &Curved<f64>, h: f64, before: &State<Vec<f64>>, after: &State<Vec<f64>>) -> f64 {
    let total = |x: &[f64]| x.iter().map(|x| x.abs()).sum::<f64>();
    let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut scale = 0.0;
    for state in [before, after] {
        let n = state.dof();
        let (mut hq, mut hp, mut d) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        system.gradient(&state.q, &state.p, &mut hq, &mut hp);
        system.dissipation(&state.q, &state.p, &hp, &mut d);
        let mut bend = 0.0_f64;
        system.curvature(&state.q, &state.p, |_, _, _, value| bend = bend.max(value.abs()));
        let z = largest(&state.q).max(largest(&state.p));
        let slopes = total(&hq) + total(&hp) + total(&d);
        scale += state.energy(system).abs() + total(&state.w) + (1.0 + h * bend) * z * slopes;
    }
    (after.total(system) - before.total(system)).abs()
        / (f64::EPSILON / 2.0 * scale + f64::MIN_POSITIVE)
}

fn checked(system: &Curved<f64>, h: f64, q: &[f64], p: &[f64]) -> Result<(), TestCaseError> {
    let mut state = State::new(q.to_vec(), p.to_vec()).unwrap();
    let mut workspace = LocallyExact.workspace(system).unwrap();
    for _ in 0..3 {
        let before = state.clone();
        if let Err(failure) = LocallyExact.step(system, h, &mut state, &mut workspace) {
            prop_assert_eq!(&before, &state, "{}", failure);
            // Short steps may not fail. If a longer step fails, a shorter one must succeed.
            let shorter = |h: f64| {
                let mut state = before.clone();
                LocallyExact
                    .step(system, h, &mut state, &mut LocallyExact.workspace(system).unwrap())
                    .is_ok()
            };
            let excused = h > 0.1 && (1..=4).any(|halvings| shorter(h / f64::from(1 << halvings)));
            prop_assert!(excused, "h = {}: {}", h, failure);
            return Ok(());
        }
        let off = drift(system, h, &before, &state);
        prop_assert!(off < 32.0, "K drifts by {} roundings", off);
        let violated = system.dissipation_form().passive.violated(&before.w, &state.w);
        prop_assert!(!violated, "a reservoir gives back: {:?} {:?}", before.w, state.w);
        if h < 0.1 {
            let mut back = state.clone();
            LocallyExact
                .step(system, -h, &mut back, &mut LocallyExact.workspace(system).unwrap())
                .unwrap();
            let size = before
                .q
                .iter()
                .chain(&before.p)
                .chain(&state.w)
                .fold(1.0, |a: f64, b| a.max(b.abs()));
            let off = errors(&back, &before);
            prop_assert!(
                off.iter().all(|&off| off < 400.0 * f64::EPSILON * size),
                "not symmetric: {:?}",
                off
            );
        }
    }
    Ok(())
}

fn step() -> impl Strategy<Value = f64> {
    prop_oneof![(-5.0..-1.0_f64).prop_map(|x| 10f64.powf(x)), 0.1..2.0]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn books_of_one_degree(
        h in step(), c in -0.5..2.0, alpha in -3.0..3.0, beta in 0.0..3.0,
        z in [-2.0..2.0, -2.0..2.0],
    ) {
        checked(&*duffing(alpha, beta, c).curved(), h, &z[..1], &z[1..])?;
        checked(&*van_der_pol(c).curved(), h, &z[..1], &z[1..])?;
        checked(&Wind { c }, h, &z[..1], &z[1..])?;
    }

    #[test]
    fn books_of_many(
        h in step(), c in -0.5..2.0, beta in 0.0..2.0, z in prop::array::uniform6(-1.0..1.0),
    ) {
        checked(&*chain(3, beta, c).curved(), h, &z[..3], &z[3..])?;
        checked(&*ring(3, c, beta).curved(), h, &z[..3], &z[3..])?;
        checked(&Twisted { c: c.abs(), offset: 0.0 }, h, &z[..2], &z[2..4])?;
        checked(&*swing(c.abs()).curved(), h, &z[..2], &z[2..4])?;
    }
}

/// The Duffing oscillator with D = c |v| v, a friction that is not linear in the velocity.
struct Wind {
    c: f64,
}

impl System<f64> for Wind {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + q[0] * q[0] / 2.0 + q[0].powi(4) / 4.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (q[0] + q[0].powi(3), p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = self.c * v[0].abs() * v[0];
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::each_if(self.c >= 0.0), ..DissipationForm::GENERAL }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl Curvature<f64> for Wind {
    fn curvature(&self, q: &[f64], p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hqq, 0, 0, 1.0 + 3.0 * q[0] * q[0]);
        put(Block::Hpp, 0, 0, 1.0);
        put(Block::Dp, 0, 0, 2.0 * self.c * p[0].abs());
    }
}

/// If H is nearly quadratic, only the nonlinear part contributes to the error.
#[test]
fn weak_nonlinearity_costs_little() {
    let error = |beta: f64| {
        let system = chain(3, beta, 0.25);
        let exact = exact_end(&*system.series(), &start(THREE), 0.25);
        ["locally-exact", "gonzalez"].map(|name| {
            let mut state = start::<f64>(THREE);
            system.bind(find(name).unwrap(), As::Curved).unwrap().step(0.25, &mut state).unwrap();
            errors(&state, &exact)
        })
    };
    let [ours, theirs] = error(1e-4);
    println!("beta = 1e-4: {ours:?} against {theirs:?} of the midpoint discrete gradient");
    assert!((0..3).all(|i| ours[i] < 1e-2 * theirs[i]));
}

#[test]
fn failures_have_names_and_leave_the_state() {
    let fails = |system: &Curved<f64>, h: f64| {
        let before = State::new(vec![2.0], vec![1.0]).unwrap();
        let (mut state, mut workspace) = (before.clone(), LocallyExact.workspace(system).unwrap());
        let failure = LocallyExact.step(system, h, &mut state, &mut workspace).unwrap_err();
        assert_eq!(state, before);
        failure
    };
    let failure = fails(&*duffing(-1.0, -5.0, 0.1).curved(), 5.0);
    println!("{failure}");
    assert!(
        matches!(failure, StepFailure::NotContracting { dof: 0, .. } | StepFailure::TooLong { .. }),
        "{failure}"
    );
    let failure = fails(&*oscillator(1.0, 1e4).curved(), 1.0);
    assert!(matches!(failure, StepFailure::TooLong { .. }), "{failure}");
}

/// Nor does the erasure of the type of the system.
#[test]
fn steps_allocate_nothing_and_storage_does_not_matter() {
    let system = DampedDoublePendulum::new([1.0, 0.75], [1.0, 0.5], 3.0, [0.125, 0.25]).unwrap();
    let mut stack = State::new([0.6, -0.4], [0.3, 0.5]).unwrap();
    let mut on_stack = LocallyExact.workspace(&system).unwrap();
    let (q, p) = systems::start::<f64>(40);
    let (twisted, springs) = (Twisted { c: 0.2, offset: 0.0 }, Springs::chain(40, 0.1));
    let erased: [(&Curved<f64>, _); 3] = [
        (&system, start::<f64>(TWO)),
        (&twisted, start(TWO)),
        (&springs, State::new(q, p).unwrap()),
    ];
    let mut on_heap =
        erased.map(|(system, state)| (system, state, LocallyExact.workspace(system).unwrap()));
    let allocated = measure(|| {
        for _ in 0..50 {
            LocallyExact.step(&system, 0.05, &mut stack, &mut on_stack).unwrap();
            for (system, state, workspace) in &mut on_heap {
                LocallyExact.step(*system, 0.05, state, workspace).unwrap();
            }
        }
    });
    let [(_, heap, _), ..] = on_heap;
    assert_eq!(allocated.count_total, 0);
    assert_eq!((stack.q.to_vec(), stack.p.to_vec(), stack.w.to_vec()), (heap.q, heap.p, heap.w));
}
