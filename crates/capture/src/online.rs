//! The clean-up of frames as they come: the head's motion is taken out and the actor is brought onto the rig,
//! frame by frame.
//!
//! The first frames show the neutral face. They say all that stays the same: which marker is whose, the
//! head's rigid markers, the unit, the actor's size, and each marker's place at neutral. After that, a frame
//! needs only itself and the one before. So gaps are not filled as well as in a whole take, and swaps and
//! slides are not found.
use crate::head::{self, FACE_TOLERANCE, RIGID_TOLERANCE};
use crate::head_markers::{self, HeadMarkers};
use crate::labels::match_labels;
use crate::neighbours::nearest;
use crate::outliers;
use crate::placing::{Place, Stated};
use crate::settings::{Settings, Step};
use crate::tracks::{Tracks, extent, mean, median_point, seen, typical_extent};
use crate::{Target, neutral, proportions};
use glam::DVec3;
use rhytid_core::text::listed;
use rhytid_core::{Error, RawTake, Result, RigidMotion, Warning};
use rhytid_geometry::registration::{Similarity, fit_robustly};

/// The time in which the confidence of a marker that is not seen falls from 1 to 0, in seconds.
const FADE: f64 = 0.5;

/// A head that turns by less, in radians, does not tell what is on it from what is beside it.
const TURNS: f64 = 0.035;

/// A frame on the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct OnlineFrame {
    /// H positions in mesh units and head space.
    pub positions: Vec<[f32; 3]>,
    /// H: 1 where the marker was measured. It falls to 0 within half a second after the marker was last
    /// measured; 0 for a marker that never was.
    pub confidence: Vec<f32>,
    /// The head's motion in the world, in mesh units and axes.
    pub head: RigidMotion,
}

/// What the first frames said, and the last frame.
#[derive(Debug, Clone)]
pub struct Online {
    /// The place of each handle's marker among the labels.
    columns: Vec<Option<usize>>,
    /// The head's rigid markers, the stiffest ones of the face, and all of the face.
    bodies: Vec<Body>,
    to_rig: Similarity,
    to_world: Similarity,
    rest: Vec<DVec3>,
    /// H places at neutral on the rig, and how much larger the rig is around each.
    neutral: Vec<DVec3>,
    scales: Vec<f64>,
    neighbours: Vec<Vec<usize>>,
    /// The face's, in mesh units.
    extent: f64,
    keeps_outliers: bool,
    head: Similarity,
    /// The time of the last frame.
    time: Option<f64>,
    /// H: when each marker was last measured.
    measured: Vec<Option<f64>>,
    displacements: Vec<DVec3>,
}

/// Markers that keep their distances.
#[derive(Debug, Clone)]
struct Body {
    columns: Vec<usize>,
    /// Their places in the head's space.
    places: Vec<DVec3>,
    tolerance: f64,
}

impl Online {
    /// Learns an actor from frames of the neutral face in world space. Without neutral frames in the
    /// settings, all frames are neutral. Also returns what a user should read.
    ///
    /// # Errors
    /// As [`crate::clean`].
    pub fn calibrate(mut raw: RawTake, target: &Target, settings: &Settings) -> Result<(Self, Vec<Warning>)> {
        if settings.axes.is_some_and(|axes| axes.is_mirror_image()) {
            return Err(Error::unsupported_format(
                "the axes are a mirror image, which frames cannot have while they come; turn the axes in the \
                 program that sends",
            ));
        }
        let mut warnings = Vec::new();
        if !settings.poses.is_empty() || !settings.edits.is_empty() {
            warnings.push(Warning::from(
                "poses and repairs by hand are for whole takes, and are left out for frames as they come"
                    .to_owned(),
            ));
        }
        let matched = match_labels(&target.labels, &raw.tracks.labels, settings)?;
        warnings.extend(matched.warning.iter().cloned().map(Warning::from));
        let labels = raw.tracks.labels.clone();
        let mut tracks = Tracks::new(&mut raw.tracks);
        let frames = tracks.frames();
        let settings = Settings { neutral: settings.neutral.clone().or(Some(0..frames)), ..settings.clone() };
        let face: Vec<usize> = matched.columns.iter().copied().flatten().collect();
        let size = typical_extent(&tracks, &face);
        if size == 0.0 {
            return Err(Error::empty("no marker of a handle is seen in the frames of the neutral face"));
        }
        let HeadMarkers { rigid, mut fitted, stiff, warnings: said } =
            head_markers::find(&tracks, &face, &matched.others, &labels, &settings, size)?;
        warnings.extend(said.into_iter().map(Warning::from));
        let stabilised = |fitted: &[usize]| {
            head::stabilise(&tracks, fitted, &stiff, &face, size, raw.is_video).ok_or_else(|| {
                Error::no_fit(
                    "the head's motion cannot be found: it needs a frame that shows at least three markers \
                     that are not on one line",
                )
            })
        };
        let mut found = stabilised(&fitted)?;
        let is_sure = settings.rigid.is_some() || head_markers::are_called_head(&rigid, &labels);
        if !rigid.is_empty() && !is_sure && turn(&found.motions) < TURNS {
            warnings.push(Warning::from(format!(
                "the head hardly turns in the frames of the neutral face, so that the markers {} may be on it \
                 or beside it; the head's motion comes from the face's markers; say which markers are rigid, \
                 or turn the head a little in these frames",
                listed(rigid.iter().map(|&c| labels[c].as_str()))
            )));
            fitted.clear();
            found = stabilised(&fitted)?;
        }
        for column in &mut tracks.columns {
            for (point, motion) in column.iter_mut().zip(&found.motions) {
                *point = motion.inverse().apply(*point);
            }
        }
        let body = |columns: &[usize], tolerance: f64| Body {
            places: columns
                .iter()
                .map(|&c| median_point(tracks.columns[c].iter().copied().filter(|p| seen(*p))))
                .collect(),
            columns: columns.to_vec(),
            tolerance: tolerance * size,
        };
        let bodies =
            vec![body(&fitted, RIGID_TOLERANCE), body(&stiff, RIGID_TOLERANCE), body(&face, FACE_TOLERANCE)];
        let stated =
            Stated { metres_per_unit: raw.metres_per_unit, in_head_space: false, is_video: raw.is_video };
        let place = Place::find(
            &tracks,
            &matched.columns,
            Some(&found.motions),
            stated,
            target,
            &settings,
            &mut warnings,
        )?;
        let pose = neutral::pose(&tracks, &matched.columns, &place.neutral);
        let on_rig: Vec<DVec3> = pose.iter().map(|p| place.to_rig.apply(*p)).collect();
        crate::placing::offsets(&on_rig, &target.rest, target.millimetres(), &target.labels, &mut warnings);
        let mut at_neutral = Vec::with_capacity(target.rest.len());
        for (column, rest) in matched.columns.iter().zip(&target.rest) {
            let mean = column.and_then(|c| mean(&tracks.columns[c], &place.neutral));
            at_neutral.push(mean.map_or(*rest, |mean| place.to_rig.apply(mean)));
        }
        let is_plain = [Step::Align, Step::Proportions].iter().any(|step| settings.skip.contains(step));
        let scales =
            if is_plain { vec![1.0; target.rest.len()] } else { proportions::scales(&on_rig, &target.rest) };
        let online = Self {
            columns: matched.columns,
            bodies,
            to_rig: place.to_rig,
            to_world: place.to_world,
            neutral: if settings.skip.contains(&Step::Align) { target.rest.clone() } else { at_neutral },
            scales,
            neighbours: nearest(&target.rest, 5),
            extent: extent(target.rest.iter().copied()),
            keeps_outliers: settings.skip.contains(&Step::Outliers),
            head: found.motions.last().copied().unwrap_or(Similarity::IDENTITY),
            time: None,
            measured: vec![None; target.rest.len()],
            displacements: vec![DVec3::ZERO; target.rest.len()],
            rest: target.rest.clone(),
        };
        Ok((online, warnings))
    }

