//! Ctrl-C and SIGTERM.

use super::{afterbay, done};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A chain whose run takes too long to wait for.
fn chain(n: usize) -> String {
    let zeros = vec!["0"; n - 1].join(", ");
    format!(
        "[system]\nname = \"fput-chain\"\nparameters = {{ n = {n}, beta = 0.3, c = 0.01 }}\n\
         [initial]\nq = [1, {zeros}]\np = [0, {zeros}]\n[time]\nend = 4000\nstep = 0.01\n\
         [run]\nmethods = [\"increment-2\", \"collocation-8\"]\nevery = 4000\n"
    )
}

#[test]
fn ctrl_c_ends_a_run_within_a_second_with_what_was_done() {
    interrupted_by("INT", 130);
}

#[test]
fn sigterm_ends_a_run_within_a_second_with_what_was_done() {
    interrupted_by("TERM", 143);
}

#[test]
fn a_stopped_share_says_how_much_of_it_is_finished() {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, _) = stopped("TERM", folder.path(), &["--shard", "1/2"]);
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(143), "{stdout}");
    assert!(stdout.contains("Share 1/2: 0 of 1 cell finished"), "{stdout}");
    assert!(!stdout.contains("afterbay merge"), "{stdout}");
}

/// Starts a long run in a folder and sends it a signal. Returns its output and how long it took to
/// end.
fn stopped(signal: &str, folder: &Path, more: &[&str]) -> (Output, Duration) {
    let (scene, out) = (folder.join("chain.toml"), folder.join("out"));
    std::fs::write(&scene, chain(2000)).expect("a scene");
    let mut command = afterbay(&["run", "--out"]);
    command.arg(&out).arg(&scene).args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().expect("it starts");
    // The folder is made just before the handler is installed and the first step is taken.
    let patience = Instant::now();
    while !out.exists() && patience.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(700));
    let clock = Instant::now();
    let (sent, ..) =
        done(Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]));
    assert_eq!(sent, Some(0), "the signal is sent");
    let output = child.wait_with_output().expect("it ends");
    (output, clock.elapsed())
}

fn interrupted_by(signal: &str, code: i32) {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let (output, took) = stopped(signal, folder.path(), &[]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    assert!(took < Duration::from_secs(5), "{took:?}");
    assert!(stderr.contains("Stopping; interrupt once more to stop at once."), "{stderr}");

    let mut table = csv::Reader::from_path(out.join("data/trajectory.csv")).expect("a table");
    let rows: Vec<_> = table.records().map(|row| row.expect("a row")).collect();
    assert!(
        rows.len() >= 2 && rows.iter().all(|row| row.len() == 3 + 3 * 2000 + 2),
        "{}",
        rows.len()
    );
    let numbers = rows.iter().flat_map(|row| row.iter().skip(1));
    assert!(numbers.into_iter().all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite)));
    let record = std::fs::read_to_string(out.join("run.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    let runs = record["runs"].as_array().expect("a list");
    assert!(runs.len() == 2 && runs.iter().all(|run| run["outcome"] == "interrupted"), "{runs:?}");
    assert!(out.join("report.html").exists());
}

#[test]
fn ctrl_c_ends_a_pick_within_a_second_and_it_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, out) = (folder.path().join("chain.toml"), folder.path().join("out"));
    std::fs::write(&scene, chain(60)).expect("a scene");
    let mut command = afterbay(&["pick", "--error", "1e-9", "--out"]);
    let child = command.arg(&out).arg(&scene).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = child.spawn().expect("it starts");
    let patience = Instant::now();
    while !out.exists() && patience.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(1000));
    let clock = Instant::now();
    let (code, ..) = done(Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]));
    assert_eq!(code, Some(0), "the signal is sent");
    let output = child.wait_with_output().expect("it ends");
    let took = clock.elapsed();
    let [stdout, stderr] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert_eq!(output.status.code(), Some(130), "{stderr}");
    // One second; the rest is for a machine that is busy with other tests.
    assert!(took < Duration::from_secs(3), "{took:?}");
    assert!(stdout.contains("The search was interrupted"), "{stdout}");
    assert!(!stdout.contains("No method was found within"), "{stdout}");
    let report = std::fs::read_to_string(out.join("report.html")).expect("a report");
    assert!(report.contains("the search was interrupted"));
}
