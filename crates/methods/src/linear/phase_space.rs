//! The equations (1 - m J) (a, b) = (r, s) of an implicit step, where J is the Jacobian of (∂H/∂p,
//! -∂H/∂q - D), and m is a real or complex multiple of the step.
//!
//! ```text
//! a - m (Hpq a + Hpp b) = r        b + m (S a + (Hqp + Dp) b) = s        S = Hqq + Dq
//! ```
//!
//! If H has no mixed derivatives and Hpp is diagonal, `a = r + m Hpp b` is eliminated, and N
//! unknowns remain:
//!
//! ```text
//! (1 + m Dp + m² S Hpp) b = s - m S r
//! ```
//!
//! The matrix is tridiagonal if only neighbours in a row are coupled, sparse if it has few entries,
//! and dense otherwise. With one degree of freedom a [`Plane`] solves the equations in closed form.

use super::{Derivative, Derivatives, LinearSolver, Matrix, Number};
use afterbay_core::{Block, Curvature, InputError, Scalar};

/// The memory limit for the dense matrices of a step, in bytes. A choice.
const MOST_BYTES: f64 = 4e9;

/// The reason why the equations of a system cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unsolvable {
    /// A derivative names this degree of freedom, which does not exist.
    NoSuchDof(usize),
    /// The matrices do not fit in memory.
    TooLarge { unknowns: usize, bytes: f64 },
}

/// The second derivatives of H and the derivatives of D at a point.
#[derive(Clone, Debug)]
pub(crate) struct PhaseSpace {
    solver: LinearSolver,
    derivatives: Derivatives,
    /// Hpp, present if a is eliminated.
    inertia: Option<Vec<f64>>,
    diagonal: Vec<usize>,
}

impl PhaseSpace {
    /// Chooses the unknowns and the solver for a system. `count` is the number of matrices that
    /// will be allocated.
    pub(crate) fn new<T, S>(system: &S, count: usize) -> Result<Self, Unsolvable>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let derivatives = Derivatives::new(system).map_err(Unsolvable::NoSuchDof)?;
        let (size, solver) = (derivatives.size(), derivatives.solver());
        let bytes = 16.0 * (count * size) as f64 * size as f64;
        if solver == LinearSolver::Dense && bytes > MOST_BYTES {
            return Err(Unsolvable::TooLarge { unknowns: size, bytes });
        }
        let inertia = derivatives.eliminate().then(|| vec![0.0; size]);
        let mut space = Self { solver, derivatives, inertia, diagonal: Vec::new() };
        let too_large = |_| Unsolvable::TooLarge { unknowns: size, bytes };
        let matrix = space.matrix::<f64>().map_err(too_large)?;
        space.derivatives.locate(&matrix);
        space.diagonal = (0..size).map(|row| matrix.slot(row, row).unwrap_or(0)).collect();
        Ok(space)
    }

    /// Allocates a matrix of the pattern of 1 - m J.
    pub(crate) fn matrix<T: Number>(&self) -> Result<Matrix<T>, InputError> {
        let size = self.size();
        let diagonal = (0..size).map(|row| (row, row));
        Matrix::new(self.solver, size, self.derivatives.pattern().chain(diagonal).collect())
    }

    /// The number of unknowns of the matrix.
    pub(crate) fn size(&self) -> usize {
        self.derivatives.size()
    }

    /// The largest absolute derivative.
    pub(crate) fn largest(&self) -> f64 {
        self.derivatives.largest()
    }

    /// Evaluates the derivatives at (q, p).
    pub(crate) fn evaluate<T, S>(&mut self, system: &S, q: &[T], p: &[T])
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        self.derivatives.evaluate(system, q, p);
        if let Some(inertia) = &mut self.inertia {
            inertia.fill(0.0);
            self.derivatives.inertia().for_each(|(i, value)| inertia[i] += value);
        }
    }

    /// Factorises 1 - m J. The error is the degree of freedom of a vanishing pivot.
    pub(crate) fn factorise<T: Number>(&self, m: T, matrix: &mut Matrix<T>) -> Result<(), usize> {
        let (to, square, inertia) = (matrix.values(), m * m, self.inertia.as_deref());
        to.fill(T::ZERO);
        self.diagonal.iter().for_each(|&slot| to[slot] = T::real(1.0));
        for (&Derivative { block, j, slots: [first, second], .. }, value) in self.derivatives.iter()
        {
            match (block, inertia) {
                (Block::Hqq | Block::Dq, Some(inertia)) => {
                    to[first] += square.scaled(value * inertia[j]);
                }
                (Block::Hpp, Some(_)) => {}
                (Block::Hpp, None) => to[first] -= m.scaled(value),
                (Block::Hqq | Block::Dq | Block::Dp, _) => to[first] += m.scaled(value),
                (Block::Hqp, _) => {
                    to[first] -= m.scaled(value);
                    to[second] += m.scaled(value);
                }
            }
        }
        let rows = if inertia.is_some() { 1 } else { 2 };
        matrix.factorise().map_err(|row| row / rows)
    }

    /// Replaces (r, s) in a and b by the solution. `unknowns` is overwritten.
    pub(crate) fn solve<T: Number>(
        &self,
        m: T,
        matrix: &mut Matrix<T>,
        [a, b]: [&mut [T]; 2],
        unknowns: &mut [T],
    ) {
        let Some(inertia) = &self.inertia else { return matrix.solve_pairs([a, b], unknowns) };
        for (entry, value) in self.derivatives.iter() {
            if matches!(entry.block, Block::Hqq | Block::Dq) {
                b[entry.i] -= (m * a[entry.j]).scaled(value);
            }
        }
        matrix.solve(b);
        for ((a, b), &inertia) in a.iter_mut().zip(&*b).zip(inertia) {
            *a += (m * *b).scaled(inertia);
        }
    }

    /// Writes bounds of the changes of ∂H/∂p and of ∂H/∂q + D when q and p change by no more than
    /// these amounts.
    pub(crate) fn changes(&self, [q, p]: [&[f64]; 2], [velocities, forces]: [&mut [f64]; 2]) {
        velocities.fill(0.0);
        forces.fill(0.0);
        for (&Derivative { block, i, j, .. }, value) in self.derivatives.iter() {
            let value = value.abs();
            match block {
                Block::Hqq | Block::Dq => forces[i] += value * q[j],
                Block::Dp => forces[i] += value * p[j],
                Block::Hpp => velocities[i] += value * p[j],
                Block::Hqp => {
                    forces[i] += value * p[j];
                    velocities[j] += value * q[i];
                }
            }
        }
    }

    /// Writes Dq a + Dp b to `to`.
    pub(crate) fn friction(&self, a: &[f64], b: &[f64], to: &mut [f64]) {
        to.fill(0.0);
        for (entry, value) in self.derivatives.iter() {
            match entry.block {
                Block::Dq => to[entry.i] += value * a[entry.j],
                Block::Dp => to[entry.i] += value * b[entry.j],
                Block::Hqq | Block::Hqp | Block::Hpp => {}
            }
        }
    }
}

