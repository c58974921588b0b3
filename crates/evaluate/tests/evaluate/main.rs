//! The integration tests of this crate, in one program.
mod confidence;
mod places;
mod real_data;
