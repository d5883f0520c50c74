//! Everyone acts on everyone: faer's LU with partial pivoting, blocked.

use super::{Solver, subtract_columns, usable};
use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par};
use std::mem::MaybeUninit;

/// A dense matrix by columns, then its factors.
#[derive(Clone, Debug)]
pub(crate) struct Dense {
    size: usize,
    values: Vec<f64>,
    rows: Vec<usize>,
    rows_inverse: Vec<usize>,
    scratch: Vec<MaybeUninit<u8>>,
}

impl Dense {
    pub(super) fn new(size: usize) -> Self {
        let factorising = factor::lu_in_place_scratch::<usize, f64>(size, size, Par::Seq, Default::default());
        let solving = solve::solve_in_place_scratch::<usize, f64>(size, 1, Par::Seq);
        let bytes = StackReq::or(factorising, solving).unaligned_bytes_required();
        let scratch = vec![MaybeUninit::uninit(); bytes];
        let (rows, rows_inverse) = ((0..size).collect(), (0..size).collect());
        let mut matrix = Self { size, values: vec![0.0; size * size], rows, rows_inverse, scratch };
        // What faer makes ready the first time, on a matrix that is singular: here, not in a step.
        let _ = matrix.factorise();
        matrix
    }
}

impl Solver for Dense {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size).then_some(column * self.size + row)
    }

    fn values(&mut self) -> &mut [f64] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        let n = self.size;
        let Self { values, rows, rows_inverse, scratch, .. } = self;
        let matrix = MatMut::from_column_major_slice_mut(values, n, n);
        factor::lu_in_place(matrix, rows, rows_inverse, Par::Seq, MemStack::new(scratch), Default::default());
        (0..n).find(|k| !usable(values[k * n + k])).map_or(Ok(()), Err)
    }

    fn subtract(&self, values: &[f64], a: &[f64], x: &mut [f64]) {
        subtract_columns(values, a, x);
    }

    fn solve(&mut self, x: &mut [f64]) {
        let n = self.size;
        let factors = MatRef::from_column_major_slice(&self.values, n, n);
        let rows = PermRef::new_checked(&self.rows, &self.rows_inverse, n);
        let x = MatMut::from_column_major_slice_mut(x, n, 1);
        solve::solve_in_place(factors, factors, rows, x, Par::Seq, MemStack::new(&mut self.scratch));
    }
}
