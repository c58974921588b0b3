//! Real meshes, where they lie beside the repository.

use rhytid_formats::mesh::{read, read_like};
use rhytid_test_support::shared;

#[test]
fn reads_real_meshes_whole() {
    let Some(data) = shared("data") else { return };
    let head = read(&data.join("head/neutral.obj")).unwrap();
    assert_eq!((head.positions.len(), head.faces.len()), (26_719, 26_384));
    let uvs = head.uvs.as_ref().unwrap();
    assert_eq!(uvs.values.len(), 28_911);
    assert_eq!(uvs.corners.as_ref().unwrap().len(), head.faces.indices.len());
    // Both triangles and quads were kept.
    assert!(head.faces.counts.contains(&3) && head.faces.counts.contains(&4));

    let face = read(&data.join("face/neutral.obj")).unwrap();
    assert_eq!((face.positions.len(), face.faces.len()), (9_409, 9_230));
    assert!(face.faces.counts.iter().all(|&n| n == 4));
    assert!(face.uvs.is_some());
}

#[test]
fn real_poses_are_like_their_neutral() {
    let Some(data) = shared("data") else { return };
    for name in ["head", "face"] {
        let neutral_path = data.join(name).join("neutral.obj");
        let neutral = read(&neutral_path).unwrap();
        let mut poses = 0;
        for pose in std::fs::read_dir(data.join(name).join("poses")).unwrap() {
            let positions = read_like(&neutral, &neutral_path, &pose.unwrap().path()).unwrap();
            assert_eq!(positions.len(), neutral.positions.len());
            assert_ne!(positions, neutral.positions);
            poses += 1;
        }
        assert_eq!(poses, 8);
    }
}
