//! A few unknowns: Gauss with partial pivoting, in place.

use super::{Solver, subtract_columns, usable};

/// A dense matrix by columns, then its factors, the reciprocal pivots on the diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Small {
    size: usize,
    values: Vec<f64>,
    /// The row exchanged with each row in turn.
    exchanges: Vec<usize>,
}

impl Small {
    pub(super) fn new(size: usize) -> Self {
        Self { size, values: vec![0.0; size * size], exchanges: vec![0; size] }
    }
}

impl Solver for Small {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size).then_some(column * self.size + row)
    }

    fn values(&mut self) -> &mut [f64] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        let n = self.size;
        for k in 0..n {
            let (left, right) = self.values.split_at_mut((k + 1) * n);
            let column = &mut left[k * n..];
            let largest =
                (k..n).fold(k, |best, i| if column[i].abs() > column[best].abs() { i } else { best });
            self.exchanges[k] = largest;
            column.swap(k, largest);
            if !usable(column[k]) {
                return Err(k);
            }
            let inverse = 1.0 / column[k];
            column[k] = inverse;
            for factor in &mut column[k + 1..] {
                *factor *= inverse;
            }
            for other in right.chunks_exact_mut(n) {
                other.swap(k, largest);
                let top = other[k];
                for (x, factor) in other[k + 1..].iter_mut().zip(&column[k + 1..]) {
                    *x = (-factor).mul_add(top, *x);
                }
            }
            // The factors already made follow their rows.
            for j in 0..k {
                left.swap(j * n + k, j * n + largest);
            }
        }
        Ok(())
    }

    fn subtract(&self, values: &[f64], a: &[f64], x: &mut [f64]) {
        subtract_columns(values, a, x);
    }

    fn solve(&mut self, x: &mut [f64]) {
        let n = self.size;
        for (k, &row) in self.exchanges.iter().enumerate() {
            x.swap(k, row);
        }
        for (k, column) in self.values.chunks_exact(n.max(1)).enumerate() {
            let top = x[k];
            for (x, factor) in x[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *x = (-factor).mul_add(top, *x);
            }
        }
        for (k, column) in self.values.chunks_exact(n.max(1)).enumerate().rev() {
            let top = x[k] * column[k];
            x[k] = top;
            for (x, factor) in x[..k].iter_mut().zip(column) {
                *x = (-factor).mul_add(top, *x);
            }
        }
    }
}
