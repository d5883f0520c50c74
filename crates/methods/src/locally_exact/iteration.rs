//! The fixed-point iteration for Δz, and w along the path found.

use super::equation::Workspace;
use crate::adaptive::{LARGEST_PROJECTION, Projection};
use crate::commit;
use crate::iteration::{Correction, Iteration, Verdict};
use crate::kernels::reductions::{largest_entry, max_norm, terms};
use crate::rounding::{KEPT_ROUNDINGS, RESTORED_ROUNDINGS, rounding, roundings};
use crate::second_derivatives::SecondDerivatives;
use afterbay_core::solver::Updates;
use afterbay_core::{Curvature, Effort, Mask, Quantity, Scalar, State, StepFailure, Vector};

/// At noise level, the iteration ends after this number of updates without a new smallest one.
const STALLED_IN_NOISE: u32 = 2;
/// Above noise level, the iteration ends after this number of updates without a new smallest one.
const STALLED_ABOVE_NOISE: u32 = 8;
/// Updates of at most this number of roundings of z end the iteration.
const CONVERGED_ROUNDINGS: f64 = 1.0;
/// Updates of at most this number of roundings are noise if they no longer shrink.
const STALLED_UPDATE_ROUNDINGS: f64 = 256.0;

/// A step of size h from `state`, and the state of its iteration.
struct Step<'a, V: Vector, S: ?Sized> {
    workspace: &'a mut Workspace<V>,
    system: &'a S,
    h: V::Scalar,
    state: &'a State<V>,
    /// H(z0)
    start: V::Scalar,
    /// The change of z1 by the last update, and the degree of freedom that changed most.
    moved: f64,
    dof: usize,
    /// The number of iterations.
    spent: u64,
}

impl<V: Vector> Workspace<V> {
    /// Computes z1 and w1.
    pub(super) fn find<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
    ) -> Result<Effort, StepFailure>
    where
        S: Curvature<V::Scalar> + ?Sized,
    {
        let start = state.energy(system);
        self.initial_guess();
        let mut step =
            Step { workspace: self, system, h, state, start, moved: 0.0, dof: 0, spent: 0 };
        if let Err(failure) = step.converge() {
            // Terms that cancel inside H give λ a rounding error that |H| does not show.
            let known = step.workspace.energy_rounding.largest();
            if step.measure_rounding()? <= known {
                return Err(failure);
            }
            step.workspace.initial_guess();
            step.converge()?;
        }
        Ok(Effort { evaluations: step.spent, iterations: step.spent })
    }

    /// Sets Δz = 0.
    fn initial_guess(&mut self) {
        self.dz.iter_mut().for_each(|part| part.as_mut_slice().fill(V::Scalar::zero()));
        self.resolved = None;
    }

    /// Replaces Δz by the end of the path. `energy` is H at the start. Returns the change relative
    /// to z, the absolute change, and the degree of freedom that changed most. The momenta of
    /// motors are energies; their coordinates are the time, which is exact.
    fn update(&mut self, state: &State<V>, energy: V::Scalar) -> (f64, f64, usize) {
        let (n, free) = (state.dof(), self.free);
        let parts = [
            (0, 0..free, V::Scalar::zero()),
            (1, 0..free, V::Scalar::zero()),
            (1, free..n, energy),
        ];
        let mut most = (0.0_f64, 0.0, 0);
        for (i, entries, beside) in parts {
            let start = &[&state.q, &state.p][i].as_slice()[entries.clone()];
            let dz = &self.dz[i].as_slice()[entries.clone()];
            let y = &self.flow.y[i].as_slice()[entries.clone()];
            let moved = largest_entry(y.iter().zip(dz).map(|(&y, &dz)| (y - dz).abs().to_f64()));
            let scale = start.iter().zip(y).fold(beside.abs().to_f64(), |scale, (start, y)| {
                scale.max(start.abs().to_f64() + y.abs().to_f64())
            });
            // Numbers near underflow are rounded by up to the least normal number.
            let least = f64::MIN_POSITIVE / V::Scalar::EPSILON;
            let share = if moved.0 == 0.0 { 0.0 } else { moved.0 / (scale + least) };
            if share > most.0 || share.is_nan() {
                most = (share, moved.0, entries.start + moved.1);
            }
        }
        for (dz, y) in self.dz.iter_mut().zip(&self.flow.y) {
            dz.as_mut_slice().copy_from_slice(y.as_slice());
        }
        most
    }
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Iteration for Step<'_, V, S> {
    /// An iteration that contracts by 0.93 reaches 31 digits within this number.
    const MOST_CORRECTIONS: u32 = 1000;

    fn residual(&mut self) -> Result<(), StepFailure> {
        self.walk(false)?;
        self.spent += 1;
        Ok(())
    }

    fn update(&mut self) -> Result<f64, StepFailure> {
        let (update, moved, dof) = self.workspace.update(self.state, self.start);
        (self.moved, self.dof) = (moved, dof);
        Ok(update)
    }

    fn judge(
        &mut self,
        updates: &Updates<f64>,
        Correction { count, is_last, .. }: Correction,
    ) -> Result<Verdict, StepFailure> {
        let (epsilon, update) = (V::Scalar::EPSILON, updates.last());
        let measured = V::Scalar::from_f64(self.workspace.energy_rounding.largest());
        let roughness = self.roughness(self.start.abs() + measured);
        let small = update <= STALLED_UPDATE_ROUNDINGS * (epsilon + roughness);
        // For a linear system the first path is the solution.
        let done = self.workspace.linear
            || update <= CONVERGED_ROUNDINGS * epsilon
            || (small && updates.stalled(STALLED_IN_NOISE));
        if done {
            return self.finish(LARGEST_PROJECTION).map(|()| Verdict::Converged);
        }
        // Updates that still shrink are noise only if K is conserved to rounding.
        if small && updates.ratio() > 0.5 && self.finish(0.0).is_ok() {
            return Ok(Verdict::Converged);
        }
        if update.is_finite() && !updates.stalled(STALLED_ABOVE_NOISE) && !is_last {
            return Ok(Verdict::Keep);
        }
        if updates.stalled(1) && (self.is_noise()? || self.is_rounding(update)?) {
            return self.finish(LARGEST_PROJECTION).map(|()| Verdict::Converged);
        }
        let ratio = updates.ratio();
        Err(StepFailure::NotContracting { dof: self.dof, iterations: count, ratio })
    }
}

