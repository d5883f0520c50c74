//! Whether D is zero or passive, by its form and its parameters. States are not sampled.

use super::structure::linear;
use afterbay_core::{Mask, Passive, Scalar};
use afterbay_expression::{Graph, Input, Kinds, Node, Sign};
use std::collections::BTreeMap;

/// Whether D = 0, by the signs of its entries.
pub(super) fn zero(mut signs: impl Iterator<Item = Sign>) -> bool {
    signs.all(|sign| sign == Sign::Zero)
}

/// Passive in each j if D_j v_j ≥ 0 by signs; in sum if D = R v with R constant and positive
/// semidefinite.
pub(super) fn passive<T: Scalar>(
    mut signs: impl Iterator<Item = Sign>,
    dof: usize,
    matrix: Option<&[(usize, usize, Node)]>,
    at: impl Fn(&Node) -> T,
) -> Passive {
    if signs.all(|sign| matches!(sign, Sign::Zero | Sign::Along)) {
        return Passive::Each;
    }
    if matrix.is_some_and(|matrix| semidefinite(dof, matrix, at)) {
        Passive::InSum
    } else {
        Passive::No
    }
}

/// The sign of each D_j(q, p, v), relative to that of v_j.
pub(super) fn signs<T: Scalar>(
    graph: &Graph,
    dissipations: &[Node],
    at: impl Fn(&Node) -> T,
) -> impl Iterator<Item = Sign> {
    let closed = move |node: Node| {
        let value = at(&node);
        match (T::zero().le(value).all(), value.le(T::zero()).all()) {
            (true, true) => Sign::Zero,
            (true, false) => Sign::NotNegative,
            (false, true) => Sign::NotPositive,
            (false, false) => Sign::Unknown,
        }
    };
    let dissipations = dissipations.iter().enumerate();
    dissipations.map(move |(j, &node)| graph.sign(node, Input::Velocity(j as u32), &closed))
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

/// Whether the symmetric part of R is positive semidefinite to rounding. It is factored as L Δ Lᵀ:
/// no entry of Δ may be negative, and below an entry of 0 the column must be 0.
fn semidefinite<T: Scalar>(
    n: usize,
    entries: &[(usize, usize, Node)],
    at: impl Fn(&Node) -> T,
) -> bool {
    // Rows of the upper triangle, by columns.
    let mut rows: Vec<BTreeMap<usize, T>> = vec![BTreeMap::new(); n];
    for (i, k, node) in entries {
        let half = at(node).half();
        let mut add = |i: usize, k: usize| {
            let entry = rows[i].entry(k).or_insert(T::zero());
            *entry += half;
        };
        if i < k {
            add(*i, *k);
        } else if i > k {
            add(*k, *i);
        } else {
            add(*i, *i);
            add(*i, *i);
        }
    }
    let size = |x: T| x.abs();
    let larger = |a: T, b: T| T::select(a.lt(b), b, a);
    let diagonal =
        |rows: &[BTreeMap<usize, T>], i: usize| rows[i].get(&i).copied().unwrap_or(T::zero());
    let largest = (0..n).fold(T::zero(), |most, i| larger(most, size(diagonal(&rows, i))));
    let rounding = largest * T::from_f64(T::EPSILON * 8.0 * (1.0 + n as f64));
    for i in 0..n {
        let row: Vec<(usize, T)> = rows[i].range(i + 1..).map(|(&k, &x)| (k, x)).collect();
        let pivot = diagonal(&rows, i);
        if !(-rounding).le(pivot).all() {
            return false;
        }
        let gone = pivot.le(rounding);
        if gone.any() {
            // Rounding makes a column beside a zero of Δ as large as the square root of the
            // rounding.
            let small = |x: T| (x * x).le(rounding * largest);
            if !gone.all() || !row.iter().all(|&(_, x)| small(x).all()) {
                return false;
            }
            continue;
        }
        for (a, &(k, x)) in row.iter().enumerate() {
            for &(l, y) in &row[a..] {
                let entry = rows[k].entry(l).or_insert(T::zero());
                *entry -= x * y / pivot;
            }
        }
    }
    true
}