/// The derivatives of a system with one degree of freedom.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plane {
    /// S = Hqq + Dq
    stiffness: f64,
    mixed: f64,
    inertia: f64,
    /// Dq and Dp
    friction: [f64; 2],
}

impl Plane {
    /// Evaluates the derivatives at (q, p). One that is not finite is left out, as it is of
    /// [`Derivatives`].
    #[inline(always)]
    pub(crate) fn evaluate<T, S>(&mut self, system: &S, q: &[T], p: &[T])
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let [mut hqq, mut hqp, mut hpp, mut dq, mut dp] = [0.0_f64; 5];
        system.curvature(q, p, |block, _, _, value| {
            let value = value.to_f64();
            match block {
                Block::Hqq => hqq += value,
                Block::Hqp => hqp += value,
                Block::Hpp => hpp += value,
                Block::Dq => dq += value,
                Block::Dp => dp += value,
            }
        });
        for x in [&mut hqq, &mut hqp, &mut hpp, &mut dq, &mut dp] {
            *x = if x.is_finite() { *x } else { 0.0 };
        }
        *self = Self { stiffness: hqq + dq, mixed: hqp, inertia: hpp, friction: [dq, dp] };
    }

    /// The inverse of 1 - m J, by rows; not finite if it does not exist.
    #[inline(always)]
    pub(crate) fn inverse<T: Number>(&self, m: T) -> [T; 4] {
        let Self { stiffness, mixed, inertia, friction: [_, dp] } = *self;
        let one = T::real(1.0);
        let (a, d) = (m.fused(T::real(-mixed), one), m.fused(T::real(mixed + dp), one));
        let (b, c) = (m * T::real(-inertia), m * T::real(stiffness));
        let scale = (-b).fused(c, a * d).inverse();
        [d * scale, -b * scale, -c * scale, a * scale]
    }

    /// Dq a + Dp b
    #[inline(always)]
    pub(crate) fn friction(&self, a: f64, b: f64) -> f64 {
        self.friction[0].mul_add(a, self.friction[1] * b)
    }
}
