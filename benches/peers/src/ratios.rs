//! The time needed for a given error, interpolated between runs, and its ratio to that of the
//! other libraries.

use super::measure::Row;

/// The errors at the end for which times are computed.
pub const TARGETS: [f64; 3] = [1e-4, 1e-8, 1e-11];

/// The part of the state whose error is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The coordinates and momenta (q, p).
    Qp,
    /// The reservoirs w.
    W,
}

impl Part {
    /// Both parts.
    pub const BOTH: [Self; 2] = [Self::Qp, Self::W];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Qp => "(q, p)",
            Self::W => "w",
        }
    }

    fn error(self, row: &Row) -> Option<f64> {
        match self {
            Self::Qp => row.error_qp,
            Self::W => row.error_w,
        }
    }
}

/// The libraries, by the beginning of the names of their methods.
pub const LIBRARIES: [(&str, &str); 6] = [
    ("Boost.odeint", "boost-"),
    ("heyoka", "heyoka-"),
    ("LSODA", "numbalsoda-"),
    ("ode_solvers", "ode_solvers-"),
    ("differential-equations", "de-"),
    ("diffsol", "diffsol-"),
];

/// The time needed for an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Time {
    /// Interpolated between two neighbouring points, log-log.
    Between(f64),
    /// The fastest run of all is at least as accurate.
    AtMost(f64),
}

impl Time {
    /// The time in seconds.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Between(seconds) | Self::AtMost(seconds) => seconds,
        }
    }
}

