//! The integration tests of this crate, in one program.
mod choice;
mod confidence;
mod doctor;
mod large_scale;
mod pins;
mod points;
