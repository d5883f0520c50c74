//! The lines of a journal behind the first.

use super::{Header, JournalError};
use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD as BASE64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::time::Duration;

/// The bytes of a checksum.
const CHECKSUM: usize = 8;

/// A finished cell.
#[derive(Serialize, Deserialize)]
pub(super) struct Line {
    key: String,
    /// The time that the cell took, for those who plan the next study.
    seconds: f64,
    checksum: String,
    result: String,
}

impl Line {
    pub(super) fn new(key: &str, result: &[u8], time: Duration) -> Self {
        let (checksum, result) = (checksum(key, result), BASE64.encode(result));
        Self { key: key.into(), seconds: time.as_secs_f64(), checksum, result }
    }

    /// The key and the result, if the line is whole.
    pub(super) fn read(text: &str) -> Option<(String, Vec<u8>)> {
        let Self { key, checksum: claimed, result, .. } = serde_json::from_str(text).ok()?;
        let result = BASE64.decode(result).ok()?;
        (checksum(&key, &result) == claimed).then_some((key, result))
    }
}

fn checksum(key: &str, result: &[u8]) -> String {
    let digest = Sha256::new().chain_update(key).chain_update([0]).chain_update(result).finalize();
    digest[..CHECKSUM].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The content of a journal file.
pub(super) struct Content {
    pub(super) header: Option<Header>,
    pub(super) cells: Vec<(String, Vec<u8>)>,
    /// The bytes up to the end of the last whole line.
    pub(super) length: u64,
    /// Lines that are not whole.
    pub(super) damaged: usize,
}

impl Content {
    pub(super) fn read(path: &Path) -> Result<Self, JournalError> {
        let bytes = std::fs::read(path).map_err(JournalError::file(path))?;
        let length = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let text = String::from_utf8_lossy(&bytes[..length]);
        let mut lines = text.lines();
        let Some(first) = lines.next() else {
            let damaged = usize::from(!bytes.is_empty());
            return Ok(Self { header: None, cells: Vec::new(), length: 0, damaged });
        };
        let header = serde_json::from_str(first)
            .map_err(|why| JournalError::NoHeader { path: path.into(), why: why.to_string() })?;
        let lines: Vec<&str> = lines.collect();
        let read: Vec<_> = lines.par_iter().map(|line| Line::read(line)).collect();
        let torn = usize::from(length < bytes.len());
        let damaged = torn + read.iter().filter(|line| line.is_none()).count();
        let cells = read.into_iter().flatten().collect();
        Ok(Self { header: Some(header), cells, length: length as u64, damaged })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Task;
    use proptest::prelude::*;

    fn read(bytes: &[u8]) -> Result<Content, JournalError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("1-of-1.jsonl");
        std::fs::write(&path, bytes).expect("it is written");
        Content::read(&path)
    }

    /// A journal of cells, and the ends of its lines.
    fn journal(cells: &[(String, Vec<u8>)]) -> (Vec<u8>, Vec<usize>) {
        let header = serde_json::to_string(&Header::new(Task::Study, "ab")).expect("a header");
        let mut bytes = (header + "\n").into_bytes();
        let mut ends = vec![bytes.len()];
        for (key, result) in cells {
            let line = Line::new(key, result, Duration::from_millis(1));
            bytes.extend(serde_json::to_vec(&line).expect("a line"));
            bytes.push(b'\n');
            ends.push(bytes.len());
        }
        (bytes, ends)
    }

    fn cells() -> impl Strategy<Value = Vec<(String, Vec<u8>)>> {
        let cell = (".*", prop::collection::vec(any::<u8>(), 0..40));
        prop::collection::vec(cell, 0..6)
    }

    /// The number of cases of a test: 256, unless the environment asks for another.
    fn cases_asked() -> ProptestConfig {
        let asked = std::env::var("AFTERBAY_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok());
        ProptestConfig { cases: asked.unwrap_or(256), ..ProptestConfig::default() }
    }

    #[test]
    fn the_corpus_is_read_or_refused() {
        let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/journals");
        let mut count = 0;
        for file in std::fs::read_dir(corpus).expect("the corpus") {
            let path = file.expect("a file").path();
            // No file of the corpus has a line whose checksum is right.
            if let Ok(content) = Content::read(&path) {
                assert!(content.cells.is_empty(), "{}", path.display());
            }
            count += 1;
        }
        assert!(count > 5, "{count}");
    }

    proptest! {
        #![proptest_config(cases_asked())]

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            if let Ok(content) = read(&bytes) {
                prop_assert!(content.cells.is_empty());
            }
        }

        #[test]
        fn a_torn_journal_has_the_cells_of_its_whole_lines(cells in cells(), share in 0.0..1.0) {
            let (bytes, ends) = journal(&cells);
            let cut = (share * bytes.len() as f64) as usize;
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            let content = read(&bytes[..cut]).expect("a journal");
            prop_assert_eq!(content.header.is_some(), whole > 0);
            prop_assert_eq!(content.length, whole.checked_sub(1).map_or(0, |at| ends[at]) as u64);
            prop_assert_eq!(&content.cells[..], &cells[..whole.saturating_sub(1)]);
        }

        #[test]
        fn a_changed_byte_is_never_a_changed_result(
            cells in cells(),
            share in 0.0..1.0,
            byte in any::<u8>(),
        ) {
            let (mut bytes, ends) = journal(&cells);
            let at = ends[0] + (share * (bytes.len() - ends[0]) as f64) as usize;
            if at < bytes.len() {
                bytes[at] = byte;
                let content = read(&bytes).expect("the header is whole");
                prop_assert!(content.cells.iter().all(|cell| cells.contains(cell)));
            }
        }
    }

    #[test]
    fn numbers_are_kept_to_the_bit() {
        let numbers =
            [0.1, -0.0, f64::NAN, f64::INFINITY, -f64::MIN_POSITIVE / 4.0, 1e-320, 0.1 + 0.2];
        let mut bytes = Vec::new();
        ciborium::into_writer(&numbers.map(Some), &mut bytes).expect("it is written");
        let read: [Option<f64>; 7] = ciborium::from_reader(&bytes[..]).expect("it is read");
        for (number, read) in numbers.iter().zip(read) {
            assert_eq!(read.map(f64::to_bits), Some(number.to_bits()));
        }
    }
}
