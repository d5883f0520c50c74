//! A batch of points gives the bits of one point after the other, for any number of points.

use afterbay_core::{Abilities, Clocked, Drive, Driven, System};
use afterbay_systems::{
    Custom, CustomDrive, Described, Description, DissipationText, DriveDescription,
};
use std::sync::Arc;

fn description(potential: &str) -> Description {
    let forces = ["0.3*v1*(1 + q2^2)", "v2^3/10"].map(str::to_owned).to_vec();
    Description {
        potential: potential.into(),
        dissipation: DissipationText::Forces(forces),
        ..Default::default()
    }
}

fn check(system: &impl System<f64>) {
    assert!(system.has_batches());
    let n = system.dof();
    for count in 1..10 {
        let points = |shift: f64| -> Vec<Vec<f64>> {
            let at = |k: usize, j: usize| ((7 * k + 3 * j) as f64).sin() + shift;
            (0..count).map(|k| (0..n).map(|j| at(k, j)).collect()).collect()
        };
        let [q, p, v] = [0.1, 0.3, 0.7].map(points);
        let [mut hq, mut hp, mut d] = [(); 3].map(|()| vec![vec![f64::NAN; n]; count]);
        let [views_q, views_p, views_v] =
            [&q, &p, &v].map(|x| x.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let [mut to_hq, mut to_hp, mut to_d] = [&mut hq, &mut hp, &mut d]
            .map(|x| x.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>());
        system.gradients(&views_q, &views_p, &mut to_hq, &mut to_hp);
        system.dissipations(&views_q, &views_p, &views_v, &mut to_d);
        for k in 0..count {
            let [mut one_hq, mut one_hp, mut one_d] = [(); 3].map(|()| vec![f64::NAN; n]);
            system.gradient(&q[k], &p[k], &mut one_hq, &mut one_hp);
            system.dissipation(&q[k], &p[k], &v[k], &mut one_d);
            assert_eq!([&hq[k], &hp[k], &d[k]], [&one_hq, &one_hp, &one_d], "{k} of {count}");
        }
    }
}

#[test]
fn of_a_separable_system() {
    check(&Custom::new(&description("q1^2 + q2^4/4 + cos(q1 - q2)")).unwrap());
}

#[test]
fn of_a_system_with_a_clock() {
    let system = Described::separable(&description("q1^2*sin(t) + q2^4/4 + cos(q1 - q2)"));
    let Described::Clocked(system) = system.unwrap() else { panic!("it depends on t") };
    let system: Clocked<Custom<f64>> = system;
    check(&system);
}

#[test]
fn of_a_driven_system() {
    let system: Arc<dyn Abilities<f64>> =
        Arc::new(Custom::new(&description("q1^2 + q2^4/4 + cos(q1 - q2)")).unwrap());
    for forces in [["cos(t)", "0"], ["sin(t)*q2", "exp(-t)"]] {
        let forces = forces.map(str::to_owned).to_vec();
        let (drive, _) =
            CustomDrive::new(&DriveDescription { forces, ..Default::default() }, 2).unwrap();
        let drive: Arc<dyn Drive<f64>> = Arc::new(drive);
        check(&Driven::new::<f64>(system.clone(), drive).unwrap());
    }
}
