//! δ₃ and δ₄ of the paper's section 4, for any k. With F = k q + b p = -p' and Q = p² + b q p + k
//! q²,
//!
//! ```text
//! δ₃(q) = -p''/(12 p)                  = (k - b² - b k q/p)/12
//! δ₄(q) = -(p'''/24 + p' δ₃/2)/p       = -b k Q/(24 p²)
//! δ₃(p) = p'''/(12 F)                  = (k - b² + b k p/F)/12
//! δ₄(p) = (p''''/24 + p'' δ₃/2)/F      = -b k² Q/(24 F²)
//! ```
//!
//! all derivatives in time along the flow. The paper has k = 1, and two misprints there:
//!
//! ```text
//! δ₄(q) lacks the term -p'''/(24 p):      -p' δ₃/(2 p)
//! δ₃(p) has 22 b p in place of 2 b p:     δ₃ + 20 b p/(12 F)
//! ```
//!
//! For other k the first is taken as it stands and the extra term of the second is ours, 20 b k
//! p/(12 F), so that it is still the term in p that grows elevenfold.

use super::DampedOscillator;
use afterbay_core::{Correction, Misprinted, OrderRaising, Scalar, System};

impl<T: Scalar> DampedOscillator<T> {
    /// F = V' + D = -p'
    fn force(&self, q: T, p: T) -> T {
        self.k.mul_add(q, self.b * p)
    }

    /// Q = p² + b q p + k q²
    fn form(&self, q: T, p: T) -> T {
        p.mul_add(p, q * self.force(q, p))
    }

    /// δ without damping, when it is a number: both poles are gone. It is 2 tan(ωh/2)/ω.
    fn undamped(&self) -> Option<Correction<T>> {
        let third = self.k / T::from_f64(12.0);
        self.dissipation_form().zero.then_some(Correction { third, fourth: T::zero() })
    }
}

impl<T: Scalar> OrderRaising<T> for DampedOscillator<T> {
    fn delta_q(&self, q: T, p: T) -> Correction<T> {
        if let Some(correction) = self.undamped() {
            return correction;
        }
        let (k, b) = (self.k, self.b);
        Correction {
            third: (k - b * b - b * k * q / p) / T::from_f64(12.0),
            fourth: -b * k * self.form(q, p) / (T::from_f64(24.0) * p * p),
        }
    }

    fn delta_p(&self, q: T, p: T) -> Correction<T> {
        if let Some(correction) = self.undamped() {
            return correction;
        }
        let (k, b, force) = (self.k, self.b, self.force(q, p));
        Correction {
            third: (k - b * b + b * k * p / force) / T::from_f64(12.0),
            fourth: -b * k * k * self.form(q, p) / (T::from_f64(24.0) * force * force),
        }
    }
}

impl<T: Scalar> Misprinted<T> for DampedOscillator<T> {
    /// Without damping δ₄ is `k F/(24 p)`, and has its pole even then.
    fn printed_delta_q(&self, q: T, p: T) -> Correction<T> {
        let third = self.delta_q(q, p).third;
        Correction { third, fourth: (self.force(q, p) * third / p).half() }
    }

    fn printed_delta_p(&self, q: T, p: T) -> Correction<T> {
        let right = self.delta_p(q, p);
        let extra =
            T::from_f64(20.0) * self.b * self.k * p / (T::from_f64(12.0) * self.force(q, p));
        Correction { third: right.third + extra, ..right }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Quad, Series, taylor};
    use proptest::prelude::*;

    /// The paper's fractions, letter by letter (k = 1): δ₃(p) without its misprint, δ₄(p) as it is.
    fn fractions(b: f64, q: f64, p: f64) -> [f64; 2] {
        let force = q + b * p;
        let third = (-b.powi(3) * p - b * b * q + 2.0 * b * p + q) / (12.0 * force);
        let squares = -b.powi(5) * p * p - 2.0 * b.powi(4) * q * p + 3.0 * b.powi(3) * p * p
            - b.powi(3) * q * q
            + 4.0 * b * b * q * p
            + b * q * q
            - 2.0 * b * p * p
            - q * p;
        let linear = b.powi(4) * p + b.powi(3) * q - 3.0 * b * b * p - 2.0 * b * q + p;
        let fourth =
            squares / (24.0 * (b * b * p * p + 2.0 * b * q * p + q * q)) + linear / (24.0 * force);
        [third, fourth]
    }

