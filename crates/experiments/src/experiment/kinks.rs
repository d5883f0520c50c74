//! The warning that the reference of a study of attractors takes fixed steps over kinks of a force.

use crate::claim::{Readings, Said, list};
use crate::report::Verdict;
use crate::scene::{Scene, Studies};
use crate::sheet::{ReportError, Sheet};
use afterbay_analysis::study::Problem;
use afterbay_core::State;

/// The reading of a study whose reference meets kinks.
const KINKS: &str = "kinks";

/// Adds the warning, if a study of the scene needs it.
pub(super) fn warn(mut sheet: Sheet, scene: &Scene) -> Result<Sheet, ReportError> {
    let studies = with_reference(&scene.studies);
    if !studies.is_empty() && has_kinks_in_space(&scene.problem)? {
        let each = studies.into_iter();
        let readings = each.fold(Readings::default(), |r, name| r.and(name, "forces", KINKS));
        sheet.find("Reference", readings, it_may_be_wrong);
    }
    Ok(sheet)
}

/// The studies whose reference is a run of fixed steps.
fn with_reference(studies: &Studies) -> Vec<&'static str> {
    let Studies { poincare, bifurcation, resonance, basins, lyapunov, limit_cycle, .. } = studies;
    let all = [
        ("poincare", poincare.as_ref().and_then(|plan| plan.reference)),
        ("bifurcation", bifurcation.as_ref().and_then(|plan| plan.reference)),
        ("resonance", resonance.as_ref().and_then(|plan| plan.reference)),
        ("basins", basins.as_ref().and_then(|plan| plan.reference)),
        ("lyapunov", lyapunov.as_ref().and_then(|plan| plan.reference)),
        ("limit-cycle", limit_cycle.as_ref().and_then(|plan| plan.reference)),
    ];
    all.into_iter().filter_map(|(name, step)| step.map(|_| name)).collect()
}

/// Whether a force has a kink at values of q or p. Steps end at kinks that depend on t alone.
fn has_kinks_in_space(problem: &Problem) -> Result<bool, ReportError> {
    let system = problem.model.system::<f64>()?;
    let State { mut q, mut p, .. } = problem.start::<f64>()?;
    let zeros_at = |q: &[f64], p: &[f64]| {
        let mut zeros = Vec::new();
        system.kinks(q, p, &mut |zero| zeros.push(zero));
        zeros
    };
    let here = zeros_at(&q, &p);
    let degrees = problem.model.degrees();
    q[..degrees].iter_mut().chain(&mut p[..degrees]).for_each(|x| *x += 0.1 + 0.1 * x.abs());
    Ok(here != zeros_at(&q, &p))
}

fn it_may_be_wrong(r: &Readings) -> Said {
    let all = r.of_all("forces").into_iter();
    let studies = all.filter(|name| r.word(name, "forces") == KINKS).map(str::to_owned);
    let statement = format!(
        "A force has kinks in q or p. The reference of {} takes fixed steps over them, and may be \
         wrong there: repeat the study with a smaller step, and compare with `increment-4`.",
        list(studies)
    );
    (Verdict::Note, statement)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning(potential: &str, drive: &str, reference: bool) -> Option<String> {
        let scene = format!(
            r#"
[system]
name = "custom"
potential = "{potential}"
dissipation = ["-0.1*v1 + 0.1*v1^3"]
[initial]
q = [1.2]
p = [0.0]
[time]
end = 10.0
step = 0.01
{drive}
[study.lyapunov]
methods = ["increment-4"]
transient = 1.0
time = 10.0
reference = {reference}
"#
        );
        let scene = Scene::read(&scene).unwrap_or_else(|error| panic!("{error}"));
        let sheet = warn(Sheet::new("The scene"), &scene).expect("a sheet");
        sheet.findings.first().map(|finding| finding.statement.clone())
    }

    #[test]
    fn a_reference_that_steps_over_kinks_in_space_is_doubted() {
        for kinked in ["abs(q1)", "q1^2/2 + 10*max(q1 - 1, 0)^2", "50*max(q1 - 1, 0)^1.5"] {
            let said = warning(kinked, "", true).unwrap_or_else(|| panic!("{kinked}"));
            assert!(said.contains("reference of lyapunov"), "{said}");
            assert_eq!(warning(kinked, "", false), None);
        }
        assert_eq!(warning("q1^2/2", "", true), None);
        let square = "[drive]\nforce = [\"sign(sin(t))\"]";
        assert_eq!(warning("q1^2/2", square, true), None);
    }
}
