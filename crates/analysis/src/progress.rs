//! How far a long computation is.

/// Told how far a computation is; from many threads at once.
pub trait Progress: Sync {
    /// A stage of `total` pieces begins.
    fn begin(&self, stage: &str, total: usize);
    /// One piece is done.
    fn advance(&self);
    /// Is it to be broken off? What has begun is finished, and what has not is left out.
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
