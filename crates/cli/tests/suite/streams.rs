//! Trajectories whose states are too many for memory: their tables, from one command and from
//! several.

use super::{afterbay, done};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

const SCENE: &str = r#"
[system]
name = "duffing"
parameters = { alpha = 1.0, beta = 0.5, c = 0.001 }
[initial]
q = [1.0]
p = [0.0]
[time]
end = 300.0
step = 0.01
[run]
methods = ["moddg", "rk4"]
every = 1
"#;

fn command(folder: &Path, out: &str, more: &[&str]) -> std::process::Command {
    let mut command = afterbay(&["run", "--no-png"]);
    command.arg(folder.join("scene.toml")).arg("--out").arg(folder.join(out)).args(more);
    command
}

fn run(folder: &Path, out: &str, more: &[&str]) {
    let (code, _, stderr) = done(&mut command(folder, out, more));
    assert_eq!(code, Some(0), "{more:?}: {stderr}");
}

fn scene() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scene.toml"), SCENE).expect("a scene");
    let path = folder.path().to_owned();
    (folder, path)
}

fn table(folder: &Path, out: &str, format: &str) -> Vec<u8> {
    std::fs::read(folder.join(out).join(format!("data/trajectory.{format}"))).expect("a table")
}

#[test]
fn shares_and_resumed_commands_write_the_bytes_of_one() {
    let (_folder, path) = scene();
    run(&path, "alone", &[]);
    for shard in ["2/2", "1/2"] {
        run(&path, "shared", &["--shard", shard]);
    }
    let parts = path.join("shared/parts-of-run");
    for (number, method) in [(1, "moddg"), (2, "rk4")] {
        let size = |name: &str| std::fs::metadata(parts.join(name)).expect("a file").len();
        let rows = size(&format!("{number}-of-2.{method}.rows"));
        let journal = size(&format!("{number}-of-2.jsonl"));
        assert!(rows > 2_000_000 && journal < 100_000, "{rows}, {journal}");
    }
    for format in ["csv", "npy", "jsonl"] {
        run(&path, "alone", &["--resume", "--data", format]);
        let mut merge = afterbay(&["merge", "--no-png", "--data", format]);
        let (code, _, stderr) = done(merge.arg(path.join("shared")));
        assert_eq!(code, Some(0), "{stderr}");
        let [alone, shared] = ["alone", "shared"].map(|out| table(&path, out, format));
        assert!(alone.len() > 2_000_000 && alone == shared, "{format}: the tables differ");
        let sidecar = |out| table(&path, out, "json");
        assert!(sidecar("alone") == sidecar("shared"));
        let text = String::from_utf8(sidecar("alone")).expect("text");
        assert!(text.contains("\"rows\": 60002"), "{text}");
    }
}

#[test]
fn killed_commands_leave_no_table_and_are_completed() {
    let (_folder, path) = scene();
    let begin = Instant::now();
    run(&path, "whole", &[]);
    let (time, whole) = (begin.elapsed(), table(&path, "whole", "csv"));
    for share in [0.2, 0.5, 0.8] {
        let mut started = command(&path, "killed", &["--resume"]);
        let started = started.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut child = started.expect("it starts");
        std::thread::sleep(time.mul_f64(share));
        child.kill().expect("it is killed");
        child.wait().expect("it ends");
        let file = path.join("killed/data/trajectory.csv");
        assert!(!file.exists() || table(&path, "killed", "csv") == whole, "a part of a table");
    }
    run(&path, "killed", &["--resume"]);
    assert!(table(&path, "killed", "csv") == whole, "the tables differ");
}

#[test]
fn states_that_were_changed_are_refused_by_name() {
    let (_folder, path) = scene();
    run(&path, "out", &[]);
    let file = path.join("out/parts-of-run/1-of-1.rk4.rows");
    let mut bytes = std::fs::read(&file).expect("a file");
    let digit = bytes.iter().rposition(u8::is_ascii_digit).expect("a digit");
    bytes[digit] = if bytes[digit] == b'1' { b'2' } else { b'1' };
    std::fs::write(&file, bytes).expect("it is written");
    let (code, _, stderr) = done(&mut command(&path, "out", &["--resume"]));
    assert!(code == Some(5) && stderr.contains("1-of-1.rk4.rows was changed"), "{stderr}");
    run(&path, "out", &["--force"]);
}
