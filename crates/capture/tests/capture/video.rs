//! A real motion as a video shows it: the scale drifts, the head turns, and the depth is noisy.
use crate::real_take::{target, truth};
use glam::{DQuat, DVec3, EulerRot};
use rhytid_capture::{Settings, clean};
use rhytid_core::{NoProgress, RawTake, Take};
use std::io::Write;

/// Noise in the image, in millimetres. The depth has three times as much.
const NOISE: f64 = 0.3;

/// Every fourth frame of the truth, as a camera in front of the head sees it.
fn video(truth: &[DVec3], labels: &[String]) -> RawTake {
    let mut state = 1_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    // The sum of twelve uniform numbers is nearly normal.
    let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let mut tracks = Take { labels: labels.to_vec(), ..Take::default() };
    for (f, frame) in truth.chunks(labels.len()).step_by(4).enumerate() {
        let time = f as f64 / 30.0;
        let turn =
            DQuat::from_euler(EulerRot::YXZ, 0.25 * (1.1 * time).sin(), 0.15 * (0.7 * time).sin(), 0.0);
        let pixels = 30.0 * (1.0 + 0.15 * (0.9 * time).sin());
        tracks.times.push(time);
        for p in frame {
            let noise = 0.1 * NOISE * DVec3::new(normal(), normal(), 3.0 * normal());
            tracks.positions.push((pixels * (turn * *p + noise) + DVec3::new(960.0, -540.0, 0.0)).to_array());
        }
    }
    RawTake { tracks, is_video: true, ..RawTake::default() }
}

/// The RMS errors of the displacements from the first half second along x, y and z, in millimetres.
fn errors(take: &Take, truth: &[DVec3]) -> DVec3 {
    let m = take.labels.len();
    let truth: Vec<&[DVec3]> = truth.chunks(m).step_by(4).collect();
    let found = |f: usize, j: usize| DVec3::from_array(take.positions[f * m + j]);
    let mut squares = DVec3::ZERO;
    for j in 0..m {
        let rest = (0..15).map(|f| found(f, j) - truth[f][j]).sum::<DVec3>() / 15.0;
        for (f, frame) in truth.iter().enumerate() {
            let off = found(f, j) - frame[j] - rest;
            squares += off * off;
        }
    }
    let mean = squares / (m * truth.len()) as f64;
    10.0 * DVec3::new(mean.x.sqrt(), mean.y.sqrt(), mean.z.sqrt())
}

#[test]
fn a_video_is_cleaned_with_a_scale_in_each_frame_and_a_steady_depth() {
    let Some(target) = target() else { return };
    let truth = truth();
    let raw = video(&truth, &target.labels);
    let cleaned = |raw: RawTake| clean(raw, &target, &Settings::default(), &NoProgress).unwrap();
    let as_video = cleaned(raw.clone());
    let as_markers = cleaned(RawTake { is_video: false, ..raw });
    let [video, markers] = [&as_video, &as_markers].map(|cleaned| errors(&cleaned.take, &truth));
    let _ = writeln!(std::io::stderr(), "as a video {video} mm, as markers {markers} mm");
    assert!(video.x < 0.8 && video.y < 1.0 && video.z < 1.2, "{video}");
    assert!(3.0 * video.length() < markers.length(), "{video} {markers}");
    assert!((as_video.report.setup.scale - 1.0).abs() < 1e-6, "{}", as_video.report.setup.scale);
    assert!(as_video.report.warnings.iter().all(|warning| !warning.sentence().contains("unit")));
}
