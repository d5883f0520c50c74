//! Butcher tableaus, with each coefficient stored as the sum of two doubles.

use afterbay_core::Scalar;

/// The nonzero coefficients of a sum, with the index of their stage.
pub(crate) type Terms = &'static [(usize, [f64; 2])];

/// An explicit Runge-Kutta method with coefficients known at compile time.
pub(crate) trait Tableau {
    /// a_ij, row by row; the first row is empty.
    const ROWS: &'static [Terms];
    /// b_i
    const WEIGHTS: Terms;
}

/// The sum of the absolute coefficients.
const fn size(terms: Terms) -> f64 {
    let (mut sum, mut i) = (0.0, 0);
    while i < terms.len() {
        sum += terms[i].1[0].abs();
        i += 1;
    }
    sum
}

/// A method with one or two embedded methods of lower order, for its error estimate.
pub(crate) trait Embedded: Tableau {
    /// b_i minus the weights of each embedded method, the more accurate one first.
    const DIFFERENCES: &'static [Terms];
    /// b_i minus the weights of a method that sees kinks, of which those above see too little.
    const DIFFERENCES_AT_KINKS: Option<Terms> = None;
    /// The rounding error of the error estimate, in roundings of the slopes times h.
    const ESTIMATE_ROUNDINGS: f64 = size(Self::DIFFERENCES[0]);
    /// The power of h with which the error estimate grows.
    const ERROR_ORDER: u32;
    /// The bound imposed on h |λ|, within the half disc |hλ| ≤ r, Re λ ≤ 0 of the stability region.
    const STABLE_RADIUS: f64;
}

/// Converts a coefficient to the scalar type.
#[inline(always)]
pub(crate) fn number<T: Scalar>([high, low]: [f64; 2]) -> T {
    T::from_f64(high) + T::from_f64(low)
}

/// The classical Runge-Kutta method, order 4.
pub(crate) struct Classical;

impl Tableau for Classical {
    const ROWS: &'static [Terms] =
        &[&[], &[(0, [0.5, 0.0])], &[(1, [0.5, 0.0])], &[(2, [1.0, 0.0])]];
    const WEIGHTS: Terms = &[(0, SIXTH), (1, THIRD), (2, THIRD), (3, SIXTH)];
}

const SIXTH: [f64; 2] = [1.0 / 6.0, 9.25185853854297e-18];
const THIRD: [f64; 2] = [1.0 / 3.0, 1.850371707708594e-17];

#[cfg(test)]
mod tests {
    use super::super::{Dop853, Verner87, Verner98};
    use super::*;
    use afterbay_core::{Quad, Scalar};

    /// A rooted tree, as the list of the subtrees of its root.
    #[derive(Clone, Debug, PartialEq)]
    struct Tree(Vec<Tree>);

    impl Tree {
        fn order(&self) -> usize {
            1 + self.0.iter().map(Self::order).sum::<usize>()
        }

        /// γ(t)
        fn density(&self) -> f64 {
            self.0.iter().map(Self::density).product::<f64>() * self.order() as f64
        }

        /// Φ(t) of each stage, and the largest of its terms.
        fn weights<T: Scalar>(&self, rows: &[Terms]) -> Vec<[T; 2]> {
            let mut all = vec![[T::one(); 2]; rows.len()];
            for branch in &self.0 {
                let below = branch.weights::<T>(rows);
                for (all, row) in all.iter_mut().zip(rows) {
                    let mut sums = [T::zero(); 2];
                    for &(j, a) in *row {
                        let a: T = number(a);
                        sums = [
                            a.mul_add(below[j][0], sums[0]),
                            a.abs().mul_add(below[j][1], sums[1]),
                        ];
                    }
                    *all = [all[0] * sums[0], all[1] * sums[1]];
                }
            }
            all
        }
    }

    /// The rooted trees by order, from 1: each grafts a branch onto the root of a smaller tree, in
    /// every way.
    fn trees(order: usize) -> Vec<Vec<Tree>> {
        let mut all = vec![vec![Tree(vec![])]];
        while all.len() < order {
            let mut found: Vec<Tree> = Vec::new();
            for (i, rest) in all.iter().enumerate() {
                for (branch, Tree(rest)) in
                    all[all.len() - 1 - i].iter().flat_map(|b| rest.iter().map(move |r| (b, r)))
                {
                    let mut branches = rest.clone();
                    branches.push(branch.clone());
                    branches.sort_by_key(|branch| format!("{branch:?}"));
                    let tree = Tree(branches);
                    if !found.contains(&tree) {
                        found.push(tree);
                    }
                }
            }
            all.push(found);
        }
        all
    }

