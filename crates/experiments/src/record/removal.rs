//! The removal of results, where those of another scene take their place.

use super::{Held, StorageError};
use crate::data::Sidecar;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Removes the results that afterbay wrote to a folder, and no other file: the tables that have a
/// sidecar of afterbay, the figures that `run.json` lists, the report and, at last, `run.json`,
/// which says until then that the others are results.
pub(crate) fn remove(folder: &Path) -> Result<(), StorageError> {
    let Some(held) = Held::read(folder) else { return Ok(()) };
    for table in sidecars(&folder.join("data")) {
        remove_tables(&table)?;
    }
    for name in held.figures.iter().map(Path::new) {
        // Another program may have changed the list.
        if name.starts_with("figures") && name.components().all(is_name) {
            remove_file(&folder.join(name))?;
            remove_file(&folder.join(name).with_extension("png"))?;
        }
    }
    remove_file(&folder.join("report.html"))?;
    remove_file(&folder.join("run.json"))
}

fn is_name(component: Component<'_>) -> bool {
    matches!(component, Component::Normal(_))
}

/// The JSON files of a folder and of those below it. Links to folders are not followed.
fn sidecars(data: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(data).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            found.extend(sidecars(&path));
        } else if path.extension().is_some_and(|found| found == "json") {
            found.push(path);
        }
    }
    found
}

/// Removes a table and its sidecar, if the sidecar is one of afterbay.
fn remove_tables(sidecar: &Path) -> Result<(), StorageError> {
    let Some(found) = Sidecar::read(sidecar).ok().filter(Sidecar::is_ours) else { return Ok(()) };
    remove_file(&sidecar.with_extension(found.format.extension()))?;
    remove_file(sidecar)
}

/// Removes a file if it is there.
fn remove_file(path: &Path) -> Result<(), StorageError> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(StorageError::File { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::remove;
    use crate::artifact::Artifact;
    use crate::data::Files;
    use crate::manifest::Manifest;
    use crate::record::Output;
    use crate::report::Report;

    #[test]
    fn what_others_put_beside_the_results_stays() {
        let root = tempfile::tempdir().unwrap();
        let artifact = |name: &str| Artifact { name: name.into(), ..Artifact::default() };
        let artifacts = vec![
            Artifact { text: "t\n1\n".into(), ..artifact("data/trajectory.csv") },
            Artifact { text: "t\n1\n".into(), ..artifact("data/duffing/energy.csv") },
            artifact("figures/energy.svg"),
        ];
        let (title, subtitle) = (String::new(), String::new());
        let report = Report { title, subtitle, sections: Vec::new() };
        let manifest = Manifest::new("run", serde_json::json!({}), Vec::new());
        let output = Output { report, artifacts, manifest };
        output.write(root.path(), Files::default()).unwrap();
        for name in ["data/own.csv", "data/own.json", "figures/own.svg", "notes.txt"] {
            std::fs::write(root.path().join(name), "mine").unwrap();
        }
        std::fs::write(root.path().join("figures/energy.png"), "drawn").unwrap();
        remove(root.path()).unwrap();
        let names = |below: &str| {
            let entries = std::fs::read_dir(root.path().join(below)).unwrap();
            let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
            names.sort();
            names
        };
        assert_eq!(names(""), ["data", "figures", "notes.txt"]);
        assert_eq!(names("data"), ["duffing", "own.csv", "own.json"]);
        assert!(names("data/duffing").is_empty());
        assert_eq!(names("figures"), ["own.svg"]);
    }
}
