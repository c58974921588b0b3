//! The columns of a take, by the names in its header.

use super::{confidence, head};
use crate::tables::rows::Rows;
use rhytid_core::text::did_you_mean;
use rhytid_core::text::listed;
use rhytid_core::text::quoted;
use rhytid_core::{InputErrorKind, Result};
use std::collections::{BTreeMap, HashMap, HashSet};

/// The endings of a label's columns.
pub(super) const AXES: [&str; 3] = ["_x", "_y", "_z"];

/// The places of the columns in a row.
pub(super) struct Columns {
    pub(super) time: usize,
    pub(super) labels: Vec<String>,
    /// x, y and z of each label.
    pub(super) markers: Vec<[usize; 3]>,
    pub(super) head: Option<[usize; 7]>,
    /// For each label.
    pub(super) confidence: Vec<Option<usize>>,
}

/// Finds the columns of the `wanted` labels, or of all.
pub(super) fn match_columns(rows: &Rows<'_>, name: &str, wanted: Option<&[String]>) -> Result<Columns> {
    let header = sort_header(rows, wanted)?;
    let head = head::complete(rows, header.head)?;
    let time = header.time.ok_or_else(|| {
        rows.error(&format!(
            "the header has no column \"time\"{}, expected time,LABEL_x,LABEL_y,LABEL_z,…",
            did_you_mean("time", rows.header().iter().map(String::as_str))
        ))
    })?;
    let kept: Vec<&str> = match wanted {
        Some(wanted) => wanted.iter().map(String::as_str).collect(),
        None => header.labels.clone(),
    };
    if kept.is_empty() {
        return Err(rows
            .error("the header has no markers, expected LABEL_x,LABEL_y,LABEL_z for each")
            .of_kind(InputErrorKind::Empty));
    }
    let mut complete = Vec::with_capacity(kept.len());
    let (mut lacking, mut labels) = (Vec::new(), Vec::new());
    for label in &kept {
        let before = lacking.len();
        match header.markers.get(label) {
            Some(&[Some(x), Some(y), Some(z)]) => complete.push([x, y, z]),
            Some(axes) => lacking.push(format!("{} (lacks {})", quoted(label), lacking_columns(label, axes))),
            None => lacking.push(quoted(label) + &did_you_mean(label, header.labels.iter().copied())),
        }
        labels.extend((lacking.len() > before).then(|| (*label).to_owned()));
    }
    if !lacking.is_empty() {
        return Err(rows.error(&format!(
            "{} of the {} {} missing from the header: {}; each needs its columns LABEL_x, LABEL_y and LABEL_z",
            lacking.len(),
            kept.len(),
            if wanted.is_some() { "handles are" } else { "labels have columns" },
            lacking.join(", ")
        )).of_kind(InputErrorKind::MissingMarkers { labels }));
    }
    let confidence = confidence_columns(rows, &header, &kept, wanted.is_some())?;
    if wanted.is_some() {
        let kept: HashSet<&str> = kept.iter().copied().collect();
        let of_no_marker = confidence_of_no_marker(rows, &header);
        let labels = header.labels.iter().copied().filter(|label| !kept.contains(label));
        let ignored: Vec<&str> = labels.chain(header.others.iter().copied()).chain(of_no_marker).collect();
        if !ignored.is_empty() {
            let listed = listed(ignored.iter().copied());
            log::warn!("{name}: columns of no handle are left out ({} labels): {listed}", ignored.len());
        }
    }
    Ok(Columns {
        time,
        labels: kept.into_iter().map(str::to_owned).collect(),
        markers: complete,
        head,
        confidence,
    })
}

/// The meaning of the columns of a header.
#[derive(Default)]
struct Header<'a> {
    time: Option<usize>,
    /// In the order of their first columns.
    labels: Vec<&'a str>,
    /// x, y and z of each label.
    markers: HashMap<&'a str, [Option<usize>; 3]>,
    head: head::Found,
    /// Of each label that has such a column.
    confidence: BTreeMap<&'a str, usize>,
    /// Columns of neither the time nor a marker nor the head.
    others: Vec<&'a str>,
}

