//! Comparison of an exported file with its recipe, number by number.

use crate::export::SceneParts;
use crate::{Performance, Playback, channels};
use rhytid_core::channel::{self, Channel, Tolerance};
use rhytid_core::{Progress, Result, Rig, RigidMotion};
use rhytid_formats::animation::Format;
use rhytid_formats::export::{AnimationReader, Summary};
use rhytid_formats::export::{Frame, HeadMotion};
use rhytid_kernels::vec3;
use std::cell::LazyCell;

/// The most that two conforming devices differ by in a position, by rounding, as a part of the face's
/// diagonal.
const DEVICES_DIFFER: f64 = 1e-5;

/// The error that is allowed to a function of a triangle's shape, in units of δ/h. The triangle has the
/// height h, and its corners are off by δ.
const OF_THIN: f64 = 4.0;

/// The error that is allowed to unit normals where a file has them as integers of 8 bits. Such a normal is
/// the sum of two integers.
const OF_INTEGERS: f64 = 0.03;

/// The part by which the root mean square of fitted normals' errors may differ from what the file states, and
/// the difference that is allowed in any case. Devices round the normals of thin triangles differently.
const OF_FITTED: [f64; 2] = [0.02, 1e-4];

/// A stated error includes what float32 may add in a sum of up to 2,048 targets, as a part of the farthest
/// coordinate.
const OF_SUMS: f64 = 2.5e-4;

/// The error that is allowed to the length of a direction.
const OF_LENGTH: f64 = 1e-3;

/// A stored normal is the first frame's plus an offset, which is at most 1 along each axis if it is an
/// integer. A normal that turns straight back has no room for its direction: the sum is shorter than this.
const NO_ROOM: f32 = 0.01;

/// The difference between a channel of a file and a fresh evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelDifference {
    /// The channel.
    pub channel: Channel,
    /// The largest difference of a vertex's numbers, as a length. Directions of strain are compared up to
    /// their sign.
    pub worst: f64,
    /// The frame, counted from 0 in the file, and the vertex where it is.
    pub at: (usize, usize),
    /// The root mean square of the difference.
    pub rms: f64,
    /// The number of vertices, over all frames, whose numbers are off by more than the channel's tolerance.
    pub beyond: usize,
    /// The first of these: frame and vertex.
    pub first_beyond: Option<(usize, usize)>,
}

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// Frames that were compared.
    pub frames: usize,
    /// The difference of the positions, in mesh units.
    pub positions: ChannelDifference,
    /// The differences of the file's other channels.
    pub others: Vec<ChannelDifference>,
    /// The error that is allowed to positions, in mesh units: what the file states, plus what two devices may
    /// differ by.
    pub allowed: f64,
    /// The largest difference of two elements of the head's matrix. It is relative where an element is above
    /// 1. The translation is in mesh units.
    pub head: f64,
    /// What else differs between the file and what the recipe gives.
    pub differences: Vec<String>,
}

impl Verified {
    /// Whether the file is what its recipe gives. The limit for the head's matrix allows for glTF, which has
    /// it in 32 bits.
    pub fn passed(&self) -> bool {
        let all = std::iter::once(&self.positions).chain(&self.others);
        all.into_iter().all(|channel| channel.beyond == 0) && self.head <= 1e-6 && self.differences.is_empty()
    }
}

