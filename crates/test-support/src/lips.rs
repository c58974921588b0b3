//! A small face with a mouth.
use rhytid_core::{Example, Face, Handles, Mesh, Settings, UpAxis, VertexId};

/// Vertices along the mouth.
pub const COLUMNS: usize = 13;

/// The rows of vertices of the upper lip, from above to the back of the mouth, as y and z.
///
/// They are its front, with a groove across it, and its lower side.
const LIP: [[f64; 2]; 17] = [
    [1.2, 0.0],
    [0.9, 0.05],
    [0.79, 0.07],
    [0.78, 0.02],
    [0.77, -0.03],
    [0.73, -0.03],
    [0.72, 0.03],
    [0.71, 0.08],
    [0.6, 0.1],
    [0.35, 0.15],
    [0.15, 0.12],
    [0.02, 0.0],
    [0.02, -0.1],
    [0.02, -0.2],
    [0.02, -0.3],
    [0.02, -0.4],
    [0.15, -0.6],
];

/// The number of rows. After those of the upper lip come the back of the mouth and the lower lip.
pub const ROWS: usize = 2 * LIP.len() + 1;

/// The row of the upper lip that handles are in.
pub const HANDLES: usize = 9;

/// The rows of the upper lip's lower side.
pub const UPPER: std::ops::Range<usize> = 11..16;

/// The place of a row, as y and z.
fn place(row: usize) -> [f64; 2] {
    match (LIP.get(row), LIP.get(opposite(row))) {
        (Some(place), _) => *place,
        (None, Some([y, z])) => [-y, *z],
        (None, None) => [0.0, -0.75],
    }
}

/// The vertex of a row and a column.
pub fn at(row: usize, column: usize) -> usize {
    row * COLUMNS + column
}

/// The row that is opposite a row.
pub fn opposite(row: usize) -> usize {
    ROWS - 1 - row
}

/// A mouth that is closed but for a narrow gap, with five handles on each lip. In the example it is open.
pub fn face() -> Face {
    let mut neutral = Mesh::default();
    for [y, z] in (0..ROWS).map(place) {
        neutral.positions.extend((0..COLUMNS).map(|column| [0.25 * column as f64 - 1.5, y, z]));
    }
    for (row, column) in (0..ROWS - 1).flat_map(|row| (0..COLUMNS - 1).map(move |column| (row, column))) {
        let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        neutral.faces.push(&corners.map(|v| v as u32));
    }
    let mut positions = neutral.positions.clone();
    for (v, x) in positions.iter_mut().enumerate() {
        // The lower lip goes down, and the back of the mouth in part.
        let [last, first] = [UPPER.end - 1, opposite(UPPER.end - 1)].map(|row| row as f64);
        x[1] -= 0.5 * (((v / COLUMNS) as f64 - last) / (first - last)).clamp(0.0, 1.0);
    }
    let handles: Vec<usize> = [HANDLES, opposite(HANDLES)]
        .iter()
        .flat_map(|row| [0, 3, 6, 9, 12].map(|column| at(*row, column)))
        .collect();
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
