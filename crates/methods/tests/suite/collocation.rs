//! Energy-preserving collocation: symmetry, K, passivity, stiff scenes, failures.

use crate::bind::{Curved, after};
use crate::catalog::{
    As, Built, chain, duffing, modified_van_der_pol, oscillator, pendulum, ring, van_der_pol,
};
use crate::many::{errors, exact_end};
use afterbay_core::{
    Block, Curvature, DissipationForm, Grid, Method, Passive, State, StepFailure, System,
};
use afterbay_methods::Collocation;
use afterbay_methods::registry::{Run, find};
use proptest::prelude::*;

/// The method in the form of the registry.
fn bound(stages: usize, system: &Built) -> Run<f64> {
    system.bind(find(&format!("collocation-{}", 2 * stages)).unwrap(), As::Curved).unwrap()
}

/// Checks that steps conserve K, are symmetric and, if `passive`, that no reservoir decreases.
fn checked(
    system: &Curved<f64>,
    stages: usize,
    h: f64,
    q: Vec<f64>,
    p: Vec<f64>,
) -> Result<(), TestCaseError> {
    let (method, mut state) = (Collocation::new(stages), State::new(q, p).unwrap());
    let mut workspace = method.workspace(system).unwrap();
    let passive = system.dissipation_form().passive;
    for _ in 0..3 {
        let before = state.clone();
        if let Err(failure) = method.step(system, h, &mut state, &mut workspace) {
            prop_assert_eq!(&before, &state, "{}", failure);
            prop_assert!(excused(system, method, h, &before), "h = {}: {}", h, failure);
            return Ok(());
        }
        let drift = drift(system, h, &before, &state);
        prop_assert!(drift < ROUNDINGS, "K drifts by {} roundings, {}", drift, workspace.defect());
        prop_assert!(!passive.violated(&before.w, &state.w), "{:?} {:?}", before.w, state.w);
        if h < 0.1 {
            // The reverse step uses the same nodes; otherwise the number of nodes, which depends on
            // the error of K, may differ between the two directions.
            let fixed = Collocation { stages, nodes: 64 };
            let mut back = before.clone();
            for h in [h, -h] {
                fixed.step(system, h, &mut back, &mut fixed.workspace(system).unwrap()).unwrap();
            }
            for (part, was) in [(&back.q, &before.q), (&back.p, &before.p), (&back.w, &before.w)] {
                let size = was
                    .iter()
                    .chain(&before.p)
                    .chain(&state.w)
                    .fold(1.0, |a: f64, b| a.max(b.abs()));
                for (a, b) in part.iter().zip(was) {
                    prop_assert!((a - b).abs() < 200.0 * f64::EPSILON * size, "{} is not {}", a, b);
                }
            }
        }
    }
    Ok(())
}

/// Whether the failure of a step is due to its length: short steps may not fail, and a shorter
/// step, as the failure advises, must succeed. After long steps under active friction it may have
/// to be much shorter: one ring then goes to infinity within 0.28 (by scipy), and steps of 0.12
/// have no solution.
fn excused(system: &Curved<f64>, method: Collocation, h: f64, before: &State<Vec<f64>>) -> bool {
    let step = |h: f64| {
        let mut state = before.clone();
        method.step(system, h, &mut state, &mut method.workspace(system).unwrap()).is_ok()
    };
    h > 0.1 && (1..=6).any(|halvings| step(h / f64::from(1 << halvings)))
}

/// The bound of every check of K, in unit roundoffs of the terms of [`drift`]. Rounding changes K
/// through z1 = z0 + h γ_0, one operation per variable; through γ_0, a sum of 16 products with a
/// table entry in two chains of 8, halved again by the pairs, so 5 roundings of a slope; through H
/// at either end, a chain of 4 operations; through Δw, 6 for D·v and its sum; and through w1, 1.
/// Each is a rounding of a different term of `drift`, and 16 is twice the longest of them, since q
/// and p both contribute.
const ROUNDINGS: f64 = 16.0;

/// |ΔK| over the rounding of its terms.
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
    (after.total(system) - before.total(system)).abs() / (f64::EPSILON / 2.0 * scale)
}

