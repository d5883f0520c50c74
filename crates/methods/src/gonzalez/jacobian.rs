//! The Jacobian of the step's equation and the solution of the linear equations, in `f64`.
//!
//! With c = h/2 and the second derivatives at z̄, the correction (δq, δp) to a residual (a, b) is
//!
//! ```text
//! δq - c Hpq δq - (c Hpp + hλ) δp = a        δp + (c (Hqq + Dq) + hλ) δq + c (Hqp + Dp) δp = b
//! ```
//!
//! The derivative of λ is left out here. If H has no mixed derivatives and Hpp is diagonal, δq = a
//! + C δp with C = c Hpp + hλ is eliminated, and N unknowns remain:
//!
//! ```text
//! [1 + R C + S C] δp = b - S a        S = c (Hqq + Dq) + hλ        R = Dp Hpp⁻¹
//! ```
//!
//! R = ∂D/∂v, because D̄ is evaluated at the mean velocity, which contains λ Δp. Where Hpp is 0, R
//! C is replaced by c Dp. If δq is not eliminated, hλR is omitted: obtaining R from Dp would
//! require a linear solve, and the omission only costs corrections.

use crate::linear::{Derivative, Derivatives, LinearSolver, Matrix};
use afterbay_core::{Block, Curvature, InputError, Scalar};

/// The data for the elimination of δq.
#[derive(Clone, Debug)]
struct Eliminated {
    /// C, and C Hpp⁻¹
    c: Vec<[f64; 2]>,
    /// S, stored like the matrix
    s: Vec<f64>,
}

/// The matrix, its factors, and the derivatives it is made of.
#[derive(Clone, Debug)]
pub(super) struct Jacobian {
    derivatives: Derivatives,
    /// Present if δq is eliminated.
    eliminated: Option<Eliminated>,
    /// The positions of ∂a_i/∂q_i, ∂b_i/∂p_i, ∂a_i/∂p_i, ∂b_i/∂q_i; four equal positions if δq is
    /// eliminated.
    diagonal: Vec<[usize; 4]>,
    matrix: Matrix,
    unknowns: Vec<f64>,
    /// The number of degrees of freedom before the motors of a drive, whose equations have no λ.
    free: usize,
    half_h: f64,
    h_lambda: f64,
}

impl Jacobian {
    /// The matrix for a system. `method` is named by the errors.
    pub(super) fn new<T, S>(
        method: &'static str,
        system: &S,
        wanted: Option<LinearSolver>,
    ) -> Result<Self, InputError>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let unsupported = |why| InputError::Unsupported { method, why };
        let mut derivatives = Derivatives::new(system)
            .map_err(|_| unsupported("a second derivative belongs to no degree of freedom"))?;
        let (eliminate, size) = (derivatives.eliminate(), derivatives.size());
        let solver = wanted.unwrap_or_else(|| derivatives.solver());
        if solver == LinearSolver::Chain && !derivatives.is_chain()
            || solver == LinearSolver::Ring && !derivatives.is_ring()
        {
            return Err(unsupported("Thomas' algorithm is for chains and rings with separable H"));
        }

