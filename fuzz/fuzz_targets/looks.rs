//! Any two files as a mesh and an image that it names. The looks that are read are sound materials, or there
//! is an error. The input is the format in a byte, the size of the mesh in 4 bytes, the mesh, and the image.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, Faces, Materials, Reach};
use rhytid_formats::mesh::read_looks;

const MESHES: [&str; 5] = ["face.mtl", "face.obj", "face.gltf", "face.glb", "face.usd"];

fuzz_target!(|bytes: &[u8]| {
    let Some((format, rest)) = bytes.split_first() else { return };
    let Some((size, rest)) = rest.split_first_chunk() else { return };
    let Some((mesh, image)) = rest.split_at_checked(u32::from_le_bytes(*size) as usize) else { return };
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-looks-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(MESHES[usize::from(*format) % MESHES.len()]);
    std::fs::write(folder.join("skin.png"), image).unwrap();
    std::fs::write(folder.join("skin.mtl"), mesh).unwrap();
    std::fs::write(&path, mesh).unwrap();
    match read_looks(&path, Reach::Below) {
        Ok(looks) => {
            // A face with each material.
            let count = looks.materials.len();
            let faces = Faces { counts: vec![3; count], indices: vec![0; 3 * count] };
            let names = looks.materials.iter().map(|material| material.name.clone());
            let mut materials = Materials::named(names, (0..count as u32).collect());
            looks.give_to(&mut materials);
            assert_eq!(materials.fault(&faces), None);
        }
        Err(error) => assert!(matches!(error, Error::Input(_)), "{error:?}"),
    }
    std::fs::remove_file(path).unwrap();
});
