//! K in a long run: the table, the chart and the growth of its deviation.

use crate::chart::{Axis, Curve, LineChart};
use crate::claim::Readings;
use crate::sheet::{marked, scientific};
use afterbay_analysis::statistics::Fit;
use afterbay_analysis::study::long_run::LongRun;

/// The largest difference of two exponents that agree, however narrow their intervals.
const AGREEMENT: f64 = 0.05;

/// The conclusion from an exponent of 0.
const NOT_GROWING: &str = "not growing";

/// The conclusion from an exponent whose interval allows all of them.
const NOT_KNOWN: &str = "not known";

/// The share of the largest energy from which on K is lost. That energy contains the errors of H
/// and w, so that larger deviations show no growth.
const LOST: f64 = 0.1;

/// The conclusion from a deviation that has grown and is level at the end, and the reading of it.
const AT_FIRST: &str = "at first, and level at the end";
const LEVEL: &str = "level";

/// The reading of a deviation that is as large as the energy.
const ALL_LOST: &str = "lost";

/// The header of a table of [`cells`].
pub(crate) const HEADER: [&str; 7] = [
    "method and step",
    "exponent of t",
    "interval",
    "grows",
    "rms at the end",
    "mean at the end",
    "run",
];

/// The deviation of K of each run over the time, which `time` names.
pub(crate) fn chart(title: &str, time: &str, found: &[LongRun]) -> LineChart {
    LineChart {
        title: title.into(),
        x: Axis::log(time),
        y: Axis::log("|K - K₀| / largest energy, rms of a window"),
        curves: found.iter().map(curve).collect(),
        guides: vec![0.5, 1.0],
    }
}

/// The caption of a [`chart`].
pub(crate) const CAPTION: &str = "Deviation of K relative to the largest energy so far, root \
     mean square over the samples of a window and the starts. Dashed: growth like √t and like t.";

fn curve(run: &LongRun) -> Curve {
    marked(&run.setup.label(), run.rows.iter().map(|row| (row.t, row.rms)).collect())
}

/// The conclusion from an exponent, as far as its interval allows one.
pub(crate) fn grows(fit: &Fit) -> &'static str {
    // Two windows determine a line and no interval.
    let Some(margin) = fit.margin.map(|margin| margin.max(AGREEMENT)) else { return NOT_KNOWN };
    let may_be = |exponent: f64| (fit.slope - exponent).abs() <= margin;
    if (may_be(0.0) || fit.slope < 0.0) && !may_be(0.5) {
        return NOT_GROWING;
    }
    match (may_be(0.5), may_be(1.0)) {
        (true, true) if may_be(0.0) => NOT_KNOWN,
        (true, true) => "like √t or like t",
        (true, false) if may_be(0.0) => "like √t, or not at all",
        (true, false) => "like √t",
        (false, true) => "like t",
        (false, false) if fit.slope < 0.5 => "slower than √t",
        (false, false) if fit.slope < 1.0 => "faster than √t, slower than t",
        (false, false) => "faster than t",
    }
}

/// The cells of a run.
pub(crate) fn cells(run: &LongRun) -> Vec<String> {
    let (growth, last) = (run.growth(), run.rows.last());
    vec![
        run.setup.label(),
        growth.map_or(String::new(), |fit| format!("{:.2}", fit.slope)),
        growth.and_then(|fit| fit.margin).map_or(String::new(), |margin| format!("± {margin:.2}")),
        growth.as_ref().map_or(String::new(), |fit| conclusion(fit, at_end(run)).into()),
        scientific(last.map(|row| row.rms)),
        scientific(last.map(|row| row.mean)),
        run.ending.describe(),
    ]
}

/// The readings of long runs: the deviation of K at the end, its growth, and the ending of the run.
pub(crate) fn readings(found: &[LongRun], steps: u64) -> Readings {
    found.iter().fold(Readings::default().and("run", "steps", steps), |mut r, run| {
        let (label, growth) = (run.setup.label(), run.growth());
        if let Some(how) = at_end(run) {
            r.add(&label, "at the end", how);
        }
        r.and(&label, "rms", run.rows.last().map(|row| row.rms))
            .and(&label, "exponent", growth.as_ref().map(|fit| fit.slope))
            .and(&label, "margin", growth.as_ref().and_then(|fit| fit.margin))
            .and(&label, "run", run.ending.outcome)
    })
}

/// The growth of the deviation of one run, from its readings.
pub(crate) fn growth(r: &Readings, label: &str) -> String {
    let (slope, margin) = (r.number(label, "exponent"), r.number(label, "margin"));
    if r.number(label, "rms") == 0.0 {
        return NOT_GROWING.into();
    }
    if slope.is_nan() {
        return "growth not known".into();
    }
    let fit = Fit { slope, margin: (!margin.is_nan()).then_some(margin), points: 0 };
    let interval = fit.margin.map_or(String::new(), |margin| format!(" ± {margin:.2}"));
    let growing = match conclusion(&fit, Some(r.word(label, "at the end"))) {
        NOT_GROWING => NOT_GROWING.to_owned(),
        NOT_KNOWN => format!("growth {NOT_KNOWN}"),
        how => format!("growing {how}"),
    };
    format!("{growing} (exponent {slope:.2}{interval})")
}

/// The deviation at the end of a run in a word, if it is lost or level.
fn at_end(run: &LongRun) -> Option<&'static str> {
    match run.rows.last() {
        Some(row) if row.rms.is_nan() || row.rms >= LOST => Some(ALL_LOST),
        _ => run.is_level().then_some(LEVEL),
    }
}

/// The conclusion from an exponent and from the deviation [`at_end`].
fn conclusion(fit: &Fit, at_end: Option<&str>) -> &'static str {
    match (grows(fit), at_end) {
        (NOT_GROWING, _) => NOT_GROWING,
        (NOT_KNOWN, _) | (_, Some(ALL_LOST)) => NOT_KNOWN,
        (_, Some(LEVEL)) => AT_FIRST,
        (how, _) => how,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_that_falls_is_not_growing() {
        let said = |slope| grows(&Fit { slope, margin: Some(0.1), points: 9 });
        assert_eq!([-1.07, -0.3, 0.05].map(said), [NOT_GROWING; 3]);
        assert_eq!([0.3, 0.5, 1.0].map(said), ["slower than √t", "like √t", "like t"]);
        let unsure = grows(&Fit { slope: 0.34, margin: Some(0.36), points: 9 });
        assert_eq!(unsure, "like √t, or not at all");
    }

    /// Two windows determine a line without an interval, and three may leave it wide.
    #[test]
    fn a_growth_that_few_windows_do_not_show_is_not_known() {
        let said = |slope, margin| grows(&Fit { slope, margin, points: 3 });
        assert_eq!([said(-9.76, None), said(1.0, None), said(-0.03, Some(2.3))], [NOT_KNOWN; 3]);
        assert_eq!(said(-0.03, Some(0.6)), "like √t, or not at all");
    }

    /// The energy of RK4 on a damped oscillator is off by what the motion had at first.
    #[test]
    fn a_deviation_that_has_grown_and_is_level_says_so() {
        let fit = Fit { slope: 0.5, margin: Some(0.14), points: 8 };
        assert_eq!(conclusion(&fit, Some(LEVEL)), "at first, and level at the end");
        assert_eq!(conclusion(&fit, None), "like √t");
        assert_eq!(conclusion(&fit, Some(ALL_LOST)), NOT_KNOWN);
        assert_eq!(conclusion(&Fit { slope: 0.0, ..fit }, Some(LEVEL)), NOT_GROWING);
    }
}
