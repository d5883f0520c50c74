//! Progress of long computations.

use std::ops::ControlFlow;

/// Receives the progress of a computation. Its methods are called from many threads at once.
pub trait Progress: Sync {
    /// A stage of `total` pieces begins.
    fn begin(&self, stage: &str, total: usize);
    /// One piece is done.
    fn advance(&self);
    /// Adds this share of a piece to what is done. A negative share is subtracted again, before the
    /// piece is counted as a whole.
    fn part(&self, _share: f64) {}
    /// Adds this share of the cost of the stage to what is done; a negative share is subtracted.
    fn work(&self, _share: f64) {}
    /// This share of a cell, or of the cost of the stage, was done by an earlier command: it took
    /// no time in this one.
    fn earlier(&self, _share: f64) {}
    /// This share of the reference that the pieces of a stage need is done.
    fn reference(&self, _share: f64) {}
    /// Whether the user asked to stop. Runs that have not begun are skipped, and runs under way end
    /// early.
    fn stopped(&self) -> bool {
        false
    }
    /// The answer of an observer of a run: the run ends if the user asked to stop.
    fn flow(&self) -> ControlFlow<()> {
        if self.stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Ignores all progress.
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}
}

/// Passes on that the user asked to stop, and no progress.
pub(crate) struct Unseen<'a>(pub(crate) &'a dyn Progress);

impl Progress for Unseen<'_> {
    fn begin(&self, _stage: &str, _total: usize) {}
    fn advance(&self) {}

    fn stopped(&self) -> bool {
        self.0.stopped()
    }
}

/// The progress of one cell of a stage. It reports the cost of its pieces as well.
pub struct Weighted<'a> {
    progress: &'a dyn Progress,
    /// The share of the cell in the cost of the stage, and that of one of its pieces.
    cell: f64,
    weight: f64,
}

impl<'a> Weighted<'a> {
    /// A cell of `pieces` pieces that takes this share of the cost of the stage.
    pub fn new(progress: &'a dyn Progress, share: f64, pieces: usize) -> Self {
        Self { progress, cell: share, weight: share / pieces.max(1) as f64 }
    }
}

impl Progress for Weighted<'_> {
    fn begin(&self, stage: &str, total: usize) {
        self.progress.begin(stage, total);
    }

    fn advance(&self) {
        self.progress.advance();
        self.progress.work(self.weight);
    }

    fn part(&self, share: f64) {
        self.progress.part(share);
        self.progress.work(share * self.weight);
    }

    fn work(&self, share: f64) {
        self.progress.work(share);
    }

    fn earlier(&self, share: f64) {
        self.progress.earlier(share * self.cell);
    }

    fn reference(&self, share: f64) {
        self.progress.reference(share);
    }

    fn stopped(&self) -> bool {
        self.progress.stopped()
    }
}

/// The least share of a piece that is reported.
const LEAST: f64 = 0.005;

/// A piece under way. When it is dropped, its shares are taken back: `advance` counts it then.
pub(crate) struct Piece<'a> {
    progress: &'a dyn Progress,
    /// The number of pieces that are under way together.
    count: f64,
    /// The share of each that has been reported.
    reported: f64,
}

impl<'a> Piece<'a> {
    /// One piece begins.
    pub(crate) fn new(progress: &'a dyn Progress) -> Self {
        Self::several(progress, 1)
    }

    /// Several pieces begin, which go on together.
    pub(crate) fn several(progress: &'a dyn Progress, count: usize) -> Self {
        Self { progress, count: count as f64, reported: 0.0 }
    }

    /// `steps` of `all` steps are done.
    pub(crate) fn report(&mut self, steps: u64, all: u64) {
        let share = steps as f64 / all.max(1) as f64;
        if share >= self.reported + LEAST {
            self.progress.part(self.count * (share - self.reported));
            self.reported = share;
        }
    }
}

impl Drop for Piece<'_> {
    fn drop(&mut self) {
        self.progress.part(-self.count * self.reported);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    struct Sum(Mutex<Vec<f64>>);

    impl Progress for Sum {
        fn begin(&self, _stage: &str, _total: usize) {}
        fn advance(&self) {}
        fn part(&self, share: f64) {
            self.0.lock().expect("a list").push(share);
        }
    }

    #[test]
    fn a_cell_tells_what_its_pieces_cost() {
        struct Work(Mutex<f64>);
        impl Progress for Work {
            fn begin(&self, _stage: &str, _total: usize) {}
            fn advance(&self) {}
            fn work(&self, share: f64) {
                *self.0.lock().expect("a sum") += share;
            }
        }
        let work = Work(Mutex::new(0.0));
        let done = || *work.0.lock().expect("a sum");
        let cell = Weighted::new(&work, 0.5, 2);
        let mut piece = Piece::new(&cell);
        piece.report(50, 100);
        assert_eq!(done(), 0.125);
        drop(piece);
        cell.advance();
        assert_eq!(done(), 0.25);
        cell.advance();
        assert_eq!(done(), 0.5);
    }

    #[test]
    fn a_piece_tells_its_shares_now_and_then_and_takes_them_back() {
        let sum = Sum(Mutex::new(Vec::new()));
        let mut piece = Piece::several(&sum, 2);
        (0..=75_000).for_each(|step| piece.report(step, 100_000));
        let told = sum.0.lock().expect("a list").clone();
        assert!((100..=150).contains(&told.len()), "{}", told.len());
        assert!((told.iter().sum::<f64>() - 1.5).abs() < 0.011, "{told:?}");
        drop(piece);
        assert!(sum.0.lock().expect("a list").iter().sum::<f64>().abs() < 1e-12);
    }
}
