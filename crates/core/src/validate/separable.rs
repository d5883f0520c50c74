//! Tests of the parts of a separable system against its gradient and dissipation.

use super::along::{Resolved, Sample, compare};
use super::around::{Place, around, most, moved, reach, rounding, starts};
use super::coupling::unmoved;
use super::system;
use crate::error::InputError;
use crate::numbers::divided::by_quadrature;
use crate::quantity::{Block, Quantity};
use crate::system::{Separable, masses};

const OF_INCREMENTS: &str = "divided_difference() times the length must be V(to) - V(from)";

/// Validates by [`system()`], and compares the parts of a separable system with its gradient and
/// dissipation: the masses, ∂V/∂q_j, divided differences with the increments of V on edges of all
/// lengths down to 0, D_j and, if D is linear, ∂D_j/∂p_j. D_j may depend on no momentum but p_j,
/// unless the dissipation is coupled.
///
/// # Errors
/// Those of [`system()`], and [`InputError::Mass`].
pub fn separable(s: &dyn Separable<f64>, q: &[f64], p: &[f64]) -> Result<(), InputError> {
    system(s, q, p)?;
    masses(s)?;
    let places = around(s, q, p);
    for dof in 0..q.len() {
        parts(s, q, &places, dof)?;
        starts(&places).iter().try_for_each(|place| increments(s, &place.q, dof))?;
    }
    if s.dissipation_form().coupled {
        return Ok(());
    }
    let rule = "D_j of a separable system depends on no other momentum, unless dissipation_form() \
        says it is coupled";
    let free = q.len() - s.motors();
    let apart = |i: usize, j: usize| i != j && j < free;
    starts(&places)
        .iter()
        .try_for_each(|Place { q, p, .. }| unmoved(s, q, p, &apart, &[Block::Dp], rule))
}

/// ∂V/∂q_j, m_j and D_j against the gradient and the dissipation, at every place.
fn parts(
    s: &dyn Separable<f64>,
    start: &[f64],
    places: &[Place],
    dof: usize,
) -> Result<(), InputError> {
    let rounding = rounding(start.len());
    let steepest = most(places, |place| place.fields.hq[dof]);
    let strongest = most(places, |place| place.fields.d[dof]);
    let damping = s.dissipation_form();
    for Place { q, p, fields } in places {
        let same = |quantity, given: f64, found: f64, off: f64, slack: f64, rule| {
            // NaN counts as a difference.
            if off.abs() <= slack {
                Ok(())
            } else {
                Err(InputError::Contradiction { quantity, dof, given, found, rule })
            }
        };
        let (hq, hp, d) = (fields.hq[dof], fields.hp[dof], fields.d[dof]);
        // q_j is another number here, so that `partial` must use `at` in its place.
        let partial = s.partial(&moved(q, dof, start[dof]), dof, q[dof]);
        let rule = "partial() must be ∂H/∂q of the gradient at the point moved to";
        same(Quantity::Partial, partial, hq, partial - hq, rounding * steepest, rule)?;
        // A motor has the velocity 1, whatever its momentum, and no friction.
        if dof >= start.len() - s.motors() {
            continue;
        }
        let (mass, size) = (s.mass(dof), rounding * p[dof].abs());
        let rule = "mass() must be p over ∂H/∂p";
        same(Quantity::Mass, mass, p[dof] / hp, mass * hp - p[dof], size, rule)?;
        let drag = s.dissipation_of(q, p, dof);
        let rule = "dissipation_of() must give the D of dissipation()";
        same(Quantity::Dissipation, drag.value, d, drag.value - d, rounding * strongest, rule)?;
        if damping.linear && !damping.coupled {
            let rule = "by_p of dissipation_of() must be D over p where dissipation_form() says it \
                is linear";
            let off = drag.by_p * p[dof] - d;
            same(
                Quantity::DissipationSlope,
                drag.by_p,
                d / p[dof],
                off,
                rounding * strongest,
                rule,
            )?;
        }
    }
    Ok(())
}

/// Divided differences against the increments of V on the longest edges, and against the quadrature
/// of ∂V/∂q_j on shorter ones.
fn increments(s: &dyn Separable<f64>, q: &[f64], dof: usize) -> Result<(), InputError> {
    let (quantity, rounding, from, rest) =
        (Quantity::Increment, rounding(q.len()), q[dof], vec![0.0; q.len()]);
    let sample = |at: f64| {
        let to = moved(q, dof, at);
        let (v, slope) = (s.energy(&to, &rest), s.partial(q, dof, at));
        let size =
            (0..q.len()).fold(v.abs(), |size, i| size + (to[i] * s.partial(&to, i, to[i])).abs());
        Sample { value: vec![v], slope: vec![slope], size: vec![size] }
    };
    let edges = compare(from, reach(q), rounding, &sample, &|_, to, _| {
        s.divided_difference(q, dof, to).value
    })
    .map_err(|found| InputError::Contradiction {
        quantity,
        dof,
        given: found.given,
        found: found.found,
        rule: OF_INCREMENTS,
    })?;
    if s.has_exact_divided_differences() {
        exact_increments(s, q, dof, &sample)?;
    }
    let sensitivity = sensitivity(s, q, dof);
    for Resolved { width, steepest } in edges {
        let size = steepest * (1.0 + from.abs() / width.abs()) + sensitivity;
        let slack = rounding * size + f64::MIN_POSITIVE;
        for to in (1..=20).map(|k| from + width * 0.25_f64.powi(k)).chain([from]) {
            let given = s.divided_difference(q, dof, to).value;
            let found = by_quadrature(from, to, |at| s.partial(q, dof, at)).value;
            if (given - found).abs() <= slack {
                continue;
            }
            let rule = "divided_difference() must be the mean of partial() on short edges too, and \
                partial() itself on none";
            return Err(InputError::Contradiction { quantity, dof, given, found, rule });
        }
    }
    Ok(())
}

/// Divided differences that are claimed to be exact against the increments of V, also across kinks,
/// where no quadrature resolves the slope.
fn exact_increments(
    s: &dyn Separable<f64>,
    q: &[f64],
    dof: usize,
    sample: &dyn Fn(f64) -> Sample,
) -> Result<(), InputError> {
    let (from, start, rounding) = (q[dof], sample(q[dof]), rounding(q.len()));
    for k in 0..12 {
        let length = reach(q) * 0.5_f64.powi(k / 2);
        let to = if k % 2 == 0 { from + length } else { from - length };
        let end = sample(to);
        let given = s.divided_difference(q, dof, to).value * (to - from);
        let found = end.value[0] - start.value[0];
        let slack = rounding * (start.size[0] + end.size[0]);
        let singular = s.is_singular_along(q, dof, to) || !(found + slack).is_finite();
        // NaN counts as a difference.
        if !(singular || (given - found).abs() <= slack) {
            let (quantity, rule) = (Quantity::Increment, OF_INCREMENTS);
            return Err(InputError::Contradiction { quantity, dof, given, found, rule });
        }
    }
    Ok(())
}

/// Σ_i |q_i ∂²V/∂q_i∂q_j| from differences. Times a relative rounding of the coordinates, it is the
/// rounding of ∂V/∂q_j where the forces of several neighbours cancel.
fn sensitivity(s: &dyn Separable<f64>, q: &[f64], dof: usize) -> f64 {
    let slope = |q: &[f64]| s.partial(q, dof, q[dof]);
    let step = f64::EPSILON.sqrt();
    let by = |i: usize| (slope(&moved(q, i, q[i] * (1.0 + step))) - slope(q)).abs() / step;
    (0..q.len()).map(by).filter(|x| x.is_finite()).sum()
}
