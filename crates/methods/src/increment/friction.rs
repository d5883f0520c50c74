//! Friction that couples the momenta, D = C(q) p, as a separate flow between the sweeps.
//!
//! A sweep would need D̄_j at the means of momenta that have not been updated yet. At a mixture of
//! old and new momenta, D̄·v̄ has no sign; therefore friction is split off. With q fixed, the
//! momenta are updated one after the other,
//!
//! ```text
//! p1_j - p0_j = -h D̄_j        w1_j - w0_j = h D̄_j p̄_j/m_j        p̄ = (p0 + p1)/2
//! D̄_j = D_j(q, P)             P_k = 2 p̄_k for k moved, p̄_j for j itself, 0 for k to come
//! ```
//!
//! K is exact, and each equation is solved by one division. With D = R(q) ∂H/∂p and R symmetric,
//! the D̄_j p̄_j/m_j sum to v̄ᵀ R(q) v̄ with v̄_j = p̄_j/m_j: Σ Δw_j ≥ 0 where R is positive
//! semidefinite, for any h > 0. One pass applies C plus the difference of its lower and upper
//! triangle, which does no work; the pass in reversed order applies C minus this difference. Each
//! pass is the implicit midpoint rule for the matrix it applies, hence its own adjoint. A sweep
//! with half a step of one pass before it and half a step of the other after it is consistent, and
//! its adjoint reverses every order. The properties of sweeps and of their compositions therefore
//! carry over.
//!
//! If R has a skew part S, the difference of its triangles is symmetric and does the work 2 Σ_{k<j}
//! S_jk v̄_j v̄_k, although S itself does none: the momenta would grow like e^(h|S|) while K stays
//! exact. In this case all momenta are updated at once, by the implicit midpoint rule for C itself,
//!
//! ```text
//! p1 - p0 = -h D̄        w1_j - w0_j = h D̄_j p̄_j/m_j        D̄ = C(q) p̄
//! ```
//!
//! which conserves K, is its own adjoint, and adds v̄ᵀ R v̄ to the reservoirs, for any R. It
//! requires the elimination of N unknowns.

use afterbay_core::{Coupling, InputError, Mask, Scalar, Separable, State, StepFailure, Vector};

/// The largest number of momenta that are updated at once. A choice: the matrix takes 2 MB in
/// `f64`.
const MOST_MOMENTA: usize = 512;
/// The magnitudes of the coordinates at which the symmetry of R is tested, in
/// their own units.
const TESTED_SIZES: [f64; 6] = [0.0, 1e-3, 0.1, 1.0, 10.0, 1e3];

/// Friction that couples the momenta, with the memory of its passes.
#[derive(Clone, Debug)]
pub(super) struct Friction<V: Vector> {
    /// P of the pass, or p̄.
    means: V,
    /// The matrix 1 + h/2 C, row by row, and the residual; present if R is not symmetric.
    at_once: Option<(Vec<V::Scalar>, V)>,
}

impl<V: Vector> Friction<V> {
    /// Returns `None` if friction does not couple the momenta.
    ///
    /// # Errors
    /// [`InputError::Unsupported`] if D is not linear in the momenta, if R is not symmetric and has
    /// more than 512 rows, or if lanes differ in the symmetry of R.
    pub(super) fn new<S>(system: &S) -> Result<Option<Self>, InputError>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        let (damping, n) = (system.dissipation_form(), system.dof());
        let refuse = |why| Err(InputError::Unsupported { method: "increment", why });
        if !damping.coupled {
            return Ok(None);
        }
        if (0..n).any(|motor| system.driven_by(motor).is_some()) {
            return refuse("D couples the momenta of a driven system: take gonzalez");
        }
        if !damping.linear {
            return refuse(
                "D depends on the momenta of others and is not linear in them: take gonzalez",
            );
        }
        let symmetric = symmetric::<V, S>(system, 0);
        if (1..V::Scalar::LANES).any(|lane| self::symmetric::<V, S>(system, lane) != symmetric) {
            return refuse("R is symmetric in some lanes and not in others");
        }
        if !symmetric && n > MOST_MOMENTA {
            return refuse(
                "D = R ∂H/∂p with R not symmetric couples more than 512 momenta: take gonzalez",
            );
        }
        let at_once = (!symmetric).then(|| (vec![V::Scalar::zero(); n * n], V::zeros(n)));
        Ok(Some(Self { means: V::zeros(n), at_once }))
    }

    /// Applies friction alone for a time `h`. Momenta that are updated one after the other take the
    /// given order.
    pub(super) fn pass<S>(
        &mut self,
        system: &S,
        h: V::Scalar,
        state: &mut State<V>,
        order: impl Iterator<Item = usize>,
    ) -> Result<(), StepFailure>
    where
        S: Separable<V::Scalar> + ?Sized,
    {
        match &mut self.at_once {
            None => one_by_one(system, h, state, &mut self.means, order),
            Some((matrix, left)) => {
                at_once(system, h, state, self.means.as_mut_slice(), matrix, left)
            }
        }
    }
}

/// Tests whether R is symmetric in a lane, at q = 0 and at two pseudo-random points of each of
/// several magnitudes. Where an analytic R(q) is symmetric at points in general position, it is
/// symmetric everywhere. Points where R is not finite are skipped.
///
/// With D = C p = R v and v_j = p_j/m_j, R_ij = C_ij m_j. Entries are compared to rounding, also
/// relative to the diagonal: |R_ij|² ≤ R_ii R_jj where R is positive semidefinite.
fn symmetric<V, S>(system: &S, lane: usize) -> bool
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let n = system.dof();
    let mut seed = 1_u64;
    let mut number = |size: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        V::Scalar::from_f64(size * (2.0 * (seed >> 11) as f64 / (1_u64 << 53) as f64 - 1.0))
    };
    let mut q = V::zeros(n);
    TESTED_SIZES.iter().chain(&TESTED_SIZES[1..]).all(|&size| {
        q.as_mut_slice().iter_mut().for_each(|q| *q = number(size));
        symmetric_at::<V, S>(system, &q, lane)
    })
}

