//! The defect z' - f(z) of a Taylor polynomial over a whole stride.
//!
//! The coefficients at one point do not show features that are narrower than the distance to them:
//! tanh(p/0.001) is ±1 to 106 bits at p = ±0.05. The defect shows them. Its coefficients below
//! order M - 1 vanish by construction, and Taylor's remainder gives the rest. With z a polynomial
//! of degree M - 1 in σ = t/τ,
//!
//! ```text
//! z'(σ) - τ f(z(σ)) = -τ c(ξ) σ^{M-1}, 0 ≤ ξ ≤ σ        c: coefficient M - 1 of f(z(ξ + ·))
//! ```
//!
//! so that τ c/M, with a bound c over [0, 1], bounds the error that the stride adds.

use super::Expansion;
use super::expansion::{KINDS, kinds};
use crate::numbers::{Interval, Scalar, Series, Vector, larger_or_nan};
use crate::system::{State, System};

/// The error that a stride may add to an entry, in unit roundoffs of the largest of its kind. A
/// choice: about the rounding error of the evaluation itself.
pub(super) const ALLOWED_ROUNDINGS: f64 = 16.0;

/// The accuracy with which the polynomial of a stride solves the equations.
pub trait Defect<V: Vector, const M: usize>: Sync {
    /// The share of the stride τ, which may be negative, from its beginning, over which the defect
    /// is known to add no more than a few roundings to the error; 0 if nothing is known.
    fn solved(&self, expansion: &Expansion<V, M>, tau: f64) -> f64;

    /// The longest time of a feature that may be missed within a stride of this length.
    fn unseen(&self, stride: f64) -> f64;
}

/// Enclosures of f along the polynomial, over parts of the stride as short as needed. No feature is
/// missed, however narrow.
///
/// The coefficients of the polynomial z about the points of a range of σ are intervals. f of this
/// [`Series`] of [`Interval`]s encloses coefficient M - 1 (R. E. Moore, *Interval Analysis*, 1966).
pub struct Enclosed<S> {
    /// The system, its scalar a series of intervals.
    system: S,
}

/// The largest number of enclosures in one stride. A choice: a stride whose first part would be
/// shorter than 2⁻⁴⁷ of it is not solved.
const MOST_ENCLOSURES: u32 = 48;
/// The shortest part, as a share of the solved parts before it; shorter ones are left to the next
/// stride.
const SHORTEST_PART: f64 = 0.125;

impl<S> Enclosed<S> {
    /// The enclosures for a system whose scalar is a series of intervals.
    pub fn new(system: S) -> Self {
        Self { system }
    }

    /// Bounds of coefficient M - 1 of f of each kind of entry over [from, to], infinite where there
    /// are none.
    fn bounds<V, const M: usize>(&self, scaled: &State<V>, [from, to]: [f64; 2]) -> [f64; KINDS]
    where
        V: Vector<Scalar = Series<Interval, M>>,
        S: System<Series<Interval, M>>,
    {
        let shift = |part: &V| V::filled(part.as_slice(), |x| about(x, Interval::new(from, to)));
        let (q, p) = (shift(&scaled.q), shift(&scaled.p));
        let [mut hq, mut hp, mut d] = [(); 3].map(|()| V::zeros(scaled.dof()));
        self.system.gradient(q.as_slice(), p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
        self.system.dissipation(q.as_slice(), p.as_slice(), hp.as_slice(), d.as_mut_slice());
        let size = |x: Series<Interval, M>| x.c[M - 1].magnitude();
        let (free, mut bounds) = (scaled.dof() - self.system.motors(), [0.0_f64; KINDS]);
        for j in 0..scaled.dof() {
            let [hq, hp, d] = [&hq, &hp, &d].map(|part| part.as_slice()[j]);
            let found = [size(hp), size(hq + d), size(d * hp)];
            for (kind, found) in kinds(free, j).into_iter().zip(found) {
                bounds[kind] = larger_or_nan(bounds[kind], found);
            }
        }
        bounds
    }
}

/// The coefficients of a polynomial about the points of a range, by Horner's rule.
fn about<const M: usize>(
    mut polynomial: Series<Interval, M>,
    range: Interval,
) -> Series<Interval, M> {
    let (terms, c) = (polynomial.terms(), &mut polynomial.c);
    for k in 0..terms {
        for j in (k + 1..terms).rev() {
            c[j - 1] = c[j].mul_add(range, c[j - 1]);
        }
    }
    polynomial
}

/// An interval that contains the number.
fn enclosing<T: Scalar>(c: T) -> Interval {
    let near = c.to_f64();
    if T::from_f64(near) == c {
        Interval::from_f64(near)
    } else {
        Interval::new(near.next_down(), near.next_up())
    }
}

impl<V, S, const M: usize> Defect<V, M> for Enclosed<S>
where
    V: Vector,
    S: System<Series<Interval, M>>,
{
    fn solved(&self, expansion: &Expansion<V, M>, tau: f64) -> f64 {
        let mut powers = [Interval::one(); M];
        (1..M).for_each(|k| powers[k] = powers[k - 1] * Interval::from_f64(tau));
        let scale = |x: Series<V::Scalar, M>| {
            Series::<Interval, M>::new(std::array::from_fn(|k| enclosing(x.c[k]) * powers[k]))
        };
        let part = |part: &V::Of<Series<V::Scalar, M>>| {
            <V::Of<Series<Interval, M>> as Vector>::filled(part.as_slice(), scale)
        };
        let [q, p, w] = [&expansion.series.q, &expansion.series.p, &expansion.series.w].map(part);
        let scaled = State { q, p, w, t: Series::zero() };
        let (mut done, mut width, mut largest) = (0.0, 1.0, [0.0_f64; KINDS]);
        for _ in 0..MOST_ENCLOSURES {
            let to: f64 = f64::min(done + width, 1.0);
            let found = self.bounds(&scaled, [done, to]);
            let most: [f64; KINDS] = std::array::from_fn(|i| larger_or_nan(largest[i], found[i]));
            let share = tau.abs() / M as f64 * to.powi(M as i32);
            let scales = expansion.scales(tau.abs() * to);
            let small = |(&most, scale): (&f64, f64)| {
                share * most <= ALLOWED_ROUNDINGS * <V::Scalar as Scalar>::EPSILON * scale
            };
            if most.iter().zip(scales).all(small) {
                (done, largest) = (to, most);
                if done == 1.0 {
                    break;
                }
            } else {
                width /= 2.0;
                if width < SHORTEST_PART * done {
                    break;
                }
            }
        }
        done
    }

    fn unseen(&self, _stride: f64) -> f64 {
        0.0
    }
}

/// Samples of the defect, for systems that cannot be evaluated in intervals. Features that are
/// passed in less than a [`SAMPLES`]th of a stride may be missed.
pub struct Sampled<'a, S: ?Sized>(pub &'a S);

