//! The integration tests of this crate, in one program.
mod confidence;
mod real_data;
