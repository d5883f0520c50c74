//! A system that lies about itself, each lie caught by name.

use crate::caught::*;
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, DissipationForm, InputError, Line, Passive, Quantity,
    Separable, System, validate,
};

/// What the system below says that is not so.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lie {
    None,
    Length,
    EnergyOfNoNumber,
    GradientOfNoNumber,
    DissipationOfNoNumber,
    SlopeOffBy(f64),
    SlopeOfAnother,
    Velocity,
    Zero,
    PassiveEach,
    PassiveInSum,
    Linear,
    Affine,
    Chain,
    ChainOfDrags,
    Partial,
    EdgeOffBy(f64),
    EdgeIsPartial,
    EdgeByQuotient,
    EdgeOfNoNumberAtRest,
    NoMass,
    OtherMass,
    DragValue,
    DragByMomentum,
    DragOfOtherMomenta,
    Entry(Block, f64),
    EntryMissing,
    EntryTwice,
    EntryOutside,
    EntryNowhere,
    EntryOfNoNumber,
    EntriesThatCome,
    EntriesThatStay,
}

/// H = Σ [p_j²/(2 m_j) + 1 - cos q_j] + Σ (q_{j+1} - q_j)⁴/4, m_j = 1 + j/2, D_j = c (1 + q_j²)
/// v_j, c = 0.3.
struct Told(Lie);

impl Told {
    fn m(j: usize) -> f64 {
        1.0 + j as f64 / 2.0
    }
    fn beside(q: &[f64], j: usize) -> impl Iterator<Item = f64> {
        [j.checked_sub(1), Some(j + 1)].into_iter().flatten().filter_map(|i| q.get(i).copied())
    }
    fn force(q: &[f64], j: usize, at: f64) -> f64 {
        at.sin() + Self::beside(q, j).map(|other| (at - other).powi(3)).sum::<f64>()
    }
    fn v(q: &[f64]) -> f64 {
        q.iter().map(|q| 1.0 - q.cos()).sum::<f64>()
            + q.windows(2).map(|r| (r[1] - r[0]).powi(4) / 4.0).sum::<f64>()
    }
    fn gamma(q: f64) -> f64 {
        0.3 * (1.0 + q * q)
    }
}

