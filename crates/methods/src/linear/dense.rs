//! Dense matrices: faer's blocked LU with partial pivoting.

use super::{Number, Solver, subtract_columns, usable};
use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{Conj, MatMut, MatRef, Par};
use std::mem::MaybeUninit;

/// The size of the largest matrix that is factorised on creation. Larger matrices use no other code
/// paths of faer.
const READY: usize = 256;

/// A dense matrix stored by columns, later its factors.
#[derive(Clone, Debug)]
pub(crate) struct Dense<T> {
    size: usize,
    values: Vec<T>,
    rows: Vec<usize>,
    rows_inverse: Vec<usize>,
    scratch: Vec<MaybeUninit<u8>>,
}

impl<T: Number> Dense<T> {
    pub(super) fn new(size: usize) -> Self {
        let factorising =
            factor::lu_in_place_scratch::<usize, T>(size, size, Par::Seq, Default::default());
        let solving = solve::solve_in_place_scratch::<usize, T>(size, 1, Par::Seq);
        let bytes = StackReq::or(factorising, solving).unaligned_bytes_required();
        let scratch = vec![MaybeUninit::uninit(); bytes];
        let (rows, rows_inverse) = ((0..size).collect(), (0..size).collect());
        let mut matrix =
            Self { size, values: vec![T::ZERO; size * size], rows, rows_inverse, scratch };
        // Factorises once, so that faer allocates its memory here rather than in a step. The matrix
        // is singular.
        let _ = matrix.factorise_leading(size.min(READY));
        matrix
    }
}

impl<T: Number> Dense<T> {
    /// Factorises the leading block of size n, where n is at most the size of the matrix.
    fn factorise_leading(&mut self, n: usize) -> Result<(), usize> {
        let Self { values, rows, rows_inverse, scratch, .. } = self;
        let matrix = MatMut::from_column_major_slice_mut(&mut values[..n * n], n, n);
        let (rows, rows_inverse) = (&mut rows[..n], &mut rows_inverse[..n]);
        factor::lu_in_place(
            matrix,
            rows,
            rows_inverse,
            Par::Seq,
            MemStack::new(scratch),
            Default::default(),
        );
        (0..n).find(|k| !usable(values[k * n + k])).map_or(Ok(()), Err)
    }
}

impl<T: Number> Solver<T> for Dense<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size).then_some(column * self.size + row)
    }

    fn values(&mut self) -> &mut [T] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        self.factorise_leading(self.size)
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        subtract_columns(values, a, x);
    }

    fn solve(&mut self, x: &mut [T]) {
        let n = self.size;
        let factors = MatRef::from_column_major_slice(&self.values, n, n);
        let rows = PermRef::new_checked(&self.rows, &self.rows_inverse, n);
        let x = MatMut::from_column_major_slice_mut(x, n, 1);
        let stack = MemStack::new(&mut self.scratch);
        solve::solve_in_place_with_conj(factors, factors, rows, Conj::No, x, Par::Seq, stack);
    }

    fn copied(&self) -> Box<dyn Solver<T>> {
        Box::new(self.clone())
    }
}
