//! Frames as datagrams, and what becomes of datagrams of any kind.

mod loopback;
mod packets;
mod streams;

use rhytid_live::Frame;

/// A frame of so many markers, `m0`, `m1`, …, whose positions say which frame it is.
fn frame(number: i64, seconds: f64, markers: usize) -> Frame {
    let position = |j: usize| [number as f32 + 0.1, j as f32 / 3.0, -0.25];
    Frame { number, seconds, markers: (0..markers).map(|j| (format!("m{j}"), position(j))).collect() }
}

fn labels(markers: usize) -> Vec<String> {
    (0..markers).map(|j| format!("m{j}")).collect()
}
