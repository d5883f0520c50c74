//! Sparse matrices: faer's simplicial sparse LU, with columns in COLAMD order.
//!
//! The factorisation reuses the memory of the one before, so refactorising allocates
//! only if pivoting produces more fill-in than ever before. To reserve this memory, the matrix is
//! factorised twice on creation, once with pivots on the diagonal and once with random ones. A zero
//! pivot is divided by, and the solution is then not finite.

use super::{Number, Solver};
use afterbay_core::InputError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::perm::{Perm, PermRef};
use faer::sparse::linalg::lu::simplicial::{
    SimplicialLu, factorize_simplicial_numeric_lu, factorize_simplicial_numeric_lu_scratch,
    solve_in_place_scratch,
};
use faer::sparse::linalg::{LuError, colamd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par};
use std::mem::MaybeUninit;

/// A sparse matrix stored by columns, and its factors.
#[derive(Clone, Debug)]
pub(crate) struct Sparse<T> {
    pattern: SymbolicSparseColMat<usize>,
    values: Vec<T>,
    factors: SimplicialLu<usize, T>,
    columns: Perm<usize>,
    rows: Vec<usize>,
    rows_inverse: Vec<usize>,
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
        let why = "the sparse matrix of its step does not fit in memory";
        let unsupported = InputError::Unsupported { method: "an implicit method", why };
        let columns = order(&pattern).ok_or(unsupported)?;
        let factorising = factorize_simplicial_numeric_lu_scratch::<usize, T>(size, size);
        let solving = solve_in_place_scratch::<usize, T>(size, 1, Par::Seq);
        let bytes = StackReq::or(factorising, solving).unaligned_bytes_required();
        let mut matrix = Self {
            pattern,
            values,
            factors: SimplicialLu::new(),
            columns,
            rows: vec![0; size],
            rows_inverse: vec![0; size],
            scratch: vec![MaybeUninit::uninit(); bytes],
        };
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

/// The order of the columns that keeps the factors sparse; `None` if memory runs out.
fn order(pattern: &SymbolicSparseColMat<usize>) -> Option<Perm<usize>> {
    let (size, entries) = (pattern.ncols(), pattern.compute_nnz());
    let mut memory =
        MemBuffer::try_new(colamd::order_scratch::<usize>(size, size, entries)).ok()?;
    let (mut forward, mut inverse) = (vec![0; size], vec![0; size]);
    let stack = MemStack::new(&mut memory);
    colamd::order(&mut forward, &mut inverse, pattern.as_ref(), colamd::Control::default(), stack)
        .ok()?;
    Some(Perm::new_checked(forward.into(), inverse.into(), size))
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
        let Self { pattern, values, factors, columns, rows, rows_inverse, scratch } = self;
        if let Some(entry) = values.iter().position(|x| !x.size().is_finite()) {
            return Err(pattern.row_idx()[entry]);
        }
        let matrix = SparseColMatRef::new(pattern.as_ref(), &values[..]);
        let stack = MemStack::new(scratch);
        let columns = columns.as_ref();
        let done =
            factorize_simplicial_numeric_lu(rows, rows_inverse, factors, matrix, columns, stack);
        done.map_err(|error| match error {
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
        let rows = PermRef::new_checked(&self.rows, &self.rows_inverse, n);
        let (columns, stack) = (self.columns.as_ref(), MemStack::new(&mut self.scratch));
        self.factors.solve_in_place_with_conj(rows, columns, Conj::No, x, Par::Seq, stack);
    }

    fn copied(&self) -> Box<dyn Solver<T>> {
        Box::new(self.clone())
    }
}
