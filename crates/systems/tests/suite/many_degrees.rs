//! The derivatives of systems with many degrees of freedom, against dual numbers; their
//! edges, against divided differences of 31 digits; and of who acts on whom.

use afterbay_core::{Block, Coupling, Curvature, Quad, Scalar, Separable, System};
use afterbay_systems::{
    DampedDoublePendulum, DampedOscillator, Duffing, FputChain, ModifiedVanDerPol, MorseChain,
    VanDerPol, VanDerPolRing,
};
use num_dual::Dual64;
use proptest::prelude::*;

/// A few roundings of `size`.
fn assert_close(found: f64, exact: f64, size: f64) {
    assert!((found - exact).abs() <= 8.0 * f64::EPSILON * size, "{found} {exact}, of size {size}");
}

/// ∂H/∂q, ∂H/∂p and D.
fn fields<T: Scalar>(system: &impl System<T>, q: &[T], p: &[T]) -> [Vec<T>; 3] {
    let [mut hq, mut hp, mut d] = [0; 3].map(|_| vec![T::zero(); q.len()]);
    system.gradient(q, p, &mut hq, &mut hp);
    system.dissipation(q, p, &hp, &mut d);
    [hq, hp, d]
}

/// The vector with the derivative 1 in the entry j, if there is one.
fn along(x: &[f64], j: Option<usize>) -> Vec<Dual64> {
    let entry = |(i, &x)| Dual64::new(x, if Some(i) == j { 1.0 } else { 0.0 });
    x.iter().enumerate().map(entry).collect()
}

type Entries = Vec<(Block, usize, usize, f64)>;

fn entries(system: &impl Curvature<f64>, q: &[f64], p: &[f64]) -> Entries {
    let mut entries = Vec::new();
    system.curvature(q, p, |block, i, j, x| entries.push((block, i, j, x)));
    entries
}

/// The entries by dual numbers, all of them, ∂²H/∂q∂p both ways round.
fn exact_entries(system: &impl System<Dual64>, q: &[f64], p: &[f64]) -> Entries {
    let mut entries = Vec::new();
    for j in 0..q.len() {
        let by_q = fields(system, &along(q, Some(j)), &along(p, None));
        let by_p = fields(system, &along(q, None), &along(p, Some(j)));
        for i in 0..q.len() {
            entries.push((Block::Hqq, i, j, by_q[0][i].eps));
            entries.push((Block::Hqp, j, i, by_q[1][i].eps));
            entries.push((Block::Dq, i, j, by_q[2][i].eps));
            entries.push((Block::Hqp, i, j, by_p[0][i].eps));
            entries.push((Block::Hpp, i, j, by_p[1][i].eps));
            entries.push((Block::Dp, i, j, by_p[2][i].eps));
        }
    }
    entries
}

/// Do i and j act on each other, by the definition of the pattern?
fn coupled(coupling: &Coupling, n: usize, i: usize, j: usize) -> bool {
    match coupling {
        Coupling::Chain => i.abs_diff(j) <= 1,
        Coupling::Ring => i.abs_diff(j) <= 1 || i.abs_diff(j) == n - 1,
        Coupling::Dense => true,
    }
}

fn derivatives_are_right<S, L>(system: &S, dual: &L, q: &[f64], p: &[f64], size: f64)
where
    S: Curvature<f64>,
    L: Curvature<Dual64>,
{
    let n = system.dof();
    let [hq, hp, _] = fields(system, q, p);
    for j in 0..n {
        assert_close(hq[j], dual.energy(&along(q, Some(j)), &along(p, None)).eps, size);
        assert_close(hp[j], dual.energy(&along(q, None), &along(p, Some(j))).eps, size);
    }

    let found = entries(system, q, p);
    let of = |block: Block, i: usize, j: usize| {
        let mut entries = found.iter().filter(|x| (x.0, x.1, x.2) == (block, i, j)).map(|x| x.3);
        let entry = entries.next();
        assert_eq!(entries.next(), None, "{block:?} {i} {j} is given twice");
        entry
    };
    for (block, i, j, exact) in exact_entries(dual, q, p) {
        match of(block, i, j) {
            Some(entry) => assert_close(entry, exact, size),
            None => assert_eq!(exact, 0.0, "{block:?} {i} {j} is missing"),
        }
    }
    // The pattern has a place for every entry, and no place that stays empty.
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let present = found.iter().any(|x| (x.1, x.2) == (i, j));
        assert_eq!(present, coupled(&system.coupling(), n, i, j), "{i} {j} of {n}");
        assert!(!present || of(Block::Hqq, i, j).is_some_and(|x| x != 0.0), "{i} {j} of {n}");
    }
    // The same entries elsewhere, rest included.
    let places =
        |entries: Entries| entries.into_iter().map(|x| (x.0, x.1, x.2)).collect::<Vec<_>>();
    let rest = vec![0.0; n];
    assert_eq!(places(entries(system, &rest, &rest)), places(found));
}

