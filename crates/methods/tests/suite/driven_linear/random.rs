//! Random linear systems under random forces.

use super::{Case, distance};
use afterbay_core::{Quad, Scalar, System};
use afterbay_systems::DissipationText;
use proptest::prelude::*;

/// A random system and forces, as texts.
#[derive(Clone, Debug)]
struct Plan {
    potential: String,
    friction: Vec<Vec<String>>,
    masses: Vec<String>,
    forces: Vec<String>,
    /// Whether the matrix of the friction is diagonal.
    diagonal: bool,
}

impl Plan {
    fn case(&self) -> Case {
        let [masses, forces] = [&self.masses, &self.forces]
            .map(|texts| texts.iter().map(String::as_str).collect::<Vec<_>>());
        let drag = DissipationText::Matrix(self.friction.clone());
        Case::new(&self.potential, drag, &masses, &forces)
    }
}

fn number() -> impl Strategy<Value = f64> {
    // Numbers with few digits, so that texts hold them.
    (1..200_i32).prop_map(|x| f64::from(x) / 64.0)
}

prop_compose! {
    fn plans()(
        n in 1..=4_usize,
        [k, c, m, r, f] in prop::array::uniform5(prop::array::uniform4(number())),
        omega in prop::array::uniform2(number()),
        friction in prop::array::uniform4(0..3_u8),
        kinds in prop::array::uniform4(0..4_u8),
    ) -> Plan {
        let mut potential = String::from("0");
        let mut rows = vec![vec![0.0; n]; n];
        for j in 0..n {
            potential += &format!(" + {}*q{}^2", k[j], j + 1);
            match friction[j] {
                // Friction between neighbours keeps R symmetric and semidefinite.
                2 if j > 0 => {
                    rows[j][j] += r[j];
                    rows[j - 1][j - 1] += r[j];
                    rows[j][j - 1] -= r[j];
                    rows[j - 1][j] -= r[j];
                }
                1 => rows[j][j] += r[j],
                _ => {}
            }
            if j > 0 {
                potential += &format!(" + {}*(q{} - q{})^2", c[j], j, j + 1);
            }
        }
        let force = |j: usize| match kinds[j] {
            0 if j > 0 => "0".to_owned(),
            1 => format!("{} + {}*sin({}*t)", f[j], r[j], omega[1]),
            2 => format!("{}*cos({}*t) - sin({}*t + 1)/4", f[j], omega[0], omega[1]),
            _ => format!("{}*cos({}*t - {})", f[j], omega[0], k[j]),
        };
        Plan {
            potential,
            friction: rows.iter().map(|row| row.iter().map(f64::to_string).collect()).collect(),
            masses: m[..n].iter().map(f64::to_string).collect(),
            forces: (0..n).map(force).collect(),
            diagonal: (1..n).all(|j| friction[j] < 2),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(200)
    })]

    #[test]
    fn a_step_is_two_half_steps_and_keeps_k(
        plan in plans(), h in -3.0..1.48_f64, t0 in -2000..2000_i32,
        q in prop::array::uniform4(-2.0..2.0), p in prop::array::uniform4(-2.0..2.0),
    ) {
        // These times are added without rounding.
        let (h, t0) = ((10f64.powf(h) * 1048576.0).round() / 1048576.0, f64::from(t0) / 16.0);
        let case = plan.case();
        let n = case.custom.dof();
        let (run, fine) = (case.bound::<f64>().unwrap(), case.bound::<Quad>().unwrap());
        let start = case.start::<f64>([&q[..n], &p[..n]], t0);
        let mut exact = case.start::<Quad>([&q[..n], &p[..n]], t0);
        let (mut one, mut two) = (start.clone(), start.clone());
        run.step(h, &mut one).unwrap();
        for _ in 0..2 {
            run.step(h / 2.0, &mut two).unwrap();
        }
        // The terms of a step are as large as the energies on the way.
        let system = case.driven(|x| x);
        let mut size = start.energy(&*system).max(1.0);
        for _ in 0..16 {
            fine.step(Quad::from_f64(h / 16.0), &mut exact).unwrap();
            let parts = case.parts(&exact);
            size = parts.iter().flatten().fold(size, |most, x| most.max(x.to_f64().abs()));
        }
        let [exact, whole, halves] = [case.parts(&exact), case.parts(&one), case.parts(&two)];
        let off = [distance(&whole, &exact), distance(&halves, &exact)].map(|x| x / size);
        let drift = (one.total(&*system) - start.total(&*system)).abs() / size;
        prop_assert!(off[0] < 8e-15 && off[1] < 8e-15, "off by {:?} of {}", off, size);
        prop_assert!(drift < 8e-15, "K is off by {} of {}", drift, size);
        prop_assert!(!plan.diagonal || whole[2].iter().all(|w| w.to_f64() >= -1e-15 * size));
        for (motor, &p) in (n..).zip(&one.p[n..]) {
            prop_assert_eq!((one.q[motor], one.w[motor]), (t0 + h, -p));
        }
    }
}
