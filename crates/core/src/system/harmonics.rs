//! Forces that are sums of sines and cosines of the time.

use crate::numbers::{Mask, Scalar};

/// A function of the time, c + Σ_k (a_k cos ω_k t + b_k sin ω_k t).
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics<T> {
    /// The constant c.
    pub constant: T,
    /// The terms of the sum. [`Harmonics::add`] keeps their frequencies positive and distinct.
    pub terms: Vec<Harmonic<T>>,
}

/// One term, a cos ωt + b sin ωt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic<T> {
    /// The angular frequency ω.
    pub frequency: T,
    /// The coefficient a of cos ωt.
    pub cosine: T,
    /// The coefficient b of sin ωt.
    pub sine: T,
}

impl<T: Scalar> Harmonics<T> {
    /// The constant function c.
    pub fn constant(constant: T) -> Self {
        Self { constant, terms: Vec::new() }
    }

    /// Adds a term. One with both coefficients 0 is left out.
    pub fn add(&mut self, mut term: Harmonic<T>) {
        let zero = T::zero();
        if term.cosine == zero && term.sine == zero {
            return;
        }
        if term.frequency == zero {
            self.constant += term.cosine;
            return;
        }
        if term.frequency.lt(zero).all() {
            (term.frequency, term.sine) = (-term.frequency, -term.sine);
        }
        match self.terms.iter_mut().find(|other| other.frequency == term.frequency) {
            Some(other) => {
                other.cosine += term.cosine;
                other.sine += term.sine;
            }
            None => self.terms.push(term),
        }
    }

    /// The value at t.
    pub fn at(&self, t: T) -> T {
        self.terms.iter().fold(self.constant, |sum, term| {
            let (sin, cos) = (term.frequency * t).sin_cos();
            sum + term.cosine * cos + term.sine * sin
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_of_one_frequency_are_one() {
        let mut sum = Harmonics::constant(0.5);
        for [frequency, cosine, sine] in
            [[1.5, 1.0, 2.0], [0.0, 3.0, 4.0], [-1.5, 0.25, 0.5], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]
        {
            sum.add(Harmonic { frequency, cosine, sine });
        }
        assert_eq!(sum.constant, 3.5);
        let terms = [[1.5, 1.25, 1.5], [2.0, 1.0, 0.0]].map(|[frequency, cosine, sine]| Harmonic {
            frequency,
            cosine,
            sine,
        });
        assert_eq!(sum.terms, terms);
        let exact = 3.5 + 1.25 * 1.05_f64.cos() + 1.5 * 1.05_f64.sin() + 1.4_f64.cos();
        assert!((sum.at(0.7) - exact).abs() < 1e-14);
    }
}
