//! A check that each D_j depends on no velocity but v_j, where the system claims this.

use afterbay_core::{DissipationForm, InputError, Mask, Scalar, System};

/// The sizes of q, p and v at which D is compared.
const SIZES: [f64; 2] = [0.1, 1.0];

/// 2^32 times the golden ratio, less 2^32. Its multiples are spread evenly over all numbers of 32
/// bits.
const GOLDEN: u32 = 0x9e37_79b9;

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
/// D is evaluated with all velocities single, with all doubled, and then, for each bit, with those
/// of the degrees of freedom doubled whose number has this bit set. Each D_j must have the value
/// that it had when v_j was the same. Any two numbers differ in some bit, so that a dependence of
/// D_j on v_k shows.
///
/// D of a separable system may be written in p, so that the momenta are doubled with the
/// velocities. Motors are left out, and values that are NaN do not count.
fn has_hidden_coupling<T: Scalar, S: System<T> + ?Sized>(system: &S, is_separable: bool) -> bool {
    let n = system.dof() - system.motors();
    let DissipationForm { zero, coupled, .. } = system.dissipation_form();
    if zero || coupled || n < 2 || system.finds_dissipation_form() {
        return false;
    }
    let dof = system.dof();
    let zeros = || vec![T::zero(); dof];
    let [mut q, mut p, mut v, mut single, mut double, mut found] = [(); 6].map(|()| zeros());
    for size in SIZES {
        let number = |i: usize| {
            let share = f64::from((i as u32).wrapping_mul(GOLDEN)) / f64::from(u32::MAX);
            T::from_f64(size * (0.5 + share))
        };
        let moving = p.iter_mut().chain(&mut v).enumerate();
        moving.for_each(|(i, x)| *x = number(i));
        q.iter_mut().enumerate().for_each(|(j, x)| *x = number(j + 2 * dof));
        // D where v_j is doubled if j & mask = bits.
        let mut evaluate = |mask: usize, bits: usize, found: &mut [T]| {
            let set = |x: &mut [T], first: usize| {
                for (j, x) in x[..n].iter_mut().enumerate() {
                    let single = number(j + first);
                    *x = if j & mask == bits { single + single } else { single };
                }
            };
            set(&mut v, dof);
            if is_separable {
                set(&mut p, 0);
            }
            system.dissipation(&q, &p, &v, found);
        };
        let (none, all) = (1, 0);
        evaluate(0, none, &mut single);
        evaluate(0, all, &mut double);
        for bit in (0..usize::BITS - (n - 1).leading_zeros()).map(|bit| 1 << bit) {
            evaluate(bit, bit, &mut found);
            let mut changed = T::zero().lt(T::zero());
            for (j, ((&now, &one), &two)) in found[..n].iter().zip(&single).zip(&double).enumerate()
            {
                let then = if j & bit == bit { two } else { one };
                changed = changed.or(now.lt(then)).or(then.lt(now));
            }
            if changed.any() {
                return true;
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
        for n in [1, 2, 3, 5, 8, 17] {
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
