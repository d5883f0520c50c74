//! K = H + w is kept to rounding by every method that claims it, whatever the state, the system and the step; and a
//! passive system's reservoir never gives anything back to a method that claims so.

#![cfg(test)]

use afterbay_core::{
    Drag, Effort, InputError, Mask, Method, Quad, Scalar, Separable, State, StepFailure, System,
};
use afterbay_methods::ModDg;
use afterbay_methods::registry::{METHODS, Row, Run, find, linear, nonlinear};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::FileFailurePersistence;
use proptest::test_runner::TestRunner;

/// What every check below allows, in unit roundoffs of the terms that enter (see [`Model::terms`]).
///
/// With v = p̄, m = 1, the exact change of K is `2v (v - p0) + (ΔV/Δq) Δq + Δw`, and what a step leaves of it is
///
/// | where it comes from | roundings | of |
/// |---|---|---|
/// | p1 and q1 are rounded, one fused operation each | 1 | p1², q1 V'(q1) |
/// | ΔV/Δq: a sum, a product, three fused operations, one more in the equation | 6 | (ΔV/Δq) Δq |
/// | D̄: a fused mean, friction and product, in the equation and again in Δw | 2·4 | D̄ Δq |
/// | Δw: two products; w1 is rounded | 2 and 1 | D̄ Δq, w1 |
/// | v is rounded, which the equation feels (1 + F')-fold: 2v² (1 + F') | 2 | p², q V', D̄ Δq |
/// | the solver stops when what is left is a rounding of v, p0 and of q0 in F | 2 | p², q V', D̄ Δq |
///
/// No term collects more than 16.
const ROUNDINGS: f64 = 16.0;

/// Simple iteration stops at the noise of its last update, up to 16 roundings of p0 and v by itself: 2·16 of p².
const ROUNDINGS_FIXED_POINT: f64 = 48.0;

/// The steps taken from every state.
const STEPS: usize = 5;

#[derive(Clone, Copy, Debug)]
enum Model {
    DampedOscillator { k: f64, b: f64 },
    Duffing { alpha: f64, beta: f64, c: f64 },
    VanDerPol { mu: f64 },
    ModifiedVanDerPol { mu: f64, alpha: f64, beta: f64 },
}

/// A method bound to a system, and whether it has its closed form.
struct Bound<T: Scalar> {
    run: Run<T>,
    closed: bool,
}

type Attempt<T> = Result<Run<T>, InputError>;

impl Model {
    /// α and β of V = α q²/2 + β q⁴/4.
    fn potential(self) -> [f64; 2] {
        match self {
            Self::DampedOscillator { k, .. } => [k, 0.0],
            Self::Duffing { alpha, beta, .. } | Self::ModifiedVanDerPol { alpha, beta, .. } => [alpha, beta],
            Self::VanDerPol { .. } => [1.0, 0.0],
        }
    }

    /// c and d of D = (c + d q²) p.
    fn friction(self) -> [f64; 2] {
        match self {
            Self::DampedOscillator { b, .. } => [b, 0.0],
            Self::Duffing { c, .. } => [c, 0.0],
            Self::VanDerPol { mu } | Self::ModifiedVanDerPol { mu, .. } => [-mu, mu],
        }
    }

    /// The method bound to the system: in closed form where there is one, and solved for.
    fn bind<T: Scalar>(self, row: &Row) -> Vec<Bound<T>> {
        let x = T::from_f64;
        let attempts: [Option<Attempt<T>>; 2] = match self {
            Self::DampedOscillator { k, b } => {
                let system = DampedOscillator::new(x(k), x(b)).unwrap();
                [Some(linear(row, system)), Some(nonlinear(row, system))]
            }
            Self::Duffing { alpha, beta, c } => {
                [None, Some(nonlinear(row, Duffing::new(x(alpha), x(beta), x(c)).unwrap()))]
            }
            Self::VanDerPol { mu } => [None, Some(nonlinear(row, VanDerPol::new(x(mu)).unwrap()))],
            Self::ModifiedVanDerPol { mu, alpha, beta } => {
                [None, Some(nonlinear(row, ModifiedVanDerPol::new(x(mu), x(alpha), x(beta)).unwrap()))]
            }
        };
        let mut bound = Vec::new();
        for (run, closed) in attempts.into_iter().zip([true, false]) {
            match run {
                None | Some(Err(InputError::Unsupported { .. })) => {}
                Some(Err(error)) => panic!("{}: {error}", row.name),
                Some(Ok(run)) => bound.push(Bound { run, closed: closed && row.name != "moddg-fixed-point" }),
            }
        }
        bound
    }

