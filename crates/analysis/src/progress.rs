//! Progress of long computations.

/// Receives the progress of a computation. Its methods are called from many threads at once.
pub trait Progress: Sync {
    /// A stage of `total` pieces begins.
    fn begin(&self, stage: &str, total: usize);
    /// One piece is done.
    fn advance(&self);
    /// Whether the user asked to stop. Runs that have not begun are skipped, and runs under way end
    /// early.
    fn stopped(&self) -> bool {
        false
    }
}

/// Ignores all progress.
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
}
