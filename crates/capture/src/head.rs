//! Head stabilisation: the head's rigid motion, fitted to the rigid markers, or robustly to all.
use crate::low_pass::low_pass;
use crate::tracks::{Tracks, median_point, seen};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use rhytid_geometry::registration::Similarity;
use rhytid_geometry::registration::fit_robustly;

/// How a head moved. *Local space* moves with the head. It is the file's space for a head in the middle of
/// its motion.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    /// From local space to the file's, one per frame; rigid, but with a scale where the take is from a video.
    pub motions: Vec<Similarity>,
    /// RMS distance of the markers from where the motion puts them, in the file's unit; 0 in frames without a
    /// fit.
    pub residuals: Vec<f64>,
    /// Frames in which too few of the rigid markers were seen.
    pub unseen: Vec<usize>,
}

/// Frames to sample where not all are needed.
const SAMPLED: usize = 400;

/// Frames in which sets of markers are compared.
const COMPARED: usize = 200;

/// A rigid marker may be off by this part of the face's extent before it loses its weight.
pub(crate) const RIGID_TOLERANCE: f64 = 0.005;

/// The same where all of the face's markers stand in for rigid ones.
pub(crate) const FACE_TOLERANCE: f64 = 0.02;

/// The head's motion from the columns `rigid`. The columns `stiff` of the columns `face` are used if `rigid`
/// is empty, and in frames in which fewer than three rigid markers are seen. Where too few of these are seen,
/// all of `face` are used. `extent` is the face's. With `with_scale`, each frame has a scale of its own, as
/// in a video. `None` where no frame has enough markers.
pub(crate) fn stabilise(
    tracks: &Tracks,
    rigid: &[usize],
    stiff: &[usize],
    face: &[usize],
    extent: f64,
    with_scale: bool,
) -> Option<Head> {
    let from_face = || from_face(tracks, stiff, face, extent, with_scale);
    let first = if rigid.is_empty() {
        from_face()?
    } else {
        fitted(tracks, rigid, RIGID_TOLERANCE * extent, with_scale)?
    };
    let unseen: Vec<usize> = (0..first.len()).filter(|&f| first[f].is_none()).collect();
    let second = if unseen.is_empty() || rigid.is_empty() { None } else { from_face() };
    let residuals = first.iter().map(|fit| fit.map_or(0.0, |(_, rms)| rms)).collect();
    let second = second.map(|fits| motions(&fits));
    Some(Head { motions: complete(&motions(&first), second.as_deref()), residuals, unseen })
}

/// The motion of the stiff columns. Where too few of these are seen, that of the whole face.
fn from_face(
    tracks: &Tracks,
    stiff: &[usize],
    face: &[usize],
    extent: f64,
    with_scale: bool,
) -> Option<Vec<Fit>> {
    let all = || fitted(tracks, face, FACE_TOLERANCE * extent, with_scale);
    if stiff.len() == face.len() {
        return all();
    }
    let Some(mut fits) = fitted(tracks, stiff, RIGID_TOLERANCE * extent, with_scale) else { return all() };
    if fits.iter().any(Option::is_none)
        && let Some(all) = all()
    {
        let whole = complete(&motions(&fits), Some(&motions(&all)));
        for ((fit, motion), all) in fits.iter_mut().zip(whole).zip(&all) {
            if let (None, Some((_, rms))) = (&fit, all) {
                *fit = Some((motion, *rms));
            }
        }
    }
    Some(fits)
}

fn motions(fits: &[Fit]) -> Vec<Option<Similarity>> {
    fits.iter().map(|fit| Some((*fit)?.0)).collect()
}

/// A motion, and the RMS residual of its fit; `None` where too few markers are seen.
pub(crate) type Fit = Option<(Similarity, f64)>;

/// The motion of the columns in each frame, with its RMS residual.
pub(crate) fn fitted(
    tracks: &Tracks,
    columns: &[usize],
    tolerance: f64,
    with_scale: bool,
) -> Option<Vec<Fit>> {
    let frame = |f: usize| -> Vec<DVec3> { columns.iter().map(|&c| tracks.columns[c][f]).collect() };
    let frames = sampled(tracks.frames());
    let seen_in = |f: usize| columns.iter().filter(|&&c| seen(tracks.columns[c][f])).count();
    let fullest = frames
        .iter()
        .copied()
        .max_by_key(|&f| (seen_in(f), std::cmp::Reverse(f.abs_diff(tracks.frames() / 2))))?;
    let mut reference = frame(fullest);
    for _ in 0..4 {
        let unmoved: Vec<Vec<DVec3>> = frames
            .par_iter()
            .filter_map(|&f| {
                let frame = frame(f);
                let back = fit_robustly(&reference, &frame, with_scale, tolerance)?.0.inverse();
                Some(frame.into_iter().map(|p| back.apply(p)).collect())
            })
            .collect();
        if unmoved.is_empty() {
            return None;
        }
        reference = (0..columns.len())
            .map(|c| median_point(unmoved.iter().map(|frame| frame[c]).filter(|p| seen(*p))))
            .collect();
    }
    let fits = (0..tracks.frames()).into_par_iter();
    Some(fits.map(|f| fit_robustly(&reference, &frame(f), with_scale, tolerance)).collect())
}

