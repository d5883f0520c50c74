//! Methods at several steps beside a reference: their labels, and charts of their states.

use crate::chart::{Curve, LineChart};
use crate::claim::significant;
use crate::sheet::{Sheet, dotted};
use afterbay_methods::registry::{REFERENCE, Row};

/// The label of the reference.
pub(super) const REFERENCE_LABEL: &str = REFERENCE.name;

/// The label of a method and its step, which has four digits: what is found belongs to the label.
pub(super) fn label(row: &Row, h: f64) -> String {
    match row.name {
        REFERENCE_LABEL => REFERENCE_LABEL.into(),
        name => format!("{name}, h = {}", significant(h, 4)),
    }
}

/// A sentence that names the method and the step of the reference; empty if there is none.
pub(super) fn of_reference(h: Option<f64>) -> String {
    h.map_or(String::new(), |h| {
        format!(" The reference takes steps of nearly {h:.2e} with DOP853.")
    })
}

/// The states of a method and a step, as the points of a chart.
pub(super) struct States {
    pub(super) row: &'static Row,
    pub(super) label: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// Shows a chart of the states of each method above those of the reference, or a chart of the
/// reference if nothing else was computed. `chart` makes one from a label and curves.
pub(super) fn show_states(
    sheet: &mut Sheet,
    data: &str,
    found: &[States],
    chart: impl Fn(&str, Vec<Curve>) -> LineChart,
) {
    let of_exact = |states: &&States| states.row.name == REFERENCE_LABEL;
    let exact = found.iter().find(of_exact);
    for (nth, states) in found.iter().enumerate() {
        if of_exact(&states) && found.len() > 1 {
            continue;
        }
        let own = Some(states).filter(|states| !of_exact(states));
        let curves = exact.into_iter().chain(own);
        let curves = curves.map(|states| dotted(&states.label, states.points.clone())).collect();
        let name = format!("{data}-{}-{nth}", states.row.name);
        let caption = "Grey: the reference. It lies below the method.";
        sheet.show(&name, &chart(&states.label, curves), caption, data);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_methods::registry::find;

    #[test]
    fn a_step_has_four_digits_however_short_it_is() {
        let rk4 = find("rk4").expect("a method");
        let labels = [1e-5, 4e-5, 2e-3, 0.0123, 0.0124, 0.1, 1e7].map(|h| label(rk4, h));
        let ends = ["1.000e-5", "4.000e-5", "0.002000", "0.01230", "0.01240", "0.1000", "1.000e7"];
        assert_eq!(labels, ends.map(|end| format!("rk4, h = {end}")));
    }
}
