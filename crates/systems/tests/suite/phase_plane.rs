//! H along one angle or momentum: divided differences of H in 31 digits, derivatives by dual
//! numbers. The double pendulum in closed form, and the same given as text.

use afterbay_core::{Block, Curvature, Mean, PhasePlane, Quad, Scalar, System};
use afterbay_systems::{CustomGeneral, DampedDoublePendulum, DissipationText, GeneralDescription};
use num_dual::Dual64;
use proptest::prelude::*;
use std::sync::LazyLock;

/// A double pendulum in every scalar.
trait Pendulum {
    type Of<T: Scalar>: PhasePlane<T> + Curvature<T>;

    fn of<T: Scalar>() -> Self::Of<T>;
}

const MASSES: [f64; 2] = [1.3, 0.7];
const LENGTHS: [f64; 2] = [0.8, 1.1];
const GRAVITY: f64 = 9.81;
const FRICTION: [f64; 2] = [0.1, 0.2];

struct ClosedForm;

impl Pendulum for ClosedForm {
    type Of<T: Scalar> = DampedDoublePendulum<T>;

    fn of<T: Scalar>() -> DampedDoublePendulum<T> {
        let of = |x: [f64; 2]| x.map(T::from_f64);
        DampedDoublePendulum::new(of(MASSES), of(LENGTHS), T::from_f64(GRAVITY), of(FRICTION))
            .unwrap()
    }
}

struct Text;

static TEXT: LazyLock<CustomGeneral<f64>> = LazyLock::new(|| {
    let hamiltonian = "(m2*l2^2*p1^2 + (m1 + m2)*l1^2*p2^2 - 2*m2*l1*l2*cos(q1 - q2)*p1*p2) \
                       / (2*m2*l1^2*l2^2*(m1 + m2*sin(q1 - q2)^2)) \
                       + 2*(m1 + m2)*g*l1*sin(q1/2)^2 + 2*m2*g*l2*sin(q2/2)^2";
    let parameters = [
        ("m1", MASSES[0]),
        ("m2", MASSES[1]),
        ("l1", LENGTHS[0]),
        ("l2", LENGTHS[1]),
        ("g", GRAVITY),
        ("c1", FRICTION[0]),
        ("c2", FRICTION[1]),
    ];
    let description = GeneralDescription {
        hamiltonian: hamiltonian.into(),
        dissipation: DissipationText::Forces(vec!["c1*v1".into(), "c2*v2".into()]),
        parameters: parameters.map(|(name, value)| (name.into(), value)).into(),
        ..GeneralDescription::default()
    };
    CustomGeneral::new(&description).unwrap()
});

impl Pendulum for Text {
    type Of<T: Scalar> = CustomGeneral<T>;

    fn of<T: Scalar>() -> CustomGeneral<T> {
        TEXT.map(T::from_f64)
    }
}

/// The largest that the terms of H and of its slopes get.
fn size(p: [f64; 2]) -> f64 {
    let [p1, p2] = p.map(f64::abs);
    40.0 + 4.0 * (p1 + p2).powi(2)
}

fn close(found: f64, exact: f64, bound: f64) -> Result<(), TestCaseError> {
    prop_assert!(
        (found - exact).abs() <= bound,
        "{found} {exact}: {:.1} of the bound",
        (found - exact).abs() / bound
    );
    Ok(())
}

/// Is this the mean of the slope of H from one end to the other, with the derivatives by the end
/// and the variable held?
fn is_the_mean(
    found: Mean<f64>,
    exact: impl Fn(Quad, Quad) -> Quad,
    dual: impl Fn(Dual64, Dual64) -> Mean<Dual64>,
    [from, to, held]: [f64; 3],
    size: f64,
) -> Result<(), TestCaseError> {
    let width = (Quad::from_f64(to) - Quad::from_f64(from)).0.abs();
    if width > 0.0 {
        let quotient = exact(Quad::from_f64(to), Quad::from_f64(held))
            - exact(Quad::from_f64(from), Quad::from_f64(held));
        let quotient = quotient / (Quad::from_f64(to) - Quad::from_f64(from));
        // H itself is known to 1e-30 only.
        close(found.value, quotient.0, 16.0 * f64::EPSILON * size + 1e-29 * size / width)?;
    }
    close(found.by_end, dual(Dual64::new(to, 1.0), Dual64::from(held)).value.eps, 1e-8 * size)?;
    close(found.by_other, dual(Dual64::from(to), Dual64::new(held, 1.0)).value.eps, 1e-12 * size)
}

