//! Long runs in legs.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::cell::{Leg, Study};
use afterbay_analysis::study::long_run::{LongRuns, Setup};
use afterbay_methods::registry::find;
use afterbay_systems::DUFFING;

#[test]
fn legs_go_on_from_what_was_kept_to_the_bit() {
    let duffing = [("alpha", 1.0), ("beta", 1.0), ("c", 1e-7)];
    let model = Model::named(&DUFFING, duffing).expect("a system");
    let start = Problem { model, q: vec![1.0], p: vec![0.5], end: 1.0 };
    let row = find("moddg").expect("a method");
    // In lanes the last window takes two legs; a single run goes on alone.
    for (count, steps) in [(8, 5_600_000), (1, 20_000)] {
        let setup = Setup { row, h: 0.1, compensated: count == 1 };
        let study = LongRuns::new(vec![start.clone(); count], vec![setup], steps);
        let study = study.expect("a study");
        let (mut so_far, mut legs) = (None, 0);
        let resumed = loop {
            legs += 1;
            match study.advance(&(), 0, so_far, &Silent, None).expect("a leg") {
                Leg::Last(followed) => break followed,
                Leg::Further(followed) => {
                    let mut bytes = Vec::new();
                    ciborium::into_writer(&followed, &mut bytes).expect("bytes");
                    so_far = Some(ciborium::from_reader(&bytes[..]).expect("the same"));
                }
            }
        };
        let once = study.compute(&(), 0, &Silent).expect("a cell");
        assert_eq!(format!("{resumed:?}"), format!("{once:?}"));
        let [run] = &study.gather(&[once])[..] else { panic!("one setup") };
        let windows = run.rows.len();
        assert_eq!(legs, if count == 1 { windows } else { windows + 1 });
        assert!(run.ending.is_completed(), "{:?}", run.ending);
        assert_eq!(run.rows.last().expect("rows").steps, steps);
    }
}
