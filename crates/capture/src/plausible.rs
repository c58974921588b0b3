//! The gate behind the clean-up: a result that no face can have.
use crate::neighbours::nearest;
use crate::target::Target;
use crate::tracks::{Tracks, extent};
use rayon::prelude::*;
use rhytid_core::{Error, Remedy, human};

/// No marker goes so far from its place at rest, in extents of the face. The open jaw goes 0.2.
const FARTHEST: f64 = 1.0;

/// No marker is farther than this for long.
const FAR: f64 = 0.5;

/// More than this part of the frames is long. Labels that are swapped across the face for a while are not.
const LONG: f64 = 0.1;

/// No skin between neighbours stretches by so much: 1 is twice the length at rest.
const STRETCH: f64 = 100.0;

/// Neighbours of each marker.
const NEIGHBOURS: usize = 4;

/// Markers that an error names.
const NAMED: usize = 4;

/// What a marker does that is wrong.
struct Wrong {
    marker: usize,
    /// The largest displacement, in the target's unit.
    distance: f64,
    /// The largest strain to a neighbour.
    strain: f64,
    /// The frame of the largest displacement, or else of the largest strain.
    frame: usize,
}

/// An error that names the markers with displacements that no face has. `None` if there are none. Where the
/// displacements contain more than the face's motion, as the head's, `moves_alone` is false, and only strains
/// count.
pub(crate) fn implausible(displacements: &Tracks, target: &Target, moves_alone: bool) -> Option<Error> {
    let extent = extent(target.rest.iter().copied());
    let neighbours = nearest(&target.rest, NEIGHBOURS);
    let of_marker = |j: usize| wrong(displacements, target, j, &neighbours[j], extent, moves_alone);
    let mut all: Vec<Wrong> = (0..target.rest.len()).into_par_iter().filter_map(of_marker).collect();
    // Stable: equals stay in the order of the handles.
    all.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    if all.is_empty() {
        return None;
    }
    let named: Vec<String> = all.iter().take(NAMED).map(|wrong| words(wrong, target, moves_alone)).collect();
    let more = match all.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!("; and {} more", human::count(more)),
    };
    Some(
        Error::no_fit(format!(
            "the cleaned take cannot be a face's: {}{more}; check the file's unit and axes, the labels of these \
             markers, the rigid markers, and whether numbers such as 0 or 9999 stand for points that were not \
             seen",
            named.join("; ")
        ))
        .with_remedies(&[Remedy::KeepImplausible]),
    )
}

fn wrong(
    displacements: &Tracks,
    target: &Target,
    marker: usize,
    neighbours: &[usize],
    extent: f64,
    moves_alone: bool,
) -> Option<Wrong> {
    let column = &displacements.columns[marker];
    let (mut farthest, mut far, mut strain) = ((0.0, 0), 0_usize, (0.0, 0));
    for (f, displacement) in column.iter().enumerate() {
        let distance = displacement.length();
        far += usize::from(distance > FAR * extent);
        if distance > farthest.0 {
            farthest = (distance, f);
        }
        let here = target.rest[marker] + *displacement;
        for &other in neighbours {
            let there = target.rest[other] + displacements.columns[other][f];
            let found = here.distance(there) / target.rest[marker].distance(target.rest[other]) - 1.0;
            if found > strain.0 && found.is_finite() {
                strain = (found, f);
            }
        }
    }
    let is_long = far as f64 > LONG * column.len() as f64;
    let moves = moves_alone && (farthest.0 > FARTHEST * extent || is_long);
    if !moves && strain.0 <= STRETCH {
        return None;
    }
    let frame = if moves { farthest.1 } else { strain.1 };
    Some(Wrong { marker, distance: farthest.0, strain: strain.0, frame })
}

fn words(wrong: &Wrong, target: &Target, moves_alone: bool) -> String {
    let label = &target.labels[wrong.marker];
    let distance = wrong.distance * target.millimetres();
    if moves_alone && wrong.strain <= STRETCH {
        return format!("{label} is {distance:.0} mm from its place at rest in frame {}", wrong.frame);
    }
    let strain = human::percent(wrong.strain, 0);
    if moves_alone {
        return format!(
            "{label} is {distance:.0} mm from its place at rest in frame {}, and the skin to a neighbour is \
             stretched by {strain}",
            wrong.frame
        );
    }
    format!("the skin from {label} to a neighbour is stretched by {strain} in frame {}", wrong.frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Twenty-five handles 2 cm apart, whose jaw opens by 4 cm and more.
    fn face() -> (Tracks, Target) {
        let rest: Vec<DVec3> =
            (0..25).map(|i| DVec3::new(f64::from(i % 5), f64::from(i / 5), 0.0) * 2.0).collect();
        let column = |at: &DVec3| {
            let reach = (4.0 - at.y).max(0.0);
            (0..200).map(|f| DVec3::Y * -reach * (f64::from(f) * 0.1).sin().max(0.0)).collect()
        };
        let columns = rest.iter().map(column).collect();
        let labels = (0..25).map(|i| format!("m{i}")).collect();
        let target = Target { labels, rest, metres_per_unit: 0.01, strains: vec![], examples: vec![] };
        (Tracks { columns, rate: 100.0 }, target)
    }

    fn said(tracks: &Tracks, target: &Target, moves_alone: bool) -> Option<String> {
        implausible(tracks, target, moves_alone).map(|error| error.to_string())
    }

    #[test]
    fn a_face_passes_and_gaps_are_nothing() {
        let (mut tracks, target) = face();
        tracks.columns[3][20..40].fill(DVec3::NAN);
        assert_eq!(said(&tracks, &target, true), None);
    }

    #[test]
    fn metres_in_one_frame_and_half_a_face_for_long() {
        let (mut tracks, target) = face();
        // The extent is 11.3 cm.
        tracks.columns[7][33] += DVec3::Z * 12.0;
        let words = said(&tracks, &target, true).unwrap();
        assert!(
            words.contains("face's: m7 is 12") && words.contains("mm from its place at rest in frame 33;"),
            "{words}"
        );
        let (mut tracks, target) = face();
        tracks.columns[7][60..64].iter_mut().for_each(|p| *p += DVec3::Z * 6.0);
        assert_eq!(said(&tracks, &target, true), None);
        let (mut tracks, target) = face();
        tracks.columns[7][60..90].iter_mut().for_each(|p| *p += DVec3::Z * 6.0);
        assert!(said(&tracks, &target, true).unwrap().contains("face's: m7 is"), "half a face away for long");
    }

    #[test]
    fn with_the_heads_motion_only_strains_count() {
        let (mut tracks, target) = face();
        tracks.columns.iter_mut().flatten().for_each(|p| *p += DVec3::X * 150.0);
        assert_eq!(said(&tracks, &target, false), None);
        tracks.columns[7][12] += DVec3::X * 210.0;
        let words = said(&tracks, &target, false).unwrap();
        assert!(
            words.contains("m7 to a neighbour is stretched by") && words.contains("in frame 12"),
            "{words}"
        );
    }
}