type Pair = [f64; 2];

fn means_are_divided_differences<P: Pendulum>(
    q: Pair,
    p: Pair,
    j: usize,
    width: f64,
) -> Result<(), TestCaseError> {
    let energy = |at: [Quad; 2]| {
        let (mut q, mut p) = (q.map(Quad::from_f64), p.map(Quad::from_f64));
        (q[j], p[j]) = (at[0], at[1]);
        P::of::<Quad>().energy(&q, &p)
    };
    let (dual_q, dual_p) = (q.map(Dual64::from), p.map(Dual64::from));
    let system = P::of::<f64>();
    for width in [0.0, width] {
        let (to, size) = (q[j] + width, size(p));
        is_the_mean(
            system.along_q(&q, &p, j, [q[j], to], p[j]),
            |q, p| energy([q, p]),
            |to, p| P::of().along_q(&dual_q, &dual_p, j, [dual_q[j], to], p),
            [q[j], to, p[j]],
            size,
        )?;
        let to = p[j] + width;
        let size = size.max(self::size([to, p[1 - j]]));
        is_the_mean(
            system.along_p(&q, &p, j, q[j], [p[j], to]),
            |p, q| energy([q, p]),
            |to, q| P::of().along_p(&dual_q, &dual_p, j, q, [dual_p[j], to]),
            [p[j], to, q[j]],
            size,
        )?;
    }
    Ok(())
}

fn slopes_are_entries<P: Pendulum>(q: Pair, p: Pair, j: usize) -> Result<(), TestCaseError> {
    let system = P::of::<f64>();
    let (mut hq, mut hp) = ([0.0; 2], [0.0; 2]);
    system.gradient(&q, &p, &mut hq, &mut hp);
    let at = [q[j], p[j]];
    let mut elsewhere = (q, p);
    (elsewhere.0[j], elsewhere.1[j]) = (7.0, 7.0);
    let slopes = system.slopes(&elsewhere.0, &elsewhere.1, j, at);
    close(slopes.hq, hq[j], 1e-15 * size(p))?;
    close(slopes.hp, hp[j], 1e-15 * size(p))?;
    let mut seen = 0;
    let mut off = 0.0_f64;
    system.curvature(&q, &p, |block, row, column, value| {
        let found = match block {
            Block::Hqq => slopes.hqq,
            Block::Hqp => slopes.hqp,
            Block::Hpp => slopes.hpp,
            Block::Dq | Block::Dp => return,
        };
        if (row, column) == (j, j) {
            seen += 1;
            off = off.max((found - value).abs());
        }
    });
    prop_assert!(seen == 3 && off <= 1e-14 * size(p), "{seen} {off:e}");
    // On a short edge the closed form is what quadrature gives.
    let edge = system.along_q(&q, &p, j, [q[j], q[j] + 0.1], p[j]);
    let slopes = |at, share| {
        let slopes = system.slopes(&q, &p, j, [at, p[j]]);
        [slopes.hq, share * slopes.hqq, slopes.hqp]
    };
    let [value, by_end, by_other] = afterbay_core::quadrature::mean(q[j], q[j] + 0.1, slopes);
    close(edge.value, value, 1e-14 * size(p))?;
    close(edge.by_end, by_end, 1e-12 * size(p))?;
    close(edge.by_other, by_other, 1e-14 * size(p))?;
    let mut d = [0.0; 2];
    system.dissipation(&q, &p, &p, &mut d);
    let found = system.plane_dissipation(&q, &p, j, at, p[j]);
    prop_assert!(found.value == d[j] && found.by_v * p[j] == d[j]);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(1000)
    })]

    #[test]
    fn means_are_divided_differences_of_h(
        q in prop::array::uniform2(-4.0..4.0), p in prop::array::uniform2(-5.0..5.0),
        j in 0..2_usize, side in -1.0..1.0_f64, exponent in -9.0..1.5_f64,
    ) {
        let width = side.signum() * 10.0_f64.powf(exponent);
        means_are_divided_differences::<ClosedForm>(q, p, j, width)?;
        means_are_divided_differences::<Text>(q, p, j, width)?;
    }

    #[test]
    fn slopes_are_the_entries_of_the_gradient_and_the_curvature(
        q in prop::array::uniform2(-4.0..4.0), p in prop::array::uniform2(-5.0..5.0),
        j in 0..2_usize,
    ) {
        slopes_are_entries::<ClosedForm>(q, p, j)?;
        slopes_are_entries::<Text>(q, p, j)?;
    }
}
