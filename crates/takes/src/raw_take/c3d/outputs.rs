//! Points of a C3D file that are no markers. Vicon's programs store what a model computes as points: joint
//! angles, forces, virtual points. Parameters beside the labels list their labels.
use super::super::labels;
use super::MOST_PARTS;
use super::parameters::Parameters;
use rhytid_core::{Error, Result};
use std::collections::HashMap;

/// The parameters that list labels of computed points. POINT:TYPE_GROUPS may name more.
const LISTS: [&str; 8] =
    ["ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS", VIRTUAL, "MODELLED_MARKERS"];

/// Positions that a model computes from markers.
const VIRTUAL: &str = "MODELED_MARKERS";

/// Parameters that are about all points, though POINT:TYPE_GROUPS may name them.
const OF_MARKERS: [&str; 4] = ["LABELS", "DESCRIPTIONS", "UNITS", "MARKERS"];

/// Whether each point is a marker; the others are named in a warning. If a file has nothing but virtual
/// points, they count as markers.
///
/// # Errors
/// What is wrong, without the file's name, if the file has nothing but computed points.
pub(super) fn markers(
    parameters: &Parameters<'_>,
    names: &[String],
    warnings: &mut Vec<String>,
) -> Result<Vec<bool>> {
    let mut lists: Vec<String> = LISTS.map(str::to_owned).to_vec();
    for group in texts(parameters, "TYPE_GROUPS") {
        let group = group.to_ascii_uppercase();
        let is_of_markers = OF_MARKERS.contains(&group.as_str()) || group.ends_with("_UNITS");
        if !group.is_empty() && !is_of_markers && !lists.contains(&group) && lists.len() < MOST_LISTS {
            lists.push(group);
        }
    }
    let mut list_of: HashMap<String, usize> = HashMap::new();
    for (list, name) in lists.iter().enumerate() {
        // The lists go on in ANGLES2, ANGLES3 and so on, as the labels do.
        for part in 1..=MOST_PARTS {
            let name = if part == 1 { name.clone() } else { format!("{name}{part}") };
            if parameters.texts("POINT", &name).is_none() {
                break;
            }
            list_of.extend(
                texts(parameters, &name).filter(|label| !label.is_empty()).map(|label| (label, list)),
            );
        }
    }
    let found: Vec<Option<usize>> = names.iter().map(|name| list_of.get(name).copied()).collect();
    let is_virtual = |list: &Option<usize>| list.is_some_and(|list| lists[list] == VIRTUAL);
    let count = |is: &dyn Fn(&Option<usize>) -> bool| found.iter().filter(|list| is(list)).count();
    let left = count(&|list| list.is_none());
    if left == found.len() {
        return Ok(vec![true; found.len()]);
    }
    let said: Vec<String> = (0..lists.len())
        .map(|list| (count(&|found| *found == Some(list)), &lists[list]))
        .filter(|(points, _)| *points > 0)
        .map(|(points, list)| format!("{points} by POINT:{list}"))
        .collect();
    let said = said.join(", ");
    if left > 0 {
        warnings.push(format!(
            "{} of {} points are computed by a model and no markers; they are left out: {said}",
            found.len() - left,
            found.len()
        ));
        return Ok(found.iter().map(Option::is_none).collect());
    }
    if found.iter().any(is_virtual) {
        warnings.push(format!("every point is computed by a model ({said}); the virtual points are read"));
        return Ok(found.iter().map(is_virtual).collect());
    }
    Err(Error::empty(format!(
        "has no markers: its {} points are computed by a model ({said}); export the labelled trajectories too",
        found.len()
    )))
}

/// The most lists; a file could name any number.
const MOST_LISTS: usize = 32;

fn texts(parameters: &Parameters<'_>, name: &str) -> impl Iterator<Item = String> {
    parameters.texts("POINT", name).unwrap_or_default().into_iter().map(labels::text)
}
