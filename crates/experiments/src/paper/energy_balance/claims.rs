//! Findings on errors and energies over time, figures 4.1 to 4.4.

use crate::claim::{Readings, Said, list, sci, verdict};
use crate::findings::{KEPT, keeps, kept};
use crate::paper::rule::{MAGNITUDE, alike};
use crate::report::Verdict;

/// "errors remain of constant magnitude" from δ₃ to δ₄.
pub(super) fn order_raised(r: &Readings) -> Said {
    let (three, four) = ("moddg-q3-shared", "moddg-q4-shared");
    let pair = |what: &str| (r.number(three, what), r.number(four, what));
    let (median, maximum) = (pair("median"), pair("maximum"));
    let same = [median, maximum].map(|(three, four)| alike(three, four));
    let keep = [three, four].iter().all(|name| r.number(name, "drift") <= KEPT);
    let says = match same {
        [true, true] => {
            "the local errors of q stay of one magnitude, in the median and at their largest"
        }
        [true, false] => {
            "the local errors of q stay of one magnitude in the median, not at their largest"
        }
        [false, true] => {
            "the local errors of q stay of one magnitude at their largest, not in the median"
        }
        [false, false] => "the local errors of q do not stay of one magnitude",
    };
    let statement = format!(
        "{says}: from δ₃(q) to δ₄(q) the median goes from {} to {}, the maximum from {} to {}. K \
         is off by {} and {} of it: {}.",
        sci(median.0),
        sci(median.1),
        sci(maximum.0),
        sci(maximum.1),
        sci(r.number(three, "drift")),
        sci(r.number(four, "drift")),
        if keep { "both keep K" } else { "not both keep K" },
    );
    (verdict(same == [true, true] && keep), statement)
}

/// "For q our scheme and SV are both committing errors of order magnitude 10⁻⁷", of T as section 2
/// defines it.
pub(super) fn errors_of_one_magnitude(r: &Readings) -> Said {
    const PRINTED: f64 = 1e-7;
    let of = |name: &str| ["median", "maximum"].map(|what| r.number(name, what));
    let are = |name: &str| of(name).iter().all(|&size| alike(size, PRINTED));
    let (moddg, leapfrog) = (are("moddg"), are("leapfrog"));
    let says = match (moddg, leapfrog) {
        (true, true) => "both have errors T of q of this magnitude",
        (true, false) => "moddg has errors T of q of this magnitude, leapfrog has not",
        (false, true) => "leapfrog has errors T of q of this magnitude, moddg has not",
        (false, false) => "neither has errors T of q of this magnitude",
    };
    let h = r.number("step", "h");
    let all = ["moddg", "leapfrog", "rk4"].map(|name| {
        let [median, maximum] = of(name);
        format!("{name} {} / {}", sci(median), sci(maximum))
    });
    let statement = format!(
        "at h = {h} {says}. Median / maximum of T: {}. The error of one step, h T, has the median \
         {} with moddg and {} with leapfrog.",
        list(all),
        sci(h * of("moddg")[0]),
        sci(h * of("leapfrog")[0]),
    );
    (verdict(moddg && leapfrog), statement)
}

fn drifts(r: &Readings) -> String {
    let all = r.numbers("drift").into_iter().map(|(name, drift)| format!("{name} {}", sci(drift)));
    format!("max |K - K₀|/K₀ at h = {}: {}", r.number("step", "h"), list(all))
}

/// "SV scheme underperforms": holds if its drift of K exceeds the other two by more than a
/// magnitude.
pub(super) fn underperforms(r: &Readings) -> Said {
    let drift = |name: &str| r.number(name, "drift");
    let worse = |name: &str| drift("leapfrog") > MAGNITUDE * drift(name);
    let says = match (worse("moddg"), worse("rk4")) {
        (true, true) => "leapfrog is off K by more than a magnitude beyond both others",
        (true, false) => "leapfrog is off K by more than a magnitude beyond moddg alone",
        (false, true) => "leapfrog is off K by more than a magnitude beyond rk4 alone",
        (false, false) => "leapfrog is not off K by more than a magnitude beyond the others",
    };
    (verdict(worse("moddg") && worse("rk4")), format!("{says}. {}.", drifts(r)))
}

/// "modDG goes head to head with eRK4": holds if their drifts of K are of one magnitude.
pub(super) fn head_to_head(r: &Readings) -> Said {
    let (moddg, rk4) = (r.number("moddg", "drift"), r.number("rk4", "drift"));
    let level = alike(moddg, rk4);
    let says = if level {
        "moddg and rk4 are off K by the same magnitude"
    } else if rk4 > moddg {
        "rk4 is off K by more than a magnitude beyond moddg"
    } else if moddg > rk4 {
        "moddg is off K by more than a magnitude beyond rk4"
    } else {
        "the two cannot be compared"
    };
    let statement = format!("{says}; moddg {}, rk4 {}. {}.", kept(moddg), kept(rk4), drifts(r));
    (verdict(level), statement)
}

/// "modDG retains this same behavior even when we substitute simpler expression for the δ
/// function."
pub(super) fn simpler_delta(r: &Readings) -> Said {
    let all = r.numbers("drift");
    let lost: Vec<_> = all.iter().filter(|(_, drift)| !keeps(*drift)).collect();
    let holds = lost.is_empty() && !all.is_empty();
    let says = if holds {
        "every δ shared by the three equations keeps K".to_owned()
    } else {
        format!("K is lost with {}", list(lost.iter().map(|(name, _)| name.to_string())))
    };
    let all = all.iter().map(|(name, drift)| format!("{name} {}", sci(*drift)));
    (verdict(holds), format!("{says}. max |K - K₀|/K₀: {}.", list(all)))
}

/// The energy ratio, and whether it is more accurate where K is kept better.
pub(super) fn energy_ratio(r: &Readings) -> Said {
    let all = r.numbers("d_R");
    let keep = |name: &str| r.number(name, "drift") <= KEPT;
    let least = |keeps: bool| {
        let of = all.iter().filter(|(name, _)| keep(name) == keeps);
        of.map(|(_, worst)| *worst).reduce(f64::min).unwrap_or(f64::NAN)
    };
    let says = if least(true) <= least(false) {
        "the most accurate of these keeps K"
    } else if least(false) < least(true) {
        "the most accurate of these does not keep K: to keep it does not by itself make the energy \
         ratio accurate"
    } else {
        "those that keep K and those that do not cannot be compared"
    };
    let all = all.iter().map(|(name, worst)| {
        format!("{name} {} (K off by {})", sci(*worst), sci(r.number(name, "drift")))
    });
    (Verdict::Note, format!("{says}. max |d_R|: {}.", list(all)))
}
