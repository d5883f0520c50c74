//! All tests of the core in one program.

#![cfg(test)]

mod caught;
mod check;
mod check_hidden;
mod events;
mod integrate;
mod scalars;