impl System<f64> for Told {
    fn dof(&self) -> usize {
        if self.0 == Lie::Length { N + 1 } else { N }
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let kinetic: f64 = p.iter().enumerate().map(|(j, p)| p * p / (2.0 * Self::m(j))).sum();
        let far = if self.0 == Lie::Chain { 0.1 * q[0] * q[3] } else { 0.0 };
        if self.0 == Lie::EnergyOfNoNumber { f64::NAN } else { kinetic + Self::v(q) + far }
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        for j in 0..N {
            (hq[j], hp[j]) = (Self::force(q, j, q[j]), p[j] / Self::m(j));
        }
        match self.0 {
            Lie::GradientOfNoNumber => hp[3] = f64::INFINITY,
            Lie::SlopeOffBy(off) => hq[2] *= 1.0 + off,
            Lie::SlopeOfAnother => hq[1] = Self::force(q, 2, q[2]),
            Lie::Velocity => hp[2] = p[2],
            Lie::Chain => (hq[0], hq[3]) = (hq[0] + 0.1 * q[3], hq[3] + 0.1 * q[0]),
            _ => {}
        }
    }
    fn dissipation(&self, q: &[f64], p: &[f64], v: &[f64], d: &mut [f64]) {
        (0..N).for_each(|j| d[j] = Self::gamma(q[j]) * v[j]);
        match self.0 {
            Lie::DissipationOfNoNumber => d[1] = f64::NAN,
            // Only where q2 is large, not at the state itself.
            Lie::PassiveEach if q[1] > 0.5 => d[1] = -0.1 * v[1],
            Lie::PassiveInSum => d[2] += 3.0 * v[0],
            Lie::Linear => d[3] += 0.01 * v[3] * v[3] * v[3],
            Lie::Affine => d[0] += 0.01,
            Lie::ChainOfDrags => d[3] += 0.1 * q[1],
            Lie::DragOfOtherMomenta => d[1] += 0.01 * p[0],
            _ => {}
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        let passive = match self.0 {
            Lie::PassiveEach | Lie::None => Passive::Each,
            Lie::PassiveInSum => Passive::InSum,
            _ => Passive::No,
        };
        let linear = !matches!(
            self.0,
            Lie::PassiveEach | Lie::ChainOfDrags | Lie::PassiveInSum | Lie::DragOfOtherMomenta
        );
        DissipationForm {
            zero: self.0 == Lie::Zero,
            passive,
            linear,
            coupled: self.0 == Lie::PassiveInSum,
        }
    }
    fn coupling(&self) -> Coupling {
        if self.0 == Lie::PassiveInSum { Coupling::Dense } else { Coupling::Chain }
    }
}

impl Separable<f64> for Told {
    fn mass(&self, j: usize) -> f64 {
        match (self.0, j) {
            (Lie::NoMass, 1) => -1.5,
            (Lie::OtherMass, 3) => 2.0,
            _ => Self::m(j),
        }
    }
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        // Forgets that the point is moved.
        if self.0 == Lie::Partial { Self::force(q, j, q[j]) } else { Self::force(q, j, at) }
    }
    fn divided_difference(&self, q: &[f64], j: usize, to: f64) -> Line<f64> {
        let from = q[j];
        let honest = afterbay_core::divided::by_quadrature(from, to, |at| Self::force(q, j, at));
        let value = match self.0 {
            Lie::EdgeOffBy(off) if j == 1 => honest.value * (1.0 + off),
            Lie::EdgeIsPartial => Self::force(q, j, (from + to) / 2.0),
            Lie::EdgeByQuotient if to != from => {
                let mut end = q.to_vec();
                end[j] = to;
                (Self::v(&end) - Self::v(q)) / (to - from)
            }
            Lie::EdgeOfNoNumberAtRest if to == from => f64::NAN,
            _ => honest.value,
        };
        Line { value, ..honest }
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        let by_p = Self::gamma(q[j]) / Self::m(j);
        let by_q = 0.6 * q[j] * p[j] / Self::m(j);
        match self.0 {
            Lie::DragValue => Dissipation { value: 0.9 * by_p * p[j], by_q, by_p },
            Lie::DragByMomentum => Dissipation { value: by_p * p[j], by_q, by_p: 1.0 },
            Lie::DragOfOtherMomenta if j == 1 => {
                Dissipation { value: by_p * p[j] + 0.01 * p[0], by_q, by_p }
            }
            _ => Dissipation { value: by_p * p[j], by_q, by_p },
        }
    }
}

impl Curvature<f64> for Told {
    fn curvature(&self, q: &[f64], p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        let mut tell = |block, i: usize, j: usize, x: f64| match self.0 {
            Lie::Entry(lie, off) if (lie, 2) == (block, i) => put(block, i, j, x * (1.0 + off)),
            Lie::EntryMissing if (block, i, j) == (Block::Hqq, 1, 2) => {}
            Lie::EntryTwice if (block, i, j) == (Block::Hpp, 0, 0) => {
                put(block, i, j, x / 2.0);
                put(block, i, j, x / 2.0);
            }
            Lie::EntryOutside if (block, i, j) == (Block::Dp, 3, 3) => {
                put(block, i, j, x);
                put(block, 3, 0, 0.0);
            }
            Lie::EntryNowhere if (block, i, j) == (Block::Dp, 3, 3) => put(block, usize::MAX, j, x),
            Lie::EntryOfNoNumber if (block, i, j) == (Block::Dq, 1, 1) => {
                put(block, i, j, f64::NAN);
            }
            Lie::EntriesThatCome if (block, i, j) == (Block::Dq, 0, 0) && q[0] < 0.5 => {}
            _ => put(block, i, j, x),
        };
        for j in 0..N {
            let own: f64 = Self::beside(q, j).map(|other| 3.0 * (q[j] - other).powi(2)).sum();
            tell(Block::Hqq, j, j, q[j].cos() + own);
            if j + 1 < N {
                let bond = -3.0 * (q[j + 1] - q[j]).powi(2);
                tell(Block::Hqq, j, j + 1, bond);
                tell(Block::Hqq, j + 1, j, bond);
            }
            tell(Block::Hpp, j, j, 1.0 / Self::m(j));
            tell(Block::Dq, j, j, 0.6 * q[j] * p[j] / Self::m(j));
            tell(Block::Dp, j, j, Self::gamma(q[j]) / Self::m(j));
        }
    }
    fn is_linear(&self) -> bool {
        self.0 == Lie::EntriesThatStay
    }
}

