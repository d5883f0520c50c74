//! Bounds of the frequencies and eigenvalues of a system.

use afterbay_core::{Block, Curvature, Mask, Scalar, Vector, larger_or_nan};

/// The roundings by which the diagonal of Hqq may fall short of the rest of its row.
const DOMINANCE_ROUNDINGS: f64 = 16.0;

/// Row sums of the blocks of the Jacobian of (∂H/∂p, -∂H/∂q - D).
#[derive(Clone, Debug)]
pub(crate) struct Rates<V: Vector> {
    /// Σ_j |∂²H/∂q_i∂q_j|, and the diagonal entry minus the other entries of its row
    hqq: V,
    dominance: V,
    hpp: V,
    /// Σ_j |∂D_i/∂q_j|, Σ_j |∂D_i/∂p_j|, and the sums of ∂²H/∂q∂p by rows and by columns
    dq: V,
    dp: V,
    mixed: [V; 2],
    /// ∂²H/∂p_i²
    inverse_masses: V,
    /// The largest change of p' for changes of q with entries up to 1, and the same for p.
    force: [f64; 2],
    /// See [`Self::by_time`].
    by_time: [f64; 3],
}

/// The properties of the blocks that row sums do not show.
#[derive(Clone, Copy, Debug)]
struct Structure {
    /// Whether Hpp or Dp has entries off the diagonal.
    coupled: bool,
    /// Whether Hpp has a negative entry.
    backward: bool,
}

/// Bounds at one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// √(|Hpp| |Hqq|), which bounds the frequencies if H is separable.
    pub(crate) frequency: f64,
    /// A bound of the absolute eigenvalues of the Jacobian.
    pub(crate) eigenvalue: f64,
    /// |Hpp|: a bound of the change of the velocities with momenta whose entries change by up to 1.
    pub(crate) velocity: f64,
}

