//! Our own files, read back bit for bit.
use crate::animation::{Animation, UvKind, animation, with_everything};
use rhytid_formats::animation;
use std::path::Path;

fn check(animation: &Animation, path: &Path) {
    animation.export(path).unwrap();
    let mut reader = animation::open(path).unwrap();
    let summary = reader.summary().clone();
    assert_eq!(summary.vertices, animation.rest.len());
    assert_eq!(summary.faces, animation.faces);
    assert_eq!(summary.frames, animation.frames.len());
    assert_eq!(summary.first_time_code, animation.first_time_code);
    assert_eq!(summary.rate, animation.rate);
    assert_eq!(summary.metres_per_unit, animation.metres_per_unit);
    assert_eq!(summary.up_axis, animation.up_axis);
    assert_eq!(summary.provenance.as_ref(), Some(&animation.provenance));
    assert_eq!(summary.normals, animation.with_normals);
    assert_eq!(summary.velocities, animation.velocities.is_some());
    assert_eq!(summary.strain, animation.strain.is_some());
    assert_eq!(summary.head, animation.head.is_some());
    assert!(summary.extents);
    let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let mut out = Vec::new();
    // Backwards, so that no order is relied on.
    for i in (0..animation.frames.len()).rev() {
        let frame = animation.frame(i);
        reader.positions(i, &mut out).unwrap();
        assert_eq!(bits(&out), bits(frame.positions), "{}: positions of frame {i}", path.display());
        reader.normals(i, &mut out).unwrap();
        assert_eq!(bits(&out), bits(frame.normals.unwrap_or_default()), "{}: normals", path.display());
        reader.velocities(i, &mut out).unwrap();
        assert_eq!(bits(&out), bits(frame.velocities.unwrap_or_default()), "{}: velocities", path.display());
        reader.strain(i, &mut out).unwrap();
        let strains = frame.strain.map(|strain| strain.strains.as_flattened()).unwrap_or_default();
        assert_eq!(bits(&out), bits(strains), "{}: strains", path.display());
        let [low, high] = reader.extent(i).unwrap().unwrap();
        let along = |c: usize| frame.positions.iter().skip(c).step_by(3).copied();
        assert_eq!(low, [0, 1, 2].map(|c| along(c).fold(f32::MAX, f32::min)));
        assert_eq!(high, [0, 1, 2].map(|c| along(c).fold(f32::MIN, f32::max)));
        let head = animation.head.as_ref().map(|head| head[i].matrix());
        assert_eq!(reader.head(i).unwrap(), head, "{}: head of frame {i}", path.display());
    }
}

#[test]
fn what_is_exported_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["usd", "usdc", "usda", "usdz"] {
        let path = folder.path().join(format!("face.{extension}"));
        for uvs in [UvKind::None, UvKind::PerVertex, UvKind::PerCorner] {
            check(&animation(uvs, 3, 1), &path);
        }
        let mut all = with_everything(UvKind::PerCorner, 6, 2);
        all.first_time_code = -3.0;
        all.frames[2][0][..4].copy_from_slice(&[-0.0, f32::MAX, 1e-45, crate::animation::ROUNDED_TWICE]);
        check(&all, &path);
        check(&Animation { with_normals: false, ..with_everything(UvKind::None, 1, 3) }, &path);
    }
}
