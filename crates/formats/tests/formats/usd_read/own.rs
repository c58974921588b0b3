//! Our own files, read back bit for bit.
use crate::animation::{Animation, Other, UvKind, animation, with_everything};
use rhytid_core::channel::{self, Channel};
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
    assert_eq!(summary.recipe.as_ref(), Some(&animation.recipe));
    let channels: Vec<Channel> =
        [channel::POSITIONS.clone()].into_iter().chain(animation.channels()).collect();
    let found =
        |channels: &[Channel]| channels.iter().map(|c| (c.name.clone(), c.width, c.kind)).collect::<Vec<_>>();
    assert_eq!(found(&summary.channels), found(&channels));
    assert_eq!(summary.head, animation.head.is_some());
    assert!(summary.extents);
    let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let mut out = Vec::new();
    // Backwards, so that no order is relied on.
    for i in (0..animation.frames.len()).rev() {
        let frame = animation.frame(i);
        for channel in &summary.channels {
            reader.channel(channel, i, &mut out).unwrap();
            let expected = frame.get(channel).unwrap();
            assert_eq!(bits(&out), bits(expected), "{}: {} of frame {i}", path.display(), channel.name);
        }
        reader.channel(&Channel::of_file("elsewhere", 1), i, &mut out).unwrap();
        assert!(out.is_empty());
        let [low, high] = reader.extent(i).unwrap().unwrap();
        let along = |c: usize| frame.positions().iter().skip(c).step_by(3).copied();
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

/// Rhytid never writes these, and other programs may: numbers of faces, and numbers that are the same in all
/// frames.
#[test]
fn channels_of_any_kind_are_read_back() {
    use rhytid_core::channel::{Interpolation, Timing};
    let folder = tempfile::tempdir().unwrap();
    for extension in ["usd", "usda"] {
        let path = folder.path().join(format!("face.{extension}"));
        let mut made = animation(UvKind::None, 3, 8);
        let of_faces = Channel { interpolation: Interpolation::Uniform, ..Channel::of_file("group", 1) };
        let constant = Channel { timing: Timing::Constant, ..Channel::of_file("pores", 2) };
        let [faces, vertices] = [made.faces.len(), made.rest.len()];
        let numbers = |n: usize, k: usize| (0..n).map(|i| (i * 3 + k) as f32).collect::<Vec<f32>>();
        made.others
            .push(Other { frames: (0..3).map(|k| numbers(faces, k)).collect(), channel: of_faces.clone() });
        made.others.push(Other { frames: vec![numbers(2 * vertices, 7)], channel: constant.clone() });
        made.export(&path).unwrap();
        let mut reader = animation::open(&path).unwrap();
        let summary = reader.summary().clone();
        assert_eq!(summary.channels[2..], [of_faces.clone(), constant.clone()]);
        let mut out = Vec::new();
        for k in 0..3 {
            reader.channel(&of_faces, k, &mut out).unwrap();
            assert_eq!(out, numbers(faces, k));
            reader.channel(&constant, k, &mut out).unwrap();
            assert_eq!(out, numbers(2 * vertices, 7));
        }
    }
}
