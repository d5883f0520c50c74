//! The second derivatives of H and the derivatives of D, from which the matrix of an implicit step
//! is made.
//!
//! The unknowns of a step are the corrections a of q and b of p. If H has no mixed derivatives and
//! Hpp is diagonal, a is eliminated; the matrix of the N unknowns b is tridiagonal if only
//! neighbours in a row are coupled. Otherwise the 2 N unknowns are ordered a_0, b_0, a_1, ..

use super::{LinearSolver, Matrix, Number, SMALL};
use crate::kernels::reductions::all_finite;
use afterbay_core::{Block, Curvature, InputError, Scalar};

/// The number of unknowns from which a ring is solved as one. `Small`, which has pivots, takes up to
/// 1.1 times as long below. A choice.
const SMALLEST_RING: usize = 5;
/// A matrix is treated as sparse if fewer than one in this many entries is nonzero. A choice.
const ENTRIES_A_NONZERO: usize = 8;

/// The reason for which a method refuses a system whose matrices cannot be made.
pub(crate) const NO_SUCH_DOF: &str =
    "a second derivative names a degree of freedom that does not exist";

/// Checks the degrees of freedom that the second derivatives of a system name.
///
/// # Errors
/// [`InputError::Unsupported`] if one of them does not exist.
pub(crate) fn check_derivatives<T, S>(method: &'static str, system: &S) -> Result<(), InputError>
where
    T: Scalar,
    S: Curvature<T> + ?Sized,
{
    let (n, mut exist) = (system.dof(), true);
    let origin = vec![T::zero(); n];
    system.curvature(&origin, &origin, |_, i, j, _| exist &= i < n && j < n);
    if exist { Ok(()) } else { Err(InputError::Unsupported { method, why: NO_SUCH_DOF }) }
}

/// A derivative, and its positions among the entries of the matrix. Only Hqp has a second one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Derivative {
    pub(crate) block: Block,
    pub(crate) i: usize,
    pub(crate) j: usize,
    pub(crate) slots: [usize; 2],
}

/// The derivatives of a system, in the order in which it provides them.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives {
    n: usize,
    list: Vec<Derivative>,
    values: Vec<f64>,
    eliminate: bool,
}

impl Derivatives {
    /// Finds the derivatives that a system has. The error is a degree of freedom that a derivative
    /// names and that does not exist.
    pub(crate) fn new<T, S>(system: &S) -> Result<Self, usize>
    where
        T: Scalar,
        S: Curvature<T> + ?Sized,
    {
        let n = system.dof();
        let origin = vec![T::zero(); n];
        let mut list = Vec::new();
        system.curvature(&origin, &origin, |block, i, j, _| {
            list.push(Derivative { block, i, j, slots: [0; 2] });
        });
        if let Some(most) = list.iter().map(|entry| entry.i.max(entry.j)).max()
            && most >= n
        {
            return Err(most);
        }
        let eliminate = list.iter().all(|entry| match entry.block {
            Block::Hqp => false,
            Block::Hpp => entry.i == entry.j,
            Block::Hqq | Block::Dq | Block::Dp => true,
        });
        Ok(Self { n, values: vec![0.0; list.len()], list, eliminate })
    }

    /// Whether a is eliminated.
    pub(crate) fn eliminate(&self) -> bool {
        self.eliminate
    }

    /// The number of unknowns.
    pub(crate) fn size(&self) -> usize {
        if self.eliminate { self.n } else { 2 * self.n }
    }

    /// Whether the matrix is tridiagonal.
    pub(crate) fn is_chain(&self) -> bool {
        self.eliminate && self.list.iter().all(|entry| entry.i.abs_diff(entry.j) <= 1)
    }

    /// Whether the matrix is tridiagonal but for entries in its corners.
    pub(crate) fn is_ring(&self) -> bool {
        let is_near = |entry: &Derivative| {
            let apart = entry.i.abs_diff(entry.j);
            apart <= 1 || apart + 1 == self.n
        };
        self.eliminate && self.list.iter().all(is_near)
    }

    /// The solver that suits the pattern of the matrix.
    pub(crate) fn solver(&self) -> LinearSolver {
        let size = self.size();
        if self.is_chain() {
            LinearSolver::Chain
        } else if size < SMALLEST_RING {
            LinearSolver::Small
        } else if self.is_ring() {
            LinearSolver::Ring
        } else if size <= SMALL {
            LinearSolver::Small
        } else if self.list.len().saturating_mul(ENTRIES_A_NONZERO) >= size * size {
            LinearSolver::Dense
        } else {
            LinearSolver::Sparse
        }
    }

    /// The rows and columns of the derivatives.
    pub(crate) fn pattern(&self) -> impl Iterator<Item = (usize, usize)> {
        self.list.iter().flat_map(|entry| places(entry, self.eliminate))
    }

    /// Finds the positions of the derivatives in a matrix of their pattern.
    pub(crate) fn locate<T: Number>(&mut self, matrix: &Matrix<T>) {
        for entry in &mut self.list {
            entry.slots = places(entry, self.eliminate)
                .map(|(row, column)| matrix.slot(row, column).unwrap_or(0));
        }
    }

    /// Evaluates the derivatives at (q, p). One that is not finite, as ∂F/∂t of √t at 0, is left
    /// out of the matrix, on which the solution does not depend.
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
        // In a pass of its own: the system's evaluation, compiled with the lines above, took a
        // quarter longer.
        if !all_finite(&self.values) {
            self.values.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
        }
    }

    /// The derivatives with their values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Derivative, f64)> {
        self.list.iter().zip(self.values.iter().copied())
    }

    /// The diagonal entries of Hpp, with their degrees of freedom.
    pub(crate) fn inertia(&self) -> impl Iterator<Item = (usize, f64)> {
        let parts = self.iter().filter(|(entry, _)| entry.block == Block::Hpp);
        parts.map(|(entry, value)| (entry.i, value))
    }

    /// The largest absolute value.
    pub(crate) fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
    }
}

/// The rows and columns of a derivative.
fn places(&Derivative { block, i, j, .. }: &Derivative, eliminate: bool) -> [(usize, usize); 2] {
    match block {
        _ if eliminate => [(i, j); 2],
        Block::Hqq | Block::Dq => [(2 * i + 1, 2 * j); 2],
        Block::Dp => [(2 * i + 1, 2 * j + 1); 2],
        Block::Hpp => [(2 * i, 2 * j + 1); 2],
        // ∂²H/∂q_i∂p_j is the derivative of ∂H/∂p_j with respect to q_i, and of ∂H/∂q_i with
        // respect to p_j.
        Block::Hqp => [(2 * j, 2 * i), (2 * i + 1, 2 * j + 1)],
    }
}
