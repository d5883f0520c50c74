//! Tridiagonal matrices with two more entries, in the corners: those of a ring of neighbours.
//!
//! ```text
//! [ A  c ] [ x ]   [ f ]        A u = c        A v = f
//! [ r  d ] [ y ] = [ g ]        y = (g - r·v) / (d - r·u)        x = v - y u
//! ```
//!
//! A is tridiagonal and y is the last unknown; c and r have entries at the two neighbours of y. The
//! equations with A are solved by Thomas' algorithm ([`tridiagonal`]), without pivoting.

use super::{Number, Solver, tridiagonal, usable};

/// Rows of three entries: those of the neighbour before, of the row itself and of the neighbour
/// after it, where the first and the last row are neighbours. The factorisation leaves the factors
/// of A, and the reciprocal of `d - r·u` in place of d.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T> {
    values: Vec<T>,
    u: Vec<T>,
}

impl<T: Number> Ring<T> {
    pub(super) fn new(size: usize) -> Self {
        Self { values: vec![T::ZERO; 3 * size], u: vec![T::ZERO; size.saturating_sub(1)] }
    }
}

/// r·x
fn along<T: Number>(last: &[T; 3], x: &[T]) -> T {
    let end = |x: Option<&T>| x.copied().unwrap_or(T::ZERO);
    last[0].fused(end(x.last()), last[2] * end(x.first()))
}

impl<T: Number> Solver<T> for Ring<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        let size = self.values.len() / 3;
        if row >= size || column >= size {
            return None;
        }
        let entry = match (column + size - row) % size {
            0 => 1,
            1 => 2,
            ahead if ahead + 1 == size => 0,
            _ => return None,
        };
        Some(3 * row + entry)
    }

    fn values(&mut self) -> &mut [T] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        let Some((last, rows)) = self.values.as_chunks_mut::<3>().0.split_last_mut() else {
            return Ok(());
        };
        self.u.fill(T::ZERO);
        if let (Some(row), Some(u)) = (rows.first_mut(), self.u.first_mut()) {
            *u += std::mem::replace(&mut row[0], T::ZERO);
        }
        if let (Some(row), Some(u)) = (rows.last_mut(), self.u.last_mut()) {
            *u += std::mem::replace(&mut row[2], T::ZERO);
        }
        tridiagonal::factorise(rows)?;
        tridiagonal::solve(rows, &mut self.u);
        let pivot = last[1] - along(last, &self.u);
        last[1] = pivot.inverse();
        if usable(pivot) { Ok(()) } else { Err(rows.len()) }
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        let rows = values.as_chunks::<3>().0;
        tridiagonal::subtract(rows, a, x);
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return };
        let end = rows.len() - 1;
        x[0] -= first[0] * a[end];
        x[end] -= last[2] * a[0];
    }

    fn solve(&mut self, x: &mut [T]) {
        let Some((last, rows)) = self.values.as_chunks::<3>().0.split_last() else { return };
        let Some((y, x)) = x.split_last_mut() else { return };
        tridiagonal::solve(rows, x);
        *y = (*y - along(last, x)) * last[1];
        for (x, &u) in x.iter_mut().zip(&self.u) {
            *x = (-*y).fused(u, *x);
        }
    }

    fn copied(&self) -> Box<dyn Solver<T>> {
        Box::new(self.clone())
    }
}
