//! Systems defined by formulas that are written once for every scalar.

use super::abilities::{Abilities, SecondDerivatives};
use super::dissipation::{Dissipation, DissipationForm};
use super::hamiltonian::System;
use super::hessian::Curvature;
use super::separable::{Separable, masses};
use crate::error::InputError;
use crate::numbers::singularity::{Sight, between, diverges, enclosed, is_singular};
use crate::numbers::{Interval, Line, Scalar, Slope, divided};
use crate::quantity::Block;
use std::sync::Arc;

/// H = Σ p_j²/(2 m_j) + V(q) and D_j(q, v) with v_j = p_j/m_j, written once for every scalar.
///
/// [`FromFormulas`] makes a system of them: gradients, divided differences, second derivatives and
/// the derivatives of D come from the formulas by slope arithmetic ([`Slope`]).
///
/// A scalar may stand for two points at once, the ends of an edge. So choose between two
/// expressions by [`Scalar::select`], not by `if` on [`Scalar::to_f64`], which sees one end alone:
/// divided differences across the border are wrong then, and K is not kept.
/// [`validate::separable`](crate::validate::separable) finds this near the border.
pub trait Formulas: Send + Sync {
    /// N, the number of degrees of freedom.
    fn dof(&self) -> usize;

    /// V(q)
    fn potential<T: Scalar>(&self, q: &[T]) -> T;

    /// D_j(q, v). It depends on no velocity but that of j, unless [`Formulas::dissipation_form`] is
    /// coupled.
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T;

    /// The mass m_j > 0. A run with a mass that is not positive or not finite is refused.
    fn mass(&self, _j: usize) -> f64 {
        1.0
    }

    /// The properties of D that hold at every state.
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm::GENERAL
    }

    /// Passes to `put` every x(q, v) at whose zeros the slopes of V or D may not be analytic, such
    /// as v_j if D contains |v_j|. Methods of high order take shorter steps across them, and
    /// references are not continued across them ([`System::kinks`]).
    fn kinks<T: Scalar>(&self, _q: &[T], _v: &[T], _put: &mut dyn FnMut(T)) {}

    /// Whether V may be singular where q is finite. If true, each step is examined by V in
    /// intervals, and refused across a singularity. Return `false` for a V without singularities to
    /// save this time. Return it, too, if V has a root whose argument stays at 0 within its
    /// roundings, as that of spheres that just touch: in intervals it looks like a singularity.
    fn may_be_singular(&self) -> bool {
        true
    }
}

/// The system of [`Formulas`], in any scalar. Its divided differences are exact to roundings on
/// edges of any length.
///
/// A gradient takes N evaluations of V, a divided difference three. Where V is a sum over many
/// neighbours, a [`Separable`] written by hand is faster. Up to 64 degrees of freedom nothing is
/// allocated.
#[derive(Clone, Copy, Debug)]
pub struct FromFormulas<F>(pub F);

/// The largest number of degrees of freedom whose arguments are stored on the stack.
const MOST_ON_STACK: usize = 64;

/// Calls `f` with n numbers, given by index.
#[inline(always)]
fn with_entries<T: Scalar, R>(
    n: usize,
    entry: impl Fn(usize) -> T,
    f: impl FnOnce(&[T]) -> R,
) -> R {
    if n <= 4 {
        let mut room = [T::zero(); 4];
        for (i, x) in room.iter_mut().enumerate() {
            if i < n {
                *x = entry(i);
            }
        }
        f(&room[..n])
    } else if n <= MOST_ON_STACK {
        let mut room = [T::zero(); MOST_ON_STACK];
        for (i, x) in room[..n].iter_mut().enumerate() {
            *x = entry(i);
        }
        f(&room[..n])
    } else {
        f(&(0..n).map(entry).collect::<Vec<_>>())
    }
}

/// Calls `f` with n numbers, given by index: `at` for entry j, and constants for the others.
#[inline(always)]
fn along<T: Scalar, R>(
    n: usize,
    entry: impl Fn(usize) -> T,
    j: usize,
    at: Slope<T>,
    f: impl FnOnce(&[Slope<T>]) -> R,
) -> R {
    with_entries(n, |i| if i == j { at } else { Slope::constant(entry(i)) }, f)
}

impl<F: Formulas> FromFormulas<F> {
    /// The slope of V along q_j.
    #[inline(always)]
    fn potential<T: Scalar>(&self, q: &[T], j: usize, at: Slope<T>) -> Slope<T> {
        along(q.len(), |i| q[i], j, at, |q| self.0.potential(q))
    }

    /// Whether V is singular somewhere on a line, given its coordinates at a share of it.
    #[cold]
    fn is_singular(&self, n: usize, line: &dyn Fn(usize, Interval) -> Interval) -> bool {
        let value = |share: f64| {
            let point = |i| line(i, Interval::from_f64(share)).to_f64();
            with_entries(n, point, |q| self.0.potential(q))
        };
        is_singular([0.0, 1.0], |share| {
            if with_entries(n, |i| line(i, share), |q| self.0.potential(q)).is_bounded() {
                Sight::Clear
            } else if diverges(share.to_f64(), 1.0, value) {
                Sight::Pole
            } else {
                Sight::Border
            }
        })
    }

