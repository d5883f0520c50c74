//! Compositions of forward and backward sweeps for higher order.

use afterbay_core::{InputError, Scalar};

/// The fractions of the step that the sweeps take: forward, backward, forward, ... in turn. They
/// sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Composition {
    fractions: Vec<[f64; 2]>,
}

impl Composition {
    /// Alternates forward and backward sweeps with the given fractions of the step, which sum to 1.
    /// The order is 1, or 2 if the fractions are the same from both ends; more takes fractions that
    /// satisfy further conditions, such as those of [`Composition::suzuki4`].
    ///
    /// ```
    /// use afterbay_methods::Composition;
    /// let half_and_half = Composition::alternating(&[0.5, 0.5])?;
    /// assert_eq!(half_and_half, Composition::pair());
    /// # Ok::<(), afterbay_core::InputError>(())
    /// ```
    ///
    /// # Errors
    /// [`InputError::Parameter`] where their sum is not 1 to the rounding of its terms.
    pub fn alternating(fractions: &[f64]) -> Result<Self, InputError> {
        let value = fractions.iter().fold(0.0, |sum, x| sum + x);
        let size: f64 = fractions.iter().map(|x| x.abs()).sum();
        if !size.is_finite() || (value - 1.0).abs() > fractions.len() as f64 * f64::EPSILON * size {
            return Err(InputError::Parameter { name: "sum of the fractions", value, range: "1" });
        }
        Ok(Self { fractions: fractions.iter().map(|&x| [x, 0.0]).collect() })
    }

    /// One sweep: order 1.
    pub fn sweep() -> Self {
        Self { fractions: vec![[1.0, 0.0]] }
    }

    /// Half a step forward and half a step backward: symmetric, order 2.
    pub fn pair() -> Self {
        Self { fractions: vec![[0.5, 0.0]; 2] }
    }

    /// Order 4: five pairs (Suzuki 1990).
    pub fn suzuki4() -> Self {
        Self::of_pairs(&SUZUKI_4)
    }

    /// Order 4: twelve sweeps (Blanes and Moan 2002, S6, to the fifteen digits printed).
    pub fn blanes_moan4() -> Self {
        Self { fractions: BLANES_MOAN_4.to_vec() }
    }

    /// Order 6: seven pairs (Yoshida 1990).
    pub fn yoshida6() -> Self {
        Self::of_pairs(&YOSHIDA_6)
    }

    /// Order 6: nine pairs (McLachlan 1995).
    pub fn mclachlan6() -> Self {
        Self::of_pairs(&MCLACHLAN_6)
    }

    /// Order 6: twenty sweeps (Blanes and Moan 2002, S10, to the fifteen digits printed).
    pub fn blanes_moan6() -> Self {
        Self { fractions: BLANES_MOAN_6.to_vec() }
    }

    /// Order 8: seventeen pairs (Kahan and Li 1997).
    pub fn kahan_li8() -> Self {
        Self::of_pairs(&KAHAN_LI_8)
    }

    /// The number of sweeps in a step.
    pub fn sweeps(&self) -> usize {
        self.fractions.len()
    }

    /// Builds pairs of sweeps; each sweep takes half the weight.
    fn of_pairs(weights: &[[f64; 2]]) -> Self {
        let halves = |&[high, low]: &[f64; 2]| [[high / 2.0, low / 2.0]; 2];
        Self { fractions: weights.iter().flat_map(halves).collect() }
    }

    /// The fractions of the step taken by the sweeps, in order. They sum to 1.
    pub fn fractions<T: Scalar>(&self) -> impl Iterator<Item = T> {
        self.fractions.iter().map(|&[high, low]| T::from_f64(high) + T::from_f64(low))
    }
}

// Each number is the sum of two doubles; tests/data/compositions.py prints them with their sources.

const SUZUKI_4: [[f64; 2]; 5] = [
    [0.4144907717943757, 2.5197374150855977e-17],
    [0.4144907717943757, 2.5197374150855977e-17],
    [-0.657963087177503, 1.023280585909174e-17],
    [0.4144907717943757, 2.5197374150855977e-17],
    [0.4144907717943757, 2.5197374150855977e-17],
];

const YOSHIDA_6: [[f64; 2]; 7] = [
    [0.7845136104775573, -3.5563022382244234e-17],
    [0.23557321335935813, 3.5654707827194944e-18],
    [-1.177679984178871, -2.0339167994318994e-17],
    [1.3151863206839112, 4.9162287956429646e-17],
    [-1.177679984178871, -2.0339167994318994e-17],
    [0.23557321335935813, 3.5654707827194944e-18],
    [0.7845136104775573, -3.5563022382244234e-17],
];

const MCLACHLAN_6: [[f64; 2]; 9] = [
    [0.3921614440073141, 1.98268441460107e-17],
    [0.33259913678935943, 9.999068221580819e-18],
    [-0.7062461725576393, -3.081729314915952e-17],
    [0.0822135962935508, 5.549728434915305e-18],
    [0.79854399093483, -9.116695306694601e-18],
    [0.0822135962935508, 5.549728434915305e-18],
    [-0.7062461725576393, -3.081729314915952e-17],
    [0.33259913678935943, 9.999068221580819e-18],
    [0.3921614440073141, 1.98268441460107e-17],
];