impl<V: Vector, S: Curvature<V::Scalar> + ?Sized> Step<'_, V, S> {
    /// Follows the last path once more, with w along it. K may be restored by a change of z of at
    /// most `furthest` times its largest entry.
    fn finish(&mut self, furthest: f64) -> Result<(), StepFailure> {
        self.walk(true)?;
        self.workspace.update(self.state, self.start);
        self.workspace.place(self.state);
        commit::check(self.workspace.ends())?;
        self.restore(furthest)
    }

    /// Moves the new state along ∇H if K is off by more than the rounding at its ends, which is
    /// possible on long steps. Returns an error if K is still off by more than rounding.
    fn restore(&mut self, furthest: f64) -> Result<(), StepFailure> {
        let Self { workspace, system, state, start, .. } = self;
        let (system, start) = (*system, *start);
        let n = state.dof();
        let Workspace { end: [q, p], w, gradient: [hq, hp], energy_rounding, .. } =
            &mut **workspace;
        let (q, p, w) = (q.as_mut_slice(), p.as_mut_slice(), w.as_slice());
        let (hq, hp, w0) = (hq.as_mut_slice(), hp.as_mut_slice(), state.w.as_slice());
        system.gradient(q, p, hq, hp);
        let zero = V::Scalar::zero();
        let (mut gained, mut size) = (zero, start.abs());
        for j in 0..n {
            gained += w[j] - w0[j];
            size += w[j].abs() + w0[j].abs();
        }
        size += terms(hq, q) + terms(hp, p);
        let mut energy = system.energy(q, p);
        if !energy.is_finite().all() {
            return Err(StepFailure::non_finite(&[(Quantity::Energy, &[energy])]));
        }
        let target = start - gained;
        let left = |energy: V::Scalar| {
            let off = (energy - target).abs().to_f64();
            roundings::<V::Scalar>(off, (size + energy.abs()).to_f64())
        };
        if left(energy) <= RESTORED_ROUNDINGS {
            return Ok(());
        }
        let slope: [&[V::Scalar]; 2] = [hq, hp];
        let free = n - system.motors();
        let end_of_free = [&q[..free], &p[..free]];
        let projection = Projection::short(slope, target, size.to_f64(), furthest, end_of_free);
        let restored = projection.apply(system, [q, p], &mut energy).is_ok();
        if restored || left(energy) <= KEPT_ROUNDINGS {
            return Ok(());
        }
        let off = (energy - target).abs().to_f64();
        let is_rounding = energy_rounding.allows(system, [q, p], |measured| {
            off <= RESTORED_ROUNDINGS * rounding::<V::Scalar>(measured.largest())
        })?;
        if is_rounding {
            return Ok(());
        }
        Err(StepFailure::ProjectionFailed { excess: (energy - target).to_f64() })
    }

    /// Whether the change of the end is the rounding of the forces. Near an equilibrium the forces
    /// are differences of large terms, and p is small compared with the effect of their rounding:
    /// `ε h |H''| |z|` away from the origin, and the rounding of these terms.
    #[cold]
    fn is_noise(&mut self) -> Result<bool, StepFailure> {
        let (q, p) = (self.state.q.as_slice(), self.state.p.as_slice());
        let z = max_norm(q).max(max_norm(p));
        let second = SecondDerivatives::at(self.system, q, p).largest();
        let (start, h, moved) = (self.start.to_f64(), self.h.to_f64().abs(), self.moved);
        self.workspace.energy_rounding.allows(self.system, [q, p], |measured| {
            let terms = z + h * (second * z + measured.of_forces(start, second));
            moved <= STALLED_UPDATE_ROUNDINGS * V::Scalar::EPSILON * terms
        })
    }

    /// Measures the rounding of H at the start, and returns the largest so far.
    #[cold]
    fn measure_rounding(&mut self) -> Result<f64, StepFailure> {
        let (q, p) = (self.state.q.as_slice(), self.state.p.as_slice());
        self.workspace.energy_rounding.measure(self.system, q, p)
    }

    /// Whether an update is the effect of the measured rounding of H.
    #[cold]
    fn is_rounding(&mut self, update: f64) -> Result<bool, StepFailure> {
        let energy = V::Scalar::from_f64(self.measure_rounding()?);
        Ok(update <= STALLED_UPDATE_ROUNDINGS * (V::Scalar::EPSILON + self.roughness(energy)))
    }

    /// Follows the path of the current Δz, and w along it if requested.
    fn walk(&mut self, with_w: bool) -> Result<(), StepFailure> {
        let Self { workspace, system, h, state, start, .. } = self;
        let h = *h;
        workspace.place(state);
        workspace.evaluate(*system, h, *start);
        let with_w = with_w && workspace.dissipative;
        let Workspace { slopes, flow, dz, gradient, d, rest, w, scratch, .. } = &mut **workspace;
        let [middle_q, middle_p, sq, sp, a, b] = scratch;
        let (middle_q, middle_p) = (middle_q.as_mut_slice(), middle_p.as_mut_slice());
        let (drag, rest, v) = (d.as_mut_slice(), rest.as_slice(), gradient[1].as_slice());
        let w = w.as_mut_slice();
        w.copy_from_slice(state.w.as_slice());
        let dz = [dz[0].as_slice(), dz[1].as_slice()];
        let products = flow.follow(
            h,
            |x, to| slopes.multiply(x, to, [a.as_mut_slice(), b.as_mut_slice()]),
            |weight, [q, p]| {
                if !with_w {
                    return;
                }
                for j in 0..w.len() {
                    middle_q[j] = q[j] - dz[0][j].half();
                    middle_p[j] = p[j] - dz[1][j].half();
                }
                let (sq, sp) = (sq.as_mut_slice(), sp.as_mut_slice());
                slopes.multiply_hessian([middle_q, middle_p], [sq, sp]);
                drag.copy_from_slice(rest);
                sp.iter_mut().zip(v).for_each(|(sp, &v)| *sp += v);
                slopes.add_dissipation(sp, drag);
                slopes.add_position_terms(middle_q, drag, sq);
                for j in 0..w.len() {
                    w[j] = weight.mul_add(drag[j] * sp[j], w[j]);
                }
            },
        );
        products.map(drop).ok_or_else(|| flow.too_long())
    }

    /// The effect of a rounding of H on h λ Δz, relative to z: |λ Δz| is known to ε|H|/|Δz|, which
    /// exceeds a rounding of z if Δz is short.
    fn roughness(&self, energy: V::Scalar) -> f64 {
        let Self { workspace: Workspace { linear, dz, .. }, state, h, .. } = self;
        if *linear {
            return 0.0;
        }
        let largest = |part: &V| max_norm(part.as_slice());
        let moved = largest(&dz[0]).max(largest(&dz[1]));
        let size = largest(&state.q).min(largest(&state.p)) + moved;
        if moved == 0.0 {
            return 0.0;
        }
        h.to_f64().abs() * (V::Scalar::EPSILON * energy.to_f64().abs() / (moved * size))
    }
}
