//! `validate::drive` accepts true harmonics and dependences, and finds false ones.

use afterbay_core::{Drive, Harmonic, Harmonics, InputError, Quantity, validate};

/// Forces on the second and the third degree of freedom: 0.3 + 2 cos ωt - sin 3ωt, and
/// q1 q2 cos ωt.
struct Forces {
    omega: f64,
    claimed: Option<Harmonics<f64>>,
    depends: [bool; 2],
}

/// The sum of the first force.
fn sum(omega: f64) -> Harmonics<f64> {
    let term = |k, cosine, sine| Harmonic { frequency: k * omega, cosine, sine };
    Harmonics { constant: 0.3, terms: vec![term(1.0, 2.0, 0.0), term(3.0, 0.0, -1.0)] }
}

impl Drive<f64> for Forces {
    fn driven(&self) -> &[usize] {
        &[1, 2]
    }
    fn force(&self, k: usize, q: &[f64], t: f64) -> f64 {
        let angle = self.omega * t;
        match k {
            0 => 0.3 + 2.0 * angle.cos() - (3.0 * angle).sin(),
            _ => q[0] * q[1] * angle.cos(),
        }
    }
    fn slopes(&self, _k: usize, _q: &[f64], _t: f64, _put: &mut dyn FnMut(Option<usize>, f64)) {}
    fn depends_on_own(&self, k: usize) -> bool {
        k == 0 && self.depends[0]
    }
    fn depends_on_coordinates(&self, k: usize) -> bool {
        k == 1 && self.depends[1]
    }
    fn harmonics(&self, k: usize) -> Option<Harmonics<f64>> {
        if k == 0 { self.claimed.clone() } else { None }
    }
}

const Q: [f64; 3] = [0.4, -1.2, 0.0];

fn found(omega: f64, t: f64, claimed: Harmonics<f64>) -> Result<(), InputError> {
    validate::drive(&Forces { omega, claimed: Some(claimed), depends: [false, true] }, &Q, t)
}

fn assert_caught(outcome: Result<(), InputError>, at: usize, says: &str) {
    let Err(InputError::Contradiction { quantity: Quantity::Drive, dof, rule, .. }) = outcome
    else {
        panic!("{says}: {outcome:?}")
    };
    assert!(dof == at && rule.contains(says), "{says}: {dof} {rule}");
}

#[test]
fn true_sums_pass_in_all_units() {
    for omega in [1e-9, 0.7, -2.5, 1e12] {
        for t in [0.0, 1.0 / omega, -1e4 / omega] {
            assert_eq!(found(omega, t, sum(omega)), Ok(()), "{omega} {t}");
        }
    }
}

#[test]
fn false_sums_are_found() {
    for omega in [1e-9, 0.7, 1e12] {
        let mut lies = vec![sum(1.001 * omega), Harmonics::constant(0.3)];
        for (k, off) in [(0, 1e-9), (1, 1e-9)] {
            let mut lie = sum(omega);
            lie.terms[k].cosine += off;
            lies.push(lie);
        }
        let (mut constant, mut sign) = (sum(omega), sum(omega));
        constant.constant = f64::NAN;
        sign.terms[1].sine = 1.0;
        for lie in lies.into_iter().chain([constant, sign]) {
            assert_caught(found(omega, 0.0, lie), 1, "harmonics()");
        }
    }
}

#[test]
fn forces_that_depend_on_what_they_deny_are_found() {
    let forces = |depends| Forces { omega: 0.7, claimed: None, depends };
    assert_eq!(validate::drive(&forces([true, true]), &Q, 0.0), Ok(()));
    let denied = validate::drive(&forces([false, false]), &Q, 0.0);
    assert_caught(denied, 2, "depends_on_coordinates()");
    /// F = q, and not of its own degree of freedom.
    struct Spring;
    impl Drive<f64> for Spring {
        fn driven(&self) -> &[usize] {
            &[0]
        }
        fn force(&self, _k: usize, q: &[f64], _t: f64) -> f64 {
            1.0 / q[0]
        }
        fn slopes(&self, _k: usize, _q: &[f64], _t: f64, _put: &mut dyn FnMut(Option<usize>, f64)) {
        }
        fn depends_on_own(&self, _k: usize) -> bool {
            false
        }
    }
    assert_caught(validate::drive(&Spring, &[2.0], 0.0), 0, "depends_on_own()");
    let quantity = Quantity::Drive;
    let refused = InputError::NotFinite { quantity, dof: 0, value: f64::INFINITY };
    assert_eq!(validate::drive(&Spring, &[0.0], 0.0), Err(refused));
    let quantity = Quantity::Coordinate;
    let refused = InputError::Length { quantity, expected: 2, found: 1 };
    assert_eq!(validate::drive(&forces([true, true]), &[1.0], 0.0), Err(refused));
}
