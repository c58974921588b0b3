//! The C interface, as C and C++ programs use it.
#[path = "../../install/layout.rs"]
mod layout;

mod drawing;
mod header;
mod install;
mod programs;
mod support;
mod symbols;
