//! Verdicts do not depend on the units of time, mass and length.

use super::{rows, spread};
use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::Problem;
use afterbay_analysis::study::stability::{Map, Verdict};
use afterbay_systems::{Custom, Described, Description, DissipationText};

/// m q'' = -a k q - b k q³/l² - c (1 - s q²/l²) q' with k = m/t², from q = x l at rest.
struct Scene {
    a: f64,
    b: f64,
    s: f64,
    x: f64,
}

/// The verdicts on a scene in units of time, mass and length.
fn verdicts(Scene { a, b, s, x }: &Scene, [t, m, l]: [f64; 3]) -> Vec<Verdict> {
    let [k, b] = [a * m / t / t, b * m / t / t / l / l];
    let s = s / l / l;
    let description = Description {
        potential: format!("{k:e}*q1^2/2 + {b:e}*q1^4/4"),
        dissipation: DissipationText::Forces(vec![format!("c*(1 - {s:e}*q1^2)*v1")]),
        masses: vec![format!("{m:e}")],
        parameters: vec![("c".into(), m / t)],
        ..Default::default()
    };
    let system = Custom::new(&description).expect("a system");
    let model = Model::Custom(Described::Separable(system));
    let problem = Problem { model, q: vec![x * l], p: vec![0.0], end: 42.0 * t };
    let values: Vec<f64> = spread(6, 0.0, 1.0).into_iter().map(|c| c * m / t).collect();
    let steps = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.4].map(|h| h * t);
    let (end, least_steps) = (42.0 * t, 1);
    let map = Map { problem, parameter: "c", values: &values, steps: &steps, end, least_steps };
    let cells = map.run(&rows(&["rk4", "moddg", "leapfrog", "relaxed-rk4"]), &Silent);
    cells.expect("a map").into_iter().map(|cell| cell.verdict).collect()
}

#[test]
fn units_change_no_verdict() {
    let scenes = [
        Scene { a: 1.0, b: 0.0, s: 0.0, x: 1.0 },
        Scene { a: -1.0, b: 1.0, s: 0.0, x: 1.5 },
        Scene { a: 1.0, b: 0.2, s: 1.0, x: 1.0 },
    ];
    let [small, large] = [2_f64.powi(-40), 2_f64.powi(23)];
    for scene in scenes {
        let one = verdicts(&scene, [1.0; 3]);
        assert!(one.contains(&Verdict::Right) && one.contains(&Verdict::Wrong), "{one:?}");
        assert!(!one.contains(&Verdict::Unjudged), "{one:?}");
        for i in 0..3 {
            for unit in [small, large] {
                let mut units = [1.0; 3];
                units[i] = unit;
                let differ = verdicts(&scene, units).into_iter().zip(&one).filter(|(a, b)| a != *b);
                let differ: Vec<_> = differ.collect();
                assert!(differ.is_empty(), "{units:?}: {differ:?}");
            }
        }
        // Atoms and picoseconds, planets and months.
        for units in [[2_f64.powi(-43), 2_f64.powi(-86), 2_f64.powi(-33)], [large, 2e24, 2e11]] {
            let units = units.map(|unit: f64| unit.log2().round().exp2());
            assert_eq!(verdicts(&scene, units), one, "{units:?}");
        }
    }
}
