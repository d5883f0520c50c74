//! The systems: all-to-all coupling with friction of every kind, and a Toda chain.

use crate::bind::Curved;
use afterbay_core::{
    Block, Coupling, Curvature, Dissipation, DissipationForm, Passive, Separable, State, System,
};

/// The form of D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rubs {
    /// c v
    Linearly,
    /// c |v| v, with |v| the norm of all velocities
    Wind,
    /// c |v| v_j with a separate coefficient for each j: passive in the sum and in each degree of
    /// freedom
    Unevenly,
}

/// H = Σ p²/2 + ½ q·K q + β Σ q⁴/4 with K symmetric and positive definite, D = friction and g G v
/// with G skew.
#[derive(Clone, Debug)]
pub(crate) struct Web {
    n: usize,
    spring: Vec<f64>,
    skew: Vec<f64>,
    pub(crate) c: f64,
    pub(crate) g: f64,
    pub(crate) beta: f64,
    pub(crate) rubs: Rubs,
}

impl Web {
    /// Creates a system with springs of about this stiffness.
    pub(crate) fn new(n: usize, stiffness: f64, c: f64, g: f64, beta: f64, rubs: Rubs) -> Self {
        let x = |i: usize, j: usize| (1.3 * (i * j) as f64 + 0.7 * (i + j) as f64).sin();
        let spring = |i: usize, j: usize| {
            stiffness * (f64::from(u8::from(i == j)) + 0.5 * x(i, j) / n as f64)
        };
        let skew = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Less => x(i, j),
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Greater => -x(i, j),
        };
        let table = |f: &dyn Fn(usize, usize) -> f64| (0..n * n).map(|k| f(k / n, k % n)).collect();
        Self { n, spring: table(&spring), skew: table(&skew), c, g, beta, rubs }
    }

    fn coefficient(&self, j: usize) -> f64 {
        if self.rubs == Rubs::Unevenly { self.c * (1.0 + j as f64) } else { self.c }
    }

    fn row<'a>(&self, table: &'a [f64], i: usize) -> &'a [f64] {
        &table[i * self.n..(i + 1) * self.n]
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl System<f64> for Web {
    fn dof(&self) -> usize {
        self.n
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let own = |j: usize| {
            p[j] * p[j] + q[j] * dot(self.row(&self.spring, j), q) + 0.5 * self.beta * q[j].powi(4)
        };
        (0..self.n).map(own).sum::<f64>() / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hp.copy_from_slice(p);
        for (j, hq) in hq.iter_mut().enumerate() {
            *hq = self.partial(q, j, q[j]);
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        let speed = if self.rubs == Rubs::Linearly { 1.0 } else { dot(v, v).sqrt() };
        for (j, d) in d.iter_mut().enumerate() {
            *d = self.coefficient(j) * speed * v[j];
            if self.g != 0.0 {
                *d += self.g * dot(self.row(&self.skew, j), v);
            }
        }
    }
    fn dissipation_form(&self) -> DissipationForm {
        let passive = if self.g == 0.0 { Passive::Each } else { Passive::InSum };
        let coupled = self.g != 0.0 || self.rubs != Rubs::Linearly;
        DissipationForm { zero: false, passive, linear: self.rubs == Rubs::Linearly, coupled }
    }
    fn unit_mass(&self) -> bool {
        true
    }
}

impl Separable<f64> for Web {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let row = self.row(&self.spring, j);
        row[j].mul_add(at - q[j], dot(row, q)) + self.beta * at.powi(3)
    }
    fn dissipation_of(&self, q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        let mut d = vec![0.0; self.n];
        self.dissipation(q, p, p, &mut d);
        let speed = if self.rubs == Rubs::Linearly { 1.0 } else { dot(p, p).sqrt() };
        Dissipation { value: d[j], by_q: 0.0, by_p: self.coefficient(j) * speed }
    }
}

impl Curvature<f64> for Web {
    fn curvature(&self, q: &[f64], p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        let speed = dot(p, p).sqrt().max(f64::MIN_POSITIVE);
        for i in 0..self.n {
            put(Block::Hpp, i, i, 1.0);
            for j in 0..self.n {
                let own = f64::from(u8::from(i == j));
                put(
                    Block::Hqq,
                    i,
                    j,
                    self.spring[i * self.n + j] + own * 3.0 * self.beta * q[i] * q[i],
                );
                let c = self.coefficient(i);
                let rubs = match self.rubs {
                    Rubs::Linearly => own * c,
                    Rubs::Wind | Rubs::Unevenly => c * (own * speed + p[i] * p[j] / speed),
                };
                put(Block::Dp, i, j, rubs + self.g * self.skew[i * self.n + j]);
            }
        }
    }
    fn is_linear(&self) -> bool {
        self.beta == 0.0 && self.rubs == Rubs::Linearly
    }
}

