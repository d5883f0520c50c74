//! The paper's report: its tables, and its findings. It is run once for all of these tests.

mod claims;
mod tables;

use afterbay_analysis::progress::Silent;
use afterbay_experiments::Finding;
use afterbay_experiments::paper::{self, Extent};
use afterbay_experiments::record::Output;
use std::sync::LazyLock;

/// A quick paper that one thread has run.
static PAPER: LazyLock<(Output, Vec<Finding>)> = LazyLock::new(|| paper_by(1));

fn paper_by(threads: usize) -> (Output, Vec<Finding>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| paper::run(Extent::Quick, &Silent)).expect("the paper runs")
}
