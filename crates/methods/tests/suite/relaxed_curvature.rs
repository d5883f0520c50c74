//! Relaxation where H is not strictly convex along the motion: the orders stay.

use crate::catalog::{As, written, written_general};
use crate::many::orders::check_orders;
use afterbay_core::Quad;
use afterbay_methods::registry::find;
use afterbay_systems::{Description, DissipationText, GeneralDescription};

/// Where H is not strictly convex K hardly depends on γ at some steps. They had the error of a step
/// that ends at the wrong place: with h = 0.05 up to 1e5 times that of RK4 on the second system.
#[test]
fn orders_where_k_hardly_depends_on_gamma() {
    let forces = |forces: &[&str]| {
        DissipationText::Forces(forces.iter().map(|&force| force.to_owned()).collect())
    };
    let two_wells = written(&Description {
        potential: "(q1^4 + q2^4)/4 - (q1^2 + q2^2)/2 + 0.3*(q1 - q2)^2".to_owned(),
        dissipation: forces(&["0.1*p1", "0.05*p2*(1 + q1^2)"]),
        ..Description::default()
    });
    let valley = written_general(&GeneralDescription {
        hamiltonian: "(p1 + q1)^2/2 + (p2 + q2)^2/2 + (q1 - q2)^4/8".to_owned(),
        dissipation: forces(&["0.1*v1", "0.2*v2"]),
        ..GeneralDescription::default()
    });
    for system in [two_wells, valley] {
        for (name, order, counts) in [
            ("relaxed-rk4", 4.0, [400, 500, 640, 800]),
            ("relaxed-dop853", 8.0, [320, 400, 480, 560]),
        ] {
            let run = system.bind::<Quad>(find(name).unwrap(), As::Curved).unwrap();
            let start: [&[f64]; 2] = [&[0.3, -0.6], &[0.9, 0.4]];
            check_orders(name, (&run, &*system.series()), start, (8.0, counts), (order, 0.1));
        }
    }
}
