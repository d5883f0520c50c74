//! Legs of a cell that are stopped halfway.

use super::*;
use crate::Model;
use crate::progress::Silent;
use crate::study::cell::{Leg, Study};
use crate::study::long_run::LongRuns;
use afterbay_systems::DUFFING;
use std::sync::atomic::{AtomicU64, Ordering};

/// Asks to stop once it was asked this number of times.
struct After(AtomicU64);

impl Progress for After {
    fn begin(&self, _stage: &str, _total: usize) {}

    fn advance(&self) {}

    fn stopped(&self) -> bool {
        let before = self.0.load(Ordering::Relaxed);
        self.0.store(before.saturating_sub(1), Ordering::Relaxed);
        before == 0
    }
}

/// Goes on with a cell until it is done, or stopped.
fn follow(
    study: &LongRuns,
    mut so_far: Option<Followed>,
    progress: &dyn Progress,
) -> (Option<Followed>, bool) {
    loop {
        match study.advance(&(), 0, so_far.take(), progress, None).expect("a leg") {
            Leg::Last(followed) => return (Some(followed), true),
            Leg::Further(followed) => so_far = Some(followed),
        }
        if progress.stopped() {
            return (so_far, false);
        }
    }
}

/// Of two starts in a well without walls, one is on its way out and fails in the third window.
#[test]
fn a_leg_that_is_stopped_halfway_counts_each_state_once() {
    let model = Model::of(&DUFFING, &[1.0, -1.0, 0.0]);
    let inside = Problem { model, q: vec![0.5], p: vec![0.0], end: 1.0 };
    let outside = Problem { q: vec![1.0 + 1e-12], ..inside.clone() };
    let row = afterbay_methods::registry::find("rk4").expect("a method");
    let setup = Setup { row, h: 0.1, compensated: false };
    let study = LongRuns::new(vec![inside, outside], vec![setup], 2000).expect("a study");
    let (Some(whole), true) = follow(&study, None, &Silent) else { panic!("a cell") };
    let failed = &whole.runs[1];
    assert_eq!((failed.ending.outcome, failed.windows.len()), ("not-finite", 2), "{failed:?}");
    let counts: Vec<u64> = whole.runs[0].windows.iter().map(|window| window.count).collect();
    assert_eq!(counts, [100, 78, 69, 82, 87, 97, 74], "the samples of each window");
    let (mut asked, mut stops) = (0, 0);
    loop {
        let (kept, done) = follow(&study, None, &After(AtomicU64::new(asked)));
        if done {
            break;
        }
        // A checkpoint is written and read.
        let mut bytes = Vec::new();
        ciborium::into_writer(&kept, &mut bytes).expect("bytes");
        let kept = ciborium::from_reader(&bytes[..]).expect("the same");
        let (resumed, done) = follow(&study, kept, &Silent);
        assert!(done);
        assert_eq!(format!("{:?}", resumed.as_ref()), format!("{:?}", Some(&whole)), "{asked}");
        (asked, stops) = (asked + 3, stops + 1);
    }
    assert!(stops > 200, "{stops}");
}
