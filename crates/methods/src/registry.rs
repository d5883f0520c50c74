//! Every method by name: its order, what it keeps, what it needs, and how it is bound to a system.

mod cost;
mod forms;
pub mod inlined;
mod number;
mod run;
mod table;

use crate::moddg::steps::{Equation, Placement, Printed, Raised};
use crate::{Composition, Relaxed};
use afterbay_core::{Abilities, InputError};
use std::sync::Arc;

pub use cost::Cost;
pub use number::{Compensable, Number, compensated};
pub use run::{Run, Setting, Show};
pub use table::{ADAPTIVE, FIXED, METHODS};

/// The order of what has no error but rounding.
pub const EXACT: u32 = u32::MAX;

/// A method in the registry.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name in scenes and tables.
    pub name: &'static str,
    /// One line on what it is.
    pub about: &'static str,
    /// The orders of its local errors (x(t + h) - x1)/h in q, p and w, away from poles, where H is
    /// separable if it need be no more general, [`EXACT`] where there are none; some systems see
    /// higher ones. The order of the method is the least of them, on any system it applies to.
    pub local_order: [u32; 3],
    /// Every step that is taken keeps K to roundings of what it is made of, at every step size, on
    /// every system the method applies to; what cannot is a failure. `linear-exact` adds h |A| of
    /// them beyond 12 degrees of freedom.
    pub keeps_k: bool,
    /// At every step size, Δw_j ≥ 0 for each j where the system is [`Passive::Each`], and Σ Δw_j ≥
    /// 0, to a rounding of Σ |w_j|, where it is [`Passive::InSum`]; for friction computed from the
    /// velocity that [`System::dissipation`] is given.
    ///
    /// [`Passive::Each`]: afterbay_core::Passive::Each
    /// [`Passive::InSum`]: afterbay_core::Passive::InSum
    /// [`System::dissipation`]: afterbay_core::System::dissipation
    pub passive: bool,
    /// (q, p) stays bounded on every linear system with H positive definite and friction that only
    /// takes energy, at every step size, however many degrees of freedom are coupled: the
    /// eigenvalues of the step are in the unit circle where those of the flow are in the left
    /// half-plane. What fails there is not stable, except by [`StepFailure::TooLong`], which is not
    /// judged.
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

    /// Does it choose its steps, by a tolerance?
    pub const fn is_adaptive(&self) -> bool {
        matches!(self.kind, Kind::AdaptiveCollocation | Kind::AdaptiveDop853)
    }

    /// Does it run eight systems side by side? Whether it applies to them is told when it is bound.
    pub const fn has_lanes(&self) -> bool {
        matches!(self.kind, Kind::Leapfrog | Kind::Rk4 | Kind::Increment(_) | Kind::ModDg)
    }

    /// The equations whose δ it uses: its poles are there.
    pub fn poles(&self) -> &'static [Equation] {
        let (Kind::Raised(Raised(placement, _)) | Kind::Printed(Printed(placement, _))) = self.kind
        else {
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
    /// The same, or D linear in the momenta it couples; or H followed in the plane of each q_j and
    /// p_j (`PhasePlane`), D_j free of the other velocities.
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
    AdaptiveCollocation,
    AdaptiveDop853,
}

/// The row of a method.
pub fn find(name: &str) -> Option<&'static Row> {
    METHODS.iter().find(|row| row.name == name)
}

/// Binds a method to a system by the shortest way its abilities allow, in the form that serves
/// every system.
///
/// # Errors
/// [`InputError::Unsupported`] where the system lacks an ability the method needs, or the method
/// does not run in this scalar.
pub fn bind<T: Number>(row: &Row, system: Arc<dyn Abilities<T>>) -> Result<Run<T>, InputError> {
    T::bind(row, &system)
}
