//! Tables with a row for each frame, and columns for the x, y and z of each marker.
use super::{Found, check_room, confidence, no_frames, position};
use crate::header::WideColumns;
use crate::stamps::{StampColumns, Stamps};
use crate::tables::rows::Rows;
use rhytid_core::text::listed;
use rhytid_core::{RawTake, Result};

/// Reads a table.
///
/// # Errors
/// [`rhytid_core::Error::Input`]: no frames, neither times nor a rate, or a cell that is no coordinate.
pub(in super::super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let mut rows = Rows::separated(bytes, name)?;
    let columns = WideColumns::of(rows.header());
    let image = image_columns(rows.header());
    let mut stamps = Stamps::new(StampColumns::of(rows.header()));
    let labels = columns.markers.iter().map(|marker| marker.label.clone()).collect();
    let mut found = Found::new(labels, columns.unit);
    while rows.next_of_table(&mut found.warnings)? {
        stamps.push(&rows)?;
        check_room(&rows, found.positions.len() + columns.markers.len(), bytes.len())?;
        for marker in &columns.markers {
            let sure = confidence(&rows, marker.confidence);
            found.positions.push(position(&rows, marker.columns)?);
            found.confidence.push(sure);
        }
        if let Some([w, h]) = image {
            found.images.push([w, h].map(|column| rows.number(column).unwrap_or(f64::NAN)));
        }
    }
    if found.positions.is_empty() {
        return Err(no_frames(name));
    }
    // MediaPipe's meshes have a visibility that is always 0.
    if found.confidence.iter().all(|sure| *sure == 0.0) {
        found.confidence.fill(1.0);
    }
    let unsure = found.confidence.iter().zip(&mut found.positions).filter(|(sure, _)| **sure == 0.0);
    unsure.for_each(|(_, position)| *position = RawTake::MISSING);
    let is_used = |name: &String| image.iter().flatten().any(|&column| rows.header()[column] == *name);
    let others: Vec<String> = columns.others.into_iter().filter(|name| !is_used(name)).collect();
    for (labels, what) in [
        (&columns.incomplete, "markers lack one of the columns x, y and z and are left out"),
        (&others, "columns are no positions and are left out"),
    ] {
        if !labels.is_empty() {
            let shown = listed(labels.iter().map(String::as_str));
            found.warnings.push(format!("{} {what}: {shown}", labels.len()));
        }
    }
    let times = stamps.times(rate, &mut found.warnings).map_err(|error| error.in_file(name))?;
    Ok(found.into_take(times))
}

/// The columns of the image's width and height.
pub(super) fn image_columns(header: &[String]) -> Option<[usize; 2]> {
    let find = |names: &[&str]| {
        let plain = |cell: &String| -> String {
            cell.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
        };
        header.iter().position(|cell| names.contains(&&*plain(cell)))
    };
    let width = find(&["width", "imagewidth", "imgwidth", "imgw", "framewidth", "videowidth", "w"])?;
    let height = find(&["height", "imageheight", "imgheight", "imgh", "frameheight", "videoheight", "h"])?;
    Some([width, height])
}
