//! `afterbay compare`: two results, their scenes, their rows, and what is refused.

use crate::afterbay;
use assert_cmd::prelude::OutputAssertExt;
use predicates::prelude::{PredicateBooleanExt, predicate};
use predicates::str::contains;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The oscillator with b = B and the methods M.
const OSCILLATOR: &str = r#"
[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = B }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 2.0
step = 0.1
[run]
methods = [M]
[study.global-order]
steps = [0.1, 0.05]
methods = [M]
[study.work-precision]
steps = [0.1, 0.05]
methods = [M]
"#;

/// A chain of N masses.
const CHAIN: &str = r#"
[system]
name = "fput-chain"
parameters = { n = N, beta = 1.0, c = 0.1 }
[initial]
q = "sin(i)"
p = "0"
[time]
end = 2.0
step = 0.1
[run]
methods = ["rk4", "increment-2"]
"#;

/// Results in a folder of their own.
struct Results(TempDir);

impl Results {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a command on a scene, and gives the folder of its results.
    fn of(&self, command: &str, name: &str, scene: &str) -> PathBuf {
        let (file, out) = (self.path(&format!("{name}.toml")), self.path(name));
        std::fs::write(&file, scene).expect("a scene");
        afterbay(&[command, "--no-png"]).arg(&file).arg("--out").arg(&out).assert().success();
        out
    }

    fn oscillator(&self, command: &str, name: &str, b: &str, methods: &str) -> PathBuf {
        self.of(
            command,
            name,
            &OSCILLATOR
                .replace("b = B", &format!("b = {b}"))
                .replace("[M]", &format!("[{methods}]")),
        )
    }

    /// The command that compares two results.
    fn compare(&self, a: &Path, b: &Path) -> Command {
        let mut command = afterbay(&["compare", "--no-png"]);
        command.arg(a).arg(b).arg("--out").arg(self.path("compared"));
        command
    }

    /// What the comparison prints as JSON.
    fn json(&self, a: &Path, b: &Path) -> Value {
        let mut command = self.compare(a, b);
        let output = command.args(["--format", "json"]).assert().success();
        serde_json::from_slice(&output.get_output().stdout).expect("JSON and nothing else")
    }

    /// A table of the comparison.
    fn table(&self, name: &str) -> Vec<Vec<String>> {
        let path = self.path("compared/data").join(format!("{name}.csv"));
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).expect(name);
        let cells = |row: csv::StringRecord| row.iter().map(str::to_owned).collect();
        reader.records().map(|row| cells(row.expect("a row"))).collect()
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path("compared").join(name)).expect(name)
    }
}

/// The part of the JSON that is about one table.
fn of_table<'a>(summary: &'a Value, name: &str) -> &'a Value {
    let tables = summary["tables"].as_array().expect("a list");
    tables.iter().find(|table| table["name"] == name).expect(name)
}

/// The column of a table that has a header.
fn column(table: &[Vec<String>], name: &str) -> Vec<f64> {
    let at = table[0].iter().position(|other| other == name).expect(name);
    table[1..].iter().map(|row| row[at].parse().expect("a number")).collect()
}

