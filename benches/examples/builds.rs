//! Two builds of a bench in turn: the ratio of the new time to the old one for every row.
//!
//! ```text
//! cargo run --release -p afterbay-benches --example builds -- OLD NEW [COLUMNS] [TURNS]
//! ```
//!
//! OLD and NEW are executables of one bench that prints a table: its path is what
//! `cargo bench -p afterbay-benches --no-run` prints. A row is a name, then columns of figures, all
//! separated by two spaces or more. The first COLUMNS (1) of them are times. Each of TURNS (15)
//! turns runs both builds, so that load on the machine slows both alike, and every second turn
//! runs the new one first. Printed are the median over the turns of the ratio within a turn, and
//! an interval that contains the true median with 95 % confidence (from 6 turns on), whatever the
//! distribution.

use std::collections::BTreeMap;
use std::error::Error;
use std::process::Command;

/// The ratios of a row, one a turn.
type Ratios = BTreeMap<String, Vec<f64>>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [old, new, rest @ ..] = arguments.as_slice() else {
        return Err("give the old and the new executable of a bench".into());
    };
    let columns = rest.first().map_or(Ok(1), |text| text.parse::<usize>())?;
    let turns = rest.get(1).map_or(Ok(15), |text| text.parse::<usize>())?;

    let mut ratios = Ratios::new();
    for turn in 0..turns {
        let order = if turn % 2 == 0 { [old, new] } else { [new, old] };
        let mut times = [times(order[0], columns)?, times(order[1], columns)?];
        times.rotate_left(turn % 2);
        let [before, now] = times;
        for (name, before) in before {
            // A row that only one of the builds has is left out.
            if let Some(now) = now.get(&name) {
                ratios.entry(name).or_default().push(now / before);
            }
        }
    }
    println!("{:64} {:>7}  95 % of {turns} turns", "new / old", "median");
    for (name, mut ratios) in ratios {
        ratios.sort_unstable_by(f64::total_cmp);
        let cut = cut(ratios.len());
        let (low, high) = (ratios[cut], ratios[ratios.len() - 1 - cut]);
        println!("{name:64} {:7.3}  {low:.3} to {high:.3}", ratios[ratios.len() / 2]);
    }
    Ok(())
}

/// The times that a bench prints, by the name of the row and the number of the column.
fn times(bench: &str, columns: usize) -> Result<BTreeMap<String, f64>, Box<dyn Error>> {
    let output = Command::new(bench).arg("--bench").output()?;
    if !output.status.success() {
        return Err(format!("{bench}: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let text = String::from_utf8(output.stdout)?;
    let mut times = BTreeMap::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|x| !x.is_empty()).collect();
        let names = cells.iter().skip(1).take_while(|cell| cell.parse::<f64>().is_err()).count();
        let Some((name, figures)) = cells.split_at_checked(names + 1) else { continue };
        for (column, figure) in figures.iter().take(columns).enumerate() {
            if let Ok(time) = figure.parse::<f64>() {
                times.insert(format!("{}, column {}", name.join(" "), column + 1), time);
            }
        }
    }
    Ok(times)
}

/// The number k of values to leave out at either end of n sorted ones, so that the others contain
/// the median of the distribution with a probability of at least 0.95: the largest k with
/// 2 P(B ≤ k) ≤ 0.05, B binomial with n and 1/2. Zero where there is none, for n < 6.
fn cut(n: usize) -> usize {
    let (mut probability, mut below) = (0.5_f64.powi(n as i32), 0.0);
    for k in 0..n {
        below += probability;
        if 2.0 * below > 0.05 {
            return k.saturating_sub(1);
        }
        probability *= (n - k) as f64 / (k + 1) as f64;
    }
    0
}