    /// H + w, in 31 digits.
    fn total<T: Widen>(self, state: &State<[T; 1]>) -> Quad {
        let [q, p, w] = [state.q[0].widen(), state.p[0].widen(), state.w[0].widen()];
        let [alpha, beta] = self.potential().map(Quad::from_f64);
        let q2 = q * q;
        (p * p + alpha * q2 + (beta * q2 * q2).half()).half() + w
    }

    /// The sum of the magnitudes of the terms that enter a step: p² and the terms of q V' at both ends, w at both ends,
    /// and the terms of the work D̄ Δq.
    fn terms<T: Scalar>(self, before: &State<[T; 1]>, after: &State<[T; 1]>) -> f64 {
        let abs = |part: &[T; 1]| part[0].to_f64().abs();
        let [alpha, beta] = self.potential().map(f64::abs);
        let [c, d] = self.friction().map(f64::abs);
        let end = |state: &State<[T; 1]>| {
            let q2 = abs(&state.q).powi(2);
            abs(&state.p).powi(2) + alpha * q2 + beta * q2 * q2 + abs(&state.w)
        };
        let q = (abs(&before.q) + abs(&after.q)) / 2.0;
        let p = (before.p[0] + after.p[0]).half().to_f64().abs();
        let work = (c + d * q * q) * p * (after.q[0] - before.q[0]).to_f64().abs();
        end(before) + end(after) + work
    }

    /// The change of K over a step in unit roundoffs of the terms that enter.
    fn drift<T: Widen>(self, before: &State<[T; 1]>, after: &State<[T; 1]>) -> f64 {
        let change = (self.total(after) - self.total(before)).0.abs();
        let terms = self.terms(before, after);
        // Beyond the range of the numbers there is no K to keep.
        if terms.is_finite() { change / (T::EPSILON * terms + f64::MIN_POSITIVE) } else { 0.0 }
    }
}

/// A number as exactly as it is known.
trait Widen: Scalar {
    fn widen(self) -> Quad;
}

impl Widen for f64 {
    fn widen(self) -> Quad {
        Quad::from_f64(self)
    }
}

impl Widen for Quad {
    fn widen(self) -> Quad {
        self
    }
}

/// Where a run starts and how it steps.
#[derive(Clone, Copy, Debug)]
struct Case {
    model: Model,
    q: f64,
    p: f64,
    w: f64,
    h: f64,
}

/// Numbers up to `size`, small ones and 0 included.
fn number(size: f64) -> impl Strategy<Value = f64> {
    let tiny =
        (-12.0..0.0_f64, prop::bool::ANY).prop_map(|(x, up)| if up { 10f64.powf(x) } else { -10f64.powf(x) });
    prop_oneof![6 => -size..size, 1 => Just(0.0), 1 => tiny]
}

fn logarithmic(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|x| 10f64.powf(x))
}

fn damped_oscillator() -> impl Strategy<Value = Model> {
    (logarithmic(-3.0, 3.0), number(10.0)).prop_map(|(k, b)| Model::DampedOscillator { k, b })
}

/// Single wells, double wells, and potentials without a bottom.
fn duffing() -> impl Strategy<Value = Model> {
    (number(10.0), number(10.0), number(10.0)).prop_map(|(alpha, beta, c)| Model::Duffing { alpha, beta, c })
}

fn van_der_pol() -> impl Strategy<Value = Model> {
    number(10.0).prop_map(|mu| Model::VanDerPol { mu })
}

fn modified_van_der_pol() -> impl Strategy<Value = Model> {
    (number(10.0), number(10.0), number(10.0)).prop_map(|(mu, alpha, beta)| Model::ModifiedVanDerPol {
        mu,
        alpha,
        beta,
    })
}

/// Any of the systems, passive and active.
fn model() -> impl Strategy<Value = Model> {
    prop_oneof![damped_oscillator(), duffing(), van_der_pol(), modified_van_der_pol()]
}

/// Systems that only lose energy.
fn passive() -> impl Strategy<Value = Model> {
    prop_oneof![damped_oscillator(), duffing()].prop_map(|model| match model {
        Model::DampedOscillator { k, b } => Model::DampedOscillator { k, b: b.abs() },
        Model::Duffing { alpha, beta, c } => Model::Duffing { alpha, beta, c: c.abs() },
        active => active,
    })
}

/// Those of them with a single well.
fn passive_well() -> impl Strategy<Value = Model> {
    passive().prop_map(|model| match model {
        Model::Duffing { alpha, beta, c } => Model::Duffing { alpha: alpha.abs(), beta: beta.abs(), c },
        other => other,
    })
}

