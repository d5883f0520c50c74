//! A system given by its formulas alone: its second derivatives, and every method of the registry.

use crate::bind::Curved;
use crate::catalog::{Built, written};
use afterbay_core::{
    Abilities, Curvature, DissipationForm, Formulas, FromFormulas, Grid, Passive, Scalar, State,
};
use afterbay_methods::registry::{self, FIXED, Row, Setting};
use afterbay_systems::{Description, DissipationText};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Two coupled pendulums with unequal masses and dissipation that couples the velocities.
struct Coupled;

impl Formulas for Coupled {
    fn dof(&self) -> usize {
        2
    }
    fn potential<T: Scalar>(&self, q: &[T]) -> T {
        let apart = q[0] - q[1];
        apart * apart * (q[0] * q[0] + T::one()) - q[0].sin_cos().1 - q[1].sin_cos().1
    }
    fn dissipation<T: Scalar>(&self, q: &[T], v: &[T], j: usize) -> T {
        let rate = T::from_f64(0.1) * (T::one() + q[0] * q[1] * (q[0] * q[1]));
        if j == 0 { rate * (v[0] - v[1]) } else { rate * (v[1] - v[0]) }
    }
    fn mass(&self, j: usize) -> f64 {
        [1.0, 2.0][j]
    }
    fn dissipation_form(&self) -> DissipationForm {
        DissipationForm {
            passive: Passive::InSum,
            linear: true,
            coupled: true,
            ..DissipationForm::GENERAL
        }
    }
    fn may_be_singular(&self) -> bool {
        false
    }
}

/// The system of [`Coupled`] from expressions.
fn coupled() -> Built {
    let rate = "0.1*(1 + (q1*q2)^2)";
    let forces = [format!("{rate}*(p1 - p2/2)"), format!("{rate}*(p2/2 - p1)")];
    written(&Description {
        potential: "(q1 - q2)^2*(q1^2 + 1) - cos(q1) - cos(q2)".into(),
        dissipation: DissipationText::Forces(forces.to_vec()),
        masses: vec!["1".into(), "2".into()],
        ..Description::default()
    })
}

#[test]
fn formulas_have_second_derivatives() {
    fn matrices(system: &Curved<f64>) -> BTreeMap<(String, usize, usize), f64> {
        let mut all = BTreeMap::new();
        system.curvature(&[0.4, -1.3], &[0.7, 0.2], |block, i, j, x| {
            *all.entry((format!("{block:?}"), i, j)).or_insert(0.0) += x;
        });
        all.retain(|_, x| *x != 0.0);
        all
    }
    let (found, exact) = (matrices(&FromFormulas(Coupled)), matrices(&*coupled().curved()));
    assert_eq!(found.keys().collect::<Vec<_>>(), exact.keys().collect::<Vec<_>>());
    for (key, found) in found {
        assert!((found - exact[&key]).abs() < 1e-14, "{key:?}: {found} {}", exact[&key]);
    }
}

#[test]
fn formulas_run_by_every_method_that_runs_the_expressions() {
    let start = State::new(vec![0.4, -1.3], vec![0.7, 0.2]).unwrap();
    let setting = Setting::from(Grid { h: 0.02, steps: 20 });
    let run = |system: Arc<dyn Abilities<f64>>, row: &Row| {
        let mut state = start.clone();
        let run = registry::bind(row, system).ok()?;
        run.run(setting, &mut state, 1, &mut |_, _| ControlFlow::Continue(())).unwrap();
        Some(state)
    };
    let mut compared = 0;
    for row in FIXED {
        let [a, b] = [run(Arc::new(FromFormulas(Coupled)), row), run(coupled().abilities(), row)];
        assert_eq!(a.is_some(), b.is_some(), "{}", row.name);
        let (Some(a), Some(b)) = (a, b) else { continue };
        let pairs = |x: &State<Vec<f64>>| [x.q.clone(), x.p.clone(), x.w.clone()].concat();
        for (a, b) in pairs(&a).into_iter().zip(pairs(&b)) {
            assert!((a - b).abs() < 1e-12, "{}: {a} {b}", row.name);
        }
        compared += 1;
    }
    assert!(compared >= 18, "{compared}");
}
