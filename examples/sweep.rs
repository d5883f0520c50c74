//! A sweep over a parameter, in parallel: the well in which a particle comes to rest, against the
//! damping. `cargo run --example sweep`

use afterbay_core::{Grid, State, integrate};
use afterbay_methods::ModDg;
use afterbay_systems::Duffing;
use rayon::prelude::*;
use std::error::Error;

/// A run: its damping, where the particle ends, and the error of K relative to the energy lost.
struct Run {
    damping: f64,
    end: f64,
    drift: f64,
}

/// V = -q²/2 + q⁴/4 has wells at q = -1 and q = 1, with a barrier at q = 0.
fn run(damping: f64) -> Result<Run, Box<dyn Error + Send + Sync>> {
    let system = Duffing::new(-1.0, 1.0, damping)?;
    let mut state = State::new([0.0], [3.0])?;
    let before = state.total(&system);
    integrate(&ModDg::newton(), &system, Grid::new(0.01, 400.0)?, &mut state, &mut ())?;
    let drift = (state.total(&system) - before).abs() / state.w[0];
    Ok(Run { damping, end: state.q[0], drift })
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    // The order of the results is that of the numbers, however many threads there are.
    let runs = (0..240)
        .into_par_iter()
        .map(|i| run(0.05 + 0.005 * f64::from(i)))
        .collect::<Result<Vec<_>, _>>()?;

    println!("The well in which the particle ends, by its damping c (< left, > right):");
    for row in runs.chunks(60) {
        let wells: String = row.iter().map(|run| if run.end < 0.0 { '<' } else { '>' }).collect();
        println!("from c = {:.3}  {wells}", row[0].damping);
    }
    let last = runs.iter().rfind(|run| run.end < 0.0).ok_or("no run ends in the left well")?;
    println!("Beyond c = {:.3} it stays in the right one.", last.damping);

    let drift = runs.iter().map(|run| run.drift).fold(0.0, f64::max);
    println!("K is off by {drift:.0e} of the energy lost at most, in {} runs.", runs.len());
    if runs.iter().any(|run| (run.end.abs() - 1.0).abs() > 0.1) {
        return Err("a particle has not come to rest".into());
    }
    if drift < 1e-11 { Ok(()) } else { Err("K is not kept".into()) }
}
