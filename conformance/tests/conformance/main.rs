//! Tests of the conformance suite itself: its cases, its references, and the faults that it notices. The
//! method is tested on golden, random and real faces. (Devices are tested in `tests/devices.rs`.)

mod bends;
mod coverage;
mod cpu;
mod explain;
mod golden;
mod learned;
mod must_pass;
mod mutants;
mod other_data;
mod other_topology;
mod real_data;
mod rotations;
mod stored;
#[path = "../support/mod.rs"]
mod support;
mod toy;
mod toy_backend;
mod what_must_hold;
