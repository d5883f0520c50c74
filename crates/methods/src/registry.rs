//! Every method by name: its order, what it keeps, what it needs, and how it is bound to a system.

mod cost;
mod run;
mod table;
mod within;

use crate::moddg::ClosedForm;
use crate::moddg::steps::{Equation, Placement, Plain, Printed, Raised};
use crate::{
    Collocation, Composition, GeneralIncrement, Gonzalez, Increment, Leapfrog, LinearExact, LocallyExact,
    ModDg, Relaxed, Rk4, Tiled,
};
use afterbay_core::solver::{FixedPoint, Newton};
use afterbay_core::{
    Corrected, Curvature, InputError, Lanewise, Linear, Misprinted, OrderRaising, PhasePlane, Scalar,
    Separable, Uniform, Vector, f64x8,
};
use run::bind;

pub use cost::Cost;
pub use run::{Run, Show};
pub use table::METHODS;
pub use within::{ADAPTIVE, AdaptiveRow, Within, adaptive, find_adaptive};

/// The order of what has no error but rounding.
pub const EXACT: u32 = u32::MAX;

/// A method in the registry.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// One line on what it is.
    pub about: &'static str,
    /// The orders of its local errors (x(t + h) - x1)/h in q, p and w, away from poles, where H is separable if it need be
    /// no more general, [`EXACT`] where there are none; some systems see higher ones. The order of the method is the least of them, on any system it applies to.
    pub local_order: [u32; 3],
    /// Every step that is taken keeps K to roundings of what it is made of, at every step size, on every system the method applies to; what
    /// cannot is a failure. `linear-exact` adds h |A| of them beyond 12 degrees of freedom.
    pub keeps_k: bool,
    /// At every step size, Δw_j ≥ 0 for each j where the system is [`Passive::Each`], and Σ Δw_j ≥ 0, to a rounding of Σ |w_j|, where it is
    /// [`Passive::InSum`]; for friction computed from the velocity that [`System::dissipation`] is given.
    ///
    /// [`Passive::Each`]: afterbay_core::Passive::Each
    /// [`Passive::InSum`]: afterbay_core::Passive::InSum
    /// [`System::dissipation`]: afterbay_core::System::dissipation
    pub passive: bool,
    /// (q, p) stays bounded on every linear system with H positive definite and friction that only takes energy, at every step
    /// size, however many degrees of freedom are coupled: the eigenvalues of the step are in the unit circle where those of
    /// the flow are in the left half-plane. What fails there is not stable, except by [`StepFailure::TooLong`], which is not judged.
    ///
    /// [`StepFailure::TooLong`]: afterbay_core::StepFailure::TooLong
    pub a_stable: bool,
    /// The same, and R(∞) = 0: (q, p) vanishes in one step where h λ → -∞ for every λ of the flow.
    pub l_stable: bool,
    /// What a step costs.
    pub cost: Cost,
    /// What a system must be for the method to apply.
    pub needs: Needs,
    kind: Kind,
}

impl Row {
    /// The order of the method.
    pub fn order(&self) -> u32 {
        self.local_order.into_iter().min().unwrap_or(0)
    }

    /// The equations whose δ it uses: its poles are there.
    pub fn poles(&self) -> &'static [Equation] {
        let (Kind::Raised(Raised(placement, _)) | Kind::Printed(Printed(placement, _))) = self.kind else {
            return &[];
        };
        match placement {
            Placement::Shared(Equation::Q) | Placement::Single(Equation::Q) => &[Equation::Q],
            Placement::Shared(Equation::P) | Placement::Single(Equation::P) => &[Equation::P],
            Placement::Each => &[Equation::Q, Equation::P],
        }
    }
}

/// What a system must be for a method to apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Any,
    /// Its second derivatives.
    Curvature,
    /// The same at every state: H quadratic and D linear.
    Linear,
    /// H = Σ p²/(2m) + V(q), D_j free of the other momenta.
    Separable,
    /// The same, or D linear in the momenta it couples; or H followed in the plane of each q_j and p_j ([`PhasePlane`]), D_j free
    /// of the other velocities.
    SeparableOrPlanes,
    /// H = p²/(2m) + V(q), one degree of freedom.
    OneDegree,
    /// A system whose δ the paper prints: the damped oscillator.
    Printed,
}