/// A start for one of the systems: anywhere, at a turning point, or at rest in an equilibrium.
fn case(model: impl Strategy<Value = Model>) -> impl Strategy<Value = Case> {
    (model, number(10.0), number(10.0), number(10.0), logarithmic(-6.0, 1.0), 0..8).prop_map(
        |(model, q, p, w, h, place)| {
            let [alpha, beta] = model.potential();
            let well = (-alpha / beta).sqrt();
            let (q, p) = match place {
                0 => (q, 0.0),
                1 => (if well <= 10.0 { well } else { 0.0 }, 0.0),
                _ => (q, p),
            };
            Case { model, q, p, w, h }
        },
    )
}

/// A step: the registry's methods, and broken ones.
type Step<'a, T> = &'a dyn Fn(T, &mut State<[T; 1]>) -> Result<Effort, StepFailure>;

/// May this method fail like this? The plain closed form fails where its equation is singular, what is iterated where
/// there is nothing to find, δ at its pole, and anything where numbers end.
fn makes_sense(row: &Row, closed: bool, failure: &StepFailure) -> bool {
    match failure {
        StepFailure::NonFinite { .. } => true,
        StepFailure::Pole { .. } => !row.poles().is_empty(),
        StepFailure::Singular { .. } => closed,
        StepFailure::NotContracting { .. } => row.name == "moddg-fixed-point",
        StepFailure::NewtonStalled { .. } => !closed && row.name != "moddg-fixed-point",
    }
}

fn bits<T: Widen>(state: &State<[T; 1]>) -> [[u64; 2]; 3] {
    [state.q[0], state.p[0], state.w[0]].map(|x| {
        let Quad(high, low) = x.widen();
        [high.to_bits(), low.to_bits()]
    })
}

impl Case {
    fn start<T: Scalar>(&self) -> State<[T; 1]> {
        let mut state = State::new([T::from_f64(self.q)], [T::from_f64(self.p)]).unwrap();
        state.w = [T::from_f64(self.w)];
        state
    }

    /// Takes a few steps, checking each. What was found wrong, or the failure that ended them.
    fn follow<T: Widen>(
        &self,
        step: Step<'_, T>,
        wrong: impl Fn(&State<[T; 1]>, &State<[T; 1]>) -> Option<String>,
    ) -> Result<Option<StepFailure>, String> {
        let mut state = self.start();
        for n in 1..=STEPS {
            let before = state.clone();
            match step(T::from_f64(self.h), &mut state) {
                Ok(_) if state.check(1).is_err() => return Err(format!("step {n} left {state:?}")),
                Ok(_) => {
                    if let Some(wrong) = wrong(&before, &state) {
                        return Err(format!("{wrong} in step {n} from {before:?} to {state:?}"));
                    }
                }
                Err(_) if bits(&before) != bits(&state) => {
                    return Err(format!("failed step {n} changed {before:?} to {state:?}"));
                }
                Err(failure) => return Ok(Some(failure)),
            }
        }
        Ok(None)
    }

    /// Takes a few steps that keep K to so many roundings of the terms that enter.
    fn keeps_k<T: Widen>(&self, step: Step<'_, T>, roundings: f64) -> Result<Option<StepFailure>, String> {
        self.follow(step, |before, after| {
            let drift = self.model.drift(before, after);
            (drift > roundings).then(|| format!("K moved by {drift:.1} roundings"))
        })
    }

    /// Takes a few steps in which w never falls.
    fn only_fills<T: Widen>(&self, step: Step<'_, T>) -> Result<Option<StepFailure>, String> {
        self.follow(step, |before, after| after.w[0].lt(before.w[0]).all().then(|| "w fell".into()))
    }
}

/// So many cases; what fails is kept beside this file.
fn config(cases: u32) -> ProptestConfig {
    let failure_persistence = FileFailurePersistence::WithSource("proptest-regressions");
    ProptestConfig {
        failure_persistence: Some(Box::new(failure_persistence)),
        ..ProptestConfig::with_cases(cases)
    }
}

/// Compositions of sweeps and what is solved in all of (q, p) have tests of their own (increment.rs, gonzalez.rs): the
/// bound here is that of a single scalar equation.
fn on_one_degree(row: &Row) -> bool {
    !row.name.starts_with("increment") && row.name != "gonzalez"
}

