//! Runs that are stopped and go on, with their states in files, and the sentence on all runs.

use super::{energy, where_they_went};
use crate::claim::Readings;
use crate::experiment::{perform, plan};
use crate::journal::{Journal, Ledger, Shard, Start, checkpoint};
use crate::scene::{Scene, Task};
use afterbay_analysis::progress::{Progress, Silent};
use afterbay_analysis::study::outcome::COMPLETED;
use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Asks to stop after `legs` legs, or once it was asked `asked` times.
struct Stop {
    legs: AtomicU64,
    asked: AtomicU64,
}

impl Stop {
    fn after(legs: u64, asked: u64) -> Self {
        Self { legs: AtomicU64::new(legs), asked: AtomicU64::new(asked) }
    }
}

impl Progress for Stop {
    fn begin(&self, _stage: &str, _total: usize) {}

    fn advance(&self) {}

    fn part(&self, share: f64) {
        // The share of a leg is taken back at its end.
        if share < 0.0 {
            self.legs.fetch_sub(1, Ordering::Relaxed);
        }
    }

    fn stopped(&self) -> bool {
        let asked = self.asked.load(Ordering::Relaxed);
        self.asked.store(asked.saturating_sub(1), Ordering::Relaxed);
        asked == 0 || self.legs.load(Ordering::Relaxed) == 0
    }
}

fn journal(folder: &Path, scene: &Scene, shard: Shard) -> Journal {
    let cells = plan(Task::Run, scene).expect("a plan");
    Journal::open(folder, (Task::Run, scene), (&cells, shard), Start::Resume).expect("a journal")
}

/// The table of the states and that of the events, and the bytes of the first in memory.
fn tables(scene: &Scene, ledger: &dyn Ledger, progress: &dyn Progress) -> (String, String, usize) {
    let results = perform(Task::Run, scene, ledger, progress).expect("results");
    let (output, _) = results.expect("all cells");
    let table = |name: &str| {
        let found = output.artifacts.iter().find(|artifact| artifact.name == name);
        found.map_or((String::new(), 0), |artifact| {
            let mut text = String::new();
            artifact.open().and_then(|mut all| all.read_to_string(&mut text)).expect("a table");
            (text, artifact.text.len())
        })
    };
    let ((states, held), (events, _)) = (table("data/trajectory.csv"), table("data/events.csv"));
    (states, events, held)
}

fn text(end: f64, of_run: &str) -> String {
    format!(
        "[system]\nname = \"duffing\"\nparameters = {{ alpha = 1.0, beta = 0.5, c = 1e-5 }}\n\
         [initial]\nq = [1.0]\np = [0.5]\n[time]\nend = {end}\nstep = 0.01\n\
         [run]\nmethods = [\"moddg\"]\n{of_run}\n"
    )
}

#[test]
fn stopped_runs_go_on_with_the_same_tables() {
    let events = "every = 10\n[run.events.left]\nof = \"q1\"\n[run.events.fast]\nof = \"p1\"\n\
                  value = 0.3\ndirection = \"both\"\n";
    for (of_run, end) in [("every = 50", 25_000.0), ("sample = 0.07", 1500.0), (events, 1500.0)] {
        let scene = Scene::read(&text(end, of_run)).expect("a scene");
        let (states, found, held) = tables(&scene, &crate::experiment::Afresh, &Silent);
        assert_eq!((held, found.is_empty()), (states.len(), of_run != events));
        // Stopped after a leg; in the middle of one; after a leg and again in the middle.
        for stops in [&[(1, u64::MAX)][..], &[(9, 13_000)], &[(2, u64::MAX), (9, 3_000)]] {
            let folder = tempfile::tempdir().expect("a folder");
            for &(legs, asked) in stops {
                let journal = journal(folder.path(), &scene, Shard::WHOLE);
                let (some, ..) = tables(&scene, &journal, &Stop::after(legs, asked));
                assert!(some.len() < states.len(), "{of_run}: it was not stopped");
                // What was done is a beginning of the table; the last state may be another.
                let lines = some.lines().count() - 1;
                let begin = |text: &str| text.lines().take(lines).map(str::to_owned).collect();
                let [some, all]: [Vec<String>; 2] = [begin(&some), begin(&states)];
                assert!(lines > 100 && some == all, "{of_run}: the beginning differs");
            }
            let journal = journal(folder.path(), &scene, Shard::WHOLE);
            let before = journal.recall(&checkpoint("run/moddg"));
            assert_eq!(before.is_some(), stops[0].1 == u64::MAX, "{of_run}");
            let (resumed, again, held) = tables(&scene, &journal, &Silent);
            assert!(resumed == states && again == found, "{of_run}: {stops:?}: tables differ");
            assert!(held < 100, "the rows of the table are in a file: {held}");
        }
    }
}

/// What is kept of a run between two legs, and at its end, does not grow with its states.
#[test]
fn a_run_of_any_length_keeps_little_in_its_journal() {
    let size = |end: f64, legs: u64| {
        let scene = Scene::read(&text(end, "every = 25")).expect("a scene");
        let folder = tempfile::tempdir().expect("a folder");
        let ledger = journal(folder.path(), &scene, Shard::WHOLE);
        let (some, ..) = tables(&scene, &ledger, &Stop::after(legs, u64::MAX));
        drop(ledger);
        let ledger = journal(folder.path(), &scene, Shard::WHOLE);
        let kept = ledger.recall(&checkpoint("run/moddg")).expect("a checkpoint");
        (some.len(), kept.len())
    };
    let ((short, first), (long, second)) = (size(25_000.0, 1), size(100_000.0, 8));
    assert!(short > 3_000_000 && long > 7 * short, "{short} and {long} bytes of the table");
    // A block of the table, and the last state.
    assert!(first.max(second) < 70_000, "{first} and {second} bytes of the journal");
}

#[test]
fn another_command_goes_on_with_the_states_of_a_run() {
    let scene = Scene::read(&text(25_000.0, "every = 50")).expect("a scene");
    let folder = tempfile::tempdir().expect("a folder");
    let whole = journal(folder.path(), &scene, Shard::WHOLE);
    let (states, ..) = tables(&scene, &crate::experiment::Afresh, &Silent);
    tables(&scene, &whole, &Stop::after(1, u64::MAX));
    drop(whole);
    // The first of two shares has the only cell.
    let share = journal(folder.path(), &scene, Shard { number: 1, count: 2 });
    let (resumed, ..) = tables(&scene, &share, &Silent);
    assert!(resumed == states, "tables differ");
    drop(share);
    let joined = Journal::join(folder.path(), Task::Run).expect("a journal");
    assert_eq!(joined.task, Task::Run);
    assert!(tables(&joined.scene, &joined.journal, &Silent).0 == states, "tables differ");
}

#[test]
fn states_between_the_steps_of_a_tolerance_are_told_from_steps() {
    let said = |method: &str| {
        let r = Readings::default().and(method, "run", COMPLETED);
        where_they_went(&r.and(method, "rise", 1e-3)).1
    };
    assert!(said("rk4").contains("it rises with rk4 1e-3. 1 of 1 runs"), "{}", said("rk4"));
    let between = said("adaptive-radau");
    assert!(between.contains("adaptive-radau 1e-3. Between two steps that follow"), "{between}");
}

#[test]
fn energies_of_any_size_can_be_read() {
    let shown = [0.0, -0.5, 123.25, 2e-7, -1e82].map(energy);
    assert_eq!(shown, ["0.000000", "-0.500000", "123.250000", "2.000000e-7", "-1.000000e82"]);
}
