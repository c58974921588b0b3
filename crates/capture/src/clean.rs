//! The clean-up: all steps in their order.
use crate::event_words::{not_to_be_trusted, unlike};
use crate::events::{confidence, event, filled_before, runs};
use crate::expected::Suspects;
use crate::gaps::Filled;
use crate::head::Head;
use crate::head_markers::{self, HeadMarkers};
use crate::labels::{Matched, match_labels};
use crate::placing::{Place, Stated, offsets};
use crate::settings::{Settings, Step};
use crate::swaps::Swap;
use crate::target::Target;
use crate::tracks::{Tracks, extent, mean, noise, typical_extent};
use crate::{
    Axes, Event, Found, Kind, Mark, Pose, Report, depth, doubts, edits, gaps, gross_strain, head, low_pass,
    neutral, outliers, plausible, poses, proportions, shuffles, slides, swaps, unmeasured,
};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, RawTake, Result, RigidMotion, Take, TakeEvent, Warning};
use rhytid_geometry::registration::Similarity;
use std::borrow::Cow;

/// A clean take, and a report of what was done.
#[derive(Debug, Clone, PartialEq)]
pub struct Cleaned {
    /// A position of every handle in every frame, in head space and mesh units.
    pub take: Take,
    /// What was found and done, in frames of the raw take.
    pub report: Report,
}

/// Confidence of positions that a spline filled.
const SPLINE_CONFIDENCE: f32 = 0.8;
/// Confidence of positions that the low-rank model filled.
pub(crate) const MODEL_CONFIDENCE: f32 = 0.5;
/// Confidence of positions that had another marker's label.
pub(crate) const SHUFFLED_CONFIDENCE: f32 = 0.8;
/// Above this RMS noise, in millimetres, markers are filtered unless told otherwise.
const NOISY: f64 = 0.05;
/// Default cut-off of the markers' filter, in Hz.
const LOW_PASS: f64 = 12.0;