/// So many frames of all columns that sets of markers can be compared.
pub(crate) fn thinned(tracks: &Tracks) -> Tracks {
    let frames = spread(tracks.frames(), COMPARED);
    let of_column = |column: &Vec<DVec3>| frames.iter().map(|&f| column[f]).collect();
    Tracks { columns: tracks.columns.iter().map(of_column).collect(), rate: tracks.rate }
}

fn sampled(frames: usize) -> Vec<usize> {
    spread(frames, SAMPLED)
}

/// At most `most` of the frames, evenly spread.
fn spread(frames: usize, most: usize) -> Vec<usize> {
    let count = frames.min(most);
    (0..count).map(|i| i * frames / count.max(1)).collect()
}

/// Motions without gaps. A gap takes the motions of `other`, moved so that they meet the neighbours at both
/// ends. Without `other`, a gap is interpolated between its neighbours. Before the first known motion and
/// after the last one, their value is held.
fn complete(motions: &[Option<Similarity>], other: Option<&[Option<Similarity>]>) -> Vec<Similarity> {
    let known: Vec<usize> = (0..motions.len()).filter(|&f| motions[f].is_some()).collect();
    let at = |f: usize| motions[f].unwrap_or(Similarity::IDENTITY);
    let stand_in = |f: usize| other.and_then(|other| other[f]);
    (0..motions.len())
        .map(|f| {
            if let Some(motion) = motions[f] {
                return motion;
            }
            let i = known.partition_point(|&k| k < f);
            let (a, b) = (i.checked_sub(1).map(|i| known[i]), known.get(i).copied());
            let (Some(a), Some(b)) = (a.or(b), b.or(a)) else { return Similarity::IDENTITY };
            let s = if a == b { 0.0 } else { (f - a) as f64 / (b - a) as f64 };
            match (stand_in(f), stand_in(a), stand_in(b)) {
                (Some(here), Some(at_a), Some(at_b)) => {
                    // The correction to the stand-in, in the head's own space, is known at both ends. Between
                    // the ends it is interpolated.
                    let lacks = |f: usize, stand_in: Similarity| stand_in.inverse().after(&at(f));
                    here.after(&between(&lacks(a, at_a), &lacks(b, at_b), s))
                }
                _ => between(&at(a), &at(b), s),
            }
        })
        .collect()
}

fn between(a: &Similarity, b: &Similarity, s: f64) -> Similarity {
    Similarity {
        scale: a.scale + s * (b.scale - a.scale),
        rotation: a.rotation.slerp(b.rotation, s).normalize(),
        translation: a.translation.lerp(b.translation, s),
    }
}

/// The middle of the columns' positions, in local space.
pub(crate) fn centre(tracks: &Tracks, columns: &[usize], motions: &[Similarity]) -> DVec3 {
    let frames = sampled(tracks.frames());
    let points = frames.iter().flat_map(|&f| {
        let back = motions[f].inverse();
        columns.iter().map(move |&c| back.apply(tracks.columns[c][f]))
    });
    let centre = median_point(points.filter(|p| seen(*p)));
    if seen(centre) { centre } else { DVec3::ZERO }
}

