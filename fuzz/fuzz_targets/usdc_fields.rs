//! A binary USD file with one changed field, index, token or value. Most of these files get past the
//! compression and the table of contents, which plain bytes hardly do.
#![no_main]
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

#[path = "usd_layer/mod.rs"]
mod usd_layer;
#[path = "usdc_sections/mod.rs"]
mod usdc_sections;

fuzz_target!(|bytes: &[u8]| usd_layer::decode(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let file = usdc_sections::changed(&data[..size], seed).filter(|file| file.len() <= max_size);
    let Some(file) = file else { return fuzzer_mutate(data, size, max_size) };
    data[..file.len()].copy_from_slice(&file);
    file.len()
});
