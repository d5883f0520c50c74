//! `afterbay cite`

use crate::arguments::Format;
use crate::failure::Failure;
use crate::{scene, table};
use afterbay_methods::registry::{KOBUS, Row, Source};
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// The sources of a method.
#[derive(Serialize)]
struct Cited {
    /// The method; none for afterbay and the paper it is based on.
    method: Option<&'static str>,
    /// Its entries in BibTeX.
    entries: Vec<String>,
}

/// The entry of this program, with the authors and the title of `CITATION.cff`.
fn software() -> String {
    format!(
        "@misc{{afterbay,\n  author = {{{{The afterbay developers}}}},\n  title = {{afterbay: \
         dissipative {{Hamiltonian}} systems with an exact energy balance}},\n  note = {{Version \
         {}}}\n}}",
        env!("CARGO_PKG_VERSION")
    )
}

/// Prints the sources of all methods of a scene.
pub(crate) fn run(path: &Path, format: Format) -> Result<ExitCode, Failure> {
    let methods = scene::read(path)?.methods();
    match format {
        Format::Json => table::json(&cited(&methods))?,
        Format::Table => table::line(&bibliography(&methods))?,
    }
    Ok(ExitCode::SUCCESS)
}

fn cited(methods: &[&Row]) -> Vec<Cited> {
    let entries = |row: &&Row| row.sources.iter().map(|source| source.bibtex().into()).collect();
    let always = Cited { method: None, entries: vec![software(), KOBUS.bibtex().into()] };
    let each = methods.iter().map(|row| Cited { method: Some(row.name), entries: entries(row) });
    [always].into_iter().chain(each).collect()
}

/// One file for BibTeX. Comments tell which method has which keys, and every entry is there once.
fn bibliography(methods: &[&Row]) -> String {
    let mut sources: Vec<&Source> = vec![&KOBUS];
    let mut lines = vec!["% afterbay and the source of its reservoirs: afterbay, kobus".to_owned()];
    for row in methods {
        let keys: Vec<_> = row.sources.iter().map(Source::key).collect();
        let keys = if keys.is_empty() { "no source".into() } else { keys.join(", ") };
        lines.push(format!("% {}: {keys}", row.name));
        sources.extend(row.sources);
    }
    lines.push(format!("\n{}", software()));
    for (i, source) in sources.iter().enumerate() {
        if !sources.iter().take(i).any(|other| other == source) {
            lines.push(format!("\n{}", source.bibtex()));
        }
    }
    lines.join("\n")
}
