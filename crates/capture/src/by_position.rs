//! Finds each handle's marker by its position on the face, where the names do not match.
use crate::handles::{HandleSettings, place_handles};
use crate::handles_in_frame::POOR;
use crate::labels::{is_unlabelled, same_names};
use crate::subjects::{self, ambiguous};
use crate::tracks::median_point;
use glam::DVec3;
use rhytid_core::{Error, Face, Handles, Mesh, Progress, RawTake, Result, Rig, Settings, Take};
use std::collections::{BTreeMap, HashSet};

/// A handle and the marker that probably belongs to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Match {
    /// The handle's label.
    pub handle: String,
    /// The marker's label in the file; `None` where no marker is near, or where two fit about equally well.
    pub marker: Option<String>,
    /// Distance of the marker from the handle after the markers were laid on the face, in millimetres; NaN
    /// without a marker.
    pub distance_mm: f64,
    /// How clearly this marker is the best one. 1: no other handle or marker is near. 0: another handle or
    /// marker fits as well.
    pub sure: f64,
}

/// A marker that is farther from a handle than this part of the handles' extent does not belong to it.
const MAX_DISTANCE: f64 = 0.1;

/// A match that is less sure than this is left out.
const LEAST_SURE: f64 = 0.1;

/// Neighbours whose median offset estimates how the actor's face differs there.
const NEIGHBOURS: usize = 6;

/// Rounds of matching. After each round the neighbours' offsets are taken out.
const PASSES: usize = 4;

/// A marker is seen in at least this part of the frames, or it is not matched.
const SELDOM: f64 = 0.05;

/// A match for each handle, in the rig's order. `map` (handle → label) comes first, then equal names, then
/// positions. A frame of the take is laid over the rest pose as [`place_handles`] does it. `subject` is as in
/// [`same_names`].
///
/// # Errors
/// As [`same_names`] and [`place_handles`]; [`Error::Input`] if the markers do not fit the face, or if more
/// than one subject has enough markers for a face.
pub fn match_by_position(
    rig: &Rig,
    raw: &RawTake,
    map: &BTreeMap<String, String>,
    subject: Option<&str>,
    progress: &dyn Progress,
) -> Result<Vec<Match>> {
    let raw = &usable(&rig.handles().labels, raw, map, subject)?;
    let labels = &raw.tracks.labels;
    let named = same_names(&rig.handles().labels, labels, map, subject)?;
    let face = face_of(rig);
    let pairs = named
        .iter()
        .zip(&rig.handles().points)
        .filter_map(|(column, point)| Some((labels[(*column)?].clone(), *point)));
    let settings = HandleSettings { known: pairs.collect(), ..HandleSettings::default() };
    let laid = place_handles(&face, raw, &settings, progress)?;
    if laid.cost > POOR {
        return Err(misfit());
    }
    let rest = |h: usize| DVec3::from_array(rig.handles().rest[h].map(f64::from));
    let handles: Vec<DVec3> = (0..rig.handles().labels.len()).map(rest).collect();
    let markers: Vec<DVec3> = laid.markers.iter().copied().map(DVec3::from_array).collect();
    let extent = crate::tracks::extent(handles.iter().copied());
    let place = |column: usize| laid.handles.labels.iter().position(|label| *label == labels[column]);
    let fixed: Vec<Option<usize>> = named.iter().map(|column| column.and_then(place)).collect();
    let mut shifted = markers.clone();
    let mut matched = assigned(&handles, &shifted, &fixed, MAX_DISTANCE * extent);
    for _ in 1..PASSES {
        // Neighbouring markers are off by similar vectors where an actor's face is longer or wider.
        let off: Vec<(DVec3, DVec3)> = matched
            .iter()
            .enumerate()
            .filter_map(|(h, m)| Some((handles[h], handles[h] - markers[(*m)?])))
            .collect();
        if off.is_empty() {
            break;
        }
        for (at, marker) in shifted.iter_mut().zip(&markers) {
            let mut near: Vec<&(DVec3, DVec3)> = off.iter().collect();
            near.sort_by(|a, b| a.0.distance_squared(*marker).total_cmp(&b.0.distance_squared(*marker)));
            *at = *marker + median_point(near.iter().take(NEIGHBOURS).map(|(_, off)| *off));
        }
        matched = assigned(&handles, &shifted, &fixed, MAX_DISTANCE * extent);
    }
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let of_handle = |h: usize| {
        let handle = rig.handles().labels[h].clone();
        let Some(m) = matched[h] else {
            return Match { handle, marker: None, distance_mm: f64::NAN, sure: 0.0 };
        };
        let distance = handles[h].distance(shifted[m]);
        let others = (0..shifted.len()).filter(|&o| o != m).map(|o| handles[h].distance(shifted[o]));
        let rivals = (0..handles.len()).filter(|&o| o != h).map(|o| handles[o].distance(shifted[m]));
        let next = others.chain(rivals).fold(f64::INFINITY, f64::min);
        let sure = if fixed[h].is_some() { 1.0 } else { (1.0 - distance / next).max(0.0) };
        if sure < LEAST_SURE {
            return Match { handle, marker: None, distance_mm: f64::NAN, sure };
        }
        let distance_mm = handles[h].distance(markers[m]) * millimetres;
        Match { handle, marker: Some(laid.handles.labels[m].clone()), distance_mm, sure }
    };
    let found: Vec<Match> = (0..handles.len()).map(of_handle).collect();
    if 2 * found.iter().filter(|m| m.marker.is_some()).count() < handles.len().min(labels.len()) {
        return Err(misfit());
    }
    Ok(found)
}

