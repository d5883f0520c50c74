//! Divided differences φ[a, b] = (φ(b) - φ(a))/(b - a) of functions of one number, without
//! cancellation, with their derivatives by b.
//!
//! With the middle m = (a + b)/2, the half width e = (b - a)/2 and d = b - a:
//!
//! ```text
//! exp   e^m sinh(e)/e                          sin   cos(m) sin(e)/e
//! sinh  cosh(m) sinh(e)/e                      cos   -sin(m) sin(e)/e
//! cosh  sinh(m) sinh(e)/e                      ln    2 artanh(d/(a+b)) / d
//! √     1/(√a + √b)                            |·|   (a + b)/(|a| + |b|)
//! tanh  sinh(d)/(d cosh(a) cosh(b))            atan  atan(d/(1 + ab))/d, where 1 + ab > 0
//! ```
//!
//! The values are accurate to a few roundings for every width, 0 included, as long as φ itself is
//! finite. The rounding errors of m and e are carried along, because sin 1000 and exp 700 magnify
//! them. If e is small, a series replaces the quotient by e; otherwise nothing cancels. The
//! derivatives are for Newton's method and less accurate.
//!
//! [`of_potential`] and [`by_quadrature`] give the divided difference of a whole potential over an
//! edge.
//!
//! R. Krawczyk, A. Neumaier, *Interval slopes for rational functions*, SIAM J. Numer. Anal. 22
//! (1985); T. W. Reps, L. B. Rall, *Computational divided differencing*, Higher-Order and Symbolic
//! Computation 16 (2003).

mod arcs;
mod edge;
pub(super) mod elementary;

pub use arcs::{acos, asin};
pub use edge::{by_quadrature, of_potential};
pub use elementary::{abs, atan, cos, cosh, exp, ln, sin, sinh, sqrt, tanh};

#[cfg(test)]
mod tests;
