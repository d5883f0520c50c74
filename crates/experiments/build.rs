//! Sets `AFTERBAY_SOURCES` to a hash of the sources and the locked dependencies that results depend
//! on, so that a journal is not continued by a program that computes otherwise. Outside the
//! repository the versions of the crates stand for them.

use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::{fs, io};

const PARTS: [&str; 8] = [
    "../core/src",
    "../expression/src",
    "../systems/src",
    "../methods/src",
    "../inlined/src",
    "../analysis/src",
    "../experiments/src",
    "../../Cargo.lock",
];

fn main() -> io::Result<()> {
    let mut hasher = DefaultHasher::new();
    for part in PARTS.map(Path::new).into_iter().filter(|part| part.exists()) {
        println!("cargo:rerun-if-changed={}", part.display());
        add(&mut hasher, part)?;
    }
    println!("cargo:rustc-env=AFTERBAY_SOURCES={:016x}", hasher.finish());
    Ok(())
}

/// Adds the name and content of a file, or those of the files of a folder in the order of their
/// names.
fn add(hasher: &mut DefaultHasher, path: &Path) -> io::Result<()> {
    if path.is_dir() {
        let entries = fs::read_dir(path)?.map(|entry| Ok(entry?.path()));
        let mut paths: Vec<PathBuf> = entries.collect::<io::Result<_>>()?;
        paths.sort();
        return paths.iter().try_for_each(|path| add(hasher, path));
    }
    hasher.write(path.to_string_lossy().as_bytes());
    hasher.write(&fs::read(path)?);
    Ok(())
}
