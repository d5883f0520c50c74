//! A static form computes what the form behind `&dyn` traits does, to the bit.

use afterbay_core::{Abilities, Grid, State, Tolerance, f64x8};
use afterbay_inlined as inlined;
use afterbay_methods::registry::{self, METHODS, Run, Setting};
use afterbay_systems::{
    Custom, DampedDoublePendulum, DampedOscillator, Description, DissipationText, Duffing,
    FputChain, ModifiedVanDerPol, VanDerPol, VanDerPolRing,
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The bits of every state of a run, or the words of its failure.
fn trace(run: &Run<f64>, setting: Setting<f64>, start: &State<Vec<f64>>) -> (Vec<u64>, String) {
    let (mut state, mut bits) = (start.clone(), Vec::new());
    let end = run.run(setting, &mut state, 1, &mut |_, at| {
        bits.extend([at.q, at.p, at.w].into_iter().flatten().map(|x| x.to_bits()));
        ControlFlow::Continue(())
    });
    (bits, end.map_or_else(|error| format!("{error:?}"), |_| String::new()))
}

#[test]
fn a_static_form_computes_the_same_bits() {
    let custom = Custom::new(&Description {
        potential: "1 - cos(q1)".into(),
        dissipation: DissipationText::Forces(vec!["0.1*p1".into()]),
        ..Default::default()
    });
    let systems: [Arc<dyn Abilities<f64>>; 8] = [
        Arc::new(DampedOscillator::new(1.0, 0.1).unwrap()),
        Arc::new(Duffing::new(-1.0, 0.5, 0.1).unwrap()),
        Arc::new(VanDerPol::new(1.5).unwrap()),
        Arc::new(ModifiedVanDerPol::new(0.8, 1.0, 0.3).unwrap()),
        Arc::new(custom.unwrap()),
        Arc::new(DampedDoublePendulum::new([1.0, 0.7], [1.0, 1.2], 9.8, [0.1, 0.2]).unwrap()),
        Arc::new(FputChain::new(6, 0.5, 0.01).unwrap()),
        Arc::new(VanDerPolRing::new(6, 1.0, 0.3).unwrap()),
    ];
    let mut compared = 0;
    for system in systems {
        let q = [1.1, -0.4, 0.8, 0.1, -0.6, 0.3][..system.dof()].to_vec();
        let start = State::new(q.clone(), q.iter().map(|q| 0.3 - q).collect()).unwrap();
        for row in METHODS {
            let Some(form) = inlined::bind(row, &system) else { continue };
            let plain = registry::bind::<f64>(row, system.clone());
            let (Ok(form), Ok(plain)) = (form, plain) else {
                panic!("{} is bound in neither or both forms", row.name)
            };
            for h in [0.01, 0.1, 0.5] {
                let setting = if row.is_adaptive() {
                    Setting::Tolerance(Tolerance::all(h * 1e-5), 20.0)
                } else {
                    Setting::Step(Grid::of(h, 200).unwrap())
                };
                let [form, plain] = [&form, &plain].map(|run| trace(run, setting, &start));
                assert!(form.0.len() > 10, "{} {h}: {}", row.name, form.1);
                assert_eq!(form, plain, "{} {h}", row.name);
                compared += 1;
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn a_static_form_in_lanes_computes_the_same_bits() {
    let lanes = |from: f64| f64x8::from(std::array::from_fn(|k| from + 0.3 * k as f64));
    let [one, slack] = [f64x8::splat(1.0), lanes(-0.2)];
    let systems: [Arc<dyn Abilities<f64x8>>; 3] = [
        Arc::new(DampedOscillator::new(one, slack).unwrap()),
        Arc::new(Duffing::new(lanes(-1.0), lanes(0.1), slack).unwrap()),
        Arc::new(VanDerPol::new(slack).unwrap()),
    ];
    let start = State::new(vec![lanes(-0.9)], vec![lanes(0.4)]).unwrap();
    let mut compared = 0;
    for system in systems {
        for row in METHODS {
            let Some(form) = inlined::bind_lanes(row, &system) else { continue };
            let runs = [form, registry::bind::<f64x8>(row, system.clone())].map(Result::unwrap);
            for h in [0.01, 0.1, 0.5] {
                let [form, plain] = runs.each_ref().map(|run| {
                    let (mut state, mut bits) = (start.clone(), Vec::new());
                    let grid = Grid::<f64x8>::of(h, 200).unwrap();
                    let end = run.run(grid, &mut state, 1, &mut |_, at| {
                        let numbers = [at.q[0], at.p[0], at.w[0]];
                        bits.push(numbers.map(|x| x.to_array().map(f64::to_bits)));
                        ControlFlow::Continue(())
                    });
                    (bits, end.map_or_else(|error| format!("{error:?}"), |_| String::new()))
                });
                assert!(form.0.len() > 10, "{} {h}: {}", row.name, form.1);
                assert_eq!(form, plain, "{} {h}", row.name);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 27);
}
