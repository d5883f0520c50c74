//! A check that each D_j depends on no velocity but v_j, where the system claims this.

use afterbay_core::{DissipationForm, InputError, Mask, Scalar, System};

/// The sizes of q and p at which D is compared.
const SIZES: [f64; 2] = [0.1, 1.0];

/// Refuses a system whose D_j depends on other velocities without saying so. `is_separable` tells
/// whether H is known to be separable.
///
/// # Errors
/// [`InputError::Unsupported`].
pub(crate) fn states_coupling<T: Scalar, S: System<T> + ?Sized>(
    method: &'static str,
    system: &S,
    is_separable: bool,
) -> Result<(), InputError> {
    if has_hidden_coupling(system, is_separable) {
        let why = "some D_j depends on the velocity of another degree of freedom, and \
                   dissipation_form() says that it does not: set `coupled`";
        return Err(InputError::Unsupported { method, why });
    }
    Ok(())
}

/// Whether some D_j depends on another velocity although [`DissipationForm::coupled`] is false.
///
/// For each bit, the velocities of all degrees of freedom whose number has this bit set are
/// doubled, and then those of the others. D_j of the degrees of freedom that are not doubled must
/// not change. Any two numbers differ in some bit, so that a dependence of D_j on v_k shows. D of a
/// separable system may be written in p, so that the momenta are doubled with the velocities.
/// Motors are left out, and values that are NaN do not count.
fn has_hidden_coupling<T: Scalar, S: System<T> + ?Sized>(system: &S, is_separable: bool) -> bool {
    let n = system.dof() - system.motors();
    let DissipationForm { zero, coupled, .. } = system.dissipation_form();
    if zero || coupled || n < 2 {
        return false;
    }
    let zeros = || vec![T::zero(); system.dof()];
    let [mut q, mut before, mut after] = [(); 3].map(|()| zeros());
    // v and p, and how many of the two are doubled.
    let (mut motion, doubled) = ([zeros(), zeros()], 1 + usize::from(is_separable));
    let mut seed = 1_u64;
    let mut number = |size: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        T::from_f64(size * ((seed >> 11) as f64 / (1_u64 << 53) as f64 + 0.5))
    };
    for size in SIZES {
        let [v, p] = &mut motion;
        q.iter_mut().chain(&mut *p).for_each(|x| *x = number(size));
        system.gradient(&q, p, &mut after, v);
        system.dissipation(&q, p, v, &mut before);
        for bit in 0..usize::BITS - (n - 1).leading_zeros() {
            for set in [0, 1] {
                let moves = |j: usize| (j >> bit) & 1 == set;
                let scale = |motion: &mut [Vec<T>], by: fn(T) -> T| {
                    for x in motion {
                        (0..n).filter(|&j| moves(j)).for_each(|j| x[j] = by(x[j]));
                    }
                };
                scale(&mut motion[..doubled], |x| x + x);
                system.dissipation(&q, &motion[1], &motion[0], &mut after);
                scale(&mut motion[..doubled], T::half);
                let changes = |j: usize| before[j].lt(after[j]).or(after[j].lt(before[j])).any();
                if (0..n).any(|j| !moves(j) && changes(j)) {
                    return true;
                }
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterbay_core::{Formulas, FromFormulas};

    /// Free masses, of which one may be braked relative to another.
    #[derive(Clone)]
    struct Dashpot {
        n: usize,
        between: Option<[usize; 2]>,
    }

    impl Formulas for Dashpot {
        fn dof(&self) -> usize {
            self.n
        }

        fn potential<T: Scalar>(&self, _q: &[T]) -> T {
            T::zero()
        }

        fn dissipation<T: Scalar>(&self, _q: &[T], v: &[T], j: usize) -> T {
            match self.between {
                Some([i, k]) if j == i => v[i] - v[k],
                _ => v[j],
            }
        }
    }

    #[test]
    fn every_pair_of_velocities_is_seen() {
        for n in [1, 2, 3, 5, 8] {
            let coupled = |between| {
                let system = FromFormulas(Dashpot { n, between });
                has_hidden_coupling::<f64, _>(&system, true)
            };
            assert!(!coupled(None), "{n}");
            for i in 0..n {
                for k in (0..n).filter(|&k| k != i) {
                    assert!(coupled(Some([i, k])), "{n}: D{i} by v{k}");
                }
            }
        }
    }
}
