//! Any bytes as a USD file (binary, text or a package) give a layer with its samples, and perhaps an
//! animation, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "usd_layer/mod.rs"]
mod usd_layer;

fuzz_target!(|bytes: &[u8]| usd_layer::decode(bytes));
