//! The matrices of the path: S = H'', R with D = R v, and for linear systems E = ∂D/∂q at fixed v.
//!
//! R depends on D alone, and its symmetric part is positive semidefinite where the system is
//! passive:
//!
//! ```text
//! D linear in v              the matrix itself, by columns
//! D_j a function of v_j, or D_j v_j ≥ 0 for each j
//!                            R_jj = D_j/v_j, the secant from v = 0
//! any other                  R = ρ + (g uᵀ - u gᵀ)
//!                            u = v/|v|     ρ = D·v/|v|²     g = (D - ρ v)/|v|
//! ```
//!
//! The last satisfies R v = D and x·R x = ρ |x|², which is not negative if D·v is not. Secants by
//! columns satisfy neither.
//!
//! v contains the velocities of the degrees of freedom that are not motors. The row of a motor has
//! one entry: R_mj = -F_j, because D_m = -F_j v_j. So p of the motor and w_j change by the same
//! energy.

use crate::kernels::reductions::max_norm;
use crate::linear::NO_SUCH_DOF;
use afterbay_core::{
    Block, Coupling, Curvature, DissipationForm, InputError, Passive, Scalar, System, Vector,
};

/// The error of R v, in roundings, up to which friction counts as linear in the velocities.
const LINEAR_ROUNDINGS: f64 = 64.0;

/// The form of R.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Diagonal,
    Matrix,
    SkewRankTwo,
}

/// S, R and E at z̄.
#[derive(Clone, Debug)]
pub(super) struct Slopes<V: Vector> {
    /// S = H'', entry by entry
    entries: Vec<(Block, usize, usize, V::Scalar)>,
    /// ∂D/∂q at fixed p, entry by entry; empty if the system is not linear
    by_q: Vec<(usize, usize, V::Scalar)>,
    linear: bool,
    kind: Kind,
    /// The number of degrees of freedom that are not motors
    free: usize,
    damping: DissipationForm,
    diagonal: V,
    /// Columns of R: the rows `bandwidth` above and below the diagonal
    columns: Vec<V::Scalar>,
    bandwidth: usize,
    /// ρ, g and u
    rate: V::Scalar,
    skew: [V; 2],
    /// The motors, each with the degree of freedom j that it drives, and R_mj = -F_j
    motors: Vec<(usize, usize, V::Scalar)>,
}

impl<V: Vector> Slopes<V> {
    /// Allocates S, R and E.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if a second derivative names a degree of freedom that does not
    /// exist.
    pub(super) fn new<S: Curvature<V::Scalar> + ?Sized>(system: &S) -> Result<Self, InputError> {
        let n = system.dof();
        let damping = system.dissipation_form();
        let (mut counts, origin) = ([0, 0], vec![V::Scalar::zero(); n]);
        let mut exist = true;
        system.curvature(&origin, &origin, |block, i, j, _| {
            exist &= i < n && j < n;
            match block {
                Block::Dq => counts[1] += 1,
                Block::Dp => {}
                Block::Hqq | Block::Hqp | Block::Hpp => counts[0] += 1,
            }
        });
        if !exist {
            return Err(InputError::Unsupported { method: "locally-exact", why: NO_SUCH_DOF });
        }
        let bandwidth = if system.coupling() == Coupling::Chain { 1 } else { n.saturating_sub(1) };
        let motors = (n - system.motors()..n)
            .filter_map(|m| Some((m, system.driven_by(m)?, V::Scalar::zero())))
            .collect();
        let entries = if damping.coupled { n * (2 * bandwidth + 1).min(n) } else { 0 };
        Ok(Self {
            entries: Vec::with_capacity(counts[0]),
            by_q: Vec::with_capacity(counts[1]),
            linear: system.is_linear(),
            kind: Kind::Diagonal,
            free: n - system.motors(),
            damping,
            diagonal: V::zeros(n),
            columns: vec![V::Scalar::zero(); entries],
            bandwidth,
            rate: V::Scalar::zero(),
            skew: [V::zeros(n), V::zeros(n)],
            motors,
        })
    }

