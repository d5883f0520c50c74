//! Friction that couples the momenta, D = C(q) p, as a flow of its own between the sweeps.
//!
//! A sweep needs D̄_j of the means of momenta that have not moved yet. Taken at a mixed state instead, D̄ loses its sign; so
//! friction is split off. With q at rest the momenta move one after the other,
//!
//! ```text
//! p1_j - p0_j = -h D̄_j        w1_j - w0_j = h D̄_j p̄_j/m_j        p̄ = (p0 + p1)/2
//! D̄_j = D_j(q, P)             P_k = 2 p̄_k for k moved, p̄_j for j itself, 0 for k to come
//! ```
//!
//! K is exact, each equation is solved by one division, and with D = R(q) ∂H/∂p, R symmetric, the D̄_j p̄_j/m_j add up to
//! v̄ᵀ R(q) v̄, v̄_j = p̄_j/m_j: the reservoirs fill in sum where R is positive semidefinite, at any h > 0. One pass sees C and the
//! difference of its lower and upper triangle, which exerts no power; the pass in reversed order sees the opposite. Either is
//! the implicit midpoint rule for what it sees, hence its own adjoint. A sweep with half a step of one before and half a step
//! of the other after it is consistent, and its adjoint is the same with every order reversed: what holds of sweeps alone, and
//! of every composition of them, holds of these.

use afterbay_core::{Coupling, InputError, Mask, Passive, Scalar, Separable, State, StepFailure, Vector};

/// Is friction that couples the momenta linear in them, and where Δw ≥ 0 is owed, its R symmetric?
///
/// With D = C p = R v and v_j = p_j/m_j it is R_ij = C_ij m_j. R is looked at where q = 0 only: that it is symmetric elsewhere
/// too is left to the system. What is active owes nothing, and may have any C.
pub(super) fn check<V, S>(system: &S) -> Result<(), InputError>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let damping = system.damping();
    let refuse = |why| Err(InputError::Unsupported { method: "increment", why });
    if !damping.coupled {
        return Ok(());
    }
    if !damping.linear {
        return refuse("D depends on the momenta of others and is not linear in them: take gonzalez");
    }
    if damping.passive != Passive::No && !symmetric::<V, S>(system) {
        return refuse("D = R ∂H/∂p with R not symmetric would drain the reservoirs in sum: take gonzalez");
    }
    Ok(())
}

/// Is R symmetric at q = 0? To rounding, beside the diagonal: |R_ij|² ≤ R_ii R_jj where R is positive semidefinite.
fn symmetric<V, S>(system: &S) -> bool
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let (n, coupling) = (system.dof(), system.coupling());
    let (q, mut p) = (V::zeros(n), V::zeros(n));
    let mut entry = |i: usize, j: usize| {
        p.as_mut_slice()[j] = system.mass(j);
        let drag = system.drag(q.as_slice(), p.as_slice(), i).value;
        p.as_mut_slice()[j] = V::Scalar::zero();
        drag.to_f64()
    };
    let diagonal: Vec<f64> = (0..n).map(|j| entry(j, j)).collect();
    let rounding = f64::EPSILON * (1000.0 + n as f64);
    // Only neighbours, where there are.
    let first = |i: usize| match coupling {
        Coupling::Dense => 0,
        Coupling::Ring if i + 1 == n => 0,
        Coupling::Chain | Coupling::Ring => i.saturating_sub(1),
    };
    (0..n).all(|i| {
        (first(i)..i).filter(|&j| coupling.joins(n, i, j)).all(|j| {
            let slack = rounding * (diagonal[i].abs() * diagonal[j].abs()).sqrt();
            (entry(i, j) - entry(j, i)).abs() <= slack
        })
    })
}

/// Friction alone for a time `h`, in the order given. `means` holds P.
pub(super) fn pass<V, S>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    means: &mut V,
    order: impl Iterator<Item = usize>,
) -> Result<(), StepFailure>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let (zero, two) = (V::Scalar::zero(), V::Scalar::from_f64(2.0));
    let half = h.half();
    let (q, p, w) = (state.q.as_slice(), state.p.as_mut_slice(), state.w.as_mut_slice());
    let means = means.as_mut_slice();
    means.fill(zero);
    for j in order {
        // With P_j = 0 this is what the others exert; D is linear.
        let drag = system.drag(q, means, j);
        let slope = half.mul_add(drag.by_p, V::Scalar::one());
        if !zero.lt(slope).all() {
            return Err(StepFailure::Singular { dof: j, slope: slope.to_f64() });
        }
        let mean = (-half).mul_add(drag.value, p[j]) / slope;
        // The rounding of the slope is the same in every step, and K would drift by its share of p0². What is left of the
        // equation knows it.
        let left = p[j] - mean - half * drag.by_p.mul_add(mean, drag.value);
        let mean = mean + left / slope;
        let force = drag.by_p.mul_add(mean, drag.value);
        w[j] = (h / system.mass(j) * force).mul_add(mean, w[j]);
        p[j] = two.mul_add(mean, -p[j]);
        means[j] = mean + mean;
    }
    Ok(())
}
