//! All tests of the core in one program.

#![cfg(test)]

mod caught;
mod check;
mod check_drive;
mod check_hidden;
mod events;
mod events_of_several;
mod integrate;
mod scalars;