    /// The error of the order condition of a tree, in unit roundoffs of the terms of its sum.
    fn miss<T: Scalar>(rows: &[Terms], weights: &[(usize, [f64; 2])], tree: &Tree) -> f64 {
        let (mut sum, mut terms) = (-(T::from_f64(tree.density()).recip()), 0.0);
        let phi = tree.weights::<T>(rows);
        for &(i, weight) in weights {
            let weight: T = number(weight);
            sum = weight.mul_add(phi[i][0], sum);
            terms += (weight.abs() * phi[i][1]).to_f64();
        }
        sum.to_f64().abs() / (T::EPSILON * terms)
    }

    /// Rows, weights and order of each method.
    fn methods() -> [(&'static [Terms], Terms, usize); 4] {
        fn of<B: Tableau>(order: usize) -> (&'static [Terms], Terms, usize) {
            (B::ROWS, B::WEIGHTS, order)
        }
        [of::<Classical>(4), of::<Dop853>(8), of::<Verner87>(8), of::<Verner98>(9)]
    }

    #[test]
    fn order_conditions_hold_to_rounding_in_both_scalars_and_not_beyond() {
        let trees = trees(10);
        assert_eq!(
            trees.iter().map(Vec::len).collect::<Vec<_>>(),
            [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]
        );
        for (rows, weights, order) in methods() {
            for tree in trees[..order].iter().flatten() {
                let found = [miss::<f64>(rows, weights, tree), miss::<Quad>(rows, weights, tree)];
                assert!(
                    found.iter().all(|&miss| miss < 16.0),
                    "{tree:?} is missed by {found:?} roundings"
                );
            }
            assert!(trees[order].iter().any(|tree| miss::<Quad>(rows, weights, tree) > 1e20));
        }
    }

    /// The order of each embedded method is `orders`, and not more.
    fn check_embedded<B: Embedded>(orders: &[usize], trees: &[Vec<Tree>]) {
        let all: Vec<_> = B::DIFFERENCES.iter().copied().chain(B::DIFFERENCES_AT_KINKS).collect();
        assert_eq!(all.len(), orders.len());
        for (differences, &order) in all.into_iter().zip(orders) {
            let mut weights: Vec<_> = (0..B::ROWS.len()).map(|i| (i, [0.0; 2])).collect();
            for &(i, [b, _]) in B::WEIGHTS {
                weights[i].1[0] += b;
            }
            for &(i, [difference, _]) in differences {
                weights[i].1[0] -= difference;
            }
            let missed = |tree: &Tree| miss::<f64>(B::ROWS, &weights, tree);
            for tree in trees[..order].iter().flatten() {
                assert!(missed(tree) < 16.0, "{tree:?} is missed by {} roundings", missed(tree));
            }
            assert!(trees[order].iter().any(|tree| missed(tree) > 1e6));
        }
    }

    #[test]
    fn embedded_methods_have_their_order() {
        let trees = trees(9);
        check_embedded::<Dop853>(&[5, 3], &trees);
        check_embedded::<Verner87>(&[7, 5], &trees);
        check_embedded::<Verner98>(&[8], &trees);
    }

    /// |R(z)| for z = r e^{iφ}, R(z) = 1 + Σ_k z^{k+1} bᵀ Aᵏ 1.
    fn amplification<B: Tableau>(r: f64, angle: f64) -> f64 {
        let mut column = vec![1.0; B::ROWS.len()];
        let (mut sum, mut power) = ([1.0, 0.0], 1.0);
        for k in 1..=B::ROWS.len() {
            power *= r;
            let term = power * B::WEIGHTS.iter().map(|&(i, [b, _])| b * column[i]).sum::<f64>();
            let (sin, cos) = (k as f64 * angle).sin_cos();
            sum = [sum[0] + term * cos, sum[1] + term * sin];
            let row = |row: &Terms| row.iter().map(|&(j, [a, _])| a * column[j]).sum();
            column = B::ROWS.iter().map(row).collect();
        }
        sum[0].hypot(sum[1])
    }

    /// |R| ≤ 1 + `growth` in the half disc of radius `inner`, which contains that of the steps, and
    /// not in the one of radius `outer`.
    fn check_half_disc<B: Embedded>(growth: f64, inner: f64, outer: f64) {
        let angles =
            || (0..=90).map(|degrees| std::f64::consts::PI * (0.5 + f64::from(degrees) / 180.0));
        assert!(B::STABLE_RADIUS <= inner);
        for (angle, part) in
            angles().flat_map(|angle| (1..=500).map(move |i| (angle, f64::from(i) / 500.0)))
        {
            let found = amplification::<B>(part * inner, angle);
            assert!(found <= 1.0 + growth, "|R| = {found} at |z| = {}, {angle}", part * inner);
        }
        assert!(angles().any(|angle| amplification::<B>(outer, angle) > 1.0 + 10.0 * growth));
    }

    #[test]
    fn steps_are_stable_in_their_half_disc() {
        check_half_disc::<Dop853>(1e-12, 5.96, 5.98);
        check_half_disc::<Verner98>(1e-12, 2.74, 2.78);
        // |R| exceeds 1 near the imaginary axis, by little.
        check_half_disc::<Verner87>(1e-5, 2.5, 3.0);
    }
}
