//! The step of a linear system as matrices on x = (q, p, 1): e^{hA}, and for each reservoir a quadratic form.
//!
//! ```text
//! Q_j = ∫_0^h e^{τAᵀ} ½ (d_jᵀ v_j + v_jᵀ d_j) e^{τA} dτ        Q_j(2h) = Q_j + e^{hAᵀ} Q_j e^{hA}        Δw_j = xᵀ Q_j x
//! ```
//!
//! with d_j and v_j the rows of D and ∂H/∂p. A step with h |A| ≤ 1 comes from the Taylor series and Gauss nodes; a longer
//! one from such a step by doubling. Of a short step X = e^{hA} - 1 is kept, of which nothing is lost in the 1.

use crate::linear_flow::{nodes, terms};
use afterbay_core::{Curvature, Scalar};

/// The matrices, row by row, of the last h.
#[derive(Clone, Debug)]
pub(super) struct Table<T> {
    n: usize,
    /// 2N, or 2N + 1 where there are constant forces
    size: usize,
    h: Option<T>,
    /// Is x1 = e^{hA} x0 rather than x0 + X x0?
    long: bool,
    a: Vec<T>,
    d: Vec<T>,
    v: Vec<T>,
    /// X of a short step, and e^{hA}
    change: Vec<T>,
    flow: Vec<T>,
    forms: Vec<Vec<T>>,
    nodes: Vec<[T; 2]>,
    /// (hA)^k/k! for k ≥ 1
    powers: Vec<Vec<T>>,
    scratch: [Vec<T>; 2],
    x: Vec<T>,
}

/// to += factor row
#[inline(always)]
fn add<T: Scalar>(to: &mut [T], factor: T, row: &[T]) {
    to.iter_mut().zip(row).for_each(|(to, &x)| *to = factor.mul_add(x, *to));
}

