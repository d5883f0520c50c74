//! Beyond the paper: N degrees of freedom, on a chain, a ring and a double pendulum.

mod energy_balance;
mod long_run;
mod orders;
mod size;
mod work;

use super::{Extent, Paper, Part};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::Model;
use afterbay_analysis::study::{MOST_DEGREES_IN_QUAD, Problem};
use afterbay_systems::{DAMPED_DOUBLE_PENDULUM, FPUT_CHAIN, VAN_DER_POL_RING};
use std::f64::consts::PI;

pub(super) const PART: Part = Part {
    heading: "Beyond the paper: N degrees of freedom",
    methods: &[
        &orders::SEPARABLE,
        &orders::ANY,
        &energy_balance::FOLLOWED,
        &energy_balance::OF_ONE_DEGREE,
        &size::COMPARED,
        &size::TIMED,
    ],
    sheet,
};

fn sheet(paper: &Paper<'_>, mut sheet: Sheet) -> Result<Sheet, ReportError> {
    sheet.text(format!(
        "The paper leaves N > 1 open. Here each degree of freedom has a reservoir w_j of its own, \
         and K = H + Σ w_j. Three systems: a damped FPUT-β chain (β = 1, c = 0.01) that starts \
         from rest as a sine with the strain 1 at its ends; a ring of five Van der Pol oscillators \
         (μ = 1, κ = 0.5), which is active; and a double pendulum with friction (m = l = g = 1, c \
         = 0.1), whose H is not separable. Errors are the largest over the degrees of freedom. The \
         reference is a Taylor series, in 106 bits up to {MOST_DEGREES_IN_QUAD} degrees of freedom \
         and in 53 beyond, or a run whose step was halved until two runs agree, where a series \
         takes too many strides. Its doubt stands in each table.",
    ));
    orders::add(paper, &mut sheet)?;
    energy_balance::add(paper, &mut sheet)?;
    long_run::add(paper, &mut sheet)?;
    work::add(paper, &mut sheet)?;
    size::add(paper, &mut sheet)?;
    Ok(sheet)
}

/// The problems that depend on the extent only, for the manifest.
pub(super) fn problems(extent: Extent) -> Vec<(&'static str, Problem)> {
    let end = orders::end(extent);
    let mut problems = vec![
        ("fput-chain", chain(orders::masses(extent), end)),
        ("van-der-pol-ring", ring(end)),
        ("damped-double-pendulum", pendulum(end)),
        ("fput-chain-work", work::long_chain(extent)),
        ("damped-double-pendulum-work", work::long_pendulum(extent)),
    ];
    problems
        .extend(long_run::starts(extent).into_iter().map(|start| ("fput-chain-long-run", start)));
    problems
}

/// The chain of n masses that starts from rest as a sine, q_j = (n+1)/π sin(π j/(n+1)). The strain
/// at the walls is 1, and the energy per degree of freedom is the same for every n.
fn chain(n: usize, end: f64) -> Problem {
    let length = (n + 1) as f64;
    let q = (1..=n).map(|j| length / PI * (PI * j as f64 / length).sin()).collect();
    Problem { model: Model::of(&FPUT_CHAIN, &[n as f64, 1.0, 0.01]), q, p: vec![0.0; n], end }
}

/// The chain of n masses that starts from rest with the same wave for every n, q_j = sin(π j/4).
fn wave(n: usize, end: f64) -> Problem {
    Problem { q: (1..=n).map(|j| (PI * j as f64 / 4.0).sin()).collect(), ..chain(n, end) }
}

/// Five oscillators that start with different phases.
fn ring(end: f64) -> Problem {
    let model = Model::of(&VAN_DER_POL_RING, &[5.0, 1.0, 0.5]);
    Problem { model, q: vec![2.0, -1.0, 0.5, 1.5, -0.5], p: vec![0.5, 1.0, -1.5, 0.0, 0.25], end }
}

/// A pendulum released from rest, with both rods far from the vertical.
fn pendulum(end: f64) -> Problem {
    let model = Model::of(&DAMPED_DOUBLE_PENDULUM, &[1.0, 1.0, 1.0, 1.0, 1.0, 0.1, 0.1]);
    Problem { model, q: vec![1.5, -0.5], p: vec![0.0; 2], end }
}
