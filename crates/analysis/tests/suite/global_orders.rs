//! Orders are measured where errors are resolved, in any units, and nowhere else.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::{Problem, global_order};
use afterbay_methods::registry::find;
use afterbay_systems::{Custom, DUFFING, Described, Description, DissipationText};

/// The motion leaves the saddle and returns so close to it that roundings decide the side on which
/// it goes on.
#[test]
fn what_is_not_resolved_shows_no_order() {
    let well = Model::of(&DUFFING, &[-1.0, 1.0, 0.0]);
    let scene = Problem { model: well, q: vec![1e-30], p: vec![0.0], end: 200.0 };
    let rk4 = [find("rk4").expect("a method")];
    let rows = global_order::run(&scene, &rk4, &[0.02, 0.01], &Silent).expect("orders");
    for row in rows.iter().filter(|row| row.variable != "w") {
        let measured = row.measured().expect("it ended");
        println!("{}: {measured}, order {:?}", row.variable, row.order);
        assert!(measured.to_string().starts_with('≤') && row.order.is_none(), "{row:?}");
        assert!(row.doubt > 0.1, "{row:?}");
    }
}

/// In units in which p is smaller or larger than q by fourteen powers of ten or more, the doubts of
/// q, p and w are each of its own size.
#[test]
fn orders_are_measured_in_any_units() {
    let scales: [(f64, f64, f64, f64); 2] =
        [(3e-10, 1e-24, 1e-26, 1e-2), (3e10, 2e27, 6e24, 6.7e9)];
    for (q, p, mass, k) in scales {
        let friction = format!("{}*v1", 0.1 * (k * mass).sqrt());
        let description = Description {
            potential: format!("{k:?}*q1^2/2 + {:?}*q1^4", k / (4.0 * q * q)),
            dissipation: DissipationText::Forces(vec![friction]),
            masses: vec![mass.to_string()],
            ..Description::default()
        };
        let h = 0.1 * (mass / k).sqrt();
        let system = Custom::new(&description).expect("a system");
        let model = Model::Custom(Described::Separable(system));
        let scene = Problem { model, q: vec![q], p: vec![p], end: 40.0 * h };
        let rk4 = [find("rk4").expect("a method")];
        let rows = global_order::run(&scene, &rk4, &[h, h / 2.0], &Silent).expect("orders");
        for row in rows.iter().filter(|row| row.h < h) {
            assert!(row.order.is_some_and(|order| (order - 4.0).abs() < 0.3), "{row:?}");
        }
    }
}