    /// The slope of D_j along q_j and v_j.
    #[inline(always)]
    fn dissipation_between<T: Scalar>(
        &self,
        [q, p]: [&[T]; 2],
        j: usize,
        at: [Slope<T>; 2],
    ) -> Slope<T> {
        let v = |i: usize| p[i] / T::from_f64(self.0.mass(i));
        along(
            q.len(),
            |i| q[i],
            j,
            at[0],
            |q| along(q.len(), v, j, at[1], |v| self.0.dissipation(q, v, j)),
        )
    }
}

impl<T: Scalar, F: Formulas> System<T> for FromFormulas<F> {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn check(&self) -> Result<(), InputError> {
        masses::<T>(self)
    }

    fn energy(&self, q: &[T], p: &[T]) -> T {
        let twice =
            (0..p.len()).fold(T::zero(), |sum, j| sum + p[j] * p[j] / T::from_f64(self.0.mass(j)));
        twice.half() + self.0.potential(q)
    }

    fn gradient(&self, q: &[T], p: &[T], hq: &mut [T], hp: &mut [T]) {
        for j in 0..q.len() {
            (hq[j], hp[j]) = (self.partial(q, j, q[j]), p[j] / T::from_f64(self.0.mass(j)));
        }
    }

    fn dissipation(&self, q: &[T], _p: &[T], v: &[T], d: &mut [T]) {
        d.iter_mut().enumerate().for_each(|(j, d)| *d = self.0.dissipation(q, v, j));
    }

    fn dissipation_form(&self) -> DissipationForm {
        self.0.dissipation_form()
    }

    fn kinks(&self, q: &[T], p: &[T], put: &mut dyn FnMut(T)) {
        let v = |j: usize| p[j] / T::from_f64(self.0.mass(j));
        with_entries(p.len(), v, |v| self.0.kinks(q, v, put));
    }

    fn may_be_singular(&self) -> bool {
        self.0.may_be_singular()
    }

    fn is_singular_between(&self, from: &[T], to: &[T]) -> bool {
        (0..T::LANES).any(|lane| {
            self.is_singular(from.len(), &|i, share| {
                between(enclosed(from[i], lane), enclosed(to[i], lane), share)
            })
        })
    }
}

impl<T: Scalar, F: Formulas> Separable<T> for FromFormulas<F> {
    fn mass(&self, j: usize) -> T {
        T::from_f64(self.0.mass(j))
    }

    fn partial(&self, q: &[T], j: usize, at: T) -> T {
        self.potential(q, j, Slope::between(at, at)).slope
    }

    fn divided_difference(&self, q: &[T], j: usize, to: T) -> Line<T> {
        divided::of_potential(q[j], to, |at| self.potential(q, j, at))
    }

    fn has_exact_divided_differences(&self) -> bool {
        true
    }

    fn is_singular_along(&self, q: &[T], j: usize, to: T) -> bool {
        (0..T::LANES).any(|lane| {
            self.is_singular(q.len(), &|i, share| {
                let from = enclosed(q[i], lane);
                if i == j { between(from, enclosed(to, lane), share) } else { from }
            })
        })
    }

    fn dissipation_of(&self, q: &[T], p: &[T], j: usize) -> Dissipation<T> {
        let (m, at) = (T::from_f64(self.0.mass(j)), q[j]);
        let v = p[j] / m;
        let by_q =
            self.dissipation_between([q, p], j, [Slope::between(at, at), Slope::constant(v)]);
        let by_v = self.dissipation_between([q, p], j, [Slope::constant(at), Slope::between(v, v)]);
        Dissipation { value: by_q.end, by_q: by_q.slope, by_p: by_v.slope / m }
    }
}

/// All second derivatives come from the formulas by slope arithmetic in slopes: N (N + 1)/2
/// evaluations of V, and N or N² of each D_j.
impl<T: Scalar, F: Formulas> Curvature<T> for FromFormulas<F> {
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        let n = q.len();
        let form = self.0.dissipation_form();
        for i in 0..n {
            for j in 0..=i {
                let second = along(
                    n,
                    |k| q[k],
                    j,
                    Slope::between(q[j], q[j]),
                    |q| self.potential(q, i, Slope::between(q[i], q[i])).slope.slope,
                );
                put(Block::Hqq, i, j, second);
                if j < i {
                    put(Block::Hqq, j, i, second);
                }
            }
            let m = T::from_f64(self.0.mass(i));
            put(Block::Hpp, i, i, m.recip());
            if form.zero {
                continue;
            }
            let v = |k: usize| p[k] / T::from_f64(self.0.mass(k));
            let still = |x: T| Slope::between(x, x);
            for j in 0..n {
                let by_q = along(
                    n,
                    |k| q[k],
                    j,
                    still(q[j]),
                    |q| with_entries(n, |k| Slope::constant(v(k)), |v| self.0.dissipation(q, v, i)),
                );
                put(Block::Dq, i, j, by_q.slope);
                if i == j || form.coupled {
                    let by_v = with_entries(
                        n,
                        |k| Slope::constant(q[k]),
                        |q| along(n, v, j, still(v(j)), |v| self.0.dissipation(q, v, i)),
                    );
                    put(Block::Dp, i, j, by_v.slope / T::from_f64(self.0.mass(j)));
                }
            }
        }
    }
}

impl<T: Scalar, F: Formulas + 'static> Abilities<T> for FromFormulas<F> {
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        Some(self)
    }

    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        Some(self)
    }
}
