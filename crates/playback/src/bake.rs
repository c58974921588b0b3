//! The head's motion put into the vertices.

use rhytid_core::RigidMotion;

/// Moves a frame's V positions and normals as the head moves.
///
/// A position x becomes R x + t, and a normal n becomes R n. They are computed in f64 and rounded once.
/// `normals` is empty where no normals are wanted.
pub(crate) fn bake(motion: &RigidMotion, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
    let [x, y, z, _] = motion.matrix();
    let turn = |v: &[f32; 3]| {
        let v = v.map(f64::from);
        [x, y, z].map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    };
    let t = motion.translation;
    for p in positions {
        let turned = turn(p);
        *p = std::array::from_fn(|c| (turned[c] + t[c]) as f32);
    }
    for n in normals {
        *n = turn(n).map(|c| c as f32);
    }
}
