//! Contact by Hertz's law, a power of max(.., 0): a bounce in closed form, and a chain of beads.

use afterbay_analysis::Model;
use afterbay_analysis::progress::Silent;
use afterbay_analysis::study::work_precision::Runs;
use afterbay_analysis::study::{Problem, global_order, work_precision};
use afterbay_methods::registry::{METHODS, Row, bind, find};
use afterbay_systems::{Custom, Described, Description, DissipationText};

fn scene(potential: &str, friction: &[&str], q: &[f64], p: &[f64], end: f64) -> Problem {
    let forces = friction.iter().map(ToString::to_string).collect();
    let description = Description {
        potential: potential.to_owned(),
        dissipation: DissipationText::Forces(forces),
        ..Description::default()
    };
    let system = Custom::new(&description).expect("a system");
    let model = Model::Custom(Described::Separable(system));
    Problem { model, q: q.to_vec(), p: p.to_vec(), end }
}

/// A bead of unit mass and velocity touches the wall V = max(q, 0)^(5/2) at t = 1 and leaves it
/// after
///
/// ```text
/// 2^(3/5) √π Γ(7/5)/Γ(9/10)
/// ```
#[test]
fn a_bead_bounces_off_a_wall() {
    let contact = 2.230_585_478_339_950_2;
    let scene = scene("max(q1, 0)^2.5", &["0*v1"], &[-1.0], &[1.0], 4.0);
    let found = scene.solution(4.0, 1, &Silent).expect("a reference");
    let doubt = found.doubt_at(1).qp();
    let off = (found.at(1).q[0] + 4.0 - 1.0 - contact).abs().max((found.at(1).p[0] + 1.0).abs());
    println!("off by {off:e}, doubt {doubt:e}");
    assert!(off <= doubt + 1e-15 && doubt < 1e-9, "off by {off:e}, doubt {doubt:e}");
}

/// Three beads in a row, pressed together from the second contact on.
fn beads() -> Problem {
    let potential = "max(q1 - q2, 0)^2.5 + max(q2 - q3 - 0.3, 0)^(5/2) + q3^2/2";
    let friction = ["0.1*(v1 - v2)", "0.1*(2*v2 - v1 - v3)", "0.1*(v3 - v2)"];
    scene(potential, &friction, &[0.0; 3], &[1.5, 0.0, 0.0], 3.0)
}

#[test]
fn steps_through_contacts_have_their_order() {
    let methods: Vec<&Row> = ["increment-2", "gonzalez", "implicit-midpoint"]
        .map(|name| find(name).expect("a method"))
        .into();
    let steps = [0.01, 0.005, 0.0025, 0.00125];
    let rows = global_order::run(&beads(), &methods, &steps, &Silent).expect("orders");
    for row in rows.iter().filter(|row| row.h < 0.01) {
        let order = row.order.expect("an order");
        assert!((order - 2.0).abs() < 0.1, "{} of {} at {}", row.method, row.variable, row.h);
    }
}

/// Every method that keeps K does so through contacts; some end, and say why.
#[test]
fn k_is_kept_through_contacts() {
    let beads = beads();
    let system = beads.model.system::<f64>().expect("a system");
    let fixed: Vec<&Row> = METHODS
        .iter()
        .filter(|row| row.keeps_k && !row.is_adaptive() && bind(row, system.clone()).is_ok())
        .collect();
    let adaptive: Vec<&Row> = METHODS
        .iter()
        .filter(|row| row.keeps_k && row.is_adaptive() && bind(row, system.clone()).is_ok())
        .collect();
    let runs =
        Runs { methods: &fixed, steps: &[0.05, 0.01], adaptive: &adaptive, tolerances: &[1e-6] };
    let rows = work_precision::run(&beads, runs, &Silent).expect("runs");
    let completed = rows.iter().filter(|row| row.outcome == "completed");
    assert!(completed.clone().count() > 20, "{}", completed.count());
    for row in completed {
        assert!(row.k_drift < 1e-13, "{} at {}: {:e}", row.method, row.h, row.k_drift);
    }
}
