//! The sentence on Lyapunov exponents, and those of stiff motions by the reference.

use crate::lyapunov::{custom, last, settled};
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::dynamics::Dynamics;
use afterbay_experiments::experiment;
use afterbay_experiments::report::Verdict;
use afterbay_experiments::scene::Scene;
use afterbay_methods::registry::REFERENCE;

/// Large friction holds a slow motion, which alone shows nothing of the fast decay.
#[test]
fn the_reference_of_a_stiff_motion_has_its_exponents() {
    let found = settled("q1^2/2", "300*v1", 1.0, [1.0, 20.0]).run(&REFERENCE, 0.05, &Silent);
    let (exponents, sum, ..) = last(&found.unwrap());
    let root = (90_000.0_f64 - 4.0).sqrt();
    let slow = -2.0 / (300.0 + root);
    assert!((exponents[0] - slow).abs() < 1e-9, "{exponents:?}, not {slow}");
    assert!((sum + 300.0).abs() < 3e-4, "{sum}");
}

/// Within a step of 0.05 displacements shrink by more than the differences of 2⁻⁵² can show.
#[test]
fn a_reference_that_loses_a_mode_is_in_doubt() {
    let text = custom("q1^2/2", "1000*v1", &[1.0], &[0.0]);
    let study = "[study.lyapunov]\nmethods = [\"moddg\"]\nrows = 4\ntransient = 1\n";
    let scene = Scene::read(&format!("{text}{study}")).unwrap_or_else(|error| panic!("{error}"));
    let (_, findings) = experiment::study(&scene, &Silent).unwrap();
    let statement = &findings[0].statement;
    assert!(statement.contains("it is in doubt, since these differ"), "{statement}");
    assert_eq!(findings[0].verdict, Verdict::Fails);
}

/// Without friction all exponents are 0, and what is found are roundings of the steps.
#[test]
fn exponents_that_are_roundings_are_0() {
    let text = custom("q1^2/2", "", &[1.0], &[0.0]);
    let study = "[study.lyapunov]\nmethods = [\"gonzalez\"]\ntime = 20\n";
    for step in ["0.01", "0.001"] {
        let text = text.replace("step = 0.1", &format!("step = {step}"));
        let scene =
            Scene::read(&format!("{text}{study}")).unwrap_or_else(|error| panic!("{error}"));
        let (_, findings) = experiment::study(&scene, &Silent).unwrap();
        let statement = &findings[0].statement;
        assert_eq!(statement.matches("(0 within the error)").count(), 2, "{statement}");
        let differs = ["doubt", "not that of the reference"].map(|word| statement.contains(word));
        assert_eq!(differs, [false; 2], "{statement}");
        assert_eq!(findings[0].verdict, Verdict::Note);
    }
}