/// The take without the markers that cannot be the face's: those of other subjects, those that are hardly
/// ever seen, and those without a name where there are names enough.
fn usable(
    handles: &[String],
    raw: &RawTake,
    map: &BTreeMap<String, String>,
    subject: Option<&str>,
) -> Result<RawTake> {
    let take = &raw.tracks;
    let (count, enough) = (take.labels.len(), handles.len().div_ceil(2).max(4));
    let parts = subjects::parted(handles, &take.labels);
    let mut sizes: BTreeMap<&str, usize> = BTreeMap::new();
    for part in parts.iter().filter_map(|part| part.subject.as_deref()) {
        *sizes.entry(part).or_default() += 1;
    }
    sizes.retain(|_, size| *size >= enough);
    let mapped: HashSet<&String> = map.values().collect();
    if subject.is_none() && mapped.is_empty() && sizes.len() > 1 {
        return Err(ambiguous(sizes.iter().map(|(subject, size)| (Some(*subject), *size))));
    }
    let with_name = take.labels.iter().filter(|label| !is_unlabelled(label)).count();
    let is_usable = |c: usize| {
        let label = &take.labels[c];
        let of_subject = match (subject, &parts[c].subject) {
            (Some(wanted), Some(found)) => subjects::is_called(found, wanted),
            _ => true,
        };
        let seen = take.positions.iter().skip(c).step_by(count).filter(|p| !p[0].is_nan()).count();
        let is_seldom = (seen as f64) < SELDOM * take.frames() as f64;
        let is_nameless = with_name >= enough && is_unlabelled(label);
        mapped.contains(label) || of_subject && !is_seldom && !is_nameless
    };
    let columns: Vec<usize> = (0..count).filter(|&c| is_usable(c)).collect();
    let mut positions = Vec::with_capacity(columns.len() * take.frames());
    for frame in take.positions.chunks_exact(count.max(1)) {
        positions.extend(columns.iter().map(|&c| frame[c]));
    }
    let labels = columns.iter().map(|&c| take.labels[c].clone()).collect();
    let tracks = Take { labels, times: take.times.clone(), positions, ..Take::default() };
    Ok(RawTake {
        tracks,
        metres_per_unit: raw.metres_per_unit,
        in_head_space: raw.in_head_space,
        is_video: raw.is_video,
        ..RawTake::default()
    })
}

fn misfit() -> Error {
    Error::no_fit("the markers do not fit the rig's face: say which marker belongs to which handle")
}

/// The rig as a face without examples.
fn face_of(rig: &Rig) -> Face {
    Face {
        name: rig.surface().name.clone(),
        neutral: Mesh {
            positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
            faces: rig.surface().faces.clone(),
            uvs: None,
            materials: None,
        },
        metres_per_unit: rig.surface().metres_per_unit,
        up_axis: rig.surface().up_axis,
        handles: Handles { labels: rig.handles().labels.clone(), points: rig.handles().points.clone() },
        examples: Vec::new(),
        prior: None,
        settings: Settings::default(),
    }
}

/// A marker for each handle, each marker at most once. The nearest pairs are matched first. Then two handles
/// exchange markers as long as the sum of squared distances falls.
fn assigned(handles: &[DVec3], markers: &[DVec3], fixed: &[Option<usize>], far: f64) -> Vec<Option<usize>> {
    let mut matched = fixed.to_vec();
    let mut free = vec![true; markers.len()];
    fixed.iter().flatten().for_each(|&m| free[m] = false);
    let square = |h: usize, m: usize| handles[h].distance_squared(markers[m]);
    let mut pairs: Vec<(f64, usize, usize)> = (0..handles.len())
        .filter(|&h| fixed[h].is_none())
        .flat_map(|h| (0..markers.len()).map(move |m| (h, m)))
        .map(|(h, m)| (square(h, m), h, m))
        .filter(|(square, _, m)| free[*m] && *square < far * far)
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, h, m) in pairs {
        if matched[h].is_none() && free[m] {
            matched[h] = Some(m);
            free[m] = false;
        }
    }
    let movable: Vec<usize> =
        (0..handles.len()).filter(|&h| fixed[h].is_none() && matched[h].is_some()).collect();
    loop {
        let mut changed = false;
        for (i, &a) in movable.iter().enumerate() {
            for &b in &movable[i + 1..] {
                let (Some(m), Some(n)) = (matched[a], matched[b]) else { continue };
                if square(a, n) + square(b, m) < square(a, m) + square(b, n) {
                    (matched[a], matched[b]) = (Some(n), Some(m));
                    changed = true;
                }
            }
        }
        if !changed {
            return matched;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_marker_is_given_once_and_to_the_nearest() {
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        let handles = [at(0.0), at(1.0), at(2.0), at(9.0)];
        let markers = [at(2.4), at(1.4), at(0.6)];
        assert_eq!(assigned(&handles, &markers, &[None; 4], 3.0), [Some(2), Some(1), Some(0), None]);
        let fixed = [Some(1), None, None, None];
        assert_eq!(assigned(&handles, &markers, &fixed, 3.0), [Some(1), Some(2), Some(0), None]);
    }
}
