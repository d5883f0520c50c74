//! The exact flow of a linear system of any size, the reservoir included.
//!
//! ```text
//! z' = A z + c        z = (q, p)        z1 = e^{hA} z0 + h φ₁(hA) c        φ₁(X) = X⁻¹ (e^X - 1)
//! w1_j - w0_j = ∫_0^h D_j(z) v_j(z) dτ        v = ∂H/∂p
//! ```
//!
//! for H quadratic and D linear ([`Curvature::is_linear`]), constant forces included. K is exact
//! because the flow is. The first line is linear and the second quadratic in (z0, 1). With up to 12
//! degrees of freedom both are tabulated as matrices, computed once for each h by doubling a short
//! step (`equations.rs`, `table.rs`): a step is one matrix-vector product for z and one quadratic
//! form for each reservoir, whether h is 1e-3 or 100. With more degrees of freedom the quadratic
//! forms would be too large. The flow is then the Taylor series of the system over spans that are
//! short compared with 1/|A|, with Gauss nodes for w: O(N) for each product if only neighbours are
//! coupled, up to h |A| of about 1000.
//!
//! The only error is rounding. With up to 12 degrees of freedom long steps are computed in 31
//! digits, and the errors of q, p, w and K in one step are roundings of their terms, for any step
//! size. With more, a step amplifies the rounding errors of the series by h |A|: K is conserved to
//! about 1 + h |A| roundings, and steps with h |A| beyond 1000 are refused. The error of K is the
//! same in every step, so over a time t it may accumulate to t |A| roundings. The method is passive
//! where the system is: where Δw_j ≥ 0 is required, a negative Δw_j caused by rounding is set to 0.
//!
//! A linear system may be driven by forces that are sums of sines and cosines of t
//! ([`afterbay_core::Harmonics`]), with up to 12 degrees of freedom and 12 frequencies. The sines
//! and cosines join z, the flow stays that of a constant matrix, and the energy supplied to each
//! degree of freedom is one more quadratic form (`driven.rs`). Its errors are roundings of their
//! terms, at resonance too.
//!
//! Other drives are refused, and so are systems that are not linear and those whose V or D depends
//! on t.

mod doubling;
mod driven;
mod equations;
mod table;

use crate::commit::commit;
use crate::linear_flow::LinearFlow;
use crate::registry::binding::{Binding, Bound, Target};
use afterbay_core::{
    Curvature, DissipationForm, Effort, InputError, Mask, Method, Passive, Scalar, State,
    StepFailure, Vector,
};
use driven::DrivenLinearExact;
use equations::{Equations, Forces};
use std::sync::Arc;
use table::Table;

/// The exact flow of a linear system.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearExact;

/// The largest number of degrees of freedom for which steps are tabulated. A choice.
const MOST_TABULATED: usize = 12;

const NOT_LINEAR: &str = "the system is not linear";
const HAS_CLOCK: &str = "V or D depends on the time";

/// The representation of the flow.
#[derive(Clone, Debug)]
enum Flow<V: Vector> {
    Table(Box<Table<V::Scalar>>),
    Series(Box<LinearFlow<V>>),
}

/// The flow, the new state, and intermediate values.
#[derive(Clone, Debug)]
pub struct Workspace<V: Vector> {
    flow: Flow<V>,
    q: V,
    p: V,
    w: V,
    /// The point of a node, ∇H and D there, and c
    at: [V; 2],
    slope: [V; 2],
    d: V,
    /// ∇H and D for products with A
    inner_slope: [V; 2],
    inner_d: V,
    constant: [V; 2],
}

impl Binding for LinearExact {
    fn bind<V: Vector + 'static>(&self, target: &Target<'_, V::Scalar>) -> Bound<V::Scalar> {
        if target.system.driven().is_some() {
            return target.fixed::<V, _, _>(DrivenLinearExact, Arc::clone(target.system));
        }
        if target.system.motors() > 0 {
            return Err(target.refused(HAS_CLOCK));
        }
        target.fixed::<V, _, _>(*self, target.curvature()?)
    }
}

