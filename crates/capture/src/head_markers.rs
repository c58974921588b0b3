//! The head's markers: the rigid set that travels with the face. A slate, a chair or another actor's cap is
//! rigid as well, but goes its own way.
use crate::head::{FACE_TOLERANCE, Fit, RIGID_TOLERANCE, fitted, thinned};
use crate::label_words::says_head;
use crate::rigid_sets::Distances;
use crate::settings::Settings;
use crate::tracks::{Tracks, median_point, seen};
use rhytid_core::text::bare_label;
use rhytid_core::text::listed;
use rhytid_core::{Error, InputErrorKind, Result};
use std::collections::BTreeSet;

/// The markers that show the head's motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeadMarkers {
    /// Markers on a cap or the like; empty where the face's own must do.
    pub rigid: Vec<usize>,
    /// The markers to fit the head's motion to: the rigid ones, and the face's stiff ones where the rigid
    /// ones are soft. Empty where there are no rigid ones.
    pub fitted: Vec<usize>,
    /// The face's markers that keep their distances best; all where none do.
    pub stiff: Vec<usize>,
    /// A sentence each.
    pub warnings: Vec<String>,
}

/// A pair of rigid markers keeps its distance within this part of the face's extent. The first one is usual,
/// the others are for head bands that give way.
const KEEPS: [f64; 3] = [0.0025, 0.005, 0.0075];

/// The steps in which the limit for the face's stiff markers grows, as parts of its extent.
const STIFF: [f64; 7] = [0.001, 0.00125, 0.0016, 0.002, 0.0025, 0.0032, 0.004];

/// As many of the face's markers are stiff at the least.
const FEWEST_STIFF: usize = 6;

/// The stiff markers span at least this part of the face's extent.
const STIFF_SPAN: f64 = 0.5;

/// Against a set that travels with the face, the face moves by at most this many times as much as against
/// its own fit …
const TRAVELS: f64 = 1.5;

/// … and by this part of its extent.
const SLACK: f64 = 0.003;

/// A fit to fewer markers of a face follows its expressions. Then there is more slack.
const FEW: usize = 12;

/// The slack for few markers.
const FEW_SLACK: f64 = 0.03;

/// As many sets are tried.
const MOST_SETS: usize = 100;

/// The frames in ten in which a marker must be near its usual place to count as still, and the part of the
/// face's markers that must be.
const STILL: [f64; 2] = [0.9, 0.25];

/// A rigid set that was tried.
struct Tried {
    columns: Vec<usize>,
    /// How far its distances vary.
    varies: f64,
    /// How far the face moves against it.
    left: f64,
    /// How far the face may move against it.
    limit: f64,
}

impl Tried {
    fn travels(&self) -> bool {
        self.left <= self.limit
    }
}

