//! Tables with a row for each frame and marker: `frame,marker,x,y,z`.
use super::{Found, confidence, no_frames, position, wide::image_columns};
use crate::header::LongColumns;
use crate::stamps::{StampColumns, Stamps};
use crate::tables::rows::Rows;
use rhytid_core::text::quoted;
use rhytid_core::{Error, RawTake, Result};
use std::collections::HashMap;

/// A position of the table.
struct Sample {
    frame: usize,
    label: usize,
    position: [f64; 3],
    confidence: f32,
}

/// Reads a table. Rows may be in any order. A marker without a row in a frame was not seen.
///
/// # Errors
/// [`Error::Input`]: no frames, neither times nor a rate, a cell that is no coordinate, or far more markers
/// and frames than rows.
pub(in super::super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let mut rows = Rows::separated(bytes, name)?;
    let stamp_columns = StampColumns::of(rows.header());
    let key_column = stamp_columns.key();
    let (Some(columns), Some(key_column)) = (LongColumns::of(rows.header()), key_column) else {
        return Err(rows.error("the header has no columns of the frame, the marker, x, y and z"));
    };
    let image = image_columns(rows.header());
    let mut stamps = Stamps::new(stamp_columns);
    let mut samples: Vec<Sample> = Vec::new();
    let mut labels: Vec<String> = Vec::new();
    let mut place_of_label: HashMap<String, usize> = HashMap::new();
    let mut place_of_frame: HashMap<Vec<u8>, usize> = HashMap::new();
    let mut images: Vec<[f64; 2]> = Vec::new();
    let mut warnings = Vec::new();
    while rows.next_of_table(&mut warnings)? {
        let label = rows.text(columns.label)?;
        if label.is_empty() {
            return Err(rows.error(&format!(
                "{} is empty, expected the marker's label",
                quoted(&rows.header()[columns.label])
            )));
        }
        let label = match place_of_label.get(label) {
            Some(&label) => label,
            None => {
                place_of_label.insert(label.to_owned(), labels.len());
                labels.push(label.to_owned());
                labels.len() - 1
            }
        };
        let next = place_of_frame.len();
        // 1 and 1.0 are one frame.
        let key = match rows.number(key_column) {
            Some(number) => number.to_bits().to_le_bytes().to_vec(),
            None => rows.cell(key_column).to_vec(),
        };
        let frame = *place_of_frame.entry(key).or_insert(next);
        if frame == next {
            stamps.push(&rows)?;
            if let Some([w, h]) = image {
                images.push([w, h].map(|column| rows.number(column).unwrap_or(f64::NAN)));
            }
        }
        samples.push(Sample {
            frame,
            label,
            position: position(&rows, columns.axes)?,
            confidence: confidence(&rows, columns.confidence),
        });
    }
    let (m, frames) = (labels.len(), place_of_frame.len());
    if frames == 0 {
        return Err(no_frames(name));
    }
    // Each row takes about 20 bytes, so that a marker is then seen in less than a tenth of the frames.
    if frames.saturating_mul(m) > bytes.len() / 2 {
        return Err(Error::malformed(format!(
            "{name}: has {} rows for {m} markers in {frames} frames, so that hardly any marker is seen; check that {} \
             names the markers and {} the frames",
            samples.len(),
            quoted(&rows.header()[columns.label]),
            quoted(&rows.header()[key_column])
        )));
    }
    // MediaPipe's meshes have a visibility that is always 0.
    let all_unsure = samples.iter().all(|sample| sample.confidence == 0.0);
    let order = stamps.sort();
    let mut place = vec![0; frames];
    order.iter().enumerate().for_each(|(sorted, &frame)| place[frame] = sorted);
    let mut found = Found {
        positions: vec![RawTake::MISSING; frames * m],
        confidence: vec![1.0; frames * m],
        unit: columns.unit,
        images: if images.is_empty() { images } else { order.iter().map(|&frame| images[frame]).collect() },
        labels,
        warnings,
    };
    let mut is_given = vec![false; frames * m];
    let mut twice = 0;
    for sample in samples {
        let at = place[sample.frame] * m + sample.label;
        if std::mem::replace(&mut is_given[at], true) {
            twice += 1;
            continue;
        }
        let is_seen = all_unsure || sample.confidence > 0.0;
        found.positions[at] = if is_seen { sample.position } else { RawTake::MISSING };
        found.confidence[at] = if all_unsure { 1.0 } else { sample.confidence };
    }
    if twice > 0 {
        found.warnings.push(format!(
            "{twice} rows repeat the frame and the marker of an earlier row and are left out; if they are of another \
             person, export each person to a file"
        ));
    }
    let times = stamps.times(rate, &mut found.warnings).map_err(|error| error.in_file(name))?;
    Ok(found.into_take(times))
}