/// H = Σ p²/2 + Σ [e^r - 1 - r] with r = q_{j+1} - q_j and walls at both ends, D = c v.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Toda {
    pub(crate) n: usize,
    pub(crate) c: f64,
}

impl Toda {
    fn r(q: &[f64], j: usize) -> f64 {
        let end = |j: usize| if j == 0 { 0.0 } else { q.get(j - 1).copied().unwrap_or(0.0) };
        end(j + 1) - end(j)
    }
}

impl System<f64> for Toda {
    fn dof(&self) -> usize {
        self.n
    }
    fn energy(&self, q: &[f64], p: &[f64]) -> f64 {
        let spring = |j: usize| {
            let r = Self::r(q, j);
            // Avoids the cancellation in e^r - 1 - r.
            if r.abs() < 1e-5 { r * r * (0.5 + r / 6.0) } else { r.exp_m1() - r }
        };
        (0..=self.n).map(spring).sum::<f64>() + dot(p, p) / 2.0
    }
    fn gradient(&self, q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
        hp.copy_from_slice(p);
        for (j, hq) in hq.iter_mut().enumerate() {
            *hq = Self::r(q, j).exp_m1() - Self::r(q, j + 1).exp_m1();
        }
    }
    fn dissipation(&self, _q: &[f64], _p: &[f64], v: &[f64], d: &mut [f64]) {
        d.iter_mut().zip(v).for_each(|(d, v)| *d = self.c * v);
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm { passive: Passive::Each, ..DissipationForm::LINEAR }
    }
    fn coupling(&self) -> Coupling {
        Coupling::Chain
    }
    fn unit_mass(&self) -> bool {
        true
    }
}

impl Curvature<f64> for Toda {
    fn curvature(&self, q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
        for j in 0..self.n {
            put(Block::Hpp, j, j, 1.0);
            put(Block::Dp, j, j, self.c);
            let [left, right] = [Self::r(q, j).exp(), Self::r(q, j + 1).exp()];
            put(Block::Hqq, j, j, left + right);
            if j > 0 {
                put(Block::Hqq, j, j - 1, -left);
                put(Block::Hqq, j - 1, j, -left);
            }
        }
    }
}

impl Separable<f64> for Toda {
    fn partial(&self, q: &[f64], j: usize, at: f64) -> f64 {
        let left = if j == 0 { 0.0 } else { q[j - 1] };
        let right = q.get(j + 1).copied().unwrap_or(0.0);
        (at - left).exp_m1() - (right - at).exp_m1()
    }
    fn dissipation_of(&self, _q: &[f64], p: &[f64], j: usize) -> Dissipation<f64> {
        Dissipation { value: self.c * p[j], by_q: 0.0, by_p: self.c }
    }
}

/// n numbers of order 1.
pub(crate) fn wave(n: usize, a: f64) -> Vec<f64> {
    (0..n).map(|j| (a * j as f64 + 0.2).sin()).collect()
}

/// |ΔK| over the rounding of its terms: H, w and, for each degree of freedom, z times the slopes
/// of H and D, amplified by h |H''| as the rounding of z is.
pub(crate) fn drift(
    system: &Curved<f64>,
    h: f64,
    before: &State<Vec<f64>>,
    after: &State<Vec<f64>>,
) -> f64 {
    let total = |x: &[f64]| x.iter().map(|x| x.abs()).sum::<f64>();
    let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut scale = f64::MIN_POSITIVE / f64::EPSILON;
    for state in [before, after] {
        let n = state.dof();
        let (mut hq, mut hp, mut d) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        system.gradient(&state.q, &state.p, &mut hq, &mut hp);
        system.dissipation(&state.q, &state.p, &hp, &mut d);
        let mut bend = 0.0_f64;
        system.curvature(&state.q, &state.p, |_, _, _, value| bend = bend.max(value.abs()));
        let z = largest(&state.q).max(largest(&state.p));
        let slopes = total(&hq) + total(&hp) + total(&d);
        scale += state.energy(system).abs() + total(&state.w) + (1.0 + h * bend) * z * slopes;
    }
    (after.total(system) - before.total(system)).abs() / (f64::EPSILON / 2.0 * scale)
}

/// The number of reservoirs of a passive system that decreased by more than the rounding of w: of
/// each, or of their sum.
pub(crate) fn falls(passive: Passive, before: &[f64], after: &[f64]) -> usize {
    let gains = before.iter().zip(after).map(|(before, after)| after - before);
    match passive {
        Passive::No => 0,
        Passive::Each => gains.filter(|&gain| gain < 0.0).count(),
        Passive::InSum => {
            let size: f64 = before.iter().chain(after).map(|w| w.abs()).sum();
            usize::from(gains.sum::<f64>() < -4.0 * f64::EPSILON * size)
        }
    }
}
