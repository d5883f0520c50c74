//! Results are the same to the bit for any number of threads.

use super::timeless::timeless;
use super::{afterbay, done, folder};
use std::collections::BTreeMap;
use std::path::Path;

/// Every table, figure and manifest, without the parts that depend on the clock or on the threads.
fn results(command: &str, scene: &str, threads: &str) -> BTreeMap<String, Vec<u8>> {
    let out = tempfile::tempdir().expect("a folder");
    let mut run = afterbay(&[command, "--threads", threads]);
    // The PNG files of one scene show that they do not depend on the threads either.
    run.args((scene != "fput-chain.toml").then_some("--no-png"));
    let (code, _, stderr) = done(run.arg("--out").arg(out.path()).arg(folder().join(scene)));
    assert_eq!(code, Some(0), "{stderr}");
    let mut files = BTreeMap::new();
    for part in ["data", "figures"] {
        for file in std::fs::read_dir(out.path().join(part)).expect("a folder").flatten() {
            let name = format!("{part}/{}", file.file_name().to_string_lossy());
            // Charts of measured time.
            if !["figures/work-qp", "figures/work-w"]
                .contains(&name.split('.').next().unwrap_or(""))
            {
                files.insert(name, contents(&file.path()));
            }
        }
    }
    let record = std::fs::read_to_string(out.path().join("run.json")).expect("written");
    let mut record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    assert_eq!(record["threads"].to_string(), threads);
    record["threads"].take();
    files.insert("run.json".into(), record.to_string().into_bytes());
    files
}

/// The contents of a file. The column `seconds` of a table is left out.
fn contents(path: &Path) -> Vec<u8> {
    if path.extension().is_some_and(|extension| extension == "csv") {
        timeless(path).into_bytes()
    } else {
        std::fs::read(path).expect("written")
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    for (command, scene) in [
        ("run", "damped-oscillator.toml"),
        ("study", "damped-oscillator.toml"),
        ("run", "fput-chain.toml"),
        ("study", "friction-matrix.toml"),
    ] {
        let one = results(command, scene, "1");
        assert!(one.len() > 3, "{:?}", one.keys());
        for threads in ["2", "5", "16"] {
            let other = results(command, scene, threads);
            assert!(one.keys().eq(other.keys()));
            for (name, contents) in &one {
                assert!(
                    *contents == other[name],
                    "{command} {scene}: {name} differs with {threads} threads"
                );
            }
        }
    }
}
