//! Point caches in Blender, on the neutral as an OBJ.

use super::{faces, programs};
use rhytid::core::Mesh;
use rhytid::formats::mesh;

#[test]
fn blender_plays_point_caches_on_the_neutral() {
    let folder = tempfile::tempdir().unwrap();
    for animation in [faces::demo(), faces::other_axes_and_units()] {
        let rig = &animation.rig;
        let neutral = Mesh {
            positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
            faces: rig.surface().faces.clone(),
            uvs: rig.surface().uvs.clone(),
            materials: None,
        };
        let path = folder.path().join(format!("{}.obj", rig.surface().name));
        mesh::write_obj(&path, &neutral).unwrap();
        let cache = animation.export(&format!("{}.pc2", rig.surface().name), "--head drop");
        let found = programs::blender_point_cache(&path, &cache, &animation.frames);
        // Blender keeps the numbers that it reads.
        assert!(found == animation.positions, "{}: {} numbers", rig.surface().name, found.len());
    }
}
