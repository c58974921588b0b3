//! The handles of a face from one frame of a take.
use crate::face_cluster::face_clusters;
use crate::handles::{HandleSettings, PlacedHandles};
use crate::label_words::says_head;
use crate::labels::is_unlabelled;
use crate::orientation::{Choice, Known, choose};
use crate::posture::Posture;
use crate::settings::Settings;
use crate::subjects::{is_called, parted, unknown};
use crate::tracks::{Tracks, extent, mean, seen, typical_extent};
use crate::typical::{moves_with, rigid_set, typical_frame};
use crate::verdict;
use crate::{by_motion, head, head_markers};
use glam::DVec3;
use rhytid_core::text::listed;
use rhytid_core::{Error, Face, Handles, InputErrorKind, Progress, RawTake, Result, SurfacePoint, Take};
use rhytid_geometry::registration::{OntoSurface, Similarity};
use rhytid_solve::{Placed, Skin};
use std::collections::BTreeSet;

/// A marker on a head band keeps its distance from others and is at least this far off the skin, in metres.
const OFF_SKIN: f64 = 0.005;

/// Rounds in which markers of a head band are told from those of the face.
const PASSES: usize = 3;

/// A marker that was laid farther from the skin than this, in metres, is on no face.
const FAR: f64 = 0.04;

/// A marker that is shown in a smaller part of the frames gets no handle.
const RARE: f64 = 0.05;

/// A marker of a cap is nearer than this to the middle of the face, in metres.
const HEAD: f64 = 0.35;

/// Frames in which the motion of markers is compared with the examples.
const COMPARED: usize = 240;

/// With fewer markers nothing can be laid.
const FEWEST: usize = 4;

/// A second cluster is a face too if its cost is at most so many times the best one's. Another actor's is one
/// if its cost is below the second number.
const FACES: (f64, f64) = (1.5, 0.4);

/// So many known points say where the face is.
const CERTAIN: usize = 3;

/// Fits with a greater cost are useless.
pub(crate) const POOR: f64 = 0.75;

/// Places a handle for each marker in one frame.
pub(crate) fn place(
    face: &Face,
    raw: &RawTake,
    settings: &HandleSettings,
    skin: &Skin,
    progress: &dyn Progress,
) -> Result<PlacedHandles> {
    let mut placing = Placing::new(face, raw, settings, skin, progress)?;
    let unlabelled = placing.without_unlabelled();
    let actor = placing.columns.clone();
    let mut faults = placing.keep_the_face()?;
    let frame = placing.frame;
    let others: Vec<usize> = actor.iter().copied().filter(|m| !placing.columns.contains(m)).collect();
    let posture = Posture::new(&raw.tracks, &placing.columns, &others, frame);
    let shown: Vec<usize> = placing.columns.iter().copied().filter(|&m| seen(placing.at(m))).collect();
    let Cap { rigid, laid } = placing.cap(&shown, &others, &posture)?;
    let mut on_skin: Vec<usize> = shown.iter().copied().filter(|m| !rigid.contains(m)).collect();
    let mut laid = match laid {
        Some(laid) => laid,
        None => placing.lay(&on_skin, &posture)?,
    };
    // What is far off the face says nothing about where the face is.
    let far: Vec<usize> = (0..on_skin.len())
        .filter(|&i| placing.known[on_skin[i]].is_none())
        .filter(|&i| skin.distance(laid.fit.points[i]) * face.metres_per_unit > FAR)
        .map(|i| on_skin[i])
        .collect();
    if !far.is_empty() && on_skin.len() >= FEWEST + far.len() {
        on_skin.retain(|m| !far.contains(m));
        laid = placing.lay(&on_skin, &posture)?;
    }
    let mut placed = skin.points(&laid.fit, &placing.known_of(&on_skin))?;
    let moved = placing.move_by_motion(&on_skin, &rigid, &laid.fit.motion, &placed);
    if !moved.is_empty() {
        placed = skin.points(&laid.fit, &placing.known_of(&on_skin))?;
        for &i in &moved {
            placed[i].distance = skin.at(&placed[i].point).distance(laid.fit.points[i]);
        }
    }
    let labels = &raw.tracks.labels;
    let handles = Handles {
        labels: on_skin.iter().map(|&m| labels[m].clone()).collect(),
        points: placed.iter().map(|placed| placed.point).collect(),
    };
    faults.extend(verdict::faults(face, &placed, &laid));
    let mut warnings = verdict::warnings(face, &handles, &placed, &laid);
    warnings.extend(verdict::moved(&handles, &moved));
    if settings.known.len() >= CERTAIN {
        faults.append(&mut warnings);
        warnings = std::mem::take(&mut faults);
    } else {
        warnings.extend(verdict::may_slide(face, skin.axes(), &laid));
    }
    let names = |columns: &mut dyn Iterator<Item = usize>| -> Vec<String> {
        columns.map(|m| labels[m].clone()).collect()
    };
    let is_rigid = |m: &usize| rigid.contains(m);
    Ok(PlacedHandles {
        distances: placed.iter().map(|placed| placed.distance).collect(),
        markers: laid.fit.points.iter().map(DVec3::to_array).collect(),
        rigid: names(&mut rigid.iter().copied()),
        elsewhere: names(&mut actor.iter().copied().filter(|m| {
            !is_rigid(m) && (!placing.columns.contains(m) || far.contains(m) && !on_skin.contains(m))
        })),
        unseen: names(&mut placing.columns.iter().copied().filter(|m| !shown.contains(m) && !is_rigid(m))),
        unlabelled: names(&mut unlabelled.into_iter()),
        handles,
        frame,
        cost: laid.fit.cost,
        faults,
        warnings,
    })
}

