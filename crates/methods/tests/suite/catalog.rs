//! Systems of the catalogue and from expressions, in the forms that their crate compiles, so that
//! they are not compiled again here.

use crate::bind::{Able, AnyMembers, AnySeparable, Curved};
use crate::many::InSeries;
use afterbay_core::{Abilities, Corrected, InputError, PhasePlane, Series};
use afterbay_methods::registry::{Number, Row, Run};
use afterbay_systems::catalog::{Compensable, Expandable};
use afterbay_systems::{
    CustomGeneral, DAMPED_DOUBLE_PENDULUM, DAMPED_OSCILLATOR, DUFFING, Described, Description,
    FPUT_CHAIN, GeneralDescription, MODIFIED_VAN_DER_POL, SystemRow, VAN_DER_POL, VAN_DER_POL_RING,
    catalog,
};
use std::ops::Deref;
use std::sync::Arc;

/// The definition of a system, from which it is made in any scalar.
#[derive(Clone)]
enum Origin {
    /// A row of the catalogue, the number of degrees of freedom, and the other parameters.
    Row(&'static SystemRow, usize, Vec<f64>),
    Text(Described),
}

/// A system in any scalar. It dereferences to the system in `f64`.
#[derive(Clone)]
pub(crate) struct Built {
    origin: Origin,
    in_f64: Arc<dyn Abilities<f64>>,
}

/// The abilities with which a system is bound: those of any H, of one with phase planes, of a
/// separable H, of one with known δ, of a linear system with printed δ, and of equal members.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum As {
    Curved,
    General,
    Separable,
    Nonlinear,
    Linear,
    Uniform,
}

/// A scalar in which systems are made and methods bound.
pub(crate) trait Both: Number + catalog::Number {}
impl<T: Number + catalog::Number> Both for T {}

fn listed(row: &'static SystemRow, n: usize, parameters: &[f64]) -> Built {
    Built::new(Origin::Row(row, n, parameters.to_vec()))
}

/// A system with separable H from expressions.
pub(crate) fn written(description: &Description) -> Built {
    Built::new(Origin::Text(Described::separable(description).unwrap()))
}

/// A system with any H from expressions.
pub(crate) fn written_general(description: &GeneralDescription) -> Built {
    Built::new(Origin::Text(Described::General(CustomGeneral::new(description).unwrap())))
}

pub(crate) fn oscillator(k: f64, b: f64) -> Built {
    listed(&DAMPED_OSCILLATOR, 1, &[k, b])
}

pub(crate) fn duffing(alpha: f64, beta: f64, c: f64) -> Built {
    listed(&DUFFING, 1, &[alpha, beta, c])
}

pub(crate) fn van_der_pol(mu: f64) -> Built {
    listed(&VAN_DER_POL, 1, &[mu])
}

pub(crate) fn modified_van_der_pol(mu: f64, alpha: f64, beta: f64) -> Built {
    listed(&MODIFIED_VAN_DER_POL, 1, &[mu, alpha, beta])
}

pub(crate) fn chain(n: usize, beta: f64, c: f64) -> Built {
    listed(&FPUT_CHAIN, n, &[beta, c])
}

pub(crate) fn ring(n: usize, mu: f64, coupling: f64) -> Built {
    listed(&VAN_DER_POL_RING, n, &[mu, coupling])
}

pub(crate) fn pendulum(masses: [f64; 2], lengths: [f64; 2], g: f64, c: [f64; 2]) -> Built {
    let [[m1, m2], [l1, l2], [c1, c2]] = [masses, lengths, c];
    listed(&DAMPED_DOUBLE_PENDULUM, 2, &[m1, m2, l1, l2, g, c1, c2])
}

impl Deref for Built {
    type Target = dyn Abilities<f64>;

    fn deref(&self) -> &Self::Target {
        &*self.in_f64
    }
}

impl Origin {
    fn make<T: catalog::Number>(&self) -> Arc<dyn Abilities<T>> {
        match self {
            Self::Row(row, n, x) => T::system(row, *n, &lifted(x, T::from_f64)).unwrap(),
            Self::Text(system) => T::custom(system, &|_, x| T::from_f64(x)),
        }
    }
}

fn lifted<T>(parameters: &[f64], lift: impl Fn(f64) -> T) -> Vec<T> {
    parameters.iter().map(|&x| lift(x)).collect()
}

impl Built {
    fn new(origin: Origin) -> Self {
        let in_f64 = origin.make();
        Self { origin, in_f64 }
    }

    pub(crate) fn abilities<T: catalog::Number>(&self) -> Arc<dyn Abilities<T>> {
        self.origin.make()
    }

    pub(crate) fn curved<T: catalog::Number>(&self) -> Arc<Curved<T>> {
        self.abilities().second_derivatives().unwrap()
    }

    pub(crate) fn separable<T: catalog::Number>(&self) -> Arc<AnySeparable<T>> {
        self.abilities().separable().unwrap()
    }

    pub(crate) fn planes<T: catalog::Number>(&self) -> Arc<dyn PhasePlane<T>> {
        self.abilities().phase_planes().unwrap()
    }

    pub(crate) fn members(&self) -> Arc<AnyMembers> {
        self.in_f64.clone().uniform().unwrap()
    }

    pub(crate) fn series<T: Expandable>(&self) -> Arc<InSeries<T>> {
        let constant = |x| Series::constant(T::from_f64(x));
        match &self.origin {
            Origin::Row(row, n, x) => T::series(row, *n, &lifted(x, constant)).unwrap(),
            Origin::Text(system) => T::custom_series(system),
        }
    }

    /// The system in the numbers of compensation.
    pub(crate) fn corrected<T: Compensable>(&self) -> Arc<AnySeparable<Corrected<T>>> {
        let exact = |x| Corrected::exact(T::from_f64(x));
        let corrected = match &self.origin {
            Origin::Row(row, n, x) => T::corrected(row, *n, &lifted(x, exact)).unwrap(),
            Origin::Text(system) => T::custom_corrected(system),
        };
        corrected.unwrap()
    }

    /// Binds the system with some of its abilities.
    pub(crate) fn bind<T: Both>(&self, row: &Row, form: As) -> Result<Run<T>, InputError> {
        let (all, mut able) = (self.abilities::<T>(), Able::new(self.curved()));
        if form == As::General {
            able.planes = all.clone().phase_planes();
        } else if form != As::Curved {
            able.separable = all.clone().separable();
        }
        if form == As::Nonlinear || form == As::Linear {
            able.raising = all.clone().order_raising();
        }
        if form == As::Linear {
            able.linear = all.clone().linear();
            able.misprinted = all.clone().misprinted();
        }
        if form == As::Uniform {
            able.members = all.uniform();
        }
        able.bind(row)
    }
}
