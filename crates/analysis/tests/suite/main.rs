//! All tests of the studies in one program.

#![cfg(test)]

mod after;
mod contact;
mod global_orders;
mod local_orders;
mod long_run;
mod pick;
mod references;
mod stability;
mod tangent;
mod trajectory;
