//! The step of a linear system as matrices acting on x = (q, p, 1): e^{hA}, and a quadratic form
//! for each reservoir.
//!
//! ```text
//! Q_j = ∫_0^h e^{τAᵀ} ½ (d_jᵀ v_j + v_jᵀ d_j) e^{τA} dτ        Δw_j = xᵀ Q_j x
//! Q_j(2h) = Q_j + e^{hAᵀ} Q_j e^{hA}
//! ```
//!
//! with d_j and v_j the rows of D and ∂H/∂p. A step with h |A| ≤ 1 is computed from the Taylor
//! series and Gauss quadrature, a longer one by doubling such a step in 31 digits, because doubling
//! amplifies the rounding errors of the short step by h |A|. A is built from the unrounded second
//! derivatives, so that the flow conserves exactly the H they belong to. For a short step X =
//! e^{hA} - 1 is stored, so that no digits are lost to the 1.

use super::doubling::Doubling;
use afterbay_core::{Block, Curvature, Quad, Scalar};

/// The matrices of the last h, row by row.
#[derive(Clone, Debug)]
pub(super) struct Table<T> {
    n: usize,
    /// 2N, or 2N + 1 where there are constant forces
    size: usize,
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

/// Converts a scalar that holds one number without rounding.
fn widen<T: Scalar>(x: T) -> Quad {
    let high = x.to_f64();
    Quad::from_f64(high) + Quad::from_f64((x - T::from_f64(high)).to_f64())
}

fn narrow<T: Scalar>(x: Quad) -> T {
    T::from_f64(x.0) + T::from_f64(x.1)
}

impl<T: Scalar> Table<T> {
    pub(super) fn new<S: Curvature<T> + ?Sized>(system: &S) -> Self {
        let n = system.dof();
        let zeros = |count: usize| vec![T::zero(); count];
        // ∂H/∂q, ∂H/∂p and D at x.
        let mut x = zeros(2 * n);
        let evaluate = |x: &[T]| {
            let mut all = [zeros(n), zeros(n), zeros(n)];
            let [hq, hp, d] = &mut all;
            system.gradient(&x[..n], &x[n..], hq, hp);
            system.dissipation(&x[..n], &x[n..], hp, d);
            all
        };
        let constant = evaluate(&x);
        let free = constant.iter().flatten().all(|&c| c == T::zero());
        let size = if free { 2 * n } else { 2 * n + 1 };
        let none = |rows: usize| vec![Quad::ZERO; rows * size];
        // The rows of ∂H/∂q and ∂H/∂p, made exactly symmetric, and of D.
        let (mut slopes, mut d) = (none(2 * n), none(n));
        system.curvature(&x[..n], &x[n..], |block, i, j, value| {
            let half = widen(value).half();
            let mut put = |i: usize, j: usize, value: Quad| slopes[i * size + j] += value;
            match block {
                Block::Hqq => [(i, j), (j, i)].map(|(i, j)| put(i, j, half)),
                Block::Hpp => [(n + i, n + j), (n + j, n + i)].map(|(i, j)| put(i, j, half)),
                Block::Hqp => [(i, n + j), (n + j, i)].map(|(i, j)| put(i, j, half + half)),
                Block::Dq | Block::Dp => [(); 2],
            };
        });
        for k in 0..2 * n {
            x[k] = T::one();
            let [_, _, drag] = evaluate(&x);
            x[k] = T::zero();
            for j in 0..n {
                d[j * size + k] = widen(drag[j]) - widen(constant[2][j]);
            }
        }
        if !free {
            for j in 0..n {
                let [hq, hp, drag] = [0, 1, 2].map(|part| widen(constant[part][j]));
                slopes[j * size + 2 * n] = hq;
                slopes[(n + j) * size + 2 * n] = hp;
                d[j * size + 2 * n] = drag;
            }
        }
        let mut a = none(size);
        for j in 0..n {
            for k in 0..size {
                a[j * size + k] = slopes[(n + j) * size + k];
                a[(n + j) * size + k] = -slopes[j * size + k] - d[j * size + k];
            }
        }
        let v = slopes.split_off(n * size);
        let short = [&a, &d, &v].map(|rows| rows.iter().map(|&x| narrow(x)).collect::<Vec<T>>());
        x.resize(size, T::one());
        Self {
            n,
            size,
            h: None,
            doubled: false,
            rate: rate(n, size, &a),
            short: Box::new(Doubling::new(size, n, short)),
            long: Box::new(Doubling::new(size, n, [a, d, v])),
            matrix: zeros(size * size),
            forms: (0..n).map(|_| zeros(size * size)).collect(),
            x,
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

    /// Computes q1, p1 and Δw.
    pub(super) fn step(&mut self, [q0, p0]: [&[T]; 2], [q, p, w]: [&mut [T]; 3]) {
        let (n, size) = (self.n, self.size);
        let x = &mut self.x[..size];
        x[..n].copy_from_slice(q0);
        x[n..2 * n].copy_from_slice(p0);
        for (i, (new, row)) in q.iter_mut().chain(p).zip(self.matrix.chunks_exact(size)).enumerate()
        {
            let start = if self.doubled { T::zero() } else { x[i] };
            *new = start + row.iter().zip(&*x).fold(T::zero(), |sum, (&m, &x)| m.mul_add(x, sum));
        }
        for (w, form) in w.iter_mut().zip(&self.forms) {
            *w = form.chunks_exact(size).zip(&*x).fold(T::zero(), |sum, (row, &x_i)| {
                let row = row.iter().zip(&*x).fold(T::zero(), |sum, (&m, &x)| m.mul_add(x, sum));
                row.mul_add(x_i, sum)
            });
        }
    }
}

/// |A|, minimised over the ratio of the units of q and p.
fn rate(n: usize, size: usize, a: &[Quad]) -> f64 {
    let square = |rows: usize, columns: usize| {
        let entry = |i: usize, j: usize| a[(rows + i) * size + columns + j].to_f64();
        (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .map(|(i, j)| entry(i, j).powi(2))
            .sum::<f64>()
    };
    (square(0, 0) + square(n, n) + 2.0 * square(0, n).sqrt() * square(n, 0).sqrt()).sqrt()
}