/// Markers on the mesh, the right way up.
pub(crate) struct Laid {
    pub fit: OntoSurface,
    pub choice: Choice,
}

/// Markers of a cap or a head band.
struct Cap {
    rigid: BTreeSet<usize>,
    /// The other markers on the mesh, if they were laid without those of the cap.
    laid: Option<Laid>,
}

/// The markers of a take that are to be placed.
struct Placing<'a> {
    face: &'a Face,
    take: &'a Take,
    settings: &'a HandleSettings,
    skin: &'a Skin,
    progress: &'a dyn Progress,
    /// Metres in one unit of the take, if known.
    metres: Option<f64>,
    in_head_space: bool,
    is_video: bool,
    /// The columns of the markers.
    columns: Vec<usize>,
    /// The point of each column, if known.
    known: Vec<Option<SurfacePoint>>,
    frame: usize,
}

impl<'a> Placing<'a> {
    fn new(
        face: &'a Face,
        raw: &'a RawTake,
        settings: &'a HandleSettings,
        skin: &'a Skin,
        progress: &'a dyn Progress,
    ) -> Result<Self> {
        let take = &raw.tracks;
        let metres = settings.metres_per_unit.or(raw.metres_per_unit);
        let mut placing = Self {
            face,
            take,
            settings,
            skin,
            progress,
            metres: metres.or(raw.in_head_space.then_some(face.metres_per_unit)),
            in_head_space: raw.in_head_space,
            is_video: raw.is_video,
            columns: (0..take.labels.len()).collect(),
            known: vec![None; take.labels.len()],
            frame: settings.frame.unwrap_or(0),
        };
        if take.frames() == 0 {
            return Err(Error::empty("the take has no frames"));
        }
        if placing.frame >= take.frames() {
            return Err(Error::out_of_range(format!(
                "the frame {} is not in the take, expected 0 to {}",
                placing.frame,
                take.frames() - 1
            )));
        }
        if let Some(subject) = &settings.subject {
            let labels = parted(&[], &take.labels);
            placing
                .columns
                .retain(|&m| labels[m].subject.as_deref().is_some_and(|known| is_called(known, subject)));
            if placing.columns.is_empty() {
                return Err(unknown(subject, &labels));
            }
        }
        for (label, point) in &settings.known {
            if let Some(vertex) = point.triangle().iter().find(|v| v.index() >= face.neutral.positions.len())
            {
                return Err(Error::out_of_range(format!(
                    "the marker “{label}” is said to be at vertex {vertex}, expected 0 to {}",
                    face.neutral.positions.len().saturating_sub(1)
                )));
            }
            let column = placing.column(label)?;
            placing.known[column] = Some(*point);
        }
        Ok(placing)
    }