    /// Evaluates S and E at z̄.
    pub(super) fn evaluate<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        [q, p]: [&[V::Scalar]; 2],
    ) {
        let Self { entries, by_q, linear, .. } = self;
        entries.clear();
        by_q.clear();
        system.curvature(q, p, |block, i, j, x| match block {
            Block::Hqq | Block::Hqp | Block::Hpp => entries.push((block, i, j, x)),
            Block::Dq if *linear => by_q.push((i, j, x)),
            Block::Dq | Block::Dp => {}
        });
    }

    /// Computes R and D̄ = D(z̄, 0) + R v at z̄. D(z̄, 0) is written to `rest`.
    pub(super) fn resist<S: System<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        [q, p]: [&[V::Scalar]; 2],
        v: &[V::Scalar],
        [rest, d, probe, found]: [&mut [V::Scalar]; 4],
    ) {
        probe.fill(V::Scalar::zero());
        system.dissipation(q, p, probe, rest);
        if !self.motors.is_empty() {
            probe.fill(V::Scalar::one());
            system.dissipation(q, p, probe, found);
            self.motors.iter_mut().for_each(|(m, _, r)| *r = found[*m]);
            probe.fill(V::Scalar::zero());
        }
        let free = self.free;
        let evaluate_d = |probe: &[V::Scalar], found: &mut [V::Scalar]| {
            system.dissipation(q, p, probe, found);
            found.iter_mut().zip(&*rest).for_each(|(found, &rest)| *found -= rest);
            found[free..].fill(V::Scalar::zero());
        };
        if !self.damping.coupled {
            self.kind = Kind::Diagonal;
            // D linear in p is linear in v. Otherwise the secant is used where it exists.
            let one = V::Scalar::one();
            for (probe, &v) in probe.iter_mut().zip(v) {
                *probe = if self.damping.linear || v == V::Scalar::zero() { one } else { v };
            }
            evaluate_d(probe, found);
            self.secants(probe, found, |_| true);
        } else {
            self.probe(v, [probe, found], &evaluate_d);
            evaluate_d(v, found);
            if !self.is_linear(v, found, rest) {
                self.set_nonlinear_r(&v[..free], [probe, found], &evaluate_d);
            }
        }
        d.copy_from_slice(rest);
        self.add_dissipation(v, d);
    }

    /// Sets R_jj for the degrees of freedom in `meant`, given the values `found` of D - D(z̄, 0) at
    /// a velocity.
    fn secants(&mut self, at: &[V::Scalar], found: &[V::Scalar], meant: impl Fn(usize) -> bool) {
        let pairs = found.iter().zip(at).enumerate();
        for ((j, (&found, &at)), r) in pairs.zip(self.diagonal.as_mut_slice()) {
            if meant(j) {
                *r = found / at;
            }
        }
    }

    /// Evaluates the columns of R, several at a time if they have no row in common.
    fn probe(
        &mut self,
        v: &[V::Scalar],
        [probe, found]: [&mut [V::Scalar]; 2],
        evaluate_d: &impl Fn(&[V::Scalar], &mut [V::Scalar]),
    ) {
        self.kind = Kind::Matrix;
        let (n, bandwidth) = (v.len(), self.bandwidth);
        let width = (2 * bandwidth + 1).min(n);
        for colour in 0..width {
            probe.fill(V::Scalar::zero());
            probe.iter_mut().skip(colour).step_by(width).for_each(|x| *x = V::Scalar::one());
            evaluate_d(probe, found);
            for k in (colour..n).step_by(width) {
                let rows = rows(n, bandwidth, k);
                self.columns[k * width..][..rows.len()].copy_from_slice(&found[rows]);
            }
        }
    }

    /// Whether D - D(z̄, 0) equals R v to the rounding of D and `rest` = D(z̄, 0).
    fn is_linear(&self, v: &[V::Scalar], found: &[V::Scalar], rest: &[V::Scalar]) -> bool {
        let (n, bandwidth) = (v.len(), self.bandwidth);
        let width = (2 * bandwidth + 1).min(n);
        (0..n).all(|i| {
            let (mut sum, mut size) = (V::Scalar::zero(), found[i].abs() + rest[i].abs());
            for k in rows(n, bandwidth, i) {
                let term = self.columns[k * width + i - rows(n, bandwidth, k).start] * v[k];
                sum += term;
                size += term.abs();
            }
            (found[i] - sum).abs().to_f64() <= LINEAR_ROUNDINGS * V::Scalar::EPSILON * size.to_f64()
        })
    }

    /// Sets R for D that is not linear in the velocities v of the degrees of freedom, given the
    /// value `found` of D - D(z̄, 0) there.
    fn set_nonlinear_r(
        &mut self,
        v: &[V::Scalar],
        [probe, found]: [&mut [V::Scalar]; 2],
        evaluate_d: &impl Fn(&[V::Scalar], &mut [V::Scalar]),
    ) {
        let (zero, one) = (V::Scalar::zero(), V::Scalar::one());
        let largest = max_norm(v);
        if self.damping.passive == Passive::Each {
            self.kind = Kind::Diagonal;
            let small = V::Scalar::EPSILON.sqrt() * largest;
            let least = if small > 0.0 { V::Scalar::from_f64(small) } else { one };
            let moves = |j: usize| v.get(j).is_some_and(|v| v.abs().to_f64() > small);
            self.secants(v, found, moves);
            for (j, probe) in probe.iter_mut().enumerate() {
                *probe = if moves(j) { v[j] } else { least };
            }
            evaluate_d(probe, found);
            self.secants(probe, found, |j| !moves(j));
            return;
        }
        self.kind = Kind::SkewRankTwo;
        let [skew, unit] = &mut self.skew;
        let (skew, unit) = (skew.as_mut_slice(), unit.as_mut_slice());
        self.rate = zero;
        skew.fill(zero);
        unit.fill(zero);
        if largest == 0.0 || !largest.is_finite() {
            return;
        }
        let scale = V::Scalar::from_f64(largest);
        let square = v.iter().fold(zero, |sum, &v| (v / scale).mul_add(v / scale, sum));
        let length = scale * square.sqrt();
        unit.iter_mut().zip(v).for_each(|(unit, &v)| *unit = v / length);
        let along =
            found.iter().zip(&*unit).fold(zero, |sum, (&d, &unit)| d.mul_add(unit, sum)) / length;
        let negative = self.damping.passive == Passive::InSum && along.to_f64() < 0.0;
        self.rate = if negative { zero } else { along };
        for ((skew, &d), &unit) in skew.iter_mut().zip(&*found).zip(&*unit) {
            *skew = d / length - along * unit;
        }
    }

    /// S x
    pub(super) fn multiply_hessian(
        &self,
        [q, p]: [&[V::Scalar]; 2],
        [sq, sp]: [&mut [V::Scalar]; 2],
    ) {
        sq.fill(V::Scalar::zero());
        sp.fill(V::Scalar::zero());
        for &(block, i, j, x) in &self.entries {
            match block {
                Block::Hqq => sq[i] = x.mul_add(q[j], sq[i]),
                Block::Hpp => sp[i] = x.mul_add(p[j], sp[i]),
                Block::Hqp => {
                    sq[i] = x.mul_add(p[j], sq[i]);
                    sp[j] = x.mul_add(q[i], sp[j]);
                }
                Block::Dq | Block::Dp => {}
            }
        }
    }

    /// Adds R v to `to`.
    pub(super) fn add_dissipation(&self, v: &[V::Scalar], to: &mut [V::Scalar]) {
        let zero = V::Scalar::zero();
        match self.kind {
            Kind::Diagonal => {
                let pairs = to.iter_mut().zip(self.diagonal.as_slice());
                pairs.zip(v).for_each(|((to, &r), &v)| *to = r.mul_add(v, *to));
            }
            Kind::Matrix => {
                let (n, bandwidth) = (v.len(), self.bandwidth);
                let width = (2 * bandwidth + 1).min(n);
                for (k, &v) in v.iter().enumerate() {
                    let rows = rows(n, bandwidth, k);
                    let column = &self.columns[k * width..][..rows.len()];
                    to[rows].iter_mut().zip(column).for_each(|(to, &r)| *to = r.mul_add(v, *to));
                }
            }
            Kind::SkewRankTwo => {
                let [skew, unit] = [self.skew[0].as_slice(), self.skew[1].as_slice()];
                let along =
                    |x: &[V::Scalar]| x.iter().zip(v).fold(zero, |sum, (&x, &v)| x.mul_add(v, sum));
                let [by_skew, by_unit] = [along(skew), along(unit)];
                for (j, to) in to[..self.free].iter_mut().enumerate() {
                    *to += self.rate * v[j] + (skew[j] * by_unit - unit[j] * by_skew);
                }
            }
        }
        self.motors.iter().for_each(|&(m, j, r)| to[m] = r.mul_add(v[j], to[m]));
    }

    /// Adds E x to `to`. The derivatives of D at fixed p contain the change of v with q, which R
    /// takes into account. `v` is memory for it.
    pub(super) fn add_position_terms(
        &self,
        x: &[V::Scalar],
        to: &mut [V::Scalar],
        v: &mut [V::Scalar],
    ) {
        if self.by_q.is_empty() {
            return;
        }
        v.fill(V::Scalar::zero());
        for &(block, i, j, entry) in &self.entries {
            if block == Block::Hqp {
                v[j] = (-entry).mul_add(x[i], v[j]);
            }
        }
        self.add_dissipation(v, to);
        for &(i, j, entry) in &self.by_q {
            to[i] = entry.mul_add(x[j], to[i]);
        }
    }

    /// A x = (s_p, -s_q - R s_p - E x_q) with s = S x, which is stored in `s`.
    pub(super) fn multiply(
        &self,
        x: [&[V::Scalar]; 2],
        [a, b]: [&mut [V::Scalar]; 2],
        [sq, sp]: [&mut [V::Scalar]; 2],
    ) {
        self.multiply_hessian(x, [&mut *sq, &mut *sp]);
        self.add_dissipation(sp, sq);
        self.add_position_terms(x[0], sq, b);
        a.copy_from_slice(sp);
        b.iter_mut().zip(&*sq).for_each(|(b, &s)| *b = -s);
    }
}

/// The rows in which column `k` of R may have entries.
fn rows(n: usize, bandwidth: usize, k: usize) -> std::ops::Range<usize> {
    k.saturating_sub(bandwidth)..(k + bandwidth + 1).min(n)
}
