//! The README's code, compiled as documentation's examples are. It stands here since a crate that is published has no file of another
//! folder.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