/// Cleans a take for a rig's handles.
///
/// # Errors
/// [`Error::Input`] if fewer than four handles have a marker, or a setting names something unknown. Also if
/// more than one subject has the handles' labels, no frames are like the neutral face, or the result cannot
/// be a face's. [`Error::Cancelled`].
pub fn clean(
    mut raw: RawTake,
    target: &Target,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Cleaned> {
    let settings = &*without_mirror_image(&mut raw, settings);
    const STEPS: u64 = 6;
    let step = |done: u64| {
        progress.report("clean", done, STEPS);
        if progress.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    };
    step(0)?;
    let RawTake { tracks: mut file, metres_per_unit, in_head_space, is_video, recording, warnings } = raw;
    let mut warnings: Vec<Warning> = warnings.into_iter().map(Warning::from).collect();
    let mut matched = match_labels(&target.labels, &file.labels, settings)?;
    warnings.extend(matched.warning.take().map(Warning::from));
    if file.frames() == 0 {
        return Err(Error::empty("the take has no frames"));
    }
    let frames = file.frames();
    let mut events = filled_before(&file, &matched.columns);
    let mut tracks = Tracks::new(&mut file);
    events.extend(edits::apply(&mut tracks, &settings.edits, &target.labels, &file.labels, &matched)?);
    step(1)?;
    let unmeasured = unmeasured::leave_out(&mut matched, &tracks, &file.labels, in_head_space);
    warnings.extend(unmeasured.into_iter().map(Warning::from));
    let (head, rigid) =
        without_head(&mut tracks, &matched, &file.labels, in_head_space, is_video, settings, &mut warnings)?;
    step(2)?;
    let motions = head.as_ref().map(|head| &head.motions[..]);
    let stated = Stated { metres_per_unit, in_head_space, is_video };
    let place = Place::find(&tracks, &matched.columns, motions, stated, target, settings, &mut warnings)?;
    let mut tracks = on_the_rig(tracks, &matched.columns, &place.to_rig);
    step(3)?;
    events.extend(mended(&mut tracks, &place, target, settings));
    step(4)?;
    let displaced = displacements(&mut tracks, &place, target, settings, &mut warnings);
    let noise = noise(&tracks);
    let filled = fill_gaps(&mut tracks, &events, target, settings, noise);
    if is_video {
        depth::steady(&mut tracks, &to_camera(head.as_ref(), &place, frames));
    }
    events.extend(steps(&tracks, &filled, target));
    step(5)?;
    let noise_mm = noise * 3.0_f64.sqrt() * target.millimetres();
    let low_pass_hz = filter_noise(&mut tracks, settings, noise, noise_mm);
    let poses = fit_poses(&mut tracks, target, settings)?;
    warnings.extend(unlike(&poses).map(Warning::from));
    let at = |j: usize, f: usize| target.rest[j] + tracks.columns[j][f];
    events.extend(gross_strain::events(target, tracks.frames(), at));
    events.extend(of_gaps(&mut tracks, &filled, settings));
    events.extend(head.iter().flat_map(of_head));
    events.sort_by_key(|e| (e.kind, e.first, e.marker, e.other));
    warnings.extend(not_to_be_trusted(&events, &target.labels, tracks.rate));
    let moves_alone = in_head_space || !settings.skip.contains(&Step::Head) && is_aligned(false, settings);
    match plausible::implausible(&tracks, target, moves_alone) {
        Some(error) if settings.force => warnings.push(error.to_string().into()),
        Some(error) => return Err(error),
        None => {}
    }

    let report = Report {
        labels: target.labels.clone(),
        frames,
        rate: tracks.rate,
        start: file.times[0],
        timecode: recording.timecode.map(|timecode| timecode.to_string()),
        marks: marks(&recording.events, file.times[0], tracks.rate),
        setup: found(&file.labels, &matched, &rigid, &place, displaced, poses, settings),
        head_residuals_mm: head_residuals_mm(head.as_ref(), &place, frames),
        noise_mm,
        low_pass_hz,
        warnings,
        events,
    };
    let take = Take {
        labels: target.labels.clone(),
        times: file.times,
        positions: positions(&tracks, &target.rest),
        head: head.map(|head| in_the_world(&head, &place)).or(file.head),
        confidence: confidence(&report.events, frames, target.labels.len()),
    };
    let take = match settings.fps {
        Some(fps) => take.resample(fps)?,
        None => take,
    };
    step(STEPS)?;
    Ok(Cleaned { take, report })
}

/// Undoes a mirror image of the positions, so that the remaining change of axes is a rotation. Returns the
/// settings for that rotation.
fn without_mirror_image<'a>(raw: &mut RawTake, settings: &'a Settings) -> Cow<'a, Settings> {
    match settings.axes.filter(Axes::is_mirror_image) {
        Some(axes) => {
            raw.tracks.positions.iter_mut().for_each(|x| *x = axes.apply(*x));
            Cow::Owned(Settings { axes: Some(Axes::SAME), ..settings.clone() })
        }
        None => Cow::Borrowed(settings),
    }
}

/// The direction of a video's camera on the rig in each frame. The camera looks along the file's z.
fn to_camera(head: Option<&Head>, place: &Place, frames: usize) -> Vec<DVec3> {
    let of_frame = |f: usize| {
        let turn = head.map_or(Similarity::IDENTITY, |head| head.motions[f]).rotation;
        place.to_rig.rotation * turn.conjugate() * DVec3::Z
    };
    (0..frames).map(of_frame).collect()
}

/// RMS distance of the rigid markers from the head's motion in each frame, in millimetres; 0 without a fit.
fn head_residuals_mm(head: Option<&Head>, place: &Place, frames: usize) -> Vec<f32> {
    match head {
        Some(head) => head.residuals.iter().map(|r| (r * place.unit.metres * 1e3) as f32).collect(),
        None => vec![0.0; frames],
    }
}

/// The frames of events of a take that begins at `start`, in seconds.
fn marks(events: &[TakeEvent], start: f64, rate: f64) -> Vec<Mark> {
    let mark = |event: &TakeEvent| Mark {
        name: event.name.clone(),
        frame: ((event.time - start) * rate).round() as i64,
    };
    events.iter().map(mark).collect()
}

