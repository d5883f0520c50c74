//! The rows of families of methods, whose members differ in a few properties.

use super::binding::{AdaptiveBinding, Form};
use super::sources::{BRUGNANO, HAIRER_2010, KOBUS, Source};
use super::{Cost, Needs, Order, Row};
use crate::Collocation;
use crate::increment::Increments;
use crate::moddg::steps::Degree::{Fourth, Third};
use crate::moddg::steps::Equation::{P, Q};
use crate::moddg::steps::Placement::{Each, Shared, Single};
use crate::moddg::steps::{Placement, Printed, Raised};
use crate::splitting::Splittings;

/// The row of an explicit method that chooses its steps. Each tableau has a negative weight.
pub(super) const fn explicit(
    name: &'static str,
    about: &'static str,
    order: u32,
    evaluations: u32,
    sources: &'static [Source],
    method: &'static dyn AdaptiveBinding,
) -> Row {
    Row {
        name,
        about,
        local_order: Order::each([order; 3]),
        keeps_k: true,
        passive: false,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(evaluations),
        needs: Needs::Curvature,
        sources,
        form: Form::Adaptive(method),
    }
}

/// The row of energy-preserving collocation.
pub(super) const fn collocation(name: &'static str, method: &'static Collocation) -> Row {
    let stages = method.stages;
    Row {
        name,
        about: "energy-preserving collocation, solved to rounding",
        local_order: Order::each([2 * stages as u32; 3]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Modes(stages as u32),
        needs: Needs::Curvature,
        sources: &[BRUGNANO, HAIRER_2010],
        form: Form::Fixed(method),
    }
}

/// The row of a composition of sweeps. A single sweep evaluates the force at a corner of the box:
/// it has order 1 in p, hence order 2 in q, and order 1 in w if D_j depends on the neighbours. With
/// one degree of freedom and separable H it is its own adjoint, and all orders are 2. With phase
/// planes the velocity is evaluated at a corner too, and q also has order 1. If all sweeps go
/// `forward` in time the method is passive, and since K is conserved H cannot grow.
pub(super) const fn increment(
    name: &'static str,
    local_order: [u32; 3],
    sweeps: u32,
    forward: bool,
    about: &'static str,
    sources: &'static [Source],
    method: &'static Increments,
) -> Row {
    Row {
        name,
        about,
        local_order: Order::each(local_order),
        keeps_k: true,
        passive: forward,
        a_stable: forward,
        l_stable: false,
        cost: Cost::Sweeps(sweeps),
        needs: Needs::SeparableOrPlanes,
        sources,
        form: Form::Fixed(method),
    }
}

/// The row of a splitting method with a projection onto K. At order 2 all kicks go forward in time,
/// so that the method is passive.
pub(super) const fn splitting(
    name: &'static str,
    about: &'static str,
    order: u32,
    kicks: u32,
    sources: &'static [Source],
    method: &'static Splittings,
) -> Row {
    Row {
        name,
        about,
        local_order: Order::each([order; 3]),
        keeps_k: true,
        passive: order == 2,
        a_stable: false,
        l_stable: false,
        cost: Cost::Kicks(kicks),
        needs: Needs::Separable,
        sources,
        form: Form::Fixed(method),
    }
}

/// The row of modDG with δ rederived (`moddg/steps.rs`).
pub(super) const fn raised(
    name: &'static str,
    local_order: [u32; 3],
    method: &'static Raised,
) -> Row {
    let Raised(placement, degree) = *method;
    let about = match (placement, degree) {
        (Shared(Q), Third) => "moddg with δ₃(q) in all three equations",
        (Shared(Q), Fourth) => "moddg with δ₄(q) in all three equations",
        (Shared(P), Third) => "moddg with δ₃(p) in all three equations",
        (Shared(P), Fourth) => "moddg with δ₄(p) in all three equations",
        (Single(Q), Third) => "moddg with δ₃(q) in the equation for q alone",
        (Single(Q), Fourth) => "moddg with δ₄(q) in the equation for q alone",
        (Single(P), Third) => "moddg with δ₃(p) in the equation for p alone",
        (Single(P), Fourth) => "moddg with δ₄(p) in the equation for p alone",
        (Each, Third) => "moddg with δ₃(q) in q, δ₃(p) in p, h in w",
        (Each, Fourth) => "moddg with δ₄(q) in q, δ₄(p) in p, h in w",
    };
    modified(name, about, local_order, placement, Needs::OneDegree, Form::Fixed(method))
}

/// The row of modDG with δ as the paper prints it.
pub(super) const fn printed(
    name: &'static str,
    local_order: [u32; 3],
    method: &'static Printed,
) -> Row {
    let about = "the scheme of this name without -printed, with δ as the paper prints it";
    modified(name, about, local_order, method.0, Needs::Printed, Form::Fixed(method))
}

/// The row of the scheme with δ in place of h. Near a pole δ may be negative, and a shared negative
/// step returns energy from the reservoir, on linear systems too. Hence no shared δ is A-stable.
/// All other placements have h in the equation for w.
const fn modified(
    name: &'static str,
    about: &'static str,
    local_order: [u32; 3],
    placement: Placement,
    needs: Needs,
    form: Form,
) -> Row {
    let keeps_k = matches!(placement, Shared(_));
    Row {
        name,
        about,
        local_order: Order::each(local_order),
        keeps_k,
        passive: !keeps_k,
        a_stable: false,
        l_stable: false,
        cost: Cost::Sweeps(1),
        needs,
        sources: &[KOBUS],
        form,
    }
}
