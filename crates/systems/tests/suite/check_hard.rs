//! Honest systems that are not easy to believe: potentials with walls, kinks, narrow features, ends
//! and cancellation, and a Hamiltonian that is not separable.

use afterbay_core::{
    Block, Curvature, Dissipation, DissipationForm, InputError, Passive, Quantity, Separable,
    System, validate,
};
use proptest::prelude::*;

/// H = p²/2 + V(q), D = friction · v
#[derive(Clone, Copy)]
struct Well {
    v: fn(f64) -> f64,
    slope: fn(f64) -> f64,
}

impl System<f64> for Well {
    fn dof(&self) -> usize {
        1
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        p[0] * p[0] / 2.0 + (self.v)(q[0])
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        (hq[0], hp[0]) = ((self.slope)(q[0]), p[0]);
    }
    /// Dry friction, which jumps at rest.
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d[0] = if v[0] == 0.0 { 0.0 } else { 0.1 * v[0].signum() };
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::GENERAL }
    }
}

impl Separable<f64> for Well {
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        (self.slope)(at)
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], _j: usize) -> Dissipation<f64> {
        Dissipation {
            value: if p[0] == 0.0 { 0.0 } else { 0.1 * p[0].signum() },
            by_q: 0.0,
            by_p: 0.0,
        }
    }
}

const TAU: f64 = std::f64::consts::TAU;

/// Potentials written as a user would, with what they lose.
const WELLS: [(&str, Well); 13] = [
    ("pendulum", Well { v: |q| 9.81 * (1.0 - q.cos()), slope: |q| 9.81 * q.sin() }),
    ("lattice", Well { v: |q| -(TAU * q).cos(), slope: |q| TAU * (TAU * q).sin() }),
    ("Toda", Well { v: |q| q.exp() - q - 1.0, slope: |q| q.exp() - 1.0 }),
    (
        "Morse",
        Well {
            v: |q| (1.0 - (-q).exp()).powi(2),
            slope: |q| 2.0 * (1.0 - (-q).exp()) * (-q).exp(),
        },
    ),
    (
        "Lennard-Jones",
        Well {
            v: |q| 4.0 * (q.powi(-12) - q.powi(-6)),
            slope: |q| 4.0 * (6.0 * q.powi(-7) - 12.0 * q.powi(-13)),
        },
    ),
    ("logarithm", Well { v: |q| q - q.ln(), slope: |q| 1.0 - 1.0 / q }),
    ("cone", Well { v: f64::abs, slope: |q| if q == 0.0 { 0.0 } else { q.signum() } }),
    ("contact", Well { v: |q| 50.0 * q.max(0.0).powi(2), slope: |q| 100.0 * q.max(0.0) }),
    ("hyperbola", Well { v: |q| (1.0 + q * q).sqrt(), slope: |q| q / (1.0 + q * q).sqrt() }),
    (
        "bump",
        Well {
            v: |q| (-(q * 1e4).powi(2)).exp(),
            slope: |q| -2e8 * q * (-(q * 1e4).powi(2)).exp(),
        },
    ),
    (
        "ripple",
        Well { v: |q| q * q / 2.0 + 1e-6 * (1e3 * q).sin(), slope: |q| q + 1e-3 * (1e3 * q).cos() },
    ),
    ("offset", Well { v: |q| 1e10 + q * q / 2.0, slope: |q| q }),
    ("steep", Well { v: |q| q.powi(20), slope: |q| 20.0 * q.powi(19) }),
];

/// H = (1 + q1²/4) p1²/2 + p2²/2 + κ q1 p2 + (1 - cos(q1 - q2)), D = c (v1 + v2/2, v2 + v1/2).
struct Twisted {
    kappa: f64,
    c: f64,
    /// Added to ∂²H/∂q1∂p2.
    off: f64,
}