fn sort_header<'a>(rows: &'a Rows<'_>, wanted: Option<&[String]>) -> Result<Header<'a>> {
    let wanted: Option<HashSet<&str>> = wanted.map(|labels| labels.iter().map(String::as_str).collect());
    let mut header = Header::default();
    for (column, cell) in rows.header().iter().enumerate() {
        let before = if cell == "time" {
            header.time.replace(column)
        } else if let Some(i) = head::COLUMNS.iter().position(|name| name == cell) {
            header.head[i].replace(column)
        } else if let Some((label, axis)) = split(cell) {
            let axes = header.markers.entry(label).or_insert_with(|| {
                header.labels.push(label);
                [None; 3]
            });
            let is_wanted = wanted.as_ref().is_none_or(|set| set.contains(label));
            axes[axis].replace(column).filter(|_| is_wanted)
        } else if let Some(label) = confidence::label(cell) {
            let is_wanted = wanted.as_ref().is_none_or(|set| set.contains(label));
            header.confidence.insert(label, column).filter(|_| is_wanted)
        } else if wanted.is_some() {
            header.others.push(cell);
            None
        } else {
            return Err(rows.error(&format!(
                "column {} of the header is {}, expected time, LABEL_x, LABEL_y or LABEL_z; leave out what is none of \
                 them",
                column + 1,
                quoted(cell)
            )));
        };
        if let Some(before) = before {
            return Err(rows
                .error(&format!(
                    "the columns {} and {} of the header are both {}; keep one of them",
                    before + 1,
                    column + 1,
                    quoted(cell)
                ))
                .of_kind(InputErrorKind::Conflict));
        }
    }
    Ok(header)
}

/// The columns with the confidence of `kept` labels, if they exist.
///
/// # Errors
/// [`rhytid_core::Error::Input`] without `wanted`, where a column is of a label without positions.
fn confidence_columns(
    rows: &Rows<'_>,
    header: &Header<'_>,
    kept: &[&str],
    wanted: bool,
) -> Result<Vec<Option<usize>>> {
    if let Some(stray) = confidence_of_no_marker(rows, header).next().filter(|_| !wanted) {
        let label = confidence::label(stray).unwrap_or_default();
        return Err(rows.error(&format!(
            "the header has {}, and no marker {}{}; give it its columns LABEL_x, LABEL_y and LABEL_z, or leave this \
             one out",
            quoted(stray),
            quoted(label),
            did_you_mean(label, header.labels.iter().copied())
        )).of_kind(InputErrorKind::MissingMarkers { labels: vec![label.to_owned()] }));
    }
    Ok(kept.iter().map(|label| header.confidence.get(label).copied()).collect())
}

/// The columns of the confidence of labels that have no other columns.
fn confidence_of_no_marker<'a>(rows: &'a Rows<'_>, header: &Header<'_>) -> impl Iterator<Item = &'a str> {
    let stray = header.confidence.iter().filter(|(label, _)| !header.markers.contains_key(*label));
    stray.map(|(_, &column)| rows.header()[column].as_str())
}

/// The label and the axis of a column: `brow_left_y` is axis 1 of `brow_left`.
fn split(column: &str) -> Option<(&str, usize)> {
    let axis = AXES.iter().position(|suffix| column.ends_with(suffix))?;
    let label = column.strip_suffix(AXES[axis])?;
    (!label.is_empty()).then_some((label, axis))
}

fn lacking_columns(label: &str, axes: &[Option<usize>; 3]) -> String {
    let columns = axes.iter().zip(AXES).filter(|(column, _)| column.is_none());
    columns.map(|(_, suffix)| quoted(&format!("{label}{suffix}"))).collect::<Vec<_>>().join(" and ")
}
