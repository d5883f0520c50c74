//! The command as users see it: its output, its files and its exit codes.

use crate::afterbay;
use crate::timeless::timeless;
use assert_cmd::Command;
use assert_cmd::prelude::OutputAssertExt;
use predicates::prelude::{PredicateBooleanExt, predicate};
use predicates::str::contains;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).expect("the file is written")
}

/// The quick paper, once in words by five threads and once in JSON by one.
#[test]
fn the_paper_writes_everything_and_says_what_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let paper = |more: &[&str]| {
        let mut command = afterbay(&["paper", "--quick"]);
        command.args(more).current_dir(folder.path()).env("COLUMNS", "80");
        command.assert().success()
    };
    let (words, json) = std::thread::scope(|scope| {
        let json = scope
            .spawn(|| paper(&["--threads", "1", "--no-png", "--format", "json", "--out", "json"]));
        let words = paper(&["--threads", "5", "--out", "deep/er"]);
        (words, json.join().expect("it is run"))
    });
    let narrow = |text: &str| text.lines().all(|line| line.chars().count() <= 80);
    words
        .stdout(predicate::function(narrow))
        .stdout(contains("does not hold").and(contains("figure 3.1")).and(contains("report.html")))
        .stderr(predicate::str::is_empty());
    let findings: serde_json::Value =
        serde_json::from_slice(&json.get_output().stdout).expect("JSON and nothing else");
    let findings = findings.as_array().expect("a list");
    assert!(findings.len() > 20 && findings.iter().any(|one| one["verdict"] == "fails"));
    let out = folder.path().join("deep/er");
    everything_is_written(&out);
    let charts = |out: &Path, extension: &str| {
        let all = std::fs::read_dir(out.join("figures")).expect("charts").flatten();
        all.filter(|file| file.path().extension().is_some_and(|end| end == extension)).count()
    };
    let without = folder.path().join("json");
    assert!(charts(&out, "svg") > 40 && charts(&without, "svg") == charts(&out, "svg"));
    assert_eq!([charts(&out, "png"), charts(&without, "png")], [charts(&out, "svg"), 0]);
    let (five, one) = (tables(&out.join("data")), tables(&without.join("data")));
    assert!(one.len() >= 32 && one.contains_key("fput-chain/size.csv"), "{:?}", one.keys());
    assert!(one.keys().eq(five.keys()));
    for (name, table) in one {
        assert!(table == five[&name], "{name} differs with 5 threads");
    }
}

fn everything_is_written(out: &Path) {
    assert!(read(&out.join("report.html")).starts_with("<!DOCTYPE html>"));
    let manifest: serde_json::Value =
        serde_json::from_str(&read(&out.join("run.json"))).expect("JSON");
    assert_eq!(manifest["threads"], 5);
    assert_eq!(manifest["scene"]["problem"]["system"]["name"], "damped-oscillator");
    assert_eq!(manifest["scene"]["problem"]["q"], serde_json::json!([2.3]));
    let ring = &manifest["scene"]["many_degrees"][1][1]["system"];
    assert_eq!(
        ring,
        &serde_json::json!({
            "name": "van-der-pol-ring",
            "parameters": {"n": 5, "mu": 1.0, "coupling": 0.5}
        })
    );
    assert_eq!(manifest["hash"].as_str().map(str::len), Some(64));
    let mut orders = csv::Reader::from_path(out.join("data/local_orders.csv")).expect("a table");
    assert_eq!(&orders.headers().expect("a header")[0], "method");
    let leftovers: Vec<_> =
        std::fs::read_dir(out.join("data")).expect("a folder").flatten().collect();
    assert!(
        leftovers.iter().all(|file| !file.file_name().to_string_lossy().starts_with(".afterbay-"))
    );
}

/// The tables of a folder and of the folders in it, by their paths, without measured times.
fn tables(folder: &Path) -> BTreeMap<String, String> {
    let mut tables = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() {
            let inner = self::tables(&path).into_iter();
            tables.extend(inner.map(|(table, text)| (format!("{name}/{table}"), text)));
        } else if name.ends_with(".csv") {
            tables.insert(name, timeless(&path));
        }
    }
    tables
}

#[test]
fn findings_of_a_study_have_words_and_readings_in_json() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/damped-oscillator.toml");
    let output = afterbay(&["study", scene, "--no-png", "--format", "json", "--out"])
        .arg(folder.path())
        .output()
        .expect("runs");
    let answer: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let findings = answer["findings"].as_array().expect("a list");
    assert!(findings.len() > 5, "{findings:?}");
    for one in findings {
        assert!(["holds", "fails", "note"].iter().any(|word| one["verdict"] == *word), "{one}");
        assert!(one["statement"].as_str().is_some_and(|text| !text.is_empty()), "{one}");
        assert!(one["readings"].as_array().is_some_and(|all| !all.is_empty()), "{one}");
    }
}

