//! Findings on the decay of the overdamped oscillator.

use crate::claim::{Readings, Said, fixed, list, sci, verdict};
use crate::findings::{KEPT, kept};
use crate::report::Verdict;
use afterbay_analysis::study::decay::{Decay, TOLERANCE};
use afterbay_analysis::study::outcome::COMPLETED;
use std::collections::BTreeMap;

/// Whether keeping K comes with a loss of energy 1 - R within a tenth of the exact loss.
pub(super) fn balance_and_decay(r: &Readings) -> Said {
    let [found, exact] = ["moddg", "the solution"].map(|of| r.number(of, "R"));
    let (drift, falls) = (r.number("moddg", "drift"), r.number("moddg", "falls of w"));
    let run = r.word("moddg", "run");
    let balanced = drift <= KEPT && falls == 0.0 && run == COMPLETED;
    let right = (found - exact).abs() <= TOLERANCE * (1.0 - exact);
    let says = match (balanced, right) {
        (true, true) => "the balance is exact and the decay is right",
        (true, false) => "the balance is exact and the decay is wrong",
        (false, true) => "the decay is right though the balance is not exact",
        (false, false) => "neither is the balance exact nor the decay right",
    };
    let w = if falls == 0.0 {
        "w rises at every step".to_owned()
    } else {
        format!("w falls at {falls} steps")
    };
    let statement = format!(
        "{says}. In the second step the energy ratio is exactly {} and modDG gives {}; modDG {} \
         (off by {} of it), and {w}. Its run: {run}.",
        fixed(exact, 4),
        fixed(found, 4),
        kept(drift),
        sci(drift),
    );
    (verdict(balanced && right), statement)
}

/// The largest error of an energy that counts as exact, relative to the energy at the start.
const ON_IT: f64 = 0.01;

/// States which energies agree with the exact one.
pub(super) fn energies(r: &Readings) -> Said {
    let one = |(label, off): (&str, f64)| {
        if off <= ON_IT {
            format!("{label} lies on it (off by {} of H₀ at most)", sci(off))
        } else if off.is_nan() {
            format!("{label} does not reach the end")
        } else {
            format!("{label} does not lie on it (off by {} of H₀)", sci(off))
        }
    };
    let all = r.numbers("off H₀ by").into_iter().map(one).collect::<Vec<_>>();
    (Verdict::Note, format!("of the exact energy, within {ON_IT} of H₀: {}.", all.join("; ")))
}

/// States which methods decay rightly at both frictions, and which at only one.
pub(super) fn trusted(r: &Readings) -> Said {
    let right = [Decay::Right, Decay::RightWithoutK].map(|decay| decay.to_string());
    let (wrong, mut wrongly) = (Decay::WrongWithK.to_string(), 0);
    let (mut both, mut once, mut later) = (Vec::new(), Vec::new(), Vec::new());
    let mut rest: BTreeMap<&str, usize> = BTreeMap::new();
    for name in r.of_all("b = 200") {
        let [soft, stiff] = ["b = 200", "b = 5000"].map(|b| r.word(name, b));
        wrongly += usize::from(soft == wrong);
        match [soft, stiff].map(|word| right.iter().any(|right| right == word)) {
            [true, true] => both.push(name.to_owned()),
            [true, false] => once.push(format!("{name} (at b = 5000: {stiff})")),
            [false, true] => later.push(format!("{name} (at b = 200: {soft})")),
            [false, false] => *rest.entry(soft).or_default() += 1,
        }
    }
    let rest = rest.into_iter().map(|(word, count)| format!("{count} \"{word}\""));
    let holds = !both.is_empty();
    let says = if holds {
        format!("{}: right at b = 200 and at b = 5000", list(both))
    } else {
        "no method is right at b = 200 and at b = 5000".to_owned()
    };
    let statement = format!(
        "{says}. Right at b = 200 only: {}. Right at b = 5000 only: {}. {} methods keep K and \
         decay wrongly at b = 200. Right at neither, by what becomes of them at b = 200: {}.",
        list(once),
        list(later),
        wrongly,
        list(rest),
    );
    (verdict(holds), statement)
}
