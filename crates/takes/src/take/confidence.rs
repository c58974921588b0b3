//! The optional column of a marker's confidence, `LABEL_confidence`.
use super::cells::{in_frame, shown};
use crate::tables::rows::Rows;
use rhytid_core::text::quoted;
use rhytid_core::{Error, Result, Take};

const SUFFIX: &str = "_confidence";

/// The label of a column: `brow_left_confidence` is that of `brow_left`. No column ends with this and an axis
/// too.
pub(super) fn label(column: &str) -> Option<&str> {
    column.strip_suffix(SUFFIX).filter(|label| !label.is_empty())
}

/// The name of a label's column.
pub(super) fn column(label: &str) -> String {
    format!("{label}{SUFFIX}")
}

/// Adds the current row's M confidences to `out`: 1 where a label has no column.
///
/// # Errors
/// [`Error::Input`] if a cell is no number from 0 to 1.
pub(super) fn read(
    rows: &Rows<'_>,
    columns: &[Option<usize>],
    labels: &[String],
    frame: usize,
    out: &mut Vec<f32>,
) -> Result<()> {
    for (column, label) in columns.iter().zip(labels) {
        let Some(column) = *column else {
            out.push(1.0);
            continue;
        };
        let number = std::str::from_utf8(rows.cell(column)).ok().and_then(|cell| cell.parse::<f32>().ok());
        let Some(confidence) = number.filter(|x| (0.0..=1.0).contains(x)) else {
            let message = format!(
                "{} of marker {} is {}, expected a number from 0 (a guess) to 1 (measured)",
                quoted(&rows.header()[column]),
                quoted(label),
                shown(rows, column)
            );
            return Err(in_frame(rows, frame, &message));
        };
        out.push(confidence);
    }
    Ok(())
}

/// `None` if all are 1, as in [`Take::confidence`].
pub(super) fn below_one(confidence: Option<Vec<f32>>) -> Option<Vec<f32>> {
    confidence.filter(|all| all.iter().any(|&x| x < 1.0))
}

/// The markers that need a column: those whose confidence is below 1 in any frame.
///
/// # Errors
/// [`Error::Input`] if the take does not have frames × M confidences from 0 to 1. The message begins with
/// `name`.
pub(super) fn written(take: &Take, name: &str) -> Result<Vec<usize>> {
    let Some(confidence) = &take.confidence else { return Ok(Vec::new()) };
    let m = take.labels.len();
    if confidence.len() != take.positions.len() {
        return Err(Error::mismatch(format!(
            "{name}: not written: the take has {} confidences, expected one for each of its {} positions",
            confidence.len(),
            take.positions.len()
        )));
    }
    if let Some(i) = confidence.iter().position(|x| !(0.0..=1.0).contains(x)) {
        return Err(Error::out_of_range(format!(
            "{name}: not written: frame {}: the confidence of marker {} is {}, expected 0 to 1",
            i / m,
            quoted(&take.labels[i % m]),
            confidence[i]
        )));
    }
    Ok((0..m).filter(|&j| confidence.iter().skip(j).step_by(m).any(|&x| x < 1.0)).collect())
}
