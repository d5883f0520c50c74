//! Every fixed-step method for one degree of freedom that claims to conserve K = H + w does so to
//! rounding, for all states, systems and steps; and under methods that claim passivity the
//! reservoir of a passive system never decreases. `k_on_expressions` has the other methods.

use crate::one_step::*;
use afterbay_core::{Dissipation, Method, Quad, Scalar, Separable, State, StepFailure, System};
use afterbay_methods::ModDg;
use afterbay_methods::registry::{FIXED, Row, find};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// Systems that only lose energy.
fn passive() -> BoxedStrategy<Model> {
    let passive = |model| match model {
        Model::DampedOscillator { k, b } => Model::DampedOscillator { k, b: b.abs() },
        Model::Duffing { alpha, beta, c } => Model::Duffing { alpha, beta, c: c.abs() },
        active => active,
    };
    prop_oneof![damped_oscillator(), duffing()].prop_map(passive).boxed()
}

/// The passive systems with a single well.
fn passive_well() -> BoxedStrategy<Model> {
    let single = |model| match model {
        Model::Duffing { alpha, beta, c } => {
            Model::Duffing { alpha: alpha.abs(), beta: beta.abs(), c }
        }
        other => other,
    };
    passive().prop_map(single).boxed()
}

/// Whether this failure is legitimate for the method: a singular equation for the plain closed
/// form, a missing solution for iterations, a pole for δ, and overflow for all.
fn makes_sense(row: &Row, closed: bool, failure: &StepFailure) -> bool {
    match failure {
        StepFailure::NonFinite { .. } => true,
        StepFailure::Pole { .. } => !row.poles().is_empty(),
        StepFailure::Singular { .. } => closed,
        StepFailure::NotContracting { .. } => row.name == "moddg-fixed-point",
        StepFailure::NewtonStalled { .. } | StepFailure::SeveralSolutions { .. } => {
            !closed && row.name != "moddg-fixed-point"
        }
        StepFailure::Unresolved { .. }
        | StepFailure::Undefined { .. }
        | StepFailure::AcrossSingularity { .. }
        | StepFailure::NotGradient { .. }
        | StepFailure::NotPartial { .. }
        | StepFailure::EdgeUnresolved { .. }
        | StepFailure::BalanceLost { .. }
        | StepFailure::Vanishes { .. }
        | StepFailure::TooLarge { .. } => false,
        StepFailure::TooLong { .. } => row.name == "locally-exact",
        // Only events cause them.
        StepFailure::EventsAccumulate { .. }
        | StepFailure::LeftByEvent { .. }
        | StepFailure::NoRebound { .. } => false,
        // Only the reference divides its steps.
        StepFailure::PartsAccumulate { .. } => false,
        StepFailure::NoRelaxationRoot { .. } => row.name.starts_with("relaxed"),
        StepFailure::ProjectionFailed { .. } => row.name.starts_with("splitting"),
    }
}

/// Runs this number of cases; failing cases are stored beside this file.
fn config(cases: u32) -> ProptestConfig {
    let failure_persistence = FileFailurePersistence::WithSource("proptest-regressions");
    ProptestConfig {
        failure_persistence: Some(Box::new(failure_persistence)),
        ..ProptestConfig::with_cases(cases)
    }
}

