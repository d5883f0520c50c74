//! GMRES, a solver for linear equations that uses only products with the matrix.
//!
//! Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856-869: the linear combination of
//! b, A b, A² b, .. with the smallest residual. Memory is allocated once; solving does not
//! allocate.

/// The basis of the Krylov space, and the Hessenberg matrix of A in it.
#[derive(Clone, Debug)]
pub(crate) struct Gmres {
    /// Orthonormal vectors
    basis: Vec<Vec<f64>>,
    /// The columns of the triangular matrix produced by the rotations
    columns: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    right: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Gmres {
    /// Allocates the memory for `size` unknowns and at most `most` products.
    pub(crate) fn new(size: usize, most: usize) -> Self {
        Self {
            basis: vec![vec![0.0; size]; most + 1],
            columns: (1..=most).map(|rows| vec![0.0; rows + 1]).collect(),
            rotations: vec![[0.0; 2]; most],
            right: vec![0.0; most + 1],
        }
    }

    /// Replaces b in `x` by the solution of A x = b. Stops when the residual is `tolerance` times
    /// |b|, or when no products are left. `multiply` writes A a to its second argument. Returns the
    /// number of products.
    pub(crate) fn solve(
        &mut self,
        tolerance: f64,
        x: &mut [f64],
        multiply: &mut dyn FnMut(&[f64], &mut [f64]),
    ) -> usize {
        let Self { basis, columns, rotations, right } = self;
        let size = dot(x, x).sqrt();
        if size == 0.0 || !size.is_finite() {
            return 0;
        }
        right.fill(0.0);
        right[0] = size;
        basis[0].iter_mut().zip(&*x).for_each(|(to, &x)| *to = x / size);
        let mut done = 0;
        for k in 0..columns.len() {
            let (known, next) = basis.split_at_mut(k + 1);
            let (next, column) = (&mut next[0], &mut columns[k]);
            multiply(&known[k], next);
            for (entry, known) in column.iter_mut().zip(&*known) {
                *entry = dot(known, next);
                next.iter_mut()
                    .zip(known)
                    .for_each(|(x, &known)| *x = (-*entry).mul_add(known, *x));
            }
            let left = dot(next, next).sqrt();
            if !left.is_finite() {
                break;
            }
            column[k + 1] = left;
            for (i, &[c, s]) in rotations[..k].iter().enumerate() {
                let [a, b] = [column[i], column[i + 1]];
                (column[i], column[i + 1]) = (c.mul_add(a, s * b), c.mul_add(b, -s * a));
            }
            let length = column[k].hypot(left);
            if length == 0.0 {
                break;
            }
            let [c, s] = [column[k] / length, left / length];
            rotations[k] = [c, s];
            (column[k], column[k + 1]) = (length, 0.0);
            (right[k], right[k + 1]) = (c * right[k], -s * right[k]);
            done = k + 1;
            if right[k + 1].abs() <= tolerance * size || left == 0.0 {
                break;
            }
            next.iter_mut().for_each(|x| *x /= left);
        }
        self.combine(done, x);
        done
    }

    /// Computes the combination of the first `done` basis vectors with the smallest residual.
    fn combine(&mut self, done: usize, x: &mut [f64]) {
        let Self { basis, columns, right, .. } = self;
        for k in (0..done).rev() {
            let share = right[k] / columns[k][k];
            right[k] = share;
            for (right, entry) in right[..k].iter_mut().zip(&columns[k]) {
                *right = (-share).mul_add(*entry, *right);
            }
        }
        x.fill(0.0);
        for (share, known) in right[..done].iter().zip(&*basis) {
            x.iter_mut().zip(known).for_each(|(x, &known)| *x = share.mul_add(known, *x));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix that is neither symmetric nor close to 1 takes as many products as it has rows, and
    /// two if it has two eigenvalues.
    #[test]
    fn equations_are_solved() {
        let n = 12;
        let entry = |i: usize, j: usize| (1.7 * i as f64 + 0.3 * (i * j) as f64 + j as f64).sin();
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
        let two = |i: usize, j: usize| if i == j { 1.0 + (i % 2) as f64 } else { 0.0 };
        for (products, matrix) in [(n, &entry as &dyn Fn(usize, usize) -> f64), (2, &two)] {
            let mut multiply = |a: &[f64], to: &mut [f64]| {
                for (i, to) in to.iter_mut().enumerate() {
                    *to = a.iter().enumerate().map(|(j, a)| matrix(i, j) * a).sum();
                }
            };
            let mut x = vec![0.0; n];
            multiply(&exact, &mut x);
            let done = Gmres::new(n, n).solve(1e-12, &mut x, &mut multiply);
            assert_eq!(done, products);
            for (x, exact) in x.iter().zip(&exact) {
                assert!((x - exact).abs() < 1e-10, "{x} {exact}");
            }
        }
    }
}
