//! The abilities of a system, queried at run time.

use super::drive::{Drive, Driven};
use super::exact_flow::ExactFlow;
use super::hamiltonian::System;
use super::hessian::Curvature;
use super::lattice::{EndMembers, Uniform};
use super::linear::Linear;
use super::nonseparable::PhasePlane;
use super::order_raising::{Misprinted, OrderRaising};
use super::separable::Separable;
use super::state::State;
use crate::error::InputError;
use crate::numbers::{Scalar, f64x8};
use crate::quantity::Block;
use std::any::Any;
use std::sync::Arc;

/// A system whose concrete type is erased and whose abilities can be queried.
///
/// Each ability is a trait of its own, and a system returns `Some(self)` for those it implements. A
/// method uses the fastest algorithm they allow and refuses a system that lacks an ability it
/// needs.
///
/// ```
/// # use afterbay_core::*;
/// # use std::sync::Arc;
/// # struct Free;
/// # impl System<f64> for Free {
/// #     fn dof(&self) -> usize { 1 }
/// #     fn energy(&self, _q: &[f64], p: &[f64]) -> f64 { p[0] * p[0] / 2.0 }
/// #     fn gradient(&self, _q: &[f64], p: &[f64], hq: &mut [f64], hp: &mut [f64]) {
/// #         (hq[0], hp[0]) = (0.0, p[0]);
/// #     }
/// #     fn dissipation(&self, _q: &[f64], _p: &[f64], _v: &[f64], d: &mut [f64]) { d[0] = 0.0; }
/// # }
/// # impl Separable<f64> for Free {
/// #     fn partial(&self, _q: &[f64], _j: usize, _at: f64) -> f64 { 0.0 }
/// #     fn dissipation_of(&self, _q: &[f64], _p: &[f64], _j: usize) -> Dissipation<f64> {
/// #         Dissipation { value: 0.0, by_q: 0.0, by_p: 0.0 }
/// #     }
/// # }
/// impl Abilities<f64> for Free {
///     fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<f64>>> {
///         Some(self)
///     }
/// }
/// let system: Arc<dyn Abilities<f64>> = Arc::new(Free);
/// assert!(system.clone().separable().is_some() && system.second_derivatives().is_none());
/// ```
pub trait Abilities<T: Scalar>: System<T> + Any {
    /// H = Σ p_j²/(2 m_j) + V(q).
    fn separable(self: Arc<Self>) -> Option<Arc<dyn Separable<T>>> {
        None
    }

    /// H along one coordinate or one momentum at a time.
    fn phase_planes(self: Arc<Self>) -> Option<Arc<dyn PhasePlane<T>>> {
        None
    }

    /// The second derivatives of H and the derivatives of D.
    fn second_derivatives(self: Arc<Self>) -> Option<Arc<dyn SecondDerivatives<T>>> {
        None
    }

    /// A flow that is linear, of a separable system.
    fn linear(self: Arc<Self>) -> Option<Arc<dyn Linear<T>>> {
        None
    }

    /// The δ that raise the order of the modified discrete gradient.
    fn order_raising(self: Arc<Self>) -> Option<Arc<dyn OrderRaising<T>>> {
        None
    }

    /// δ as printed in the paper, for [`Misprinted`] systems.
    fn misprinted(self: Arc<Self>) -> Option<Arc<dyn Misprinted<T>>> {
        None
    }

    /// The exact flow.
    fn exact_flow(self: Arc<Self>) -> Option<Arc<dyn Flow<T>>> {
        None
    }

    /// A system and its drive.
    fn driven(&self) -> Option<&Driven<dyn Abilities<T>, dyn Drive<T>>> {
        None
    }

    /// Whether it is a chain or a ring of equal members ([`Uniform`]).
    fn is_uniform(&self) -> bool {
        false
    }

    /// A chain or a ring of equal members, in `f64`; none in other scalars.
    fn uniform(self: Arc<Self>) -> Option<Arc<dyn Members>> {
        None
    }
}

/// A block of derivatives, the row and the column in it, and the entry there.
pub type Entry<T> = (Block, usize, usize, T);

/// The number of entries handed over at a time.
const ENTRIES: usize = 16;

/// [`Curvature`] with its type erased. Every system with curvature implements it.
pub trait SecondDerivatives<T: Scalar>: System<T> {
    /// [`Curvature::curvature`], some entries at a time.
    fn each(&self, q: &[T], p: &[T], put: &mut dyn FnMut(&[Entry<T>]));

    /// [`Curvature::is_linear`]
    fn is_constant(&self) -> bool;
}

impl<T: Scalar, S: Curvature<T>> SecondDerivatives<T> for S {
    fn each(&self, q: &[T], p: &[T], put: &mut dyn FnMut(&[Entry<T>])) {
        let mut entries = [(Block::Hqq, 0, 0, T::zero()); ENTRIES];
        let mut count = 0;
        self.curvature(q, p, |block, row, column, value| {
            entries[count] = (block, row, column, value);
            count += 1;
            if count == ENTRIES {
                put(&entries);
                count = 0;
            }
        });
        put(&entries[..count]);
    }

    fn is_constant(&self) -> bool {
        self.is_linear()
    }
}

impl<T: Scalar> Curvature<T> for dyn SecondDerivatives<T> {
    #[inline]
    fn curvature(&self, q: &[T], p: &[T], mut put: impl FnMut(Block, usize, usize, T)) {
        self.each(q, p, &mut |entries| {
            entries.iter().for_each(|&(block, row, column, value)| put(block, row, column, value));
        });
    }

    #[inline]
    fn is_linear(&self) -> bool {
        self.is_constant()
    }
}

/// [`ExactFlow`] with its type erased. Every system with an exact flow implements it.
pub trait Flow<T: Scalar>: System<T> {
    /// [`ExactFlow::flow`]
    fn carry(&self, h: T, state: &mut State<Vec<T>>);
}

impl<T: Scalar, S: ExactFlow<T>> Flow<T> for S {
    fn carry(&self, h: T, state: &mut State<Vec<T>>) {
        self.flow(h, state);
    }
}

/// [`Uniform`] with its type erased. Every chain or ring of equal members implements it.
pub trait Members: Separable<f64> {
    /// [`Uniform::lanes`]
    ///
    /// # Errors
    /// Those of [`Uniform::lanes`].
    fn side_by_side(&self) -> Result<Arc<dyn Separable<f64x8>>, InputError>;

    /// [`Uniform::ends`]
    fn at_ends(&self) -> Option<EndMembers>;
}

impl<S: Uniform> Members for S {
    fn side_by_side(&self) -> Result<Arc<dyn Separable<f64x8>>, InputError> {
        Ok(Arc::new(self.lanes()?))
    }

    fn at_ends(&self) -> Option<EndMembers> {
        self.ends()
    }
}

impl Uniform for dyn Members {
    type Lanes = Arc<dyn Separable<f64x8>>;

    fn lanes(&self) -> Result<Self::Lanes, InputError> {
        self.side_by_side()
    }

    fn ends(&self) -> Option<EndMembers> {
        self.at_ends()
    }
}