/// ∂V/∂q_j, its means and D_j, with q_j moved to `to`.
fn separable_parts_are_right<S, L, M>(
    system: (&S, &L, &M),
    q: &[f64],
    p: &[f64],
    to: f64,
    size: f64,
) where
    S: Separable<f64>,
    L: Separable<Dual64>,
    M: Separable<Quad>,
{
    let (plain, dual, quad) = system;
    let [hq, _, d] = fields(plain, q, p);
    let lift = |x: &[f64]| x.iter().map(|&x| Quad::from_f64(x)).collect::<Vec<_>>();
    let (start, rest) = (lift(q), vec![Quad::ZERO; q.len()]);
    for j in 0..q.len() {
        let moved: Vec<f64> =
            q.iter().enumerate().map(|(i, &x)| if i == j { to } else { x }).collect();
        assert_eq!(plain.partial(q, j, q[j]), hq[j]);
        assert_eq!(plain.partial(q, j, to), fields(plain, &moved, p)[0][j]);
        assert_close(plain.divided_difference(q, j, q[j]).value, hq[j], size);

        let edge = plain.divided_difference(q, j, to);
        let (end, width) = (lift(&moved), Quad::from_f64(to) - Quad::from_f64(q[j]));
        let (exact, blur) = if to == q[j] {
            (quad.partial(&start, j, start[j]), 0.0)
        } else {
            // V itself is known to 1e-31 only, and its divided difference to that over the width.
            let quotient = (quad.energy(&end, &rest) - quad.energy(&start, &rest)) / width;
            (quotient, 1e-29 * size * size / width.0.abs())
        };
        assert!(
            (edge.value - exact.0).abs() <= 8.0 * f64::EPSILON * size + blur,
            "{j}: {edge:?} {exact:?} of size {size}"
        );
        let line = dual.divided_difference(&along(q, None), j, Dual64::new(to, 1.0)).value;
        assert_close(line.re, edge.value, size);
        assert_close(edge.slope, line.eps, size);

        let drag = plain.dissipation_of(q, p, j);
        assert_close(drag.value, d[j], size);
        assert_close(drag.by_q, fields(dual, &along(q, Some(j)), &along(p, None))[2][j].eps, size);
        assert_close(drag.by_p, fields(dual, &along(q, None), &along(p, Some(j)))[2][j].eps, size);
    }
}

fn numbers(reach: f64) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-reach..reach, 20)
}

/// More than the sum of the absolute values of the terms of any field and its derivatives, V of the
/// third power.
fn size(parameters: [f64; 2], q: &[f64], p: &[f64], to: f64) -> f64 {
    let largest = |x: &[f64]| x.iter().fold(1.0, |max: f64, x| max.max(x.abs()));
    let [x, y] = parameters.map(f64::abs);
    let reach = largest(q).max(to.abs());
    (1.0 + 4.0 * x) * (1.0 + 4.0 * y) * (2.0 * reach).powi(3).max(reach * reach * largest(p))
}

