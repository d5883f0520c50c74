//! The benches are under `benches/`; this crate exists to keep their dependencies apart.
