//! The step of one coordinate along its edge: the equation of modDG, and of each coordinate in a
//! sweep, for the mean momentum v.
//!
//! ```text
//! v = p0 - δ(p)/2 (mean of ∂V/∂q along the edge + D̄)        D̄ = D((q0 + q1)/2, v)
//! q1 = q0 + δ(q) v/m        p1 = 2 v - p0        Δw = δ(w)/m D̄ v
//! ```
//!
//! The force of a drive that does not depend on q is known before the step. It is then taken out of
//! D and added to the start: v = (p0 + δ(p)/2 F) - ..

use afterbay_core::solver::{Equation, Root, Sample, Solver};
use afterbay_core::{Dissipation, Mask, Scalar, Separable, StepFailure};

/// The factors of the step in the equations for q, p and w.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates<T> {
    /// δ(q)/m
    pub(crate) q: T,
    /// δ(p)
    pub(crate) p: T,
    /// δ(w)/m
    pub(crate) w: T,
}

/// A coordinate before its step.
pub(crate) struct Coordinate<T, F = ()> {
    pub(crate) dof: usize,
    pub(crate) q: T,
    pub(crate) p: T,
    pub(crate) rates: Rates<T>,
    /// The largest |q_i| of the coordinates coupled to this one. Forces of that size may cancel,
    /// and their sum carries their rounding error.
    pub(crate) largest_coupled: T,
    /// Whether the system is dissipative.
    pub(crate) dissipative: bool,
    /// The force of a drive, if it does not depend on q; `()` where there is no drive.
    pub(crate) drive: F,
}

/// A force that is known before the step, if there is one.
pub(crate) trait Known<T>: Copy {
    fn force(self) -> Option<T>;
}

impl<T> Known<T> for () {
    #[inline(always)]
    fn force(self) -> Option<T> {
        None
    }
}

impl<T: Scalar> Known<T> for Option<T> {
    #[inline(always)]
    fn force(self) -> Option<T> {
        self
    }
}

/// The coordinate after its step.
pub(crate) struct Moved<T> {
    pub(crate) q: T,
    pub(crate) p: T,
    /// The increment of the reservoir; 0 without dissipation.
    pub(crate) dw: T,
    pub(crate) evaluations: u64,
}

/// The edge of coordinate j through the point q. Entry j of p is overwritten.
pub(crate) struct Edge<'a, T, S: ?Sized> {
    pub(crate) system: &'a S,
    pub(crate) j: usize,
    pub(crate) q: &'a mut [T],
    pub(crate) p: &'a mut [T],
}

impl<T: Scalar, S: Separable<T> + ?Sized> Edge<'_, T, S> {
    /// D at the midpoint of the edge and the mean momentum v, without the force of a drive if that
    /// is known.
    #[inline(always)]
    fn dissipation_of(&mut self, middle: T, v: T, drive: Option<T>) -> Dissipation<T> {
        let Self { system, j, ref mut q, ref mut p } = *self;
        let from = std::mem::replace(&mut q[j], middle);
        p[j] = v;
        let drag = match drive {
            Some(_) => system.friction_of(q, p, j),
            None => system.dissipation_of(q, p, j),
        };
        q[j] = from;
        drag
    }
}

/// The function F of the equation v = p0 - F(v). The step sizes are scaled by `share`, from 1 (the
/// full step) to 0.
pub(crate) struct MomentumEquation<'a, 'b, T, S: ?Sized, F = ()> {
    pub(crate) coordinate: &'a Coordinate<T, F>,
    pub(crate) edge: &'a mut Edge<'b, T, S>,
}

impl<T: Scalar, S: Separable<T> + ?Sized, F: Known<T>> Equation<T>
    for MomentumEquation<'_, '_, T, S, F>
{
    #[inline(always)]
    fn at(&mut self, share: T, v: T) -> Sample<T> {
        let Coordinate { q: q0, rates, largest_coupled, dissipative, drive, .. } = *self.coordinate;
        let (width, half_step) = (share * rates.q, share * rates.p.half());
        let product = width * half_step;
        let mean =
            self.edge.system.divided_difference(self.edge.q, self.edge.j, width.mul_add(v, q0));
        let by_q = half_step * mean.slope;
        if !dissipative {
            let (argument_rounding, value_rounding) =
                ((by_q * q0).abs(), by_q.abs() * largest_coupled);
            return Sample {
                value: half_step * mean.value,
                slope: product * mean.slope,
                argument_rounding,
                value_rounding,
            };
        }
        let drag = self.edge.dissipation_of(width.half().mul_add(v, q0), v, drive.force());
        let by_q = half_step.half().mul_add(drag.by_q, by_q);
        Sample {
            value: half_step.mul_add(mean.value, half_step * drag.value),
            // The slope of the mean comes last, because the other terms wait for it.
            slope: product
                .mul_add(mean.slope, product.half().mul_add(drag.by_q, half_step * drag.by_p)),
            argument_rounding: (by_q * q0).abs(),
            value_rounding: by_q.abs() * largest_coupled,
        }
    }
}

/// [`MomentumEquation`], restricted to one side of all singularities: beyond them its slope makes
/// every solver refuse the step.
struct WithinSingularities<'a, 'b, T, S: ?Sized, F>(MomentumEquation<'a, 'b, T, S, F>);

