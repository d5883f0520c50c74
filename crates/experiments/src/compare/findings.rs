//! The sentences of a comparison.

use super::join::{Column, Joined, Measure};
use super::trajectories::{Distance, VARIABLES};
use crate::claim::{Readings, Said, list, sci};
use crate::report::Verdict;

/// The most columns that a sentence names.
const NAMED: usize = 6;

/// The numbers of scenes' keys and of tables that differ, are in one result only or come from
/// another scene than their result.
pub(super) struct Counts {
    pub(super) scene: usize,
    pub(super) tables_in_one: usize,
    pub(super) of_another: usize,
}

/// The readings of all tables together.
pub(super) fn overall(counts: &Counts, tables: &[Joined]) -> Readings {
    let sum = |of: &dyn Fn(&Joined) -> usize| tables.iter().map(of).sum::<usize>();
    let in_one = |table: &Joined| table.columns_in_one.iter().map(Vec::len).sum();
    let entries = |table: &Joined| table.different().map(|column| column.different).sum();
    let times = |table: &Joined| table.times().map(|column| column.different).sum();
    Readings::default()
        .and("tables", "in both", tables.len())
        .and("tables", "in one", counts.tables_in_one)
        .and("tables", "of another scene", counts.of_another)
        .and("rows", "in both", sum(&|table| table.rows))
        .and("rows", "in A only", sum(&|table| table.rows_in_one[0]))
        .and("rows", "in B only", sum(&|table| table.rows_in_one[1]))
        .and("columns", "in one", sum(&in_one))
        .and("entries", "different", sum(&entries))
        .and("times", "different", sum(&times))
        .and("scenes", "different keys", counts.scene)
}

/// States whether the results are equal, and how much differs.
pub(super) fn equal_or_not(r: &Readings) -> Said {
    let of = |of: &str, what: &str| r.number(of, what);
    let parts = [
        ("entries", "different", ""),
        ("rows", "in A only", " in A only"),
        ("rows", "in B only", " in B only"),
        ("columns", "in one", " in one only"),
        ("tables", "in one", " in one only"),
    ];
    let found: Vec<_> = (parts.into_iter())
        .filter(|(nouns, what, _)| of(nouns, what) != 0.0)
        .map(|(nouns, what, place)| counted(of(nouns, what), nouns) + place)
        .collect();
    let times = |word: &str| match of("times", "different") {
        0.0 => String::new(),
        times => format!("{word} {}", counted(times, "times")),
    };
    let differ = match found.is_empty() {
        true => format!("nothing differs{}", times(" but")),
        false => format!("they differ in {}{}", list(found), times("; and in")),
    };
    let rows = counted(of("rows", "in both"), "rows");
    let tables = counted(of("tables", "in both"), "tables");
    let mut statement = format!("{differ}. Compared: {rows} of {tables}.");
    match of("scenes", "different keys") {
        0.0 => statement.push_str(" The scenes are equal."),
        keys => statement.push_str(&format!(" The scenes differ in {}.", counted(keys, "keys"))),
    }
    let of_another = of("tables", "of another scene");
    if of_another != 0.0 {
        let tables = counted(of_another, "tables");
        statement.push_str(&format!(" Left out, since they come from another scene: {tables}."));
    }
    (Verdict::Note, statement)
}

/// A time without the roundings of its sum.
fn time(t: f64) -> String {
    format!("{t:.9e}").parse().map_or_else(|_| t.to_string(), |t: f64| t.to_string())
}

/// A ratio with two significant digits, or with those of its distance from 1.
fn ratio(x: f64) -> String {
    match (x - 1.0, x.abs()) {
        (0.0, _) => "1".into(),
        (off, _) if off.abs() < 0.05 => {
            format!("1 {} {:.1e}", if off < 0.0 { '-' } else { '+' }, off.abs())
        }
        (_, 0.1..10.0) => format!("{x:.2}"),
        (_, 10.0..1e4) => format!("{x:.0}"),
        _ => sci(x),
    }
}

/// A count with its noun, from the plural: `1 entry`, `2 rows`.
fn counted(count: f64, nouns: &str) -> String {
    match nouns {
        _ if count != 1.0 => format!("{count} {nouns}"),
        "entries" => format!("{count} entry"),
        _ => format!("{count} {}", nouns.trim_end_matches('s')),
    }
}

/// The readings of a table: of the columns that differ, and of times.
pub(super) fn of_table(table: &Joined) -> Readings {
    let all = Readings::default()
        .and("rows", "in both", table.rows)
        .and("rows", "in A only", table.rows_in_one[0])
        .and("rows", "in B only", table.rows_in_one[1]);
    let mut shown: Vec<&Column> = table.different().collect();
    shown.truncate(NAMED);
    shown.extend(table.times());
    let mut all = shown.into_iter().fold(all, |r, column| {
        let name = &column.name;
        let r = r.and(name, "different", column.different).and(name, "in one", column.empty);
        match (column.measure, column.range) {
            (_, None) => r,
            (Measure::Difference, Some([lo, hi])) => {
                r.and(name, "largest difference", lo.abs().max(hi.abs()))
            }
            (_, Some([lo, hi])) => r.and(name, "least ratio", lo).and(name, "largest ratio", hi),
        }
    });
    let more = table.different().count().saturating_sub(NAMED);
    all.add("columns", "not named", more);
    all
}

