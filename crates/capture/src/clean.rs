//! All steps in their order.
use crate::events::{confidence, event, filled_before, runs};
use crate::fit::{Similarity, fit_robustly};
use crate::labels::match_labels;
use crate::low_pass::low_pass;
use crate::placing::{mean, noise, offsets, rigid_markers, typical_extent, unit};
use crate::settings::{Settings, Step};
use crate::tracks::{Tracks, extent, seen};
use crate::{Axes, Event, Found, Kind, Report, gaps, head, neutral, outliers, swaps};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, RawTake, Result, Rig, RigidMotion, Take};

/// The handles of the rig that a take is cleaned for.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// H labels.
    pub labels: Vec<String>,
    /// H positions on the rest pose.
    pub rest: Vec<DVec3>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
}

impl Target {
    /// The handles of a rig.
    pub fn of(rig: &Rig) -> Self {
        let rest =
            rig.handles.iter().map(|&v| DVec3::from_array(rig.rest[v as usize].map(f64::from))).collect();
        Self { labels: rig.labels.clone(), rest, metres_per_unit: rig.metres_per_unit }
    }
}

/// A clean take, and what was done.
#[derive(Debug, Clone, PartialEq)]
pub struct Cleaned {
    /// A position of every handle in every frame, in head space and mesh units.
    pub take: Take,
    /// What was found and done, in frames of the raw take.
    pub report: Report,
}

/// A spline's samples.
const SPLINE_CONFIDENCE: f32 = 0.8;
/// The low-rank model's samples.
const MODEL_CONFIDENCE: f32 = 0.5;
/// A marker may be off by this part of the face's extent before the alignment counts it less: markers are glued on by hand.
const ALIGN_TOLERANCE: f64 = 0.03;
/// Above this RMS noise, in millimetres, markers are filtered unless told otherwise.
const NOISY: f64 = 0.05;
/// At this cut-off, in Hz.
const LOW_PASS: f64 = 20.0;

