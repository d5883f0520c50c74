//! Lies that are hidden: by a state at rest, and by members that look alike.

use crate::caught::*;
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, Formulas, FromFormulas, InputError, Quantity, Scalar,
    Separable, System, Uniform, validate,
};

/// H = Σ (p_j² + q_j²)/2 and D_j = 0.3 p_j for four, and a product that vanishes at rest with
/// everything its lie forgets.
struct AtRest(&'static str);

impl System<f64> for AtRest {
    fn dof(&self) -> usize {
        N
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let own: f64 = q.iter().chain(p).map(|x| x * x / 2.0).sum();
        own + match self.0 {
            "far" => q[0] * q[0] * q[3] * q[3],
            "slope" => q[0] * q[0] * q[1],
            "entry" => q[0] * q[0] * q[1] * q[1],
            _ => 0.0,
        }
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hq.copy_from_slice(q);
        hp.copy_from_slice(p);
        let (i, j) = match self.0 {
            "far" => (0, 3),
            "entry" => (0, 1),
            _ => return,
        };
        hq[i] += 2.0 * q[i] * q[j] * q[j];
        hq[j] += 2.0 * q[i] * q[i] * q[j];
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        (0..N).for_each(|j| d[j] = 0.3 * v[j]);
        if self.0 == "drag" {
            d[0] *= 1.0 + v[1] * v[1];
        }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
}

impl Separable<f64> for AtRest {
    fn partial(&self, _q: &[f64], _j: usize, at: f64) -> f64 {
        at
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        let mut d = [0.0; N];
        self.dissipation(q, p, p, &mut d);
        Dissipation { value: d[j], by_q: 0.0, by_p: 0.3 }
    }
}

impl Curvature<f64> for AtRest {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for j in 0..N {
            let other = if j < 2 { 2.0 * q[1 - j] * q[1 - j] } else { 0.0 };
            put(Block::Hqq, j, j, 1.0 + other);
            put(Block::Hpp, j, j, 1.0);
            put(Block::Dp, j, j, 0.3);
        }
    }
}

#[test]
fn a_state_at_rest_hides_nothing() {
    let rest = [0.0; N];
    assert_eq!(validate::separable(&AtRest("none"), &rest, &rest), Ok(()));
    assert_entry(validate::system(&AtRest("far"), &rest, &rest), (Block::Hqq, 3, 0), "coupling()");
    assert_caught(
        validate::system(&AtRest("slope"), &rest, &rest),
        Quantity::Slope,
        0,
        "derivative",
    );
    assert_entry(
        validate::separable(&AtRest("drag"), &rest, &rest),
        (Block::Dp, 0, 1),
        "no other momentum",
    );
    assert_entry(
        validate::curvature(&AtRest("entry"), &rest, &rest),
        (Block::Hqq, 1, 0),
        "missing",
    );
}

/// H = Σ p_j²/(2 m_j) + q_j²/2, D_j = 0.3 v_j; the masses in the lanes are 1.
struct Row {
    ring: bool,
    lanes: f64,
    m: fn(usize) -> f64,
}

impl<T: Scalar> System<T> for Row {
    fn dof(&self) -> usize {
        N
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        (0..N).fold(T::zero(), |sum, j| sum + (p[j] * p[j] / self.mass(j) + q[j] * q[j]).half())
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        (0..N).for_each(|j| (hq[j], hp[j]) = (q[j], p[j] / self.mass(j)));
    }
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        (0..N).for_each(|j| d[j] = T::from_f64(0.3) * v[j]);
    }
    fn coupling(&self) -> Coupling {
        if self.ring { Coupling::Ring } else { Coupling::Chain }
    }
}

impl<T: Scalar> Separable<T> for Row {
    fn mass(&self, j: usize) -> T {
        T::from_f64((self.m)(j))
    }
    fn partial(&self, _q: &[T], _j: usize, at: T) -> T {
        at
    }
    fn dissipation_of(&self, _q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let by_p = T::from_f64(0.3) / self.mass(j);
        Dissipation { value: by_p * p[j], by_q: T::zero(), by_p }
    }
}

impl Uniform for Row {
    type Lanes = Row;
    fn lanes(&self) -> Result<Row, InputError> {
        Ok(Row { m: if self.lanes == 1.0 { self.m } else { |_| 1.5 }, ..*self })
    }
}

#[test]
fn members_that_are_not_alike() {
    for ring in [false, true] {
        let alike = Row { ring, lanes: 1.0, m: |_| 2.0 };
        for (q, p) in [(Q, P), ([0.0; N], [0.0; N])] {
            assert_eq!(validate::uniform(&alike, &q, &p), Ok(()));
            let other = Row { ring, lanes: 1.0, m: |j| 1.0 + j as f64 };
            assert_eq!(validate::separable(&other, &q, &p), Ok(()));
            assert_eq!(
                assert_caught(
                    validate::uniform(&other, &q, &p),
                    Quantity::Mass,
                    0,
                    "middle of three"
                ),
                [2.0, 1.0]
            );
            let lanes = Row { ring, lanes: 2.0, m: |_| 2.0 };
            assert_eq!(
                assert_caught(
                    validate::uniform(&lanes, &q, &p),
                    Quantity::Mass,
                    0,
                    "middle of three"
                ),
                [1.5, 2.0]
            );
        }
    }
}

/// A free particle in a plane that leaves entries as they are, or adds to them.
struct Unwritten(&'static str);

impl System<f64> for Unwritten {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, _q: &[f64], p: &[f64]) -> f64 {
        (p[0] * p[0] + p[1] * p[1]) / 2.0
    }
    fn gradient(&self, _q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hp[0] = p[0];
        hp[1] = if self.0 == "velocity" { hp[1] + p[1] } else { p[1] };
        hq[0] = 0.0;
        if self.0 != "slope" {
            hq[1] = 0.0;
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
        if self.0 != "dissipation" {
            d.fill(0.0);
        }
    }
}

#[test]
fn entries_that_are_not_written_are_found() {
    let found = |lie| validate::system(&Unwritten(lie), &[0.3, 0.4], &[0.5, 0.7]);
    assert_eq!(found("none"), Ok(()));
    for (lie, quantity, dof) in [
        ("slope", Quantity::Slope, 1),
        ("velocity", Quantity::Velocity, 1),
        ("dissipation", Quantity::Dissipation, 0),
    ] {
        assert_caught(found(lie), quantity, dof, "must write every entry");
    }
}

/// V = q²/2 for q < 0 and q² + 2 q elsewhere, chosen by `if`, which sees one end of an edge, or by
/// `select`.
struct Chosen {
    by_if: bool,
}

impl Formulas for Chosen {
    fn dof(&self) -> usize {
        1
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let (q, left) = (q[0], (q[0] * q[0]).half());
        let right = q * q + q + q;
        match self.by_if {
            true if q.to_f64() < 0.0 => left,
            true => right,
            false => T::select(q.lt(T::zero()), left, right),
        }
    }
    fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], _j: usize) -> T {
        v[0].over(10.0)
    }
}

#[test]
fn a_choice_that_sees_one_end_of_an_edge_is_found() {
    for q in [0.5, 0.1, -0.01, -0.5] {
        let found = |by_if| validate::separable(&FromFormulas(Chosen { by_if }), &[q], &[0.3]);
        assert_caught(found(true), Quantity::Increment, 0, "divided_difference()");
        assert_eq!(found(false), Ok(()), "{q}");
    }
}
