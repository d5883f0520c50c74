//! The stages of an explicit Runge-Kutta step, and what they add up to.

use super::tableau::Tableau;
use afterbay_core::{Effort, Scalar, State, System, Vector};

/// The slopes of the stages, the increments d and e, and the gradient at the start.
#[derive(Clone, Debug)]
pub(super) struct Stages<V: Vector> {
    /// a_ij that are not 0, with their j, row by row
    rows: Vec<Vec<(usize, V::Scalar)>>,
    /// b_i
    weights: Vec<V::Scalar>,
    /// f(Z_i), as what q and p change by
    slopes: Vec<[V; 2]>,
    /// The point of a stage
    q: V,
    p: V,
    /// D there
    d: V,
    /// ∇H at the start
    pub(super) start: [V; 2],
    /// d
    pub(super) dq: V,
    pub(super) dp: V,
    /// e
    pub(super) dw: V,
}

impl<V: Vector> Stages<V> {
    pub(super) fn new(tableau: &Tableau, n: usize) -> Self {
        let number = |[high, low]: [f64; 2]| V::Scalar::from_f64(high) + V::Scalar::from_f64(low);
        let row = |row: &&[(usize, [f64; 2])]| row.iter().map(|&(j, a)| (j, number(a))).collect();
        let zeros = || V::zeros(n);
        Self {
            rows: tableau.rows.iter().map(row).collect(),
            weights: tableau.weights.iter().map(|&b| number(b)).collect(),
            slopes: tableau.weights.iter().map(|_| [zeros(), zeros()]).collect(),
            q: zeros(),
            p: zeros(),
            d: zeros(),
            start: [zeros(), zeros()],
            dq: zeros(),
            dp: zeros(),
            dw: zeros(),
        }
    }

    /// Computes d and e of the step η from `state`.
    pub(super) fn take<S>(&mut self, system: &S, eta: V::Scalar, state: &State<V>) -> Effort
    where
        S: System<V::Scalar> + ?Sized,
    {
        let n = state.dof();
        let zero = V::Scalar::zero();
        let dissipative = !system.damping().zero;
        let Self { rows, weights, slopes, q, p, d, start, dq, dp, dw } = self;
        let (q0, p0) = (&state.q.as_slice()[..n], &state.p.as_slice()[..n]);
        let (q, p, d) = (&mut q.as_mut_slice()[..n], &mut p.as_mut_slice()[..n], &mut d.as_mut_slice()[..n]);
        let (dq, dp, dw) =
            (&mut dq.as_mut_slice()[..n], &mut dp.as_mut_slice()[..n], &mut dw.as_mut_slice()[..n]);
        dq.fill(zero);
        dp.fill(zero);
        dw.fill(zero);
        for (i, (row, &weight)) in rows.iter().zip(weights.iter()).enumerate() {
            q.fill(zero);
            p.fill(zero);
            for &(j, a) in row {
                let [of_q, of_p] = &slopes[j];
                add(q, a, &of_q.as_slice()[..n]);
                add(p, a, &of_p.as_slice()[..n]);
            }
            for j in 0..n {
                q[j] = eta.mul_add(q[j], q0[j]);
                p[j] = eta.mul_add(p[j], p0[j]);
            }
            let [v, force] = &mut slopes[i];
            let (v, force) = (&mut v.as_mut_slice()[..n], &mut force.as_mut_slice()[..n]);
            system.gradient(q, p, force, v);
            if i == 0 {
                start[0].as_mut_slice().copy_from_slice(force);
                start[1].as_mut_slice().copy_from_slice(v);
            }
            if dissipative {
                system.dissipation(q, p, v, d);
                for j in 0..n {
                    force[j] += d[j];
                    dw[j] = weight.mul_add(d[j] * v[j], dw[j]);
                }
            }
            for x in &mut *force {
                *x = -*x;
            }
            add(dq, weight, v);
            add(dp, weight, force);
        }
        for part in [dq, dp, dw] {
            for x in part {
                *x *= eta;
            }
        }
        Effort { evaluations: weights.len() as u64, iterations: 0 }
    }

    /// Does `change` times d move the state by more than a rounding?
    pub(super) fn feel(&self, state: &State<V>, change: V::Scalar) -> bool {
        let largest = |part: &V| part.as_slice().iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        let [q, p] = [(&self.dq, &state.q), (&self.dp, &state.p)];
        let moved = |(d, z): (&V, &V)| change.to_f64().abs() * largest(d) > V::Scalar::EPSILON * largest(z);
        moved(q) || moved(p)
    }
}

/// sum + a x
fn add<T: Scalar>(sum: &mut [T], a: T, x: &[T]) {
    for (sum, &x) in sum.iter_mut().zip(x) {
        *sum = a.mul_add(x, *sum);
    }
}
