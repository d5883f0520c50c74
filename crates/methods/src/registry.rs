//! Every method by name: its order, what it keeps, what it needs, and how it is bound to a system.

mod run;

use crate::moddg::ClosedForm;
use crate::moddg::steps::{Degree, Equation, Placement, Plain, Printed, Raised};
use crate::{Collocation, Composition, GeneralIncrement, Gonzalez, Increment, Leapfrog, ModDg, Rk4, Tiled};
use afterbay_core::solver::{FixedPoint, Newton};
use afterbay_core::{
    Curvature, InputError, Linear, Misprinted, OrderRaising, PhasePlane, Scalar, Separable, Uniform, Vector,
};
use run::bind;

pub use run::{Run, Show};

/// A method in the registry.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// One line on what it is.
    pub about: &'static str,
    /// The orders of its local errors (x(t + h) - x1)/h in q, p and w, away from poles, where H is separable if it need be
    /// no more general; some systems see higher ones. The order of the method is the least of them, on any system it applies to.
    pub local_order: [u32; 3],
    /// K is kept to rounding at every step size.
    pub keeps_k: bool,
    /// Every Δw ≥ 0 where the system is passive, at every step size.
    pub passive: bool,
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
    ModDg,
    ModDgFixedPoint,
    Raised(Raised),
    Printed(Printed),
    Gonzalez,
    /// s
    Collocation(usize),
    /// A composition of sweeps.
    Increment(fn() -> Composition),
}

/// Every method there is.
pub const METHODS: &[Row] = &[
    Row {
        name: "leapfrog",
        about: "the paper's pqpLF/SV: Störmer-Verlet with a reservoir",
        local_order: [2, 2, 2],
        keeps_k: false,
        passive: true,
        needs: Needs::Separable,
        kind: Kind::Leapfrog,
    },
    Row {
        name: "rk4",
        about: "the paper's eRK4: classical Runge-Kutta on (q, p, w)",
        local_order: [4, 4, 4],
        keeps_k: false,
        passive: true,
        needs: Needs::Any,
        kind: Kind::Rk4,
    },
    Row {
        name: "gonzalez",
        about: "the midpoint discrete gradient, solved to rounding",
        local_order: [2, 2, 2],
        keeps_k: true,
        passive: true,
        needs: Needs::Curvature,
        kind: Kind::Gonzalez,
    },
    collocation("collocation-2", 1),
    collocation("collocation-4", 2),
    collocation("collocation-6", 3),
    collocation("collocation-8", 4),
    collocation("collocation-10", 5),
    collocation("collocation-12", 6),
    collocation("collocation-14", 7),
    collocation("collocation-16", 8),
    Row {
        name: "moddg",
        about: "the paper's modified discrete gradient, solved to rounding",
        local_order: [2, 2, 2],
        keeps_k: true,
        passive: true,
        needs: Needs::OneDegree,
        kind: Kind::ModDg,
    },
    Row {
        name: "moddg-fixed-point",
        about: "moddg solved by simple iteration, as the paper does",
        local_order: [2, 2, 2],
        keeps_k: true,
        passive: true,
        needs: Needs::OneDegree,
        kind: Kind::ModDgFixedPoint,
    },
    raised("moddg-q3-shared", [3, 2, 2], Placement::Shared(Equation::Q), Degree::Third),
    raised("moddg-q4-shared", [3, 2, 2], Placement::Shared(Equation::Q), Degree::Fourth),
    raised("moddg-p3-shared", [2, 3, 2], Placement::Shared(Equation::P), Degree::Third),
    raised("moddg-p4-shared", [2, 3, 2], Placement::Shared(Equation::P), Degree::Fourth),
    raised("moddg-q3-single", [3, 2, 2], Placement::Single(Equation::Q), Degree::Third),
    raised("moddg-q4-single", [3, 2, 2], Placement::Single(Equation::Q), Degree::Fourth),
    raised("moddg-p3-single", [2, 3, 2], Placement::Single(Equation::P), Degree::Third),
    raised("moddg-p4-single", [2, 3, 2], Placement::Single(Equation::P), Degree::Fourth),
    raised("moddg-qp3", [3, 3, 2], Placement::Each, Degree::Third),
    raised("moddg-qp4", [4, 4, 2], Placement::Each, Degree::Fourth),
    printed("moddg-q4-shared-printed", [3, 2, 2], Placement::Shared(Equation::Q), Degree::Fourth),
    printed("moddg-q4-single-printed", [3, 2, 2], Placement::Single(Equation::Q), Degree::Fourth),
    printed("moddg-p3-shared-printed", [2, 2, 2], Placement::Shared(Equation::P), Degree::Third),
    printed("moddg-p3-single-printed", [2, 2, 2], Placement::Single(Equation::P), Degree::Third),
    printed("moddg-p4-shared-printed", [2, 2, 2], Placement::Shared(Equation::P), Degree::Fourth),
    printed("moddg-p4-single-printed", [2, 2, 2], Placement::Single(Equation::P), Degree::Fourth),
    increment("increment-1", [2, 1, 1], true, "coordinate increments: one sweep", Composition::sweep),
    increment(
        "increment-2",
        [2; 3],
        true,
        "coordinate increments: a sweep and its adjoint",
        Composition::pair,
    ),
    increment(
        "increment-4",
        [4; 3],
        false,
        "coordinate increments, 5 pairs of sweeps (Suzuki)",
        Composition::suzuki4,
    ),
    increment(
        "increment-6",
        [6; 3],
        false,
        "coordinate increments, 7 pairs of sweeps (Yoshida)",
        Composition::yoshida6,
    ),
    increment(
        "increment-8",
        [8; 3],
        false,
        "coordinate increments, 17 pairs of sweeps (Kahan, Li)",
        Composition::kahan_li8,
    ),
];

