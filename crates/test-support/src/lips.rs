//! A small face with a mouth.
use rhytid_core::{Example, Face, Handles, Mesh, Settings, UpAxis, VertexId};

/// Vertices along the mouth.
pub const COLUMNS: usize = 13;

/// The rows of vertices from above to below, as y and z.
///
/// They are the front of the upper lip and its lower side. Then come the back of the mouth, the upper side of
/// the lower lip, and its front.
pub const ROWS: [[f64; 2]; 19] = [
    [1.2, 0.0],
    [0.9, 0.05],
    [0.6, 0.1],
    [0.35, 0.15],
    [0.15, 0.12],
    [0.02, 0.0],
    [0.02, -0.2],
    [0.02, -0.4],
    [0.15, -0.6],
    [0.0, -0.75],
    [-0.15, -0.6],
    [-0.02, -0.4],
    [-0.02, -0.2],
    [-0.02, 0.0],
    [-0.15, 0.12],
    [-0.35, 0.15],
    [-0.6, 0.1],
    [-0.9, 0.05],
    [-1.2, 0.0],
];

/// The rows of the upper lip's lower side.
pub const UPPER: std::ops::Range<usize> = 5..8;

/// The vertex of a row and a column.
pub fn at(row: usize, column: usize) -> usize {
    row * COLUMNS + column
}

/// The row that is opposite a row.
pub fn opposite(row: usize) -> usize {
    ROWS.len() - 1 - row
}

/// A mouth that is closed but for a narrow gap, with five handles on each lip. In the example it is open.
pub fn face() -> Face {
    let mut neutral = Mesh::default();
    for [y, z] in ROWS {
        neutral.positions.extend((0..COLUMNS).map(|column| [0.25 * column as f64 - 1.5, y, z]));
    }
    for (row, column) in (0..ROWS.len() - 1).flat_map(|row| (0..COLUMNS - 1).map(move |column| (row, column)))
    {
        let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        neutral.faces.push(&corners.map(|v| v as u32));
    }
    let mut positions = neutral.positions.clone();
    for (v, x) in positions.iter_mut().enumerate() {
        // The lower lip goes down, and the back of the mouth in part.
        x[1] -= 0.5 * ((v / COLUMNS) as f64 - 7.0).clamp(0.0, 4.0) / 4.0;
    }
    let handles: Vec<usize> =
        [3, opposite(3)].iter().flat_map(|row| [0, 3, 6, 9, 12].map(|column| at(*row, column))).collect();
    Face {
        name: "lips".into(),
        neutral,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..handles.len()).map(|h| format!("h{h}")).collect(),
            points: handles.into_iter().map(|v| VertexId::from_index(v).into()).collect(),
        },
        examples: vec![Example { name: "open".into(), positions, mirror: false, noise: Some(0.0) }],
        prior: None,
        settings: Settings::default(),
    }
}
