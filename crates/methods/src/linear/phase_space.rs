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

use super::{LinearSolver, Matrix, Number, SMALL};
use afterbay_core::{Block, Curvature, InputError, Scalar};

/// The memory limit of one matrix, in bytes.
const MEMORY: f64 = 1e9;
/// A matrix is treated as sparse if fewer than one in this many entries is nonzero.
const FEW: usize = 8;

/// A derivative of the system, and its positions among the entries of the matrix. Only Hqp has a
/// second one.
#[derive(Clone, Copy, Debug)]
struct Derivative {
    block: Block,
    i: usize,
    j: usize,
    slots: [usize; 2],
}

/// The second derivatives of H and the derivatives of D at a point.
#[derive(Clone, Debug)]
pub(crate) struct PhaseSpace {
    size: usize,
    solver: LinearSolver,
    derivatives: Vec<Derivative>,
    values: Vec<f64>,
    /// Hpp, present if a is eliminated.
    inertia: Option<Vec<f64>>,
    diagonal: Vec<usize>,
}

impl PhaseSpace {
    /// Chooses the unknowns and the solver for a system.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if the matrix does not fit in memory, or a derivative names a
    /// degree of freedom that does not exist.
    pub(crate) fn new<T, S>(system: &S, method: &'static str) -> Result<Self, InputError>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let origin = vec![T::zero(); n];
        let mut derivatives = Vec::new();
        system.curvature(&origin, &origin, |block, i, j, _| {
            derivatives.push(Derivative { block, i, j, slots: [0; 2] });
        });
        if derivatives.iter().any(|entry| entry.i.max(entry.j) >= n) {
            let why = "a second derivative names a degree of freedom that does not exist";
            return Err(InputError::Unsupported { method, why });
        }
        let eliminates = derivatives.iter().all(|entry| match entry.block {
            Block::Hqp => false,
            Block::Hpp => entry.i == entry.j,
            Block::Hqq | Block::Dq | Block::Dp => true,
        });
        let chain = eliminates && derivatives.iter().all(|entry| entry.i.abs_diff(entry.j) <= 1);
        let size = if eliminates { n } else { 2 * n };
        let dense = size <= SMALL || derivatives.len().saturating_mul(FEW) >= size * size;
        let solver = match dense {
            _ if chain => LinearSolver::Chain,
            true if size <= SMALL => LinearSolver::Small,
            true => LinearSolver::Dense,
            false => LinearSolver::Sparse,
        };
        if solver == LinearSolver::Dense && 16.0 * (size as f64).powi(2) > MEMORY {
            let why = "the dense matrix of its step does not fit in memory";
            return Err(InputError::Unsupported { method, why });
        }
        let values = vec![0.0; derivatives.len()];
        let inertia = eliminates.then(|| vec![0.0; n]);
        let mut space =
            Self { size, solver, derivatives, values, inertia, diagonal: (0..size).collect() };
        let matrix = space.matrix::<f64>()?;
        let slot = |(row, column)| matrix.slot(row, column).unwrap_or(0);
        for entry in &mut space.derivatives {
            entry.slots = places(entry, eliminates).map(slot);
        }
        space.diagonal.iter_mut().for_each(|row| *row = slot((*row, *row)));
        Ok(space)
    }

    /// Allocates a matrix of the pattern of 1 - m J.
    pub(crate) fn matrix<T: Number>(&self) -> Result<Matrix<T>, InputError> {
        let eliminates = self.inertia.is_some();
        let pattern = self.derivatives.iter().flat_map(|entry| places(entry, eliminates));
        let diagonal = (0..self.size).map(|row| (row, row));
        Matrix::new(self.solver, self.size, pattern.chain(diagonal).collect())
    }

