//! Words of tables and methods, read back from a journal.

use afterbay_methods::registry::{REFERENCE, Row, find};
use serde::{Deserialize, Deserializer, Serializer};
use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};

/// A word of a table, such as the name of a method or an outcome. The alias keeps serde from
/// borrowing it from the text that is read.
pub type Word = &'static str;

/// All words read so far. There are few: names and outcomes.
static KNOWN: Mutex<Option<HashSet<Word>>> = Mutex::new(None);

/// Reads a word. Each distinct word is kept once for the life of the program.
pub fn word<'de, D: Deserializer<'de>>(source: D) -> Result<Word, D::Error> {
    let text = String::deserialize(source)?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    if let Some(word) = known.get(&*text) {
        return Ok(word);
    }
    let word: Word = text.leak();
    known.insert(word);
    Ok(word)
}

/// A method, written as its name.
pub(crate) mod by_name {
    use super::{Deserialize, Deserializer, REFERENCE, Row, Serializer, find};
    use serde::de::Error;

    pub(crate) fn serialize<S: Serializer>(row: &&'static Row, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(row.name)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        source: D,
    ) -> Result<&'static Row, D::Error> {
        let name = String::deserialize(source)?;
        let reference = (name == REFERENCE.name).then_some(&REFERENCE);
        reference
            .or_else(|| find(&name))
            .ok_or_else(|| D::Error::custom(format!("no method {name}")))
    }
}
