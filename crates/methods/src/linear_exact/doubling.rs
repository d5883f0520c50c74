//! A short step by Taylor series and Gauss quadrature, and its repeated doubling.

use crate::linear_flow::{nodes, terms};
use afterbay_core::Scalar;

/// A, the rows of both factors of each energy, and the matrices of the step h, row by row.
#[derive(Clone, Debug)]
pub(super) struct Doubling<T> {
    size: usize,
    a: Vec<T>,
    left: Vec<T>,
    right: Vec<T>,
    /// X of a short step, and e^{hA}
    pub(super) change: Vec<T>,
    pub(super) flow: Vec<T>,
    pub(super) forms: Vec<Vec<T>>,
    nodes: Vec<[T; 2]>,
    /// (hA)^k/k! for k ≥ 1
    powers: Vec<Vec<T>>,
    scratch: [Vec<T>; 2],
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

impl<T: Scalar> Doubling<T> {
    /// Creates the matrices for A and the factors of `count` energies.
    pub(super) fn new(size: usize, count: usize, [a, left, right]: [Vec<T>; 3]) -> Self {
        let square = || vec![T::zero(); size * size];
        Self {
            size,
            a,
            left,
            right,
            change: square(),
            flow: square(),
            forms: (0..count).map(|_| square()).collect(),
            nodes: nodes(),
            powers: (0..terms::<T>()).map(|_| square()).collect(),
            scratch: [square(), square()],
        }
    }

    /// Computes X, e^{hA} and Q_j for the time `short`, doubled `doublings` times.
    pub(super) fn make(&mut self, short: T, doublings: u32) {
        self.begin(short);
        for _ in 0..doublings {
            self.double();
        }
    }

    /// Computes X and Q_j of a short step by Taylor series and Gauss quadrature.
    fn begin(&mut self, h: T) {
        let Self { size, a, left, right, change, flow, forms, nodes, powers, scratch } = self;
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
            let [l, r] = &mut *scratch;
            multiply(left, flow, l, size);
            multiply(right, flow, r, size);
            for (form, (l, r)) in
                forms.iter_mut().zip(l.chunks_exact(size).zip(r.chunks_exact(size)))
            {
                for (form, (&l_i, &r_i)) in form.chunks_exact_mut(size).zip(l.iter().zip(r)) {
                    for (form, (&l_k, &r_k)) in form.iter_mut().zip(l.iter().zip(r)) {
                        let both = l_i.mul_add(r_k, r_i * l_k).half();
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

    /// Doubles the step from h to 2h.
    fn double(&mut self) {
        let Self { size, flow, forms, scratch, .. } = self;
        let size = *size;
        let [product, both] = scratch;
        for form in forms {
            // Q is symmetric: (Q E)ᵀ E = Eᵀ Q E.
            multiply(form, flow, product, size);
            both.fill(T::zero());
            for (row, product) in flow.chunks_exact(size).zip(product.chunks_exact(size)) {
                both.chunks_exact_mut(size)
                    .zip(row)
                    .for_each(|(both, &factor)| add(both, factor, product));
            }
            form.iter_mut().zip(&*both).for_each(|(form, &both)| *form += both);
        }
        multiply(flow, flow, product, size);
        flow.copy_from_slice(product);
    }
}
