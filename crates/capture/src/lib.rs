//! From a raw take to a clean one: pure functions, one clean-up step a file.
#![forbid(unsafe_code)]

pub mod coverage;