#[test]
fn a_result_does_not_differ_from_itself() {
    let results = Results::new();
    let a = results.oscillator("run", "a", "0.1", r#""rk4", "moddg""#);
    results
        .compare(&a, &a)
        .assert()
        .success()
        .stdout(
            contains("The results: nothing differs. Compared: 42 rows of 1 table.")
                .and(contains("The scenes are equal."))
                .and(contains("report.html"))
                .and(contains("they differ").not()),
        )
        .stderr(predicate::str::is_empty());
    assert!(results.read("report.html").starts_with("<!DOCTYPE html>"));
    let manifest: Value = serde_json::from_str(&results.read("run.json")).expect("JSON");
    assert_eq!(manifest["command"], "compare");
    assert_eq!(manifest["scene"]["a"], manifest["scene"]["b"]);
    assert_eq!(results.table("trajectory").len(), 43);
    assert!(!results.path("compared/figures").exists());

    let study = results.oscillator("study", "s", "0.1", r#""rk4""#);
    let mut again = results.compare(&study, &study);
    again.arg("--force").assert().success().stdout(contains("The results: nothing differs. "));
}

#[test]
fn times_are_compared_by_their_ratio_and_are_no_difference() {
    let results = Results::new();
    let a = results.oscillator("study", "a", "0.1", r#""rk4", "moddg""#);
    let b = results.oscillator("study", "b", "0.1", r#""rk4", "moddg""#);
    let summary = results.json(&a, &b);
    let said = summary["findings"][0]["statement"].as_str().expect("a sentence");
    // Some of the times may be the same by chance.
    assert!(said.starts_with("nothing differs"), "{said}");
    assert_eq!(summary["scene"], json!([]));
    let table = results.table("work_precision");
    let ratios = column(&table, "seconds_ratio");
    let times = column(&table, "seconds_b").into_iter().zip(column(&table, "seconds_a"));
    let expected: Vec<_> = times.map(|(b, a)| b / a).collect();
    assert_eq!((ratios.len(), ratios), (4, expected));
    assert!(!table[0].iter().any(|name| name == "seconds_difference"), "{:?}", table[0]);
}

#[test]
fn a_changed_parameter_is_named_and_so_is_what_follows_from_it() {
    let results = Results::new();
    let a = results.oscillator("run", "a", "0.1", r#""rk4", "moddg""#);
    let b = results.oscillator("run", "b", "0.2", r#""rk4", "moddg""#);
    let summary = results.json(&a, &b);
    let key = json!([{ "key": "system.parameters.b", "a": "0.1", "b": "0.2" }]);
    assert_eq!(summary["scene"], key);
    let joined = of_table(&summary, "trajectory");
    assert_eq!((&joined["rows"], &joined["rows_in_one"]), (&json!(42), &json!([0, 0])));
    assert_eq!(joined["keys"], json!(["method", "t"]));

    // What is joined are the rows of the two tables, and their differences.
    let table = results.table("trajectory");
    let [a_s, b_s] = ["q1_a", "q1_b"].map(|name| column(&table, name));
    let expected: Vec<_> = a_s.iter().zip(&b_s).map(|(a, b)| b - a).collect();
    assert_eq!(column(&table, "q1_difference"), expected);
    let mut of_b = csv::Reader::from_path(b.join("data/trajectory.csv")).expect("a table");
    let at = of_b.headers().expect("a header").iter().position(|name| name == "q1").expect("q1");
    let of_b: Vec<f64> =
        of_b.records().map(|row| row.expect("a row")[at].parse().expect("a number")).collect();
    assert_eq!(b_s, of_b);

    // The sentence states the largest difference of rk4, and when.
    let times = column(&table, "t");
    let rk4 = expected.iter().zip(&times).take(21).map(|(x, t)| (x.abs(), *t));
    let (most, when) = rk4.reduce(|a, b| if b.0 > a.0 { b } else { a }).expect("rows");
    let said = summary["findings"][1]["statement"].as_str().expect("a sentence");
    let part = format!("rk4 at 21 common times, q by {most:.1e} (t = {when})");
    assert!(said.contains(&part), "{part} in {said}");

    // One chart has the curves of both.
    let chart = results.read("figures/trajectory-q1-against-t.svg");
    for label in ["rk4", "moddg", ">A<", ">B<"] {
        assert!(chart.contains(label), "{label}");
    }
    results.compare(&a, &b).assert().success().stdout(
        contains("system.parameters.b").and(contains("they differ in ")).and(contains("NaN").not()),
    );
}

#[test]
fn rows_of_different_methods_are_in_one_only() {
    let results = Results::new();
    let a = results.oscillator("run", "a", "0.1", r#""rk4", "moddg""#);
    let b = results.oscillator("run", "b", "0.1", r#""leapfrog", "rk4""#);
    let summary = results.json(&a, &b);
    assert_eq!(summary["scene"][0]["a"], r#"["rk4","moddg"]"#);
    let joined = of_table(&summary, "trajectory");
    assert_eq!((&joined["rows"], &joined["rows_in_one"]), (&json!(21), &json!([21, 21])));
    assert!(results.table("trajectory")[1..].iter().all(|row| row[0] == "rk4"));
    let chart = results.read("figures/trajectory-q1-against-t.svg");
    for label in ["rk4", "moddg", "leapfrog", ">A<", ">B<"] {
        assert!(chart.contains(label), "{label}");
    }

    // Without a method in common there is nothing to join, and this is said.
    let c = results.oscillator("run", "c", "0.1", r#""leapfrog""#);
    let mut disjoint = results.compare(&a, &c);
    disjoint.arg("--force").assert().success().stdout(
        contains("no common times").and(contains("0 rows of 1 table.")).and(contains("NaN").not()),
    );
    assert_eq!(results.table("trajectory").len(), 1);
}

#[test]
fn chains_of_different_lengths_are_compared_where_both_are() {
    let results = Results::new();
    let [a, b] = ["2", "4"].map(|n| {
        results.of("run", &format!("chain-{n}"), &CHAIN.replace("n = N", &format!("n = {n}")))
    });
    let summary = results.json(&a, &b);
    let joined = of_table(&summary, "trajectory");
    assert_eq!(joined["rows"], 42);
    assert_eq!(joined["columns_in_one"][0], json!([]));
    let in_b = ["q3", "q4", "p3", "p4", "w3", "w4"];
    assert!(in_b.iter().all(|name| joined["columns_in_one"][1].to_string().contains(name)));
    let table = results.table("trajectory");
    assert!(table[0].contains(&"q2_difference".into()) && !table[0].contains(&"q3_a".into()));
    assert!(table.iter().flatten().all(|cell| cell != "NaN" && cell != "inf"));
    results
        .compare(&a, &b)
        .assert()
        .success()
        .stdout(contains("system.parameters.n").and(contains("6 columns in one only")));
}

#[test]
fn a_method_that_fails_in_one_result_leaves_no_nan() {
    let results = Results::new();
    let scene = |step: &str| {
        OSCILLATOR
            .replace("b = B", "b = 200.0")
            .replace("[M]", r#"["rk4"]"#)
            .replace("end = 2.0\nstep = 0.1", &format!("end = 20.0\nstep = {step}"))
    };
    let a = results.of("run", "a", &scene("0.01"));
    std::fs::write(results.path("b.toml"), scene("0.1")).expect("a scene");
    let b = results.path("b");
    let mut failing = afterbay(&["run"]);
    failing.arg(results.path("b.toml")).arg("--out").arg(&b).assert().code(4);
    let summary = results.json(&a, &b).to_string();
    assert!(!summary.contains("NaN") && !summary.contains("inf"), "{summary}");
    let table = results.table("trajectory");
    assert!(table.iter().flatten().all(|cell| cell != "NaN" && cell != "inf"));
    assert!(results.read("report.html").contains("1 not-finite"));
}

/// Not even with --force.
#[test]
fn a_comparison_does_not_replace_what_it_compares() {
    let results = Results::new();
    let a = results.oscillator("run", "a", "0.1", r#""rk4""#);
    let b = results.oscillator("run", "b", "0.2", r#""rk4""#);
    for out in [&a, &b] {
        let mut command = afterbay(&["compare", "--force"]);
        let refused = command.arg(&a).arg(&b).arg("--out").arg(out).assert().code(5);
        refused.stderr(contains("is one of the two results").and(contains("--out DIR")));
    }
    results.compare(&a, &b).assert().success();
}

#[test]
fn what_is_no_result_is_refused() {
    let results = Results::new();
    let good = results.oscillator("run", "good", "0.1", r#""rk4""#);
    let study = results.oscillator("study", "study", "0.1", r#""rk4""#);
    let broken = results.oscillator("run", "broken", "0.2", r#""rk4""#);
    std::fs::write(broken.join("data/trajectory.csv"), "method,t\nrk4,0,1\n").expect("a table");
    let bare = results.oscillator("run", "bare", "0.3", r#""rk4""#);
    std::fs::remove_dir_all(bare.join("data")).expect("it is there");
    let [empty, foreign, cut] = ["empty", "foreign", "cut"].map(|name| {
        let folder = results.path(name);
        std::fs::create_dir(&folder).expect("a folder");
        folder
    });
    std::fs::write(foreign.join("run.json"), r#"{"command": "run", "of": "others"}"#).expect("it");
    std::fs::write(cut.join("run.json"), r#"{"version": "0.1.0", "comm"#).expect("it");
    let compared = results.path("once");
    afterbay(&["compare"]).arg(&good).arg(&good).arg("--out").arg(&compared).assert().success();

    for (folder, message) in [
        (results.path("missing"), "there is no folder"),
        (results.path("good.toml"), "there is no folder"),
        (empty, "its run.json cannot be read"),
        (foreign, "its run.json is not that of a run"),
        (cut, "its run.json is not that of a run"),
        (broken, "trajectory.csv cannot be read"),
        (bare, "data cannot be read"),
        (compared, "is a result of `compare`"),
        (study, "no table in common"),
    ] {
        for [a, b] in [[&good, &folder], [&folder, &good]] {
            let mut command = results.compare(a, b);
            let output = command.args(["--format", "json"]).assert().code(3);
            let output = output.get_output();
            let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert_eq!(found["exit_code"], 3, "{message}");
            let cause = found["causes"][0].as_str().expect("a cause");
            assert!(cause.contains(message), "{message} in {cause}");
            assert!(found["help"].as_str().is_some_and(|help| !help.is_empty()), "{message}");
            assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
        }
    }
    assert!(!results.path("compared").exists(), "nothing is written");
}

#[test]
fn other_results_are_overwritten_by_force_alone() {
    let results = Results::new();
    let a = results.oscillator("run", "a", "0.1", r#""rk4""#);
    let b = results.oscillator("run", "b", "0.2", r#""rk4""#);
    results.compare(&a, &b).assert().success();
    results.compare(&a, &b).assert().success();
    let other = results.compare(&b, &a).assert().code(5);
    other.stderr(contains("holds the results of").and(contains("--force")));
    results.compare(&b, &a).arg("--force").assert().success();
    // The results that are compared are others too.
    let manifest = std::fs::read_to_string(a.join("run.json")).expect("it");
    afterbay(&["compare"]).arg(&a).arg(&b).arg("--out").arg(&a).assert().code(5);
    assert_eq!(std::fs::read_to_string(a.join("run.json")).expect("it"), manifest);
}
