//! The efficiency of the compositions of sweeps: errors of q, p and w at equal numbers of sweeps,
//! on a damped FPUT-β chain and a ring of Van der Pol oscillators. Prints one table. There is no
//! timing, since a sweep costs the same in each composition.

use afterbay_core::System;
use afterbay_core::{Grid, Separable, Series, State, integrate, taylor};
use afterbay_methods::{Composition, Increment};
use afterbay_systems::{FputChain, VanDerPolRing};

const N: usize = 16;
const END: f64 = 5.0;
/// The numbers of sweeps per unit of time.
const RATES: [f64; 4] = [48.0, 96.0, 192.0, 384.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let chain = FputChain::new(N, 1.0, 0.05)?;
    let ring = VanDerPolRing::new(N, 1.0, 0.5)?;
    let sine = |j: usize| (std::f64::consts::PI * (j + 1) as f64 / (N + 1) as f64).sin();
    let wave = State::new(std::array::from_fn(sine), [0.0; N])?;
    let kicked = State::new(
        std::array::from_fn(|j| 2.0 * sine(3 * j)),
        std::array::from_fn(|j| sine(5 * j)),
    )?;
    println!("{:>44}  errors of (q, p) and of w with about so many sweeps for a unit of time", "");
    print!("{:44}", "");
    RATES.iter().for_each(|rate| print!("  {rate:^17}"));
    println!();
    table("chain", &chain, &chain.map(Series::<f64, 24>::constant), &wave)?;
    table("ring", &ring, &ring.map(Series::<f64, 24>::constant), &kicked)
}

fn table<S: Separable<f64>>(
    name: &str,
    system: &S,
    exact: &impl System<Series<f64, 24>>,
    start: &State<[f64; N]>,
) -> Result<(), Box<dyn std::error::Error>> {
    let end = &taylor::trajectory::<_, _, 24>(exact, start, END, 1)?[1];
    let off = |a: &[f64; N], b: &[f64; N]| {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    for (label, composition) in [
        ("order 2, a pair", Composition::pair()),
        ("order 4, Suzuki, 5 pairs", Composition::suzuki4()),
        ("order 4, Blanes and Moan, 12 sweeps", Composition::blanes_moan4()),
        ("order 6, Yoshida, 7 pairs", Composition::yoshida6()),
        ("order 6, McLachlan, 9 pairs", Composition::mclachlan6()),
        ("order 6, Blanes and Moan, 20 sweeps", Composition::blanes_moan6()),
        ("order 8, Kahan and Li, 17 pairs", Composition::kahan_li8()),
    ] {
        print!("{name:6}{label:38}");
        for rate in RATES {
            let count = (rate * END / composition.sweeps() as f64).round();
            let mut state = start.clone();
            let grid = Grid { h: END / count, steps: count as u64 };
            match integrate(&Increment::new(composition.clone()), system, grid, &mut state, &mut ())
            {
                Ok(_) => {
                    let qp = off(&state.q, &end.q).max(off(&state.p, &end.p));
                    print!("  {qp:>8.1e} {:>8.1e}", off(&state.w, &end.w));
                }
                Err(_) => print!("  {:>17}", "fails"),
            }
        }
        println!();
    }
    Ok(())
}
