//! One step of a method for one degree of freedom, and the change of K = H + w that rounding may
//! cause.

use crate::catalog::{self, As, Both};
use afterbay_core::{
    Effort, InputError, IntegrateError, Mask, Passive, Quad, Scalar, State, StepFailure,
};
use afterbay_methods::registry::{Row, Run};
use proptest::prelude::*;

/// The bound of every check below, in unit roundoffs of the terms of a step (see [`Model::terms`]).
///
/// With v = p̄, m = 1, the exact change of K is `2v (v - p0) + (ΔV/Δq) Δq + Δw`. The rounding
/// errors of a step contribute to it
///
/// | where it comes from | roundings | of |
/// |---|---|---|
/// | p1 and q1 are rounded, one fused operation each | 1 | p1², q1 V'(q1) |
/// | ΔV/Δq: a sum, a product, three fused operations, one more in the equation | 6 | (ΔV/Δq) Δq |
/// | D̄: a fused mean, friction and product, in the equation and again in Δw | 2·4 | D̄ Δq |
/// | Δw: two products; w1 is rounded | 2 and 1 | D̄ Δq, w1 |
/// | v is rounded, which F amplifies by 1 + F': 2v² (1 + F') | 2 | p², q V', D̄ Δq |
/// | the solver stops at a residual of a rounding of v, p0 and of q0 in F | 2 | p², q V', D̄ Δq |
///
/// No term has more than 16 roundings.
pub(crate) const ROUNDINGS: f64 = 16.0;

/// The fixed-point iteration stops at the noise of its last update, up to 16 roundings of p0 and v:
/// 2·16 of p².
pub(crate) const ROUNDINGS_FIXED_POINT: f64 = 48.0;

/// The number of steps from every state.
const STEPS: usize = 5;

#[derive(Clone, Copy, Debug)]
pub(crate) enum Model {
    DampedOscillator { k: f64, b: f64 },
    Duffing { alpha: f64, beta: f64, c: f64 },
    VanDerPol { mu: f64 },
    ModifiedVanDerPol { mu: f64, alpha: f64, beta: f64 },
}

/// A method bound to a system, and whether it is in closed form.
pub(crate) struct Bound<T: Scalar> {
    pub(crate) run: Run<T>,
    pub(crate) closed: bool,
}

impl Model {
    /// α and β of V = α q²/2 + β q⁴/4.
    fn potential(self) -> [f64; 2] {
        match self {
            Self::DampedOscillator { k, .. } => [k, 0.0],
            Self::Duffing { alpha, beta, .. } | Self::ModifiedVanDerPol { alpha, beta, .. } => {
                [alpha, beta]
            }
            Self::VanDerPol { .. } => [1.0, 0.0],
        }
    }

    /// c and d of D = (c + d q²) p.
    pub(crate) fn friction(self) -> [f64; 2] {
        match self {
            Self::DampedOscillator { b, .. } => [b, 0.0],
            Self::Duffing { c, .. } => [c, 0.0],
            Self::VanDerPol { mu } | Self::ModifiedVanDerPol { mu, .. } => [-mu, mu],
        }
    }

    /// Binds the method to the system, in closed form if there is one, and with a solver.
    pub(crate) fn bind<T: Both>(self, row: &Row) -> Vec<Bound<T>> {
        let system = match self {
            Self::DampedOscillator { k, b } => catalog::oscillator(k, b),
            Self::Duffing { alpha, beta, c } => catalog::duffing(alpha, beta, c),
            Self::VanDerPol { mu } => catalog::van_der_pol(mu),
            Self::ModifiedVanDerPol { mu, alpha, beta } => {
                catalog::modified_van_der_pol(mu, alpha, beta)
            }
        };
        let forms: &[As] = match self {
            Self::DampedOscillator { .. } => &[As::Linear, As::Nonlinear],
            _ => &[As::Nonlinear],
        };
        let mut bound = Vec::new();
        for &form in forms {
            match system.bind(row, form) {
                Err(InputError::Unsupported { .. }) => {}
                Err(error) => panic!("{}: {error}", row.name),
                Ok(run) => {
                    let closed = form == As::Linear && row.name != "moddg-fixed-point";
                    bound.push(Bound { run, closed });
                }
            }
        }
        bound
    }

    /// H + w, in 31 digits.
    pub(crate) fn total<T: Widen>(self, state: &State<[T; 1]>) -> Quad {
        let [q, p, w] = [state.q[0].widen(), state.p[0].widen(), state.w[0].widen()];
        let [alpha, beta] = self.potential().map(Quad::from_f64);
        let q2 = q * q;
        (p * p + alpha * q2 + (beta * q2 * q2).half()).half() + w
    }

    /// The sum of the absolute terms of a step: p² and the terms of q V' at both ends, w at both
    /// ends, and the terms of the work D̄ Δq.
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