fn told(lie: Lie) -> Caught {
    validate::system(&Told(lie), &Q, &P)
}

fn parts(lie: Lie) -> Caught {
    // What the parts say is not seen by those who do not look at them.
    assert_eq!(told(lie), Ok(()));
    validate::separable(&Told(lie), &Q, &P)
}

fn entries(lie: Lie) -> Caught {
    assert_eq!(told(lie), Ok(()));
    validate::curvature(&Told(lie), &Q, &P)
}

#[test]
fn the_truth_passes() {
    for (q, p) in [
        (Q, P),
        ([0.0; N], [0.0; N]),
        ([1e-9, 0.0, -3e-8, 0.0], [0.0, 1e-12, 0.0, 0.0]),
        ([1e3; N], [-1e7; N]),
    ] {
        assert_eq!(validate::separable(&Told(Lie::None), &q, &p), Ok(()));
        assert_eq!(validate::curvature(&Told(Lie::None), &q, &p), Ok(()));
    }
}

#[test]
fn lengths_that_do_not_match() {
    let wrong = |quantity, expected, found| Err(InputError::Length { quantity, expected, found });
    assert_eq!(told(Lie::Length), wrong(Quantity::Coordinate, N + 1, N));
    assert_eq!(
        validate::system(&Told(Lie::None), &Q, &P[1..]),
        wrong(Quantity::Momentum, N, N - 1)
    );
    assert_eq!(
        validate::separable(&Told(Lie::None), &Q[2..], &P),
        wrong(Quantity::Coordinate, N, N - 2)
    );
    assert_eq!(validate::curvature(&Told(Lie::None), &[], &[]), wrong(Quantity::Coordinate, N, 0));
}

#[test]
fn what_is_no_number() {
    for (lie, quantity, dof, says) in [
        (Lie::EnergyOfNoNumber, Quantity::Energy, 0, "H = NaN is not finite"),
        (Lie::GradientOfNoNumber, Quantity::Velocity, 3, "∂H/∂p4 = inf is not finite"),
        (Lie::DissipationOfNoNumber, Quantity::Dissipation, 1, "D2 = NaN is not finite"),
    ] {
        let error = told(lie).unwrap_err();
        let InputError::NotFinite { quantity: found, dof: of, .. } = error else {
            panic!("{error:?}")
        };
        assert_eq!((found, of), (quantity, dof));
        assert_eq!(error.to_string(), says);
    }
    let error = validate::system(&Told(Lie::None), &[0.0, f64::NAN, 0.0, 0.0], &P).unwrap_err();
    assert_eq!(error.to_string(), "q2 = NaN is not finite");
}

#[test]
fn gradients_that_are_not_derivatives() {
    for off in [1.0, -2.0, 1e-6, -1e-9] {
        let [given, found] =
            assert_caught(told(Lie::SlopeOffBy(off)), Quantity::Slope, 2, "∂H/∂q3");
        assert!(
            (given / found - 1.0 - off).abs() < 1e-12 + 1e-3 * off.abs(),
            "{off}: {given} {found}"
        );
    }
    // Means over an edge of 1/64 of the largest coordinate: the values at the state, ± ∂²H/∂q² ≈ 12
    // times half of it.
    let [given, found] =
        assert_caught(told(Lie::SlopeOfAnother), Quantity::Slope, 1, "derivative of the energy");
    assert!((given - Told::force(&Q, 2, Q[2])).abs() < 0.2, "{given}");
    assert!((found - Told::force(&Q, 1, Q[1])).abs() < 0.2, "{found}");
    assert_caught(told(Lie::Velocity), Quantity::Velocity, 2, "∂H/∂p3");
    // At rest every slope is 0, right or wrong.
    let rest = [0.0; N];
    assert_caught(
        validate::system(&Told(Lie::SlopeOffBy(1.0)), &rest, &rest),
        Quantity::Slope,
        2,
        "∂H/∂q3",
    );
    assert_caught(
        validate::system(&Told(Lie::Velocity), &rest, &rest),
        Quantity::Velocity,
        2,
        "∂H/∂p3",
    );
}

