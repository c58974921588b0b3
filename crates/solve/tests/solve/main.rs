//! The integration tests of this crate, in one program.
mod choice;
mod confidence;
mod contact;
mod doctor;
mod head;
mod large_scale;
mod openings;
mod parts;
mod pins;
mod points;
mod welded;
