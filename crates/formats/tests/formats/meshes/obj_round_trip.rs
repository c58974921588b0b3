use proptest::prelude::*;
use rhytid_core::{Error, Faces, Material, Materials, Mesh, Uvs};
use rhytid_formats::mesh::{Format, check, decode, read, write_obj};

/// Any mesh that passes `check`, in the form in which it is read: corners only where they say something.
fn meshes() -> impl Strategy<Value = Mesh> {
    let coordinate = prop_oneof![
        -1e3..1e3_f64,
        any::<f32>().prop_filter("finite", |x| x.is_finite()).prop_map(f64::from),
        prop::sample::select(vec![0.0, -0.0, 1e-300, f64::MIN_POSITIVE, f64::from(f32::MAX), 0.1 + 0.2]),
    ];
    let uv = any::<[f32; 2]>().prop_filter("finite", |uv| uv.iter().all(|x| x.is_finite()));
    (
        prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 1..20),
        0..3_usize,
        1..25_usize,
    )
        .prop_flat_map(move |(positions, kind, uv_count)| {
            let vertices = positions.len();
            let face = prop::collection::vec((0..vertices as u32, 0..uv_count as u32), 3..7);
            let uv_count = if kind == 1 { vertices } else { uv_count };
            let values = prop::collection::vec(uv.clone(), uv_count);
            (Just(positions), prop::collection::vec(face, 1..12), values, Just(kind))
        })
        .prop_map(|(positions, polygons, values, kind)| {
            let mut faces = Faces::default();
            for polygon in &polygons {
                faces.push(&polygon.iter().map(|c| c.0).collect::<Vec<_>>());
            }
            let corners: Vec<u32> = polygons.iter().flatten().map(|c| c.1).collect();
            // Some faces have no material, some share one.
            let mut materials = Materials::default();
            for polygon in &polygons {
                if polygon.len() == 5 {
                    materials.of_face.push(Materials::NONE);
                    continue;
                }
                let name = format!("skin {}", polygon[0].1 % 3);
                let known = materials.list.iter().position(|material| material.name == name);
                let index = known.unwrap_or_else(|| {
                    materials.list.push(Material::new(name));
                    materials.list.len() - 1
                });
                materials.of_face.push(index as u32);
            }
            let materials = (!materials.list.is_empty()).then_some(materials);
            let uvs = match kind {
                0 => None,
                1 => Some(Uvs { values, corners: None }),
                _ if values.len() == positions.len() && corners == faces.indices => None,
                _ => Some(Uvs { values, corners: Some(corners) }),
            };
            Mesh { positions, faces, uvs, materials }
        })
}

proptest! {
    #[test]
    fn what_is_written_is_read(mesh in meshes()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a face.OBJ");
        check(&mesh, "made up").unwrap();
        write_obj(&path, &mesh).unwrap();
        prop_assert_eq!(read(&path).unwrap(), mesh);
        // The temporary file is gone.
        prop_assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

#[test]
fn writes_plain_obj() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.obj");
    let mut mesh = Mesh {
        positions: vec![[0.0, 0.1, -2.5], [1e-7, 1.0, 0.0], [3.0, 1.0, 1.0]],
        faces: Faces { counts: vec![3], indices: vec![2, 0, 1] },
        uvs: Some(Uvs { values: vec![[0.25, 0.1]], corners: Some(vec![0, 0, 0]) }),
        materials: None,
    };
    write_obj(&path, &mesh).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, "v 0.0 0.1 -2.5\nv 1e-7 1.0 0.0\nv 3.0 1.0 1.0\nvt 0.25 0.1\nf 3/1 1/1 2/1\n");

    mesh.faces.indices[0] = 3;
    let error = write_obj(&path, &mesh).unwrap_err();
    assert!(matches!(error, Error::Input(_)), "{error}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text, "the old file stays");
    mesh.faces.indices[0] = 2;
    let error = write_obj(&folder.path().join("none/face.obj"), &mesh).unwrap_err();
    assert!(error.to_string().contains("does not exist"), "{error}");
}

#[test]
fn check_refuses_what_a_caller_could_make() {
    let good = decode(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n", Format::Obj, "m").unwrap();
    let refused = |change: &dyn Fn(&mut Mesh, &mut Uvs), expected: &str| {
        let mut mesh = good.clone();
        let mut uvs = mesh.uvs.take().unwrap();
        change(&mut mesh, &mut uvs);
        mesh.uvs = Some(uvs);
        let message = check(&mesh, "m").unwrap_err().to_string();
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    };
    refused(&|m, _| m.positions[1][2] = f64::NAN, "vertex 1 (counted from 0) is at [1.0, 0.0, NaN]");
    refused(&|m, _| m.positions[1][2] = 1e39, "expected finite coordinates below 3.4e38");
    refused(&|m, _| m.faces = Faces::default(), "has 3 vertices but no faces");
    refused(&|m, _| m.faces.counts = vec![1, 2], "face 1 has 1 corner,");
    refused(&|m, _| m.faces.counts = vec![4], "has 3 corners, expected the 4");
    refused(&|m, _| m.faces.push(&[0, 1, 3]), "face 2 refers to vertex 3, expected 0 to 2");
    refused(&|_, uvs| uvs.values[0][1] = f32::INFINITY, "texture coordinate 0 (counted from 0)");
    refused(&|_, uvs| uvs.corners = None, "has 1 texture coordinates for 3 vertices");
    refused(&|_, uvs| uvs.corners = Some(vec![0; 4]), "has 4 texture indices for 3 face corners");
    refused(&|_, uvs| uvs.corners = Some(vec![0, 0, 1]), "face 1 refers to texture coordinate 1");
}
