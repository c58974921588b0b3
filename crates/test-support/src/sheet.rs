//! A small face without faults.
use rhytid_core::{Example, Face, Faces, Handles, Mesh, Settings, UpAxis, VertexId};

/// Vertices along a side of the sheet.
pub const SIDE: u32 = 5;

/// A curved sheet of 5 × 5 vertices, 16 cm wide, in 16 quads.
///
/// The vertices come row after row, and those of a row are on a line. Handles are at its corners and its
/// middle. One example lifts the middle and folds a vertex beside it.
pub fn face() -> Face {
    let mut neutral = Mesh::default();
    add_sheet(&mut neutral, SIDE, SIDE, [0.0; 3]);
    let mut smile = neutral.positions.clone();
    smile[12][2] += 1.5;
    smile[13][2] += 0.4;
    Face {
        name: "sheet".into(),
        neutral,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: ["a", "b", "c", "d", "e"].map(String::from).to_vec(),
            points: [0, 4, 12, 20, 24].map(|v| VertexId(v).into()).to_vec(),
        },
        examples: vec![Example { name: "smile".into(), positions: smile, mirror: false, noise: None }],
        prior: None,
        settings: Settings::default(),
    }
}

/// Adds `columns` × `rows` vertices, 4 units apart, in quads that share no vertex with the rest of the mesh.
pub fn add_sheet(mesh: &mut Mesh, columns: u32, rows: u32, at: [f64; 3]) {
    let first = mesh.positions.len() as u32;
    for row in 0..rows {
        for column in 0..columns {
            let (x, y) = (4.0 * f64::from(column), 4.0 * f64::from(row));
            mesh.positions.push([at[0] + x, at[1] + y, at[2] + 0.05 * y * y]);
        }
    }
    let faces: &mut Faces = &mut mesh.faces;
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let a = first + row * columns + column;
            faces.push(&[a, a + 1, a + 1 + columns, a + columns]);
        }
    }
}