impl System<f64> for Twisted {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let kinetic = ((1.0 + q[0] * q[0] / 4.0) * p[0] * p[0] + p[1] * p[1]) / 2.0;
        kinetic + self.kappa * q[0] * p[1] + 1.0 - (q[0] - q[1]).cos()
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        let pull = (q[0] - q[1]).sin();
        (hq[0], hq[1]) = (q[0] * p[0] * p[0] / 4.0 + self.kappa * p[1] + pull, -pull);
        (hp[0], hp[1]) = ((1.0 + q[0] * q[0] / 4.0) * p[0], p[1] + self.kappa * q[0]);
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        (d[0], d[1]) = (self.c * (v[0] + v[1] / 2.0), self.c * (v[1] + v[0] / 2.0));
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::InSum, coupled: true, ..DissipationForm::GENERAL }
    }
}

impl Curvature<f64> for Twisted {
    fn curvature(&self, q: &[f64], p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        let bond = (q[0] - q[1]).cos();
        put(Block::Hqq, 0, 0, p[0] * p[0] / 4.0 + bond);
        put(Block::Hqq, 0, 1, -bond);
        put(Block::Hqq, 1, 0, -bond);
        put(Block::Hqq, 1, 1, bond);
        let (mixed, inverse) = (q[0] * p[0] / 2.0, 1.0 + q[0] * q[0] / 4.0);
        put(Block::Hqp, 0, 0, mixed);
        put(Block::Hqp, 0, 1, self.kappa + self.off);
        put(Block::Hpp, 0, 0, inverse);
        put(Block::Hpp, 1, 1, 1.0);
        for (i, [own, other]) in [[1.0, 0.5], [0.5, 1.0]].into_iter().enumerate() {
            put(Block::Dq, i, 0, self.c * (own * mixed + other * self.kappa));
            put(Block::Dp, i, 0, self.c * own * inverse);
            put(Block::Dp, i, 1, self.c * other);
        }
    }
}

/// Numbers of either sign from 1e-12 to 1e6, and 0.
fn number() -> impl Strategy<Value = f64> {
    let any = (-12.0..6.0_f64, prop::bool::ANY)
        .prop_map(|(x, up)| (if up { 1.0 } else { -1.0 }) * 10f64.powf(x));
    prop_oneof![12 => any, 1 => Just(0.0), 4 => -2.0..2.0_f64]
}

proptest! {
    #[test]
    fn wells(q in number(), p in number()) {
        for (name, well) in WELLS {
            let outcome = validate::separable(&well, &[q], &[p]);
            // Where V ends there is nothing to check.
            let ends = !((well.v)(q).is_finite() && (well.slope)(q).is_finite());
            let refused = matches!(outcome, Err(InputError::NotFinite { .. }));
            prop_assert!(outcome.is_ok() != ends && refused == ends, "{name}: {outcome:?}");
        }
    }

    #[test]
    fn lies_about_wells(q in -2.0..2.0_f64, p in number()) {
        // An energy of 1e10 hides what is 1e-3 of a displacement.
        for (name, well) in WELLS.into_iter().filter(|(name, _)| *name != "offset") {
            let other = Well { slope: |_| 0.123, ..well };
            let outcome = validate::system(&other, &[q], &[p.clamp(-10.0, 10.0)]);
            let caught = matches!(
                outcome,
                Err(InputError::Contradiction { quantity: Quantity::Slope, dof: 0, .. })
            );
            prop_assert!(caught || !(well.v)(q).is_finite(), "{name}: {outcome:?}");
        }
    }

    #[test]
    fn twisted(
        kappa in -2.0..2.0_f64, c in 0.0..2.0_f64,
        q in [number(), number()], p in [number(), number()],
    ) {
        prop_assert_eq!(validate::curvature(&Twisted { kappa, c, off: 0.0 }, &q, &p), Ok(()));
    }

    #[test]
    fn lies_about_the_twist(
        q in prop::array::uniform2(-2.0..2.0_f64), p in prop::array::uniform2(-2.0..2.0_f64),
    ) {
        let outcome = validate::curvature(&Twisted { kappa: 0.3, c: 0.1, off: 0.01 }, &q, &p);
        let caught = matches!(
            outcome,
            Err(InputError::ContradictionBetween { block: Block::Hqp, row: 0, column: 1, .. })
        );
        prop_assert!(caught, "{outcome:?}");
    }
}