/// Plays the performance that the file's recipe names, and compares each number of each channel.
///
/// # Errors
/// As [`Playback::play`] and reading.
pub fn verify(
    reader: &mut dyn AnimationReader,
    format: Format,
    performance: &Performance,
    playback: &mut Playback<'_>,
    progress: &dyn Progress,
) -> Result<Verified> {
    let (summary, selection) = (reader.summary().clone(), &performance.selection);
    let mut differences = differences(&summary, performance, format)?;
    let parts = SceneParts::new(playback, performance)?;
    differences.extend(reader.compare(&parts.scene(&performance.rig, performance))?);
    let devices = DEVICES_DIFFER * diagonal(&performance.rig);
    let allowed = summary.stated_error.map_or(0.0, |stated| stated.worst) + devices;
    let limits = Limits {
        devices,
        allowed,
        rate: summary.rate,
        fitted: summary.fitted,
        is_stated: summary.stated_error.is_some(),
    };
    let known = channels::of_recipe(&performance.rig, &performance.recipe)?;
    let others = summary.channels.iter().filter(|found| known.iter().any(|known| known.name == found.name));
    let mut compared: Vec<Compared> = std::iter::once(&channel::POSITIONS)
        .chain(others)
        .map(|channel| Compared::new(channel, &summary))
        .collect();
    let head = selection.head().filter(|_| performance.recipe.head == HeadMotion::Keep);
    let (mut done, mut off_head, mut wrong_extents) = (0, 0.0_f64, 0);
    let mut buffer = Vec::new();
    let total = summary.frames as u64;
    progress.report("verify", 0, total);
    playback.play(selection, &performance.recipe, progress, |fresh| {
        let heights = LazyCell::new(|| heights(&performance.rig, fresh.positions().as_chunks().0));
        for compared in &mut compared {
            reader.channel(&compared.difference.channel, done, &mut buffer)?;
            compared.frame(done, &buffer, fresh, &|v| heights[v], &limits);
        }
        if let Some(extent) = reader.extent(done)? {
            reader.positions(done, &mut buffer)?;
            let expected = extent_of(&buffer);
            let is_right = if !summary.clips.is_empty() {
                // One box is around the frames of several clips.
                is_around(extent, expected, f64::INFINITY)
            } else if summary.fitted {
                // The box around sums of shapes is a little larger, since programs round these sums.
                is_around(extent, expected, DEVICES_DIFFER * diagonal(&performance.rig))
            } else {
                extent == expected
            };
            wrong_extents += usize::from(!is_right);
        }
        // A head that never moves need not be in the file.
        let expected = head.map_or(RigidMotion::IDENTITY, |head| head[done]).matrix();
        let found = reader.head(done)?.unwrap_or(RigidMotion::IDENTITY.matrix());
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            let off = (found - expected).abs() / expected.abs().max(1.0);
            if off > off_head || off.is_nan() {
                off_head = off;
            }
        }
        done += 1;
        progress.report("verify", done as u64, total);
        Ok(())
    })?;
    if wrong_extents > 0 {
        differences.push(format!("extents: wrong in {wrong_extents} of {done} frames"));
    }
    let at_stated = compared[0].at_asked;
    let mut found = compared.into_iter().map(Compared::finish);
    let positions = found.next().unwrap_or_else(|| Compared::new(&channel::POSITIONS, &summary).finish());
    let others: Vec<ChannelDifference> = found.collect();
    let coordinates = performance.rig.surface().rest.as_flattened().iter();
    let farthest = coordinates.fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
    let sums = if summary.fitted { OF_SUMS * farthest } else { 0.0 };
    let rounding = 2.0 * devices + sums;
    differences.extend(wrong_statements(&summary, &positions, &others, rounding, at_stated));
    Ok(Verified { frames: done, positions, others, allowed, head: off_head, differences })
}

/// What the file states of its errors and is not so. A file that states a large error would allow anything.
/// `at_stated` is the difference at the stated place of the largest one, and `rounding` is what positions may
/// differ by in any case.
fn wrong_statements(
    summary: &Summary,
    positions: &ChannelDifference,
    others: &[ChannelDifference],
    rounding: f64,
    at_stated: f64,
) -> Vec<String> {
    let is_off =
        |stated: f64, found: f64, rounding: f64| (stated - found).abs() > rounding || stated.is_nan();
    let sentence =
        |what: &str, stated: f64, found: f64| format!("the stated {what}: {stated:.6}, but it is {found:.6}");
    let mut wrong = Vec::new();
    if let Some(stated) = summary.stated_error {
        if is_off(stated.worst, positions.worst, rounding) {
            wrong.push(sentence("error", stated.worst, positions.worst));
        }
        if is_off(stated.rms, positions.rms, 0.01 * positions.rms + rounding) {
            wrong.push(sentence("RMS error", stated.rms, positions.rms));
        }
        if is_off(at_stated, positions.worst, rounding) {
            let (frame, vertex) = stated.at;
            wrong.push(format!(
                "the stated place of the largest error: not in frame {frame}, vertex {vertex}"
            ));
        }
    }
    for other in others {
        let is_normal = other.channel.name == channel::NORMALS.name;
        let Some(stated) = summary.stated_channel_error(&other.channel) else {
            if is_normal && summary.fitted {
                wrong.push("the error of the normals: is not stated; export the file again".into());
            }
            continue;
        };
        let [part, least] = OF_FITTED;
        if is_normal && is_off(stated.rms, other.rms, part * other.rms + least) {
            wrong.push(sentence("RMS error of the normals", stated.rms, other.rms));
        }
        // Thin triangles magnify how devices round.
        if stated.worst > 2.0 * other.worst + 0.01 || stated.worst.is_nan() {
            wrong.push(sentence(&format!("error of the {}", other.channel.words), stated.worst, other.worst));
        }
    }
    wrong
}

