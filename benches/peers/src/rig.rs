//! The rig to evaluate, and its handle positions.
use rhytid_core::{Error, Face, Method, NoProgress, Result, Rig, rig_file};
use std::f32::consts::PI;
use std::path::Path;

/// Reads the rig at `path`. If it does not exist, solves the demo face of about `vertices` vertices and
/// stores it there.
pub(crate) fn at(path: &Path, vertices: u32) -> Result<Rig> {
    if !path.exists() {
        eprintln!("solving the demo face with about {vertices} vertices, once");
        let rig = rhytid_solve::solve(&face(vertices as usize), &NoProgress)?.rounded()?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        }
        rig_file::write(path, &rig)?;
    }
    rig_file::read(path)
}

/// The demo face for the chapter's method, which the peers compute.
pub(crate) fn face(vertices: usize) -> Face {
    let mut face = rhytid_demo::face(vertices);
    face.settings.method = Method::Chapter;
    face
}

/// `frames` × H × 3 handle positions in mesh units: the examples come and go smoothly, one after the other.
pub(crate) fn handles_over_time(rig: &Rig, frames: usize) -> Result<Vec<f32>> {
    let examples: Vec<&[[f32; 3]]> = rig.examples().handles.rows().collect();
    if examples.is_empty() {
        return Err(Error::rig_lacks(format!(
            "{}: has no examples, so nothing to blend; add some",
            rig.surface().name
        )));
    }
    let mut positions = Vec::with_capacity(frames * rig.handles().len() * 3);
    for frame in 0..frames {
        let time = frame as f32 / frames as f32;
        let weight = |j: usize| (PI * (time + (j + 1) as f32 / (2 * examples.len()) as f32)).sin().powi(2);
        for (h, rest) in rig.handles().rest.iter().enumerate() {
            for c in 0..3 {
                let moves =
                    examples.iter().enumerate().map(|(j, example)| weight(j) * (example[h][c] - rest[c]));
                positions.push(rest[c] + moves.sum::<f32>());
            }
        }
    }
    Ok(positions)
}