const fn collocation(name: &'static str, stages: usize) -> Row {
    Row {
        name,
        about: "energy-preserving collocation, solved to rounding",
        local_order: [2 * stages as u32; 3],
        keeps_k: true,
        passive: true,
        needs: Needs::Curvature,
        kind: Kind::Collocation(stages),
    }
}

/// A single sweep takes the force at a corner of the box: of order 1 in p, so of order 2 in q, and of order 1 in w where D_j
/// feels its neighbours. With one degree of freedom and H separable it is its own adjoint, and all of its orders are 2. With
/// phase planes the velocity is taken at a corner too, and q is of order 1 as well.
const fn increment(
    name: &'static str,
    local_order: [u32; 3],
    passive: bool,
    about: &'static str,
    composition: fn() -> Composition,
) -> Row {
    let kind = Kind::Increment(composition);
    Row { name, about, local_order, keeps_k: true, passive, needs: Needs::SeparableOrPlanes, kind }
}

const fn raised(name: &'static str, local_order: [u32; 3], placement: Placement, degree: Degree) -> Row {
    let about = match (placement, degree) {
        (Placement::Shared(Equation::Q), Degree::Third) => "moddg with δ₃(q) in all three equations",
        (Placement::Shared(Equation::Q), Degree::Fourth) => "moddg with δ₄(q) in all three equations",
        (Placement::Shared(Equation::P), Degree::Third) => "moddg with δ₃(p) in all three equations",
        (Placement::Shared(Equation::P), Degree::Fourth) => "moddg with δ₄(p) in all three equations",
        (Placement::Single(Equation::Q), Degree::Third) => "moddg with δ₃(q) in the equation for q alone",
        (Placement::Single(Equation::Q), Degree::Fourth) => "moddg with δ₄(q) in the equation for q alone",
        (Placement::Single(Equation::P), Degree::Third) => "moddg with δ₃(p) in the equation for p alone",
        (Placement::Single(Equation::P), Degree::Fourth) => "moddg with δ₄(p) in the equation for p alone",
        (Placement::Each, Degree::Third) => "moddg with δ₃(q) in q, δ₃(p) in p, h in w",
        (Placement::Each, Degree::Fourth) => "moddg with δ₄(q) in q, δ₄(p) in p, h in w",
    };
    let keeps_k = matches!(placement, Placement::Shared(_));
    let kind = Kind::Raised(Raised(placement, degree));
    // δ may be negative near a pole, and a shared negative step takes energy back from the reservoir. The others have h
    // in the equation for w.
    let passive = !keeps_k;
    Row { name, about, local_order, keeps_k, passive, needs: Needs::OneDegree, kind }
}

const fn printed(name: &'static str, local_order: [u32; 3], placement: Placement, degree: Degree) -> Row {
    let row = raised(name, local_order, placement, degree);
    let kind = Kind::Printed(Printed(placement, degree));
    Row { about: "the same as the paper prints it", needs: Needs::Printed, kind, ..row }
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
        Kind::Gonzalez => bind::<Vec<T>, _, _>(Gonzalez::default(), system),
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

/// Binds a method to a separable system, with states stored in `V`.
fn stored<V, S>(row: &Row, system: S) -> Result<Run<V::Scalar>, InputError>
where
    V: Vector + 'static,
    S: Separable<V::Scalar> + Curvature<V::Scalar> + 'static,
{
    match row.kind {
        Kind::Leapfrog => bind::<V, _, _>(Leapfrog, system),
        Kind::Rk4 => bind::<V, _, _>(Rk4, system),
        Kind::Gonzalez => bind::<V, _, _>(Gonzalez::default(), system),
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
