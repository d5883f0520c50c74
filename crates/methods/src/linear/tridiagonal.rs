//! Tridiagonal matrices: Thomas' algorithm, from both ends to the middle.
//!
//! The rows depend on each other in sequence, so eliminating from both ends at once halves the
//! time. There is no pivoting, so the matrix should be diagonally dominant. The matrix of a step is
//! I + h/2 Dp + h²/4 Hqq Hpp. It is diagonally dominant for short steps, and for any step size if V
//! is convex and couples neighbours by springs. Otherwise a vanishing pivot is a failure, and a
//! small one costs corrections.

use super::{Number, Solver, usable};

/// Rows of three entries: below, on and above the diagonal. After the factorisation they hold, on
/// the side of the nearer end, the factor, then the reciprocal pivot, and on the other side the
/// entry divided by the pivot. The middle row has two factors.
#[derive(Clone, Debug)]
pub(crate) struct Tridiagonal<T> {
    values: Vec<T>,
    size: usize,
}

impl<T: Number> Tridiagonal<T> {
    pub(super) fn new(size: usize) -> Self {
        Self { size, values: vec![T::ZERO; 3 * size] }
    }
}

/// Eliminates from `row` the entry at `near`, given the reciprocal pivot and the scaled entry of
/// the previous row.
fn eliminate<T: Number>(row: &mut [T; 3], near: usize, [inverse, beyond]: [T; 2]) -> T {
    row[near] *= inverse;
    (-row[near]).fused(beyond, row[1])
}

/// Eliminates the rows from one end, where `near` is the index of the entry towards that end.
/// Returns the last reciprocal pivot and the scaled entry of the last row.
fn eliminate_all<'a, T: Number + 'a>(
    rows: impl Iterator<Item = (usize, &'a mut [T; 3])>,
    near: usize,
) -> Result<[T; 2], usize> {
    let mut last = [T::ZERO; 2];
    for (k, row) in rows {
        let pivot = eliminate(row, near, last);
        if !usable(pivot) {
            return Err(k);
        }
        last = [pivot.inverse(), row[2 - near]];
        row[1] = last[0];
        row[2 - near] *= last[0];
    }
    Ok(last)
}

/// Factorises a tridiagonal matrix. The error is the row of a vanishing pivot.
pub(super) fn factorise<T: Number>(rows: &mut [[T; 3]]) -> Result<(), usize> {
    let (half, size) = (rows.len() / 2, rows.len());
    let (left, right) = rows.split_at_mut(half);
    let Some((middle, right)) = right.split_first_mut() else { return Ok(()) };
    let before = eliminate_all(left.iter_mut().enumerate(), 0)?;
    let after = eliminate_all((half + 1..size).zip(right).rev(), 2)?;
    middle[1] = eliminate(middle, 0, before);
    let pivot = eliminate(middle, 2, after);
    middle[1] = pivot.inverse();
    if usable(pivot) { Ok(()) } else { Err(half) }
}

/// Replaces the right-hand side x by the solution, with the factors of the matrix.
pub(super) fn solve<T: Number>(rows: &[[T; 3]], x: &mut [T]) {
    let half = rows.len() / 2;
    let (left, right) = rows.split_at(half);
    let (x_left, x_right) = x.split_at_mut(half);
    let (Some((middle, right)), Some((x, x_right))) =
        (right.split_first(), x_right.split_first_mut())
    else {
        return;
    };
    // If the number of rows is even, the left part has one more.
    let more = left.len() - right.len();
    let (mut before, mut after) = (T::ZERO, T::ZERO);
    for (row, x) in left.iter().zip(x_left.iter_mut()).take(more) {
        before = (-row[0]).fused(before, *x);
        *x = before;
    }
    let pairs = left[more..].iter().zip(&mut x_left[more..]);
    for ((row, x), (other, y)) in pairs.zip(right.iter().zip(x_right.iter_mut()).rev()) {
        before = (-row[0]).fused(before, *x);
        after = (-other[2]).fused(after, *y);
        (*x, *y) = (before, after);
    }
    *x = (-middle[0]).fused(before, (-middle[2]).fused(after, *x)) * middle[1];
    (before, after) = (*x, *x);
    let pairs = left[more..].iter().zip(&mut x_left[more..]).rev();
    for ((row, x), (other, y)) in pairs.zip(right.iter().zip(x_right.iter_mut())) {
        before = (-row[2]).fused(before, *x * row[1]);
        after = (-other[0]).fused(after, *y * other[1]);
        (*x, *y) = (before, after);
    }
    for (row, x) in left.iter().zip(x_left.iter_mut()).take(more) {
        before = (-row[2]).fused(before, *x * row[1]);
        *x = before;
    }
}

/// Subtracts from x the product of a with a tridiagonal matrix.
pub(super) fn subtract<T: Number>(rows: &[[T; 3]], a: &[T], x: &mut [T]) {
    if let (Some(row), Some(x), [first, rest @ ..]) = (rows.first(), x.first_mut(), a) {
        *x -= row[1] * *first + row[2] * rest.first().copied().unwrap_or(T::ZERO);
    }
    for ((row, x), a) in rows.iter().zip(x.iter_mut()).skip(1).zip(a.array_windows::<3>()) {
        *x -= row[0].fused(a[0], row[1].fused(a[1], row[2] * a[2]));
    }
    if let (Some(row), Some(x), [.., before, last]) = (rows.last(), x.last_mut(), a) {
        *x -= row[0] * *before + row[1] * *last;
    }
}

impl<T: Number> Solver<T> for Tridiagonal<T> {
    fn slot(&self, row: usize, column: usize) -> Option<usize> {
        (row < self.size && column < self.size && row.abs_diff(column) <= 1)
            .then(|| 2 * row + column + 1)
    }

    fn values(&mut self) -> &mut [T] {
        &mut self.values
    }

    fn factorise(&mut self) -> Result<(), usize> {
        factorise(self.values.as_chunks_mut().0)
    }

    fn subtract(&self, values: &[T], a: &[T], x: &mut [T]) {
        subtract(values.as_chunks().0, a, x);
    }

    fn solve(&mut self, x: &mut [T]) {
        solve(self.values.as_chunks().0, x);
    }

    fn copied(&self) -> Box<dyn Solver<T>> {
        Box::new(self.clone())
    }
}