/// How the file's markers and numbers were understood. `labels` are the file's, `rigid` the columns of the
/// head's markers.
fn found(
    labels: &[String],
    matched: &Matched,
    rigid: &[usize],
    place: &Place,
    displaced: Displaced,
    poses: Vec<Pose>,
    settings: &Settings,
) -> Found {
    let names = |columns: &[usize]| columns.iter().map(|&c| labels[c].clone()).collect::<Vec<_>>();
    let mut unused: Vec<usize> = [&matched.others[..], &matched.left_out].concat();
    unused.retain(|c| !rigid.contains(c));
    unused.sort_unstable();
    Found {
        subject: matched.subject.clone(),
        markers: matched.columns.iter().map(|c| c.map(|c| labels[c].clone())).collect(),
        rigid: names(rigid),
        unused: names(&unused),
        metres_per_unit: place.unit.metres,
        unit_is_guessed: place.unit.is_guessed,
        axes: place.axes.to_string(),
        axes_are_guessed: settings.axes.is_none() && is_aligned(place.in_head_space, settings),
        neutral: place.neutral.clone(),
        neutral_is_found: settings.neutral.is_none(),
        neutral_rival: place.rival.clone(),
        scale: place.scale(),
        in_head_space: place.in_head_space,
        offsets_mm: displaced.offsets_mm,
        scales: displaced.scales,
        poses,
    }
}

/// Whether the actor is brought onto the rig.
fn is_aligned(in_head_space: bool, settings: &Settings) -> bool {
    !in_head_space && !settings.skip.contains(&Step::Align)
}

/// Takes the head's motion out of all markers. Also returns the columns of the rigid markers.
fn without_head(
    tracks: &mut Tracks,
    matched: &Matched,
    labels: &[String],
    in_head_space: bool,
    is_video: bool,
    settings: &Settings,
    warnings: &mut Vec<Warning>,
) -> Result<(Option<Head>, Vec<usize>)> {
    let face: Vec<usize> = matched.columns.iter().copied().flatten().collect();
    let extent = typical_extent(tracks, &face);
    if extent == 0.0 {
        return Err(Error::empty("the take cannot be cleaned: no marker of a handle is seen in any frame"));
    }
    let HeadMarkers { rigid, fitted, stiff, warnings: said } =
        head_markers::find(tracks, &face, &matched.others, labels, settings, extent)?;
    if in_head_space || settings.skip.contains(&Step::Head) {
        return Ok((None, rigid));
    }
    warnings.extend(said.into_iter().map(Warning::from));
    let mut head = head::stabilise(tracks, &fitted, &stiff, &face, extent, is_video).ok_or_else(|| {
        Error::no_fit(
            "the head's motion cannot be found: it needs a frame that shows at least three markers that are \
             not on one line",
        )
    })?;
    if !settings.skip.contains(&Step::HeadLowPass) {
        let centre = head::centre(tracks, &face, &head.motions);
        head::smooth(&mut head.motions, centre, settings.head_low_pass, tracks.rate);
    }
    let back: Vec<Similarity> = head.motions.iter().map(Similarity::inverse).collect();
    tracks.columns.par_iter_mut().for_each(|column| {
        column.iter_mut().zip(&back).for_each(|(p, back)| *p = back.apply(*p));
    });
    Ok((Some(head), rigid))
}

/// The handles' markers alone, on the rig.
fn on_the_rig(mut tracks: Tracks, columns: &[Option<usize>], to_rig: &Similarity) -> Tracks {
    let unseen = vec![DVec3::NAN; tracks.frames()];
    let mut column =
        |c: &Option<usize>| c.map_or_else(|| unseen.clone(), |c| std::mem::take(&mut tracks.columns[c]));
    let mut columns: Vec<Vec<DVec3>> = columns.iter().map(&mut column).collect();
    if *to_rig != Similarity::IDENTITY {
        columns.par_iter_mut().flatten().for_each(|p| *p = to_rig.apply(*p));
    }
    Tracks { columns, rate: tracks.rate }
}

