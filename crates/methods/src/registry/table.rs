//! The rows of the registry.

use super::binding::Form;
use super::families::{collocation, explicit, increment, printed, raised, splitting};
use super::sources::{
    BLANES_MOAN, BUTCHER, CIESLINSKI, CIESLINSKI_RATKIEWICZ, GONZALEZ, HAIRER_LUBICH_WANNER_2003,
    HAIRER_LUBICH_WANNER_2006, HAIRER_NORSETT_WANNER, HAIRER_WANNER_1996, HAIRER_WANNER_1999,
    ITOH_ABE, KAHAN_LI, KETCHESON, KOBUS, KUTTA, RANOCHA, SUZUKI, VERLET, VERNER, YOSHIDA,
};
use super::{Cost, Needs, Order, Row};
use crate::explicit_dop853::ExplicitDop853;
use crate::increment::Increments;
use crate::moddg::steps::Degree::{Fourth, Third};
use crate::moddg::steps::Equation::{P, Q};
use crate::moddg::steps::Placement::{Each, Shared, Single};
use crate::moddg::steps::{Plain, Printed, Raised};
use crate::splitting::Splittings;
use crate::{
    AdaptiveCollocation, AdaptiveDop853, AdaptiveRadau, AdaptiveVerner87, AdaptiveVerner98,
    Collocation, Composition, Gonzalez, ImplicitMidpoint, Leapfrog, LinearExact, LocallyExact,
    ModDg, Relaxed, Rk4,
};
use afterbay_core::solver::FixedPoint;

/// The method that computes the references of the studies of attractors. It is accurate, and it can
/// advance eight systems side by side. It is not one of [`METHODS`].
pub static REFERENCE: Row = Row {
    name: "reference",
    about: "DOP853 with small steps",
    local_order: Order::each([8; 3]),
    keeps_k: false,
    passive: false,
    a_stable: false,
    l_stable: false,
    cost: Cost::Explicit(13),
    needs: Needs::Any,
    sources: &[HAIRER_NORSETT_WANNER],
    form: Form::Fixed(&ExplicitDop853),
};

