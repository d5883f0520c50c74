//! The rows of the registry.

use super::{Cost, EXACT, Kind, Needs, Row};
use crate::moddg::steps::{Degree, Equation, Placement, Printed, Raised};
use crate::{Composition, Relaxed};

/// All methods; those with a fixed step come before those with a tolerance.
pub const METHODS: &[Row] = &[
    Row {
        name: "leapfrog",
        about: "the paper's pqpLF/SV: Störmer-Verlet with a reservoir",
        local_order: [2, 2, 2],
        keeps_k: false,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(1),
        needs: Needs::Separable,
        kind: Kind::Leapfrog,
    },
    Row {
        name: "rk4",
        about: "the paper's eRK4: classical Runge-Kutta on (q, p, w)",
        local_order: [4, 4, 4],
        keeps_k: false,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(4),
        needs: Needs::Any,
        kind: Kind::Rk4,
    },
    Row {
        name: "relaxed-rk4",
        about: "classical Runge-Kutta, relaxed to keep K",
        local_order: [4; 3],
        keeps_k: true,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Relaxed(4),
        needs: Needs::Any,
        kind: Kind::Relaxed(Relaxed::rk4()),
    },
    Row {
        name: "relaxed-dop853",
        about: "DOP853, relaxed to keep K",
        local_order: [8; 3],
        keeps_k: true,
        passive: false,
        a_stable: false,
        l_stable: false,
        cost: Cost::Relaxed(12),
        needs: Needs::Any,
        kind: Kind::Relaxed(Relaxed::dop853()),
    },
    Row {
        name: "gonzalez",
        about: "the midpoint discrete gradient, solved to rounding",
        local_order: [2, 2, 2],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Modes(1),
        needs: Needs::Curvature,
        kind: Kind::Gonzalez,
    },
    Row {
        name: "locally-exact",
        about: "matrix δ: exact where the system is linear, solved to rounding",
        local_order: [2; 3],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: true,
        cost: Cost::Paths,
        needs: Needs::Curvature,
        kind: Kind::LocallyExact,
    },
    Row {
        name: "linear-exact",
        about: "the exact flow",
        local_order: [EXACT; 3],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: true,
        cost: Cost::Flow,
        needs: Needs::Linear,
        kind: Kind::LinearExact,
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
        a_stable: true,
        l_stable: false,
        cost: Cost::Sweeps(1),
        needs: Needs::OneDegree,
        kind: Kind::ModDg,
    },
    Row {
        name: "moddg-fixed-point",
        about: "moddg solved by simple iteration, as the paper does",
        local_order: [2, 2, 2],
        keeps_k: true,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Sweeps(1),
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
    increment(
        "increment-1",
        [2, 1, 1],
        1,
        true,
        "coordinate increments: one sweep",
        Composition::sweep,
    ),
    increment(
        "increment-2",
        [2; 3],
        2,
        true,
        "coordinate increments: a sweep and its adjoint",
        Composition::pair,
    ),
    increment(
        "increment-4",
        [4; 3],
        10,
        false,
        "coordinate increments, 5 pairs of sweeps (Suzuki)",
        Composition::suzuki4,
    ),
    increment(
        "increment-6",
        [6; 3],
        14,
        false,
        "coordinate increments, 7 pairs of sweeps (Yoshida)",
        Composition::yoshida6,
    ),
    increment(
        "increment-8",
        [8; 3],
        34,
        false,
        "coordinate increments, 17 pairs of sweeps (Kahan, Li)",
        Composition::kahan_li8,
    ),
    Row {
        name: "adaptive-collocation",
        about: "Gauss collocation of order 8 or 16, its steps and K by the tolerance",
        local_order: [8; 3],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Nodes,
        needs: Needs::Curvature,
        kind: Kind::AdaptiveCollocation,
    },
    Row {
        name: "adaptive-dop853",
        about: "DOP853, its steps and K by the tolerance",
        local_order: [8; 3],
        keeps_k: true,
        passive: false,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(12),
        needs: Needs::Curvature,
        kind: Kind::AdaptiveDop853,
    },
];

/// The methods with a fixed step.
pub const FIXED: &[Row] = METHODS.split_at(steps()).0;

/// The methods with a tolerance. The first applies to any system, including stiff ones.
pub const ADAPTIVE: &[Row] = METHODS.split_at(steps()).1;

/// The number of rows with a fixed step.
const fn steps() -> usize {
    let mut count = 0;
    while count < METHODS.len() && !METHODS[count].is_adaptive() {
        count += 1;
    }
    count
}

const fn collocation(name: &'static str, stages: usize) -> Row {
    Row {
        name,
        about: "energy-preserving collocation, solved to rounding",
        local_order: [2 * stages as u32; 3],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Modes(stages as u32),
        needs: Needs::Curvature,
        kind: Kind::Collocation(stages),
    }
}

/// The row of a composition of sweeps. A single sweep evaluates the force at a corner of the box:
/// it has order 1 in p, hence order 2 in q, and order 1 in w if D_j depends on the neighbours. With
/// one degree of freedom and separable H it is its own adjoint, and all orders are 2. With phase
/// planes the velocity is evaluated at a corner too, and q also has order 1. If all sweeps go
/// `forward` in time the method is passive, and since K is conserved H cannot grow.
const fn increment(
    name: &'static str,
    local_order: [u32; 3],
    sweeps: u32,
    forward: bool,
    about: &'static str,
    composition: fn() -> Composition,
) -> Row {
    let kind = Kind::Increment(composition);
    Row {
        name,
        about,
        local_order,
        keeps_k: true,
        passive: forward,
        a_stable: forward,
        l_stable: false,
        cost: Cost::Sweeps(sweeps),
        needs: Needs::SeparableOrPlanes,
        kind,
    }
}

const fn raised(
    name: &'static str,
    local_order: [u32; 3],
    placement: Placement,
    degree: Degree,
) -> Row {
    let about = match (placement, degree) {
        (Placement::Shared(Equation::Q), Degree::Third) => {
            "moddg with δ₃(q) in all three equations"
        }
        (Placement::Shared(Equation::Q), Degree::Fourth) => {
            "moddg with δ₄(q) in all three equations"
        }
        (Placement::Shared(Equation::P), Degree::Third) => {
            "moddg with δ₃(p) in all three equations"
        }
        (Placement::Shared(Equation::P), Degree::Fourth) => {
            "moddg with δ₄(p) in all three equations"
        }
        (Placement::Single(Equation::Q), Degree::Third) => {
            "moddg with δ₃(q) in the equation for q alone"
        }
        (Placement::Single(Equation::Q), Degree::Fourth) => {
            "moddg with δ₄(q) in the equation for q alone"
        }
        (Placement::Single(Equation::P), Degree::Third) => {
            "moddg with δ₃(p) in the equation for p alone"
        }
        (Placement::Single(Equation::P), Degree::Fourth) => {
            "moddg with δ₄(p) in the equation for p alone"
        }
        (Placement::Each, Degree::Third) => "moddg with δ₃(q) in q, δ₃(p) in p, h in w",
        (Placement::Each, Degree::Fourth) => "moddg with δ₄(q) in q, δ₄(p) in p, h in w",
    };
    let keeps_k = matches!(placement, Placement::Shared(_));
    let kind = Kind::Raised(Raised(placement, degree));
    // Near a pole δ may be negative, and a shared negative step returns energy from the reservoir,
    // on linear systems too; hence no shared δ is A-stable. The others have h in the equation for
    // w.
    let passive = !keeps_k;
    Row {
        name,
        about,
        local_order,
        keeps_k,
        passive,
        a_stable: false,
        l_stable: false,
        cost: Cost::Sweeps(1),
        needs: Needs::OneDegree,
        kind,
    }
}

const fn printed(
    name: &'static str,
    local_order: [u32; 3],
    placement: Placement,
    degree: Degree,
) -> Row {
    let row = raised(name, local_order, placement, degree);
    let kind = Kind::Printed(Printed(placement, degree));
    Row { about: "the same as the paper prints it", needs: Needs::Printed, kind, ..row }
}