        let own = |i: usize| match eliminate {
            true => [(i, i); 4],
            false => {
                [(2 * i, 2 * i), (2 * i + 1, 2 * i + 1), (2 * i, 2 * i + 1), (2 * i + 1, 2 * i)]
            }
        };
        let pattern = derivatives.pattern().chain((0..n).flat_map(own)).collect();
        let mut matrix = Matrix::new(solver, size, pattern)?;
        derivatives.locate(&matrix);
        let slot = |(row, column)| matrix.slot(row, column).unwrap_or(0);
        let diagonal = (0..n).map(|i| own(i).map(slot)).collect();
        Ok(Self {
            derivatives,
            eliminated: eliminate
                .then(|| Eliminated { c: vec![[0.0; 2]; n], s: vec![0.0; matrix.values().len()] }),
            diagonal,
            matrix,
            unknowns: vec![0.0; size],
            free: n - system.motors(),
            half_h: 0.0,
            h_lambda: 0.0,
        })
    }

    /// Evaluates the derivatives at (q, p) and factorises the matrix. The error is the degree of
    /// freedom of a vanishing pivot.
    pub(super) fn factorise<T, S>(
        &mut self,
        system: &S,
        h: f64,
        lambda: f64,
        q: &[T],
        p: &[T],
    ) -> Result<(), usize>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        (self.half_h, self.h_lambda) = (0.5 * h, h * lambda);
        self.derivatives.evaluate(system, q, p);
        if self.fill_eliminated() {
            return self.matrix.factorise();
        }
        self.fill_pairs();
        self.matrix.factorise().map_err(|row| row / 2)
    }

    /// Sets C, S and the matrix, if δq is eliminated. Returns whether it is.
    #[inline(always)]
    fn fill_eliminated(&mut self) -> bool {
        let (half_h, h_lambda) = (self.half_h, self.h_lambda);
        let Some(Eliminated { c, s }) = &mut self.eliminated else { return false };
        let to = self.matrix.values();
        to.fill(0.0);
        // Slices, whose addresses and lengths stay in registers.
        let (c, s) = (c.as_mut_slice(), s.as_mut_slice());
        c.fill([0.0; 2]);
        s.fill(0.0);
        self.derivatives.inertia().for_each(|(i, value)| c[i][0] += value);
        for [c, share] in &mut c[..self.free] {
            *share = if *c == 0.0 { half_h } else { half_h + h_lambda / *c };
            *c = half_h.mul_add(*c, h_lambda);
        }
        c[self.free..].fill([0.0, half_h]);
        for (&Derivative { block, j, slots: [slot, _], .. }, value) in self.derivatives.iter() {
            match block {
                Block::Hqq | Block::Dq => {
                    let value = half_h * value;
                    s[slot] += value;
                    to[slot] = value.mul_add(c[j][0], to[slot]);
                }
                Block::Dp => to[slot] = value.mul_add(c[j][1], to[slot]),
                Block::Hqp | Block::Hpp => {}
            }
        }
        for (j, (own, [c, _])) in self.diagonal.iter().zip(c).enumerate() {
            let h_lambda = if j < self.free { h_lambda } else { 0.0 };
            s[own[0]] += h_lambda;
            to[own[0]] += h_lambda.mul_add(*c, 1.0);
        }
        true
    }

    /// Sets the matrix of δq and δp.
    #[inline(always)]
    fn fill_pairs(&mut self) {
        let (half_h, h_lambda) = (self.half_h, self.h_lambda);
        let to = self.matrix.values();
        to.fill(0.0);
        for (&Derivative { block, slots: [first, second], .. }, value) in self.derivatives.iter() {
            let value = half_h * value;
            match block {
                Block::Hqq | Block::Dq | Block::Dp => to[first] += value,
                Block::Hpp => to[first] -= value,
                Block::Hqp => {
                    to[first] -= value;
                    to[second] += value;
                }
            }
        }
        for (j, own) in self.diagonal.iter().enumerate() {
            let h_lambda = if j < self.free { h_lambda } else { 0.0 };
            for (slot, value) in own.iter().zip([1.0, 1.0, -h_lambda, h_lambda]) {
                to[*slot] += value;
            }
        }
    }

    /// Replaces the residual (a, b) by the correction (δq, δp).
    pub(super) fn solve(&mut self, a: &mut [f64], b: &mut [f64]) {
        let x = &mut self.unknowns;
        let Some(Eliminated { c, s }) = &self.eliminated else {
            return self.matrix.solve_pairs([a, b], x);
        };
        x.copy_from_slice(b);
        self.matrix.subtract(s, a, x);
        self.matrix.solve(x);
        for (((x, [c, _]), a), b) in x.iter().zip(c).zip(a).zip(b) {
            *a = c.mul_add(*x, *a);
            *b = *x;
        }
    }

    /// Adds ½ ∇∇H (x, y) to (u, v).
    pub(super) fn add_half_hessian(&self, [x, y]: [&[f64]; 2], [u, v]: [&mut [f64]; 2]) {
        for (&Derivative { block, i, j, .. }, value) in self.derivatives.iter() {
            let half = 0.5 * value;
            match block {
                Block::Hqq => u[i] = half.mul_add(x[j], u[i]),
                Block::Hpp => v[i] = half.mul_add(y[j], v[i]),
                Block::Hqp => {
                    u[i] = half.mul_add(y[j], u[i]);
                    v[j] = half.mul_add(x[i], v[j]);
                }
                Block::Dq | Block::Dp => {}
            }
        }
    }

    /// h/2 times the largest derivative: the relative change of z in one step caused by a change of
    /// z.
    pub(super) fn gain(&self) -> f64 {
        self.half_h.abs() * self.derivatives.largest()
    }
}