/// All methods; those with a fixed step come before those with a tolerance.
///
/// A `const` would compile all methods again in each crate that reads the table.
pub static METHODS: &[Row] = &[
    Row {
        name: "leapfrog",
        about: "the paper's pqpLF/SV: Störmer-Verlet with a reservoir",
        local_order: Order::each([2, 2, 2]),
        keeps_k: false,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(1),
        needs: Needs::Separable,
        sources: &[VERLET, HAIRER_LUBICH_WANNER_2003],
        form: Form::Fixed(&Leapfrog),
    },
    Row {
        name: "rk4",
        about: "the paper's eRK4: classical Runge-Kutta on (q, p, w)",
        local_order: Order::each([4, 4, 4]),
        keeps_k: false,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Explicit(4),
        needs: Needs::Any,
        sources: &[KUTTA],
        form: Form::Fixed(&Rk4),
    },
    Row {
        name: "relaxed-rk4",
        about: "classical Runge-Kutta, relaxed to keep K",
        local_order: Order::each([4; 3]),
        keeps_k: true,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Relaxed(4),
        needs: Needs::Any,
        sources: &[KETCHESON, RANOCHA, KUTTA],
        form: Form::Fixed(&Relaxed::rk4()),
    },
    Row {
        name: "relaxed-dop853",
        about: "DOP853, relaxed to keep K",
        local_order: Order::each([8; 3]),
        keeps_k: true,
        passive: false,
        a_stable: false,
        l_stable: false,
        cost: Cost::Relaxed(12),
        needs: Needs::Any,
        sources: &[KETCHESON, RANOCHA, HAIRER_NORSETT_WANNER],
        form: Form::Fixed(&Relaxed::dop853()),
    },
    Row {
        name: "relaxed-verner98",
        about: "Verner's method of order 9, relaxed to keep K",
        local_order: Order::each([9; 3]),
        keeps_k: true,
        passive: false,
        a_stable: false,
        l_stable: false,
        cost: Cost::Relaxed(16),
        needs: Needs::Any,
        sources: &[KETCHESON, RANOCHA, VERNER],
        form: Form::Fixed(&Relaxed::verner98()),
    },
    splitting(
        "splitting-2",
        "drift, kick, drift, projected onto K",
        2,
        1,
        &[VERLET, HAIRER_LUBICH_WANNER_2006],
        &Splittings(Composition::pair),
    ),
    splitting(
        "splitting-4",
        "six kicks (Blanes, Moan), projected onto K",
        4,
        6,
        &[BLANES_MOAN, HAIRER_LUBICH_WANNER_2006],
        &Splittings(Composition::blanes_moan4),
    ),
    splitting(
        "splitting-6",
        "ten kicks (Blanes, Moan), projected onto K",
        6,
        10,
        &[BLANES_MOAN, HAIRER_LUBICH_WANNER_2006],
        &Splittings(Composition::blanes_moan6),
    ),
    Row {
        name: "gonzalez",
        about: "the midpoint discrete gradient, solved to rounding",
        local_order: Order::each([2, 2, 2]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Modes(1),
        needs: Needs::Curvature,
        sources: &[GONZALEZ],
        form: Form::Fixed(&Gonzalez { solver: None }),
    },
    Row {
        name: "implicit-midpoint",
        about: "the Gauss method of one stage, solved to rounding",
        local_order: Order::each([2; 3]),
        keeps_k: false,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Modes(1),
        needs: Needs::Curvature,
        sources: &[HAIRER_LUBICH_WANNER_2006],
        form: Form::Fixed(&ImplicitMidpoint),
    },
    Row {
        name: "locally-exact",
        about: "matrix δ: exact where the system is linear, solved to rounding",
        local_order: Order::each([2; 3]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: true,
        cost: Cost::Paths,
        needs: Needs::Curvature,
        sources: &[CIESLINSKI_RATKIEWICZ, CIESLINSKI],
        form: Form::Fixed(&LocallyExact),
    },
    Row {
        name: "linear-exact",
        about: "the exact flow",
        local_order: [Order::Exact; 3],
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: true,
        cost: Cost::Flow,
        needs: Needs::Linear,
        sources: &[],
        form: Form::Fixed(&LinearExact),
    },
    collocation("collocation-2", &Collocation::new(1)),
    collocation("collocation-4", &Collocation::new(2)),
    collocation("collocation-6", &Collocation::new(3)),
    collocation("collocation-8", &Collocation::new(4)),
    collocation("collocation-10", &Collocation::new(5)),
    collocation("collocation-12", &Collocation::new(6)),
    collocation("collocation-14", &Collocation::new(7)),
    collocation("collocation-16", &Collocation::new(8)),
    Row {
        name: "moddg",
        about: "the paper's modified discrete gradient, solved to rounding",
        local_order: Order::each([2, 2, 2]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Sweeps(1),
        needs: Needs::OneDegree,
        sources: &[KOBUS],
        form: Form::Fixed(&ModDg::newton()),
    },
    Row {
        name: "moddg-fixed-point",
        about: "moddg solved by fixed-point iteration, as the paper does",
        local_order: Order::each([2, 2, 2]),
        keeps_k: true,
        passive: true,
        a_stable: false,
        l_stable: false,
        cost: Cost::Sweeps(1),
        needs: Needs::OneDegree,
        sources: &[KOBUS],
        form: Form::Fixed(&ModDg { steps: Plain, solver: FixedPoint }),
    },
    raised("moddg-q3-shared", [3, 2, 2], &Raised(Shared(Q), Third)),
    raised("moddg-q4-shared", [3, 2, 2], &Raised(Shared(Q), Fourth)),
    raised("moddg-p3-shared", [2, 3, 2], &Raised(Shared(P), Third)),
    raised("moddg-p4-shared", [2, 3, 2], &Raised(Shared(P), Fourth)),
    raised("moddg-q3-single", [3, 2, 2], &Raised(Single(Q), Third)),
    raised("moddg-q4-single", [3, 2, 2], &Raised(Single(Q), Fourth)),
    raised("moddg-p3-single", [2, 3, 2], &Raised(Single(P), Third)),
    raised("moddg-p4-single", [2, 3, 2], &Raised(Single(P), Fourth)),
    raised("moddg-qp3", [3, 3, 2], &Raised(Each, Third)),
    raised("moddg-qp4", [4, 4, 2], &Raised(Each, Fourth)),
    printed("moddg-q4-shared-printed", [3, 2, 2], &Printed(Shared(Q), Fourth)),
    printed("moddg-q4-single-printed", [3, 2, 2], &Printed(Single(Q), Fourth)),
    printed("moddg-p3-shared-printed", [2, 2, 2], &Printed(Shared(P), Third)),
    printed("moddg-p3-single-printed", [2, 2, 2], &Printed(Single(P), Third)),
    printed("moddg-p4-shared-printed", [2, 2, 2], &Printed(Shared(P), Fourth)),
    printed("moddg-p4-single-printed", [2, 2, 2], &Printed(Single(P), Fourth)),
    increment(
        "increment-1",
        [2, 1, 1],
        1,
        true,
        "coordinate increments: one sweep",
        &[ITOH_ABE],
        &Increments(Composition::sweep),
    ),
    increment(
        "increment-2",
        [2; 3],
        2,
        true,
        "coordinate increments: a sweep and its adjoint",
        &[ITOH_ABE],
        &Increments(Composition::pair),
    ),
    increment(
        "increment-4",
        [4; 3],
        10,
        false,
        "coordinate increments, 5 pairs of sweeps (Suzuki)",
        &[ITOH_ABE, SUZUKI],
        &Increments(Composition::suzuki4),
    ),
    increment(
        "increment-6",
        [6; 3],
        14,
        false,
        "coordinate increments, 7 pairs of sweeps (Yoshida)",
        &[ITOH_ABE, YOSHIDA],
        &Increments(Composition::yoshida6),
    ),
    increment(
        "increment-8",
        [8; 3],
        34,
        false,
        "coordinate increments, 17 pairs of sweeps (Kahan, Li)",
        &[ITOH_ABE, KAHAN_LI],
        &Increments(Composition::kahan_li8),
    ),
    Row {
        name: "adaptive-collocation",
        about: "Gauss collocation of order 8 or 16, its steps and K by the tolerance",
        local_order: Order::each([8; 3]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Nodes,
        needs: Needs::Curvature,
        sources: &[BUTCHER, HAIRER_LUBICH_WANNER_2006],
        form: Form::Adaptive(&AdaptiveCollocation),
    },
    explicit(
        "adaptive-dop853",
        "DOP853, its steps and K by the tolerance",
        8,
        12,
        &[HAIRER_NORSETT_WANNER, HAIRER_LUBICH_WANNER_2006],
        &AdaptiveDop853,
    ),
    explicit(
        "adaptive-verner98",
        "Verner's pair 9(8), its steps and K by the tolerance",
        9,
        16,
        &[VERNER, HAIRER_LUBICH_WANNER_2006],
        &AdaptiveVerner98,
    ),
    explicit(
        "adaptive-verner87",
        "Verner's pair 8(7), its steps and K by the tolerance",
        8,
        13,
        &[VERNER, HAIRER_LUBICH_WANNER_2006],
        &AdaptiveVerner87,
    ),
    // On linear passive systems H ≥ 0 cannot grow, whatever the step: no Δw is negative, and K is
    // exact. The step before K is restored is L-stable; the projection may give energy back.
    Row {
        name: "adaptive-radau",
        about: "Radau IIA of order 5, 9 or 13, its steps and K by the tolerance",
        local_order: Order::each([5; 3]),
        keeps_k: true,
        passive: true,
        a_stable: true,
        l_stable: false,
        cost: Cost::Stages,
        needs: Needs::Curvature,
        sources: &[HAIRER_WANNER_1996, HAIRER_WANNER_1999, HAIRER_LUBICH_WANNER_2006],
        form: Form::Adaptive(&AdaptiveRadau),
    },
];

/// The methods with a fixed step.
pub static FIXED: &[Row] = METHODS.split_at(steps()).0;

/// The methods with a tolerance. All of them need second derivatives of H. The implicit ones also
/// suit stiff systems.
pub static ADAPTIVE: &[Row] = METHODS.split_at(steps()).1;

/// Finds the row of a method by its name.
pub fn find(name: &str) -> Option<&'static Row> {
    METHODS.iter().find(|row| row.name == name)
}

/// The number of rows with a fixed step.
const fn steps() -> usize {
    let mut count = 0;
    while count < METHODS.len() && !METHODS[count].is_adaptive() {
        count += 1;
    }
    count
}
