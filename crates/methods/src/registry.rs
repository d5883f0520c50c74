//! The registry of all methods by name: their orders, conserved quantities, requirements and costs,
//! and the binding of a method to a system.

pub(crate) mod binding;
mod cost;
mod erased;
#[cfg(not(test))]
mod families;
pub mod inlined;
mod number;
mod order;
mod run;
mod sources;
mod stepper;
// A static is compiled with all it refers to, here each method for each scalar. The unit tests,
// which bind nothing, would compile all of them once more.
#[cfg(not(test))]
mod table;

use crate::moddg::steps::Equation;
use afterbay_core::{Abilities, InputError, Scalar, validate};
use binding::{Form, Target};
use std::sync::Arc;

pub use cost::Cost;
pub use erased::{Part, Show};
pub use number::{Compensable, Number, compensated};
pub use order::Order;
pub(crate) use run::fixed;
pub use run::{Run, Setting, Stepping};
pub use sources::{KOBUS, Source};
#[cfg(not(test))]
pub use table::{ADAPTIVE, FIXED, METHODS, REFERENCE, find};

/// A method in the registry.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The name in scenes and tables.
    pub name: &'static str,
    /// A one-line description.
    pub about: &'static str,
    /// The orders of the local errors (x(t + h) - x1)/h in q, p and w, away from poles. For methods
    /// that do not require a separable H, the orders on separable H; some systems have higher ones.
    /// The order of the method is the least of them, on any system to which it applies.
    pub local_order: [Order; 3],
    /// Whether every accepted step conserves K to roundings of its terms, for every step size and
    /// every system to which the method applies. A step that cannot conserve K fails.
    /// `linear-exact` adds h |A| roundings beyond 12 degrees of freedom.
    pub keeps_k: bool,
    /// Whether, for every step size, Δw_j ≥ 0 for each j where the system is [`Passive::Each`], and
    /// Σ Δw_j ≥ 0, to a rounding of Σ |w_j|, where it is [`Passive::InSum`]. Friction must be
    /// computed from the velocity passed to [`System::dissipation`].
    ///
    /// [`Passive::Each`]: afterbay_core::Passive::Each
    /// [`Passive::InSum`]: afterbay_core::Passive::InSum
    /// [`System::dissipation`]: afterbay_core::System::dissipation
    pub passive: bool,
    /// Whether (q, p) stays bounded on every linear system with positive definite H and passive
    /// friction, for every step size and any number of coupled degrees of freedom: the eigenvalues
    /// of the step lie in the closed unit disc if those of the flow lie in the left half-plane. A
    /// failing step counts as unstable, except for [`StepFailure::TooLong`], which is not judged.
    ///
    /// [`StepFailure::TooLong`]: afterbay_core::StepFailure::TooLong
    pub a_stable: bool,
    /// Whether, in addition, R(∞) = 0: (q, p) vanishes in one step as h λ → -∞ for every λ of the
    /// flow.
    pub l_stable: bool,
    /// The cost of a step.
    pub cost: Cost,
    /// The class of systems to which the method applies.
    pub needs: Needs,
    /// The publications the method comes from. Its reservoir comes from [`KOBUS`].
    pub sources: &'static [Source],
    form: Form,
}

impl Row {
    /// The order of the method.
    pub fn order(&self) -> Order {
        let [q, p, w] = self.local_order;
        q.min(p).min(w)
    }

    /// Whether the method chooses its steps by a tolerance.
    pub const fn is_adaptive(&self) -> bool {
        matches!(self.form, Form::Adaptive(_))
    }

    /// Whether the method can step eight systems side by side. Whether it can for a given system is
    /// determined when it is bound.
    pub fn has_lanes(&self) -> bool {
        matches!(self.form, Form::Fixed(method) if method.lanes())
    }

    /// The equations whose δ the method uses; the δ have poles.
    pub fn poles(&self) -> &'static [Equation] {
        match self.form {
            Form::Fixed(method) => method.delta_poles(),
            Form::Adaptive(_) => &[],
        }
    }

    /// The method, if it is of this type.
    fn method<M: 'static>(&self) -> Option<&'static M> {
        self.form.any().downcast_ref()
    }

    fn target<'a, T: Scalar>(&self, system: &'a Arc<dyn Abilities<T>>) -> Target<'a, T> {
        Target { name: self.name, system }
    }
}

/// The class of systems to which a method applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Any system.
    Any,
    /// A system that provides its second derivatives.
    Curvature,
    /// A system whose second derivatives are constant: H quadratic and D linear. Forces that are
    /// sums of sines and cosines of the time may drive it.
    Linear,
    /// H = Σ p²/(2m) + V(q), and D_j independent of the other momenta.
    Separable,
    /// H and D as for `Separable`, or D linear in the momenta that it couples; or any H that
    /// provides the means of its derivatives in the plane of each (q_j, p_j) (`PhasePlane`), with
    /// D_j independent of the other velocities.
    SeparableOrPlanes,
    /// H = p²/(2m) + V(q), one degree of freedom.
    OneDegree,
    /// A system whose δ the paper prints: the damped oscillator.
    Printed,
}

impl Needs {
    /// A description in words.
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

/// Binds a method to a system, in the form compiled for every system. Closed forms are used where
/// the abilities of the system allow them.
///
/// # Errors
/// [`InputError::Unsupported`] where the system lacks an ability the method needs, or the method
/// does not run in this scalar, and [`InputError::Mass`] for a mass that is not positive and
/// finite, also where the method uses none.
pub fn bind<T: Number>(row: &Row, system: Arc<dyn Abilities<T>>) -> Result<Run<T>, InputError> {
    if system.dof() == 0 {
        let why = "the system has no degree of freedom";
        return Err(InputError::Unsupported { method: row.name, why });
    }
    if let Some(separable) = system.clone().separable() {
        validate::masses(&*separable)?;
    }
    T::bind(row, &system)
}
