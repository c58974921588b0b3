//! Any bytes as a USD file give a sound mesh or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_formats::mesh::Format;

mod sound_mesh;

fuzz_target!(|bytes: &[u8]| sound_mesh::decode(bytes, Format::Usd));