impl<V, S> Method<V, S> for LinearExact
where
    V: Vector,
    S: Curvature<V::Scalar> + ?Sized,
{
    type Workspace = Workspace<V>;

    fn workspace(&self, system: &S) -> Result<Workspace<V>, InputError> {
        if !system.is_linear() {
            return Err(InputError::Unsupported { method: "linear-exact", why: NOT_LINEAR });
        }
        let n = system.dof();
        let (zeros, pair) = (|| V::zeros(n), || [V::zeros(n), V::zeros(n)]);
        let flow = if n <= MOST_TABULATED {
            Flow::Table(Box::new(Table::new(Equations::new(system, &Forces::none()))))
        } else {
            Flow::Series(Box::new(LinearFlow::new(n)))
        };
        let mut workspace = Workspace {
            flow,
            q: zeros(),
            p: zeros(),
            w: zeros(),
            at: pair(),
            slope: pair(),
            d: zeros(),
            inner_slope: pair(),
            inner_d: zeros(),
            constant: pair(),
        };
        let origin = V::zeros(n);
        let [a, b] = &mut workspace.constant;
        let (constant_q, constant_p) = (a.as_mut_slice(), b.as_mut_slice());
        velocity(
            system,
            [origin.as_slice(); 2],
            &mut workspace.slope,
            &mut workspace.d,
            [constant_q, constant_p],
        );
        Ok(workspace)
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V>,
    ) -> Result<Effort, StepFailure> {
        if h == V::Scalar::zero() {
            return Ok(Effort::default());
        }
        let damping = system.dissipation_form();
        let effort = workspace.follow(system, h, state, &damping)?;
        let Workspace { q, p, w, .. } = workspace;
        let (q, p, w) = (q.as_slice(), p.as_slice(), w.as_mut_slice());
        for (w, &w0) in w.iter_mut().zip(state.w.as_slice()) {
            *w = w0 + gain(&damping, *w);
        }
        commit(state, [q, p, w], !damping.zero)?;
        Ok(effort)
    }
}

impl<V: Vector> Workspace<V> {
    /// Computes q1, p1 and, in `w`, the energies dissipated.
    #[inline]
    fn follow<S: Curvature<V::Scalar> + ?Sized>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &State<V>,
        damping: &DissipationForm,
    ) -> Result<Effort, StepFailure> {
        let Self { flow, q, p, w, at, slope, d, inner_slope, inner_d, constant } = self;
        let (q, p, w) = (q.as_mut_slice(), p.as_mut_slice(), w.as_mut_slice());
        let [q0, p0] = [state.q.as_slice(), state.p.as_slice()];
        let flow = match flow {
            Flow::Table(table) => {
                table.prepare(h);
                table.step([q0, p0], [q, p, w]);
                return Ok(Effort { evaluations: 1, iterations: 0 });
            }
            Flow::Series(flow) => flow,
        };
        let [u_q, u_p] = &mut flow.u;
        velocity(system, [q0, p0], slope, d, [u_q.as_mut_slice(), u_p.as_mut_slice()]);
        w.fill(V::Scalar::zero());
        let products = flow.follow(
            h,
            |[x, y], [a, b]| {
                velocity(system, [x, y], inner_slope, inner_d, [&mut *a, &mut *b]);
                for (to, constant) in [(a, &constant[0]), (b, &constant[1])] {
                    to.iter_mut().zip(constant.as_slice()).for_each(|(to, &c)| *to -= c);
                }
            },
            |weight, [x, y]| {
                if damping.zero {
                    return;
                }
                let [at_q, at_p] = at;
                let (at_q, at_p) = (at_q.as_mut_slice(), at_p.as_mut_slice());
                for j in 0..w.len() {
                    (at_q[j], at_p[j]) = (q0[j] + x[j], p0[j] + y[j]);
                }
                let [hq, hp] = slope;
                let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
                system.gradient(at_q, at_p, hq, hp);
                system.dissipation(at_q, at_p, hp, d);
                for j in 0..w.len() {
                    w[j] = weight.mul_add(d[j] * hp[j], w[j]);
                }
            },
        );
        let Some(evaluations) = products else { return Err(flow.too_long()) };
        let [x, y] = [flow.y[0].as_slice(), flow.y[1].as_slice()];
        for j in 0..x.len() {
            (q[j], p[j]) = (q0[j] + x[j], p0[j] + y[j]);
        }
        Ok(Effort { evaluations, iterations: 0 })
    }
}

/// Δw. It is 0 without dissipation, and where Δw ≥ 0 is required but rounding errors make it
/// negative.
fn gain<T: Scalar>(damping: &DissipationForm, w: T) -> T {
    let negative = damping.passive == Passive::Each && w.lt(T::zero()).all();
    if negative || damping.zero { T::zero() } else { w }
}

/// (∂H/∂p, -∂H/∂q - D) at (q, p).
fn velocity<V: Vector, S: Curvature<V::Scalar> + ?Sized>(
    system: &S,
    [q, p]: [&[V::Scalar]; 2],
    [hq, hp]: &mut [V; 2],
    d: &mut V,
    [a, b]: [&mut [V::Scalar]; 2],
) {
    let (hq, hp, d) = (hq.as_mut_slice(), hp.as_mut_slice(), d.as_mut_slice());
    system.gradient(q, p, hq, hp);
    system.dissipation(q, p, hp, d);
    a.copy_from_slice(hp);
    for (j, b) in b.iter_mut().enumerate() {
        *b = -hq[j] - d[j];
    }
}
