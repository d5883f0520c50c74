//! The linear equations of the simplified Newton iteration.
//!
//! With J the Jacobian at one point of the step (`solve.rs`), the correction ΔZ for the residual R
//! solves `(1 - h A ⊗ J) ΔZ = R`. The eigenvectors of A decouple the stages: for each eigenvalue μ,
//! the component x of ΔZ along it satisfies `(1 - h μ J) x = left · R` ([`PhaseSpace`]), and ΔZ is
//! the real part of Σ right x. (Hairer, Wanner II, IV.8.) The equations are solved in `f64`,
//! whatever the scalar: an approximate Jacobian costs corrections but no accuracy.

use super::tables::Tables;
use crate::linear::{Matrix, NO_SUCH_DOF, Number, PhaseSpace, Plane, Unsolvable};
use afterbay_core::{Curvature, InputError, Scalar, StepFailure, Vector};
use faer::c64;
use std::array::from_fn;

/// The matrices of a step.
#[derive(Clone, Debug)]
pub(super) enum Equations<const S: usize> {
    /// One degree of freedom.
    Plane(Box<InPlane<S>>),
    /// Several degrees of freedom.
    Space(Box<InSpace<S>>),
}

/// The inverse matrices for one degree of freedom.
#[derive(Clone, Copy, Debug)]
pub(super) struct InPlane<const S: usize> {
    plane: Plane,
    real: [f64; 4],
    pairs: [[c64; 4]; 3],
    solution: [[f64; S]; 2],
}

/// The matrices for several degrees of freedom, and the memory of a solution.
#[derive(Clone, Debug)]
pub(super) struct InSpace<const S: usize> {
    space: PhaseSpace,
    /// h
    h: f64,
    real: Matrix<f64>,
    pairs: Vec<Matrix<c64>>,
    /// Of q and p, by degrees of freedom.
    residual: [Vec<[f64; S]>; 2],
    solution: [Vec<[f64; S]>; 2],
    a: Vec<f64>,
    b: Vec<f64>,
    unknowns: Vec<f64>,
    a_pair: Vec<c64>,
    b_pair: Vec<c64>,
    unknowns_pair: Vec<c64>,
}

impl<const S: usize> Equations<S> {
    /// Allocates the equations of a system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the matrices do not fit in memory, or a derivative names a
    /// degree of freedom that does not exist.
    pub(super) fn new<V, F>(system: &F) -> Result<Self, InputError>
    where
        V: Vector,
        F: Curvature<V::Scalar> + ?Sized,
    {
        if V::LEN == Some(1) {
            return Ok(Self::Plane(Box::new(InPlane {
                plane: Plane::default(),
                real: [0.0; 4],
                pairs: [[c64::ZERO; 4]; 3],
                solution: [[0.0; S]; 2],
            })));
        }
        let n = system.dof();
        let space = PhaseSpace::new(system, S / 2 + 1).map_err(|reason| {
            let why = match reason {
                Unsolvable::NoSuchDof(_) => NO_SUCH_DOF,
                Unsolvable::TooLarge { .. } => {
                    "the dense matrix of its step does not fit in memory"
                }
            };
            InputError::Unsupported { method: "adaptive-radau", why }
        })?;
        let pair = space.matrix()?;
        let zeros = || vec![c64::ZERO; n];
        Ok(Self::Space(Box::new(InSpace {
            h: 0.0,
            real: space.matrix()?,
            pairs: vec![pair; S / 2],
            residual: [(); 2].map(|()| vec![[0.0; S]; n]),
            solution: [(); 2].map(|()| vec![[0.0; S]; n]),
            a: vec![0.0; n],
            b: vec![0.0; n],
            unknowns: vec![0.0; space.size()],
            a_pair: zeros(),
            b_pair: zeros(),
            unknowns_pair: vec![c64::ZERO; space.size()],
            space,
        })))
    }

    /// Evaluates the derivatives at (q, p).
    #[inline(always)]
    pub(super) fn evaluate<V, F>(&mut self, system: &F, q: &V, p: &V)
    where
        V: Vector,
        F: Curvature<V::Scalar> + ?Sized,
    {
        match self {
            Self::Plane(it) => it.plane.evaluate(system, q.as_slice(), p.as_slice()),
            Self::Space(it) => it.space.evaluate(system, q.as_slice(), p.as_slice()),
        }
    }

    /// Factorises the matrices of the step h.
    ///
    /// # Errors
    /// [`StepFailure::Singular`] for a vanishing pivot.
    #[inline(always)]
    pub(super) fn factorise<T: Scalar>(
        &mut self,
        tables: &Tables<T, S>,
        h: f64,
    ) -> Result<(), StepFailure> {
        let failure = |dof| StepFailure::Singular { dof, slope: None };
        match self {
            Self::Plane(it) => {
                it.real = it.plane.inverse(h * tables.eigenvalue);
                for (to, pair) in it.pairs.iter_mut().zip(tables.pairs()) {
                    *to = it.plane.inverse(pair.eigenvalue * h);
                }
            }
            Self::Space(it) => {
                it.h = h;
                it.space.factorise(h * tables.eigenvalue, &mut it.real).map_err(failure)?;
                for (to, pair) in it.pairs.iter_mut().zip(tables.pairs()) {
                    it.space.factorise(pair.eigenvalue * h, to).map_err(failure)?;
                }
            }
        }
        Ok(())
    }

