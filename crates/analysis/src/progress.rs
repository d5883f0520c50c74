//! How far a long computation is.

/// Told how far a computation is; from many threads at once.
pub trait Progress: Sync {
    /// A stage of `total` pieces begins.
    fn begin(&self, stage: &str, total: usize);
    /// One piece is done.
    fn advance(&self);
    /// Has somebody had enough? What is not begun is left out then, and what runs ends early.
    fn stopped(&self) -> bool {
        false
    }
}

/// Nobody looks.
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
}
