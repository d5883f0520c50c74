//! Any bytes are read or refused within a second, the longest texts within a few, without a panic,
//! and what is read is planned. Nothing is run.
//!
//! `AFTERBAY_FUZZ_CASES=10000000 cargo test -p afterbay-experiments --test suite fuzz` looks for
//! hours. The scenes of `corpus/scenes` and the valid ones begin every search, unchanged and with
//! changes.

use super::{SOON, bad, soon};
use afterbay_experiments::experiment::plan;
use afterbay_experiments::scene::{MOST_BYTES, Scene, Task, text};
use proptest::prelude::*;
use std::time::Duration;

/// Tokens inserted into valid scenes.
const TOKENS: [&str; 30] = [
    "[",
    "]",
    "{",
    "}",
    "[[",
    "=",
    ".",
    ",",
    "\"",
    "\"\"\"",
    "'",
    "'''",
    "#",
    "\n",
    "\r\n",
    "\\",
    "nan",
    "inf",
    "1e999",
    "-",
    "0",
    "99999999999999999999",
    "q1",
    "p2",
    "^",
    "(",
    "1/0",
    "\u{feff}",
    "é",
    "study.",
];

/// A change of a text at a place given as a share of its length.
#[derive(Clone, Debug)]
enum Change {
    Delete { at: f64, length: usize },
    Repeat { at: f64, length: usize },
    Replace { at: f64, byte: u8 },
    Insert { at: f64, token: &'static str },
    SwapLines { one: usize, other: usize },
}

fn change() -> impl Strategy<Value = Change> {
    let share = 0.0..1.0_f64;
    prop_oneof![
        (share.clone(), 1..9_usize).prop_map(|(at, length)| Change::Delete { at, length }),
        (share.clone(), 1..40_usize).prop_map(|(at, length)| Change::Repeat { at, length }),
        (share.clone(), any::<u8>()).prop_map(|(at, byte)| Change::Replace { at, byte }),
        (share, prop::sample::select(&TOKENS[..]))
            .prop_map(|(at, token)| Change::Insert { at, token }),
        (0..40_usize, 0..40_usize).prop_map(|(one, other)| Change::SwapLines { one, other }),
    ]
}

fn apply(bytes: &mut Vec<u8>, change: &Change) {
    let place = |at: f64, length: usize| ((at * length as f64) as usize).min(length);
    match *change {
        Change::Delete { at, length } => {
            let at = place(at, bytes.len());
            bytes.drain(at..(at + length).min(bytes.len()));
        }
        Change::Repeat { at, length } => {
            let at = place(at, bytes.len());
            let part = bytes[at..(at + length).min(bytes.len())].to_vec();
            bytes.splice(at..at, part);
        }
        Change::Replace { at, byte } => {
            let at = place(at, bytes.len());
            if let Some(old) = bytes.get_mut(at) {
                *old = byte;
            }
        }
        Change::Insert { at, token } => {
            let at = place(at, bytes.len());
            bytes.splice(at..at, token.bytes());
        }
        Change::SwapLines { one, other } => {
            let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
            if one < lines.len() && other < lines.len() {
                lines.swap(one, other);
            }
            *bytes = lines.concat();
        }
    }
}

/// For the longest texts, which take up to a second here, without optimisation: work that grows as
/// the square of the length takes minutes.
const LONG: Duration = Duration::from_secs(5);

/// Reads the bytes in the given time. An error must refer to a place within the text.
fn read(bytes: &[u8], limit: Duration) -> Result<(), TestCaseError> {
    let (took, error) = soon(|| {
        let scene = text(bytes).and_then(Scene::read);
        if let Ok(scene) = &scene {
            for task in [Task::Run, Task::Study] {
                // A refusal is as good as a plan.
                let _ = plan(task, scene);
            }
        }
        scene.err()
    });
    if let (Some(error), Ok(text)) = (error, text(bytes)) {
        let place = text.get(error.span.clone());
        prop_assert!(place.is_some(), "{error} at {:?} of {} bytes", error.span, text.len());
        prop_assert!(!error.to_string().is_empty());
    }
    prop_assert!(took < limit, "{took:?}");
    Ok(())
}

/// The number of cases of a test: `usual`, unless the environment asks for another.
fn cases(usual: u32) -> ProptestConfig {
    let asked = std::env::var("AFTERBAY_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok());
    ProptestConfig { cases: asked.unwrap_or(usual), ..ProptestConfig::default() }
}

/// Valid scenes, and those of the corpus.
fn corpus() -> Vec<Vec<u8>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/scenes");
    let files = std::fs::read_dir(folder).expect("the corpus");
    let mut paths: Vec<_> = files.map(|file| file.expect("a file").path()).collect();
    paths.sort();
    let kept = paths.iter().map(|path| std::fs::read(path).expect("a scene"));
    bad::GOOD.iter().map(|good| good.as_bytes().to_vec()).chain(kept).collect()
}

#[test]
fn the_corpus_is_read_or_refused() {
    for bytes in corpus() {
        let found = read(&bytes, SOON);
        assert!(found.is_ok(), "{}: {found:?}", String::from_utf8_lossy(&bytes));
    }
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read(&bytes, SOON)?;
    }

    #[test]
    fn any_text_is_read_or_refused(
        tokens in prop::collection::vec(prop::sample::select(&TOKENS[..]), 0..60),
    ) {
        read(tokens.concat().as_bytes(), SOON)?;
    }

    #[test]
    fn a_scene_with_changes_is_read_or_refused(
        good in prop::sample::select(corpus()),
        changes in prop::collection::vec(change(), 0..6),
    ) {
        let mut bytes = good;
        changes.iter().for_each(|change| apply(&mut bytes, change));
        read(&bytes, SOON)?;
    }
}

#[test]
fn long_texts_are_read_or_refused_soon() {
    let numbers = |separator: &str| {
        let all: Vec<_> = (1..100_000_u32).map(|i| format!("{i}e-9")).collect();
        all.join(separator)
    };
    let [named, custom, ..] = bad::GOOD;
    for (what, long) in [
        ("steps", named.replacen("[0.1, 0.05]", &format!("[{}]", numbers(",")), 1)),
        ("q", named.replacen("[2.3]", &format!("[{}]", numbers(",")), 1)),
        ("masses", custom.replacen("[1.0, 2.0]", &format!("[{}]", numbers(",")), 1)),
        ("keys", (0..60_000).map(|i| format!("k{i} = {i}\n")).collect()),
        (
            "parameters",
            custom.replacen(
                "c = 0.05",
                &(0..50_000).map(|i| format!("c{i} = {i},")).collect::<String>(),
                1,
            ),
        ),
        ("methods", named.replacen("\"moddg\"", &"\"rk4\",".repeat(100_000), 1)),
        ("sum", custom.replacen("q1^2/2", &"q1^2*q2+".repeat(8_000), 1)),
        ("powers", custom.replacen("q1^2/2", &format!("{}1", "q1^".repeat(200)), 1)),
        (
            "functions",
            custom.replacen("q1^2/2", &format!("{}q1{}", "sin(".repeat(200), ")".repeat(200)), 1),
        ),
        (
            "friction",
            custom.replacen(
                "dissipation = [\"c*p1\", \"c*p2\"]\nmass = [1.0, 2.0]",
                &format!("friction = [{}]", format!("[{}],", "0,".repeat(600)).repeat(600)),
                1,
            ),
        ),
    ] {
        assert!(long.len() <= MOST_BYTES, "{what}: {}", long.len());
        let found = read(long.as_bytes(), LONG);
        assert!(found.is_ok(), "{what}: {found:?}");
    }
}
