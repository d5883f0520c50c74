//! The findings of a check, compared with the error put in; and the initial state.

use afterbay_core::{Block, InputError, Quantity};

pub(crate) const N: usize = 4;
pub(crate) const Q: [f64; N] = [0.7, -0.4, 1.2, 0.3];
pub(crate) const P: [f64; N] = [0.5, 0.9, -0.6, 0.2];

pub(crate) type Caught = Result<(), InputError>;

/// The lie is found by this quantity of this degree of freedom, and the message says so.
#[track_caller]
pub(crate) fn assert_caught(found: Caught, quantity: Quantity, dof: usize, says: &str) -> [f64; 2] {
    let error = found.unwrap_err();
    assert!(error.to_string().contains(says), "{error}");
    match error {
        InputError::Contradiction { quantity: q, dof: j, given, found, .. } => {
            assert_eq!((q, j), (quantity, dof), "{error}");
            [given, found]
        }
        _ => panic!("{error}"),
    }
}

#[track_caller]
pub(crate) fn assert_entry(found: Caught, place: (Block, usize, usize), says: &str) -> [f64; 2] {
    let error = found.unwrap_err();
    assert!(error.to_string().contains(says), "{error}");
    match error {
        InputError::ContradictionBetween { block, row, column, given, found, .. } => {
            assert_eq!((block, row, column), place, "{error}");
            [given, found]
        }
        _ => panic!("{error}"),
    }
}
