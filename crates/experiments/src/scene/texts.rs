//! Texts of a scene that are shown in charts.

use super::document::Document;
use super::problem::{SceneError, SceneProblem};
use super::source::Source;

/// Refuses titles and units with characters that an SVG file cannot contain.
pub(super) fn check(source: &Source, document: &Document) -> Result<(), SceneError> {
    let units = document.units.clone().unwrap_or_default();
    let of_units = [("time", units.time), ("q", units.q), ("p", units.p), ("energy", units.energy)];
    let of_units = of_units.into_iter().map(|(key, unit)| (vec!["units", key], unit));
    let of_figures = document.figure.iter();
    let of_figures =
        of_figures.map(|(name, table)| (vec!["figure", &**name, "title"], table.title.clone()));
    let title = (vec!["title"], document.title.clone());
    for (keys, text) in [title].into_iter().chain(of_units).chain(of_figures) {
        if text.is_some_and(|text| text.contains(is_refused)) {
            let problem = SceneProblem::ControlCharacter;
            return Err(SceneError { problem, span: source.span_of(&keys) });
        }
    }
    Ok(())
}

/// A text that takes the place of a title, with a sign for each character that a title may not
/// have.
pub(super) fn as_title(text: &str) -> String {
    text.replace(is_refused, "\u{fffd}")
}

/// Whether a character is a control character, or none that XML knows.
fn is_refused(c: char) -> bool {
    c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')
}