    /// The frame at a time in seconds, which is later than that of the frame before. `markers` are in the
    /// order of the labels at calibration; one that is no finite number, or that is left
    /// out, is not seen.
    pub fn frame(&mut self, time: f64, markers: &[[f64; 3]]) -> OnlineFrame {
        let marker = |column: usize| {
            let point = markers.get(column).map_or(DVec3::NAN, |p| DVec3::from_array(*p));
            if point.is_finite() { point } else { DVec3::NAN }
        };
        for body in &self.bodies {
            let now: Vec<DVec3> = body.columns.iter().map(|&column| marker(column)).collect();
            if let Some((motion, _)) = fit_robustly(&body.places, &now, false, body.tolerance) {
                self.head = motion;
                break;
            }
        }
        let onto_rig = self.to_rig.after(&self.head.inverse());
        let mut now = vec![DVec3::NAN; self.rest.len()];
        for (j, column) in self.columns.iter().enumerate() {
            let point = column.map_or(DVec3::NAN, marker);
            if seen(point) {
                now[j] = self.scales[j] * (onto_rig.apply(point) - self.neutral[j]);
            }
        }
        let confidence = self.measure(time, &now);
        let positions =
            self.rest.iter().zip(&self.displacements).map(|(rest, d)| (*rest + *d).as_vec3().to_array());
        let head = self.to_world.after(&self.head).after(&self.to_rig.inverse());
        OnlineFrame {
            positions: positions.collect(),
            confidence,
            head: RigidMotion {
                rotation: head.rotation.to_array(),
                translation: head.translation.to_array(),
            },
        }
    }

    /// Takes the displacements of a frame. A marker that is not seen, or that jumps away from its neighbours
    /// as no skin does, goes with its neighbours. Returns the confidence of each.
    fn measure(&mut self, time: f64, now: &[DVec3]) -> Vec<f32> {
        // How far each marker moved since the frame before, where both show it.
        let mut steps = vec![DVec3::NAN; now.len()];
        for (j, step) in steps.iter_mut().enumerate() {
            if self.measured[j].is_some() && self.measured[j] == self.time {
                *step = now[j] - self.displacements[j];
            }
        }
        let mut confidence = Vec::with_capacity(now.len());
        for (j, &now) in now.iter().enumerate() {
            let around = median_point(self.neighbours[j].iter().map(|&n| steps[n]).filter(|p| seen(*p)));
            let before = self.displacements[j];
            let expected = if seen(around) { before + around } else { before };
            // Neighbours may be wrong, too: a marker that keeps its own place is believed.
            let is_far =
                |from: DVec3, since: f64| outliers::is_jump_within(from, now, time - since, self.extent);
            let jumps = !self.keeps_outliers
                && self.measured[j].is_some_and(|since| is_far(before, since) && is_far(expected, since));
            if seen(now) && !jumps {
                self.measured[j] = Some(time);
                self.displacements[j] = now;
                confidence.push(1.0);
            } else {
                self.displacements[j] = expected;
                let sure = self.measured[j].map_or(0.0, |since| 1.0 - (time - since) / FADE);
                confidence.push(sure.max(0.0) as f32);
            }
        }
        self.time = Some(time);
        confidence
    }
}

/// How far the head turns from its first place, in radians.
fn turn(motions: &[Similarity]) -> f64 {
    let first = motions.first().map_or(Similarity::IDENTITY, |motion| *motion).rotation;
    motions.iter().map(|motion| motion.rotation.angle_between(first)).fold(0.0, f64::max)
}