impl Needs {
    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Any => "any system",
            Self::Curvature => "any H, 2nd derivatives",
            Self::Linear => "linear system",
            Self::Separable => "separable H",
            Self::SeparableOrPlanes => "separable H or phase planes",
            Self::OneDegree => "separable H, 1 degree",
            Self::Printed => "damped oscillator",
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Leapfrog,
    Rk4,
    Relaxed(Relaxed),
    ModDg,
    ModDgFixedPoint,
    Raised(Raised),
    Printed(Printed),
    LinearExact,
    LocallyExact,
    Gonzalez,
    /// s
    Collocation(usize),
    /// A composition of sweeps.
    Increment(fn() -> Composition),
}

/// The row of a method.
pub fn find(name: &str) -> Option<&'static Row> {
    METHODS.iter().find(|row| row.name == name)
}

/// Binds a method to a system with any H and any number of degrees of freedom.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn general<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Scalar,
    S: Curvature<T> + PhasePlane<T> + 'static,
{
    match row.kind {
        Kind::Rk4 => bind::<Vec<T>, _, _>(Rk4, system),
        Kind::Relaxed(method) => bind::<Vec<T>, _, _>(method, system),
        Kind::Gonzalez => bind::<Vec<T>, _, _>(Gonzalez::default(), system),
        Kind::LocallyExact => bind::<Vec<T>, _, _>(LocallyExact, system),
        Kind::LinearExact => bind::<Vec<T>, _, _>(LinearExact, system),
        Kind::Collocation(stages) => bind::<Vec<T>, _, _>(Collocation::new(stages), system),
        Kind::Increment(composition) => bind::<Vec<T>, _, _>(GeneralIncrement::new(composition()), system),
        _ => Err(InputError::Unsupported { method: row.name, why: "H is not separable" }),
    }
}

/// Binds a method to a separable system with any number of degrees of freedom.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn separable<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Scalar,
    S: Separable<T> + Curvature<T> + 'static,
{
    stored::<Vec<T>, S>(row, system)
}

/// Binds a method to a separable system with one degree of freedom of which nothing more is known, its state on the stack.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn single<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Scalar,
    S: Separable<T> + Curvature<T> + 'static,
{
    stored::<[T; 1], S>(row, system)
}

/// Binds a method to eight separable systems side by side, each of which it moves as it would alone, to the bit, as far as functions
/// are that of the scalar; none where it runs one at a time: an implicit step in all degrees of freedom at once has its pivots, and its
/// number of iterations, to itself. A step that fails in one of them changes none: it is then to be taken one at a time.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn lanes<S: Separable<f64x8> + 'static>(row: &Row, system: S) -> Result<Option<Run<f64x8>>, InputError> {
    let natural = (0..system.dof()).collect();
    beside(row, system, natural)
}

/// The same of eight chains or rings of equal members: coordinate increments in the order of [`uniform`].
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn uniform_lanes<S: Separable<f64x8> + 'static>(
    row: &Row,
    system: S,
) -> Result<Option<Run<f64x8>>, InputError> {
    let (coupling, n) = (system.coupling(), system.dof());
    if coupling.two_coloured(n) && !system.dissipation_form().coupled {
        return beside(row, system, coupling.coloured(n));
    }
    lanes(row, system)
}

/// Eight systems side by side, their coordinates moved in an order.
fn beside<S: Separable<f64x8> + 'static>(
    row: &Row,
    system: S,
    order: Vec<usize>,
) -> Result<Option<Run<f64x8>>, InputError> {
    fn stored<V, S>(row: &Row, system: S, order: Vec<usize>) -> Result<Option<Run<f64x8>>, InputError>
    where
        V: Vector<Scalar = f64x8> + 'static,
        S: Separable<f64x8> + 'static,
    {
        match row.kind {
            Kind::Leapfrog => bind::<V, _, _>(Leapfrog, system),
            Kind::Rk4 => bind::<V, _, _>(Rk4, system),
            Kind::Increment(composition) => {
                bind::<V, _, _>(Increment::new(composition()).in_order(order), system)
            }
            Kind::ModDg => bind::<V, _, _>(ModDg::newton(), system),
            _ => return Ok(None),
        }
        .map(Some)
    }
    if system.dof() == 1 {
        stored::<[f64x8; 1], S>(row, system, order)
    } else {
        stored::<Vec<f64x8>, S>(row, system, order)
    }
}