impl<T: Scalar, S: Separable<T> + ?Sized, F: Known<T>> Equation<T>
    for WithinSingularities<'_, '_, T, S, F>
{
    fn at(&mut self, share: T, v: T) -> Sample<T> {
        let Coordinate { q: q0, rates, .. } = *self.0.coordinate;
        let Edge { system, j, ref q, .. } = *self.0.edge;
        if system.is_singular_along(q, j, (share * rates.q).mul_add(v, q0)) {
            let slope = T::from_f64(f64::NEG_INFINITY);
            return Sample {
                value: T::zero(),
                slope,
                argument_rounding: T::zero(),
                value_rounding: T::zero(),
            };
        }
        self.0.at(share, v)
    }
}

impl<T> Coordinate<T> {
    /// This step under a drive, whose force may be known.
    pub(crate) fn under(self, drive: Option<T>) -> Coordinate<T, Option<T>> {
        let Self { dof, q, p, rates, largest_coupled, dissipative, drive: () } = self;
        Coordinate { dof, q, p, rates, largest_coupled, dissipative, drive }
    }
}

impl<T: Scalar, F: Known<T>> Coordinate<T, F> {
    /// Moves the coordinate along its edge.
    #[inline(always)]
    pub(crate) fn advance<S: Separable<T> + ?Sized>(
        self,
        solver: &impl Solver,
        mut edge: Edge<'_, T, S>,
    ) -> Result<Moved<T>, StepFailure> {
        if edge.system.has_exact_divided_differences() && !edge.system.may_be_singular() {
            let root = solver.solve(
                self.dof,
                self.start(),
                MomentumEquation { coordinate: &self, edge: &mut edge },
            )?;
            return Ok(self.moved(root, edge));
        }
        self.advance_with_care(solver, edge)
    }

    /// Moves the coordinate where the edge may not be resolved, or V may be singular on it.
    #[inline(never)]
    fn advance_with_care<S: Separable<T> + ?Sized>(
        &self,
        solver: &impl Solver,
        mut edge: Edge<'_, T, S>,
    ) -> Result<Moved<T>, StepFailure> {
        match solver.solve(
            self.dof,
            self.start(),
            MomentumEquation { coordinate: self, edge: &mut edge },
        ) {
            Ok(root) if !self.is_singular(&edge, root.x) => Ok(self.moved(root, edge)),
            outcome => self.beyond_singularity(solver, edge, outcome),
        }
    }

    /// Whether V is singular on the edge to which this mean momentum leads.
    #[inline(always)]
    fn is_singular<S: Separable<T> + ?Sized>(&self, edge: &Edge<'_, T, S>, v: T) -> bool {
        edge.system.is_singular_along(edge.q, edge.j, self.end(v))
    }

    /// The mean momentum of free flight, from which the equation starts.
    #[inline(always)]
    fn start(&self) -> T {
        match self.drive.force() {
            Some(force) => self.rates.p.half().mul_add(force, self.p),
            None => self.p,
        }
    }

    #[inline(always)]
    fn end(&self, v: T) -> T {
        self.rates.q.mul_add(v, self.q)
    }

    /// Called if the equation was not solved, or its solution lies beyond a singularity. Finds the
    /// solution on this side of the singularity, or returns the failure that names it.
    #[cold]
    #[inline(never)]
    fn beyond_singularity<S: Separable<T> + ?Sized>(
        &self,
        solver: &impl Solver,
        mut edge: Edge<'_, T, S>,
        outcome: Result<Root<T>, StepFailure>,
    ) -> Result<Moved<T>, StepFailure> {
        // The solution beyond the singularity, or the end of free flight, where the iteration
        // starts.
        let (v, failure) = match outcome {
            Ok(root) => (root.x, None),
            Err(failure) => (self.start(), Some(failure)),
        };
        let (j, to) = (edge.j, self.end(v));
        let (dof, from, end) = (self.dof, self.q.to_f64(), to.to_f64());
        if self.is_singular(&edge, v) {
            let within =
                WithinSingularities(MomentumEquation { coordinate: self, edge: &mut edge });
            if let Ok(root) = solver.solve(self.dof, self.start(), within)
                && !self.is_singular(&edge, root.x)
            {
                return Ok(self.moved(root, edge));
            }
            return Err(StepFailure::AcrossSingularity { dof, from, to: end });
        }
        let Edge { system, ref q, .. } = edge;
        let finite = |x: T| x.is_finite().all();
        let ends = finite(system.partial(q, j, self.q)) && finite(system.partial(q, j, to));
        match failure {
            Some(_) if ends && !finite(system.divided_difference(q, j, to).value) => {
                Err(StepFailure::EdgeUnresolved { dof, from, to: end })
            }
            Some(failure) => Err(failure),
            None => Err(StepFailure::AcrossSingularity { dof, from, to: end }),
        }
    }

    /// The coordinate after a step with mean momentum v.
    #[inline(always)]
    pub(crate) fn moved<S: Separable<T> + ?Sized>(
        &self,
        root: Root<T>,
        mut edge: Edge<'_, T, S>,
    ) -> Moved<T> {
        let Self { q: q0, p: p0, rates, dissipative, drive, .. } = *self;
        let v = root.x;
        let q = rates.q.mul_add(v, q0);
        let dw = if dissipative {
            let drag = edge.dissipation_of(rates.q.half().mul_add(v, q0), v, drive.force()).value;
            rates.w * drive.force().map_or(drag, |force| drag - force) * v
        } else {
            T::zero()
        };
        let p = T::from_f64(2.0).mul_add(v, -p0);
        Moved { q, p, dw, evaluations: u64::from(root.evaluations) }
    }
}