const KAHAN_LI_8: [[f64; 2]; 17] = [
    [0.13020248308889007, 1.1162108848587086e-17],
    [0.5611629817751084, 1.3030629711955552e-17],
    [-0.38947496264484727, -1.9608337955400347e-17],
    [0.1588419065551556, 7.805147593533912e-18],
    [-0.39590389413323757, -1.1273558895660098e-17],
    [0.1845396409783157, -3.916274568717344e-18],
    [0.25837438768632204, 9.396339691672474e-18],
    [0.2950117236093103, 2.648293707662844e-17],
    [-0.6055085338300346, 4.4864319457316306e-17],
    [0.2950117236093103, 2.648293707662844e-17],
    [0.25837438768632204, 9.396339691672474e-18],
    [0.1845396409783157, -3.916274568717344e-18],
    [-0.39590389413323757, -1.1273558895660098e-17],
    [0.1588419065551556, 7.805147593533912e-18],
    [-0.38947496264484727, -1.9608337955400347e-17],
    [0.5611629817751084, 1.3030629711955552e-17],
    [0.13020248308889007, 1.1162108848587086e-17],
];

const BLANES_MOAN_4: [[f64; 2]; 12] = [
    [0.0792036964311957, 5.750283845100057e-18],
    [0.1303114101821663, 1.5451688785105944e-18],
    [0.2228614958676077, -6.938243130207411e-19],
    [-0.3667132690474257, -1.7132786063666572e-17],
    [0.3246481886897062, 1.4738514583950746e-17],
    [0.1096884778767498, -4.207356930874085e-18],
    [0.1096884778767498, -4.207356930874085e-18],
    [0.3246481886897062, 1.4738514583950746e-17],
    [-0.3667132690474257, -1.7132786063666572e-17],
    [0.2228614958676077, -6.938243130207411e-19],
    [0.1303114101821663, 1.5451688785105944e-18],
    [0.0792036964311957, 5.750283845100057e-18],
];

const BLANES_MOAN_6: [[f64; 2]; 20] = [
    [0.0502627644003922, -3.775400318772881e-21],
    [0.0985536835006498, -2.429194323849515e-18],
    [0.3149606169276942, -2.5797296212476794e-17],
    [-0.4473464826954782, 2.0303897387566394e-17],
    [0.4924263724898759, -1.8692092682249494e-17],
    [-0.4251187677976909, 2.1828035470753095e-17],
    [0.2370639139781219, -4.024831678725604e-18],
    [0.1956024886000531, -9.335519252454106e-18],
    [0.3463581898507269, -1.6336753902214696e-17],
    [-0.3627627792543449, 1.367084888224781e-17],
    [-0.3627627792543449, 1.367084888224781e-17],
    [0.3463581898507269, -1.6336753902214696e-17],
    [0.1956024886000531, -9.335519252454106e-18],
    [0.2370639139781219, -4.024831678725604e-18],
    [-0.4251187677976909, 2.1828035470753095e-17],
    [0.4924263724898759, -1.8692092682249494e-17],
    [-0.4473464826954782, 2.0303897387566394e-17],
    [0.3149606169276942, -2.5797296212476794e-17],
    [0.0985536835006498, -2.429194323849515e-18],
    [0.0502627644003922, -3.775400318772881e-21],
];

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::Quad;

    #[test]
    fn a_step_is_covered_once() {
        let all = [
            Composition::sweep(),
            Composition::pair(),
            Composition::suzuki4(),
            Composition::blanes_moan4(),
            Composition::yoshida6(),
            Composition::mclachlan6(),
            Composition::blanes_moan6(),
            Composition::kahan_li8(),
        ];
        for (composition, sweeps) in all.iter().zip([1, 2, 10, 12, 14, 18, 20, 34]) {
            let sum = composition.fractions::<Quad>().fold(Quad::ZERO, |sum, x| sum + x);
            assert!((sum - Quad::ONE).abs().0 < 1e-30, "{composition:?}");
            assert_eq!(composition.sweeps(), sweeps);
            // The composition is symmetric, hence its own adjoint.
            let fractions: Vec<f64> = composition.fractions().collect();
            assert!(
                sweeps == 1
                    || fractions
                        .iter()
                        .zip(fractions.iter().rev())
                        .all(|(a, b)| (a - b).abs() < 1e-14)
            );
        }
    }

    #[test]
    fn fractions_that_are_no_step_are_refused() {
        let refused =
            |fractions: &[f64]| Composition::alternating(fractions).unwrap_err().to_string();
        assert_eq!(refused(&[]), "parameter sum of the fractions = 0.0 must be 1");
        assert_eq!(refused(&[0.5]), "parameter sum of the fractions = 0.5 must be 1");
        assert_eq!(
            refused(&[0.5, 0.5 + 1e-14]),
            "parameter sum of the fractions = 1.00000000000001 must be 1"
        );
        assert_eq!(
            refused(&[1.0, f64::INFINITY]),
            "parameter sum of the fractions = inf must be 1"
        );
        assert_eq!(refused(&[f64::NAN, 1.0]), "parameter sum of the fractions = NaN must be 1");
        assert_eq!(refused(&[1e308, 1e308, 1.0]), "parameter sum of the fractions = inf must be 1");
        assert_eq!(Composition::alternating(&[0.5, 0.5]), Ok(Composition::pair()));
        assert!(Composition::alternating(&[0.1; 10]).is_ok());
        assert!(Composition::alternating(&[0.0, 1.0]).is_ok());
    }

    /// For the weights γ of a symmetric method, Σ γ^k = 0 for odd k below the order.
    #[test]
    fn odd_powers_of_the_weights_cancel() {
        for (weights, order) in
            [(&SUZUKI_4[..], 4), (&YOSHIDA_6[..], 6), (&MCLACHLAN_6[..], 6), (&KAHAN_LI_8[..], 8)]
        {
            for k in (3..order).step_by(2) {
                let sum: f64 = weights.iter().map(|[high, _]| high.powi(k)).sum();
                assert!(sum.abs() < 1e-15, "{order} {k}: {sum:e}");
            }
        }
    }
}