/// Every method that claims K, on one case.
fn check_k<T: Widen>(case: &Case) -> Result<(), TestCaseError> {
    for row in METHODS.iter().filter(|row| row.keeps_k && on_one_degree(row)) {
        let roundings = if row.name == "moddg-fixed-point" { ROUNDINGS_FIXED_POINT } else { ROUNDINGS };
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
        for row in METHODS.iter().filter(|row| row.passive && on_one_degree(row)) {
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
    // h D is of the size of 1 and h V' is small: a solver that stops at what q loses in D stops too early.
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
        // |∂F/∂v| = 3.6: it diverges, with updates below what q could lose.
        Case { model: diverging, q: -1.7744761493622853e-10, p: 0.0, w: 0.0, h: 1.0 },
        // |∂F/∂v| = 0.99: it contracts so slowly that rounding ends the shrinking early.
        Case { model: slow, q: -9.114644483772375, p: 5.939745794139252, w: 0.0, h: 0.00327396364764561 },
    ] {
        check_k::<f64>(&case).unwrap();
    }
}

#[test]
fn k_is_kept_beside_a_pole_where_the_step_is_endless() {
    // δ₄(q) is 1e30 and more, so p̄ is that much smaller than p0.
    for (k, b, q, p, h) in [
        (
            164.03086808500353,
            9.118753810810546,
            -8.190154756581727,
            -2.534299325477662e-11,
            4.1847530990544675,
        ),
        (535.5431212492113, 4.694728826007533, -9.296407983726308, -9.824778120715335e-12, 6.722624928783395),
    ] {
        check_k::<f64>(&Case { model: Model::DampedOscillator { k, b }, q, p, w: 0.0, h }).unwrap();
    }
}

#[test]
fn k_is_kept_beside_a_singular_step() {
    // σ = 1 + h/2 (b + h k/2) is all but 0, and so is p0 - h/2 k q0: p̄ is their quotient.
    for (missing, slack) in [(1e-3, 0.0), (1e-6, 1e-3), (1e-9, 1e-9)] {
        let model = Model::DampedOscillator { k: 1.0, b: -2.5 * (1.0 - missing) };
        check_k::<f64>(&Case { model, q: 1.0, p: 0.5 + slack, w: 0.0, h: 1.0 }).unwrap();
    }
}

/// A user's system, V = eᵠ - 1 - q with D = c p, whose edge comes from quadrature.
struct Exponential {
    c: f64,
}

impl<T: Scalar> System<T> for Exponential {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (p[0] * p[0]).half() + q[0].exp_m1() - q[0]
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
    fn drag(&self, _q: &[T], p: &[T], _j: usize) -> Drag<T> {
        let by_p = T::from_f64(self.c);
        Drag { value: by_p * p[0], by_q: T::zero(), by_p }
    }
}

proptest! {
    #![proptest_config(config(1000))]

    #[test]
    fn k_is_kept_without_an_edge_in_closed_form(
        q in number(2.0), p in number(2.0), c in prop_oneof![Just(0.0), 0.0..3.0_f64], h in logarithmic(-6.0, -0.5),
    ) {
        let system = Exponential { c };
        let total = |state: &State<[f64; 1]>| {
            let [q, p, w] = [state.q, state.p, state.w].map(|x| x[0].widen());
            system.energy(&[q], &[p]) + w
        };
        // Both ends of p², of the terms of q V' = q eᵠ - q, and w; the work is below these here.
        let end = |state: &State<[f64; 1]>| {
            let [q, p, w] = [state.q[0], state.p[0], state.w[0]];
            p * p + q.abs() * (q.exp() + 1.0) + w.abs()
        };
        let mut state = State::new([q], [p]).unwrap();
        let before = state.clone();
        ModDg::newton().step(&system, h, &mut state, &mut ()).unwrap();
        let drift = (total(&state) - total(&before)).0.abs();
        let roundings = drift / (<f64 as Scalar>::EPSILON * (end(&state) + end(&before)) + f64::MIN_POSITIVE);
        prop_assert!(roundings <= ROUNDINGS, "K moved by {roundings:.1} roundings to {state:?}");
    }
}

/// An ordinary start of an ordinary damped system.
const ORDINARY: Case =
    Case { model: Model::Duffing { alpha: 1.0, beta: 1.0, c: 0.3 }, q: 1.3, p: -0.7, w: 0.0, h: 0.1 };

fn solved<T: Scalar>(case: &Case, name: &str) -> Run<T> {
    case.model.bind(find(name).unwrap()).pop().unwrap().run
}

#[test]
fn a_reservoir_update_off_by_1e_minus_10_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let w0 = state.w[0];
        let effort = run.step(h, state)?;
        state.w[0] = w0 + (state.w[0] - w0) * (1.0 + 1e-10);
        Ok(effort)
    };
    assert_eq!(ORDINARY.keeps_k(&|h, state| run.step(h, state), ROUNDINGS), Ok(None));
    let wrong = ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err();
    assert!(wrong.contains("K moved by") && wrong.contains("step 1 "), "{wrong}");
}