/// Undoes shuffles and swaps, drops outliers and cuts out slides. Drops what is still wrong where labels were
/// exchanged.
fn mended(tracks: &mut Tracks, place: &Place, target: &Target, settings: &Settings) -> Vec<Event> {
    let extent = extent(target.rest.iter().copied());
    let mut events = Vec::new();
    let mut exchanged = Vec::new();
    if !settings.skip.contains(&Step::Swaps) {
        let noise = noise(tracks);
        let found = shuffles::settle(tracks, place.neutral_frame(), extent, noise);
        exchanged.extend(found.suspects);
        events.extend(found.shuffles.into_iter().map(|shuffle| {
            let confidence = if shuffle.is_dropped { MODEL_CONFIDENCE } else { SHUFFLED_CONFIDENCE };
            event(Kind::Shuffled, shuffle.marker, shuffle.frames, confidence)
        }));
        let found = swaps::undo(tracks, place.neutral_frame(), &place.markers, extent);
        let of_swap = |swap: &Swap| Suspects { labels: swap.pair.into(), frames: swap.first..swap.end };
        exchanged.extend(found.iter().map(of_swap));
        events.extend(found.iter().map(|swap| Event {
            other: Some(swap.pair[1]),
            ..event(Kind::Swap, swap.pair[0], swap.first..swap.end, 1.0)
        }));
    }
    if !settings.skip.contains(&Step::Outliers) {
        let found = outliers::drop(tracks, &place.markers, extent);
        events.extend(found.iter().map(|outlier| {
            let frames = outlier.first..outlier.first + outlier.frames;
            Event {
                distance_mm: Some(outlier.distance * target.millimetres()),
                ..event(Kind::Outlier, outlier.marker, frames, SPLINE_CONFIDENCE)
            }
        }));
    }
    if !settings.skip.contains(&Step::Slides) {
        let noise = noise(tracks);
        let found = slides::cut(tracks, &place.markers, extent, noise);
        events.extend(found.iter().map(|slide| Event {
            other: slide.to,
            ..event(Kind::Slide, slide.marker, slide.first..slide.end, MODEL_CONFIDENCE)
        }));
    }
    let found = doubts::drop(tracks, &exchanged, extent, noise(tracks));
    events.extend(
        found.into_iter().map(|doubt| event(Kind::Shuffled, doubt.marker, doubt.frames, MODEL_CONFIDENCE)),
    );
    events
}

/// How the actor's face differs from the rig's.
struct Displaced {
    /// Each marker's offset from its handle at neutral, in millimetres.
    offsets_mm: Vec<Option<f64>>,
    /// How large the rig is around each handle, compared with the actor.
    scales: Vec<f64>,
}

/// Turns positions into displacements from the neutral ones, scaled to the rig's face. In head space they are
/// measured from the rest pose.
fn displacements(
    tracks: &mut Tracks,
    place: &Place,
    target: &Target,
    settings: &Settings,
    warnings: &mut Vec<Warning>,
) -> Displaced {
    let columns: Vec<Option<usize>> = (0..tracks.columns.len()).map(Some).collect();
    let pose = neutral::pose(tracks, &columns, &place.neutral);
    let offsets_mm = offsets(&pose, &target.rest, target.millimetres(), &target.labels, warnings);
    let neutral: Vec<DVec3> = if is_aligned(place.in_head_space, settings) {
        // The mean over the remaining neutral frames is less noisy than the median.
        let means = tracks.columns.iter().map(|column| mean(column, &place.neutral));
        means.zip(&place.markers).map(|(mean, at)| mean.unwrap_or(*at)).collect()
    } else {
        target.rest.clone()
    };
    let columns = tracks.columns.par_iter_mut().zip(&neutral);
    let scales = if is_aligned(place.in_head_space, settings)
        && [Step::Head, Step::Proportions].iter().all(|step| !settings.skip.contains(step))
    {
        proportions::scales(&pose, &target.rest)
    } else {
        vec![1.0; target.rest.len()]
    };
    columns.zip(&scales).for_each(|((column, at), scale)| {
        column.iter_mut().for_each(|p| *p = *scale * (*p - *at));
    });
    Displaced { offsets_mm, scales }
}

/// Holds displacements where an edit says so, and fills the other gaps.
fn fill_gaps(
    tracks: &mut Tracks,
    events: &[Event],
    target: &Target,
    settings: &Settings,
    noise: f64,
) -> Vec<Filled> {
    for held in events.iter().filter(|event| event.kind == Kind::Held) {
        gaps::hold(tracks, held.marker, held.first..held.first + held.frames);
    }
    gaps::fill(tracks, &target.rest, settings.max_gap, noise)
}