macro_rules! check_separable {
    ($system:expr, $q:expr, $p:expr, $ends:expr, $parameters:expr) => {{
        let system = $system.unwrap();
        let (n, dual, quad) =
            (system.dof(), system.map(Dual64::from_f64), system.map(Quad::from_f64));
        let (q, p) = (&$q[..n], &$p[..n]);
        derivatives_are_right(&system, &dual, q, p, size($parameters, q, p, 0.0));
        for to in $ends {
            let size = size($parameters, q, p, to);
            separable_parts_are_right((&system, &dual, &quad), q, p, to, size);
        }
    }};
}

proptest! {
    #[test]
    fn chain_and_ring(
        n in 1..21_usize, x in -2.0..2.0_f64, y in -2.0..2.0_f64,
        q in numbers(3.0), p in numbers(3.0), to in -3.0..3.0_f64, digits in 0..16_i32,
    ) {
        prop_assume!(y.abs() > 1e-3);
        // Long edges, short ones down to a rounding, none at all, and one to a neighbour.
        let ends = [to, q[0] + (to - q[0]) * 10f64.powi(-digits), q[0], -q[0], q[n / 2]];
        check_separable!(FputChain::new(n, x, y), q, p, ends, [x, y]);
        check_separable!(VanDerPolRing::new(n, x, y), q, p, ends, [x, y]);
    }

    #[test]
    fn morse_chain(
        n in 1..21_usize, epsilon in -2.0..2.0_f64, a in 0.1..1.5_f64, c in -2.0..2.0_f64,
        q in numbers(2.0), p in numbers(3.0),
    ) {
        prop_assume!(epsilon.abs() > 1e-3);
        let system = MorseChain::new(n, epsilon, a, c).unwrap();
        let (q, p) = (&q[..n], &p[..n]);
        // Compressed by 4, a bond has e^{8a} in its force, with the rounding of its exponent.
        let growth = (1.0 + 8.0 * a) * (8.0 * a).exp();
        let size = 8.0 * epsilon.abs() * (1.0 + a).powi(2) * growth + 3.0 * (1.0 + c.abs());
        derivatives_are_right(&system, &system.map(Dual64::from_f64), q, p, size);
    }

    #[test]
    fn one_degree_of_freedom(
        x in 0.1..2.0_f64, y in -2.0..2.0_f64, z in -2.0..2.0_f64,
        q in -3.0..3.0_f64, p in -3.0..3.0_f64,
    ) {
        let (q, p) = (&[q], &[p]);
        let size = size([x, y], q, p, 0.0) * (1.0 + z.abs());
        macro_rules! check {
            ($($system:expr),*) => {$({
                let system = $system.unwrap();
                derivatives_are_right(&system, &system.map(Dual64::from_f64), q, p, size);
            })*};
        }
        check!(DampedOscillator::new(x, y), Duffing::new(x, y, z));
        check!(VanDerPol::new(y), ModifiedVanDerPol::new(z, x, y));
    }

    #[test]
    fn double_pendulum(
        m1 in 0.2..3.0_f64, m2 in 0.2..3.0_f64, l1 in 0.2..3.0_f64, l2 in 0.2..3.0_f64,
        g in 0.1..20.0_f64, c1 in -2.0..2.0_f64, c2 in -2.0..2.0_f64,
        q in numbers(4.0), p in numbers(3.0),
    ) {
        let system = DampedDoublePendulum::new([m1, m2], [l1, l2], g, [c1, c2]).unwrap();
        let (q, p) = (&q[..2], &p[..2]);
        // The largest entry of M⁻¹, of the velocities, and what they make of B = m2 l1 l2.
        let inverse = (1.0 / (m1 * l1 * l1)).max((m1 + m2) / (m1 * m2 * l2 * l2));
        let v = inverse * (p[0].abs() + p[1].abs());
        let whirl = m2 * l1 * l2 * v * (1.0 + v) * (1.0 + 4.0 * m2 * l1 * l2 * inverse);
        let size = (1.0 + c1.abs() + c2.abs()) * (inverse + v + 4.0 * whirl * (1.0 + inverse))
            + (m1 + m2) * g * l1 + m2 * g * l2;
        derivatives_are_right(&system, &system.map(Dual64::from_f64), q, p, size);
    }
}
