//! How fast a system can move.

use afterbay_core::{Block, Curvature, Scalar, Vector};

/// Sums over the rows of the blocks of the Jacobian of (∂H/∂p, -∂H/∂q - D).
#[derive(Clone, Debug)]
pub(crate) struct Rates<V: Vector> {
    /// Σ_j |∂²H/∂q_i∂q_j|, and the diagonal less the rest
    by_q: V,
    outweighed: V,
    by_p: V,
    /// Σ_j |∂D_i/∂q_j|, Σ_j |∂D_i/∂p_j|, and of ∂²H/∂q∂p by rows and by columns
    drag: V,
    friction: V,
    mixed: [V; 2],
}

impl<V: Vector> Rates<V> {
    pub(crate) fn new(n: usize) -> Self {
        let zeros = || V::zeros(n);
        Self {
            by_q: zeros(),
            outweighed: zeros(),
            by_p: zeros(),
            drag: zeros(),
            friction: zeros(),
            mixed: [zeros(), zeros()],
        }
    }

    /// An estimate of the largest frequency, √(b |Hqq|), which is a bound of it where H is separable; and a bound of |λ| for the eigenvalues λ of the Jacobian J = [Hpq Hpp; -Hqq - Dq, -Hqp - Dp] at (q, p).
    ///
    /// In the norm of the largest sum of a row, with a = |Hpq|, b = |Hpp|, c = |Hqq| + |Dq| and d = |Hqp| + |Dp|, the spectral radius of J is at
    /// most that of [a b; c d] (A. M. Ostrowski, J. Math. Anal. Appl. 2 (1961) 161-209):
    ///
    /// ```text
    /// |λ| ≤ (a + d + √((a - d)² + 4 b c)) / 2
    /// ```
    ///
    /// Where Hpq = 0, Dq = 0, Hpp and Dp are diagonal, and the diagonal of Hqq is at least the rest of each row, so that Hqq is positive
    /// semidefinite, `|λ| ≤ max(√(bc), d)`: with x the q of an eigenvector, λ² + r λ + k = 0 for a real r of at most d and a real
    /// k ≥ 0 of at most b c, the quotients of x with Hpp⁻¹. Friction that is skew, or a potential that falls, has no such bound.
    #[inline]
    pub(crate) fn see<S>(&mut self, system: &S, q: &V, p: &V) -> [f64; 2]
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let zero = V::Scalar::zero();
        let [row, column] = &mut self.mixed;
        let [by_q, outweighed, by_p, drag, friction, row, column] = [
            &mut self.by_q,
            &mut self.outweighed,
            &mut self.by_p,
            &mut self.drag,
            &mut self.friction,
            row,
            column,
        ]
        .map(V::as_mut_slice);
        for sums in [&mut *by_q, outweighed, by_p, drag, friction, row, column] {
            sums.fill(zero);
        }
        let mut coupled = false;
        system.curvature(q.as_slice(), p.as_slice(), |block, i, j, value| {
            let size = value.abs();
            match block {
                Block::Hqq => {
                    by_q[i] += size;
                    outweighed[i] += if i == j { value } else { -size };
                }
                Block::Hpp => by_p[i] += size,
                Block::Hqp => {
                    row[i] += size;
                    column[j] += size;
                }
                Block::Dq => drag[i] += size,
                Block::Dp => friction[i] += size,
            }
            coupled |= i != j && matches!(block, Block::Hpp | Block::Dp);
        });
        // What is not a number is larger than all.
        let larger = |most: f64, x: f64| if x <= most { most } else { x };
        let largest = |x: &[V::Scalar]| x.iter().fold(0.0, |most, x| larger(most, x.to_f64()));
        let both = |x: &[V::Scalar], y: &[V::Scalar]| {
            x.iter().zip(y).fold(0.0, |most, (&x, &y)| larger(most, (x + y).to_f64()))
        };
        let [a, b] = [largest(column), largest(by_p)];
        let [c, d] = [both(by_q, drag), both(row, friction)];
        let frequency = (b * largest(by_q)).sqrt();
        let least = outweighed.iter().fold(f64::INFINITY, |least, x| least.min(x.to_f64()));
        let falls = least < -ROUNDINGS * f64::EPSILON * c;
        if !coupled && !falls && a == 0.0 && largest(row) == 0.0 && largest(drag) == 0.0 {
            return [frequency, frequency.max(d)];
        }
        let bound = 0.5 * (a + d + (a - d).hypot(2.0 * (b * c).sqrt()));
        [frequency, bound]
    }
}

/// By how many roundings a row of Hqq may miss its diagonal.
const ROUNDINGS: f64 = 8.0;