#[test]
fn damping_that_is_another() {
    let [given, found] =
        assert_caught(told(Lie::Zero), Quantity::Dissipation, 0, "D1 is given as 0.0");
    assert_eq!([given, found], [0.0, Told::gamma(Q[0]) * P[0]]);
    let [_, found] =
        assert_caught(told(Lie::PassiveEach), Quantity::ReservoirRate, 1, "w'2 is given as 0.0");
    assert!(found < 0.0);
    let error = told(Lie::PassiveInSum).unwrap_err();
    assert!(
        matches!(
            error,
            InputError::Contradiction { quantity: Quantity::TotalReservoirRate, dof: 2, .. }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("Σ w' is given as 0.0 and found to be -"), "{error}");
    assert_caught(told(Lie::Linear), Quantity::Dissipation, 3, "linear in p");
    assert_caught(told(Lie::Affine), Quantity::Dissipation, 0, "linear in p");
}

#[test]
fn couplings_that_reach_further() {
    let [given, found] = assert_entry(told(Lie::Chain), (Block::Hqq, 3, 0), "∂²H/∂q4∂q1");
    assert!(given == 0.0 && (found - 0.1).abs() < 1e-9);
    let [_, found] = assert_entry(told(Lie::ChainOfDrags), (Block::Dq, 3, 1), "coupling()");
    assert!((found - 0.1).abs() < 1e-9);
}

#[test]
fn parts_that_are_not_those_of_the_system() {
    assert_caught(parts(Lie::Partial), Quantity::Partial, 0, "∂V/∂q1");
    assert_eq!(parts(Lie::NoMass), Err(InputError::Mass { dof: 1, value: -1.5 }));
    assert_eq!(
        assert_caught(parts(Lie::OtherMass), Quantity::Mass, 3, "m4 is given as 2.0")[0],
        2.0
    );
    assert_caught(parts(Lie::DragValue), Quantity::Dissipation, 0, "dissipation_of()");
    let [given, found] =
        assert_caught(parts(Lie::DragByMomentum), Quantity::DissipationSlope, 0, "by_p");
    assert!(given == 1.0 && (found - Told::gamma(Q[0])).abs() < 1e-15);
    assert_entry(parts(Lie::DragOfOtherMomenta), (Block::Dp, 1, 0), "∂D2/∂p1");
}

#[test]
fn increments_that_disagree_with_v() {
    for (off, says) in
        [(0.5, "V(to) - V(from)"), (-1e-6, "V(to) - V(from)"), (1e-11, "mean of partial()")]
    {
        let [given, found] =
            assert_caught(parts(Lie::EdgeOffBy(off)), Quantity::Increment, 1, says);
        // The increment of V over an edge of 1e-3 has lost three digits.
        assert!((given / found - 1.0 - off).abs() < 1e-12, "{off}: {given} {found}");
    }
    assert_caught(parts(Lie::EdgeIsPartial), Quantity::Increment, 0, "V(to) - V(from)");
    // Right on long edges, and 1e-16/Δq wrong on short ones.
    let [given, found] =
        assert_caught(parts(Lie::EdgeByQuotient), Quantity::Increment, 0, "short edges");
    assert!((given - found).abs() < 1e-4 && given != found);
    let [given, _] =
        assert_caught(parts(Lie::EdgeOfNoNumberAtRest), Quantity::Increment, 0, "on none");
    assert!(given.is_nan());
}

#[test]
fn entries_that_are_not_derivatives() {
    for (block, column) in [(Block::Hqq, 1), (Block::Hpp, 2), (Block::Dq, 2), (Block::Dp, 2)] {
        for off in [-2.0, 1e-6] {
            let [given, found] =
                assert_entry(entries(Lie::Entry(block, off)), (block, 2, column), "derivative");
            assert!((given / found - 1.0 - off).abs() < 1e-9, "{block:?}: {given} {found}");
        }
    }
    let [given, found] = assert_entry(entries(Lie::EntryMissing), (Block::Hqq, 1, 2), "missing");
    assert!(given == 0.0 && found < -1.0);
    assert_entry(entries(Lie::EntryTwice), (Block::Hpp, 0, 0), "twice");
    assert_entry(entries(Lie::EntryOutside), (Block::Dp, 3, 0), "∂D4/∂p1");
    assert_entry(entries(Lie::EntryNowhere), (Block::Dp, usize::MAX, 3), "no place");
    assert_entry(entries(Lie::EntryOfNoNumber), (Block::Dq, 1, 1), "finite");
    assert_entry(entries(Lie::EntriesThatCome), (Block::Dq, 0, 0), "same order");
    assert_entry(entries(Lie::EntriesThatStay), (Block::Hqq, 0, 0), "is_linear");
}
