//! Files that another program has in the folder of the results.

use super::Held;
use crate::data::DataFormat;
use std::path::{Path, PathBuf};

/// A file that results could replace or delete, in a folder without a record of afterbay. The names
/// of tables and figures are not known before they are made, so all files of their kinds count.
pub(super) fn foreign(folder: &Path) -> Option<PathBuf> {
    if Held::read(folder).is_some() {
        return None;
    }
    let tables: Vec<&str> =
        DataFormat::ALL.map(DataFormat::extension).into_iter().chain(["json"]).collect();
    let named = ["run.json", "report.html"].map(|name| folder.join(name));
    named
        .into_iter()
        .find(|path| path.exists())
        .or_else(|| of_kinds(&folder.join("data"), &tables))
        .or_else(|| of_kinds(&folder.join("figures"), &["svg", "png"]))
}

/// The first file by name with one of these extensions.
fn of_kinds(folder: &Path, extensions: &[&str]) -> Option<PathBuf> {
    let paths = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let counts = |path: &PathBuf| {
        path.extension().is_some_and(|found| extensions.iter().any(|kind| found == *kind))
    };
    paths.filter(counts).min()
}

#[cfg(test)]
mod tests {
    use crate::record::{StorageError, prepare};

    #[test]
    fn a_folder_with_tables_or_figures_of_others_is_refused() {
        let root = tempfile::tempdir().unwrap();
        let names = ["data/trajectory.csv", "data/own.npy", "data/a.json", "figures/energy.png"];
        for (nth, name) in names.into_iter().enumerate() {
            let folder = root.path().join(nth.to_string());
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "mine").unwrap();
            match prepare(&folder) {
                Err(StorageError::Foreign { path: found }) => assert_eq!(found, path),
                other => panic!("{name}: {other:?}"),
            }
            std::fs::write(folder.join("run.json"), r#"{"command":"run","hash":"0"}"#).unwrap();
            prepare(&folder).unwrap();
        }
        let folder = root.path().join("else");
        std::fs::create_dir_all(folder.join("data")).unwrap();
        std::fs::write(folder.join("data/notes.md"), "mine").unwrap();
        prepare(&folder).unwrap();
    }
}
