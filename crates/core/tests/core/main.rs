//! The integration tests of this crate, in one program.
mod animator;
mod atomic_file;
mod clustered_basis;
mod plan;
mod rig_file;
