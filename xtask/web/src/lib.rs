//! The browser's pages: `crates/web`, compiled and finished by wasm-bindgen. The folder with its pages and a
//! rig can be served by any static host. A small host of our own is included. The npm package of
//! `crates/player` is built in the same way.
//!
//! It is a package of its own, since wasm-bindgen would lengthen the build of every other chore.
#![forbid(unsafe_code)]

mod build;
mod film;
mod player;
mod program;
mod server;

pub use build::{Size, build};
pub use player::build_player;
pub use program::Warnings;
pub use server::Server;

/// The error is one sentence for the person at the terminal.
pub type Result<T = ()> = std::result::Result<T, String>;
