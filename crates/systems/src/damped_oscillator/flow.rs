//! The exact flow over a time h, `z → M z` for z = (q, p), with a = b/2, s = k - a²:
//!
//! ```text
//! b² ≤ 4k    M = e^{-ah} cos(ωh) I + σ [ a  1 ; -k  -a ]
//!            ω = √s,   σ = e^{-ah} sin(ωh)/ω
//! b² > 4k    M = diag(e^{-rh}, e^{-Rh}) + σ [ r  1 ; -k  -r ]
//!            R = a ± √-s,   r = k/R,   |r| < |R|,   σ = (e^{-rh} - e^{-Rh})/(R - r)
//! ```
//!
//! σ is smooth at b² = 4k, and both forms are accurate there. Hyperbolic functions are avoided: for
//! large h they overflow long before M does.

use super::DampedOscillator;
use afterbay_core::{ExactFlow, Mask, Scalar, State, Vector};

/// M = diag(keep) + σ [ r 1 ; -k -r ], r the rate.
struct Transition<T> {
    keep: [T; 2],
    /// keep - 1, without cancellation.
    lose: [T; 2],
    sigma: T,
    rate: T,
}

impl<T: Scalar> DampedOscillator<T> {
    /// The increments of (q, p, w) by the exact flow from (q, p) over the time `h`, which may be
    /// negative.
    ///
    /// In units of √k q and p the increments are accurate to a few roundings of the larger entry of
    /// `|M - I| |z|`, while a difference of two states is accurate to a rounding of the state only.
    /// Long times add a rounding for every unit of the phase and of the exponents. Δw is exactly 0
    /// for b = 0.
    ///
    /// The increments overflow where M does. The lanes of a SIMD scalar must all be on the same
    /// side of b² = 4k; otherwise the overdamped ones are NaN. Derivatives by h exist everywhere,
    /// those by k and b except at b² = 4k.
    pub fn increment(&self, h: T, q: T, p: T) -> [T; 3] {
        self.advance(h, q, p).1
    }

    /// The new (q, p), and the increments of (q, p, w).
    fn advance(&self, h: T, q: T, p: T) -> ([T; 2], [T; 3]) {
        let creeping = self.b.half().mul_add(self.b.half(), -self.k);
        if T::zero().lt(creeping).all() {
            let m = self.creep(creeping.sqrt(), h);
            let (z, [dq, dp]) = m.apply(self.k, q, p);
            // -ΔH = -(p Δp + k q Δq) - ½ (Δp² + k Δq²). The terms of the first bracket in pq
            // cancel: left out.
            let [of_q, of_p] = [m.rate.mul_add(m.sigma, m.lose[0]), m.lose[1] - m.rate * m.sigma];
            let square = |q: T, p: T| self.k.mul_add(q * q, p * p);
            let linear = (of_p * p).mul_add(p, of_q * self.k * q * q);
            (z, [dq, dp, -linear - square(dq, dp).half()])
        } else {
            let m = self.swing(-creeping, h);
            let ([q1, p1], [dq, dp]) = m.apply(self.k, q, p);
            // The entry above by det M = e^{-bh}, which vanishes with b: -(e^{-bh} - 1) H + ½ b σ
            // (p p1 - k q q1).
            let decay = (-self.b * h).exp_m1() * self.k.mul_add(q * q, p * p);
            let exchange = self.b * m.sigma * (p * p1 - self.k * q * q1);
            ([q1, p1], [dq, dp, (exchange - decay).half()])
        }
    }

    /// b² ≤ 4k, where `s` = k - b²/4.
    fn swing(&self, s: T, h: T) -> Transition<T> {
        let rate = self.b.half();
        // At s = 0 exactly the angle is 0 and sin(ωh)/ω is h.
        let critical = s.le(T::zero()).and(T::zero().le(s));
        let omega = T::select(critical, T::one(), s).sqrt();
        let angle = T::select(critical, T::zero(), omega * h).half();
        let (sin, cos) = angle.sin_cos();
        let versine = sin * sin + sin * sin;
        let ratio = T::select(critical, h, (sin * cos + sin * cos) / omega);
        let (decay, cos) = ((-rate * h).exp(), T::one() - versine);
        let (keep, lose) = (decay * cos, (-rate * h).exp_m1().mul_add(cos, -versine));
        Transition { keep: [keep; 2], lose: [lose; 2], sigma: decay * ratio, rate }
    }

    /// b² > 4k, where `root` = √(b²/4 - k).
    fn creep(&self, root: T, h: T) -> Transition<T> {
        let root = T::select(self.b.lt(T::zero()), -root, root);
        let fast = self.b.half() + root;
        let slow = self.k / fast;
        let gap = root + root;
        let exponents = [-slow * h, -fast * h];
        let keep = exponents.map(T::exp);
        let sigma = -keep[0] * (-gap * h).exp_m1() / gap;
        Transition { keep, lose: exponents.map(T::exp_m1), sigma, rate: slow }
    }
}

impl<T: Scalar> Transition<T> {
    /// M z and (M - I) z for z = (q, p).
    fn apply(&self, k: T, q: T, p: T) -> ([T; 2], [T; 2]) {
        let mix = [self.sigma * self.rate.mul_add(q, p), -self.sigma * k.mul_add(q, self.rate * p)];
        let z = [q, p];
        let change = [0, 1].map(|i| self.lose[i].mul_add(z[i], mix[i]));
        // Added to z while that is the larger part, so that nothing is lost on small steps;
        // afterwards on its own, so that a state that has decayed keeps its digits.
        let new = [0, 1].map(|i| {
            let short = self.lose[i].abs().lt(T::from_f64(0.5));
            T::select(short, z[i] + change[i], self.keep[i].mul_add(z[i], mix[i]))
        });
        (new, change)
    }
}

impl<T: Scalar> ExactFlow<T> for DampedOscillator<T> {
    /// By [`DampedOscillator::increment`], with its limits.
    fn flow<V: Vector<Scalar = T>>(&self, h: T, state: &mut State<V>) {
        let (q, p, w) = (state.q.as_mut_slice(), state.p.as_mut_slice(), state.w.as_mut_slice());
        let ([q1, p1], [_, _, dw]) = self.advance(h, q[0], p[0]);
        (q[0], p[0], w[0]) = (q1, p1, w[0] + dw);
        state.t += h;
    }
}