/// Removes from the motions what is faster than `cutoff` Hz. `centre` is a point in local space near the
/// head. Its path is smoothed instead of the translation, since a small rotation moves a far point a long
/// way.
pub(crate) fn smooth(motions: &mut [Similarity], centre: DVec3, cutoff: f64, rate: f64) {
    let mut columns: [Vec<f64>; 8] = Default::default();
    let mut before = DQuat::IDENTITY;
    for motion in motions.iter() {
        // A quaternion and its negative are the same turn.
        let rotation = if before.dot(motion.rotation) < 0.0 { -motion.rotation } else { motion.rotation };
        before = rotation;
        let numbers = rotation.to_array().into_iter().chain(motion.apply(centre).to_array());
        let numbers = numbers.chain([motion.scale]);
        columns.iter_mut().zip(numbers).for_each(|(column, x)| column.push(x));
    }
    columns.par_iter_mut().for_each(|column| low_pass(column, cutoff, rate));
    for (f, motion) in motions.iter_mut().enumerate() {
        let [x, y, z, w, cx, cy, cz, scale] = std::array::from_fn(|i| columns[i][f]);
        motion.rotation = DQuat::from_xyzw(x, y, z, w).normalize();
        motion.scale = scale;
        motion.translation = DVec3::new(cx, cy, cz) - motion.rotation * (scale * centre);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAP: [DVec3; 4] = [
        DVec3::new(0.0, 145.0, 50.0),
        DVec3::new(75.0, 105.0, -10.0),
        DVec3::new(-75.0, 105.0, -10.0),
        DVec3::new(0.0, 165.0, -40.0),
    ];

    const FACE: [usize; 6] = [4, 5, 6, 7, 8, 9];

    fn motion(f: usize) -> Similarity {
        let t = f as f64 / 100.0;
        Similarity {
            scale: 1.0,
            rotation: DQuat::from_euler(glam::EulerRot::XYZ, 0.3 * t.sin(), 0.2 * (2.0 * t).cos(), 0.1 * t),
            translation: DVec3::new(20.0 * t.sin(), 1500.0, 30.0 * t),
        }
    }

    /// A cap of four markers and a face of six markers, one of which moves.
    fn tracks(frames: usize) -> Tracks {
        let face = |i: usize, f: usize| {
            let a = i as f64;
            let still = DVec3::new(60.0 * (a * 1.1).cos(), 60.0 * (a * 1.1).sin(), 40.0 + 5.0 * a);
            if i == 0 { still + DVec3::Y * (10.0 * (f as f64 * 0.2).sin()) } else { still }
        };
        let columns = (0..10)
            .map(|c| {
                (0..frames).map(|f| motion(f).apply(if c < 4 { CAP[c] } else { face(c - 4, f) })).collect()
            })
            .collect();
        Tracks { columns, rate: 100.0 }
    }

    /// The largest error of the path of a point in the cap, relative to the first frame.
    fn error(head: &Head) -> f64 {
        let relative =
            |motions: &dyn Fn(usize) -> Similarity, f: usize| motions(f).after(&motions(0).inverse());
        (0..head.motions.len())
            .map(|f| {
                let found = relative(&|f| head.motions[f], f);
                let point = motion(0).apply(CAP[0]);
                found.apply(point).distance(relative(&motion, f).apply(point))
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_motion_is_found_despite_ghosts_and_gaps() {
        let mut tracks = tracks(600);
        tracks.columns[1][50] += DVec3::splat(40.0);
        (100..200).for_each(|f| tracks.columns[0][f] = DVec3::NAN);
        let head = stabilise(&tracks, &[0, 1, 2, 3], &FACE, &FACE, 150.0, false).unwrap();
        assert!(error(&head) < 1e-6 && head.unseen.is_empty(), "{}", error(&head));
        assert!(head.residuals.iter().all(|r| *r < 1e-6));
    }

    #[test]
    fn the_face_stands_in_where_the_cap_is_lost() {
        let mut tracks = tracks(600);
        (0..3).for_each(|c| tracks.columns[c][250..400].fill(DVec3::NAN));
        let head = stabilise(&tracks, &[0, 1, 2, 3], &FACE, &FACE, 150.0, false).unwrap();
        assert_eq!(head.unseen, (250..400).collect::<Vec<_>>());
        // Five of the face's six markers keep still. A line between the ends would be off by more than 10.
        assert!(error(&head) < 2.5, "{}", error(&head));
        let moved = motion(325)
            .apply(CAP[0])
            .distance(motion(250).apply(CAP[0]).lerp(motion(400).apply(CAP[0]), 0.5));
        assert!(moved > 10.0, "{moved}");
    }

    #[test]
    fn a_lost_head_is_held_between_its_neighbours() {
        let mut tracks = tracks(100);
        tracks.columns.iter_mut().for_each(|column| column[40..60].fill(DVec3::NAN));
        tracks.columns.iter_mut().for_each(|column| column[90..].fill(DVec3::NAN));
        let head = stabilise(&tracks, &[0, 1, 2, 3], &FACE, &FACE, 150.0, false).unwrap();
        let (a, b) = (head.motions[39].translation, head.motions[60].translation);
        assert!(head.motions[50].translation.distance(a.lerp(b, 11.0 / 21.0)) < 1e-9);
        assert_eq!(head.motions[99], head.motions[89]);
    }

    #[test]
    fn smoothing_takes_noise_and_leaves_motion() {
        let exact = stabilise(&tracks(600), &[0, 1, 2, 3], &FACE, &FACE, 150.0, false).unwrap();
        let mut noisy = tracks(600);
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        for p in noisy.columns.iter_mut().flatten() {
            *p += DVec3::new(noise(), noise(), noise()) * 0.3;
        }
        let mut head = stabilise(&noisy, &[0, 1, 2, 3], &FACE, &FACE, 150.0, false).unwrap();
        let rough = error(&head);
        smooth(&mut head.motions, DVec3::ZERO, 8.0, 100.0);
        assert!(error(&head) < 0.7 * rough, "{} {rough}", error(&head));
        let mut smoothed = exact.clone();
        smooth(&mut smoothed.motions, DVec3::ZERO, 8.0, 100.0);
        assert!(error(&smoothed) < 0.05, "{}", error(&smoothed));
    }
}