fn step() -> impl Strategy<Value = f64> {
    prop_oneof![(-5.0..-1.0_f64).prop_map(|x| 10f64.powf(x)), 0.1..2.0]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]
    #[test]
    fn books_of_one_degree(
        stages in 1..=8_usize, h in step(), c in -0.5..2.0, alpha in -3.0..3.0, beta in 0.0..3.0,
        z in [-2.0..2.0, -2.0..2.0],
    ) {
        checked(&*duffing(alpha, beta, c).curved(), stages, h, vec![z[0]], vec![z[1]])?;
        let system = modified_van_der_pol(c, alpha, beta).curved();
        checked(&*system, stages, h, vec![z[0]], vec![z[1]])?;
    }

    #[test]
    fn books_of_a_chain(
        stages in 1..=8_usize, h in step(), c in -0.5..2.0, beta in 0.0..2.0,
        z in prop::array::uniform6(-1.0..1.0),
    ) {
        checked(&*chain(3, beta, c).curved(), stages, h, z[..3].to_vec(), z[3..].to_vec())?;
        let ring = ring(3, c, beta).curved();
        checked(&*ring, stages, h, z[..3].to_vec(), z[3..].to_vec())?;
    }

    /// H is not a polynomial, so nodes are added until K is exact.
    #[test]
    fn books_of_a_double_pendulum(
        stages in 1..=8_usize, h in step(), c in 0.0..2.0, z in prop::array::uniform4(-1.5..1.5),
    ) {
        let system = pendulum([1.0, 0.8], [1.0, 0.7], 3.0, [c, 0.3]).curved();
        checked(&*system, stages, h, z[..2].to_vec(), z[2..].to_vec())?;
    }
}

/// A step so long that no quadrature resolves H along it, and twice the nodes do not reduce the
/// error: the error is not attributed to rounding.
#[test]
fn what_is_not_resolved_is_not_taken() {
    let system = pendulum([1.0, 0.8], [1.0, 0.7], 3.0, [1.675_129_059_908_43, 0.3]).curved();
    let q = vec![-0.988_421_713_161_297_9, 0.907_523_940_106_871_1];
    let p = vec![0.068_482_842_986_598, 0.443_513_451_821_390_74];
    checked(&*system, 1, 0.848_085_938_350_559_2, q, p).unwrap();
}

/// Over 1e5 steps the change of K grows like a sum of rounding errors, not like t: less than 1e-18
/// of its terms per step, ten times less than one rounding, at the end and in the middle.
#[test]
fn k_does_not_drift() {
    let system = duffing(-1.0, 1.0, 0.0);
    for stages in [1, 2, 4, 8] {
        let run = bound(stages, &system);
        for h in [0.05, 0.3] {
            let mut state = State::new(vec![1.5], vec![0.5]).unwrap();
            let start = state.total(&*system);
            for _ in 0..2 {
                state = after(&run, Grid { h, steps: 50_000 }, &state);
                // p²/2 + q²/2 + q⁴/4 at most.
                let drift = (state.total(&*system) - start).abs() / 2.6;
                assert!(drift < 1e5 * 1e-18, "{stages} {h}: {drift:e}");
            }
        }
    }
}

/// q, p and w agree with another method in another scalar: a Taylor series.
#[test]
fn the_solution_is_the_solution() {
    let duffing = duffing(-1.0, 1.0, 0.1);
    let start = State::new(vec![1.5], vec![0.5]).unwrap();
    let exact = exact_end(&*duffing.series(), &start, 10.0);
    let state = after(&bound(8, &duffing), Grid { h: 0.5, steps: 20 }, &start);
    assert!(errors(&state, &exact).iter().all(|&error| error < 1e-13), "{state:?} {exact:?}");
}

/// A step of a linear system multiplies the state by the (s, s) Padé approximant of the
/// exponential.
#[test]
fn linear_decays() {
    let (k, b, h) = (1.0, 200.0, 0.1);
    let system = oscillator(k, b);
    let mut state = State::new([1.0], [1.0]).unwrap();
    let run = bound(1, &system);
    for _ in 0..3 {
        // The midpoint rule: (1 - hA/2) z1 = (1 + hA/2) z0.
        let (q, p) = (state.q[0], state.p[0]);
        let (c, right) = (h / 2.0, [q + h / 2.0 * p, p - h / 2.0 * (k * q + b * p)]);
        let determinant = 1.0 + c * b + c * c * k;
        let exact = [
            ((1.0 + c * b) * right[0] + c * right[1]) / determinant,
            (right[1] - c * k * right[0]) / determinant,
        ];
        run.step(h, &mut state).unwrap();
        assert!(
            (state.q[0] - exact[0]).abs() < 1e-14 && (state.p[0] - exact[1]).abs() < 1e-14,
            "{state:?} {exact:?}"
        );
    }
    // With more stages the step is the exponential itself, as far as it is resolved: the rates are
    // -199.995 and -0.005.
    let (mut state, mut exact) =
        (State::new(vec![1.0], vec![-b]).unwrap(), State::new(vec![1.0], vec![-b]).unwrap());
    bound(8, &system).step(0.01, &mut state).unwrap();
    system.abilities::<f64>().exact_flow().unwrap().carry(0.01, &mut exact);
    let off = errors(&state, &exact);
    assert!(off.iter().all(|&off| off < 1e-12 * exact.w[0]), "{state:?} {exact:?}");
}

