//! The browser's pages: `crates/web` compiled and finished by wasm-bindgen, with its pages and a rig, as a folder that any static host
//! serves; and a small host of our own.
//!
//! A package of its own, since what finishes WebAssembly would lengthen the build of every other chore.
#![forbid(unsafe_code)]

mod build;
mod server;

pub use build::{Size, build};
pub use server::Server;

/// The error is one sentence for the person at the terminal.
pub type Result<T = ()> = std::result::Result<T, String>;