    /// The number of unknowns of the matrix.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// Evaluates the derivatives at (q, p).
    pub(crate) fn evaluate<T, S>(&mut self, system: &S, q: &[T], p: &[T])
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let mut next = self.values.iter_mut();
        system.curvature(q, p, |_, _, _, value| {
            if let Some(place) = next.next() {
                *place = value.to_f64();
            }
        });
        if let Some(inertia) = &mut self.inertia {
            inertia.fill(0.0);
            for (entry, value) in self.derivatives.iter().zip(&self.values) {
                if entry.block == Block::Hpp {
                    inertia[entry.i] += value;
                }
            }
        }
    }

    /// Factorises 1 - m J. The error is the degree of freedom of a vanishing pivot.
    pub(crate) fn factorise<T: Number>(&self, m: T, matrix: &mut Matrix<T>) -> Result<(), usize> {
        let (to, square) = (matrix.values(), m * m);
        to.fill(T::ZERO);
        self.diagonal.iter().for_each(|&slot| to[slot] = T::real(1.0));
        for (&Derivative { block, j, slots: [first, second], .. }, &value) in
            self.derivatives.iter().zip(&self.values)
        {
            match (block, &self.inertia) {
                (Block::Hqq | Block::Dq, Some(inertia)) => {
                    to[first] += square * T::real(value * inertia[j]);
                }
                (Block::Hpp, Some(_)) => {}
                (Block::Hpp, None) => to[first] -= m * T::real(value),
                (Block::Hqq | Block::Dq | Block::Dp, _) => to[first] += m * T::real(value),
                (Block::Hqp, _) => {
                    to[first] -= m * T::real(value);
                    to[second] += m * T::real(value);
                }
            }
        }
        let rows = if self.inertia.is_some() { 1 } else { 2 };
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
        let Some(inertia) = &self.inertia else {
            for ((pair, a), b) in unknowns.as_chunks_mut::<2>().0.iter_mut().zip(&*a).zip(&*b) {
                *pair = [*a, *b];
            }
            matrix.solve(unknowns);
            for ((pair, a), b) in unknowns.as_chunks::<2>().0.iter().zip(a).zip(b) {
                [*a, *b] = *pair;
            }
            return;
        };
        for (&Derivative { block, i, j, .. }, &value) in self.derivatives.iter().zip(&self.values) {
            if matches!(block, Block::Hqq | Block::Dq) {
                b[i] -= m * a[j] * T::real(value);
            }
        }
        matrix.solve(b);
        for ((a, b), &inertia) in a.iter_mut().zip(&*b).zip(inertia) {
            *a += m * *b * T::real(inertia);
        }
    }

    /// Writes Dq a + Dp b to `to`.
    pub(crate) fn friction(&self, a: &[f64], b: &[f64], to: &mut [f64]) {
        to.fill(0.0);
        for (&Derivative { block, i, j, .. }, value) in self.derivatives.iter().zip(&self.values) {
            match block {
                Block::Dq => to[i] += value * a[j],
                Block::Dp => to[i] += value * b[j],
                Block::Hqq | Block::Hqp | Block::Hpp => {}
            }
        }
    }
}

/// The positions of a derivative in the matrix: those of b if a is eliminated, and otherwise in the
/// order a_0, b_0, a_1, ..
fn places(&Derivative { block, i, j, .. }: &Derivative, eliminates: bool) -> [(usize, usize); 2] {
    match block {
        _ if eliminates => [(i, j); 2],
        Block::Hqq | Block::Dq => [(2 * i + 1, 2 * j); 2],
        Block::Dp => [(2 * i + 1, 2 * j + 1); 2],
        Block::Hpp => [(2 * i, 2 * j + 1); 2],
        // ∂²H/∂q_i∂p_j is the derivative of ∂H/∂p_j by q_i, and of ∂H/∂q_i by p_j.
        Block::Hqp => [(2 * j, 2 * i), (2 * i + 1, 2 * j + 1)],
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
    /// Evaluates the derivatives at (q, p).
    #[inline(always)]
    pub(crate) fn evaluate<T, S>(&mut self, system: &S, q: &[T], p: &[T])
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let [mut hqq, mut hqp, mut hpp, mut dq, mut dp] = [0.0; 5];
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
