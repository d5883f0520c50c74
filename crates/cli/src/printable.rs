//! Texts without control characters, which a terminal would obey.

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::borrow::Cow;
use std::error::Error;
use std::fmt;

/// A text with its control characters as escapes such as `\u{1b}`. Lines stay lines.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_obeyed) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| {
        if is_obeyed(c) { c.escape_unicode().to_string() } else { c.to_string() }
    };
    Cow::Owned(text.chars().map(shown).collect())
}

fn is_obeyed(c: char) -> bool {
    c.is_control() && c != '\n' && c != '\t'
}

/// A text of the same length in bytes, in which spans keep their places.
fn in_place(text: &str) -> String {
    let shown = |c: char| match c {
        '\r' => c,
        _ if is_obeyed(c) && c.is_ascii() => '?',
        _ if is_obeyed(c) => '¿',
        _ => c,
    };
    text.chars().map(shown).collect()
}

/// A message, its causes and its help, as they are printed.
#[derive(Debug)]
pub(crate) struct Printable {
    message: Message,
    help: Option<String>,
    labels: Vec<LabeledSpan>,
    text: Option<NamedSource<String>>,
}

/// A message and its cause.
#[derive(Debug)]
struct Message {
    text: String,
    cause: Option<Box<Self>>,
}

impl Message {
    fn of(error: &dyn Error) -> Self {
        let cause = error.source().map(|cause| Box::new(Self::of(cause)));
        Self { text: printable(&error.to_string()).into_owned(), cause }
    }
}

impl Printable {
    /// A failure and the text in which its labels have their places.
    pub(crate) fn new(trouble: &impl Diagnostic, text: Option<&NamedSource<String>>) -> Self {
        let text =
            text.map(|text| NamedSource::new(printable(text.name()), in_place(text.inner())));
        let help = trouble.help().map(|help| printable(&help.to_string()).into_owned());
        let labels = trouble.labels().into_iter().flatten().collect();
        Self { message: Message::of(trouble), help, labels, text }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Error for Message {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.cause.as_deref().map(|cause| cause as &dyn Error)
    }
}

impl fmt::Display for Printable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.message.fmt(f)
    }
}

impl Error for Printable {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.message.source()
    }
}

impl Diagnostic for Printable {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (!self.labels.is_empty()).then(|| Box::new(self.labels.iter().cloned()) as Box<_>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.text.as_ref().map(|text| text as &dyn SourceCode)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_lines_kept() {
        assert_eq!(printable("a\u{1b}[31mb\nc\td\u{7}"), "a\\u{1b}[31mb\nc\td\\u{7}");
        assert!(matches!(printable("h = 0.1 µs"), Cow::Borrowed(_)));
        let text = "a\u{1b}\u{9b}\r\nb";
        assert_eq!(in_place(text), "a?¿\r\nb");
        assert_eq!(in_place(text).len(), text.len());
    }
}
