//! The parts of a study are joined, or refused by name.

use super::shards::{AUTONOMOUS, Place, runs};
use super::{afterbay, done};

#[test]
fn parts_of_something_else_are_refused_by_name() {
    let place = Place::new(AUTONOMOUS);
    place.run("study", "out", &["--shard", "1/2"]);
    let file = place.path("out").join("parts/1-of-2.jsonl");
    let journal = std::fs::read_to_string(&file).expect("a journal");
    let (code, _, stderr) = place.merge("out");
    assert_eq!(code, Some(4), "{stderr}");
    assert!(stderr.contains("cells missing"), "{stderr}");
    for (from, to, word) in [
        ("\"journal\":3", "\"journal\":2", "format"),
        ("\"version\":\"", "\"version\":\"0.0.", "version"),
        ("\"scene\":\"", "\"scene\":\"ab", "scene"),
    ] {
        std::fs::write(&file, journal.replacen(from, to, 1)).expect("it is written");
        for output in
            [done(&mut place.command("study", "out", &["--shard", "2/2"])), place.merge("out")]
        {
            assert!(matches!(output.0, Some(3 | 5)), "{}", output.2);
            assert!(output.2.contains(word), "{word}: {}", output.2);
        }
    }
    std::fs::write(&file, "no journal\n").expect("it is written");
    let (code, _, stderr) = place.merge("out");
    assert_eq!(code, Some(3), "{stderr}");
    let (code, _, stderr) = place.merge("elsewhere");
    assert_eq!(code, Some(3), "{stderr}");
    assert!(stderr.contains("no parts"), "{stderr}");
    let (_, _, stderr) = done(afterbay(&["merge", "--run"]).arg(place.path("elsewhere")));
    assert!(stderr.contains("no parts of a run") && stderr.contains("`afterbay run"), "{stderr}");
}

/// A merge has no `--out`: its messages name the parts.
#[test]
fn a_merge_counts_its_cells_and_names_a_missing_scene() {
    let place = Place::new(AUTONOMOUS);
    for shard in ["1/2", "2/2"] {
        place.run("study", "out", &["--shard", shard]);
    }
    let mut merge = afterbay(&["merge", "--no-png", "--format", "json"]);
    let (code, stdout, stderr) = done(merge.arg(place.path("out")));
    assert_eq!(code, Some(0), "{stderr}");
    let summary: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    assert!(summary["cells"].as_u64() > Some(1) && summary["reused"] == summary["cells"]);

    let file = place.path("out").join("parts/1-of-2.jsonl");
    let journal = std::fs::read_to_string(&file).expect("a journal");
    let other = journal.replacen("\"version\":\"", "\"version\":\"0.0.", 1);
    std::fs::write(&file, other).expect("it is written");
    let (_, _, stderr) = place.merge("out");
    assert!(stderr.contains("anew") && !stderr.contains("--out"), "{stderr}");
    std::fs::write(&file, journal).expect("it is written");

    let parts = std::fs::read_dir(place.path("out").join("parts")).expect("a folder");
    let mut paths = parts.map(|entry| entry.expect("an entry").path());
    let scene = paths.find(|path| path.extension().is_some_and(|end| end == "toml"));
    std::fs::remove_file(scene.expect("a scene")).expect("it is removed");
    let (code, _, stderr) = place.merge("out");
    assert_eq!(code, Some(3), "{stderr}");
    assert!(stderr.contains("copy of the scene") && stderr.contains("--resume"), "{stderr}");
}

/// Studies and runs of one folder are joined one after the other.
#[test]
fn a_merge_joins_studies_and_runs_of_one_folder() {
    let place = Place::new(&runs());
    for task in ["study", "run"] {
        place.run(task, "alone", &[]);
        place.run(task, "shared", &["--shard", "2/2"]);
        place.run(task, "shared", &["--shard", "1/2"]);
    }
    assert!(!place.path("shared/data").exists());
    let merge =
        |more: &[&str]| done(afterbay(&["merge", "--no-png"]).arg(place.path("shared")).args(more));
    for more in [&[][..], &["--run"]] {
        let (code, _, stderr) = merge(more);
        assert_eq!(code, Some(0), "{stderr}");
    }
    assert_eq!(place.tables("shared"), place.tables("alone"));
}

/// The last digits of cells may depend on the processor they were computed for.
#[test]
fn cells_of_another_processor_are_joined_with_a_warning() {
    let place = Place::new(AUTONOMOUS);
    for shard in ["1/2", "2/2"] {
        place.run("study", "out", &["--shard", shard]);
    }
    let merged = |warned: bool| {
        let (code, _, stderr) = place.merge("out");
        assert_eq!(code, Some(0), "{stderr}");
        assert_eq!(stderr.contains("processors with other features"), warned, "{stderr}");
        place.tables("out")
    };
    let tables = merged(false);
    let file = place.path("out").join("parts/1-of-2.jsonl");
    let journal = std::fs::read_to_string(&file).expect("a journal");
    let other = journal.replacen("\"features\":\"", "\"features\":\"mmx ", 1);
    assert_ne!(journal, other);
    std::fs::write(&file, other).expect("it is written");
    assert_eq!(merged(true), tables);
}
