//! The step of x' = A x as matrices acting on x: e^{hA}, and a quadratic form for each energy.
//!
//! ```text
//! Q_j = ∫_0^h e^{τAᵀ} ½ (l_jᵀ r_j + r_jᵀ l_j) e^{τA} dτ        ∫ (l_j x) (r_j x) dτ = xᵀ Q_j x
//! Q_j(2h) = Q_j + e^{hAᵀ} Q_j e^{hA}
//! ```
//!
//! with l_j and r_j the factors of the energy ([`Equations::factors`]). A step with h |A| ≤ 1 is
//! computed from the Taylor series and Gauss quadrature, a longer one by doubling such a step in 31
//! digits, because doubling amplifies the rounding errors of the short step by h |A|. For a short
//! step X = e^{hA} - 1 is stored, so that no digits are lost to the 1.

use super::doubling::Doubling;
use super::equations::Equations;
use crate::legendre::{narrow, widen};
use afterbay_core::{Quad, Scalar};

/// The matrices of the last h, row by row.
#[derive(Clone, Debug)]
pub(super) struct Table<T> {
    n: usize,
    size: usize,
    first_wave: usize,
    h: Option<T>,
    /// Whether x1 = e^{hA} x0 is used instead of x0 + X x0
    doubled: bool,
    rate: f64,
    short: Box<Doubling<T>>,
    long: Box<Doubling<Quad>>,
    matrix: Vec<T>,
    forms: Vec<Vec<T>>,
    x: Vec<T>,
}

impl<T: Scalar> Table<T> {
    pub(super) fn new(equations: Equations) -> Self {
        let Equations { n, size, first_wave, a, factors: [left, right], rate } = equations;
        let count = left.len() / size;
        let short =
            [&a, &left, &right].map(|rows| rows.iter().map(|&x| narrow(x)).collect::<Vec<T>>());
        let square = || vec![T::zero(); size * size];
        Self {
            n,
            size,
            first_wave,
            h: None,
            doubled: false,
            rate,
            short: Box::new(Doubling::new(size, count, short)),
            long: Box::new(Doubling::new(size, count, [a, left, right])),
            matrix: square(),
            forms: (0..count).map(|_| square()).collect(),
            x: vec![T::one(); size],
        }
    }

    /// Computes the matrices of h, unless they are stored.
    pub(super) fn prepare(&mut self, h: T) {
        if self.h == Some(h) {
            return;
        }
        let rate = h.to_f64().abs() * self.rate;
        // Limited to the exponent range of a double; beyond it nothing is finite.
        let doublings = rate.log2().ceil().clamp(0.0, 1e3);
        self.doubled = doublings > 0.0;
        let Self { short, long, matrix, forms, .. } = self;
        if self.doubled {
            long.make(widen(h) * Quad::from_f64(2f64.powi(-(doublings as i32))), doublings as u32);
            let parts = long.forms.iter().zip(forms).chain([(&long.flow, matrix)]);
            parts.for_each(|(from, to)| {
                to.iter_mut().zip(from).for_each(|(to, &x)| *to = narrow(x));
            });
        } else {
            short.make(h, 0);
            let parts = short.forms.iter().zip(forms).chain([(&short.change, matrix)]);
            parts.for_each(|(from, to)| to.copy_from_slice(from));
        }
        self.h = Some(h);
    }

    /// Sets cos ω_k t and sin ω_k t at the start of the step, k counted from 0.
    pub(super) fn set_wave(&mut self, k: usize, [cos, sin]: [T; 2]) {
        let place = self.first_wave + 2 * k;
        (self.x[place], self.x[place + 1]) = (cos, sin);
    }

    /// Computes q1, p1 and the energies.
    pub(super) fn step(&mut self, [q0, p0]: [&[T]; 2], [q, p, energies]: [&mut [T]; 3]) {
        let (n, size) = (self.n, self.size);
        let x = &mut self.x[..size];
        x[..n].copy_from_slice(q0);
        x[n..2 * n].copy_from_slice(p0);
        for (i, (new, row)) in q.iter_mut().chain(p).zip(self.matrix.chunks_exact(size)).enumerate()
        {
            let start = if self.doubled { T::zero() } else { x[i] };
            *new = start + row.iter().zip(&*x).fold(T::zero(), |sum, (&m, &x)| m.mul_add(x, sum));
        }
        for (energy, form) in energies.iter_mut().zip(&self.forms) {
            *energy = form.chunks_exact(size).zip(&*x).fold(T::zero(), |sum, (row, &x_i)| {
                let row = row.iter().zip(&*x).fold(T::zero(), |sum, (&m, &x)| m.mul_add(x, sum));
                row.mul_add(x_i, sum)
            });
        }
    }
}