#[test]
fn stiff_steps_are_solved() {
    let system = van_der_pol(1000.0);
    for stages in 1..=8 {
        let run = bound(stages, &system);
        for (q, h, steps) in [(2.0, 1e-4, 2000), (1.5, 1e-3, 1000), (2.0, 1e-2, 1000)] {
            let start = State::new(vec![q], vec![0.0]).unwrap();
            let state = after(&run, Grid { h, steps }, &start);
            assert!((state.total(&*system) - start.total(&*system)).abs() < 1e-14, "{stages} {h}");
            // On the slow branch, p = -q / (μ (q² - 1)) to O(μ⁻³).
            let [q, p] = [state.q[0], state.p[0]];
            assert!((p + q / (1000.0 * (q * q - 1.0))).abs() < 1e-6, "{stages} {h}: {state:?}");
        }
    }
}

/// All steps but the first start from the polynomial of the step before. The solution does not
/// depend on it.
#[test]
fn history_does_not_matter() {
    let system = &*chain(3, 0.5, 0.2).curved();
    for stages in 1..=8 {
        let method = Collocation::new(stages);
        let mut kept = State::new(vec![0.5, -0.3, 0.8], vec![0.2, 0.7, -0.4]).unwrap();
        let mut fresh = kept.clone();
        let mut workspace = method.workspace(system).unwrap();
        for _ in 0..20 {
            method.step(system, 0.2, &mut kept, &mut workspace).unwrap();
            method.step(system, 0.2, &mut fresh, &mut method.workspace(system).unwrap()).unwrap();
        }
        assert!(
            errors(&kept, &fresh).into_iter().all(|error| error < 2e-14),
            "{stages}: {kept:?} {fresh:?}"
        );
    }
}

/// H = p²/2, and D = -1/(1 - q): the force is NaN beyond q = 1.
struct Cliff;

impl System<f64> for Cliff {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = (if q[0] > 1.0 { f64::NAN } else { 0.0 }, p[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = 0.1 * v[0];
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
    }
}

impl Curvature<f64> for Cliff {
    fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        put(Block::Hpp, 0, 0, 1.0);
        put(Block::Dp, 0, 0, 0.1);
    }
}

#[test]
fn failures_have_names_and_leave_the_state() {
    let (method, cliff): (_, &Curved<f64>) = (Collocation::new(4), &Cliff);
    let mut state = State::new(vec![0.5], vec![1.0]).unwrap();
    let before = state.clone();
    let mut workspace = method.workspace(cliff).unwrap();
    method.step(cliff, 0.1, &mut state, &mut workspace).unwrap();
    assert_ne!(state, before);
    let before = state.clone();
    let failure = method.step(cliff, 2.0, &mut state, &mut workspace).unwrap_err();
    let named = matches!(
        failure,
        StepFailure::NewtonStalled { dof: 0, .. } | StepFailure::NonFinite { dof: 0, .. }
    );
    assert!(named, "{failure}");
    assert_eq!(state, before);
}

#[test]
fn stages_and_nodes_have_their_range() {
    for (stages, nodes) in [(0, 8), (9, 32), (4, 7), (2, 65)] {
        let method = Collocation { stages, nodes };
        assert!(Method::<Vec<f64>, Curved<f64>>::workspace(&method, &Cliff).is_err(), "{method:?}");
    }
}

/// H = q²⁰ + p²/2 needs k = 10 s nodes; with 8, the error of K would exceed rounding by far.
#[test]
fn nodes_are_added_where_k_needs_them() {
    struct Steep;
    impl System<f64> for Steep {
        fn dof(&self) -> usize {
            1
        }
        fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
            q[0].powi(20) + p[0] * p[0] / 2.0
        }
        fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
            (hq[0], hp[0]) = (20.0 * q[0].powi(19), p[0]);
        }
        fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
            d.fill(0.0);
        }
        fn dissipation_form(&self) -> DissipationForm {
            DissipationForm::NONE
        }
    }
    impl Curvature<f64> for Steep {
        fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
            put(Block::Hqq, 0, 0, 380.0 * q[0].powi(18));
            put(Block::Hpp, 0, 0, 1.0);
        }
    }
    let steep: &Curved<f64> = &Steep;
    for stages in [2, 3] {
        let (method, mut state) =
            (Collocation::new(stages), State::new(vec![0.9], vec![1.5]).unwrap());
        let mut workspace = method.workspace(steep).unwrap();
        let before = state.total(steep);
        let effort = method.step(steep, 0.2, &mut state, &mut workspace).unwrap();
        let drift = (state.total(steep) - before).abs();
        println!("{effort:?} {drift:e} {}", workspace.defect());
        assert!(drift < 1e-15 && workspace.defect() < 16.0, "{drift:e}");
        assert!(effort.evaluations > 8 * effort.iterations, "{effort:?}");
    }
}
