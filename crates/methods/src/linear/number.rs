//! The entries of a matrix: real or complex numbers.

use super::{LinearSolver, Solver, matrix};
use afterbay_core::InputError;
use faer::c64;
use faer::traits::ComplexField;
use std::ops::{AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// An entry of a matrix.
pub(crate) trait Number:
    ComplexField
    + Copy
    + Neg<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + 'static
{
    /// 0
    const ZERO: Self;

    /// `x`
    fn real(x: f64) -> Self;

    /// `x · self`
    fn scaled(self, x: f64) -> Self;

    /// `self · a + b`, with a single rounding for real numbers.
    fn fused(self, a: Self, b: Self) -> Self;

    /// |x|, or for complex numbers |Re x| + |Im x|; used to compare pivots.
    fn size(self) -> f64;

    /// 1 / self
    fn inverse(self) -> Self;

    /// A matrix of these numbers, with entries at `pattern` and on the diagonal.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if a sparse matrix does not fit in memory.
    fn matrix(
        solver: LinearSolver,
        size: usize,
        pattern: Vec<(usize, usize)>,
    ) -> Result<Box<dyn Solver<Self>>, InputError>;
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    #[inline(always)]
    fn real(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn scaled(self, x: f64) -> Self {
        self * x
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    #[inline(always)]
    fn size(self) -> f64 {
        self.abs()
    }
    #[inline(always)]
    fn inverse(self) -> Self {
        1.0 / self
    }

    #[inline(never)]
    fn matrix(
        solver: LinearSolver,
        size: usize,
        pattern: Vec<(usize, usize)>,
    ) -> Result<Box<dyn Solver<Self>>, InputError> {
        matrix(solver, size, pattern)
    }
}

impl Number for c64 {
    const ZERO: Self = Self { re: 0.0, im: 0.0 };

    #[inline(always)]
    fn real(x: f64) -> Self {
        Self { re: x, im: 0.0 }
    }
    #[inline(always)]
    fn scaled(self, x: f64) -> Self {
        Self { re: self.re * x, im: self.im * x }
    }
    #[inline(always)]
    fn fused(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    #[inline(always)]
    fn size(self) -> f64 {
        self.re.abs() + self.im.abs()
    }
    // Scaled by the larger part, to prevent overflow of the squares.
    #[inline(always)]
    fn inverse(self) -> Self {
        let Self { re, im } = self;
        if re.abs() >= im.abs() {
            let share = im / re;
            let scale = 1.0 / im.mul_add(share, re);
            Self { re: scale, im: -share * scale }
        } else {
            let share = re / im;
            let scale = 1.0 / re.mul_add(share, im);
            Self { re: share * scale, im: -scale }
        }
    }
    #[inline(never)]
    fn matrix(
        solver: LinearSolver,
        size: usize,
        pattern: Vec<(usize, usize)>,
    ) -> Result<Box<dyn Solver<Self>>, InputError> {
        matrix(solver, size, pattern)
    }
}
