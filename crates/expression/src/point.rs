//! Points at which a program runs.

use crate::function::Function;
use crate::graph::Input;
use afterbay_core::{Line, Scalar};
use std::array::from_fn;

/// The inputs of a run. Parts that a program does not read may be empty.
#[derive(Clone, Copy)]
pub struct Point<'a, T> {
    /// Coordinates.
    pub q: &'a [T],
    /// Momenta.
    pub p: &'a [T],
    /// Velocities.
    pub v: &'a [T],
    /// The end of an edge, or the value of the coordinate that [`Program::moving`] replaced.
    ///
    /// [`Program::moving`]: crate::Program::moving
    pub end: T,
    /// q_j and p_j of the degree of freedom of [`Program::in_plane`].
    ///
    /// [`Program::in_plane`]: crate::Program::in_plane
    pub own: [T; 2],
}

impl<'a, T: Scalar> Point<'a, T> {
    /// Coordinates, momenta and velocities.
    pub fn new(q: &'a [T], p: &'a [T], v: &'a [T]) -> Self {
        Self { q, p, v, end: T::zero(), own: [T::zero(); 2] }
    }
}

/// One point, or several at which each instruction is carried out together.
pub(super) trait Points<T> {
    /// A number at each point.
    type Value: Copy;

    /// Returns the value that is x at every point.
    fn equal(x: T) -> Self::Value;

    /// The input at each point.
    fn read(&self, input: Input) -> Self::Value;

    /// f(x) at each point.
    fn map<const K: usize>(x: [Self::Value; K], f: impl Fn([T; K]) -> T) -> Self::Value;

    /// φ\[a, b\] and its derivative by b at each point.
    fn divided(function: Function, a: Self::Value, b: Self::Value) -> Line<Self::Value>;
}

impl<T: Scalar> Points<T> for Point<'_, T> {
    type Value = T;

    #[inline(always)]
    fn equal(x: T) -> T {
        x
    }

    #[inline(always)]
    fn read(&self, input: Input) -> T {
        match input {
            Input::Coordinate(j) => self.q[j as usize],
            Input::Momentum(j) => self.p[j as usize],
            Input::Velocity(j) => self.v[j as usize],
            Input::End => self.end,
            Input::OwnCoordinate => self.own[0],
            Input::OwnMomentum => self.own[1],
        }
    }

    #[inline(always)]
    fn map<const K: usize>(x: [T; K], f: impl Fn([T; K]) -> T) -> T {
        f(x)
    }

    #[inline(always)]
    fn divided(function: Function, a: T, b: T) -> Line<T> {
        function.divided(a, b)
    }
}

impl<T: Scalar, const P: usize> Points<T> for [Point<'_, T>; P] {
    type Value = [T; P];

    #[inline(always)]
    fn equal(x: T) -> [T; P] {
        [x; P]
    }

    #[inline(always)]
    fn read(&self, input: Input) -> [T; P] {
        from_fn(|i| self[i].read(input))
    }

    #[inline(always)]
    fn map<const K: usize>(x: [[T; P]; K], f: impl Fn([T; K]) -> T) -> [T; P] {
        let mut values = [T::zero(); P];
        let mut arguments = [T::zero(); K];
        for i in 0..P {
            for k in 0..K {
                arguments[k] = x[k][i];
            }
            values[i] = f(arguments);
        }
        values
    }

    #[inline(always)]
    fn divided(function: Function, a: [T; P], b: [T; P]) -> Line<[T; P]> {
        let lines: [Line<T>; P] = from_fn(|i| function.divided(a[i], b[i]));
        Line { value: lines.map(|line| line.value), slope: lines.map(|line| line.slope) }
    }
}
