//! Sparse matrices: faer's sparse LU with one symbolic analysis.
//!
//! The simplicial factorisation reuses the memory of the one before, so refactorising allocates
//! only if pivoting produces more fill-in than ever before. To reserve this memory, the matrix is
//! factorised twice on creation, once with pivots on the diagonal and once with random ones. A zero
//! pivot is divided by, and the solution is then not finite.

use super::{Number, Solver};
use afterbay_core::InputError;
use faer::dyn_stack::{MemStack, StackReq};
use faer::sparse::linalg::lu::{
    LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu,
};
use faer::sparse::linalg::{LuError, SupernodalThreshold};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par};
use std::mem::MaybeUninit;

/// A sparse matrix stored by columns, and its factors.
#[derive(Clone, Debug)]
pub(crate) struct Sparse<T> {
    pattern: SymbolicSparseColMat<usize>,
    values: Vec<T>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, T>,
    scratch: Vec<MaybeUninit<u8>>,
}

impl<T: Number> Sparse<T> {
    pub(super) fn new(size: usize, mut entries: Vec<(usize, usize)>) -> Result<Self, InputError> {
        entries.extend((0..size).map(|i| (i, i)));
        entries.sort_unstable_by_key(|&(row, column)| (column, row));
        entries.dedup();
        let starts =
            (0..=size).map(|column| entries.partition_point(|&(_, c)| c < column)).collect();
        let rows: Vec<usize> = entries.iter().map(|&(row, _)| row).collect();
        let values = vec![T::ZERO; rows.len()];
        let pattern = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        let params = LuSymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let why = "the sparse matrix of its step does not fit in memory";
        let unsupported = |_| InputError::Unsupported { method: "an implicit method", why };
        let symbolic = factorize_symbolic_lu(pattern.as_ref(), params).map_err(unsupported)?;
        let factorising = symbolic.factorize_numeric_lu_scratch::<T>(Par::Seq, Default::default());
        let solving = symbolic.solve_in_place_scratch::<T>(1, Par::Seq);
        let bytes = StackReq::or(factorising, solving).unaligned_bytes_required();
        let scratch = vec![MaybeUninit::uninit(); bytes];
        let mut matrix = Self { pattern, values, symbolic, numeric: NumericLu::new(), scratch };
        matrix.reserve(&entries);
        Ok(matrix)
    }

    /// Factorises twice to allocate the memory.
    fn reserve(&mut self, entries: &[(usize, usize)]) {
        for pivots in [1.0, 0.0] {
            let mut random = 1_u32;
            for (value, (row, column)) in self.values.iter_mut().zip(entries) {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let share = f64::from(random) / f64::from(u32::MAX);
                *value = T::real(if row == column { pivots + 1e-3 * share } else { 1e-3 * share });
            }
            // Only the allocation matters; the random matrix may be singular.
            let _ = self.factorise();
        }
    }
}

impl<T: Number> Solver<T> for Sparse<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        if column >= self.pattern.ncols() {
            return None;
        }
        let range = self.pattern.col_range(column);
        let rows = &self.pattern.row_idx()[range.clone()];
        rows.binary_search(&row).ok().map(|at| range.start + at)
    }

    fn values(&mut self) -> &mut [T] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        let Self { pattern, values, symbolic, numeric, scratch } = self;
        if let Some(entry) = values.iter().position(|x| !x.size().is_finite()) {
            return Err(pattern.row_idx()[entry]);
        }
        let matrix = SparseColMatRef::new(pattern.as_ref(), &values[..]);
        let stack = MemStack::new(scratch);
        let factors =
            symbolic.factorize_numeric_lu(numeric, matrix, Par::Seq, stack, Default::default());
        factors.map(|_| ()).map_err(|error| match error {
            LuError::SymbolicSingular { index } => index,
            LuError::Generic(_) => 0,
        })
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        for (column, &a) in a.iter().enumerate().take(self.pattern.ncols()) {
            let range = self.pattern.col_range(column);
            for (&row, &value) in self.pattern.row_idx()[range.clone()].iter().zip(&values[range]) {
                x[row] = (-value).fused(a, x[row]);
            }
        }
    }

    fn solve(&mut self, x: &mut [T]) {
        let n = x.len();
        let x = MatMut::from_column_major_slice_mut(x, n, 1);
        let factors = LuRef::new_unchecked(&self.symbolic, &self.numeric);
        factors.solve_in_place_with_conj(Conj::No, x, Par::Seq, MemStack::new(&mut self.scratch));
    }
}