impl<V: Vector> Rates<V> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        Self {
            hqq: zeros(),
            dominance: zeros(),
            hpp: zeros(),
            dq: zeros(),
            dp: zeros(),
            mixed: [zeros(), zeros()],
            inverse_masses: zeros(),
            force: [0.0; 2],
            by_time: [0.0; 3],
        }
    }

    /// A bound of the change of p' with (q, p) of this size, at the point seen last.
    pub(crate) fn force(&self, [q, p]: [f64; 2]) -> f64 {
        self.force[0] * q + self.force[1] * p
    }

    /// The largest derivatives of q', p' and of the power of V with respect to the times of motors,
    /// at the points seen so far, where they are finite. Those seen before count half as much at
    /// each new point.
    pub(crate) fn by_time(&self) -> [f64; 3] {
        self.by_time
    }

    /// Returns an estimate of the largest frequency, √(b |Hqq|), which is an upper bound if H is
    /// separable, and an upper bound of |λ| for the eigenvalues λ of the Jacobian J = [Hpq Hpp;
    /// -Hqq - Dq, -Hqp - Dp] at (q, p).
    ///
    /// In the norm of the largest sum of a row, with a = |Hpq|, b = |Hpp|, c = |Hqq| + |Dq| and d =
    /// |Hqp| + |Dp|, the spectral radius of J is at most that of [a b; c d] (A. M. Ostrowski, J.
    /// Math. Anal. Appl. 2 (1961) 161-209):
    ///
    /// ```text
    /// |λ| ≤ (a + d + √((a - d)² + 4 b c)) / 2
    /// ```
    ///
    /// Suppose Hpq = 0 and Dq = 0, Hpp and Dp are diagonal, Hpp is not negative, and each diagonal
    /// entry of Hqq is at least the sum of the other absolute entries of its row, so that Hqq is
    /// positive semidefinite. Then `|λ| ≤ max(√(bc), d)`: with x the q-part of an eigenvector, λ² +
    /// r λ + k = 0, where the Rayleigh quotients r and k of x, weighted with Hpp⁻¹, are real with
    /// |r| ≤ d and 0 ≤ k ≤ b c. This bound does not hold for skew friction or for concave
    /// potentials.
    ///
    /// If the masses differ, the bounds are computed again in the variables q_i √m_i and p_i/√m_i.
    /// There every ∂²H/∂p_i² is 1 and J has the same eigenvalues, so that the smaller bound
    /// holds. In the variables of the system, a light mass on a soft spring beside a heavy mass on
    /// a stiff spring has the bound of a light mass on a stiff spring.
    ///
    /// Rows and columns of motors are left out: their coordinates are the time and no slope depends
    /// on their momenta, so that J is block triangular and its other eigenvalues are 0.
    #[inline]
    pub(crate) fn bounds<S>(&mut self, system: &S, q: &V, p: &V) -> Bounds
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let structure = self.sum_rows::<S, false>(system, q, p);
        self.force = self.forces();
        let mut bounds = self.bounds_of_sums(structure, self.force);
        let free = system.dof() - system.motors();
        if has_unlike_entries(&self.inverse_masses.as_slice()[..free]) {
            let structure = self.sum_rows::<S, true>(system, q, p);
            let scaled = self.bounds_of_sums(structure, self.forces());
            bounds.frequency = bounds.frequency.min(scaled.frequency);
            bounds.eigenvalue = bounds.eigenvalue.min(scaled.eigenvalue);
        }
        bounds
    }

    /// |Hqq| + |Dq| and |Hqp| + |Dp|
    #[inline]
    fn forces(&self) -> [f64; 2] {
        let both = |x: &V, y: &V| {
            let sums = x.as_slice().iter().zip(y.as_slice());
            sums.fold(0.0, |most, (&x, &y)| larger_or_nan(most, (x + y).to_f64()))
        };
        [both(&self.hqq, &self.dq), both(&self.mixed[0], &self.dp)]
    }

    /// The bounds by the sums of rows, of which c and d are those of [`Self::forces`].
    #[inline]
    fn bounds_of_sums(
        &self,
        Structure { coupled, backward }: Structure,
        [c, d]: [f64; 2],
    ) -> Bounds {
        let Self { hqq, dominance, hpp, dq, mixed: [row, column], .. } = self;
        let largest =
            |x: &V| x.as_slice().iter().fold(0.0, |most, x| larger_or_nan(most, x.to_f64()));
        let [a, b] = [largest(column), largest(hpp)];
        let frequency = (b * largest(hqq)).sqrt();
        let least =
            dominance.as_slice().iter().fold(f64::INFINITY, |least, x| least.min(x.to_f64()));
        let falls = least < -DOMINANCE_ROUNDINGS * V::Scalar::EPSILON * c;
        if !coupled && !backward && !falls && a == 0.0 && largest(row) == 0.0 && largest(dq) == 0.0
        {
            return Bounds { frequency, eigenvalue: frequency.max(d), velocity: b };
        }
        let eigenvalue = 0.5 * (a + d + (a - d).hypot(2.0 * (b * c).sqrt()));
        Bounds { frequency, eigenvalue, velocity: b }
    }

    /// Sums the rows of the blocks at (q, p), without those of motors: in the variables of the
    /// system, or in those in which the ∂²H/∂p_i² found by the last call are 1.
    #[inline]
    fn sum_rows<S, const SCALED: bool>(&mut self, system: &S, q: &V, p: &V) -> Structure
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let zero = V::Scalar::zero();
        let Self { hqq, dominance, hpp, dq, dp, mixed: [row, column], inverse_masses, .. } = self;
        let [hqq, dominance, hpp, dq, dp, row, column, inverse_masses] =
            [hqq, dominance, hpp, dq, dp, row, column, inverse_masses].map(V::as_mut_slice);
        for sums in [&mut *hqq, dominance, hpp, dq, dp, row, column] {
            sums.fill(zero);
        }
        if !SCALED {
            inverse_masses.fill(zero);
        }
        let (mut coupled, mut backward) = (false, false);
        let free = system.dof() - system.motors();
        let mut by_time = [0.0_f64; 3];
        system.curvature(q.as_slice(), p.as_slice(), |block, i, j, value| {
            if i >= free || j >= free {
                let part = match block {
                    Block::Hqp if j < free => 0,
                    Block::Hqq | Block::Dq if i < free => 1,
                    Block::Hqq => 2,
                    _ => return,
                };
                let size = value.abs().to_f64();
                if size.is_finite() {
                    by_time[part] = by_time[part].max(size);
                }
                return;
            }
            let root = |i: usize| inverse_masses[i].sqrt();
            let value = match block {
                _ if !SCALED => value,
                Block::Hqq | Block::Dq => value * root(i) * root(j),
                Block::Hqp | Block::Dp => value * root(i) / root(j),
                Block::Hpp => value / root(i) / root(j),
            };
            let size = value.abs();
            match block {
                Block::Hqq => {
                    hqq[i] += size;
                    dominance[i] += if i == j { value } else { -size };
                }
                Block::Hpp => {
                    hpp[i] += size;
                    backward |= value.lt(zero).any();
                    if !SCALED && i == j {
                        inverse_masses[i] = value;
                    }
                }
                Block::Hqp => {
                    row[i] += size;
                    column[j] += size;
                }
                Block::Dq => dq[i] += size,
                Block::Dp => dp[i] += size,
            }
            coupled |= i != j && matches!(block, Block::Hpp | Block::Dp);
        });
        if !SCALED {
            let before = self.by_time.map(|before| 0.5 * before);
            self.by_time = std::array::from_fn(|part| by_time[part].max(before[part]));
        }
        Structure { coupled, backward }
    }
}

