//! Where the results of cells are kept, and which cells are computed here.

use crate::journal::JournalError;
use std::time::Duration;

/// Keeps the results of cells by their keys.
pub trait Ledger: Sync {
    /// The result of a cell that is finished.
    fn recall(&self, key: &str) -> Option<Vec<u8>>;

    /// Whether this command computes the cell.
    fn takes(&self, key: &str) -> bool;

    /// Keeps the result of a finished cell and the time it took.
    ///
    /// # Errors
    /// [`JournalError`] if it cannot be written.
    fn keep(&self, key: &str, result: &[u8], time: Duration) -> Result<(), JournalError>;
}

/// Computes everything and keeps nothing.
pub struct Afresh;

impl Ledger for Afresh {
    fn recall(&self, _key: &str) -> Option<Vec<u8>> {
        None
    }

    fn takes(&self, _key: &str) -> bool {
        true
    }

    fn keep(&self, _key: &str, _result: &[u8], _time: Duration) -> Result<(), JournalError> {
        Ok(())
    }
}
