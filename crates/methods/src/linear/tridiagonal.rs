//! Neighbours in a row: Thomas' algorithm.
//!
//! Without pivoting, so it wants a diagonal that outweighs the rest. The matrix of a step is I + h/2 Dp + h²/4 Hqq Hpp and
//! has it for short steps, and for any step where V is convex and couples neighbours by springs. Elsewhere a vanishing
//! pivot is a failure, and a small one costs corrections.

use super::{Solver, usable};

/// Rows of three entries: below the diagonal, on it, above it; then the factor, the reciprocal pivot, the entry above.
#[derive(Clone, Debug)]
pub(crate) struct Tridiagonal {
    size: usize,
    values: Vec<f64>,
}

impl Tridiagonal {
    pub(super) fn new(size: usize) -> Self {
        Self { size, values: vec![0.0; 3 * size] }
    }
}

impl Solver for Tridiagonal {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size && row.abs_diff(column) <= 1).then(|| 2 * row + column + 1)
    }

    fn values(&mut self) -> &mut [f64] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        // Above the first row there is nothing.
        let (mut inverse, mut above) = (0.0, 0.0);
        for (k, row) in self.values.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            row[0] *= inverse;
            let pivot = f64::mul_add(-row[0], above, row[1]);
            if !usable(pivot) {
                return Err(k);
            }
            inverse = 1.0 / pivot;
            row[1] = inverse;
            above = row[2];
        }
        Ok(())
    }

    fn solve(&mut self, x: &mut [f64]) {
        let rows = self.values.as_chunks::<3>().0;
        let mut last = 0.0;
        for (row, x) in rows.iter().zip(x.iter_mut()) {
            last = (-row[0]).mul_add(last, *x);
            *x = last;
        }
        last = 0.0;
        for (row, x) in rows.iter().zip(x.iter_mut()).rev() {
            last = (-row[2]).mul_add(last, *x) * row[1];
            *x = last;
        }
    }
}