/// The differences between the file and what its recipe gives that are known without reading frames.
fn differences(summary: &Summary, performance: &Performance, format: Format) -> Result<Vec<String>> {
    let rig = &performance.rig;
    let is_usd = !matches!(format, Format::Glb | Format::Gltf);
    let has = |yes: bool| if yes { "has" } else { "lacks" };
    let mut found = Vec::new();
    let mut compare = |what: &str, found_here: String, expected: String| {
        if found_here != expected {
            found.push(format!("{what}: {found_here}, expected {expected}"));
        }
    };
    // glTF has it in 32 bits.
    let ratio = summary.metres_per_unit / rig.surface().metres_per_unit;
    if ratio.is_nan() || (ratio - 1.0).abs() > 1e-6 {
        compare(
            "metres per unit",
            summary.metres_per_unit.to_string(),
            rig.surface().metres_per_unit.to_string(),
        );
    }
    if let Some(shown) = summary.frames_per_second {
        compare("framesPerSecond", shown.to_string(), summary.rate.to_string());
    }
    compare("up axis", format!("{:?}", summary.up_axis), format!("{:?}", rig.surface().up_axis));
    // A layer over another has no faces. The reader of glTF compares the triangles of each material.
    let faces_are_right = !is_usd || summary.faces.is_empty() || summary.faces == rig.surface().faces;
    compare("faces", if faces_are_right { "the rig's" } else { "others" }.into(), "the rig's".into());
    let expected = channels::of_recipe(rig, &performance.recipe)?;
    let expected = format.stored(&expected, summary.fitted);
    let is_in = |channels: &[Channel], channel: &Channel| {
        channels.iter().any(|known| known.name == channel.name && known.width == channel.width)
    };
    let others = summary.channels.iter().filter(|channel| channel.name != channel::POSITIONS.name);
    let unexpected = others.filter(|channel| !is_in(&expected, channel));
    for channel in expected.iter().chain(unexpected) {
        let here = is_in(&summary.channels, channel);
        compare(&channel.name, has(here).into(), has(is_in(&expected, channel)).into());
    }
    compare("extents", has(summary.extents).into(), has(is_usd).into());
    Ok(found)
}

/// The errors that are allowed to a file's numbers.
struct Limits {
    /// δ of two devices, in mesh units.
    devices: f64,
    /// δ of positions in the file.
    allowed: f64,
    rate: f64,
    fitted: bool,
    /// Whether the file states an error at all.
    is_stated: bool,
}

/// A channel, and its differences in the frames so far.
struct Compared {
    difference: ChannelDifference,
    squares: f64,
    count: usize,
    /// The largest difference that the file states for the channel.
    stated: f64,
    /// The frame and the vertex of the largest difference, as the file states it, and the difference there.
    asked: Option<(usize, usize)>,
    at_asked: f64,
    /// The normals of the first frame, where those of later frames may be stored as integers.
    first: Vec<f32>,
}

impl Compared {
    fn new(channel: &Channel, summary: &Summary) -> Self {
        let difference = ChannelDifference {
            channel: channel.clone(),
            worst: 0.0,
            at: (0, 0),
            rms: 0.0,
            beyond: 0,
            first_beyond: None,
        };
        let stated = summary.stated_channel_error(channel).map_or(0.0, |stated| stated.worst);
        let is_positions = channel.name == channel::POSITIONS.name;
        let asked = summary.stated_error.filter(|_| is_positions).map(|stated| stated.at);
        Self { difference, squares: 0.0, count: 0, stated, asked, at_asked: f64::NAN, first: Vec::new() }
    }

