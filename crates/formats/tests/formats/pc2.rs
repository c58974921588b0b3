//! Point caches, byte by byte as PC2 is described. (Blender opens them in the program's tests.)

use crate::animation::{Animation, UvKind, with_everything};
use rhytid_core::{Error, NoProgress};
use rhytid_formats::animation;
use rhytid_formats::export::Options;

#[test]
fn a_point_cache_has_every_bit_of_the_positions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.PC2");
    let made =
        Animation { first_time_code: 101.0, ..with_everything(UvKind::PerCorner, 6, 3).for_file(&path) };
    let written = made.export(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!((written.bytes, written.errors), (bytes.len() as u64, Vec::new()));
    let (header, points) = bytes.split_at(32);
    assert_eq!(&header[..12], b"POINTCACHE2\0");
    let four = |at: usize| <[u8; 4]>::try_from(&header[at..at + 4]).unwrap();
    let [version, vertices, samples] = [12, 16, 28].map(|at| i32::from_le_bytes(four(at)));
    assert_eq!((version, vertices as usize, samples), (1, made.rest.len(), 6));
    assert_eq!([20, 24].map(|at| f32::from_le_bytes(four(at))), [101.0, 1.0]);
    let expected = made.frames.iter().flat_map(|[positions, _]| positions).flat_map(|x| x.to_le_bytes());
    assert!(points.iter().copied().eq(expected));
}

#[test]
fn what_a_point_cache_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.pc2");
    let made = with_everything(UvKind::None, 2, 3).for_file(&path);
    let mut exporter = animation::create(&path, &made.scene(), &Options::default()).unwrap();
    exporter.frame(&made.frame(0)).unwrap();
    assert!(exporter.finish(&NoProgress).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
    let message = |error: Error| match error {
        Error::Input(message) => message,
        other => panic!("{other}"),
    };
    made.export(&path).unwrap();
    let refused = message(animation::open(&path).err().unwrap());
    assert!(refused.sentence().contains("face.pc2: is a point cache, which holds points alone"), "{refused}");
    let refused = message(animation::check_shapes(&path, 1, &Options::default()).unwrap_err());
    assert!(refused.sentence().contains("a point cache has no sliders"), "{refused}");
}
