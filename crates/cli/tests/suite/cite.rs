//! `afterbay cite`: each method of a scene with its sources, and entries that BibTeX reads.

use crate::afterbay;
use afterbay_methods::registry::{KOBUS, METHODS};
use assert_cmd::prelude::OutputAssertExt;
use biblatex::Bibliography;
use std::collections::BTreeSet;
use std::path::Path;

/// Methods that are nobody's: the exact flow of a linear system.
const WITHOUT_SOURCE: [&str; 1] = ["linear-exact"];

/// Takes methods from `[run]` and from a study, one of them twice, and one that is added because of
/// the tolerance.
const SCENE: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 20.0
step = 0.01
[run]
methods = ["gonzalez", "linear-exact"]
tolerance = 1e-9
[study.global-order]
methods = ["increment-4", "gonzalez", "increment-6"]
steps = [0.1, 0.05]
"#;

fn cite(scene: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene).expect("a scene");
    let output = afterbay(&["cite"]).arg(&path).args(arguments).assert().success();
    String::from_utf8(output.get_output().stdout.clone()).expect("text")
}

#[test]
fn every_method_has_a_source_or_is_known_to_have_none() {
    let without = METHODS.iter().filter(|row| row.sources.is_empty()).map(|row| row.name);
    assert_eq!(without.collect::<Vec<_>>(), WITHOUT_SOURCE);
}

#[test]
fn every_entry_is_read_by_bibtex_and_has_the_fields_of_its_type() {
    let mut keys = BTreeSet::new();
    let all: BTreeSet<_> = (METHODS.iter().flat_map(|row| row.sources).chain([&KOBUS]))
        .map(|source| (source.key(), source.bibtex()))
        .collect();
    assert!(all.len() > 15);
    for (key, text) in all {
        assert!(keys.insert(key), "{key} stands for two entries");
        let read = Bibliography::parse(text).unwrap_or_else(|error| panic!("{key}: {error}"));
        let entry = read.get(key).unwrap_or_else(|| panic!("{key} is not the key of {text}"));
        assert_eq!(read.len(), 1);
        assert!(entry.author().is_ok_and(|authors| !authors.is_empty()), "{key} has no author");
        assert!(entry.title().is_ok(), "{key} has no title");
        assert!(entry.date().is_ok() || key == KOBUS.key(), "{key} has no year");
        let missing = entry.verify().missing;
        let unknown = missing.iter().all(|field| *field == "year" && key == KOBUS.key());
        assert!(unknown, "{key} lacks {missing:?}");
    }
}

#[test]
fn each_method_is_named_once_and_each_entry_is_there_once() {
    let text = cite(SCENE, &[]);
    for line in [
        "% gonzalez: gonzalez1996",
        "% linear-exact: no source",
        "% adaptive-collocation: butcher1964, hairer2006",
        "% increment-4: itoh1988, suzuki1990",
        "% increment-6: itoh1988, yoshida1990",
    ] {
        assert_eq!(text.lines().filter(|found| *found == line).count(), 1, "{line} in\n{text}");
    }
    let read = Bibliography::parse(&text).expect("BibTeX");
    let keys: Vec<_> = read.iter().map(|entry| entry.key.as_str()).collect();
    assert_eq!(
        keys,
        [
            "afterbay",
            "kobus",
            "gonzalez1996",
            "butcher1964",
            "hairer2006",
            "itoh1988",
            "suzuki1990",
            "yoshida1990"
        ]
    );
    assert_eq!(text.matches("@article{itoh1988").count(), 1);
}

#[test]
fn json_has_the_entries_of_each_method() {
    let text = cite(SCENE, &["--format", "json"]);
    let all: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let all = all.as_array().expect("a list");
    let names: Vec<_> = all.iter().map(|one| one["method"].as_str()).collect();
    let methods =
        ["gonzalez", "linear-exact", "adaptive-collocation", "increment-4", "increment-6"];
    assert_eq!(names[0], None);
    assert_eq!(names[1..], methods.map(Some));
    let counts: Vec<_> = all.iter().map(|one| one["entries"].as_array().map(Vec::len)).collect();
    assert_eq!(counts, [2, 1, 0, 2, 2, 2].map(Some));
}

#[test]
fn the_entry_of_afterbay_is_that_of_the_citation_file() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../CITATION.cff");
    let file = std::fs::read_to_string(file).expect("the file");
    let text = cite(SCENE, &[]).replace(['{', '}'], "");
    let field = |name: &str| {
        let line = file.lines().find_map(|line| line.trim_start().strip_prefix(name));
        line.unwrap_or_else(|| panic!("no {name}")).trim().trim_matches('"').to_owned()
    };
    for part in [
        format!("author = {},", field("- name:")),
        format!("title = {},", field("title:")),
        format!("Version {}", field("version:")),
    ] {
        assert!(text.contains(&part), "{part} in\n{text}");
    }
}
