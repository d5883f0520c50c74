//! Systems of several degrees of freedom: one without a separable H, and springs in any pattern.

use afterbay_core::{Block, Coupling, Curvature, DissipationForm, Passive, Scalar, System};

/// H = (1 + q1²/4) p1²/2 + p2²/2 + 0.3 q1 p2 + q1² q2 + (q1² + q2²)²/4 + (q1² + q2²)/2,
/// D = c (∂H/∂p1 + ½ ∂H/∂p2, ½ ∂H/∂p1 + ∂H/∂p2): coupled, and positive semidefinite in sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twisted {
    pub(crate) c: f64,
    /// A constant added to H, which must not change any result.
    pub(crate) offset: f64,
}

impl<T: Scalar> System<T> for Twisted {
    fn dof(&self) -> usize {
        2
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let r = q[0] * q[0] + q[1] * q[1];
        let kinetic = (q[0] * q[0] * T::from_f64(0.25) + T::one()) * p[0] * p[0] + p[1] * p[1];
        kinetic.half()
            + T::from_f64(0.3) * q[0] * p[1]
            + q[0] * q[0] * q[1]
            + (r.half() + T::one()) * r.half()
            + T::from_f64(self.offset)
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        let r = q[0] * q[0] + q[1] * q[1] + T::one();
        let twist = T::from_f64(0.3);
        hq[0] = T::from_f64(0.25) * q[0] * p[0] * p[0] + twist * p[1] + (q[1] + q[1] + r) * q[0];
        hq[1] = q[0] * q[0] + r * q[1];
        hp[0] = (q[0] * q[0] * T::from_f64(0.25) + T::one()) * p[0];
        hp[1] = p[1] + twist * q[0];
    }
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        let c = T::from_f64(self.c);
        d[0] = c * (v[0] + v[1].half());
        d[1] = c * (v[1] + v[0].half());
    }
    fn dissipation_form(&self) -> DissipationForm {
        let passive = if self.c > 0.0 { Passive::InSum } else { Passive::No };
        if self.c == 0.0 {
            DissipationForm::NONE
        } else {
            DissipationForm { passive, coupled: true, ..DissipationForm::GENERAL }
        }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Dense
    }
}

impl<T: Scalar> Curvature<T> for Twisted {
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let (x, y) = (q[0], q[1]);
        let (three, quarter, twist) = (T::from_f64(3.0), T::from_f64(0.25), T::from_f64(0.3));
        let cross = x + x + (x + x) * y;
        put(Block::Hqq, 0, 0, quarter * p[0] * p[0] + y + y + three * x * x + y * y + T::one());
        put(Block::Hqq, 0, 1, cross);
        put(Block::Hqq, 1, 0, cross);
        put(Block::Hqq, 1, 1, x * x + three * y * y + T::one());
        let (mixed, mass) = ((x * p[0]).half(), x * x * quarter + T::one());
        put(Block::Hqp, 0, 0, mixed);
        put(Block::Hqp, 0, 1, twist);
        put(Block::Hpp, 0, 0, mass);
        put(Block::Hpp, 1, 1, T::one());
        let c = T::from_f64(self.c);
        for (i, [own, other]) in
            [[T::one(), T::one().half()], [T::one().half(), T::one()]].iter().enumerate()
        {
            put(Block::Dq, i, 0, c * (*own * mixed + *other * twist));
            put(Block::Dp, i, 0, c * *own * mass);
            put(Block::Dp, i, 1, c * *other);
        }
    }
}

/// H = Σ p_j²/(2 m_j) + Σ q_j²/2 + Σ over springs of k r²/2 + r⁴/4, r = q_j - q_i; D_j = c p_j.
#[derive(Clone, Debug)]
pub(crate) struct Springs {
    pub(crate) masses: Vec<f64>,
    pub(crate) springs: Vec<(usize, usize, f64)>,
    pub(crate) c: f64,
    pub(crate) coupling: Coupling,
}

impl Springs {
    pub(crate) fn chain(n: usize, c: f64) -> Self {
        let springs = (1..n).map(|i| (i - 1, i, 1.0 + 0.1 * (i % 3) as f64)).collect();
        Self { masses: masses(n), springs, c, coupling: Coupling::Chain }
    }
    pub(crate) fn ring(n: usize, c: f64) -> Self {
        let mut ring = Self { coupling: Coupling::Ring, ..Self::chain(n, c) };
        ring.springs.push((n - 1, 0, 0.8));
        ring
    }
    pub(crate) fn dense(n: usize, c: f64) -> Self {
        let pairs = (0..n).flat_map(|j| (0..j).map(move |i| (i, j)));
        let stiffness =
            |(i, j): (usize, usize)| (i, j, 0.02 * (1.0 + ((7 * i + 3 * j) as f64).sin()));
        Self {
            masses: masses(n),
            springs: pairs.map(stiffness).collect(),
            c,
            coupling: Coupling::Dense,
        }
    }
}

fn masses(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 + 0.2 * (i as f64).sin()).collect()
}

impl<T: Scalar> System<T> for Springs {
    fn dof(&self) -> usize {
        self.masses.len()
    }
    fn energy(&self, q: &[T], p: &[T]) -> T {
        let own = |j: usize| (p[j] * p[j] / T::from_f64(self.masses[j]) + q[j] * q[j]).half();
        let bodies = (0..q.len()).fold(T::zero(), |sum, j| sum + own(j));
        self.springs.iter().fold(bodies, |sum, &(i, j, k)| {
            let r = (q[j] - q[i]) * (q[j] - q[i]);
            (T::from_f64(k) + r.half()).half().mul_add(r, sum)
        })
    }
    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        hq.copy_from_slice(q);
        for j in 0..q.len() {
            hp[j] = p[j] / T::from_f64(self.masses[j]);
        }
        for &(i, j, k) in &self.springs {
            let r = q[j] - q[i];
            let pull = r.mul_add(r, T::from_f64(k)) * r;
            hq[j] += pull;
            hq[i] -= pull;
        }
    }
    fn dissipation(&self, _q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        for ((d, v), mass) in d.iter_mut().zip(v).zip(&self.masses) {
            *d = T::from_f64(self.c * mass) * *v;
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        if self.c == 0.0 {
            DissipationForm::NONE
        } else {
            DissipationForm { passive: Passive::each_if(self.c > 0.0), ..DissipationForm::LINEAR }
        }
    }
    fn coupling(&self) -> Coupling {
        self.coupling.clone()
    }
}

impl<T: Scalar> Curvature<T> for Springs {
    fn curvature(&self, q: &[T], _p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        for (j, &mass) in self.masses.iter().enumerate() {
            put(Block::Hqq, j, j, T::one());
            put(Block::Hpp, j, j, T::from_f64(mass).recip());
            put(Block::Dp, j, j, T::from_f64(self.c));
        }
        for &(i, j, k) in &self.springs {
            let r = q[j] - q[i];
            let stiffness = (T::from_f64(3.0) * r).mul_add(r, T::from_f64(k));
            put(Block::Hqq, i, i, stiffness);
            put(Block::Hqq, j, j, stiffness);
            put(Block::Hqq, i, j, -stiffness);
            put(Block::Hqq, j, i, -stiffness);
        }
    }
}

/// A state without symmetries.
pub(crate) fn start<T: Scalar>(n: usize) -> (Vec<T>, Vec<T>) {
    let at = |phase: f64| move |j: usize| T::from_f64((phase + 1.7 * j as f64).sin());
    ((0..n).map(at(0.4)).collect(), (0..n).map(at(2.1)).collect())
}