#[test]
fn list_shows_every_method_and_system() {
    afterbay(&["list", "methods"]).assert().success().stdout(
        contains("leapfrog")
            .and(contains("moddg-p4-single-printed"))
            .and(contains("keeps K"))
            .and(contains("a step costs")),
    );
    afterbay(&["list", "systems"]).assert().success().stdout(contains("modified-van-der-pol"));
    let output = afterbay(&["list", "systems", "--format", "json"]).output().expect("runs");
    let systems: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let systems = systems.as_array().expect("rows");
    for (name, parameters, ranges) in [
        ("fput-chain", &["n", "beta", "c"][..], "n ≥ 1"),
        ("van-der-pol-ring", &["n", "mu", "coupling"], "n ≥ 1 (coupling: κ)"),
        (
            "damped-double-pendulum",
            &["m1", "m2", "l1", "l2", "g", "c1", "c2"],
            "m1, m2, l1, l2 > 0",
        ),
    ] {
        let row = systems.iter().find(|row| row["name"] == name).expect("a row");
        assert_eq!(row["parameters"], serde_json::json!(parameters), "{name}");
        assert_eq!(row["ranges"], ranges, "{name}");
    }
    let output = afterbay(&["list", "methods", "--format", "json"]).output().expect("runs");
    let methods: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let moddg = methods
        .as_array()
        .and_then(|all| all.iter().find(|row| row["name"] == "moddg"))
        .expect("a row");
    assert_eq!((&moddg["order"], &moddg["keeps_k"]), (&2.into(), &true.into()));
    assert_eq!((&moddg["a_stable"], &moddg["l_stable"]), (&true.into(), &false.into()));
    assert_eq!(moddg["cost"], "scalar equations, 1 sweep");
}

#[test]
fn the_table_of_the_readme_is_that_of_the_registry() {
    let readme = include_str!("../../../../README.md");
    let output = afterbay(&["list", "methods", "--format", "json"]).output().expect("runs");
    let methods: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for row in
        methods.as_array().expect("rows").iter().filter(|row| row["needs"] != "damped oscillator")
    {
        let text = |key: &str| row[key].as_str().map_or(row[key].to_string(), str::to_owned);
        let yes = |key: &str| if row[key] == true { "yes " } else { "" };
        let stable = match (&row["a_stable"], &row["l_stable"]) {
            (a, l) if *a == true && *l == true => "A, L ",
            (a, l) if *a == true && *l == false => "A ",
            (a, l) if *a == false && *l == false => "",
            flags => panic!("{flags:?}"),
        };
        let expected = format!(
            "| `{}` | {} | {} {} {} | {}| {}| {stable}| {} | {} |",
            text("name"),
            text("order"),
            text("local_order_q"),
            text("local_order_p"),
            text("local_order_w"),
            yes("keeps_k"),
            yes("passive"),
            text("cost"),
            text("needs"),
        );
        assert!(readme.contains(&expected), "{expected}");
    }
}

#[test]
fn a_command_line_that_makes_no_sense_is_refused() {
    for arguments in [
        &["papr"][..],
        &["list", "methds"],
        &["paper", "--threads", "0"],
        &["list", "systems", "--threads", "100000"],
        &["paper", "--out"],
        &["list"],
    ] {
        afterbay(arguments).assert().code(2).stdout(predicate::str::is_empty());
    }
    afterbay(&["papr"]).assert().stderr(contains("'paper'"));
    afterbay(&[]).assert().code(2).stderr(contains("Usage"));
}

#[test]
fn results_that_cannot_be_written_are_a_failure_of_storage() {
    let folder = tempfile::tempdir().expect("a folder");
    let occupied = folder.path().join("occupied");
    std::fs::write(&occupied, "a file, not a folder").expect("a file");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/damped-oscillator.toml");
    // The whole paper takes more than a minute, so these must fail before they compute.
    for command in [&["paper"][..], &["run", scene], &["study", scene]] {
        Command::from_std(afterbay(command))
            .arg("--out")
            .arg(&occupied)
            .timeout(Duration::from_secs(30))
            .assert()
            .code(5)
            .stdout(predicate::str::is_empty())
            .stderr(contains("could not be written").and(contains("--out")));
    }
}
