//! Friction with a skew part that depends on q: under increments K, the orders and passivity hold.

use crate::many::orders::orders_at_end;
use crate::many::{exact_end, start};
use afterbay_core::{
    Dissipation, DissipationForm, Method, Passive, Scalar, Separable, System, integrate,
};
use afterbay_methods::{Composition, Increment};
use proptest::prelude::*;

const PASSIVE: DissipationForm =
    DissipationForm { zero: false, passive: Passive::InSum, linear: true, coupled: true };

/// Three masses on springs with D = R(q) p, R = A Aᵀ + s(q) S: S is skew and s vanishes at q = 0.
#[derive(Clone, Debug)]
struct Gyre {
    shape: [[f64; 3]; 3],
    skew: [f64; 3],
}

impl Gyre {
    fn resistance<T: Scalar>(&self, q: &[T], i: usize, j: usize) -> T {
        let even: f64 = (0..3).map(|k| self.shape[i][k] * self.shape[j][k]).sum();
        let [a, b, c] = self.skew;
        let odd = [[0.0, a, b], [-a, 0.0, c], [-b, -c, 0.0]][i][j];
        (q[0] + q[1] * q[2]).mul_add(T::from_f64(odd), T::from_f64(even))
    }
}

impl<T: Scalar> System<T> for Gyre {
    fn dof(&self) -> usize {
        3
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let spring = |q: T| (q * q).half() * ((q * q).half() + T::one());
        (0..3).fold(T::zero(), |sum, j| sum + (p[j] * p[j]).half() + spring(q[j]))
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (0..3).for_each(|j| hq[j] = self.partial(q, j, q[j]));
        hp.copy_from_slice(p);
    }
    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        (0..3).for_each(|j| d[j] = self.dissipation_of(q, v, j).value);
    }
    fn dissipation_form(&self) -> DissipationForm {
        PASSIVE
    }
}

impl<T: Scalar> Separable<T> for Gyre {
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at * (at * at + T::one())
    }
    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let value = (0..3).fold(T::zero(), |sum, k| self.resistance(q, j, k).mul_add(p[k], sum));
        Dissipation { value, by_q: T::zero(), by_p: self.resistance(q, j, j) }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(200)
    })]

    /// A skew part of R does no work, however large it is: H never grows, K is conserved, and Σ w_j
    /// does not decrease.
    #[test]
    fn a_skew_part_exerts_no_power(
        shape in prop::array::uniform3(prop::array::uniform3(-0.5..0.5_f64)),
        skew in prop::array::uniform3(-1.0..1.0_f64),
        size in 0.0..3.0_f64,
        q in prop::array::uniform3(-2.0..2.0_f64),
        p in prop::array::uniform3(-2.0..2.0_f64),
        h in 0.01..1.0_f64,
    ) {
        let gyre = Gyre { shape, skew: skew.map(|x| x * 10_f64.powf(size)) };
        let (system, mut state): (&dyn Separable<f64>, _) = (&gyre, start([&q, &p]));
        let method = Increment::new(Composition::pair());
        let mut workspace = method.workspace(system).unwrap();
        let start = state.energy(system);
        for _ in 0..50 {
            let (before, filled) = (state.energy(system), state.w.iter().sum::<f64>());
            prop_assert!(method.step(system, h, &mut state, &mut workspace).is_ok());
            let after = state.energy(system);
            // |w_j| may be as large as the energy that S moves between the reservoirs.
            let sizes = start + state.w.iter().map(|w| w.abs()).sum::<f64>();
            let powers: f64 = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| {
                gyre.resistance(&[4.0 * start + 2.0; 3], i, j).abs() * 2.0 * start
            }).sum();
            let bound = 64.0 * f64::EPSILON * (sizes + h * powers);
            prop_assert!(after <= before + bound, "H grows from {} to {}", before, after);
            prop_assert!(state.w.iter().sum::<f64>() >= filled - bound);
            let drift = state.total(system) - start;
            prop_assert!(drift.abs() <= 50.0 * bound, "{drift:e}");
        }
    }
}

/// The orders of q, p and w at t = 1 with a skew part, against Taylor series.
#[test]
fn a_skew_part_costs_no_order() {
    let gyre = Gyre {
        shape: [[0.4, -0.3, 0.1], [0.2, 0.5, -0.4], [-0.3, 0.1, 0.4]],
        skew: [2.0, -1.5, 3.0],
    };
    let begin = start([&[0.8, -0.3, 0.5], &[0.2, 0.9, -0.7]]);
    let (system, exact): (&dyn Separable<f64>, _) = (&gyre, exact_end(&gyre, &begin, 1.0));
    for (composition, order, counts) in [
        (Composition::pair(), 2.0, [400, 800, 1600]),
        (Composition::suzuki4(), 4.0, [80, 120, 160]),
    ] {
        let method = Increment::new(composition);
        let found = orders_at_end(&exact, &counts, &mut |grid| {
            let mut state = begin.clone();
            integrate(&method, system, grid, &mut state, &mut ()).unwrap();
            state
        });
        println!("{order} {found:.3?}");
        assert!(found.iter().all(|found| (found - order).abs() < 0.1), "{found:?}");
    }
}