#[test]
fn a_reservoir_fed_with_the_old_dissipation_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let (q0, p0, w0) = (state.q[0], state.p[0], state.w[0]);
        let effort = run.step(h, state)?;
        let [c, d] = ORDINARY.model.friction();
        state.w[0] = w0 + (c + d * q0 * q0) * p0 * (state.q[0] - q0);
        Ok(effort)
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("K moved by"));
}

#[test]
fn a_step_left_unsolved_is_caught() {
    let run = solved::<f64>(&ORDINARY, "moddg");
    let broken = |h: f64, state: &mut State<[f64; 1]>| {
        let effort = run.step(h, state)?;
        state.p[0] += 1e-13;
        Ok(effort)
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("K moved by"));
}

#[test]
fn a_failed_step_that_changes_the_state_is_caught() {
    let broken = |_, state: &mut State<[f64; 1]>| {
        state.w[0] += 1e-15;
        Err(StepFailure::Singular { dof: 0, slope: 0.0 })
    };
    assert!(ORDINARY.keeps_k(&broken, ROUNDINGS).unwrap_err().contains("changed"));
}

#[test]
fn what_does_not_claim_k_does_not_keep_it() {
    for row in METHODS.iter().filter(|row| !row.keeps_k) {
        let oscillator = Case { model: Model::DampedOscillator { k: 1.0, b: 0.3 }, ..ORDINARY };
        for case in [ORDINARY, oscillator] {
            for Bound { run, .. } in case.model.bind::<f64>(row) {
                let wrong = case.keeps_k(&|h, state| run.step(h, state), 1e6 * ROUNDINGS);
                assert!(wrong.is_err_and(|wrong| wrong.contains("K moved by")), "{}", row.name);
            }
        }
    }
}

#[test]
fn a_shared_step_is_not_passive_beside_its_pole() {
    // δ₃(q) falls without bound as b q/p grows, and a negative δ drains the reservoir.
    let case = Case { model: Model::DampedOscillator { k: 1.0, b: 0.5 }, q: 2.0, p: 1e-3, w: 0.0, h: 0.3 };
    for Bound { run, .. } in case.model.bind::<f64>(find("moddg-q3-shared").unwrap()) {
        assert!(case.only_fills(&|h, state| run.step(h, state)).is_err());
    }
}

#[test]
fn positive_weights_fill_the_reservoir_while_the_energy_rises() {
    // rk4 adds h Σ b_i D_i ∂H/∂p_i with b_i > 0: w rises although the step is beyond the limit of stability.
    let case = Case { model: Model::DampedOscillator { k: 1.0, b: 0.1 }, q: 2.3, p: -3.1, w: 0.0, h: 3.5 };
    let energy_rises = |name: &str| {
        let run = solved::<f64>(&case, name);
        assert_eq!(case.only_fills(&|h, state| run.step(h, state)), Ok(None));
        let (before, mut after) = (case.start(), case.start());
        run.step(case.h, &mut after).unwrap();
        let energy = |state: &State<[f64; 1]>| case.model.total(state).0 - state.w[0];
        energy(&after) > energy(&before)
    };
    assert!(energy_rises("rk4") && energy_rises("leapfrog") && !energy_rises("moddg"));
}

#[test]
fn the_property_is_mostly_about_steps_that_are_taken() {
    let mut runner = TestRunner::deterministic();
    let cases: Vec<Case> = (0..400).map(|_| case(model()).new_tree(&mut runner).unwrap().current()).collect();
    for row in METHODS.iter().filter(|row| row.keeps_k && on_one_degree(row)) {
        let (mut all, mut taken) = (0, 0);
        for case in &cases {
            for Bound { run, .. } in case.model.bind::<f64>(row) {
                all += 1;
                taken += u32::from(
                    case.keeps_k(&|h, state| run.step(h, state), ROUNDINGS_FIXED_POINT) == Ok(None),
                );
            }
        }
        let share = f64::from(taken) / f64::from(all);
        println!("{:26} {share:.2} of {all}", row.name);
        let floor = if row.name == "moddg" { 0.9 } else { 0.5 };
        assert!(share > floor, "{}: {share}", row.name);
    }
}
