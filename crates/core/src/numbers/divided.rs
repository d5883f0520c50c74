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
//! The values hold to a few roundings for every width, none included, as long as φ itself is a
//! number: m and e are carried with what their roundings leave, because a sine of 1000 or an
//! exponential of 700 feels them. Where e is small a series stands for the quotient by it; where it
//! is not, nothing cancels. The derivatives steer Newton's iteration and are less exact.
//!
//! R. Krawczyk, A. Neumaier, *Interval slopes for rational functions*, SIAM J. Numer. Anal. 22
//! (1985); T. W. Reps, L. B. Rall, *Computational divided differencing*, Higher-Order and Symbolic
//! Computation 16 (2003).

mod arcs;
mod edge;
pub(super) mod elementary;

pub use arcs::{acos, asin};
pub use edge::{by_quadrature, of_potential};
pub use elementary::{abs, atan, cos, cosh, exp, ln, sin, sinh, sinh_cosh, sqrt, tanh};

#[cfg(test)]
mod tests;