    /// Solves the equations for the residuals of q and p, which `residual` computes for each degree
    /// of freedom.
    #[inline(always)]
    pub(super) fn solve<T: Scalar>(
        &mut self,
        tables: &Tables<T, S>,
        n: usize,
        residual: impl Fn(usize) -> [[f64; S]; 2],
    ) {
        match self {
            Self::Plane(it) => it.solution = it.solve(tables, residual(0)),
            Self::Space(it) => {
                let InSpace { residual: [q, p], .. } = &mut **it;
                for d in 0..n {
                    [q[d], p[d]] = residual(d);
                }
                it.solve(tables);
            }
        }
    }

    /// The solution for a degree of freedom: the corrections of q and p.
    #[inline(always)]
    pub(super) fn solution(&self, d: usize) -> [[f64; S]; 2] {
        match self {
            Self::Plane(it) => it.solution,
            Self::Space(it) => [it.solution[0][d], it.solution[1][d]],
        }
    }

    /// Solves `(1 - h μ J) x = raw` with the real eigenvalue μ, and passes to `see`, for each
    /// degree of freedom, x_q, x_p and Dq x_q + Dp x_p.
    #[inline(always)]
    pub(super) fn filter<T: Scalar>(
        &mut self,
        tables: &Tables<T, S>,
        n: usize,
        raw: impl Fn(usize) -> [f64; 2],
        mut see: impl FnMut(usize, [f64; 3]),
    ) {
        match self {
            Self::Plane(it) => {
                let [a, b] = multiply(&it.real, raw(0));
                see(0, [a, b, it.plane.friction(a, b)]);
            }
            Self::Space(it) => {
                let InSpace { space, h, real, a, b, unknowns, .. } = &mut **it;
                for d in 0..n {
                    [a[d], b[d]] = raw(d);
                }
                let parts = [a.as_mut_slice(), b.as_mut_slice()];
                space.solve(*h * tables.eigenvalue, real, parts, unknowns);
                let unknowns = &mut unknowns[..n];
                space.friction(a, b, unknowns);
                for d in 0..n {
                    see(d, [a[d], b[d], unknowns[d]]);
                }
            }
        }
    }
}

/// The product of a matrix, by rows, and a vector.
#[inline(always)]
fn multiply<T: Number>(rows: &[T; 4], [a, b]: [T; 2]) -> [T; 2] {
    [rows[0].fused(a, rows[1] * b), rows[2].fused(a, rows[3] * b)]
}

/// Σ left_i x_i, the component of x along a complex pair of eigenvectors.
#[inline(always)]
fn along_pair<const S: usize>(left: &[c64; S], x: &[f64; S]) -> c64 {
    let [mut re, mut im] = [0.0; 2];
    for i in 0..S {
        re = left[i].re.mul_add(x[i], re);
        im = left[i].im.mul_add(x[i], im);
    }
    c64 { re, im }
}

/// Σ left_i x_i, the component of x along the real eigenvector.
#[inline(always)]
fn along_real<const S: usize>(left: &[f64; S], x: &[f64; S]) -> f64 {
    left.iter().zip(x).fold(0.0, |sum, (left, x)| left.mul_add(*x, sum))
}

/// Adds the real part of right_i x to each `to_i`.
#[inline(always)]
fn add<const S: usize>(right: &[c64; S], x: c64, to: &mut [f64; S]) {
    for i in 0..S {
        to[i] = right[i].re.mul_add(x.re, (-right[i].im).mul_add(x.im, to[i]));
    }
}

impl<const S: usize> InPlane<S> {
    #[inline(always)]
    fn solve<T: Scalar>(&self, tables: &Tables<T, S>, [q, p]: [[f64; S]; 2]) -> [[f64; S]; 2] {
        let right = [along_real(&tables.left, &q), along_real(&tables.left, &p)];
        let [a, b] = multiply(&self.real, right);
        let mut solution: [[f64; S]; 2] =
            [from_fn(|i| tables.right[i] * a), from_fn(|i| tables.right[i] * b)];
        for (matrix, pair) in self.pairs.iter().zip(tables.pairs()) {
            let [a, b] = multiply(matrix, [along_pair(&pair.left, &q), along_pair(&pair.left, &p)]);
            add(&pair.right, a, &mut solution[0]);
            add(&pair.right, b, &mut solution[1]);
        }
        solution
    }
}

impl<const S: usize> InSpace<S> {
    /// Computes the corrections for the residuals.
    fn solve<T: Scalar>(&mut self, tables: &Tables<T, S>) {
        let Self { space, h, residual: [r, s], solution: [q, p], .. } = self;
        let Self { real, a, b, unknowns, pairs, a_pair, b_pair, unknowns_pair, .. } = self;
        for (to, from) in [(&mut *a, &*r), (&mut *b, &*s)] {
            for (to, from) in to.iter_mut().zip(from) {
                *to = along_real(&tables.left, from);
            }
        }
        space.solve(*h * tables.eigenvalue, real, [a, b], unknowns);
        for (to, from) in [(&mut *q, &*a), (&mut *p, &*b)] {
            for (to, from) in to.iter_mut().zip(from) {
                *to = tables.right.map(|right| right * from);
            }
        }
        for (matrix, pair) in pairs.iter_mut().zip(tables.pairs()) {
            for (to, from) in [(&mut *a_pair, &*r), (&mut *b_pair, &*s)] {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = along_pair(&pair.left, from);
                }
            }
            space.solve(pair.eigenvalue * *h, matrix, [a_pair, b_pair], unknowns_pair);
            for (to, from) in [(&mut *q, &*a_pair), (&mut *p, &*b_pair)] {
                for (to, from) in to.iter_mut().zip(from) {
                    add(&pair.right, *from, to);
                }
            }
        }
    }
}
