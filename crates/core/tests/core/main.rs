//! The integration tests of this crate, in one program.
mod animator;
mod plan;
mod rig_file;
mod write_beside;