    /// `height` is a number of [`heights`]. It is asked for where a difference is within the limit only if
    /// its triangles are thin.
    fn frame(
        &mut self,
        frame: usize,
        found: &[f32],
        fresh: &Frame<'_>,
        height: &dyn Fn(usize) -> f64,
        limits: &Limits,
    ) {
        let channel = &self.difference.channel;
        let Some(expected) = fresh.get(channel) else { return };
        let is_normal = channel.name == channel::NORMALS.name;
        let is_axis = matches!(channel.tolerance, Tolerance::PrincipalAxis { .. });
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(f64::from(x.abs())));
        let strains = fresh.get(&channel::STRAIN).unwrap_or_default();
        // Fitted channels follow the fitted positions.
        let moved = if limits.fitted { limits.allowed } else { limits.devices };
        let of_thin = |v: usize| OF_THIN * moved / height(v);
        let of_normals = if is_normal && !limits.fitted && limits.is_stated { OF_INTEGERS } else { 0.0 };
        if is_normal && limits.is_stated && self.first.is_empty() {
            self.first = expected.to_vec();
        }
        // glTF demands a normal where the mesh has none.
        let is_any =
            |v: usize, expected: &[f32]| v * 3 < self.first.len() && expected.iter().all(|x| *x == 0.0);
        let turns_back = |v: usize, expected: &[f32]| {
            let first = self.first.get(3 * v..3 * v + 3).filter(|_| !limits.fitted).unwrap_or_default();
            first.iter().zip(expected).any(|(first, n)| 1.0 + first * n.signum() < NO_ROOM * n.abs())
        };
        let within = |v: usize, thin: f64| match channel.tolerance {
            Tolerance::Position => limits.allowed,
            Tolerance::Velocity => 2.0 * limits.allowed * limits.rate,
            Tolerance::Shape { within } => within + of_normals + self.stated + thin,
            Tolerance::PrincipalAxis { within } => {
                let apart = strains.get(2 * v..2 * v + 2).map_or(0.0, |e| f64::from(e[0] - e[1]));
                (within + thin) / apart.max(0.0)
            }
            Tolerance::FromMarkers { of_largest } => of_largest * largest + self.stated + 1e-6,
        };
        let is_by_shapes =
            matches!(channel.tolerance, Tolerance::Shape { .. } | Tolerance::PrincipalAxis { .. });
        let is_allowed = |v: usize, distance: f64| {
            distance <= within(v, 0.0) || is_by_shapes && distance <= within(v, of_thin(v))
        };
        let width = channel.width;
        let values = found.chunks_exact(width).zip(expected.chunks_exact(width));
        let (mut beyond, mut first_beyond) = (0, self.difference.first_beyond);
        for (v, (found, expected)) in values.enumerate() {
            let off = |expected: &[f32], sign: f64| {
                let square = |(a, b): (&f32, &f32)| (f64::from(*a) - sign * f64::from(*b)).powi(2);
                found.iter().zip(expected).map(square).sum::<f64>().sqrt()
            };
            // Also if the distance is NaN, which then stays the worst.
            let distance =
                if is_axis { off(expected, 1.0).min(off(expected, -1.0)) } else { off(expected, 1.0) };
            let length = |x: &[f32]| x.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let is_right = match () {
                () if (is_any(v, expected) || turns_back(v, expected))
                    && (length(found) - 1.0).abs() < OF_LENGTH =>
                {
                    true
                }
                // Where both strains are the same, each direction is right, but it is still one.
                () if is_axis && (length(found) - length(expected)).abs() > OF_LENGTH => distance == 0.0,
                () => is_allowed(v, distance),
            };
            if self.asked == Some((frame, v)) {
                self.at_asked = distance;
            }
            if !is_right || distance.is_nan() {
                beyond += 1;
                first_beyond = first_beyond.or(Some((frame, v)));
            }
            self.squares += distance * distance;
            if distance > self.difference.worst || distance.is_nan() {
                (self.difference.worst, self.difference.at) = (distance, (frame, v));
            }
        }
        // A missing number counts as a wrong one.
        beyond += expected.len().abs_diff(found.len()) / width;
        self.count += expected.len() / width;
        self.difference.beyond += beyond;
        self.difference.first_beyond = first_beyond;
    }

    fn finish(self) -> ChannelDifference {
        ChannelDifference { rms: (self.squares / self.count.max(1) as f64).sqrt(), ..self.difference }
    }
}

/// The least height of the triangles at each vertex, in mesh units; infinite where a vertex has none.
fn heights(rig: &Rig, positions: &[[f32; 3]]) -> Vec<f64> {
    let mut heights = vec![f64::INFINITY; positions.len()];
    for corners in &rig.surface().triangles {
        let [a, b, c] = corners.map(|v| positions[v as usize].map(f64::from));
        let [ab, ac, bc] = [vec3::sub(b, a), vec3::sub(c, a), vec3::sub(c, b)];
        let normal = vec3::cross(ab, ac);
        let longest = [ab, ac, bc].map(|edge| vec3::dot(edge, edge)).into_iter().fold(0.0, f64::max).sqrt();
        let height = if longest > 0.0 { vec3::dot(normal, normal).sqrt() / longest } else { 0.0 };
        for v in corners {
            let least = &mut heights[*v as usize];
            *least = least.min(height);
        }
    }
    heights
}

/// The box around positions.
fn extent_of(positions: &[f32]) -> [[f32; 3]; 2] {
    positions.as_chunks::<3>().0.iter().fold([[f32::MAX; 3], [f32::MIN; 3]], |[low, high], x| {
        [[0, 1, 2].map(|c| low[c].min(x[c])), [0, 1, 2].map(|c| high[c].max(x[c]))]
    })
}

/// Whether a box is around another, and no face of it is farther away than `most`.
fn is_around([low, high]: [[f32; 3]; 2], [inner_low, inner_high]: [[f32; 3]; 2], most: f64) -> bool {
    let is_near = |inner: f32, outer: f32| (0.0..=most).contains(&(f64::from(inner) - f64::from(outer)));
    (0..3).all(|c| is_near(inner_low[c], low[c]) && is_near(high[c], inner_high[c]))
}

/// The diagonal of the rest pose's bounding box, in mesh units.
fn diagonal(rig: &Rig) -> f64 {
    let extent = |c: usize| {
        let along = || rig.surface().rest.iter().map(|p| f64::from(p[c]));
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
    };
    (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt()
}
