//! Every system here is what it says it is, at states and with parameters of many orders of
//! magnitude.

use afterbay_core::{Curvature, InputError, Separable, Uniform, validate};
use afterbay_systems::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, MorseChain,
    VanDerPol, VanDerPolRing,
};
use proptest::prelude::*;

/// Numbers of either sign between 1e-12 and `10^largest`, and 0.
fn number(largest: f64) -> impl Strategy<Value = f64> {
    let any = (-12.0..largest, prop::bool::ANY)
        .prop_map(|(x, up)| (if up { 1.0 } else { -1.0 }) * 10f64.powf(x));
    prop_oneof![12 => any, 1 => Just(0.0)]
}

fn positive(decades: f64) -> impl Strategy<Value = f64> {
    (-decades..decades).prop_map(|x| 10f64.powf(x))
}

/// Up to `n` of them, all of one size or each of its own.
fn numbers(n: usize, largest: f64) -> impl Strategy<Value = Vec<f64>> {
    let similar = (number(largest), prop::collection::vec(-1.0..1.0_f64, n))
        .prop_map(|(size, shares)| shares.into_iter().map(|share| share * size).collect());
    prop_oneof![prop::collection::vec(number(largest), n), similar]
}

/// Whether the energies and forces at a state are numbers at all is not the system's fault.
fn good(outcome: Result<(), InputError>) -> Result<(), TestCaseError> {
    prop_assert!(outcome.is_ok(), "{}", outcome.unwrap_err());
    Ok(())
}

fn separable<S: Separable<f64>>(
    system: Result<S, InputError>,
    q: &[f64],
    p: &[f64],
) -> Result<(), TestCaseError> {
    let system = system.unwrap();
    good(validate::separable(&system, &q[..system.dof()], &p[..system.dof()]))
}

fn uniform<S: Uniform>(
    system: Result<S, InputError>,
    q: &[f64],
    p: &[f64],
) -> Result<(), TestCaseError> {
    let system = system.unwrap();
    good(validate::uniform(&system, &q[..system.dof()], &p[..system.dof()]))
}

fn curvature<S: Curvature<f64>>(
    system: Result<S, InputError>,
    q: &[f64],
    p: &[f64],
) -> Result<(), TestCaseError> {
    let system = system.unwrap();
    good(validate::curvature(&system, &q[..system.dof()], &p[..system.dof()]))
}

proptest! {
    #[test]
    fn one_degree_of_freedom(
        k in positive(9.0), x in number(6.0), y in number(6.0), z in number(6.0),
        q in number(9.0), p in number(9.0),
    ) {
        let (q, p) = (&[q], &[p]);
        separable(DampedOscillator::new(k, x), q, p)?;
        separable(Duffing::new(x, y, z), q, p)?;
        separable(VanDerPol::new(x), q, p)?;
        separable(ModifiedVanDerPol::new(x, y, z), q, p)?;
    }

    #[test]
    fn chain_and_ring(
        n in 1..12_usize, x in number(6.0), y in number(6.0),
        q in numbers(12, 9.0), p in numbers(12, 9.0),
    ) {
        uniform(FputChain::new(n, x, y), &q, &p)?;
        uniform(VanDerPolRing::new(n, x, y), &q, &p)?;
        curvature(FputChain::new(n, x, y), &q, &p)?;
        curvature(VanDerPolRing::new(n, x, y), &q, &p)?;
    }

    #[test]
    fn morse_chain(
        n in 1..12_usize, epsilon in number(6.0), a in 0.1..3.0_f64, c in number(6.0),
        q in prop::collection::vec(-2.0..2.0_f64, 12), p in numbers(12, 9.0),
    ) {
        separable(MorseChain::new(n, epsilon, a, c), &q[..n], &p[..n])?;
        curvature(MorseChain::new(n, epsilon, a, c), &q, &p)?;
    }

    #[test]
    fn double_pendulum(
        m in [positive(3.0), positive(3.0)], l in [positive(3.0), positive(3.0)], g in number(3.0),
        c in [number(3.0), number(3.0)], q in numbers(2, 6.0), p in numbers(2, 6.0),
    ) {
        curvature(DampedDoublePendulum::new(m, l, g, c), &q, &p)?;
    }
}

#[test]
fn linear_are_those_without_what_bends() {
    fn linear<S: Curvature<f64>>(system: S) -> bool {
        let at = [0.7, -0.4, 1.3];
        let at = &at[..system.dof()];
        assert_eq!(validate::curvature(&system, at, at), Ok(()));
        system.is_linear()
    }
    for (x, straight) in [(0.0, true), (-0.0, true), (0.5, false), (-1e-300, false)] {
        assert_eq!(linear(Duffing::new(2.0, x, 0.3).unwrap()), straight);
        assert_eq!(linear(VanDerPol::new(x).unwrap()), straight);
        assert_eq!(linear(ModifiedVanDerPol::new(x, 1.0, 0.0).unwrap()), straight);
        assert_eq!(linear(ModifiedVanDerPol::new(0.0, 1.0, x).unwrap()), straight);
        assert_eq!(linear(FputChain::new(3, x, 0.3).unwrap()), straight);
        assert_eq!(linear(VanDerPolRing::new(3, x, 0.3).unwrap()), straight);
    }
    assert!(linear(DampedOscillator::new(2.0, 0.3).unwrap()));
    assert!(!linear(DampedDoublePendulum::new([1.0; 2], [1.0; 2], 9.81, [0.0; 2]).unwrap()));
}