/// Steps that no skin makes, between frames in which the marker was measured.
fn steps(displacements: &Tracks, filled: &[Filled], target: &Target) -> Vec<Event> {
    let mut found = outliers::steps(displacements, &target.rest);
    for gap in filled {
        let reach = gap.frames.start..gap.frames.end + 1;
        found.retain(|step| step.marker != gap.marker || !reach.contains(&step.first));
    }
    let of_step = |step: outliers::Outlier| Event {
        distance_mm: Some(step.distance * target.millimetres()),
        ..event(Kind::Step, step.marker, step.first..step.first + step.frames, 1.0)
    };
    found.into_iter().map(of_step).collect()
}

/// Filters markers if they are noisy, or if the settings ask for it. Returns the cut-off in Hz; `None` where
/// they are not filtered.
fn filter_noise(tracks: &mut Tracks, settings: &Settings, noise: f64, noise_mm: f64) -> Option<f64> {
    let cutoff = settings.low_pass.or((noise_mm > NOISY).then_some(LOW_PASS));
    let cutoff = cutoff.filter(|hz| !settings.skip.contains(&Step::LowPass) && *hz < 0.4 * tracks.rate)?;
    // With a cut-off in the settings, everything faster counts as noise.
    low_pass::filter(tracks, cutoff, settings.low_pass.is_none().then_some(noise));
    Some(cutoff)
}

/// Maps displacements so that the actor's poses become the examples'.
fn fit_poses(tracks: &mut Tracks, target: &Target, settings: &Settings) -> Result<Vec<Pose>> {
    let (poses, maps) = poses::find(&settings.poses, &tracks.columns, &target.examples, &target.rest)?;
    if !poses.is_empty() {
        let columns = tracks.columns.par_iter_mut().zip(maps);
        columns.for_each(|(column, map)| column.iter_mut().for_each(|p| *p = map * *p));
    }
    Ok(poses)
}

/// Events of the filled gaps. If the settings leave gaps open, they are cut out again.
fn of_gaps(tracks: &mut Tracks, filled: &[Filled], settings: &Settings) -> Vec<Event> {
    let leaves_gaps = settings.skip.contains(&Step::Gaps);
    if leaves_gaps {
        filled.iter().for_each(|gap| tracks.columns[gap.marker][gap.frames.clone()].fill(DVec3::NAN));
    }
    filled.iter().map(|gap| of_gap(gap, leaves_gaps)).collect()
}

/// The frames in which too little of the head is seen.
fn of_head(head: &Head) -> impl Iterator<Item = Event> + use<> {
    let unseen = runs(&head.unseen).into_iter();
    unseen.map(|run| Event { marker: None, ..event(Kind::Head, 0, run, 0.5) })
}

fn of_gap(gap: &Filled, is_left: bool) -> Event {
    let (kind, confidence) = match gap.kind {
        _ if is_left => (Kind::Left, 0.0),
        Kind::Spline => (Kind::Spline, SPLINE_CONFIDENCE),
        Kind::Model => (Kind::Model, MODEL_CONFIDENCE),
        kind => (kind, 0.0),
    };
    event(kind, gap.marker, gap.frames.clone(), confidence)
}

/// frames × H positions on the rest pose.
fn positions(tracks: &Tracks, rest: &[DVec3]) -> Vec<[f64; 3]> {
    let mut positions = vec![[0.0; 3]; tracks.frames() * rest.len()];
    positions.par_chunks_mut(rest.len()).enumerate().for_each(|(f, frame)| {
        for (j, p) in frame.iter_mut().enumerate() {
            *p = (rest[j] + tracks.columns[j][f]).to_array();
        }
    });
    positions
}

/// The head's motions in mesh units and axes. The actor's size is left out: the rig keeps its own.
fn in_the_world(head: &Head, place: &Place) -> Vec<RigidMotion> {
    let from_rig = place.to_rig.inverse();
    let rigid = |motion: &Similarity| {
        let motion = place.to_world.after(motion).after(&from_rig);
        RigidMotion { rotation: motion.rotation.to_array(), translation: motion.translation.to_array() }
    };
    head.motions.iter().map(rigid).collect()
}
