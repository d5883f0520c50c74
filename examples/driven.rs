//! A driven oscillator: what a force supplies in a period and friction takes, by three methods of
//! the registry. `cargo run --example driven`

use afterbay_core::{
    Abilities, Drive, Driven, Grid, Harmonic, Harmonics, Motors, State, accounts, validate,
    with_motors,
};
use afterbay_methods::registry::{bind, find};
use afterbay_systems::DampedOscillator;
use std::f64::consts::{PI, TAU};
use std::{error::Error, ops::ControlFlow, sync::Arc};

/// F = f cos ωt on the first degree of freedom.
struct Shaker {
    f: f64,
    omega: f64,
}

impl Drive<f64> for Shaker {
    fn driven(&self) -> &[usize] {
        &[0]
    }
    fn force(&self, _k: usize, _q: &[f64], t: f64) -> f64 {
        self.f * (self.omega * t).cos()
    }
    fn slopes(&self, _k: usize, _q: &[f64], t: f64, put: &mut dyn FnMut(Option<usize>, f64)) {
        put(None, -self.f * self.omega * (self.omega * t).sin()); // ∂F/∂t
    }
    fn harmonics(&self, _k: usize) -> Option<Harmonics<f64>> {
        let term = Harmonic { frequency: self.omega, cosine: self.f, sine: 0.0 };
        Some(Harmonics { constant: 0.0, terms: vec![term] }) // `linear-exact` needs it
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (k, b, f, omega) = (1.0, 0.2, 0.5, 1.2_f64);
    let shaker = Shaker { f, omega };
    validate::drive(&shaker, &[0.0], 0.0)?;
    let oscillator: Arc<dyn Abilities<f64>> = Arc::new(DampedOscillator::new(k, b)?);
    let system = Arc::new(Driven::<_, dyn Drive<f64>>::new(oscillator, Arc::new(shaker))?);
    let motors = Motors { has_clock: false, driven: vec![0] };
    // π b ω A² a period, with the amplitude A of the steady motion.
    let exact = PI * b * omega * f * f / ((k - omega * omega).powi(2) + (b * omega).powi(2));
    for (name, bound) in [("leapfrog", 2e-3), ("collocation-4", 1e-5), ("linear-exact", 1e-10)] {
        let run = bind::<f64>(find(name).ok_or("no such method")?, system.clone())?;
        let mut state = with_motors(&State::new(vec![1.0], vec![0.0])?, motors.count());
        let mut after = |periods: u64| {
            let grid = Grid::of(TAU / omega / 100.0, 100 * periods)?;
            run.run(grid, &mut state, u64::MAX, &mut |_, _| ControlFlow::Continue(()))?;
            Ok::<_, Box<dyn Error>>(accounts(state.state_ref(), &motors)?)
        };
        let [before, end] = [after(60)?, after(1)?];
        let (supplied, lost) = (end.s[0] - before.s[0], end.w[0] - before.w[0]);
        println!("{name:13} a period: {supplied:.9} supplied, {lost:.9} dissipated");
        if (supplied - exact).abs().max((lost - exact).abs()) > bound * exact {
            return Err("these are not the energies of the steady motion".into());
        }
    }
    Ok(())
}
