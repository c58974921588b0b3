//! A small face with an eyeball.
use rhytid_core::{Example, Face, Handles, Mesh, Settings, UpAxis, VertexId};

/// The radius of the eyeball, whose centre is the origin.
pub const RADIUS: f64 = 1.0;

/// The distance of the skin from the centre.
pub const SKIN: f64 = 1.15;

/// Vertices along a side of the skin. They are the first, row after row.
pub const SIDE: usize = 13;

/// The vertices of the eyeball.
pub const EYEBALL: std::ops::Range<usize> = SIDE * SIDE..SIDE * SIDE + RINGS * SEGMENTS + 2;
/// The vertices of the lash: its root, then its tip.
pub const LASH: std::ops::Range<usize> = EYEBALL.end..EYEBALL.end + 6;

const RINGS: usize = 7;
const SEGMENTS: usize = 10;

/// A dome of skin over an eyeball in a flat face, with a lash at its middle and nine handles.
///
/// In the example, the skin is farther out by up to a tenth, the lash is longer, and the eyeball is turned.
pub fn face() -> Face {
    let mut neutral = Mesh::default();
    for i in 0..SIDE * SIDE {
        let [x, y] = [i % SIDE, i / SIDE].map(|k| k as f64 - 6.0).map(|d| 0.15 * d + 0.018 * d * d * d);
        let z = (SKIN * SKIN - x * x - y * y).max(0.01).sqrt();
        neutral.positions.push([x, y, z]);
    }
    let at = |row: usize, column: usize| (row * SIDE + column) as u32;
    for (row, column) in (0..SIDE - 1).flat_map(|row| (0..SIDE - 1).map(move |column| (row, column))) {
        let corners = [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
        neutral.faces.push(&corners);
    }
    let first = EYEBALL.start as u32;
    for ring in 1..=RINGS {
        let (up, out) = (std::f64::consts::PI * ring as f64 / (RINGS + 1) as f64).sin_cos();
        for segment in 0..SEGMENTS {
            let (s, c) = (std::f64::consts::TAU * segment as f64 / SEGMENTS as f64).sin_cos();
            neutral.positions.push([up * c, out, up * s].map(|x| RADIUS * x));
        }
    }
    neutral.positions.extend([[0.0, RADIUS, 0.0], [0.0, -RADIUS, 0.0]]);
    let on_ring = |ring: usize, segment: usize| first + (ring * SEGMENTS + segment % SEGMENTS) as u32;
    let poles = [0, 1].map(|pole| first + (RINGS * SEGMENTS + pole) as u32);
    for segment in 0..SEGMENTS {
        for ring in 0..RINGS - 1 {
            let corners =
                [(ring, segment), (ring, segment + 1), (ring + 1, segment + 1), (ring + 1, segment)];
            neutral.faces.push(&corners.map(|(ring, segment)| on_ring(ring, segment)));
        }
        neutral.faces.push(&[poles[0], on_ring(0, segment + 1), on_ring(0, segment)]);
        neutral.faces.push(&[poles[1], on_ring(RINGS - 1, segment), on_ring(RINGS - 1, segment + 1)]);
    }
    let first = LASH.start as u32;
    neutral
        .positions
        .extend((0..6).map(|i| [0.2 * f64::from(i % 3) - 0.2, 0.05, 1.2 + 0.2 * f64::from(i / 3)]));
    neutral.faces.push(&[first, first + 1, first + 4, first + 3]);
    neutral.faces.push(&[first + 1, first + 2, first + 5, first + 4]);

    let mut positions = neutral.positions.clone();
    for (v, x) in positions.iter_mut().enumerate() {
        let [_, y, z] = *x;
        if EYEBALL.contains(&v) {
            let (s, c) = 0.3_f64.sin_cos();
            (x[1], x[2]) = (c * y - s * z, s * y + c * z);
        } else {
            let longer = if v >= LASH.start + 3 { 0.2 } else { 0.1 };
            let out = 1.0 + longer * (0.5 + 0.5 * y).clamp(0.0, 1.0);
            *x = x.map(|x| out * x);
        }
    }
    let handles: Vec<u32> =
        [0, 6, 12].iter().flat_map(|row| [0, 6, 12].map(|column| at(*row, column))).collect();
    Face {
        name: "eye".into(),
        neutral,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..handles.len()).map(|h| format!("h{h}")).collect(),
            points: handles.into_iter().map(|v| VertexId(v).into()).collect(),
        },
        examples: vec![Example { name: "wide".into(), positions, mirror: false, noise: Some(0.0) }],
        prior: None,
        settings: Settings::default(),
    }
}
