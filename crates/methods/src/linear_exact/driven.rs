//! The exact flow of a linear system under forces that are sums of sines and cosines of the time.
//!
//! ```text
//! z' = A z + c + Σ_k (a_k cos ω_k t + b_k sin ω_k t)
//! w1_j - w0_j = ∫ D_j v_j dt        s1_j - s0_j = ∫ F_j v_j dt
//! ```
//!
//! With the sines and cosines among the unknowns the equation is linear without forces, and both
//! energies are quadratic forms at the start of the step (`table.rs`). The sines and cosines at the
//! start are computed from t in every step. The motors are those of [`afterbay_core::Driven`]; all
//! of them stand at the same time.

use super::equations::{Equations, Forces};
use super::table::Table;
use super::{MOST_TABULATED, gain};
use crate::commit::commit;
use afterbay_core::{
    Abilities, Curvature, DissipationForm, Drive, Effort, InputError, Method, Scalar, State,
    StepFailure, Vector,
};

/// The largest number of frequencies of a drive, which bounds the size of the table.
const MOST_FREQUENCIES: usize = 12;

/// The exact flow of a driven linear system.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivenLinearExact;

/// The matrices of the step, and the new state.
#[derive(Clone, Debug)]
pub(super) struct Workspace<T> {
    table: Table<T>,
    frequencies: Vec<T>,
    /// The driven degrees of freedom.
    driven: Vec<usize>,
    dissipation: DissipationForm,
    q: Vec<T>,
    p: Vec<T>,
    w: Vec<T>,
    /// The energies dissipated and supplied in the step.
    energies: Vec<T>,
}

fn refused(why: &'static str) -> InputError {
    InputError::Unsupported { method: "linear-exact", why }
}

/// The forces of a drive on a system with `n` degrees of freedom.
fn forces<T: Scalar>(drive: &dyn Drive<T>, n: usize) -> Result<Forces<T>, InputError> {
    let still = vec![T::zero(); n];
    let read = |(k, &j): (usize, &usize)| {
        let mut by_coordinate = false;
        drive.slopes(k, &still, T::zero(), &mut |by, _| by_coordinate |= by.is_some());
        if by_coordinate {
            return Err(refused("a force of the drive depends on a coordinate"));
        }
        let why = "a force of the drive is not a sum of sines and cosines of t";
        Ok((j, drive.harmonics(k).ok_or_else(|| refused(why))?))
    };
    let driven = drive.driven().iter().enumerate().map(read).collect::<Result<_, _>>()?;
    let forces = Forces::new(driven);
    if forces.frequencies.len() > MOST_FREQUENCIES {
        return Err(refused("the drive has more than 12 frequencies"));
    }
    Ok(forces)
}

impl<V: Vector> Method<V, dyn Abilities<V::Scalar>> for DrivenLinearExact {
    type Workspace = Workspace<V::Scalar>;

    fn workspace(
        &self,
        system: &dyn Abilities<V::Scalar>,
    ) -> Result<Workspace<V::Scalar>, InputError> {
        let driven = system.driven().ok_or_else(|| refused("the system has no drive"))?;
        let (system, drive) = (driven.undriven(), driven.drive());
        if system.motors() > 0 {
            return Err(refused(super::HAS_CLOCK));
        }
        let curved = system.clone().second_derivatives();
        let curved = curved.ok_or_else(|| refused("the system has no second derivatives"))?;
        if !curved.is_linear() {
            return Err(refused(super::NOT_LINEAR));
        }
        let (n, motors) = (system.dof(), drive.driven().len());
        if n > MOST_TABULATED {
            return Err(refused("with a drive it takes up to 12 degrees of freedom"));
        }
        let forces = forces(&**drive, n)?;
        let zeros = |count: usize| vec![V::Scalar::zero(); count];
        Ok(Workspace {
            table: Table::new(Equations::new(&*curved, &forces)),
            frequencies: forces.frequencies,
            driven: drive.driven().to_vec(),
            dissipation: system.dissipation_form(),
            q: zeros(n + motors),
            p: zeros(n + motors),
            w: zeros(n + motors),
            energies: zeros(n + motors),
        })
    }

    fn is_memoryless(&self) -> bool {
        true
    }

    fn step(
        &self,
        _: &dyn Abilities<V::Scalar>,
        h: V::Scalar,
        state: &mut State<V>,
        workspace: &mut Workspace<V::Scalar>,
    ) -> Result<Effort, StepFailure> {
        if h == V::Scalar::zero() {
            return Ok(Effort::default());
        }
        let Workspace { table, frequencies, driven, dissipation, q, p, w, energies } = workspace;
        let n = q.len() - driven.len();
        let [(q0, times), (p0, supplied)] = [&state.q, &state.p].map(|x| x.as_slice().split_at(n));
        table.prepare(h);
        if let Some(&t) = times.first() {
            for (k, &frequency) in frequencies.iter().enumerate() {
                table.set_wave(k, wave(frequency, t));
            }
        }
        table.step([q0, p0], [&mut q[..n], &mut p[..n], &mut *energies]);
        let (lost, gained) = energies.split_at(n);
        w.copy_from_slice(state.w.as_slice());
        for (w, &lost) in w.iter_mut().zip(lost) {
            *w += gain(dissipation, lost);
        }
        for (k, (&j, &gained)) in driven.iter().zip(gained).enumerate() {
            q[n + k] = times[k] + h;
            p[n + k] = supplied[k] + gained;
            w[n + k] -= gained;
            w[j] -= gained;
        }
        commit(state, [&*q, &*p, &*w], true)?;
        Ok(Effort { evaluations: 1, iterations: 0 })
    }
}

/// cos ωt and sin ωt, corrected for the rounding error of ωt where `mul_add` rounds once.
fn wave<T: Scalar>(frequency: T, t: T) -> [T; 2] {
    let angle = frequency * t;
    let rest = frequency.mul_add(t, -angle);
    let (sin, cos) = angle.sin_cos();
    [(-rest).mul_add(sin, cos), rest.mul_add(cos, sin)]
}
