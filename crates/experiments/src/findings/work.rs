//! Accuracy against cost: the table of runs, the cheapest of them, and which methods keep K.

use super::{KEPT, kept};
use crate::claim::{Found, Readings, Said, list, sci};
use crate::report::Verdict;
use crate::sheet::{Sheet, measured, scientific};
use afterbay_analysis::Measured;
use afterbay_analysis::study::work_precision::WorkRow;
use afterbay_core::larger_or_nan;

/// The columns of a table of runs, see [`cells`].
pub(crate) const HEADER: [&str; 9] = [
    "method",
    "h or tolerance",
    "outcome",
    "error of (q, p)",
    "error of w",
    "max |K - K₀|",
    "steps with Δw < 0",
    "seconds",
    "evaluations",
];

/// The largest error of q, p and w for the cheapest run.
const WANTED: f64 = 1e-4;

/// The reading of the outcome of a run that did not reach the end, before its setting.
const ENDED: &str = "ended at ";

/// States the cheapest runs within [`WANTED`], with K kept and without, and which methods keep K at
/// all.
pub(crate) fn cheapest(sheet: &mut Sheet, name: &str, rows: &[WorkRow]) {
    let (mut cheapest, mut worst) =
        (Readings::default().and("q, p and w", "wanted", WANTED), Readings::default());
    for of in rows.chunk_by(|a, b| a.method == b.method) {
        let timed = of.iter().filter(|row| is_good(row) && row.seconds.is_some());
        let best = timed
            .min_by(|a, b| a.seconds.unwrap_or(f64::MAX).total_cmp(&b.seconds.unwrap_or(f64::MAX)));
        if let Some(row) = best {
            cheapest.add(row.method, "setting", row.setting());
            cheapest.add(row.method, "seconds", row.seconds);
            cheapest.add(row.method, "drift", row.k_share);
        }
        let done = of.iter().filter(|row| row.error_qp.is_some());
        // H may have no value at a state, as the difference of two terms that overflow: K is lost.
        let drift = |row: &WorkRow| if row.k_share.is_nan() { f64::INFINITY } else { row.k_share };
        let drift = done.map(drift).reduce(f64::max);
        worst.add(of[0].method, "drift", drift);
        let ended = of.iter().filter(|row| drift.is_some() && row.error_qp.is_none());
        for row in ended {
            worst.add(row.method, &format!("{ENDED}{}", row.setting()), row.outcome);
        }
    }
    // They matter only where no run is known to be within the error.
    if cheapest.of_all("seconds").is_empty() {
        if let Some(doubt) = undecided(rows) {
            cheapest.add("q, p and w", "doubt", doubt);
        }
        if rows.iter().any(is_good) {
            cheapest.add("q, p and w", "times", "missing");
        }
    }
    sheet.find(&format!("{name}, cost of an error of {WANTED:e}"), cheapest, the_cheapest);
    sheet.find(&format!("{name}, K in these runs"), worst, who_keeps_k);
}

/// Whether a run is known to be within [`WANTED`].
fn is_good(row: &WorkRow) -> bool {
    let bounds = row.qp().zip(row.w()).map(|(qp, w)| [qp.bound(), w.bound()]);
    bounds.is_some_and(|[qp, w]| larger_or_nan(qp, w) <= WANTED)
}

/// The largest doubt of the reference for a run that may be within [`WANTED`], and is not known to
/// be.
fn undecided(rows: &[WorkRow]) -> Option<f64> {
    let least = |of: Measured| of.error - of.doubt;
    let of = |row: &WorkRow| {
        let (qp, w) = row.qp().zip(row.w())?;
        let may_be = least(qp).max(least(w)) <= WANTED && qp.bound().max(w.bound()) > WANTED;
        may_be.then_some(qp.doubt.max(w.doubt))
    };
    rows.iter().filter_map(of).reduce(f64::max)
}

