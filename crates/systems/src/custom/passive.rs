//! Whether D is zero or passive, by its form and its parameters. States are not sampled.

use super::structure::linear;
use afterbay_core::{Mask, Passive, Scalar};
use afterbay_expression::{Graph, Input, Kinds, Node, Sign};
use std::collections::BTreeMap;

/// The sign of a number in all of its lanes.
pub(super) fn sign<T: Scalar>(x: T) -> Sign {
    match (T::zero().le(x).all(), x.le(T::zero()).all()) {
        (true, true) => Sign::Zero,
        (true, false) => Sign::NotNegative,
        (false, true) => Sign::NotPositive,
        (false, false) => Sign::Unknown,
    }
}

/// The sign of each D_j(q, p, v), relative to that of v_j. `closed` gives the signs of closed
/// nodes.
pub(super) fn signs(
    graph: &Graph,
    dissipations: &[Node],
    closed: &dyn Fn(Node) -> Sign,
) -> Vec<Sign> {
    let dissipations = (0..).zip(dissipations);
    dissipations.map(|(j, &node)| graph.sign(node, Input::Velocity(j), closed)).collect()
}

/// Whether D = 0, by the signs of its entries.
pub(super) fn zero(signs: &[Sign]) -> bool {
    signs.iter().all(|&sign| sign == Sign::Zero)
}

/// Passive in each j if D_j v_j ≥ 0 by signs; in sum if D = R v with R constant and positive
/// semidefinite.
pub(super) fn passive<T: Scalar>(
    signs: &[Sign],
    dof: usize,
    matrix: Option<&[(usize, usize, Node)]>,
    at: impl Fn(&Node) -> T,
) -> Passive {
    if signs.iter().all(|sign| matches!(sign, Sign::Zero | Sign::Along)) {
        return Passive::Each;
    }
    let in_lane = |matrix: &[(usize, usize, Node)], lane: usize| {
        let entries = matrix.iter().map(|(i, k, node)| (*i, *k, at(node).lane(lane)));
        semidefinite(dof, &entries.collect::<Vec<_>>())
    };
    if matrix.is_some_and(|matrix| (0..T::LANES).all(|lane| in_lane(matrix, lane))) {
        Passive::InSum
    } else {
        Passive::No
    }
}

/// R, if D = R v with R made of parameters.
pub(super) fn matrix(
    graph: &mut Graph,
    dissipations: &[Node],
) -> Option<Vec<(usize, usize, Node)>> {
    let mut matrix = Vec::new();
    for (i, &dissipation) in dissipations.iter().enumerate() {
        if !linear(graph, dissipation, Kinds::VELOCITIES) {
            return None;
        }
        let by = graph.inputs(dissipation, Kinds::VELOCITIES);
        let row = graph.gradient(dissipation, Kinds::VELOCITIES, &by);
        for (input, node) in by.into_iter().zip(row) {
            match input {
                Input::Velocity(k) if graph.closed(node) => matrix.push((i, k as usize, node)),
                _ => return None,
            }
        }
    }
    Some(matrix)
}

/// Whether the symmetric part of R is positive semidefinite to rounding, in any units. It is scaled
/// to ones on the diagonal and factored as L Δ Lᵀ: no entry of Δ may be negative, and below an
/// entry of 0 the column must be 0.
fn semidefinite(n: usize, entries: &[(usize, usize, f64)]) -> bool {
    let Some(mut rows) = scaled(n, entries) else { return false };
    let rounding = 4.0 * f64::EPSILON * (1.0 + n as f64);
    for i in 0..n {
        let row: Vec<(usize, f64)> = rows[i].range(i + 1..).map(|(&k, &x)| (k, x)).collect();
        let pivot = rows[i].get(&i).copied().unwrap_or(0.0);
        if pivot.is_nan() || pivot < -rounding {
            return false;
        }
        if pivot <= rounding {
            // Rounding makes a column beside a zero of Δ as large as the square root of the
            // rounding.
            if !row.iter().all(|&(_, x)| x * x <= rounding) {
                return false;
            }
            continue;
        }
        for (a, &(k, x)) in row.iter().enumerate() {
            for &(l, y) in &row[a..] {
                *rows[k].entry(l).or_default() -= x * y / pivot;
            }
        }
    }
    true
}

/// The upper triangle of the symmetric part of R, by rows, with the entries divided by the roots of
/// their diagonal entries. `None` where a diagonal entry is negative, or 0 beside an entry that is
/// not: then R is not positive semidefinite.
fn scaled(n: usize, entries: &[(usize, usize, f64)]) -> Option<Vec<BTreeMap<usize, f64>>> {
    let mut rows: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); n];
    for &(i, k, x) in entries {
        let share = if i == k { x } else { 0.5 * x };
        *rows[i.min(k)].entry(i.max(k)).or_default() += share;
    }
    let roots: Vec<f64> =
        (0..n).map(|i| rows[i].get(&i).map_or(0.0, |diagonal| diagonal.sqrt())).collect();
    for (i, row) in rows.iter_mut().enumerate() {
        for (&k, x) in row.iter_mut().filter(|(_, x)| **x != 0.0) {
            *x = *x / roots[i] / roots[k];
            if !x.is_finite() {
                return None;
            }
        }
    }
    Some(rows)
}