/// Cleans a take for a rig's handles.
///
/// # Errors
/// [`Error::Input`] if fewer than four handles have a marker, a setting names what is not there, or no frames are like the neutral face;
/// [`Error::Cancelled`].
pub fn clean(raw: RawTake, target: &Target, settings: &Settings, progress: &dyn Progress) -> Result<Cleaned> {
    const STEPS: u64 = 6;
    let step = |done: u64| {
        progress.report("clean", done, STEPS);
        if progress.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    };
    step(0)?;
    let RawTake { tracks: mut raw_tracks, metres_per_unit: stated, in_head_space, mut warnings } = raw;
    let (rate, frames) = (raw_tracks.rate(), raw_tracks.frames());
    let matched = match_labels(&target.labels, &raw_tracks.labels, &settings.markers)?;
    if frames == 0 {
        return Err(Error::input("the take has no frames"));
    }
    let mut events = filled_before(&raw_tracks, &matched.columns);
    let m = raw_tracks.labels.len();
    let column =
        |c: usize| raw_tracks.positions.iter().skip(c).step_by(m).copied().map(DVec3::from_array).collect();
    let mut file = Tracks { columns: (0..m).map(column).collect(), rate };
    raw_tracks.positions = Vec::new();
    step(1)?;

    let face: Vec<usize> = matched.columns.iter().copied().flatten().collect();
    let face_extent = typical_extent(&file, &face);
    if face_extent == 0.0 {
        return Err(Error::input("no handle's marker was ever seen: the take has no positions to go by"));
    }
    // 1. The head.
    let to_be_aligned = !in_head_space && !settings.skip.contains(&Step::Align);
    let rigid = rigid_markers(&file, &matched.others, &raw_tracks.labels, settings, face_extent)?;
    let mut head = None;
    if !in_head_space && !settings.skip.contains(&Step::Head) {
        head = head::stabilise(&file, &rigid, &face, face_extent);
        if head.is_none() {
            return Err(Error::input(
                "no frame shows three markers from which the head's motion could be told",
            ));
        }
    }
    if let Some(head) = &mut head {
        if !settings.skip.contains(&Step::HeadLowPass) {
            let centre = head::centre(&file, &face, &head.motions);
            head::smooth(&mut head.motions, centre, settings.head_low_pass, rate);
        }
        let back: Vec<Similarity> = head.motions.iter().map(Similarity::inverse).collect();
        file.columns.par_iter_mut().for_each(|column| {
            column.iter_mut().zip(&back).for_each(|(p, back)| *p = back.apply(*p));
        });
    }
    step(2)?;

    // 2. The neutral frames and the actor's place on the rig.
    let neutral = match &settings.neutral {
        Some(range) if range.start < range.end && range.end <= frames => range.clone(),
        Some(range) => {
            return Err(Error::input(format!(
                "the neutral frames are {}..{}, expected a range within 0..{frames}",
                range.start, range.end
            )));
        }
        None => neutral::find(&file, &matched.columns, &target.rest)
            .ok_or_else(|| Error::input("no half second shows enough markers to find the neutral face in; say which frames are neutral"))?,
    };
    let pose = neutral::pose(&file, &matched.columns, &neutral);
    let rest_extent = extent(target.rest.iter().copied());
    let motion_at_neutral =
        head.as_ref().map_or(Similarity::IDENTITY, |head| head.motions[(neutral.start + neutral.end) / 2]);
    let placed =
        fit_robustly(&pose, &target.rest, true, ALIGN_TOLERANCE * rest_extent).map(|(fitted, _)| fitted);
    let fitted = match (to_be_aligned, placed) {
        (true, None) => {
            return Err(Error::input(
                "the neutral frames show fewer than three markers, or markers on one line; say which frames are neutral",
            ));
        }
        (true, Some(fitted)) => fitted,
        (false, _) => Similarity::IDENTITY,
    };
    let mesh = target.metres_per_unit;
    let unit = match () {
        () if to_be_aligned => unit(stated, settings, mesh, &fitted, &mut warnings),
        () if in_head_space => (mesh, false),
        () => (settings.metres_per_unit.or(stated).unwrap_or(mesh), false),
    };
    let axes = match settings.axes {
        _ if !to_be_aligned => settings.axes.unwrap_or(Axes::SAME),
        Some(axes) => axes,
        None => Axes::nearest(fitted.rotation * motion_at_neutral.rotation.conjugate()),
    };
    // Without an alignment there are still the unit and the axes.
    let to_world = Similarity { scale: unit.0 / mesh, rotation: axes.rotation(), translation: DVec3::ZERO };
    let fitted = if to_be_aligned || in_head_space { fitted } else { to_world };
    let scale = to_world.scale / fitted.scale;

    // 3. On the rig: the handles' markers alone.
    let unseen = || vec![DVec3::NAN; frames];
    let columns =
        matched.columns.iter().map(|c| c.map_or_else(unseen, |c| std::mem::take(&mut file.columns[c])));
    let mut tracks = Tracks { columns: columns.collect(), rate };
    if fitted != Similarity::IDENTITY {
        tracks.columns.par_iter_mut().flatten().for_each(|p| *p = fitted.apply(*p));
    }
    let on_rig: Vec<DVec3> = pose
        .iter()
        .zip(&target.rest)
        .map(|(p, r)| if seen(*p) && !in_head_space { fitted.apply(*p) } else { *r })
        .collect();
    step(3)?;
    let millimetres = 1e3 * target.metres_per_unit;
    if !settings.skip.contains(&Step::Swaps) {
        let found = swaps::undo(&mut tracks, (neutral.start + neutral.end) / 2, &on_rig, rest_extent);
        events.extend(found.iter().map(|swap| Event {
            other: Some(swap.pair[1]),
            ..event(Kind::Swap, swap.pair[0], swap.first..swap.end, 1.0)
        }));
    }
    if !settings.skip.contains(&Step::Outliers) {
        let found = outliers::drop(&mut tracks, &on_rig, rest_extent);
        events.extend(found.iter().map(|outlier| Event {
            distance_mm: Some(outlier.distance * millimetres),
            ..event(
                Kind::Outlier,
                outlier.marker,
                outlier.first..outlier.first + outlier.frames,
                SPLINE_CONFIDENCE,
            )
        }));
    }
    step(4)?;

    // 4. Displacements from neutral, which go onto the rest pose.
    let columns: Vec<Option<usize>> = (0..tracks.columns.len()).map(Some).collect();
    let pose = neutral::pose(&tracks, &columns, &neutral);
    let offsets_mm = offsets(&pose, &target.rest, millimetres, &target.labels, &mut warnings);
    let neutral_pose: Vec<DVec3> = if to_be_aligned {
        // Of what is left of the neutral frames, the mean: less noisy than the median.
        let means = tracks.columns.iter().map(|column| mean(column, &neutral));
        means.zip(&on_rig).map(|(mean, at)| mean.unwrap_or(*at)).collect()
    } else {
        target.rest.clone()
    };
    tracks
        .columns
        .par_iter_mut()
        .zip(&neutral_pose)
        .for_each(|(column, at)| column.iter_mut().for_each(|p| *p -= *at));
    let noise = noise(&tracks);
    let filled = gaps::fill(&mut tracks, &target.rest, settings.max_gap, noise);
    events.extend(filled.iter().map(|gap| {
        let confidence = match gap.kind {
            Kind::Spline => SPLINE_CONFIDENCE,
            Kind::Model => MODEL_CONFIDENCE,
            _ => 0.0,
        };
        event(gap.kind, gap.marker, gap.frames.clone(), confidence)
    }));
    step(5)?;
    let noise_mm = noise * 3.0_f64.sqrt() * millimetres;
    let cutoff = settings.low_pass.or((noise_mm > NOISY).then_some(LOW_PASS));
    let cutoff = cutoff.filter(|hz| !settings.skip.contains(&Step::LowPass) && *hz < 0.4 * rate);
    if let Some(hz) = cutoff {
        tracks.columns.par_iter_mut().for_each(|column| {
            for axis in 0..3 {
                let mut values: Vec<f64> = column.iter().map(|p| p[axis]).collect();
                low_pass(&mut values, hz, rate);
                column.iter_mut().zip(values).for_each(|(p, x)| p[axis] = x);
            }
        });
    }

    // 5. What comes out.
    if let Some(head) = &head {
        events.extend(
            runs(&head.unseen)
                .into_iter()
                .map(|run| Event { marker: None, ..event(Kind::Head, 0, run, 0.5) }),
        );
    }
    events.sort_by_key(|e| (e.kind, e.first, e.marker, e.other));
    let h = target.labels.len();
    let mut positions = vec![[0.0; 3]; frames * h];
    positions.par_chunks_mut(h).enumerate().for_each(|(f, frame)| {
        for (j, p) in frame.iter_mut().enumerate() {
            *p = (target.rest[j] + tracks.columns[j][f]).to_array();
        }
    });
    let motions = match head.as_ref() {
        Some(head) => {
            let from_rig = fitted.inverse();
            let motions =
                head.motions.iter().map(|motion| rigid_motion(&to_world.after(motion).after(&from_rig)));
            Some(motions.collect())
        }
        None => raw_tracks.head.take(),
    };
    let take = Take {
        labels: target.labels.clone(),
        times: std::mem::take(&mut raw_tracks.times),
        positions,
        head: motions,
        confidence: confidence(&events, frames, h),
    };
    let file_labels =
        |columns: &[usize]| columns.iter().map(|&c| raw_tracks.labels[c].clone()).collect::<Vec<_>>();
    let unused: Vec<usize> = matched.others.iter().copied().filter(|c| !rigid.contains(c)).collect();
    let report = Report {
        labels: target.labels.clone(),
        frames,
        rate,
        start: take.times[0],
        setup: Found {
            markers: matched.columns.iter().map(|c| c.map(|c| raw_tracks.labels[c].clone())).collect(),
            rigid: file_labels(&rigid),
            unused: file_labels(&unused),
            metres_per_unit: unit.0,
            unit_is_guessed: unit.1,
            axes: axes.to_string(),
            axes_are_guessed: settings.axes.is_none() && to_be_aligned,
            neutral,
            neutral_is_found: settings.neutral.is_none(),
            scale,
            in_head_space,
            offsets_mm,
        },
        events,
        head_residuals_mm: head.map_or_else(
            || vec![0.0; frames],
            |head| head.residuals.iter().map(|r| (r * unit.0 * 1e3) as f32).collect(),
        ),
        noise_mm,
        low_pass_hz: cutoff,
        warnings,
    };
    let take = match settings.fps {
        Some(fps) => take.resample(fps)?,
        None => take,
    };
    step(STEPS)?;
    Ok(Cleaned { take, report })
}

/// The actor's size is none of the head's motion: the rig keeps its own.
fn rigid_motion(motion: &Similarity) -> RigidMotion {
    RigidMotion { rotation: motion.rotation.to_array(), translation: motion.translation.to_array() }
}