    /// The change of K over a step in unit roundoffs of its terms.
    fn drift<T: Widen>(self, before: &State<[T; 1]>, after: &State<[T; 1]>) -> f64 {
        let change = (self.total(after) - self.total(before)).0.abs();
        let terms = self.terms(before, after);
        // K is undefined after overflow.
        if terms.is_finite() { change / (T::EPSILON * terms + f64::MIN_POSITIVE) } else { 0.0 }
    }
}

/// Conversion to 31 digits without rounding.
pub(crate) trait Widen: Both {
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

/// The initial state and the step of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case {
    pub(crate) model: Model,
    pub(crate) q: f64,
    pub(crate) p: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

/// Numbers up to `size`, including small ones and 0.
pub(crate) fn number(size: f64) -> BoxedStrategy<f64> {
    let tiny = (-12.0..0.0_f64, prop::bool::ANY)
        .prop_map(|(x, up)| if up { 10f64.powf(x) } else { -10f64.powf(x) });
    prop_oneof![6 => -size..size, 1 => Just(0.0), 1 => tiny].boxed()
}

pub(crate) fn logarithmic(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|x| 10f64.powf(x))
}

pub(crate) fn damped_oscillator() -> BoxedStrategy<Model> {
    let parameters = (logarithmic(-3.0, 3.0), number(10.0));
    parameters.prop_map(|(k, b)| Model::DampedOscillator { k, b }).boxed()
}

/// Single wells, double wells, and potentials unbounded below.
pub(crate) fn duffing() -> BoxedStrategy<Model> {
    let parameters = (number(10.0), number(10.0), number(10.0));
    parameters.prop_map(|(alpha, beta, c)| Model::Duffing { alpha, beta, c }).boxed()
}

pub(crate) fn van_der_pol() -> BoxedStrategy<Model> {
    number(10.0).prop_map(|mu| Model::VanDerPol { mu }).boxed()
}

pub(crate) fn modified_van_der_pol() -> BoxedStrategy<Model> {
    (number(10.0), number(10.0), number(10.0))
        .prop_map(|(mu, alpha, beta)| Model::ModifiedVanDerPol { mu, alpha, beta })
        .boxed()
}

/// All systems, passive and active.
pub(crate) fn model() -> BoxedStrategy<Model> {
    prop_oneof![damped_oscillator(), duffing(), van_der_pol(), modified_van_der_pol()].boxed()
}

/// An initial state for one of the systems: random, at a turning point, or at an equilibrium.
pub(crate) fn case(model: BoxedStrategy<Model>) -> impl Strategy<Value = Case> {
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

/// A step: a method of the registry, or one with a deliberate error.
pub(crate) type Step<'a, T> = &'a dyn Fn(T, &mut State<[T; 1]>) -> Result<Effort, IntegrateError>;

fn bits<T: Widen>(state: &State<[T; 1]>) -> [[u64; 2]; 3] {
    [state.q[0], state.p[0], state.w[0]].map(|x| {
        let Quad(high, low) = x.widen();
        [high.to_bits(), low.to_bits()]
    })
}

impl Case {
    pub(crate) fn start<T: Scalar>(&self) -> State<[T; 1]> {
        let mut state = State::new([T::from_f64(self.q)], [T::from_f64(self.p)]).unwrap();
        state.w = [T::from_f64(self.w)];
        state
    }

    /// Takes a few steps and checks each. Returns the first error found, or the failure that ended
    /// them.
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
                Err(IntegrateError::Run(error)) => return Ok(Some(error.failure)),
                Err(error) => return Err(error.to_string()),
            }
        }
        Ok(None)
    }

    /// Takes a few steps and checks that K is conserved to the given number of roundings.
    pub(crate) fn keeps_k<T: Widen>(
        &self,
        step: Step<'_, T>,
        roundings: f64,
    ) -> Result<Option<StepFailure>, String> {
        self.follow(step, |before, after| {
            let drift = self.model.drift(before, after);
            (drift > roundings).then(|| format!("K moved by {drift:.1} roundings"))
        })
    }

    /// Takes a few steps and checks passivity.
    pub(crate) fn only_fills<T: Widen>(
        &self,
        step: Step<'_, T>,
    ) -> Result<Option<StepFailure>, String> {
        self.follow(step, |before, after| {
            Passive::Each.violated(&before.w, &after.w).all().then(|| "w fell".into())
        })
    }
}

/// Whether the bounds here, which are those of a single scalar equation, apply. Compositions of
/// sweeps and methods implicit in all of (q, p) have tests of their own (increment.rs, gonzalez.rs,
/// collocation.rs, linear_exact.rs, locally_exact.rs).
pub(crate) fn on_one_degree(row: &Row) -> bool {
    !["increment", "gonzalez", "collocation", "linear-exact", "locally-exact"]
        .iter()
        .any(|name| row.name.starts_with(name))
}
