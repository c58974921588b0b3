//! Columns of a file that are no measured marker: seen too seldom, always in one place, or without a name.
use crate::labels::{Matched, is_unlabelled};
use crate::tracks::{Tracks, seen};
use rhytid_core::text::listed;

/// A marker is seen in at least this part of the frames in which the face is seen.
const SELDOM: f64 = 0.05;

/// A marker that is in exactly one place in so many frames or more was not measured.
const STILL_FRAMES: usize = 20;

/// Takes the markers that were not measured out of the handles' columns and out of those that may be on the
/// head. `labels` are the file's. In a take `in_head_space`, the bridge of the nose may well be in one place
/// in all frames. Returns what there is to say of handles' markers.
pub(crate) fn leave_out(
    matched: &mut Matched,
    tracks: &Tracks,
    labels: &[String],
    in_head_space: bool,
) -> Vec<String> {
    let columns: Vec<usize> = matched.columns.iter().copied().flatten().collect();
    let shown = (0..tracks.frames()).filter(|&f| columns.iter().any(|&c| seen(tracks.columns[c][f]))).count();
    let seen_in = |c: usize| tracks.columns[c].iter().filter(|p| seen(**p)).count();
    let is_seldom = |c: usize| (seen_in(c) as f64) < SELDOM * shown as f64;
    let is_still = |c: usize| {
        let mut points = tracks.columns[c].iter().filter(|p| seen(**p));
        let first = points.next();
        first.is_some() && points.clone().count() + 1 >= STILL_FRAMES && points.all(|p| Some(p) == first)
    };
    // A take that is made by a program may hold a whole face in exactly one place.
    let still = columns.iter().filter(|&&c| is_still(c)).count();
    let stands_still = |c: usize| !in_head_space && 10 * still < columns.len() && is_still(c);
    // Where a handle's marker has no name, all were matched by position, and no name means nothing.
    let has_names = !columns.iter().any(|&c| is_unlabelled(&labels[c]));
    let (mut seldom, mut constant) = (Vec::new(), Vec::new());
    for column in &mut matched.columns {
        let Some(c) = *column else { continue };
        if stands_still(c) {
            constant.push(labels[c].as_str());
        } else if seen_in(c) > 0 && is_seldom(c) {
            seldom.push(labels[c].as_str());
        } else {
            continue;
        }
        *column = None;
        matched.left_out.push(c);
    }
    let (kept, left_out): (Vec<usize>, Vec<usize>) =
        matched.others.iter().partition(|&&c| !(is_seldom(c) || has_names && is_unlabelled(&labels[c])));
    matched.others = kept;
    matched.left_out.extend(left_out);
    matched.left_out.sort_unstable();
    let mut said = Vec::new();
    if !seldom.is_empty() {
        said.push(format!(
            "{} of the handles' markers are seen in less than a twentieth of the frames and are not used: {}",
            seldom.len(),
            listed(seldom.into_iter())
        ));
    }
    if !constant.is_empty() {
        said.push(format!(
            "{} of the handles' markers are in exactly one place in all frames, so that they were not measured, \
             and are not used: {}",
            constant.len(),
            listed(constant.into_iter())
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn each_reason_and_what_is_kept() {
        let moving =
            |c: usize| (0..200_u32).map(|f| DVec3::new(f64::from(f), c as f64, 0.0)).collect::<Vec<_>>();
        let mut columns: Vec<Vec<DVec3>> = (0..16).map(moving).collect();
        columns[1][9..].fill(DVec3::NAN);
        columns[2].fill(DVec3::ZERO);
        columns[13][3..].fill(DVec3::NAN);
        let tracks = Tracks { columns, rate: 100.0 };
        let mut labels: Vec<String> = (0..16).map(|c| format!("m{c}")).collect();
        labels[12] = "*7".into();
        let matched = Matched {
            columns: (0..12).map(Some).chain([None]).collect(),
            others: vec![12, 13, 14, 15],
            ..Matched::default()
        };
        let mut found = matched.clone();
        let said = leave_out(&mut found, &tracks, &labels, false);
        let mut columns = matched.columns.clone();
        (columns[1], columns[2]) = (None, None);
        assert_eq!(
            (found.columns, found.others, found.left_out),
            (columns, vec![14, 15], vec![1, 2, 12, 13])
        );
        assert!(said[0].starts_with("1 of") && said[0].ends_with("\"m1\""), "{said:?}");
        assert!(said[1].starts_with("1 of") && said[1].ends_with("\"m2\""), "{said:?}");
        // In head space a marker may stand still.
        let mut found = matched.clone();
        let said = leave_out(&mut found, &tracks, &labels, true);
        assert_eq!((found.columns[2], found.left_out, said.len()), (Some(2), vec![1, 12, 13], 1), "{said:?}");
        // Without any name, names mean nothing.
        labels.iter_mut().for_each(|label| *label = "*7".into());
        let mut found = matched;
        leave_out(&mut found, &tracks, &labels, false);
        assert_eq!(found.others, [12, 14, 15]);
    }
}