/// States the cheapest run within the wanted error, and the cheapest of those that keep K, as
/// measured.
fn the_cheapest(r: &Readings) -> Said {
    let all = r.numbers("seconds");
    let best = |keeps: bool| {
        let able = all.iter().filter(|(name, _)| !keeps || r.number(name, "drift") <= KEPT);
        let timed = able.filter(|(_, seconds)| !seconds.is_nan());
        timed.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| *name)
    };
    let say = |name: &str| {
        format!(
            "{name} at {} ({} s, K off by {} of the largest energy)",
            r.word(name, "setting"),
            sci(r.number(name, "seconds")),
            sci(r.number(name, "drift"))
        )
    };
    let wanted = format!("with errors of at most {:e}", r.number("q, p and w", "wanted"));
    let statement = match (best(false), best(true)) {
        (None, _) if r.word("q, p and w", "times") == "missing" => {
            format!("no run that ends {wanted} has been timed.")
        }
        (None, _) if r.number("q, p and w", "doubt").is_nan() => {
            format!("no run ends {wanted}.")
        }
        (None, _) => format!(
            "no run is known to end {wanted}: the reference is known to {} only.",
            sci(r.number("q, p and w", "doubt"))
        ),
        (Some(cheapest), kept) => format!(
            "the cheapest run {wanted} is {}; {}. Methods with such a run: {}.",
            say(cheapest),
            match kept {
                None => "none of these keeps K".into(),
                Some(kept) if kept == cheapest => "the cheapest that keeps K is the same".into(),
                Some(kept) => format!("the cheapest that keeps K is {}", say(kept)),
            },
            all.len(),
        ),
    };
    (Verdict::Note, statement)
}

/// The runs of a method that did not reach the end, and how they ended.
fn ended(r: &Readings, method: &str) -> Vec<String> {
    let of = r.0.iter().filter(|reading| reading.of == method);
    let of = of.filter_map(|reading| match (&reading.found, reading.what.strip_prefix(ENDED)) {
        (Found::Word(outcome), Some(setting)) => Some(format!("{method} at {setting}, {outcome}")),
        _ => None,
    });
    of.collect()
}

/// States which methods keep K in all runs that reached the end.
fn who_keeps_k(r: &Readings) -> Said {
    let all = r.numbers("drift");
    let part = |word: &str| {
        let of = all.iter().filter(|(_, drift)| !drift.is_nan() && kept(*drift) == word);
        let of: Vec<_> = of.map(|(name, drift)| format!("{name} ({})", sci(*drift))).collect();
        (!of.is_empty()).then(|| list(of))
    };
    let methods = match [part("keeps K"), part("does not keep K")] {
        [None, None] => "K is kept by none".to_owned(),
        [Some(kept), None] => format!("K is kept in every run that reached the end by {kept}"),
        [None, Some(lost)] => format!("K is not kept in every run that reached the end by {lost}"),
        [Some(kept), Some(lost)] => {
            format!("K is kept in every run that reached the end by {kept} and not by {lost}")
        }
    };
    let mut statement = format!(
        "{methods} (in parentheses max |K - K₀| relative to the largest |H| + Σ |w_j| or T of the \
         run, T = ½ Σ |p_j ∂H/∂p_j|; up to {KEPT:.0e} counts as kept)."
    );
    let ended: Vec<_> = all.iter().flat_map(|(name, _)| ended(r, name)).collect();
    if !ended.is_empty() {
        statement.push_str(&format!(" Did not reach the end: {}.", ended.join("; ")));
    }
    let none: Vec<_> = all.iter().filter(|(_, drift)| drift.is_nan()).collect();
    if !none.is_empty() {
        let names = list(none.iter().map(|(name, _)| name.to_string()));
        statement.push_str(&format!(" No run reached the end: {names}."));
    }
    (Verdict::Note, statement)
}

