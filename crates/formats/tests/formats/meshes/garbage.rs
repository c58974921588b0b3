//! Any bytes give an input error or a mesh that passes `check`. A reader never panics.

use proptest::prelude::*;
use rhytid_core::Error;
use rhytid_formats::mesh::{Format, check, decode};

const FORMATS: [Format; 4] = [Format::Obj, Format::Ply, Format::Gltf, Format::Usd];

const USD: &[u8] = b"#usda 1.0\n(\n metersPerUnit = 0.01\n)\ndef SkelRoot \"r\" {\n double3 xformOp:translate = (1, 2, 3)\n \
 uniform token[] xformOpOrder = [\"xformOp:translate\"]\n def Mesh \"a\" {\n point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]\n \
 int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1)] \
 (interpolation = \"vertex\")\n int[] holeIndices = []\n def BlendShape \"s\" { vector3f[] offsets = [(0, 1, 0)] int[] \
 pointIndices = [2] }\n def GeomSubset \"g\" { int[] indices = [0] rel material:binding = </m> }\n }\n}\n";

const OBJ: &[u8] = b"o a\nv 0 0 0\nv 1 0 0.25\nv 1 1e0 0\nv 0 1 -.5\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n\
                     f 1/1/1 2/2/1 3/3/1 4/-1/1\nf -4/1 -2/2 \\\n 4/3\n";

/// A whole file of every kind.
fn whole() -> Vec<(Format, &'static [u8])> {
    vec![
        (Format::Obj, OBJ),
        (Format::Ply, include_bytes!("data/plyfile-ascii.ply")),
        (Format::Ply, include_bytes!("data/plyfile-little-endian.ply")),
        (Format::Ply, include_bytes!("data/plyfile-big-endian.ply")),
        (Format::Ply, include_bytes!("data/trimesh.ply")),
        (Format::Gltf, include_bytes!("data/trimesh.glb")),
        (Format::Gltf, include_bytes!("data/skin/gltfpack-vpf.glb")),
        (Format::Gltf, include_bytes!("data/skin/draco-edgebreaker.glb")),
        (Format::Usd, USD),
    ]
}

/// Whether it was read.
fn survives(bytes: &[u8], format: Format) -> bool {
    match decode(bytes, format, "garbage") {
        Ok(mesh) => {
            check(&mesh, "garbage").unwrap();
            true
        }
        Err(Error::Input(message)) => {
            assert!(message.sentence().starts_with("garbage"), "{message}");
            false
        }
        Err(other) => panic!("{other:?}"),
    }
}

#[test]
fn every_truncation() {
    for (format, bytes) in whole() {
        assert!(survives(bytes, format));
        let read = (0..bytes.len()).filter(|&n| survives(&bytes[..n], format)).count();
        // Text may lose its last figures, or whole faces of an OBJ, unseen; a binary must be whole.
        match format {
            Format::Gltf => assert_eq!(read, 0),
            Format::Usd => assert!(read <= 1, "{read}"),
            Format::Ply => assert!(read <= 4, "{read}"),
            Format::Obj => assert!(read < bytes.len() / 2, "{read}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn arbitrary_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        for format in FORMATS {
            survives(&bytes, format);
        }
    }

    #[test]
    fn arbitrary_text(text in "(v|vt|f|l|#|\\\\|[-0-9./ e]{0,6}|nan|\n|\r| )*") {
        survives(text.as_bytes(), Format::Obj);
        let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                      property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
        survives(format!("{header}{text}").as_bytes(), Format::Ply);
    }

    #[test]
    fn flipped_bytes(
        which: prop::sample::Index,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let (format, bytes) = *which.get(&whole());
        let mut bytes = bytes.to_vec();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        survives(&bytes, format);
    }

    /// Any numbers of a header or document replaced by ones that are wrong in typical ways.
    #[test]
    fn wrong_numbers(
        which: prop::sample::Index,
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..12_usize), 1..4),
    ) {
        const WRONG: [&str; 12] = [
            "0", "1", "2", "3", "5126", "5121", "255", "65536", "4294967295", "18446744073709551615", "-1", "1e300",
        ];
        let (format, bytes) = *which.get(&whole());
        let (text, rest) = match format {
            Format::Obj | Format::Usd => (bytes, &[][..]),
            Format::Ply => bytes.split_at(bytes.windows(10).position(|w| w == b"end_header").unwrap()),
            Format::Gltf => {
                let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
                (&bytes[20..20 + json], &bytes[20 + json..])
            }
        };
        let mut text = String::from_utf8(text.to_vec()).unwrap();
        for (at, wrong) in changes {
            let starts: Vec<usize> = text
                .char_indices()
                .filter(|&(i, c)| c.is_ascii_digit() && !text[..i].ends_with(|c: char| c.is_ascii_digit()))
                .map(|(i, _)| i)
                .collect();
            let start = *at.get(&starts);
            let end = text[start..].find(|c: char| !c.is_ascii_digit()).map_or(text.len(), |n| start + n);
            text.replace_range(start..end, WRONG[wrong]);
        }
        let mut changed = text.into_bytes();
        if format == Format::Gltf {
            let mut glb = b"glTF\x02\0\0\0".to_vec();
            glb.extend(((20 + changed.len() + rest.len()) as u32).to_le_bytes());
            glb.extend((changed.len() as u32).to_le_bytes());
            glb.extend(b"JSON");
            glb.append(&mut changed);
            changed = glb;
        }
        changed.extend(rest);
        survives(&changed, format);
    }
}