/// States which columns of a table differ, and by how much.
pub(super) fn columns_that_differ(r: &Readings) -> Said {
    let rows = r.number("rows", "in both");
    let one = |(name, count): (&str, f64)| {
        let size = |what: &str| r.number(name, what);
        let (least, most, off) =
            (size("least ratio"), size("largest ratio"), size("largest difference"));
        let by = match (least.is_nan(), off.is_nan()) {
            (false, _) => format!(", B/A from {} to {}", ratio(least), ratio(most)),
            (true, false) => format!(", by {} at most", sci(off)),
            (true, true) => String::new(),
        };
        let empty = match size("in one") {
            0.0 => String::new(),
            empty => format!(" (empty in A or in B: {empty})"),
        };
        format!("{name} in {count}{empty}{by}")
    };
    let mut columns: Vec<_> = r.numbers("different").into_iter().map(one).collect();
    let more = r.number("columns", "not named");
    if more != 0.0 {
        columns.push(counted(more, "more columns"));
    }
    let mut statement = format!(
        "of {} in both, {}.",
        counted(rows, "rows"),
        match &columns[..] {
            [] => "none differs".to_owned(),
            _ => format!("these differ: {}", columns.join("; ")),
        }
    );
    for (what, name) in [("in A only", "A"), ("in B only", "B")] {
        match r.number("rows", what) {
            0.0 => {}
            count => {
                statement.push_str(&format!(" In {name} only: {}.", counted(count, "rows")));
            }
        }
    }
    (Verdict::Note, statement)
}

/// The readings of trajectories: for each run the largest distance in each variable, and when. Of
/// many runs, those that differ most.
pub(super) fn of_trajectories(found: &[Distance]) -> Readings {
    let mut runs: Vec<&[Distance]> = found.chunk_by(|a, b| a.run == b.run).collect();
    let more = runs.len().saturating_sub(NAMED);
    if more > 0 {
        let known = |distance: Option<f64>| distance.unwrap_or(f64::INFINITY);
        let size =
            |run: &[Distance]| run.iter().flat_map(Distance::each).map(known).fold(0.0, f64::max);
        runs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        runs.truncate(NAMED);
    }
    let all = Readings::default().and("runs", "not named", more);
    runs.into_iter().fold(all, |r, run| {
        let name = &run[0].run;
        let r = r.and(name, "common times", run.len());
        VARIABLES.iter().enumerate().fold(r, |r, (i, variable)| {
            let sizes = run.iter().map(|one| Some((one.each()[i]?, one.t)));
            let larger = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 { b } else { a };
            let most = sizes.reduce(|a, b| Some(larger(a?, b?))).flatten();
            r.and(name, variable, most.map(|most| most.0)).and(
                name,
                &format!("{variable} at"),
                most.map(|most| most.1),
            )
        })
    })
}

/// States the largest distance of each trajectory.
pub(super) fn largest_distances(r: &Readings) -> Said {
    let one = |(name, times): (&str, f64)| {
        let largest = VARIABLES.map(|variable| {
            let (size, t) = (r.number(name, variable), r.number(name, &format!("{variable} at")));
            if size.is_nan() {
                return format!("{variable} by an unknown amount");
            }
            if size == 0.0 {
                return format!("{variable} by 0");
            }
            format!("{variable} by {} (t = {})", sci(size), time(t))
        });
        format!("{name} at {}, {}", counted(times, "common times"), list(largest))
    };
    let mut all: Vec<_> = r.numbers("common times").into_iter().map(one).collect();
    let more = r.number("runs", "not named");
    if more != 0.0 {
        all.push(counted(more, "more runs"));
    }
    let statement = match &all[..] {
        [] => "the results have no common times.".into(),
        all => format!("at most these differences: {}.", all.join("; ")),
    };
    (Verdict::Note, statement)
}

#[cfg(test)]
mod tests {
    use super::{Distance, counted, largest_distances, of_trajectories, ratio};

    #[test]
    fn a_distance_that_is_not_finite_is_the_largest() {
        let at = |t: f64, q| Distance { run: "rk4".into(), t, q, p: Some(0.1), w: Some(0.0) };
        let found = [at(0.0, Some(0.0)), at(1.0, None), at(2.0, Some(0.5))];
        let (_, said) = largest_distances(&of_trajectories(&found));
        let all = "rk4 at 3 common times, q by an unknown amount, p by 1.0e-1 (t = 0) and w by 0";
        assert_eq!(said, format!("at most these differences: {all}."));
    }

    #[test]
    fn ratios_near_1_read_as_sums() {
        assert_eq!([0.998, 1.0, 1.002, 0.15].map(ratio), ["1 - 2.0e-3", "1", "1 + 2.0e-3", "0.15"]);
    }

    #[test]
    fn nouns_follow_their_count() {
        let said = [(1.0, "entries"), (2.0, "entries"), (1.0, "common times"), (0.0, "keys")]
            .map(|(count, nouns)| counted(count, nouns));
        assert_eq!(said, ["1 entry", "2 entries", "1 common time", "0 keys"]);
    }
}
