//! Verner's most efficient pairs of orders 9(8) and 8(7) with step size control, and K exact
//! after every step.
//!
//! J. H. Verner, Numerically optimal Runge-Kutta pairs with interpolants, Numer. Algorithms 53
//! (2010) 383-396, with the coefficients of his web page. The step, its error control and the
//! projection onto K are those of [`crate::adaptive_explicit`].
//!
//! | method | evaluations | order of q, p and w | half disc of the stability region |
//! |---|---|---|---|
//! | [`AdaptiveVerner98`] | 16 | 9 | 2.7 |
//! | [`AdaptiveVerner87`] | 13 | 8 | 2.5 |
//!
//! In the half disc of 8(7), |R| exceeds 1 by up to 1e-5 near the imaginary axis. The orders hold
//! between steps, too. Some weights are negative, so the methods are not passive.
//!
//! A run **fails** with the last accepted state, and reports the
//! [`StepFailure`](afterbay_core::StepFailure) of the shortest step tried, or `Vanishes`.

use crate::adaptive_explicit::adaptive_explicit;
use crate::runge_kutta::{Verner87, Verner98};

/// The pair of orders 9 and 8, for tight tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveVerner98;

/// The pair of orders 8 and 7, for moderate tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AdaptiveVerner87;

adaptive_explicit!(AdaptiveVerner98, Verner98);
adaptive_explicit!(AdaptiveVerner87, Verner87);
