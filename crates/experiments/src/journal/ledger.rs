//! The ledger of a command. It keeps the results of cells and selects the cells to compute.

use super::JournalError;
use afterbay_analysis::rows::Shelf;
use std::time::Duration;

/// Keeps the results of cells by their keys.
pub trait Ledger: Sync {
    /// The result of a cell that is finished, or the last [`checkpoint`] of one that is not.
    fn recall(&self, key: &str) -> Option<Vec<u8>>;

    /// Whether this command computes the cell.
    fn takes(&self, key: &str) -> bool;

    /// Keeps the result of a finished cell, or a [`checkpoint`], and the time it took.
    ///
    /// # Errors
    /// [`JournalError`] if it cannot be written.
    fn keep(&self, key: &str, result: &[u8], time: Duration) -> Result<(), JournalError>;

    /// The shelf for the rows of long tables; none if they stay in memory.
    fn shelf(&self) -> Option<&Shelf> {
        None
    }
}

/// The mark behind the key of a cell that is under way.
const UNDER_WAY: char = '#';

/// The key under which a ledger keeps the last checkpoint of a cell that is under way.
pub fn checkpoint(key: &str) -> String {
    format!("{key}{UNDER_WAY}")
}

/// The cell of a checkpoint, if a key is that of one.
pub fn under_way(key: &str) -> Option<&str> {
    key.strip_suffix(UNDER_WAY)
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
