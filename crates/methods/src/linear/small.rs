//! Gaussian elimination with partial pivoting, in place, for few unknowns.

use super::{Number, Solver, subtract_columns, usable};

/// A dense matrix stored by columns, later its factors, with reciprocal pivots on the diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Small<T> {
    size: usize,
    values: Vec<T>,
    /// The row with which each row was exchanged, in order.
    exchanges: Vec<usize>,
}

impl<T: Number> Small<T> {
    pub(super) fn new(size: usize) -> Self {
        Self { size, values: vec![T::ZERO; size * size], exchanges: vec![0; size] }
    }
}

impl<T: Number> Solver<T> for Small<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size).then_some(column * self.size + row)
    }

    fn values(&mut self) -> &mut [T] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        let n = self.size;
        for k in 0..n {
            let (left, right) = self.values.split_at_mut((k + 1) * n);
            let column = &mut left[k * n..];
            let largest = (k..n)
                .fold(k, |best, i| if column[i].size() > column[best].size() { i } else { best });
            self.exchanges[k] = largest;
            column.swap(k, largest);
            if !usable(column[k]) {
                return Err(k);
            }
            let inverse = column[k].inverse();
            column[k] = inverse;
            for factor in &mut column[k + 1..] {
                *factor *= inverse;
            }
            for other in right.chunks_exact_mut(n) {
                other.swap(k, largest);
                let top = other[k];
                for (x, factor) in other[k + 1..].iter_mut().zip(&column[k + 1..]) {
                    *x = (-*factor).fused(top, *x);
                }
            }
            // The factors computed so far are exchanged with their rows.
            for j in 0..k {
                left.swap(j * n + k, j * n + largest);
            }
        }
        Ok(())
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        subtract_columns(values, a, x);
    }

    fn solve(&mut self, x: &mut [T]) {
        let n = self.size;
        for (k, &row) in self.exchanges.iter().enumerate() {
            x.swap(k, row);
        }
        for (k, column) in self.values.chunks_exact(n.max(1)).enumerate() {
            let top = x[k];
            for (x, factor) in x[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *x = (-*factor).fused(top, *x);
            }
        }
        for (k, column) in self.values.chunks_exact(n.max(1)).enumerate().rev() {
            let top = x[k] * column[k];
            x[k] = top;
            for (x, factor) in x[..k].iter_mut().zip(column) {
                *x = (-*factor).fused(top, *x);
            }
        }
    }

    fn copied(&self) -> Box<dyn Solver<T>> {
        Box::new(self.clone())
    }
}