/// The points (time, error) that no other point beats in both, from the fastest to the slowest.
pub fn envelope(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.retain(|point| point.0 > 0.0 && point.1.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    points.retain(|point| {
        let better = point.1 < least;
        least = least.min(point.1);
        better
    });
    points
}

/// The time at which an envelope reaches an error; `None` if it does not.
pub fn time_to(envelope: &[(f64, f64)], error: f64) -> Option<Time> {
    let next = envelope.iter().position(|point| point.1 <= error)?;
    let to = envelope[next];
    let Some(&from) = next.checked_sub(1).and_then(|before| envelope.get(before)) else {
        return Some(Time::AtMost(to.0));
    };
    if to.1 == error {
        return Some(Time::Between(to.0));
    }
    // An error of 0 has no logarithm; it is replaced by the rounding of 1.
    let [high, low, error] = [from.1, to.1, error].map(|x| x.max(f64::EPSILON).ln());
    let part = if high > low { ((high - error) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
    Some(Time::Between((from.0.ln() + part * (to.0.ln() - from.0.ln())).exp()))
}

/// The points (seconds, error) of the completed runs. Runs of the project's methods that conserve K
/// count only if they did so to rounding.
pub fn points<'a>(rows: impl IntoIterator<Item = &'a Row>, part: Part) -> Vec<(f64, f64)> {
    rows.into_iter()
        .filter(|row| !row.keeps_k || at_rounding(row))
        .filter_map(|row| Some((row.seconds?, part.error(row)?)))
        .collect()
}

/// Whether K was conserved to rounding: its drift is below 1e-12 of its scale.
pub fn at_rounding(row: &Row) -> bool {
    row.keeps_k && row.k_drift <= 1e-12 * row.k_scale.max(f64::MIN_POSITIVE)
}

/// The times of a method for the targets.
pub fn times(rows: &[Row], method: &str, part: Part) -> [Option<Time>; 3] {
    let envelope = envelope(points(rows.iter().filter(|row| row.method == method), part));
    TARGETS.map(|error| time_to(&envelope, error))
}

/// A method and its time.
pub type Fastest = Option<(&'static str, Time)>;

/// For each target, the fastest of the methods that `which` selects.
pub fn fastest(rows: &[Row], part: Part, which: impl Fn(&Row) -> bool) -> [Fastest; 3] {
    let mut names: Vec<_> = rows.iter().filter(|row| which(row)).map(|row| row.method).collect();
    names.dedup();
    let all: Vec<_> = names.iter().map(|name| (*name, times(rows, name, part))).collect();
    [0, 1, 2].map(|target| {
        let reached = all.iter().filter_map(|(name, times)| Some((*name, times[target]?)));
        reached.min_by(|a, b| a.1.seconds().total_cmp(&b.1.seconds()))
    })
}

/// The method that applies only to linear systems. It is shown apart from the fastest of the
/// others.
const LINEAR: &str = "linear-exact";

/// Whether a row is of one of the project's methods that conserve K and take any system.
pub fn is_ours(row: &Row) -> bool {
    row.ours && row.keeps_k && row.method != LINEAR
}

/// For each target, the fastest of the project's methods that conserve K and take any system.
pub fn ours(rows: &[Row], part: Part) -> [Fastest; 3] {
    fastest(rows, part, is_ours)
}

/// For each target, the fastest method of the other libraries.
pub fn others(rows: &[Row], part: Part) -> [Fastest; 3] {
    fastest(rows, part, |row| !row.ours)
}

/// One line of a table: the scene, the part, the method, and a cell for each target.
pub type Entry = [String; 6];

/// The header of [`table`] and [`summary`].
pub const HEADER: [&str; 6] = ["scene", "error of", "", "1e-4", "1e-8", "1e-11"];

/// The times of a scene: the fastest of the project's methods that conserve K, the fastest of the
/// other libraries, the ratio of the two, the exact flow of a linear scene, and every method of the
/// other libraries.
pub fn table(rows: &[Row]) -> Vec<Entry> {
    let mut peers: Vec<_> = rows.iter().filter(|row| !row.ours).map(|row| row.method).collect();
    peers.dedup();
    let of = |part: Part| {
        let mut table = summary(rows, part);
        let linear = rows.iter().find(|row| row.method == LINEAR).map(|row| row.method);
        for peer in linear.iter().chain(&peers) {
            let cells = times(rows, peer, part).map(|time| time.map_or(unreached(), shown));
            table.extend(entry(rows, part, peer, cells));
        }
        table
    };
    Part::BOTH.into_iter().flat_map(of).collect()
}

/// The first three lines of [`table`].
pub fn summary(rows: &[Row], part: Part) -> Vec<Entry> {
    let [ours, others] = [ours(rows, part), others(rows, part)];
    let named = |found: Fastest| {
        found.map_or(unreached(), |(name, time)| format!("{} {name}", shown(time)))
    };
    let ratio =
        [0, 1, 2].map(|k| ratio(ours[k], others[k]).map_or("-".into(), |x| format!("{x:.2}")));
    [
        entry(rows, part, "afterbay, K exact", ours.map(named)),
        entry(rows, part, "fastest other", others.map(named)),
        entry(rows, part, "ratio", ratio),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn entry(rows: &[Row], part: Part, who: &str, [a, b, c]: [String; 3]) -> Option<Entry> {
    let scene = rows.first()?.problem;
    Some([scene.into(), part.name().into(), who.into(), a, b, c])
}

/// The quotient of two times, if both are known.
pub fn ratio(ours: Fastest, other: Fastest) -> Option<f64> {
    Some(ours?.1.seconds() / other?.1.seconds())
}

/// The cases in which another library is faster, as a sentence each.
pub fn slower(rows: &[Row]) -> Vec<String> {
    let Some(scene) = rows.first().map(|row| row.problem) else { return Vec::new() };
    let mut cases = Vec::new();
    for part in Part::BOTH {
        for (k, (ours, other)) in ours(rows, part).into_iter().zip(others(rows, part)).enumerate() {
            let Some((peer, _)) = other else { continue };
            let case = format!("{scene}, {} to {:e}", part.name(), TARGETS[k]);
            match (ours, ratio(ours, other)) {
                (Some((name, _)), Some(ratio)) if ratio > 1.0 => {
                    cases.push(format!("{case}: {name} takes {ratio:.2} times as long as {peer}."));
                }
                (None, _) => cases.push(format!("{case}: reached by {peer} and by none of ours.")),
                _ => {}
            }
        }
    }
    cases
}

fn unreached() -> String {
    "not reached".into()
}

fn shown(time: Time) -> String {
    let sign = if matches!(time, Time::AtMost(_)) { "≤ " } else { "" };
    let us = 1e6 * time.seconds();
    let digits = if us < 100.0 { 1 } else { 0 };
    format!("{sign}{us:.digits$} µs")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_drops_what_is_beaten() {
        let points = vec![
            (4.0, 1e-3),
            (1.0, 1e-1),
            (2.0, 1e-2),
            (3.0, 5e-2),
            (2.0, 2e-2),
            (5.0, 1e-3),
            (0.5, f64::NAN),
        ];
        assert_eq!(envelope(points), [(1.0, 1e-1), (2.0, 1e-2), (4.0, 1e-3)]);
    }

    #[test]
    fn powers_are_interpolated_exactly() {
        // error = time^-4
        let curve: Vec<_> = [1.0, 2.0, 4.0, 8.0].map(|t: f64| (t, t.powi(-4))).into();
        for t in [1.5_f64, 2.0, 3.0, 7.9] {
            let Some(Time::Between(found)) = time_to(&curve, t.powi(-4)) else {
                panic!("{t} is not reached")
            };
            assert!((found / t - 1.0).abs() < 1e-12, "{found} for {t}");
        }
    }

    #[test]
    fn nothing_is_extrapolated() {
        let curve = [(1.0, 1e-3), (2.0, 1e-6)];
        assert_eq!(time_to(&curve, 1e-7), None);
        assert_eq!(time_to(&curve, 1e-2), Some(Time::AtMost(1.0)));
        assert_eq!(time_to(&[], 1e-2), None);
    }

    #[test]
    fn an_exact_end_counts_as_rounding() {
        let found = time_to(&[(1.0, 1.0), (4.0, 0.0)], f64::EPSILON.sqrt());
        assert!(matches!(found, Some(Time::Between(t)) if (t - 2.0).abs() < 1e-12), "{found:?}");
    }

    fn row(method: &'static str, ours: bool, seconds: f64, error: f64, drift: f64) -> Row {
        Row {
            method,
            h: None,
            outcome: "completed",
            error_qp: Some(error),
            error_w: Some(error),
            k_drift: drift,
            passivity_violations: None,
            seconds: Some(seconds),
            steps: None,
            evaluations: None,
            iterations: None,
            problem: "B",
            tolerance: None,
            k_scale: 1.0,
            keeps_k: ours,
            ours,
            failure: None,
        }
    }

    #[test]
    fn a_ratio_is_one_of_times_at_the_same_error() {
        let rows = [
            row("slow", true, 1.0, 1e-2, 1e-15),
            row("slow", true, 2.0, 1e-6, 1e-15),
            // Twice as fast, but K is not conserved.
            row("lossy", true, 0.5, 1e-2, 1e-9),
            row("lossy", true, 1.0, 1e-6, 1e-9),
            row("boost-x", false, 2.0, 1e-2, 1e-3),
            row("boost-x", false, 4.0, 1e-6, 1e-7),
        ];
        let lines = summary(&rows, Part::Qp);
        let cells = |who: &str| lines.iter().find(|entry| entry[2] == who).unwrap()[3..].to_vec();
        assert_eq!(cells("ratio"), ["0.50", "-", "-"]);
        assert_eq!(cells("fastest other")[1], "not reached");
        assert!(slower(&rows).is_empty());
    }

    #[test]
    fn what_is_slower_is_named() {
        let rows = [
            row("ours", true, 4.0, 1e-2, 1e-15),
            row("ours", true, 8.0, 1e-6, 1e-15),
            row("boost-x", false, 2.0, 1e-2, 1e-3),
            row("boost-x", false, 4.0, 1e-6, 1e-7),
            row("boost-x", false, 8.0, 1e-10, 1e-9),
        ];
        let cases = slower(&rows);
        assert_eq!(cases[0], "B, (q, p) to 1e-4: ours takes 2.00 times as long as boost-x.");
        assert_eq!(cases[1], "B, (q, p) to 1e-8: reached by boost-x and by none of ours.");
    }
}