/// Tests whether R is symmetric at q in a lane.
fn symmetric_at<V, S>(system: &S, q: &V, lane: usize) -> bool
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let (n, coupling) = (system.dof(), system.coupling());
    let mut p = V::zeros(n);
    let mut entry = |i: usize, j: usize| {
        p.as_mut_slice()[j] = system.mass(j);
        let drag = system.dissipation_of(q.as_slice(), p.as_slice(), i).value;
        p.as_mut_slice()[j] = V::Scalar::zero();
        drag.lane(lane)
    };
    let diagonal: Vec<f64> = (0..n).map(|j| entry(j, j)).collect();
    let rounding = f64::EPSILON * (1000.0 + n as f64);
    // Only neighbours are compared if the coupling is local.
    let first = |i: usize| match coupling {
        Coupling::Dense => 0,
        Coupling::Ring if i + 1 == n => 0,
        Coupling::Chain | Coupling::Ring => i.saturating_sub(1),
    };
    (0..n).all(|i| {
        (first(i)..i).filter(|&j| coupling.joins(n, i, j)).all(|j| {
            let [above, below] = [entry(j, i), entry(i, j)];
            let size =
                (diagonal[i].abs() * diagonal[j].abs()).sqrt().max(above.abs().min(below.abs()));
            let off = (above - below).abs();
            off <= rounding * size || !off.is_finite()
        })
    })
}

/// Updates all momenta at once: solves (1 + h/2 C) p̄ = p0 by elimination with iterative refinement
/// until the residual is at rounding level.
///
/// If C has a positive semidefinite symmetric part, every pivot of 1 + h/2 C is at least 1, in any
/// order.
fn at_once<V, S>(
    system: &S,
    h: V::Scalar,
    state: &mut State<V>,
    means: &mut [V::Scalar],
    matrix: &mut [V::Scalar],
    left: &mut V,
) -> Result<(), StepFailure>
where
    V: Vector,
    S: Separable<V::Scalar> + ?Sized,
{
    let (zero, one, half) = (V::Scalar::zero(), V::Scalar::one(), h.half());
    let (q, p, w) = (state.q.as_slice(), state.p.as_mut_slice(), state.w.as_mut_slice());
    let (n, left) = (p.len(), left.as_mut_slice());
    means.fill(zero);
    for k in 0..n {
        means[k] = one;
        for i in 0..n {
            let entry = half * system.dissipation_of(q, means, i).value;
            matrix[i * n + k] = if i == k { one + entry } else { entry };
        }
        means[k] = zero;
    }
    for k in 0..n {
        let pivot = matrix[k * n + k];
        if !zero.lt(pivot).all() {
            return Err(StepFailure::Singular { dof: k, slope: Some(pivot.to_f64()) });
        }
        let inverse = pivot.recip();
        let (done, rows) = matrix.split_at_mut((k + 1) * n);
        let pivots = &done[k * n + k + 1..];
        for row in rows.chunks_exact_mut(n) {
            let factor = row[k] * inverse;
            row[k] = factor;
            row[k + 1..].iter_mut().zip(pivots).for_each(|(x, &y)| *x = (-factor).mul_add(y, *x));
        }
    }
    for _ in 0..3 {
        for j in 0..n {
            left[j] = p[j] - means[j] - half * system.dissipation_of(q, means, j).value;
        }
        for j in 1..n {
            left[j] = (0..j).fold(left[j], |x, k| (-matrix[j * n + k]).mul_add(left[k], x));
        }
        for j in (0..n).rev() {
            let rest = (j + 1..n).fold(left[j], |x, k| (-matrix[j * n + k]).mul_add(left[k], x));
            left[j] = rest / matrix[j * n + j];
        }
        means.iter_mut().zip(&*left).for_each(|(mean, &update)| *mean += update);
    }
    let two = one + one;
    for j in 0..n {
        let force = system.dissipation_of(q, means, j).value;
        w[j] = (h / system.mass(j) * force).mul_add(means[j], w[j]);
        p[j] = two.mul_add(means[j], -p[j]);
    }
    Ok(())
}

/// Updates one momentum after the other, in the given order. `means` holds P.
fn one_by_one<V, S>(
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
        // With P_j = 0 this is the force of the other momenta, since D is linear.
        let drag = system.dissipation_of(q, means, j);
        let slope = half.mul_add(drag.by_p, V::Scalar::one());
        if !zero.lt(slope).all() {
            return Err(StepFailure::Singular { dof: j, slope: Some(slope.to_f64()) });
        }
        let mean = (-half).mul_add(drag.value, p[j]) / slope;
        // The slope has the same rounding error in every step, so K would drift by this share of
        // p0². The residual corrects it.
        let left = p[j] - mean - half * drag.by_p.mul_add(mean, drag.value);
        let mean = mean + left / slope;
        let force = drag.by_p.mul_add(mean, drag.value);
        w[j] = (h / system.mass(j) * force).mul_add(mean, w[j]);
        p[j] = two.mul_add(mean, -p[j]);
        means[j] = mean + mean;
    }
    Ok(())
}
