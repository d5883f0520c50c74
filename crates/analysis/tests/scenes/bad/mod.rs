//! Scenes with one thing wrong, and what is said of each.

mod custom;
mod named;
mod nested;

/// A text that is no scene.
pub(crate) struct Bad {
    /// The text.
    pub(crate) text: String,
    /// What is pointed at, its first line.
    pub(crate) at: String,
    /// A part of the message.
    pub(crate) says: &'static str,
    /// A part of the advice; nothing where the message says it all.
    pub(crate) help: &'static str,
}

/// A change of a good scene: what is replaced and by what, what is pointed at, said and advised.
type Change = (&'static str, &'static str, &'static str, &'static str, &'static str);

/// The good scenes the others are made of.
pub(crate) const GOOD: [&str; 2] = [named::GOOD, custom::GOOD];

fn changed<'a>(good: &'a str, changes: &'a [Change]) -> impl Iterator<Item = Bad> + 'a {
    changes.iter().map(move |&(from, to, at, says, help)| {
        assert!(good.contains(from), "{from}");
        Bad { text: good.replacen(from, to, 1), at: at.into(), says, help }
    })
}

/// All of them.
pub(crate) fn all() -> Vec<Bad> {
    let small = changed(named::GOOD, named::CHANGES).chain(changed(custom::GOOD, custom::CHANGES));
    small.chain(custom::places()).chain(nested::texts()).collect()
}