/// The same of eight linear systems with one degree of freedom: implicit steps take their closed form.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn linear_lanes<S: Linear<f64x8> + 'static>(
    row: &Row,
    system: S,
) -> Result<Option<Run<f64x8>>, InputError> {
    match row.kind {
        Kind::ModDg => bind::<[f64x8; 1], _, _>(ModDg::linear(), system).map(Some),
        _ => lanes(row, system),
    }
}

/// Binds a method to a chain or a ring of equal members, in `f64`: coordinate increments are taken red and black, eight
/// at a time, where two colours are enough.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn uniform<S>(row: &Row, system: S) -> Result<Run<f64>, InputError>
where
    S: Uniform + Curvature<f64> + 'static,
{
    match row.kind {
        Kind::Increment(composition) if Tiled::fits(&system).is_ok() => {
            bind::<Vec<f64>, _, _>(Tiled::new(composition()), system)
        }
        _ => separable(row, system),
    }
}

/// Binds coordinate increments whose roundings do not add up ([`Increment::compensated`]), colour
/// by colour, to a system in `f64` or lanes of it and the same in [`Corrected`] numbers. A row
/// knows no scalar, so these are no rows of their own.
///
/// # Errors
/// [`InputError::Unsupported`] where it is another method or needs more, [`InputError::Length`] where `exact` is another system.
pub fn compensated<T, S, P>(row: &Row, system: S, exact: P) -> Result<Run<T>, InputError>
where
    T: Lanewise,
    S: Separable<T> + 'static,
    P: Separable<Corrected<T>> + 'static,
{
    let Kind::Increment(composition) = row.kind else {
        return Err(InputError::Unsupported { method: row.name, why: "only increments are compensated" });
    };
    let order = system.coupling().coloured(system.dof());
    bind::<Vec<T>, _, _>(Increment::new(composition()).in_order(order).compensated(exact), system)
}

/// Binds a method to a separable system, with states stored in `V`.
fn stored<V, S>(row: &Row, system: S) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
    S: Separable<V::Scalar> + Curvature<V::Scalar> + 'static,
{
    match row.kind {
        Kind::Leapfrog => bind::<V, _, _>(Leapfrog, system),
        Kind::Rk4 => bind::<V, _, _>(Rk4, system),
        Kind::Relaxed(method) => bind::<V, _, _>(method, system),
        Kind::Gonzalez => bind::<V, _, _>(Gonzalez::default(), system),
        Kind::LocallyExact => bind::<V, _, _>(LocallyExact, system),
        Kind::LinearExact => bind::<V, _, _>(LinearExact, system),
        Kind::Collocation(stages) => bind::<V, _, _>(Collocation::new(stages), system),
        Kind::Increment(composition) => bind::<V, _, _>(Increment::new(composition()), system),
        Kind::ModDg => bind::<V, _, _>(ModDg::newton(), system),
        Kind::ModDgFixedPoint => bind::<V, _, _>(ModDg { steps: Plain, solver: FixedPoint }, system),
        Kind::Raised(_) | Kind::Printed(_) => {
            Err(InputError::Unsupported { method: row.name, why: "the system does not know its δ" })
        }
    }
}

/// Binds a method to a separable system with one degree of freedom, its state on the stack.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn nonlinear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Scalar,
    S: OrderRaising<T> + Curvature<T> + 'static,
{
    match row.kind {
        Kind::Raised(steps) => bind::<[T; 1], _, _>(ModDg { steps, solver: Newton }, system),
        Kind::Printed(_) => Err(InputError::Unsupported {
            method: row.name,
            why: "the paper prints δ for the damped oscillator only",
        }),
        _ => stored::<[T; 1], S>(row, system),
    }
}

/// Binds a method to a linear system with one degree of freedom whose δ is printed: implicit steps take their closed
/// form.
///
/// # Errors
/// [`InputError::Unsupported`] where the method needs more.
pub fn linear<T, S>(row: &Row, system: S) -> Result<Run<T>, InputError>
where
    T: Scalar,
    S: Linear<T> + Misprinted<T> + Curvature<T> + 'static,
{
    match row.kind {
        Kind::ModDg => bind::<[T; 1], _, _>(ModDg::linear(), system),
        Kind::Raised(steps) => bind::<[T; 1], _, _>(ModDg { steps, solver: ClosedForm }, system),
        Kind::Printed(steps) => bind::<[T; 1], _, _>(ModDg { steps, solver: ClosedForm }, system),
        _ => stored::<[T; 1], S>(row, system),
    }
}