    fn assert_close(found: Correction<Quad>, exact: Correction<Quad>, size: f64) {
        let off = |a: Quad, b: Quad| a.sub_accurate(b).0.abs();
        assert!(off(found.third, exact.third) < 1e-30 * size, "{found:?} {exact:?}");
        assert!(off(found.fourth, exact.fourth) < 1e-30 * size * size, "{found:?} {exact:?}");
    }

    proptest! {
        #[test]
        fn closed_forms_are_the_taylor_coefficients(
            k in 0.1..5.0_f64, b in -4.0..4.0_f64, q in -3.0..3.0_f64, p in -3.0..3.0_f64,
        ) {
            let system = DampedOscillator::new(k, b).unwrap();
            let force = system.force(q, p);
            prop_assume!(p.abs() > 1e-2 && force.abs() > 1e-2);
            let (quad, q, p) = (system.map(Quad::from_f64), Quad::from_f64(q), Quad::from_f64(p));
            let [exact_q, exact_p] = taylor::corrections(&quad.map(Series::constant), q, p);
            // Every Taylor coefficient is a sum of terms that grow like this, over p or F.
            let rate = 1.0 + k + b.abs();
            let size = |pole: f64| rate.powi(3) * (1.0 + (q.0.abs() + p.0.abs()) / pole.abs());
            assert_close(quad.delta_q(q, p), exact_q, size(p.0));
            assert_close(quad.delta_p(q, p), exact_p, size(force));
        }

        #[test]
        fn for_k_1_they_are_the_papers(b in 0.01..3.0_f64, q in 0.1..3.0_f64, p in 0.1..3.0_f64) {
            let delta = DampedOscillator::new(1.0, b).unwrap().delta_p(q, p);
            let [third, fourth] = fractions(b, q, p);
            let size = 1e-15 * (1.0_f64 + b).powi(5) * (1.0 + p / q).powi(2);
            prop_assert!((delta.third - third).abs() < size, "{delta:?} {third}");
            prop_assert!((delta.fourth - fourth).abs() < size, "{delta:?} {fourth}");
        }
    }

    #[test]
    fn without_damping_there_is_no_pole() {
        let system = DampedOscillator::new(3.0, 0.0).unwrap();
        let expected = Correction { third: 0.25, fourth: 0.0 };
        for (q, p) in [(2.3, -3.1), (1.0, 0.0), (0.0, 1.0)] {
            assert_eq!((system.delta_q(q, p), system.delta_p(q, p)), (expected, expected));
        }
    }

    #[test]
    fn a_pole_is_not_finite() {
        let system = DampedOscillator::new(2.0, 0.5).unwrap();
        for delta in
            [system.delta_q(1.0, 0.0), system.delta_p(0.25, -1.0), system.printed_delta_q(1.0, 0.0)]
        {
            assert!(!delta.third.is_finite() && !delta.fourth.is_finite(), "{delta:?}");
        }
    }

    #[test]
    fn misprints_are_what_the_paper_prints() {
        let (b, q, p) = (0.1, 2.3, -3.1_f64);
        let system = DampedOscillator::new(1.0, b).unwrap();
        let force = q + b * p;
        let (right_q, right_p) = (system.delta_q(q, p), system.delta_p(q, p));
        let (printed_q, printed_p) = (system.printed_delta_q(q, p), system.printed_delta_p(q, p));
        let fourth = force * (-b * b * p - b * q + p) / (24.0 * p * p);
        let third = (-b.powi(3) * p - b * b * q + 22.0 * b * p + q) / (12.0 * force);
        assert!(
            (printed_q.fourth - fourth).abs() < 1e-16 && (printed_p.third - third).abs() < 1e-15
        );
        assert_eq!((printed_q.third, printed_p.fourth), (right_q.third, right_p.fourth));
        assert!((printed_q.fourth - right_q.fourth).abs() > 1e-2, "{printed_q:?} {right_q:?}");
        assert!((printed_p.third - right_p.third).abs() > 1e-1, "{printed_p:?} {right_p:?}");
        // Without damping the missing term is all there is.
        let undamped = DampedOscillator::new(1.0, 0.0).unwrap();
        assert_eq!(undamped.printed_delta_q(q, p).fourth, q / p / 12.0 / 2.0);
    }
}
