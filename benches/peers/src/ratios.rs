//! The time needed for a given error, interpolated between runs, and its ratio to that of another
//! method.

use super::measure::Row;

/// The errors of (q, p) at the end for which times are computed.
pub const TARGETS: [f64; 3] = [1e-4, 1e-8, 1e-11];

/// The method relative to which times are given.
pub const YARDSTICK: &str = "ode_solvers-dop853";

/// The targets of a scene: multiples of the time of [`YARDSTICK`], for C2 milliseconds.
pub fn bars(scene: &str) -> Option<[f64; 3]> {
    match scene {
        "A" => Some([0.02; 3]),
        "B" => Some([0.37, 0.57, 0.45]),
        "C1" => Some([0.51, 0.38, 0.31]),
        "C2" => Some([0.16, 0.5, 4.0]),
        "D64" => Some([0.22, 0.21, 0.35]),
        "D1024" => Some([0.25, 0.38, 0.37]),
        _ => None,
    }
}

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

/// The points (seconds, error of (q, p)) of the completed runs of a method.
pub fn points<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Vec<(f64, f64)> {
    rows.into_iter().filter_map(|row| Some((row.seconds?, row.error_qp?))).collect()
}

/// Whether K was conserved to rounding: its drift is below 1e-12 of its scale.
pub fn at_rounding(row: &Row) -> bool {
    row.keeps_k && row.k_drift <= 1e-12 * row.k_scale.max(f64::MIN_POSITIVE)
}

/// The times of a method for the targets. For the project's methods that conserve K, only runs that
/// did so count.
pub fn times(rows: &[Row], method: &str) -> [Option<Time>; 3] {
    let of = rows.iter().filter(|row| row.method == method && (!row.keeps_k || at_rounding(row)));
    let envelope = envelope(points(of));
    TARGETS.map(|error| time_to(&envelope, error))
}

/// For each target, the fastest of the project's methods that conserve K.
pub fn best(rows: &[Row]) -> [Option<(&'static str, Time)>; 3] {
    let mut names: Vec<_> =
        rows.iter().filter(|row| row.ours && row.keeps_k).map(|row| row.method).collect();
    names.dedup();
    let all: Vec<_> = names.iter().map(|name| (*name, times(rows, name))).collect();
    [0, 1, 2].map(|target| {
        let reached = all.iter().filter_map(|(name, times)| Some((*name, times[target]?)));
        reached.min_by(|a, b| a.1.seconds().total_cmp(&b.1.seconds()))
    })
}

/// One line of the table: the scene, the method, and a cell for each target.
pub type Entry = [String; 5];

/// The table of ratios of a scene: the target, the project's best method that conserves K, and each
/// other library.
pub fn table(rows: &[Row]) -> Vec<Entry> {
    let Some(scene) = rows.first().map(|row| row.problem) else { return Vec::new() };
    let absolute = scene == "C2";
    let yardstick = times(rows, YARDSTICK);
    let cell = |target: usize, time: Option<Time>| {
        let Some(time) = time else { return "not reached".to_owned() };
        let sign = if matches!(time, Time::AtMost(_)) { "≤ " } else { "" };
        let shown = |x: f64| format!("{sign}{x:.*}", if x < 0.1 { 4 } else { 2 });
        match yardstick[target] {
            _ if absolute => format!("{} ms", shown(1e3 * time.seconds())),
            Some(unit) => shown(time.seconds() / unit.seconds()),
            None => format!("{} ms", shown(1e3 * time.seconds())),
        }
    };
    let entry = |who: String, cells: [String; 3]| {
        let [a, b, c] = cells;
        [scene.to_owned(), who, a, b, c]
    };
    let mut table = Vec::new();
    if let Some(bars) = bars(scene) {
        table.push(entry(
            "bar".into(),
            bars.map(|bar| format!("{bar}{}", if absolute { " ms" } else { "" })),
        ));
    }
    let best = best(rows);
    let named = [0, 1, 2].map(|target| {
        let Some((name, time)) = best[target] else { return "not reached".to_owned() };
        format!("{} {name}", cell(target, Some(time)))
    });
    table.push(entry("ours, K kept".into(), named));
    let mut peers: Vec<_> = rows.iter().filter(|row| !row.ours).map(|row| row.method).collect();
    peers.dedup();
    for peer in peers {
        let times = times(rows, peer);
        table.push(entry(peer.into(), [0, 1, 2].map(|target| cell(target, times[target]))));
    }
    let milliseconds = yardstick.map(|time| {
        time.map_or("not reached".into(), |time| format!("{:.4} ms", 1e3 * time.seconds()))
    });
    table.push(entry(format!("{YARDSTICK}, time"), milliseconds));
    table
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
            row(YARDSTICK, false, 2.0, 1e-2, 1e-3),
            row(YARDSTICK, false, 4.0, 1e-6, 1e-7),
        ];
        let table = table(&rows);
        let cells = |who: &str| table.iter().find(|entry| entry[1] == who).unwrap()[2..].to_vec();
        assert_eq!(cells("bar"), ["0.37", "0.57", "0.45"]);
        assert_eq!(cells("ours, K kept"), ["0.50 slow", "not reached", "not reached"]);
        assert_eq!(cells(YARDSTICK), ["1.00", "not reached", "not reached"]);
    }
}
