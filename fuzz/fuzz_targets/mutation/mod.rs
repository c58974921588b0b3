//! Shared parts of the targets that change a part of a sound file.
use libfuzzer_sys::fuzzer_mutate;

/// Puts a changed file in the place of `data`, and returns its size. Any bytes change if there is no such
/// file or if it is too large.
pub fn replace(file: Option<Vec<u8>>, data: &mut [u8], size: usize, max_size: usize) -> usize {
    let Some(file) = file.filter(|file| file.len() <= max_size) else {
        return fuzzer_mutate(data, size, max_size);
    };
    data[..file.len()].copy_from_slice(&file);
    file.len()
}

/// Changes `bytes`. Their number may grow by a few.
pub fn mutate(bytes: &mut Vec<u8>) {
    let size = bytes.len();
    bytes.resize(size + 16, 0);
    let size = fuzzer_mutate(bytes, size, size + 16);
    bytes.truncate(size);
}