/// The cells of a run.
pub(crate) fn cells(row: &WorkRow) -> Vec<String> {
    vec![
        row.method.into(),
        row.tolerance.map_or(row.h.to_string(), |tolerance| format!("tolerance {tolerance:e}")),
        row.failure.clone().unwrap_or_else(|| row.outcome.into()),
        measured(row.qp()),
        measured(row.w()),
        scientific((row.steps > 0).then_some(row.k_drift)),
        row.passivity_violations.map_or("not counted".into(), |count| count.to_string()),
        scientific(row.seconds),
        row.evaluations.map_or(String::new(), |count| count.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_analysis::study::outcome::COMPLETED;

    /// One of two runs, with these errors of (q, p) and deviations of K.
    fn row(i: usize, error_qp: [f64; 2], doubt_qp: f64, k_share: [f64; 2]) -> WorkRow {
        WorkRow {
            method: ["rk4", "moddg"][i],
            h: 0.1,
            outcome: COMPLETED,
            error_qp: Some(error_qp[i]),
            error_w: Some(0.0),
            k_drift: 0.0,
            passivity_violations: None,
            seconds: Some(1.0 + i as f64),
            steps: 10,
            evaluations: None,
            iterations: None,
            failure: None,
            doubt_qp,
            doubt_w: 0.0,
            tolerance: None,
            k_share: k_share[i],
        }
    }

    /// The statements about two runs, with these errors of (q, p) and deviations of K.
    fn statements(error_qp: [f64; 2], doubt_qp: f64, k_share: [f64; 2]) -> [String; 2] {
        let row = |i: usize| row(i, error_qp, doubt_qp, k_share);
        let mut sheet = Sheet::new("Work");
        cheapest(&mut sheet, "A scene", &[row(0), row(1)]);
        [0, 1].map(|i| sheet.findings[i].statement.clone())
    }

    fn said(error: f64, doubt: f64) -> String {
        let [cheapest, _] = statements([error, error], doubt, [0.0; 2]);
        cheapest
    }

    /// An error that is NaN is not within the wanted one, and K that is NaN is not kept.
    #[test]
    fn what_is_nan_is_neither_small_nor_kept() {
        let [cheapest, kept] = statements([f64::NAN, 1e-5], 0.0, [f64::NAN, 0.0]);
        assert!(cheapest.contains("is moddg at step"), "{cheapest}");
        assert!(kept.contains("by moddg (0.0e0) and not by rk4 (inf)"), "{kept}");
    }

    /// A method that keeps K does so in the runs that it completes: the others are named.
    #[test]
    fn runs_that_end_early_are_named_beside_those_that_keep_k() {
        let ended = WorkRow {
            h: 0.2,
            outcome: "newton-stalled",
            error_qp: None,
            error_w: None,
            ..row(0, [1e-5; 2], 0.0, [0.0; 2])
        };
        let mut sheet = Sheet::new("Work");
        cheapest(&mut sheet, "A scene", &[row(0, [1e-5; 2], 0.0, [0.0; 2]), ended]);
        let said = &sheet.findings[1].statement;
        assert!(said.starts_with("K is kept in every run that reached the end by rk4"), "{said}");
        assert!(
            said.ends_with(" Did not reach the end: rk4 at step = 0.2, newton-stalled."),
            "{said}"
        );
    }

    /// A study that was stopped has runs without times.
    #[test]
    fn a_run_within_the_error_that_was_not_timed_is_not_left_out() {
        let mut sheet = Sheet::new("Work");
        let untimed = WorkRow { seconds: None, ..row(0, [1e-5; 2], 0.0, [0.0; 2]) };
        cheapest(&mut sheet, "A scene", &[untimed]);
        let said = &sheet.findings[0].statement;
        assert_eq!(said, "no run that ends with errors of at most 1e-4 has been timed.");
    }

    /// A run may be within the wanted error although its reference cannot tell.
    #[test]
    fn a_reference_in_doubt_refutes_no_run() {
        assert!(
            said(1e-5, 1e-6).starts_with("the cheapest run with errors of at most 1e-4 is rk4")
        );
        assert_eq!(said(3e-3, 1e-6), "no run ends with errors of at most 1e-4.");
        let known = "no run is known to end with errors of at most 1e-4: the reference is known to";
        assert_eq!(said(6e-6, 4.8e-4), format!("{known} 4.8e-4 only."));
        assert_eq!(said(3e-3, 2.96e-3), format!("{known} 3.0e-3 only."));
    }
}
