//! The step sizes δ in the three equations of the scheme.
//!
//! The paper replaces h by δ = h + δ₃h³ + δ₄h⁴ to raise the order. Each δ increases the accuracy of
//! *one* equation. Used in all three equations ("shared") it conserves K; used only in its own
//! equation ("single") it does not. δ has a pole where p = 0 or where V' + D = 0.

use afterbay_core::{Mask, Misprinted, OrderRaising, Scalar, Separable, StepFailure};

/// The step sizes δ in the equations for q, p and w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSizes<T> {
    /// δ(q), in the equation for q.
    pub q: T,
    /// δ(p), in the equation for p.
    pub p: T,
    /// δ(w), in the equation for w.
    pub w: T,
}

impl<T: Copy> StepSizes<T> {
    /// Uses δ in all three equations.
    #[inline(always)]
    fn shared(delta: T) -> Self {
        Self { q: delta, p: delta, w: delta }
    }
}

/// A choice of the step sizes δ.
pub trait Steps<T: Scalar, S: ?Sized> {
    /// Returns δ(q), δ(p) and δ(w) for the step from (q, p).
    ///
    /// # Errors
    /// [`StepFailure::Pole`] where δ is not finite.
    fn sizes(&self, system: &S, h: T, q: T, p: T) -> Result<StepSizes<T>, StepFailure>;
}

/// The plain scheme: δ = h.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plain;

impl<T: Scalar, S: ?Sized> Steps<T, S> for Plain {
    #[inline(always)]
    fn sizes(&self, _system: &S, h: T, _q: T, _p: T) -> Result<StepSizes<T>, StepFailure> {
        Ok(StepSizes::shared(h))
    }
}

/// The equation whose accuracy δ increases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equation {
    /// The equation for q.
    Q,
    /// The equation for p.
    P,
}

/// The equations in which δ replaces h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// δ in all three equations: K is conserved.
    Shared(Equation),
    /// δ in its own equation, h in the other two.
    Single(Equation),
    /// δ(q) in the equation for q, δ(p) in that for p, h in that for w.
    Each,
}

/// The degree at which the series of δ is truncated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Degree {
    /// h + δ₃h³
    Third,
    /// h + δ₃h³ + δ₄h⁴
    Fourth,
}

/// δ derived from the Taylor expansion of the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raised(pub Placement, pub Degree);

/// δ as printed in the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Printed(pub Placement, pub Degree);

impl Placement {
    /// The equations whose δ is used.
    pub(crate) fn equations(self) -> &'static [Equation] {
        match self {
            Self::Shared(Equation::Q) | Self::Single(Equation::Q) => &[Equation::Q],
            Self::Shared(Equation::P) | Self::Single(Equation::P) => &[Equation::P],
            Self::Each => &[Equation::Q, Equation::P],
        }
    }

    #[inline]
    fn distribute<T: Scalar>(
        self,
        h: T,
        delta: impl Fn(Equation) -> Result<T, StepFailure>,
    ) -> Result<StepSizes<T>, StepFailure> {
        Ok(match self {
            Self::Shared(equation) => StepSizes::shared(delta(equation)?),
            Self::Single(Equation::Q) => StepSizes { q: delta(Equation::Q)?, p: h, w: h },
            Self::Single(Equation::P) => StepSizes { q: h, p: delta(Equation::P)?, w: h },
            Self::Each => StepSizes { q: delta(Equation::Q)?, p: delta(Equation::P)?, w: h },
        })
    }
}

impl Equation {
    /// The denominator of δ: p/m for the equation for q, V' + D for the equation for p.
    pub fn denominator<T: Scalar, S: Separable<T> + ?Sized>(self, system: &S, q: T, p: T) -> T {
        match self {
            Self::Q => p / system.mass(0),
            Self::P => system.partial(&[q], 0, q) + system.dissipation_of(&[q], &[p], 0).value,
        }
    }

    #[inline]
    fn check<T: Scalar, S: Separable<T> + ?Sized>(
        self,
        delta: T,
        system: &S,
        q: T,
        p: T,
    ) -> Result<T, StepFailure> {
        if delta.is_finite().all() {
            return Ok(delta);
        }
        Err(StepFailure::Pole { dof: 0, denominator: self.denominator(system, q, p).to_f64() })
    }
}

impl<T: Scalar, S: OrderRaising<T> + ?Sized> Steps<T, S> for Raised {
    #[inline]
    fn sizes(&self, system: &S, h: T, q: T, p: T) -> Result<StepSizes<T>, StepFailure> {
        self.0.distribute(h, |equation| {
            let correction = match equation {
                Equation::Q => system.delta_q(q, p),
                Equation::P => system.delta_p(q, p),
            };
            equation.check(self.1.size(&correction, h), system, q, p)
        })
    }
}

impl<T: Scalar, S: Misprinted<T> + ?Sized> Steps<T, S> for Printed {
    #[inline]
    fn sizes(&self, system: &S, h: T, q: T, p: T) -> Result<StepSizes<T>, StepFailure> {
        self.0.distribute(h, |equation| {
            let correction = match equation {
                Equation::Q => system.printed_delta_q(q, p),
                Equation::P => system.printed_delta_p(q, p),
            };
            equation.check(self.1.size(&correction, h), system, q, p)
        })
    }
}

impl Degree {
    #[inline(always)]
    fn size<T: Scalar>(self, correction: &afterbay_core::Correction<T>, h: T) -> T {
        match self {
            Self::Third => correction.step3(h),
            Self::Fourth => correction.step4(h),
        }
    }
}
