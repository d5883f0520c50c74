//! Explicit Runge-Kutta methods: the tableaus, and the stages of a step.

mod stages;
mod tableau;

pub(crate) use stages::{P, Q, Stages, W};
pub(crate) use tableau::{Classical, Dop853, Embedded, Tableau};
