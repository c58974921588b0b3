//! Any bytes as a table of markers give a sound take, no larger than the file allows, or an error.
#![no_main]
mod raw_take;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| raw_take::check(bytes, "fuzz.csv"));
