//! References do not depend on units.

use super::{custom, known, of, problem};
use afterbay_analysis::{Doubt, Model};
use afterbay_systems::{
    Custom, CustomDrive, Described, Description, DissipationText, DriveDescription,
};

/// In units of 2^-50 and of 2^60 seconds, all digits of q are those in seconds, and those of p and
/// w but for the unit. The Taylor coefficients in seconds would be up to 2^1200.
#[test]
fn units_of_time_change_no_digit() {
    let of = |unit: f64| {
        let [k, g] = [unit.powi(-2), 0.1 / unit];
        let potential = format!("{k:?}*(q1^2/2 + q1^4/4)");
        let problem = of(custom(&potential, &[&format!("{g:?}*v1")]), &[1.5], &[0.0], 20.0 * unit);
        known(&problem, 8)
    };
    let seconds = of(1.0);
    for unit in [2.0_f64.powi(-50), 2.0_f64.powi(60)] {
        let found = of(unit);
        for (state, beside) in found.states().zip(seconds.states()) {
            assert_eq!(state.q, beside.q, "{unit:e}");
            assert_eq!([state.p[0] * unit, state.w[0] * unit * unit], [beside.p[0], beside.w[0]]);
            assert_eq!(state.t / unit, beside.t);
        }
    }
}

/// Motors add a coordinate that is a time and a momentum that is an energy. A driven scene is known
/// as well in units of 2^-43 and of 2^30 seconds, and of 2^-86 kilograms, as in those of 1. The
/// second scene has a kink, so that its reference comes from runs.
#[test]
fn units_do_not_count_in_the_doubt_of_driven_scenes() {
    for force in ["f*cos(o*t)", "f*cos(o*t)*(1 + 0.1*max(q1, 0))"] {
        let of = |m: f64, unit: f64| {
            let [k, c, f, o] = [m / unit / unit, 0.8 * m / unit, 0.5 * m / unit / unit, 1.9 / unit];
            let description = Description {
                potential: format!("{k:e}*(q1^2/2 + q1^4/4)"),
                dissipation: DissipationText::Forces(vec![format!("-{c:e}*(1 - q1^2)*v1")]),
                masses: vec![format!("{m:e}")],
                ..Description::default()
            };
            let drive = DriveDescription {
                forces: vec![force.to_owned()],
                parameters: [("f", f), ("o", o)].map(|(name, x)| (name.to_owned(), x)).into(),
                ..DriveDescription::default()
            };
            let (drive, _) = CustomDrive::new(&drive, 1).expect("a drive");
            let system = Custom::new(&description).expect("a system");
            let model = Model::Custom(Described::Separable(system));
            let model = Model::Driven(Box::new(model), drive);
            let Doubt { q, p, w } = known(&problem(model, &[1.0], &[0.0], 21.0 * unit), 21).doubt();
            [q, p / m * unit, w / m * unit * unit]
        };
        let one = of(1.0, 1.0);
        assert!(one.iter().all(|&doubt| doubt < 1e-9), "{force}: {one:?}");
        let (atom, fast, slow) = (2_f64.powi(-86), 2_f64.powi(-43), 2_f64.powi(30));
        for (m, unit) in [(1.0, fast), (1.0, slow), (atom, 1.0), (atom, fast)] {
            let found = of(m, unit);
            println!("{force}, m = {m:e}, unit {unit:e}: {found:?} beside {one:?}");
            let alike = |(found, one): (f64, f64)| found < 10.0 * one && one < 10.0 * found;
            assert!(found.into_iter().zip(one).all(alike), "{m:e} {unit:e}: {found:?} {one:?}");
        }
    }
}