/// Checks every method that claims to conserve K on one case.
fn check_k<T: Widen>(case: &Case) -> Result<(), TestCaseError> {
    for row in FIXED.iter().filter(|row| row.keeps_k && on_one_degree(row)) {
        let fixed_point = row.name == "moddg-fixed-point";
        let roundings = if fixed_point { ROUNDINGS_FIXED_POINT } else { ROUNDINGS };
        for Bound { run, closed } in case.model.bind::<T>(row) {
            let label = format!("{} ({})", row.name, if closed { "closed form" } else { "solved" });
            match case.keeps_k(&|h, state| run.step(h, state), roundings) {
                Err(wrong) => prop_assert!(false, "{label}: {wrong}"),
                Ok(None) => {}
                Ok(Some(failure)) => {
                    prop_assert!(makes_sense(row, closed, &failure), "{label}: {failure}");
                }
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(1000))]

    #[test]
    fn k_is_kept_on_the_damped_oscillator(case in case(damped_oscillator())) {
        check_k::<f64>(&case)?;
    }

    #[test]
    fn k_is_kept_on_duffing(case in case(duffing())) {
        check_k::<f64>(&case)?;
    }

    #[test]
    fn k_is_kept_on_van_der_pol(case in case(van_der_pol())) {
        check_k::<f64>(&case)?;
    }

    #[test]
    fn k_is_kept_on_modified_van_der_pol(case in case(modified_van_der_pol())) {
        check_k::<f64>(&case)?;
    }

    #[test]
    fn a_passive_single_well_never_stops_the_plain_scheme(case in case(passive_well())) {
        for Bound { run, .. } in case.model.bind::<f64>(find("moddg").unwrap()) {
            let failure = case.keeps_k(&|h, state| run.step(h, state), ROUNDINGS);
            prop_assert_eq!(failure, Ok(None));
        }
    }

    #[test]
    fn what_is_passive_only_fills_the_reservoir(case in case(passive())) {
        for row in FIXED.iter().filter(|row| row.passive && on_one_degree(row)) {
            for Bound { run, closed } in case.model.bind::<f64>(row) {
                let outcome = case.only_fills(&|h, state| run.step(h, state));
                prop_assert!(outcome.is_ok(), "{} ({closed}): {}", row.name, outcome.unwrap_err());
            }
        }
    }
}

proptest! {
    #![proptest_config(config(250))]

    #[test]
    fn k_is_kept_in_31_digits(case in case(model())) {
        check_k::<Quad>(&case)?;
    }
}

#[test]
fn a_strong_drive_is_solved_to_rounding() {
    // h D is of order 1 and h V' is small: a solver that stops at the rounding of q in D would stop
    // too early.
    for (mu, q, p, h) in [
        (-6.023138359935312, -9.429959415871592, -7.1060226154188575, 0.00029234957616029484),
        (9.77203399413433, -8.845958537697308, -6.932642349061287, 0.0013077206492030124),
        (-7.7923010781396105, -9.598625215020434, 2.3673610012131308, 0.0008984918792347433),
        (6.04698241829155, 7.868669241657923, 0.6852390446207686, 0.009570927164646952),
    ] {
        let case = Case { model: Model::VanDerPol { mu }, q, p, w: 0.0, h };
        check_k::<f64>(&case).unwrap();
        check_k::<Quad>(&case).unwrap();
    }
}

#[test]
fn simple_iteration_stops_at_rounding() {
    let diverging = Model::Duffing { alpha: 0.0, beta: -7.125694500189359, c: -7.297724953138848 };
    let slow = Model::VanDerPol { mu: 7.435408932935137 };
    for case in [
        // |∂F/∂v| = 3.6: the iteration diverges, with updates below the rounding of q.
        Case { model: diverging, q: -1.7744761493622853e-10, p: 0.0, w: 0.0, h: 1.0 },
        // |∂F/∂v| = 0.99: the iteration converges so slowly that rounding soon
        // stops the updates from shrinking.
        Case {
            model: slow,
            q: -9.114644483772375,
            p: 5.939745794139252,
            w: 0.0,
            h: 0.00327396364764561,
        },
    ] {
        check_k::<f64>(&case).unwrap();
    }
}

#[test]
fn k_is_kept_beside_a_pole_where_the_step_is_endless() {
    // δ₄(q) is at least 1e30, so p̄ is smaller than p0 by this factor.
    for (k, b, q, p, h) in [
        (
            164.03086808500353,
            9.118753810810546,
            -8.190154756581727,
            -2.534299325477662e-11,
            4.1847530990544675,
        ),
        (
            535.5431212492113,
            4.694728826007533,
            -9.296407983726308,
            -9.824778120715335e-12,
            6.722624928783395,
        ),
    ] {
        check_k::<f64>(&Case { model: Model::DampedOscillator { k, b }, q, p, w: 0.0, h }).unwrap();
    }
}

#[test]
fn k_is_kept_beside_a_singular_step() {
    // σ = 1 + h/2 (b + h k/2) and p0 - h/2 k q0 nearly vanish, and p̄ is their quotient.
    for (missing, slack) in [(1e-3, 0.0), (1e-6, 1e-3), (1e-9, 1e-9)] {
        let model = Model::DampedOscillator { k: 1.0, b: -2.5 * (1.0 - missing) };
        check_k::<f64>(&Case { model, q: 1.0, p: 0.5 + slack, w: 0.0, h: 1.0 }).unwrap();
    }
}

/// A user-defined system, V = eᵠ - 1 - q with D = c p, whose edges are computed by quadrature.
struct Exponential {
    c: f64,
}

impl<T: Scalar> System<T> for Exponential {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        // Near 0 the terms of eᵠ - 1 - q cancel, and the check of K compares with V where edges are
        // not exact.
        let q = q[0];
        let series = (2..=14)
            .rev()
            .fold(T::zero(), |sum, k| (sum * q + T::one()) / T::from_f64(f64::from(k)));
        let small = q.abs().lt(T::from_f64(1e-2));
        (p[0] * p[0]).half() + T::select(small, q * q * series, q.exp_m1() - q)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (hq[0], hp[0]) = (q[0].exp_m1(), p[0]);
    }
    fn dissipation(&self, _q: &[T], p: &[T], _v: &[T], d: &mut [T]) {
        d[0] = T::from_f64(self.c) * p[0];
    }
}

impl<T: Scalar> Separable<T> for Exponential {
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at.exp_m1()
    }
    fn dissipation_of(&self, _q: &[T], p: &[T], _j: usize) -> Dissipation<T> {
        let by_p = T::from_f64(self.c);
        Dissipation { value: by_p * p[0], by_q: T::zero(), by_p }
    }
}

proptest! {
    #![proptest_config(config(1000))]

    #[test]
    fn k_is_kept_without_an_edge_in_closed_form(
        q in number(2.0), p in number(2.0), c in prop_oneof![Just(0.0), 0.0..3.0_f64],
        h in logarithmic(-6.0, -0.5),
    ) {
        let system = Exponential { c };
        let total = |state: &State<[f64; 1]>| {
            let [q, p, w] = [state.q, state.p, state.w].map(|x| x[0].widen());
            system.energy(&[q], &[p]) + w
        };
        // The terms at both ends: p², those of q V' = q eᵠ - q, and w. The work is smaller here.
        let end = |state: &State<[f64; 1]>| {
            let [q, p, w] = [state.q[0], state.p[0], state.w[0]];
            p * p + q.abs() * (q.exp() + 1.0) + w.abs()
        };
        let mut state = State::new([q], [p]).unwrap();
        let before = state.clone();
        ModDg::newton().step(&system, h, &mut state, &mut ()).unwrap();
        let drift = (total(&state) - total(&before)).0.abs();
        let rounding = <f64 as Scalar>::EPSILON * (end(&state) + end(&before));
        let roundings = drift / (rounding + f64::MIN_POSITIVE);
        prop_assert!(roundings <= ROUNDINGS, "K moved by {roundings:.1} roundings to {state:?}");
    }
}
