//! Scenes with one mistake, and the message for each.

mod attractors;
mod custom;
mod drive;
mod figures;
mod form;
mod named;
mod nested;

/// A text that is not a valid scene.
pub(crate) struct Bad {
    /// The text.
    pub(crate) text: String,
    /// The first line of the part that the message points at.
    pub(crate) at: String,
    /// A part of the message.
    pub(crate) says: &'static str,
    /// A part of the advice; empty if there is none.
    pub(crate) help: &'static str,
}

/// A change of a valid scene: the text replaced, its replacement, the part pointed at, and parts of
/// the message and of the advice.
type Change = (&'static str, &'static str, &'static str, &'static str, &'static str);

/// The valid scenes from which the others are made.
pub(crate) const GOOD: [&str; 4] = [named::GOOD, custom::GOOD, drive::GOOD, attractors::GOOD];

fn changed<'a>(good: &'a str, changes: &'a [Change]) -> impl Iterator<Item = Bad> + 'a {
    changes.iter().map(move |&(from, to, at, says, help)| {
        assert!(good.contains(from), "{from}");
        Bad { text: good.replacen(from, to, 1), at: at.into(), says, help }
    })
}

/// All bad scenes.
pub(crate) fn all() -> Vec<Bad> {
    let form = changed(named::GOOD, form::CHANGES);
    let named = changed(named::GOOD, named::CHANGES);
    let custom = changed(custom::GOOD, custom::CHANGES);
    let figures = changed(named::GOOD, figures::CHANGES);
    let drive = changed(drive::GOOD, drive::CHANGES);
    let attractors = changed(attractors::GOOD, attractors::CHANGES);
    form.chain(named)
        .chain(figures)
        .chain(custom)
        .chain(drive)
        .chain(attractors)
        .chain(custom::places())
        .chain(nested::texts())
        .collect()
}
