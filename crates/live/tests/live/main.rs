//! Tests of frames as datagrams, and of the handling of all kinds of datagrams.

mod frames;
mod loopback;
mod packets;
mod streams;

use rhytid_live::Frame;

/// A frame of `markers` markers, `m0`, `m1`, …, whose positions tell which frame it is.
fn frame(number: i64, seconds: f64, markers: usize) -> Frame {
    let position = |j: usize| [number as f32 + 0.1, j as f32 / 3.0, -0.25];
    Frame { number, seconds, markers: (0..markers).map(|j| (format!("m{j}"), position(j))).collect() }
}

fn labels(markers: usize) -> Vec<String> {
    (0..markers).map(|j| format!("m{j}")).collect()
}
