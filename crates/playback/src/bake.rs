//! The head's motion put into the vertices.

use rhytid_core::RigidMotion;

/// Moves frames as the head moves: x ↦ R x + t for positions, n ↦ R n for normals, computed in f64 and rounded once.
#[derive(Default)]
pub(crate) struct Bake {
    positions: Vec<f32>,
    normals: Vec<f32>,
}

impl Bake {
    /// A frame's 3V positions and normals (empty where they are not wanted), moved.
    pub(crate) fn frame(&mut self, motion: &RigidMotion, [positions, normals]: [&[f32]; 2]) -> [&[f32]; 2] {
        let [x, y, z, _] = motion.matrix();
        let turn = |v: &[f32; 3]| {
            let v = v.map(f64::from);
            [x, y, z].map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
        };
        let t = motion.translation;
        self.positions.clear();
        self.positions.extend(positions.as_chunks::<3>().0.iter().flat_map(|p| {
            let turned = turn(p);
            std::array::from_fn::<f32, 3, _>(|c| (turned[c] + t[c]) as f32)
        }));
        self.normals.clear();
        self.normals.extend(normals.as_chunks::<3>().0.iter().flat_map(|n| turn(n).map(|c| c as f32)));
        [&self.positions, &self.normals]
    }
}
