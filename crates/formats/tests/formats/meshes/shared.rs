//! Real meshes, where they lie beside the repository.

use super::support::{message, polygons};
use rhytid_formats::mesh::{Format, read, read_like, read_shapes};
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

/// Files as other programs write them, each with what Blender reads from it.
#[test]
fn files_of_other_people_are_read_or_named() {
    let Some(folder) = shared("data/other-people/meshes") else { return };
    for (name, vertices, faces) in [
        ("wings.obj", 5, vec![vec![0, 1, 2, 3]]),
        ("trailing_slash.obj", 5, vec![vec![0, 1, 2, 3]]),
        ("two_corners.obj", 5, vec![vec![0, 1, 2, 3]]),
        ("cr.obj", 5, vec![vec![0, 1, 2, 3]]),
        ("vt_index_no_vt.obj", 3, vec![vec![0, 1, 2]]),
        ("backslash_name.obj", 3, vec![vec![0, 1, 2]]),
        ("gbk_materials.obj", 4, vec![vec![0, 1, 2], vec![0, 2, 3]]),
    ] {
        let mesh = read(&folder.join(name)).unwrap();
        assert_eq!((mesh.positions.len(), polygons(&mesh)), (vertices, faces), "{name}");
        assert_eq!(mesh.uvs.is_some(), name == "trailing_slash.obj", "{name}");
        if name == "gbk_materials.obj" {
            assert_eq!(mesh.materials.unwrap().names().collect::<Vec<_>>(), ["%BA%C3", "%C4%E3"]);
        }
    }
    let wedge = read(&folder.join("meshlab_wedge.ply")).unwrap();
    assert_eq!((wedge.positions.len(), wedge.faces.len()), (502, 1000));
    // The first and the last face, from the text of the file.
    assert_eq!(
        (wedge.faces.indices[..3].to_vec(), wedge.faces.indices[2997..].to_vec()),
        (vec![0, 5, 1], vec![75, 497, 455])
    );
    assert_eq!(wedge.uvs.unwrap().values[2999], [0.347005, 0.531652]);
    for (name, words) in [
        (
            "comma.obj",
            "line 1: found \"0,5\", expected a number with a decimal point; the file has decimal commas",
        ),
        ("utf16.obj", "is UTF-16 text; save it as UTF-8"),
    ] {
        let said = message(read(&folder.join(name)).map(|_| ()));
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_file_under_another_extension_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        folder.path().join(name)
    };
    let ply = include_bytes!("data/trimesh.ply");
    let said = message(read(&write("head.obj", ply)).map(|_| ()));
    assert!(
        said.ends_with("head.obj: is a PLY file by its first bytes, not OBJ; rename it to .ply"),
        "{said}"
    );
    let said = message(read_shapes(&write("head.glb", ply)).map(|_| ()));
    assert!(
        said.ends_with("head.glb: is a PLY file by its first bytes, not glTF; rename it to .ply"),
        "{said}"
    );
    let said = message(read(&write("head.ply", include_bytes!("data/trimesh.glb"))).map(|_| ()));
    assert!(
        said.contains("is a glTF file by its first bytes") && said.contains("rename it to .glb"),
        "{said}"
    );
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n";
    for name in ["a.obj", "a.ply", "a.glb", "a.gltf"] {
        let said = message(read(&write(name, pointer)).map(|_| ()));
        assert!(said.ends_with("is a Git LFS pointer, not the mesh itself; run `git lfs pull`"), "{said}");
    }
    let said = message(Format::from_extension("head.FBX".as_ref()).map(|_| ()));
    assert!(said.starts_with("head.FBX: is FBX, which is not read; export the mesh as"), "{said}");
}
