//! The initial guess of the stages: the polynomial of the accepted step beyond its end.

use super::engine::Engine;
use super::stages::extrapolate;
use afterbay_core::{Scalar, State, Vector};
use std::array::from_fn;

/// The largest number of degrees of freedom for which polynomials are evaluated one by one. For
/// more, a matrix that maps the values at the nodes is cheaper. A choice: the matrix costs as much
/// as four polynomials.
const FEW: usize = 2;

impl<V: Vector, const K: usize> Engine<V, K> {
    /// Initialises the stages from the polynomial of the accepted step, truncated to its reliable
    /// coefficients, or from a constant.
    #[inline]
    pub(super) fn initial_guess(&mut self, h: V::Scalar, state: &State<V>, again: bool) {
        if let Some(length) = self.kept_h {
            let ratio = h / length;
            let offset = if again { V::Scalar::zero() } else { V::Scalar::one() };
            let count = if again { K } else { self.trusted(ratio.to_f64()) };
            if V::LEN.is_some_and(|n| n <= FEW) {
                self.extrapolate_each(offset, ratio, count);
            } else {
                self.extrapolate_all(offset, ratio, count);
            }
        } else {
            for i in 0..K {
                self.trial.f[i].as_mut_slice().copy_from_slice(self.start.f.as_slice());
                self.trial.v[i].as_mut_slice().copy_from_slice(self.start.v.as_slice());
            }
        }
        if !self.unit_mass {
            self.trial.place_q(&self.gauss, h, state);
        }
    }

    /// The number of coefficients of the forces that are worth extrapolating: P_j grows outside [0,
    /// 1].
    #[inline]
    fn trusted(&self, ratio: f64) -> usize {
        let n = self.zero.as_slice().len();
        let mut sizes = [0.0_f64; K];
        // A sample of the degrees of freedom.
        for d in (0..n).step_by(n.div_ceil(8)) {
            let mut modes = [V::Scalar::zero(); K];
            for j in 0..K {
                let f = self.kept.f[j].as_slice()[d];
                for (mode, row) in modes.iter_mut().zip(&self.gauss.modes) {
                    *mode = row[j].mul_add(f, *mode);
                }
            }
            for (size, mode) in sizes.iter_mut().zip(modes) {
                *size = size.max(mode.abs().to_f64());
            }
        }
        let x = 1.0 + 2.0 * ratio;
        let (mut before, mut at) = (1.0, x);
        let (mut least, mut count) = (f64::INFINITY, K);
        for (l, size) in sizes.into_iter().enumerate().skip(1) {
            let term = size * at * ((2 * l + 1) as f64).sqrt();
            if term < least {
                (least, count) = (term, l);
            }
            let l = l as f64;
            (before, at) = (at, ((2.0 * l + 1.0) * x * at - l * before) / (l + 1.0));
        }
        // If the coefficients still decrease at the end, all are used.
        if count == K - 1 { K } else { count }
    }

    /// Evaluates the polynomials of the accepted step, truncated to `count` coefficients, at the
    /// nodes of this step. It begins at `offset` and has the length `ratio`, in units of that one.
    fn extrapolate_each(&mut self, offset: V::Scalar, ratio: V::Scalar, count: usize) {
        let Self { gauss, kept, trial, unit_mass, .. } = self;
        let basis = gauss.basis(offset, ratio);
        let extend = |from: &[V; K], to: &mut [V; K]| {
            for d in 0..V::LEN.unwrap_or(from[0].as_slice().len()) {
                let ahead = gauss.extended(&basis, count, from_fn(|i| from[i].as_slice()[d]));
                for (to, x) in to.iter_mut().zip(ahead) {
                    to.as_mut_slice()[d] = x;
                }
            }
        };
        extend(&kept.f, &mut trial.f);
        if !*unit_mass {
            extend(&kept.v, &mut trial.v);
        }
    }

    /// [`Self::extrapolate_each`] by a matrix, which is kept while steps have equal ratios.
    fn extrapolate_all(&mut self, offset: V::Scalar, ratio: V::Scalar, count: usize) {
        if self.extrapolation_for != Some((offset, ratio, count)) {
            self.extrapolation = self.gauss.extrapolation(offset, ratio, count);
            self.extrapolation_for = Some((offset, ratio, count));
        }
        extrapolate(&self.extrapolation, &self.zero, &self.kept.f, &mut self.trial.f);
        if !self.unit_mass {
            extrapolate(&self.extrapolation, &self.zero, &self.kept.v, &mut self.trial.v);
        }
    }
}
