//! Scene files.

use crate::failure::Failure;
use afterbay_experiments::scene::{MOST_BYTES, Scene, text};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads and checks a scene.
pub(crate) fn read(path: &Path) -> Result<Scene, Failure> {
    with_text(path).map(|(_, scene)| scene)
}

/// Reads and checks a scene, and no more of the file than a scene may have. Also returns its text.
pub(crate) fn with_text(path: &Path) -> Result<(String, Scene), Failure> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| Failure::unreadable(path, error))?;
    file.take(MOST_BYTES as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| Failure::unreadable(path, error))?;
    let text = text(&bytes).map_err(|error| {
        Failure::scene(path, &String::from_utf8_lossy(&bytes[..bytes.len().min(MOST_BYTES)]), error)
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene =
        Scene::read_in(folder, text).map_err(|error| Failure::scene(path, text, error))?;
    scene.call_by(path);
    Ok((text.to_owned(), scene))
}