/// Finds the head's markers. `face` are the handles' columns, `candidates` those of no handle, and `extent`
/// is the face's.
///
/// # Errors
/// [`Error::Input`] if the settings name an unknown marker, or only one or two markers.
pub(crate) fn find(
    tracks: &Tracks,
    face: &[usize],
    candidates: &[usize],
    labels: &[String],
    settings: &Settings,
    extent: f64,
) -> Result<HeadMarkers> {
    let few = thinned(tracks);
    let own = fitted(&few, face, FACE_TOLERANCE * extent, false);
    let stiff = own.as_ref().and_then(|own| stiff(&few, face, own, extent));
    let stiff = stiff.unwrap_or_else(|| face.to_vec());
    let mut found = HeadMarkers { rigid: Vec::new(), fitted: Vec::new(), stiff, warnings: Vec::new() };
    let compared =
        |columns: Vec<usize>, varies: f64| tried(&few, columns, varies, face, own.as_deref(), extent);
    if let Some(named) = &settings.rigid {
        found.rigid = named_markers(named, labels, candidates)?;
        found.fitted.clone_from(&found.rigid);
        let given = compared(found.rigid.clone(), 0.0).filter(|given| !given.travels());
        found.warnings.extend(given.map(|given| {
            format!(
                "the given rigid markers do not travel with the face: {}; check that they are on the actor's \
                 head",
                percent_of(&given, extent)
            )
        }));
        return Ok(found);
    }
    let distances = Distances::new(&few, candidates);
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for keeps in KEEPS {
        for set in distances.sets(keeps * extent) {
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
    }
    let is_called_head = |columns: &[usize]| are_called_head(columns, labels);
    let columns = |set: &Vec<usize>| set.iter().map(|&i| distances.columns[i]).collect::<Vec<_>>();
    // Stable: the stiffer sets of a size stay first.
    sets.sort_by_key(|set| (!is_called_head(&columns(set)), std::cmp::Reverse(set.len())));
    sets.truncate(MOST_SETS);
    let all: Vec<Tried> =
        sets.iter().filter_map(|set| compared(columns(set), distances.variation(set))).collect();
    // Sets whose labels say so come first, then the one against which the face moves least.
    let best = all.iter().filter(|set| set.travels()).min_by(|a, b| {
        let is_called = [a, b].map(|set| is_called_head(&set.columns));
        is_called[1].cmp(&is_called[0]).then(a.left.total_cmp(&b.left))
    });
    if let Some(best) = best {
        found.rigid.clone_from(&best.columns);
        found.fitted.clone_from(&best.columns);
        if best.varies > KEEPS[0] * extent {
            // A head band that gives way shows less of the head's motion than it does with the face's help.
            if found.stiff.len() < face.len() {
                found.fitted.extend(&found.stiff);
            }
            found.warnings.push(format!(
                "the head's markers {} are not quite rigid: their distances vary by {:.1} % of the face's size; \
                 say which markers are rigid if these are not on a cap or a head band",
                names(&best.columns, labels),
                100.0 * best.varies / extent
            ));
        }
    }
    found.warnings.extend(not_used(&all, &found.rigid, candidates, labels, &distances, extent));
    Ok(found)
}

/// Whether the labels of most of these columns say that they are on the head.
pub(crate) fn are_called_head(columns: &[usize], labels: &[String]) -> bool {
    2 * columns.iter().filter(|&&c| says_head(&labels[c])).count() > columns.len()
}

/// What there is to say of markers that seem to be on the head, and are not used.
fn not_used(
    all: &[Tried],
    used: &[usize],
    candidates: &[usize],
    labels: &[String],
    distances: &Distances,
    extent: f64,
) -> Option<String> {
    let called: Vec<usize> = candidates.iter().copied().filter(|&c| says_head(&labels[c])).collect();
    let lacks = called.len() >= 3 && !used.iter().any(|c| called.contains(c));
    let worst = |sets: &mut dyn Iterator<Item = &Tried>| {
        sets.min_by(|a, b| a.left.total_cmp(&b.left)).map(|set| percent_of(set, extent))
    };
    if lacks {
        let mut sets = all.iter().filter(|set| set.columns.iter().any(|c| called.contains(c)));
        let why = worst(&mut sets).map_or_else(
            || {
                let of_cap = |i: &usize| called.contains(&distances.columns[*i]);
                let set: Vec<usize> = (0..distances.columns.len()).filter(of_cap).collect();
                let varies = distances.variation(&set);
                if varies == 0.0 {
                    return "are hardly ever seen together".to_owned();
                }
                format!(
                    "do not keep their distances: these vary by {:.1} % of the face's size",
                    100.0 * varies / extent
                )
            },
            |why| format!("do not travel with the face: {why}"),
        );
        return Some(format!(
            "the markers {} are named like those of a cap, but {why}; the head's motion does not come from \
             them; say which markers are rigid if these are",
            names(&called, labels)
        ));
    }
    let refused: BTreeSet<usize> = all.iter().flat_map(|set| set.columns.iter().copied()).collect();
    if !used.is_empty() || refused.is_empty() {
        return None;
    }
    let refused: Vec<usize> = refused.into_iter().collect();
    Some(format!(
        "the markers {} keep their distances, but do not travel with the face: {}; the head's motion comes from \
         the face's markers",
        names(&refused, labels),
        worst(&mut all.iter())?
    ))
}

fn names(columns: &[usize], labels: &[String]) -> String {
    let names: Vec<&str> = columns.iter().map(|&c| labels[c].as_str()).collect();
    listed(names.into_iter())
}

fn percent_of(set: &Tried, extent: f64) -> String {
    let [left, limit] = [set.left, set.limit].map(|x| 100.0 * x / extent);
    format!("against them it moves by {left:.1} % of its size, expected {limit:.1} % or less")
}

/// The columns of the markers that the settings name. A name without its prefix will do.
fn named_markers(named: &[String], labels: &[String], candidates: &[usize]) -> Result<Vec<usize>> {
    if named.len() == 1 || named.len() == 2 {
        return Err(Error::out_of_range(format!(
            "{} rigid markers are given, expected at least 3, or none to use the whole face",
            named.len()
        )));
    }
    let column = |name: &String| {
        let mut behind_a_prefix =
            candidates.iter().copied().filter(|&c| bare_label(&labels[c]) == bare_label(name));
        let place = labels.iter().position(|label| label == name).or_else(|| behind_a_prefix.next());
        place.ok_or_else(|| {
            Error::input(format!("the rigid marker “{name}” is not in the file"))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![name.clone()] })
        })
    };
    named.iter().map(column).collect()
}

