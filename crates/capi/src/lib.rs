//! Rhytid's runtime for C and C++: a rig from a file or from memory, devices, and frames in batches.
//!
//! `include/rhytid.h` is made from these sources by cbindgen, and a test compares both. `include/rhytid.hpp`
//! has the same for C++17. [`docs/c.md`](https://github.com/rhytid/rhytid/blob/main/docs/c.md) has examples.
//!
//! The rules of every function:
//!
//! - It catches panics, so that none crosses the border. It then returns
//!   [`RhytidStatus::Internal`](status::RhytidStatus::Internal).
//! - It checks each argument that can be checked: null pointers, lengths, numbers, and values of
//!   enumerations.
//!   It cannot check that a pointer leads to enough memory.
//! - It returns a [`RhytidStatus`](status::RhytidStatus), and the sentence of an error is in
//!   [`rhytid_last_error`](status::rhytid_last_error). Functions that only tell a fact return it, and 0 or
//!   null for a null pointer.
#![allow(unsafe_code, reason = "pointers of C programs; each block states what the caller guarantees")]

pub mod animator;
mod arguments;
pub mod devices;
pub mod enums;
mod held;
pub mod rig;
pub mod status;
pub mod take;
#[cfg(test)]
mod tests;
pub mod version;
pub mod vulkan;
