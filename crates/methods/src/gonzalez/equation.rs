//! The equation of the step, Δz = h (∇̄H_p, -∇̄H_q - D̄): its residual at Δz, and the Newton
//! correction of Δz.

use super::jacobian::Jacobian;
use super::lambda::Lambda;
use crate::force_rounding::ForceRounding;
use crate::kernels::reductions::{dot, products};
use crate::linear::LinearSolver;
use crate::measured_rounding::EnergyRounding;
use afterbay_core::{Curvature, InputError, Scalar, State, System, Vector};

/// The new state and the memory of the iteration.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    pub(super) jacobian: Jacobian,
    pub(super) dissipative: bool,
    /// The number of degrees of freedom before the motors of a drive, which λ leaves alone: their
    /// velocity is 1.
    pub(super) free: usize,
    pub(super) has_motors: bool,
    /// Whether λ is part of the equation. Without it the equation is that of the midpoint rule.
    pub(super) has_lambda: bool,
    /// Δz
    pub(crate) dq: V,
    pub(crate) dp: V,
    /// z̄ = z0 + Δz/2, and ∇H and D there
    pub(crate) q_mean: V,
    pub(crate) p_mean: V,
    pub(crate) hq: V,
    pub(super) hp: V,
    /// ∇̄H_p and D̄
    pub(crate) v: V,
    pub(crate) d: V,
    /// z1 = z0 + Δz and w1
    pub(crate) q: V,
    pub(crate) p: V,
    pub(crate) w: V,
    /// H(z0), where λ is part of the equation, and H(z1)
    pub(super) start: V::Scalar,
    pub(super) energy: V::Scalar,
    /// ∇H at z1 or z0; scratch space for D in `drag_along`
    pub(super) end_slopes: [V; 2],
    /// A copy of Δz to restore
    pub(super) kept: [V; 2],
    /// The residual of each equation, then the correction
    pub(crate) missing: [Vec<f64>; 2],
    /// ∂λ/∂Δz and h (-Δp, Δq), the factors of the rank-one part of the Jacobian; the latter
    /// multiplied by the inverse of the remaining Jacobian
    lambda_slope: [Vec<f64>; 2],
    column: [Vec<f64>; 2],
    /// h/2 times the largest second derivative at the start of the iteration: the factor by which a
    /// rounding of q enters p, and of p enters q
    pub(crate) gain: f64,
    /// The largest entry of R Δp, R = ∂D/∂v, at the last Jacobian: the factor by which λ enters D
    pub(super) dragged: f64,
    /// 1 + `lambda_slope` · `column`, the denominator of the Sherman-Morrison formula, if the
    /// rank-one part is present
    denominator: Option<f64>,
    /// The largest roundings of H and of the forces measured in the run.
    pub(super) measured: EnergyRounding<V::Scalar>,
    pub(super) measured_force: ForceRounding<V::Scalar>,
    /// The roundings times 1/ε of H, of the numerator of λ beyond |H|, and of the forces, once an
    /// iteration has stalled.
    pub(super) energy_rounding: f64,
    pub(super) lambda_rounding: f64,
    pub(crate) force_rounding: f64,
}

