//! All tests of the studies in one program.

#![cfg(test)]

mod after;
mod local_orders;
mod pick;
mod references;
mod stability;
