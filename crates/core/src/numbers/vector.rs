//! Storage of N numbers: on the stack where N is known to the compiler, on the heap where it is
//! not.

use super::scalar::Scalar;
use nalgebra::{DVector, SVector};

/// Storage of N scalars. Kernels are written once on slices. A constant [`Vector::LEN`] lets the
/// compiler unroll their loops and, for N = 1, remove them.
pub trait Vector: Clone + Send + Sync {
    /// The type of the numbers.
    type Scalar: Scalar;

    /// This kind of storage with other scalars.
    type Of<U: Scalar>: Vector<Scalar = U>;

    /// The length, if the type fixes it.
    const LEN: Option<usize>;

    /// `len` zeros, or as many as the type fixes.
    fn zeros(len: usize) -> Self;

    /// f of each entry of `from`, up to the number of entries that the type can hold.
    #[inline(always)]
    fn filled<U: Copy>(from: &[U], f: impl Fn(U) -> Self::Scalar) -> Self {
        let mut vector = Self::zeros(from.len());
        vector.as_mut_slice().iter_mut().zip(from).for_each(|(x, &from)| *x = f(from));
        vector
    }

    /// Overwrites the numbers with those of `from`, one at a time.
    ///
    /// The compiler turns `copy_from_slice` into a copy of integers. In some time loops it then
    /// kept the numbers in integer registers and moved them to floating-point registers in every
    /// step. Leapfrog with one degree of freedom took up to 1.3 times as long.
    ///
    /// # Panics
    /// If `from` holds fewer numbers, or more where the type does not fix the length.
    #[expect(clippy::manual_memcpy, reason = "a copy of integers, as described above")]
    #[inline(always)]
    fn assign(&mut self, from: &[Self::Scalar]) {
        let to = self.as_mut_slice();
        let n = Self::LEN.unwrap_or(to.len().max(from.len()));
        let (to, from) = (&mut to[..n], &from[..n]);
        for j in 0..n {
            to[j] = from[j];
        }
    }

    /// A copy, by [`Vector::assign`] if the type fixes the length.
    #[inline(always)]
    fn copied(&self) -> Self {
        if Self::LEN.is_none() {
            return self.clone();
        }
        let mut copy = Self::zeros(0);
        copy.assign(self.as_slice());
        copy
    }

    /// The numbers.
    fn as_slice(&self) -> &[Self::Scalar];

    /// The numbers, mutable.
    fn as_mut_slice(&mut self) -> &mut [Self::Scalar];
}

impl<T: Scalar, const N: usize> Vector for [T; N] {
    type Scalar = T;
    type Of<U: Scalar> = [U; N];
    const LEN: Option<usize> = Some(N);

    #[inline(always)]
    fn zeros(_len: usize) -> Self {
        [T::zero(); N]
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self
    }
}

/// A single number. The compiler passes an array of one number through integer registers where it
/// is copied, which takes longer than the rest of a cheap step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single<T>(pub T);

impl<T: Scalar> Vector for Single<T> {
    type Scalar = T;
    type Of<U: Scalar> = Single<U>;
    const LEN: Option<usize> = Some(1);

    #[inline(always)]
    fn zeros(_len: usize) -> Self {
        Self(T::zero())
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        std::slice::from_ref(&self.0)
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        std::slice::from_mut(&mut self.0)
    }
}

impl<T: Scalar, const N: usize> Vector for SVector<T, N> {
    type Scalar = T;
    type Of<U: Scalar> = SVector<U, N>;
    const LEN: Option<usize> = Some(N);

    #[inline(always)]
    fn zeros(_len: usize) -> Self {
        Self::from_element(T::zero())
    }
    // The inner array: the compiler does not know the length of nalgebra's own slice (13 % at N =
    // 1).
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        &self.data.0[0]
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.data.0[0]
    }
}

impl<T: Scalar> Vector for Vec<T> {
    type Scalar = T;
    type Of<U: Scalar> = Vec<U>;
    const LEN: Option<usize> = None;

    fn zeros(len: usize) -> Self {
        vec![T::zero(); len]
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self
    }
}

impl<T: Scalar> Vector for DVector<T> {
    type Scalar = T;
    type Of<U: Scalar> = DVector<U>;
    const LEN: Option<usize> = None;

    fn zeros(len: usize) -> Self {
        Self::from_element(len, T::zero())
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self.data.as_slice()
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self.data.as_mut_slice()
    }
}