impl<V: Vector> Workspace<V> {
    /// The memory of the method `name` for a system.
    pub(crate) fn new<S>(
        name: &'static str,
        system: &S,
        solver: Option<LinearSolver>,
        has_lambda: bool,
    ) -> Result<Self, InputError>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let n = system.dof();
        let zeros = || V::zeros(n);
        let reals = || [vec![0.0; n], vec![0.0; n]];
        Ok(Self {
            jacobian: Jacobian::new(name, system, solver)?,
            dissipative: !system.dissipation_form().zero,
            free: n - system.motors(),
            has_motors: system.motors() > 0,
            has_lambda,
            dq: zeros(),
            dp: zeros(),
            q_mean: zeros(),
            p_mean: zeros(),
            hq: zeros(),
            hp: zeros(),
            v: zeros(),
            d: zeros(),
            q: zeros(),
            p: zeros(),
            w: zeros(),
            start: V::Scalar::zero(),
            energy: V::Scalar::zero(),
            end_slopes: [zeros(), zeros()],
            kept: [zeros(), zeros()],
            missing: reals(),
            lambda_slope: reals(),
            column: reals(),
            gain: 0.0,
            dragged: 0.0,
            denominator: None,
            measured: EnergyRounding::new(n),
            measured_force: ForceRounding::new(n),
            energy_rounding: 0.0,
            lambda_rounding: 0.0,
            force_rounding: 0.0,
        })
    }

    /// Sets Δz = 0.
    pub(super) fn initial_guess(&mut self) {
        self.dq.as_mut_slice().fill(V::Scalar::zero());
        self.dp.as_mut_slice().fill(V::Scalar::zero());
    }

    /// Sets z̄ and z1 from Δz.
    pub(super) fn place(&mut self, state: &State<V>) {
        let n = state.dof();
        let sides = [
            (&state.q, &self.dq, &mut self.q_mean, &mut self.q),
            (&state.p, &self.dp, &mut self.p_mean, &mut self.p),
        ];
        for (start, increment, mean, end) in sides {
            let (start, increment) = (&start.as_slice()[..n], &increment.as_slice()[..n]);
            let (mean, end) = (&mut mean.as_mut_slice()[..n], &mut end.as_mut_slice()[..n]);
            for j in 0..n {
                mean[j] = start[j] + increment[j].half();
                end[j] = start[j] + increment[j];
            }
        }
    }

    /// Evaluates ∇H at z̄.
    pub(crate) fn evaluate<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let (q, p) = (self.q_mean.as_slice(), self.p_mean.as_slice());
        system.gradient(q, p, self.hq.as_mut_slice(), self.hp.as_mut_slice());
    }

    /// Computes λ at Δz.
    pub(super) fn lambda<S>(&self, system: &S) -> Lambda<V::Scalar>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        if !self.has_lambda {
            return Lambda::zero();
        }
        let [along_q, square_q] = products(self.dq.as_slice(), self.hq.as_slice());
        let [along_p, square_p] = products(self.dp.as_slice(), self.hp.as_slice());
        let along = along_q + along_p;
        let square = if self.has_motors { self.square_of_free() } else { square_q + square_p };
        let energies = || [self.start, system.energy(self.q.as_slice(), self.p.as_slice())];
        Lambda::of(along, square, energies, self.lambda_rounding)
    }

    /// |Δz|² without the motors.
    #[cold]
    fn square_of_free(&self) -> V::Scalar {
        let [dq, dp] = [&self.dq, &self.dp].map(|d| &d.as_slice()[..self.free]);
        dot(dq, dq) + dot(dp, dp)
    }

    /// Evaluates and factorises the Jacobian at z̄. The error is the degree of freedom of a
    /// vanishing pivot.
    pub(super) fn factorise<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        lambda: &Lambda<V::Scalar>,
    ) -> Result<(), usize>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let (h, value) = (h.to_f64(), lambda.value.to_f64());
        (self.denominator, self.dragged) = (None, 0.0);
        let (q, p) = (self.q_mean.as_slice(), self.p_mean.as_slice());
        self.jacobian.factorise(system, h, value, q, p)?;
        if lambda.inverse == 0.0 {
            return Ok(());
        }
        self.differentiate_lambda(system, lambda);
        self.solve_column(system, h);
        Ok(())
    }

    /// Computes `lambda_slope`, ∂λ/∂Δz = [∇H(z1) - ∇H(z̄) - ½ ∇∇H(z̄) Δz - 2 λ Δz] / |Δz|², and
    /// leaves Δz in `column`.
    fn differentiate_lambda<S>(&mut self, system: &S, lambda: &Lambda<V::Scalar>)
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let value = lambda.value.to_f64();
        let [hq, hp] = &mut self.end_slopes;
        system.gradient(self.q.as_slice(), self.p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
        let [column_q, column_p] = &mut self.column;
        for (to, from) in [(&mut *column_q, &self.dq), (&mut *column_p, &self.dp)] {
            for (to, from) in to.iter_mut().zip(from.as_slice()) {
                *to = from.to_f64();
            }
        }
        let [slope_q, slope_p] = &mut self.lambda_slope;
        slope_q.fill(0.0);
        slope_p.fill(0.0);
        self.jacobian.add_half_hessian([column_q, column_p], [slope_q, slope_p]);
        let sides =
            [(&mut *slope_q, &self.hq, &*hq, &self.dq), (&mut *slope_p, &self.hp, &*hp, &self.dp)];
        for (slope, mean, end, increment) in sides {
            let given = mean.as_slice().iter().zip(end.as_slice()).zip(increment.as_slice());
            for (slope, ((&mean, &end), &increment)) in slope.iter_mut().zip(given) {
                let twice = 2.0 * value * increment.to_f64();
                *slope = ((end - mean).to_f64() - *slope - twice) * lambda.inverse;
            }
            if self.has_motors {
                // Their increments are not part of |Δz|².
                let motors = self.free..slope.len();
                for (slope, &increment) in
                    slope[motors.clone()].iter_mut().zip(&increment.as_slice()[motors])
                {
                    *slope += 2.0 * value * increment.to_f64() * lambda.inverse;
                }
            }
        }
    }

    /// Replaces Δz in `column` by h (-Δp, Δq + R Δp) multiplied by the inverse of the remaining
    /// Jacobian, and computes the denominator.
    fn solve_column<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S, h: f64) {
        let [column_q, column_p] = &mut self.column;
        std::mem::swap(column_q, column_p);
        column_q.iter_mut().for_each(|x| *x *= -h);
        column_p.iter_mut().for_each(|x| *x *= h);
        if self.has_motors {
            column_q[self.free..].fill(0.0);
            column_p[self.free..].fill(0.0);
        }
        if self.dissipative {
            self.drag_along(system, h);
        }
        let ([slope_q, slope_p], [column_q, column_p]) = (&self.lambda_slope, &mut self.column);
        self.jacobian.solve(column_q, column_p);
        self.denominator = Some(1.0 + dot(slope_q, column_q) + dot(slope_p, column_p));
    }

    /// Adds h R Δp, the derivative of h D̄ with respect to λ. The difference quotient of D is exact
    /// where D is linear in v.
    fn drag_along<S: Curvature<V::Scalar> + ?Sized>(&mut self, system: &S, h: f64) {
        let [near, far] = &mut self.end_slopes;
        let (q, p, v) = (self.q_mean.as_slice(), self.p_mean.as_slice(), self.v.as_mut_slice());
        system.dissipation(q, p, self.hp.as_slice(), near.as_mut_slice());
        for ((v, &hp), &dp) in v.iter_mut().zip(self.hp.as_slice()).zip(self.dp.as_slice()) {
            *v = hp + dp;
        }
        if self.has_motors {
            v[self.free..].copy_from_slice(&self.hp.as_slice()[self.free..]);
        }
        system.dissipation(q, p, v, far.as_mut_slice());
        for ((x, &near), &far) in self.column[1].iter_mut().zip(near.as_slice()).zip(far.as_slice())
        {
            let drag = (far - near).to_f64();
            *x = h.mul_add(drag, *x);
            self.dragged = self.dragged.max(drag.abs());
        }
    }

    /// Computes D̄ = D(z̄) at the mean velocity in `v`.
    pub(super) fn dissipate<S: System<V::Scalar> + ?Sized>(&mut self, system: &S) {
        let (q, p, v) = (self.q_mean.as_slice(), self.p_mean.as_slice(), self.v.as_slice());
        system.dissipation(q, p, v, self.d.as_mut_slice());
    }

    /// Computes the residual of the equation at Δz.
    pub(crate) fn residual<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        &Lambda { value: lambda, .. }: &Lambda<V::Scalar>,
    ) {
        let n = self.missing[0].len();
        let (v, dp, hp) =
            (&mut self.v.as_mut_slice()[..n], &self.dp.as_slice()[..n], &self.hp.as_slice()[..n]);
        for j in 0..n {
            v[j] = lambda.mul_add(dp[j], hp[j]);
        }
        if self.has_motors {
            v[self.free..].copy_from_slice(&hp[self.free..]);
        }
        if self.dissipative {
            self.dissipate(system);
        }
        let [a, b] = &mut self.missing;
        let (dq, dp) = (&self.dq.as_slice()[..n], &self.dp.as_slice()[..n]);
        let (hq, v) = (&self.hq.as_slice()[..n], &self.v.as_slice()[..n]);
        // D stays 0 for systems without dissipation.
        let d = &self.d.as_slice()[..n];
        for j in 0..n {
            a[j] = h.mul_add(v[j], -dq[j]).to_f64();
            b[j] = (-h).mul_add(lambda.mul_add(dq[j], hq[j]) + d[j], -dp[j]).to_f64();
        }
        if self.has_motors {
            for j in self.free..n {
                b[j] = (-h).mul_add(hq[j] + d[j], -dp[j]).to_f64();
            }
        }
    }

    /// Solves for the correction by the Sherman-Morrison formula.
    pub(super) fn solve(&mut self) {
        let [a, b] = &mut self.missing;
        self.jacobian.solve(a, b);
        if let Some(denominator) = self.denominator {
            let [slope_q, slope_p] = &self.lambda_slope;
            let share = (dot(slope_q, a) + dot(slope_p, b)) / denominator;
            for (x, column) in [(a, &self.column[0]), (b, &self.column[1])] {
                for (x, column) in x.iter_mut().zip(column) {
                    *x = (-share).mul_add(*column, *x);
                }
            }
        }
    }
}
