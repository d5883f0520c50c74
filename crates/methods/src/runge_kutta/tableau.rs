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

/// A method with two embedded methods of lower order for its error estimate.
pub(crate) trait Embedded: Tableau {
    /// b_i minus the weights of the embedded methods, the more accurate one first.
    const DIFFERENCES: [Terms; 2];
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

/// DOP853, order 8: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
/// second edition, section II.5. The 30 published digits are corrected by up to 4e-29 to satisfy
/// the order conditions (`tests/data/dop853.py` prints them).
pub(crate) struct Dop853;

impl Tableau for Dop853 {
    const ROWS: &'static [Terms] = &[
        &[],
        &[(0, [0.05260015195876773, 2.235551482914852e-18])],
        &[
            (0, [0.0197250569845379, -8.963916698837345e-19]),
            (1, [0.0591751709536137, -2.689175009651222e-18]),
        ],
        &[
            (0, [0.02958758547680685, -1.3445875048256086e-18]),
            (2, [0.08876275643042054, 2.905131389430402e-18]),
        ],
        &[
            (0, [0.2413651341592667, -6.624152203915084e-18]),
            (2, [-0.8845494793282861, 7.016246096564393e-18]),
            (3, [0.924834003261792, 1.0537371249778897e-17]),
        ],
        &[
            (0, [0.037037037037037035, 2.055968564120357e-18]),
            (3, [0.17082860872947386, 8.17588394986545e-18]),
            (4, [0.12546768756682242, 8.27186456310011e-18]),
        ],
        &[
            (0, [0.037109375, -2.306165098256569e-31]),
            (3, [0.17025221101954405, -8.139510062367337e-18]),
            (4, [0.06021653898045596, 1.2006161584603956e-18]),
            (5, [-0.017578125, -2.559986847208263e-32]),
        ],
        &[
            (0, [0.03709200011850479, 3.4253328451423317e-18]),
            (3, [0.17038392571223998, 1.2967148331612045e-17]),
            (4, [0.10726203044637328, 4.772385209398826e-18]),
            (5, [-0.015319437748624402, 2.847513734176444e-19]),
            (6, [0.008273789163814023, -3.6605551308353827e-19]),
        ],
        &[
            (0, [0.6241109587160757, 2.4926899156307656e-17]),
            (3, [-3.3608926294469414, 1.5456576283941952e-16]),
            (4, [-0.868219346841726, -3.718582587865285e-17]),
            (5, [27.59209969944671, -1.288134305916391e-15]),
            (6, [20.154067550477894, -4.800642775601728e-16]),
            (7, [-43.48988418106996, 1.9413089553812006e-15]),
        ],
        &[
            (0, [0.47766253643826434, 2.572426291265729e-17]),
            (3, [-2.4881146199716677, 7.616377660551353e-17]),
            (4, [-0.590290826836843, -2.187045026955204e-17]),
            (5, [21.230051448181193, 1.1824507909843229e-15]),
            (6, [15.279233632882423, 1.6175344620754993e-16]),
            (7, [-33.28821096898486, 3.9439004961640724e-16]),
            (8, [-0.020331201708508627, 7.661055475764706e-19]),
        ],
        &[
            (0, [-0.9371424300859873, -2.660163817828753e-17]),
            (3, [5.186372428844064, -8.942575540409589e-17]),
            (4, [1.0914373489967295, 7.207295585395611e-17]),
            (5, [-8.149787010746927, 6.71260684948575e-16]),
            (6, [-18.52006565999696, -7.79846398446976e-16]),
            (7, [22.739487099350505, -8.796132218075231e-16]),
            (8, [2.4936055526796523, 5.248197812836758e-17]),
            (9, [-3.0467644718982196, 1.3907396197550824e-16]),
        ],
        &[
            (0, [2.273310147516538, 1.7007512072371205e-16]),
            (3, [-10.53449546673725, -7.400733880608535e-16]),
            (4, [-2.0008720582248625, -2.8231311099785855e-17]),
            (5, [-17.9589318631188, 3.8189608367613123e-16]),
            (6, [27.94888452941996, 1.1856623515435014e-16]),
            (7, [-2.8589982771350235, -1.700763072263501e-16]),
            (8, [-8.87285693353063, -2.2457366408215836e-16]),
            (9, [12.360567175794303, -1.3158566470099842e-16]),
            (10, [0.6433927460157636, -4.213091915914117e-17]),
        ],
    ];
    const WEIGHTS: Terms = &[
        (0, [0.054293734116568765, -2.5645259176078755e-18]),
        (5, [4.450312892752409, -2.737092775581944e-16]),
        (6, [1.8915178993145003, 6.581122499260417e-17]),
        (7, [-5.801203960010585, 1.3317442893008234e-16]),
        (8, [0.3111643669578199, -1.0104455449341462e-17]),
        (9, [-0.1521609496625161, 8.776696451847189e-18]),
        (10, [0.20136540080403034, 6.122572160027292e-18]),
        (11, [0.04471061572777259, 3.1043973515104757e-18]),
    ];
}

impl Embedded for Dop853 {
    const DIFFERENCES: [Terms; 2] = [
        // Order 5.
        &[
            (0, [0.013120044994194881, 0.0]),
            (5, [-1.2251564463762044, 0.0]),
            (6, [-0.4957589496572502, 0.0]),
            (7, [1.6643771824549865, 0.0]),
            (8, [-0.35032884874997368, 0.0]),
            (9, [0.3341791187130175, 0.0]),
            (10, [0.08192320648511571, 0.0]),
            (11, [-0.022355307863886296, 0.0]),
        ],
        // Order 3, with the weights 31/127, 0.7338.. and 3/136 at stages 0, 8 and 11.
        &[
            (0, [0.054293734116568765 - 0.2440944881889764, 0.0]),
            (5, [4.450312892752409, 0.0]),
            (6, [1.8915178993145003, 0.0]),
            (7, [-5.801203960010585, 0.0]),
            (8, [0.3111643669578199 - 0.7338466882816118, 0.0]),
            (9, [-0.1521609496625161, 0.0]),
            (10, [0.20136540080403034, 0.0]),
            (11, [0.04471061572777259 - 0.022058823529411766, 0.0]),
        ],
    ];
}

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