/// The stiffest of the face's markers that span it. `own` is the fit to all.
fn stiff(few: &Tracks, face: &[usize], own: &[Fit], extent: f64) -> Option<Vec<usize>> {
    if face.len() < FEW {
        return None;
    }
    let distances = Distances::new(few, face);
    for keeps in STIFF {
        let mut sets = distances.sets(keeps * extent);
        sets.retain(|set| set.len() >= FEWEST_STIFF && distances.span(set) > STIFF_SPAN * extent);
        sets.sort_by_key(|set| std::cmp::Reverse(set.len()));
        for set in sets.iter().take(4) {
            let columns: Vec<usize> = set.iter().map(|&i| distances.columns[i]).collect();
            let found = tried(few, columns, 0.0, face, Some(own), extent);
            if let Some(found) = found.filter(Tried::travels) {
                return Some(found.columns);
            }
        }
    }
    None
}

/// Compares the motion of `columns` with the face's `own`. `None` where they have no motion.
fn tried(
    few: &Tracks,
    columns: Vec<usize>,
    varies: f64,
    face: &[usize],
    own: Option<&[Fit]>,
    extent: f64,
) -> Option<Tried> {
    let fits = fitted(few, &columns, RIGID_TOLERANCE * extent, false)?;
    // Where the face has no fit of its own, there is nothing to compare with.
    let Some(own) = own else { return Some(Tried { columns, varies, left: 0.0, limit: 0.0 }) };
    // Only frames that both explain are compared.
    let both = |(own, fit): (&Fit, &Fit)| fit.and(*own);
    let own: Vec<Fit> = own.iter().zip(&fits).map(both).collect();
    let slack = if face.len() < FEW { FEW_SLACK } else { SLACK };
    let limit = TRAVELS * left(few, &own, face)? + slack * extent;
    Some(Tried { left: left(few, &fits, face)?, columns, varies, limit })
}

/// How far the face's stillest markers move once this motion is taken out.
fn left(few: &Tracks, fits: &[Fit], face: &[usize]) -> Option<f64> {
    let mut of_markers = Vec::with_capacity(face.len());
    for &c in face {
        let frames = few.columns[c].iter().zip(fits);
        let mut points = Vec::with_capacity(few.frames());
        for (p, fit) in frames {
            if let Some((motion, _)) = fit
                && seen(*p)
            {
                points.push(motion.inverse().apply(*p));
            }
        }
        let middle = median_point(points.iter().copied());
        let mut off: Vec<f64> = points.iter().map(|p| p.distance(middle)).collect();
        of_markers.extend(quantile(&mut off, STILL[0]));
    }
    quantile(&mut of_markers, STILL[1])
}

/// The value below which this part of the values is; `None` without values.
fn quantile(values: &mut [f64], part: f64) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let place = (part * (values.len() - 1) as f64).round() as usize;
    Some(*values.select_nth_unstable_by(place, f64::total_cmp).1)
}
