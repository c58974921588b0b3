//! The README's code, compiled like the examples of documentation. It is in this crate because a published
//! crate cannot include a file of another folder.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