    fn column(&self, label: &String) -> Result<usize> {
        let labels = &self.take.labels;
        labels.iter().position(|known| known == label).ok_or_else(|| {
            let known = listed(labels.iter().map(String::as_str));
            Error::input(format!("no marker of the take is called “{label}”; it has {known}"))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] })
        })
    }

    /// Where the frame shows a column's marker.
    fn at(&self, m: usize) -> DVec3 {
        DVec3::from_array(self.take.positions[self.frame * self.take.labels.len() + m])
    }

    fn known_of(&self, columns: &[usize]) -> Vec<Option<SurfacePoint>> {
        columns.iter().map(|&m| self.known[m]).collect()
    }

    /// Leaves out points without a label and those that hardly any frame shows, unless nothing else is there.
    /// Returns them.
    fn without_unlabelled(&mut self) -> Vec<usize> {
        let count = self.take.labels.len();
        let shows =
            |m: usize| self.take.positions.iter().skip(m).step_by(count).filter(|p| !p[0].is_nan()).count();
        let is_left_out = |m: &usize| {
            let is_rare = (shows(*m) as f64) < RARE * self.take.frames() as f64;
            self.known[*m].is_none() && (is_unlabelled(&self.take.labels[*m]) || is_rare)
        };
        let (left_out, kept): (Vec<usize>, Vec<usize>) = self.columns.iter().copied().partition(is_left_out);
        if kept.len() < FEWEST {
            return Vec::new();
        }
        self.columns = kept;
        left_out
    }

    /// Leaves out the markers that are not of the face, and finds the frame. Returns what is wrong if the
    /// take shows more than one face.
    fn keep_the_face(&mut self) -> Result<Vec<String>> {
        if self.columns.len() < FEWEST {
            return Err(Error::no_fit(format!(
                "the take has {} markers with a label, expected at least {FEWEST}",
                self.columns.len()
            )));
        }
        let mut best: Option<(f64, Self)> = None;
        let mut costs = Vec::new();
        let clusters = face_clusters(self.take, &self.columns, self.metres);
        let is_alone = clusters.len() < 2;
        for cluster in clusters {
            let first = cluster[0];
            let mut of_cluster = Self { known: self.known.clone(), columns: cluster, ..*self };
            // Who names the vertex of a marker, knows that it is on the face.
            let named = self.columns.iter().filter(|m| self.known[**m].is_some());
            of_cluster.columns.extend(named);
            of_cluster.columns.sort_unstable();
            of_cluster.columns.dedup();
            if self.settings.frame.is_none() {
                of_cluster.frame = typical_frame(&select(self.take, &of_cluster.columns));
            }
            let shown: Vec<usize> =
                of_cluster.columns.iter().copied().filter(|&m| seen(of_cluster.at(m))).collect();
            let cost =
                if is_alone { 0.0 } else { of_cluster.lay_all(&shown).map_or(1.0, |laid| laid[0].cost) };
            costs.push((cost, first));
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, of_cluster));
            }
        }
        let Some((least, of_face)) = best else { return Ok(Vec::new()) };
        *self = of_face;
        // A hand fits too, if its markers are few. Another actor's face has another prefix.
        let subjects = parted(&[], &self.take.labels);
        let own = &subjects[self.columns[0]].subject;
        costs.retain(|(cost, m)| *cost <= FACES.0 * least || *cost < FACES.1 && subjects[*m].subject != *own);
        if costs.len() < 2 {
            return Ok(Vec::new());
        }
        let marker = |m: usize| format!("one with the marker “{}”", self.take.labels[m]);
        let of: Vec<String> = costs.into_iter().map(|(_, m)| marker(m)).collect();
        Ok(vec![format!("the take shows more than one face, {}; say which actor is meant", of.join(" and "))])
    }

    /// Markers of a cap or a head band, among those of the face that are `shown` and `others`.
    fn cap(&self, shown: &[usize], others: &[usize], posture: &Posture) -> Result<Cap> {
        if let Some(rigid) = &self.settings.rigid {
            let rigid = rigid.iter().map(|label| self.column(label)).collect::<Result<_>>()?;
            return Ok(Cap { rigid, laid: None });
        }
        // A fit with all markers says roughly which ones are off the skin. A fit without these says which
        // really are.
        let mut rigid = BTreeSet::new();
        for _ in 0..PASSES {
            let of_face: Vec<usize> = shown.iter().copied().filter(|m| !rigid.contains(m)).collect();
            let laid = self.lay(&of_face, posture)?;
            let place = |m: usize| laid.fit.motion.apply(self.at(m));
            let metres = self.face.metres_per_unit;
            let distance = |m: usize| self.skin.distance(place(m)) * metres;
            // Markers whose labels say so come first, then the farthest.
            let rank = |&m: &usize| (says_head(&self.take.labels[m]), distance(m), m);
            let mut off: Vec<(bool, f64, usize)> = shown.iter().map(rank).collect();
            off.retain(|(says, distance, m)| self.known[*m].is_none() && (*says || *distance > OFF_SKIN));
            off.sort_by(|a, b| b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)));
            let off: Vec<usize> = off.into_iter().map(|(_, _, m)| m).collect();
            // A cap may have markers that are far from the face's.
            let is_near = |m: &usize| place(*m).distance(self.skin.middle()) * metres < HEAD;
            let size = extent(shown.iter().map(|&m| self.at(m)));
            let is_of_head = |m: &usize| is_near(m) && moves_with(self.take, shown, *m, size);
            let near: Vec<usize> = others.iter().copied().filter(is_of_head).collect();
            let all = [shown, &near].concat();
            let candidates: Vec<usize> =
                off.iter().chain(&near).filter_map(|m| all.iter().position(|other| other == m)).collect();
            let found = rigid_set(&select(self.take, &all), &candidates);
            let mut now: BTreeSet<usize> = found.into_iter().map(|i| all[i]).collect();
            if shown.len() < now.iter().filter(|m| shown.contains(m)).count() + FEWEST {
                now.clear();
            }
            if now == rigid {
                return Ok(Cap { rigid, laid: Some(laid) });
            }
            rigid = now;
        }
        Ok(Cap { rigid, laid: None })
    }

    /// Gives markers that move otherwise than the examples do at their place a point at which they do.
    /// Returns which of the `on_skin` ones these are.
    fn move_by_motion(
        &mut self,
        on_skin: &[usize],
        rigid: &BTreeSet<usize>,
        onto_skin: &Similarity,
        placed: &[Placed],
    ) -> Vec<usize> {
        let Some(motions) = self.motions(on_skin, rigid, onto_skin) else { return Vec::new() };
        let points: Vec<SurfacePoint> = placed.iter().map(|placed| placed.point).collect();
        let found = by_motion::moved(self.skin, &points, &motions, self.face.metres_per_unit);
        let mut moved = Vec::new();
        for (i, (point, &m)) in found.into_iter().zip(on_skin).enumerate() {
            if point.is_some() && self.known[m].is_none() {
                self.known[m] = point;
                moved.push(i);
            }
        }
        moved
    }

    /// The displacements of the `on_skin` markers from their mean places in some frames, in mesh units.
    /// `None` if the head's motion is not found.
    fn motions(
        &self,
        on_skin: &[usize],
        rigid: &BTreeSet<usize>,
        onto_skin: &Similarity,
    ) -> Option<Vec<Vec<DVec3>>> {
        let columns: Vec<usize> = on_skin.iter().chain(rigid).copied().collect();
        let step = self.take.frames().div_ceil(COMPARED).max(1);
        // The frame that was laid comes last.
        let frames: Vec<usize> = (0..self.take.frames()).step_by(step).chain([self.frame]).collect();
        let at = |f: usize, m: usize| DVec3::from_array(self.take.positions[f * self.take.labels.len() + m]);
        let of_column = |m: &usize| frames.iter().map(|&f| at(f, *m)).collect();
        let mut tracks = Tracks { columns: columns.iter().map(of_column).collect(), rate: self.take.rate() };
        let mut onto_skin = *onto_skin;
        if !self.in_head_space {
            let face: Vec<usize> = (0..on_skin.len()).collect();
            let cap: Vec<usize> = (on_skin.len()..columns.len()).collect();
            let size = typical_extent(&tracks, &face);
            let labels: Vec<String> = columns.iter().map(|&m| self.take.labels[m].clone()).collect();
            let settings = Settings::default();
            let found = head_markers::find(&tracks, &face, &cap, &labels, &settings, size).ok()?;
            let head = head::stabilise(&tracks, &found.fitted, &found.stiff, &face, size, self.is_video)?;
            onto_skin = onto_skin.after(head.motions.last()?);
            for column in &mut tracks.columns {
                for (point, motion) in column.iter_mut().zip(&head.motions) {
                    *point = motion.inverse().apply(*point);
                }
            }
        }
        let all = 0..frames.len();
        let centred = |column: &Vec<DVec3>| -> Vec<DVec3> {
            let mean = mean(column, &all).unwrap_or(DVec3::NAN);
            column.iter().map(|p| onto_skin.scale * (onto_skin.rotation * (*p - mean))).collect()
        };
        Some(tracks.columns.iter().take(on_skin.len()).map(centred).collect())
    }

    /// Lays some markers over the skin in every orientation that fits.
    fn lay_all(&self, columns: &[usize]) -> Result<Vec<OntoSurface>> {
        let positions: Vec<DVec3> = columns.iter().map(|&m| self.at(m)).collect();
        self.skin.lay(&positions, self.metres, &self.known_of(columns))
    }

    /// Lays some markers over the skin, the right way up.
    fn lay(&self, columns: &[usize], posture: &Posture) -> Result<Laid> {
        // It takes up to some seconds.
        if self.progress.cancelled() {
            return Err(Error::Cancelled);
        }
        let mut laid = self.lay_all(columns)?;
        let known = Known {
            posture,
            columns,
            labels: columns.iter().map(|&m| self.take.labels[m].as_str()).collect(),
            axes: self.skin.axes(),
            middle: self.skin.middle(),
            metres_per_unit: self.face.metres_per_unit,
            in_head_space: self.in_head_space,
        };
        let distance = |fit: &OntoSurface, i: usize| match self.known[columns[i]] {
            Some(point) => self.skin.at(&point).distance(fit.points[i]),
            None => self.skin.distance(fit.points[i]),
        };
        let choice = choose(&laid, &known, &distance);
        Ok(Laid { fit: laid.swap_remove(choice.chosen), choice })
    }
}

/// Some columns of a take.
fn select(take: &Take, columns: &[usize]) -> Take {
    let count = take.labels.len();
    let frames = take.positions.chunks(count.max(1));
    Take {
        labels: columns.iter().map(|&m| take.labels[m].clone()).collect(),
        times: take.times.clone(),
        positions: frames.flat_map(|frame| columns.iter().map(|&m| frame[m])).collect(),
        head: None,
        confidence: None,
    }
}
