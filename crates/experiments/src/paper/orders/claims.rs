//! Findings on the orders of figures 3.1 to 3.4 and of the text around them.

use super::RAISED_EACH;
use crate::claim::{Readings, Said, fixed, list, sci, verdict};
use crate::findings::{KEPT, kept};
use crate::paper::rule::{AGREEMENT, agree, order};
use crate::report::Verdict;

/// A printed order holds if the scheme keeps K and shows the order from both the maximum and the
/// median.
pub(super) fn the_scheme(r: &Readings) -> Said {
    let (Some(&(variable, printed)), Some(&(name, maximum))) =
        (r.numbers("printed").first(), r.numbers("maximum").first())
    else {
        return (Verdict::Fails, "nothing was measured.".into());
    };
    let (median, drift) = (r.number(name, "median"), r.number(name, "drift"));
    let says = match (agree(maximum, printed), agree(median, printed)) {
        (true, true) => "both agree",
        (true, false) => "only the maximum agrees",
        (false, true) => "only the median agrees",
        (false, false) => "neither agrees",
    };
    let holds = agree(maximum, printed) && agree(median, printed) && drift <= KEPT;
    let statement = format!(
        "order of {variable} printed {printed}; {name} gives {} from the maximum and {} from the \
         median: {says}. It {} (off by {} of it). Its largest error is made at t = {}, {} from a \
         pole of δ.",
        order(maximum),
        order(median),
        kept(drift),
        sci(drift),
        fixed(r.number(name, "worst t"), 3),
        sci(r.number(name, "distance to the pole")),
    );
    (verdict(holds), statement)
}

/// Finds the variant whose order from the maximum is nearest to the printed one.
pub(super) fn what_fits(r: &Readings) -> Said {
    let printed = r.numbers("printed").first().map_or(f64::NAN, |(_, printed)| *printed);
    let maxima = r.numbers("maximum");
    let off = |maximum: f64| (maximum - printed).abs();
    let known = maxima.iter().filter(|(_, maximum)| !off(*maximum).is_nan());
    let Some(&(name, maximum)) = known.min_by(|a, b| off(a.1).total_cmp(&off(b.1))) else {
        return (Verdict::Fails, "nothing was measured.".into());
    };
    let fits = agree(maximum, printed);
    let nearest = if fits {
        format!("{printed} is what {name} gives")
    } else {
        format!("no variant gives {printed}; {name} comes nearest")
    };
    let all = maxima.iter().map(|(name, maximum)| {
        let (median, drift) = (r.number(name, "median"), r.number(name, "drift"));
        format!("{name} {} / {} (K off by {})", order(*maximum), order(median), sci(drift))
    });
    let statement = format!(
        "{nearest}, from the maximum, and it {}. Maximum / median: {}.",
        kept(r.number(name, "drift")),
        list(all)
    );
    (verdict(fits), statement)
}

/// "so order of the method is p_e = p_t = 4": holds if a method that keeps K has this order in q, p
/// and w.
pub(super) fn fourth_order(r: &Readings) -> Said {
    let keeps = |name: &str| r.number(name, "drift") <= KEPT;
    let all = r.numbers("least order");
    let known = all.iter().filter(|(name, least)| keeps(name) && !least.is_nan());
    let count = known.clone().count();
    let Some(&(name, least)) = known.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return (Verdict::Fails, "no variant keeps K.".into());
    };
    let holds = least >= 4.0 - AGREEMENT;
    let says = if holds {
        format!("{name} keeps K and has a median order of {} at least in q, p and w", order(least))
    } else {
        format!(
            "of the variants that keep K none has a median order above {} in all of q, p and w \
             ({name} has it)",
            order(least)
        )
    };
    let kept = all.iter().filter(|(name, _)| keeps(name));
    let kept = kept.map(|(name, least)| format!("{name} {}", order(*least)));
    let statement = format!(
        "{says}. {count} of {} keep K, with these as the least of their three orders: {}.",
        all.len(),
        list(kept)
    );
    (verdict(holds), statement)
}

/// States what separate δ in the first two equations gain and lose.
pub(super) fn raised_each(r: &Readings) -> Said {
    let orders = r.numbers("median");
    let (fourth, less): (Vec<_>, Vec<_>) =
        orders.iter().partition(|(_, median)| agree(*median, 4.0));
    let name =
        |all: Vec<&(&str, f64)>| list(all.into_iter().map(|(variable, _)| variable.to_string()));
    let drift = r.number(RAISED_EACH, "drift");
    let medians =
        list(orders.iter().map(|(variable, median)| format!("{variable} {}", order(*median))));
    let statement = format!(
        "{RAISED_EACH} reaches order 4 in {}, not in {} (medians: {medians}), and {} (off by {} of \
         it).",
        name(fourth.iter().collect()),
        name(less.iter().collect()),
        kept(drift),
        sci(drift),
    );
    (Verdict::Note, statement)
}

/// Whether the maxima depend on the horizon and the medians do not.
pub(super) fn hang_on_the_horizon(r: &Readings) -> Said {
    let (maxima, medians) = (r.number("maxima", "spread"), r.number("medians", "spread"));
    let moves = |spread: f64| {
        if spread <= AGREEMENT {
            "stay"
        } else if spread.is_nan() {
            "are not known"
        } else {
            "move"
        }
    };
    let statement = format!(
        "from [0, {}] to [0, {}] the orders from the median {} (by {} at most), those from the \
         maximum {} (by {} at most).",
        r.number("horizon", "least"),
        r.number("horizon", "largest"),
        moves(medians),
        fixed(medians, 3),
        moves(maxima),
        fixed(maxima, 3),
    );
    (Verdict::Note, statement)
}
