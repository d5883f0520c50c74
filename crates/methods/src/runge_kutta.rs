//! Explicit Runge-Kutta methods: the tableaus, and the stages of a step.

mod dop853;
mod stages;
mod tableau;
mod verner87;
mod verner98;

pub(crate) use dop853::Dop853;
pub(crate) use stages::{P, Q, Stages, W};
pub(crate) use tableau::{Classical, Embedded, Tableau, Terms};
pub(crate) use verner87::Verner87;
pub(crate) use verner98::Verner98;
