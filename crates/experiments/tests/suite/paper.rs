//! The paper's report: its tables, and its findings.

mod claims;
mod tables;

use afterbay_analysis::progress::Silent;
use afterbay_experiments::Finding;
use afterbay_experiments::paper::{self, Extent};
use afterbay_experiments::record::Output;
use std::sync::LazyLock;

/// A quick paper, run once for all tests.
pub(crate) static PAPER: LazyLock<(Output, Vec<Finding>)> =
    LazyLock::new(|| paper::run(Extent::Quick, &Silent).expect("the paper runs"));