/// The number of equally spaced samples in a stride.
pub const SAMPLES: usize = 48;

/// The number of lengths tried for a stride, each an eighth of the one before, until its first
/// sample is solved. The last is 8⁻¹¹, about 1e-10, of the stride.
const MOST_CUTS: i32 = 12;

impl<V, S, const M: usize> Defect<V, M> for Sampled<'_, S>
where
    V: Vector,
    S: System<Series<V::Scalar, M>> + ?Sized,
{
    fn solved(&self, expansion: &Expansion<V, M>, tau: f64) -> f64 {
        for cut in 0..MOST_CUTS {
            let part = 0.125_f64.powi(cut);
            let solved =
                (1..=SAMPLES).take_while(|&i| self.is_small(expansion, tau * part, i)).count();
            if solved > 0 {
                return part * solved as f64 / SAMPLES as f64;
            }
        }
        0.0
    }

    fn unseen(&self, stride: f64) -> f64 {
        stride.abs() / SAMPLES as f64
    }
}

impl<S: ?Sized> Sampled<'_, S> {
    /// Whether a defect that is everywhere as large as at sample `i` of the stride τ adds no more
    /// to the error than a stride may.
    fn is_small<V, const M: usize>(&self, expansion: &Expansion<V, M>, tau: f64, i: usize) -> bool
    where
        V: Vector,
        S: System<Series<V::Scalar, M>>,
    {
        let at = V::Scalar::from_f64(tau * (i as f64 / SAMPLES as f64));
        let state = expansion.at(at);
        let value = |x| Series::constant(x).first();
        let lift = |part: &V| V::Of::<Series<V::Scalar, M>>::filled(part.as_slice(), value);
        let (q, p) = (lift(&state.q), lift(&state.p));
        let n = state.dof();
        let [mut hq, mut hp, mut d] = [(); 3].map(|()| V::Of::<Series<V::Scalar, M>>::zeros(n));
        self.0.gradient(q.as_slice(), p.as_slice(), hq.as_mut_slice(), hp.as_mut_slice());
        self.0.dissipation(q.as_slice(), p.as_slice(), hp.as_slice(), d.as_mut_slice());
        let Expansion { series, .. } = expansion;
        let mut off = [0.0_f64; KINDS];
        for j in 0..n {
            let [hq, hp, d] = [&hq, &hp, &d].map(|part| part.as_slice()[j].c[0]);
            let rates = [(&series.q, hp), (&series.p, -hq - d), (&series.w, d * hp)];
            for (kind, (part, rate)) in expansion.kinds(j).into_iter().zip(rates) {
                let apart = (part.as_slice()[j].rate_at(at) - rate).abs().to_f64() * tau.abs();
                off[kind] = larger_or_nan(off[kind], apart);
            }
        }
        let scales = expansion.scales(tau.abs());
        // The factor 4 allows for the rounding error of f, whose terms may cancel.
        let small = |(off, scale): (f64, f64)| {
            off <= 4.0 * ALLOWED_ROUNDINGS * <V::Scalar as Scalar>::EPSILON * scale
        };
        off.into_iter().zip(scales).all(small)
    }
}
