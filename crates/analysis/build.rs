//! Sets `AFTERBAY_SOURCES` to a hash of the sources that results depend on, so that a journal is
//! not continued by a program that computes otherwise. Outside the repository the versions of the
//! crates stand for their sources.

use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::{fs, io};

const CRATES: [&str; 6] = ["core", "expression", "systems", "methods", "inlined", "analysis"];

fn main() -> io::Result<()> {
    let mut hasher = DefaultHasher::new();
    for name in CRATES {
        let folder = Path::new("..").join(name).join("src");
        if folder.is_dir() {
            println!("cargo:rerun-if-changed={}", folder.display());
            add(&mut hasher, &folder)?;
        }
    }
    println!("cargo:rustc-env=AFTERBAY_SOURCES={:016x}", hasher.finish());
    Ok(())
}

/// Adds the names and contents of the files of a folder, in the order of their names.
fn add(hasher: &mut DefaultHasher, folder: &Path) -> io::Result<()> {
    let entries = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut paths: Vec<PathBuf> = entries.collect::<io::Result<_>>()?;
    paths.sort();
    for path in paths {
        if path.is_dir() {
            add(hasher, &path)?;
        } else {
            hasher.write(path.to_string_lossy().as_bytes());
            hasher.write(&fs::read(&path)?);
        }
    }
    Ok(())
}