/// to = a b, b square.
fn multiply<T: Scalar>(a: &[T], b: &[T], to: &mut [T], size: usize) {
    to.fill(T::zero());
    for (to, a) in to.chunks_exact_mut(size).zip(a.chunks_exact(size)) {
        a.iter().zip(b.chunks_exact(size)).for_each(|(&factor, b)| add(to, factor, b));
    }
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
        let (mut a, mut d, mut v) = (zeros(size * size), zeros(n * size), zeros(n * size));
        for k in 0..size {
            let [hq, hp, drag] = if k == 2 * n {
                constant.clone()
            } else {
                x[k] = T::one();
                let all = evaluate(&x);
                x[k] = T::zero();
                let [hq, hp, d] = all;
                [(hq, 0), (hp, 1), (d, 2)]
                    .map(|(part, i)| part.iter().zip(&constant[i]).map(|(&x, &c)| x - c).collect())
            };
            for j in 0..n {
                a[j * size + k] = hp[j];
                a[(n + j) * size + k] = -hq[j] - drag[j];
                d[j * size + k] = drag[j];
                v[j * size + k] = hp[j];
            }
        }
        let square = || zeros(size * size);
        x.resize(size, T::one());
        Self {
            n,
            size,
            h: None,
            long: false,
            a,
            d,
            v,
            change: square(),
            flow: square(),
            forms: (0..n).map(|_| square()).collect(),
            nodes: nodes(),
            powers: (0..terms::<T>()).map(|_| square()).collect(),
            scratch: [square(), square()],
            x,
        }
    }

    /// Computes the matrices of h, if they are not there.
    pub(super) fn prepare(&mut self, h: T) {
        if self.h == Some(h) {
            return;
        }
        let rate = h.to_f64().abs() * self.rate();
        // No more than what a double can count: beyond, nothing is finite.
        let doublings = rate.log2().ceil().clamp(0.0, 1e3);
        let short = h * T::from_f64(2f64.powi(-(doublings as i32)));
        self.begin(short);
        for _ in 0..doublings as u32 {
            self.double();
        }
        self.long = doublings > 0.0;
        self.h = Some(h);
    }

    /// X and Q_j of a short step, by Taylor series and Gauss nodes.
    fn begin(&mut self, h: T) {
        let Self { size, a, d, v, change, flow, forms, nodes, powers, scratch, .. } = self;
        let size = *size;
        powers[0].iter_mut().zip(&*a).for_each(|(power, &a)| *power = h * a);
        for k in 1..powers.len() {
            let (before, after) = powers.split_at_mut(k);
            multiply(&before[0], &before[k - 1], &mut after[0], size);
            let share = T::from_f64((k + 1) as f64);
            after[0].iter_mut().for_each(|x| *x = *x / share);
        }
        let sum = |share: T, to: &mut [T]| {
            to.fill(T::zero());
            for power in powers.iter().rev() {
                to.iter_mut().zip(power).for_each(|(to, &power)| *to = (*to + power) * share);
            }
        };
        forms.iter_mut().for_each(|form| form.fill(T::zero()));
        for &[node, weight] in nodes.iter() {
            sum(node, flow);
            (0..size).for_each(|i| flow[i * size + i] += T::one());
            let [rubbed, moved] = &mut *scratch;
            multiply(d, flow, rubbed, size);
            multiply(v, flow, moved, size);
            for (form, (d, v)) in
                forms.iter_mut().zip(rubbed.chunks_exact(size).zip(moved.chunks_exact(size)))
            {
                for (form, (&d_i, &v_i)) in form.chunks_exact_mut(size).zip(d.iter().zip(v)) {
                    for (form, (&d_k, &v_k)) in form.iter_mut().zip(d.iter().zip(v)) {
                        let both = d_i.mul_add(v_k, v_i * d_k).half();
                        *form = (weight * h).mul_add(both, *form);
                    }
                }
            }
        }
        sum(T::one(), change);
        // e^{hA} = 1 + X
        flow.copy_from_slice(change);
        (0..size).for_each(|i| flow[i * size + i] += T::one());
    }

    /// From h to 2h.
    fn double(&mut self) {
        let Self { size, flow, forms, scratch, .. } = self;
        let size = *size;
        let [product, both] = scratch;
        for form in forms {
            // Q is symmetric: (Q E)ᵀ E = Eᵀ Q E.
            multiply(form, flow, product, size);
            both.fill(T::zero());
            for (row, product) in flow.chunks_exact(size).zip(product.chunks_exact(size)) {
                both.chunks_exact_mut(size).zip(row).for_each(|(both, &factor)| add(both, factor, product));
            }
            form.iter_mut().zip(&*both).for_each(|(form, &both)| *form += both);
        }
        multiply(flow, flow, product, size);
        flow.copy_from_slice(product);
    }

    /// |A|, with q and p in units that make it least.
    fn rate(&self) -> f64 {
        let square = |rows: usize, columns: usize| {
            let entry = |i: usize, j: usize| self.a[(rows + i) * self.size + columns + j].to_f64();
            (0..self.n)
                .flat_map(|i| (0..self.n).map(move |j| (i, j)))
                .map(|(i, j)| entry(i, j).powi(2))
                .sum::<f64>()
        };
        let n = self.n;
        (square(0, 0) + square(n, n) + 2.0 * square(0, n).sqrt() * square(n, 0).sqrt()).sqrt()
    }

    /// q1, p1 and Δw.
    pub(super) fn step(&mut self, [q0, p0]: [&[T]; 2], [q, p, w]: [&mut [T]; 3]) {
        let (n, size) = (self.n, self.size);
        let x = &mut self.x[..size];
        x[..n].copy_from_slice(q0);
        x[n..2 * n].copy_from_slice(p0);
        let matrix = if self.long { &self.flow } else { &self.change };
        for (i, (new, row)) in q.iter_mut().chain(p).zip(matrix.chunks_exact(size)).enumerate() {
            let start = if self.long { T::zero() } else { x[i] };
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
