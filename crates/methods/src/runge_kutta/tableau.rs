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

/// A method with one or two embedded methods of lower order, for its error estimate.
pub(crate) trait Embedded: Tableau {
    /// b_i minus the weights of each embedded method, the more accurate one first.
    const DIFFERENCES: &'static [Terms];
    /// The power of h with which the error estimate grows.
    const ERROR_ORDER: u32;
    /// The bound imposed on h |λ|, within the half disc |hλ| ≤ r, Re λ ≤ 0 of the stability region.
    const STABLE_RADIUS: f64;
    /// Whether the last stage is the end of the step, so that its slope is the first of the next.
    const ENDS_AT_STAGE: bool;
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

    #[test]
    fn order_conditions_hold_to_rounding_in_both_scalars_and_not_beyond() {
        let trees = trees(9);
        assert_eq!(
            trees.iter().map(Vec::len).collect::<Vec<_>>(),
            [1, 1, 2, 4, 9, 20, 48, 115, 286]
        );
        for (rows, weights, order) in
            [(Classical::ROWS, Classical::WEIGHTS, 4), (Dop853::ROWS, Dop853::WEIGHTS, 8)]
        {
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

    #[test]
    fn what_tells_the_error_has_order_5_and_3() {
        let trees = trees(6);
        for (differences, order) in Dop853::DIFFERENCES.into_iter().zip([5, 3]) {
            let mut weights: Vec<_> = (0..Dop853::ROWS.len()).map(|i| (i, [0.0; 2])).collect();
            for &(i, [b, _]) in Dop853::WEIGHTS {
                weights[i].1[0] += b;
            }
            for &(i, [difference, _]) in differences {
                weights[i].1[0] -= difference;
            }
            let missed = |tree: &Tree| miss::<f64>(Dop853::ROWS, &weights, tree);
            for tree in trees[..order].iter().flatten() {
                assert!(missed(tree) < 16.0, "{tree:?} is missed by {} roundings", missed(tree));
            }
            assert!(trees[order].iter().any(|tree| missed(tree) > 1e10));
        }
    }

    /// |R(z)| for z = r e^{iφ}, R(z) = 1 + Σ_k z^{k+1} bᵀ Aᵏ 1.
    fn amplification(r: f64, angle: f64) -> f64 {
        let mut column = vec![1.0; Dop853::ROWS.len()];
        let (mut sum, mut power) = ([1.0, 0.0], 1.0);
        for k in 1..=Dop853::ROWS.len() {
            power *= r;
            let term =
                power * Dop853::WEIGHTS.iter().map(|&(i, [b, _])| b * column[i]).sum::<f64>();
            let (sin, cos) = (k as f64 * angle).sin_cos();
            sum = [sum[0] + term * cos, sum[1] + term * sin];
            let row = |row: &Terms| row.iter().map(|&(j, [a, _])| a * column[j]).sum();
            column = Dop853::ROWS.iter().map(row).collect();
        }
        sum[0].hypot(sum[1])
    }

    #[test]
    fn dop853_is_stable_in_the_half_disc_of_radius_5_96() {
        let angles =
            (0..=90).map(|degrees| std::f64::consts::PI * (0.5 + f64::from(degrees) / 180.0));
        for (angle, r) in
            angles.flat_map(|angle| (1..=596).map(move |i| (angle, 0.01 * f64::from(i))))
        {
            let found = amplification(r, angle);
            assert!(found <= 1.0 + 1e-12, "|R| = {found} at |z| = {r}, angle {angle}");
        }
        assert!(amplification(5.98, std::f64::consts::FRAC_PI_2) > 1.01);
    }
}
