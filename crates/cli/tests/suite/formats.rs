//! Tables in all formats: the same numbers, each with a sidecar, and one format at a time.

use super::{afterbay, done};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// A chain whose masses have units, with a method that ends early.
const SCENE: &str = r#"
[system]
name = "fput-chain"
parameters = { n = 2, beta = 1.0, c = 0.1 }
[initial]
q = [1.0, -0.5]
p = [0.0, 0.25]
[time]
end = 4.0
step = 0.1
[units]
q = "m"
time = "s"
[run]
methods = ["increment-2", "rk4"]
[study.global-order]
methods = ["increment-2", "rk4"]
steps = [0.2, 0.1]
"#;

fn written(folder: &Path, command: &str, format: &str) {
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, SCENE).expect("a scene");
    let mut command = afterbay(&[command, "--no-png", "--force", "--data", format]);
    let (code, _, stderr) = done(command.arg(scene).arg("--out").arg(folder.join(format)));
    assert_eq!(code, Some(0), "{stderr}");
}

fn names(folder: &Path) -> BTreeSet<String> {
    let files = std::fs::read_dir(folder).expect("a folder").flatten();
    files.map(|file| file.file_name().to_string_lossy().into_owned()).collect()
}

fn sidecar(path: &Path) -> Value {
    let text = std::fs::read(path).expect("a sidecar");
    serde_json::from_slice(&text).expect("JSON")
}

/// The numbers of a NumPy array of shape (rows, columns), read as its format defines it.
fn numbers(path: &Path) -> (String, Vec<f64>) {
    let bytes = std::fs::read(path).expect("an array");
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00", "its magic string and version");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (header, body) = bytes[10..].split_at(length);
    let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    (String::from_utf8_lossy(header).into_owned(), body.chunks(8).map(number).collect())
}

#[test]
fn the_formats_have_the_same_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    for format in ["csv", "npy", "jsonl"] {
        written(folder.path(), "run", format);
        let data = folder.path().join(format).join("data");
        let file = format!("trajectory.{format}");
        assert_eq!(names(&data), BTreeSet::from([file, "trajectory.json".into()]));
        let report = folder.path().join(format).join("report.html");
        let report = std::fs::read_to_string(report).expect("a report");
        assert!(report.contains(&format!("data/trajectory.{format}")), "{format}");
    }
    let of = |format: &str| folder.path().join(format);
    let mut csv = csv::Reader::from_path(of("csv").join("data/trajectory.csv")).expect("a table");
    let rows: Vec<_> = csv.records().map(|row| row.expect("a row")).collect();

    let described = sidecar(&of("npy").join("data/trajectory.json"));
    let columns = described["columns"].as_array().expect("columns");
    let (header, array) = numbers(&of("npy").join("data/trajectory.npy"));
    let shape = format!("'shape': ({}, {}", rows.len(), columns.len());
    assert!(header.contains("'descr': '<f8'") && header.contains(&shape), "{header}");
    let words = columns[0]["words"].as_array().expect("the names of methods");
    for (row, numbers) in rows.iter().zip(array.chunks(columns.len())) {
        assert_eq!(words[numbers[0] as usize], row[0]);
        for (cell, number) in row.iter().zip(numbers).skip(1) {
            assert_eq!(cell.parse::<f64>().expect("a number").to_bits(), number.to_bits());
        }
    }
    let unit = |name: &str| {
        let column = columns.iter().find(|column| column["name"] == name).expect("a column");
        column["unit"].as_str().map(str::to_owned)
    };
    assert_eq!([unit("t"), unit("q2"), unit("K")], [Some("s".into()), Some("m".into()), None]);
    let record = sidecar(&of("npy").join("run.json"));
    assert_eq!(described["provenance"]["scene"], record["hash"]);
    assert_eq!(described["provenance"]["command"], "run");

    let text = std::fs::read_to_string(of("jsonl").join("data/trajectory.jsonl")).expect("a table");
    assert_eq!(text.lines().count(), rows.len());
    for (row, line) in rows.iter().zip(text.lines()) {
        let line: Value = serde_json::from_str(line).expect("an object");
        assert_eq!(line["method"], row[0]);
        let q2: f64 = row[4].parse().expect("a number");
        assert_eq!(line["q2"].as_f64().map(f64::to_bits), Some(q2.to_bits()));
    }

    for other in ["npy", "jsonl"] {
        let mut compare = afterbay(&["compare", "--no-png", "--format", "json"]);
        let out = folder.path().join(format!("csv-{other}"));
        compare.arg(of("csv")).arg(of(other)).arg("--out").arg(out);
        let (code, stdout, stderr) = done(&mut compare);
        assert_eq!(code, Some(0), "{stderr}");
        let found: Value = serde_json::from_str(&stdout).expect("JSON");
        let readings = found.to_string();
        assert!(readings.contains("nothing differs. Compared: 82 rows of 1 table"), "{readings}");
    }
}

#[test]
fn a_table_has_one_format_at_a_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, SCENE).expect("a scene");
    let out = folder.path().join("out");
    for format in ["csv", "npy", "jsonl", "csv"] {
        let mut study = afterbay(&["study", "--no-png", "--force", "--data", format]);
        let (code, _, stderr) = done(study.arg(&scene).arg("--out").arg(&out));
        assert_eq!(code, Some(0), "{stderr}");
        let found = names(&out.join("data"));
        let expected = [format!("global_orders.{format}"), "global_orders.json".into()];
        assert_eq!(found, BTreeSet::from(expected));
    }
}
