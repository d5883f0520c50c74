//! δ of every system against its definition: the exact solution, put into the discrete equations.

use afterbay_core::{OrderRaising, Quad, Scalar, Series, State, System, taylor::Expansion};
use afterbay_systems::{DampedOscillator, Duffing, ModifiedVanDerPol, VanDerPol};

/// What is left of `Δq/p̄` and of `-Δp/(ΔV/Δq + D̄)` over the step h without `h + δ₃h³ + δ₄h⁴`.
fn remainders<S, L>(system: &S, lifted: &L, h: f64) -> [f64; 2]
where
    S: OrderRaising<Quad>,
    L: System<Series<Quad, 14>>,
{
    let (h, q, p) = (Quad::from_f64(h), Quad::from_f64(1.3), Quad::from_f64(-0.8));
    let start = State::new([q], [p]).unwrap();
    let end = Expansion::about(lifted, &start).at(h);
    let (q_mean, p_mean) = ((start.q[0] + end.q[0]).half(), (start.p[0] + end.p[0]).half());
    let force = system.divided_difference(&start.q, 0, end.q[0]).value
        + system.dissipation_of(&[q_mean], &[p_mean], 0).value;
    [
        (end.q[0] - start.q[0]) / p_mean - system.delta_q(q, p).step4(h),
        (start.p[0] - end.p[0]) / force - system.delta_p(q, p).step4(h),
    ]
    .map(|x| x.0.abs())
}

macro_rules! assert_fifth_order {
    ($($system:expr),*) => {$({
        let system = $system.unwrap().map(Quad::from_f64);
        let lifted = system.map(Series::constant);
        let [long, short] = [2e-3, 1e-3].map(|h| remainders(&system, &lifted, h));
        for i in 0..2 {
            let order = (long[i] / short[i]).log2();
            assert!((order - 5.0).abs() < 0.05, "{} {i}: {long:?} {short:?}", stringify!($system));
        }
    })*};
}

#[test]
fn delta_leaves_the_fifth_power_of_the_step() {
    assert_fifth_order!(
        DampedOscillator::new(1.0, 0.1),
        DampedOscillator::new(2.5, -3.0),
        DampedOscillator::new(0.7, 0.0),
        Duffing::new(-1.0, 0.7, -0.3),
        VanDerPol::new(1.5),
        ModifiedVanDerPol::new(0.4, -1.0, 0.5)
    );
}