/// Whether all entries are positive and finite, and some differ.
fn has_unlike_entries<T: Scalar>(x: &[T]) -> bool {
    x.iter().any(|entry| *entry != x[0])
        && x.iter().all(|entry| T::zero().lt(*entry).all() && entry.is_finite().all())
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{DissipationForm, System};
    use faer::Mat;

    /// H = ½ (q·K q + 2 q·M p + p·W p) and D = E q + C p, with given matrices.
    struct Given {
        n: usize,
        blocks: [Vec<f64>; 5],
    }

    impl System<f64> for Given {
        fn dof(&self) -> usize {
            self.n
        }
        fn energy(&self, _q: &[f64], _p: &[f64]) -> f64 {
            0.0
        }
        fn gradient(&self, _q: &[f64], _p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
            hq.fill(0.0);
            hp.fill(0.0);
        }
        fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) {
            d.fill(0.0);
        }
        fn dissipation_form(&self) -> DissipationForm {
            DissipationForm::GENERAL
        }
    }

    impl Curvature<f64> for Given {
        fn curvature(&self, _q: &[f64], _p: &[f64], mut put: impl FnMut(Block, usize, usize, f64)) {
            let names = [Block::Hqq, Block::Hqp, Block::Hpp, Block::Dq, Block::Dp];
            for (block, entries) in names.into_iter().zip(&self.blocks) {
                for (k, &x) in entries.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    put(block, k / self.n, k % self.n, x);
                }
            }
        }
    }

    impl Given {
        /// The largest |λ| of J = [Mᵀ W; -K - E, -M - C].
        fn fastest(&self) -> f64 {
            let n = self.n;
            let [k, m, w, e, c] = &self.blocks;
            let at = |x: &[f64], i: usize, j: usize| x[i * n + j];
            let entry = |i: usize, j: usize| match (i < n, j < n) {
                (true, true) => at(m, j, i),
                (true, false) => at(w, i, j - n),
                (false, true) => -at(k, i - n, j) - at(e, i - n, j),
                (false, false) => -at(m, i - n, j - n) - at(c, i - n, j - n),
            };
            let eigenvalues = Mat::from_fn(2 * n, 2 * n, entry).eigenvalues().unwrap();
            eigenvalues.iter().map(|x| x.re.hypot(x.im)).fold(0.0, f64::max)
        }

        fn bound(&self) -> f64 {
            let zeros = vec![0.0; self.n];
            Rates::<Vec<f64>>::new(self.n).bounds(self, &zeros, &zeros).eigenvalue
        }
    }

    /// Random blocks, some symmetric, skew or zero: no eigenvalue exceeds the bound.
    #[test]
    fn no_eigenvalue_is_beyond_the_bound() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
        };
        let (mut closest, mut skew) = (0.0_f64, 0.0_f64);
        for case in 0..4000 {
            let n = 1 + case % 4;
            let mut matrix = |kind: f64, size: f64| -> Vec<f64> {
                let x: Vec<f64> = (0..n * n).map(|_| size * random()).collect();
                let other = |k: usize| x[k % n * n + k / n];
                match kind {
                    kind if kind < -0.5 => vec![0.0; n * n],
                    kind if kind < 0.0 => (0..n * n).map(|k| x[k] - other(k)).collect(),
                    kind if kind < 0.5 => (0..n * n).map(|k| x[k] + other(k)).collect(),
                    _ => x,
                }
            };
            let [a, b, c, d, e] =
                [0.3, 0.2, 0.9, 0.7, 0.4].map(|x: f64| (x * (case as f64 + 1.0) * 7.3).sin());
            let eye =
                |size: f64| (0..n * n).map(|k| if k / n == k % n { size } else { 0.0 }).collect();
            let unlike = || {
                let entry = |k: usize| 10f64.powf(6.0 * (a * (k + 1) as f64 * 97.0).sin());
                (0..n * n).map(|k| if k / n == k % n { entry(k) } else { 0.0 }).collect()
            };
            let w = match a {
                a if a > 0.5 => unlike(),
                a if a > 0.0 => eye(0.5 + a),
                _ => matrix(0.2, 1.0),
            };
            let blocks =
                [matrix(0.2, 3.0), matrix(b, 1.0), w, matrix(c, 2.0), matrix(d, 4.0 * e.abs())];
            let given = Given { n, blocks };
            let [fastest, bound] = [given.fastest(), given.bound()];
            assert!(fastest <= bound * (1.0 + 1e-12), "{case}: {fastest} beyond {bound}");
            closest = closest.max(fastest / bound);
        }
        // The bound for symmetric friction does not hold for skew friction: here ω = 2 and the
        // friction rotates with frequency 2.
        let turning = Given {
            n: 2,
            blocks: [
                vec![4.0, 0.0, 0.0, 4.0],
                vec![0.0; 4],
                vec![1.0, 0.0, 0.0, 1.0],
                vec![0.0; 4],
                vec![0.0, 2.0, -2.0, 0.0],
            ],
        };
        skew = skew.max(turning.fastest());
        assert!(skew > 3.0 && skew <= turning.bound(), "{skew} {}", turning.bound());
        println!("the closest is {closest:.3} of its bound");
        assert!(closest > 0.9);
    }

    /// A light mass on a soft spring beside a heavy one on a stiff spring, both with ω = 1.
    #[test]
    fn the_bound_does_not_depend_on_the_units_of_a_coordinate() {
        for unit in [1e-8, 1e-3, 1.0, 1e8] {
            let diagonal = |x: f64, y: f64| vec![x, 0.0, 0.0, y];
            let blocks = [
                diagonal(unit, 1.0),
                vec![0.0; 4],
                diagonal(1.0 / unit, 1.0),
                vec![0.0; 4],
                diagonal(0.5, 0.5),
            ];
            let bound = Given { n: 2, blocks }.bound();
            assert!((bound - 1.0).abs() < 1e-14, "{unit:e}: {bound}");
        }
    }

    /// With H separable, diagonal friction and convex V, the bound is that of a single oscillator:
    /// max(ω, c).
    #[test]
    fn ordinary_friction_has_the_sharp_bound() {
        for c in [0.0, 1.0, 2.0, 5.0] {
            let k = vec![2.0, -1.0, -1.0, 2.0];
            let given = Given {
                n: 2,
                blocks: [
                    k,
                    vec![0.0; 4],
                    vec![1.0, 0.0, 0.0, 1.0],
                    vec![0.0; 4],
                    vec![c, 0.0, 0.0, c],
                ],
            };
            let sharp = 3.0_f64.sqrt().max(c);
            assert!((given.bound() - sharp).abs() < 1e-14, "{c}: {}", given.bound());
            assert!(given.fastest() <= sharp * (1.0 + 1e-14));
        }
    }
}
