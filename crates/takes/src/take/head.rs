//! The seven columns of the head's motion: a unit quaternion and a translation.
use super::cells::{in_frame, number, shown};
use crate::tables::rows::Rows;
use rhytid_core::Missing;
use rhytid_core::text::quoted;
use rhytid_core::{Result, RigidMotion};

/// In the order in which they are written.
pub(super) const COLUMNS: [&str; 7] =
    ["head_qw", "head_qx", "head_qy", "head_qz", "head_tx", "head_ty", "head_tz"];

/// A quaternion's length may be off by this much: files have rounded digits.
const LENGTH_TOLERANCE: f64 = 1e-3;

/// The places of the columns that exist.
pub(super) type Found = [Option<usize>; 7];

/// All seven, or `None` if there is none of them.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if only some are there; it names the missing ones.
pub(super) fn complete(rows: &Rows<'_>, found: Found) -> Result<Option<[usize; 7]>> {
    let columns: Vec<usize> = found.into_iter().flatten().collect();
    if columns.is_empty() {
        return Ok(None);
    }
    if let Ok(columns) = columns.try_into() {
        return Ok(Some(columns));
    }
    let lacking = COLUMNS.iter().zip(found).filter(|(_, column)| column.is_none());
    let lacking: Vec<String> = lacking.map(|(name, _)| quoted(name)).collect();
    Err(rows.error(&format!(
        "the head's motion lacks the columns {}, expected all seven ({}) or none",
        lacking.join(", "),
        COLUMNS.join(", ")
    )))
}

/// The head pose in the current row; `before` if the pose is missing and may be.
pub(super) fn read(
    rows: &Rows<'_>,
    columns: [usize; 7],
    frame: usize,
    before: Option<RigidMotion>,
    missing: Missing,
) -> Result<RigidMotion> {
    let mut numbers = [0.0; 7];
    for (value, column) in numbers.iter_mut().zip(columns) {
        let cell = rows.cell(column);
        match number(cell) {
            Some(number) if number.is_finite() => *value = number,
            found if missing != Missing::Error && (cell.is_empty() || found.is_some()) => {
                return Ok(before.unwrap_or(RigidMotion::IDENTITY));
            }
            _ => {
                let message = format!(
                    "{} of the head's motion is {}, expected a finite number",
                    quoted(&rows.header()[column]),
                    shown(rows, column)
                );
                return Err(in_frame(rows, frame, &message));
            }
        }
    }
    let [w, x, y, z, tx, ty, tz] = numbers;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    // The numbers are finite, but their squares may overflow, which gives a length of infinity.
    if (length - 1.0).abs() > LENGTH_TOLERANCE {
        let message = format!(
            "the head's quaternion ({w}, {x}, {y}, {z}) has the length {length}, expected 1; \
             head_qw to head_qz are a rotation"
        );
        return Err(in_frame(rows, frame, &message));
    }
    let motion = RigidMotion { rotation: [x, y, z, w], translation: [tx, ty, tz] };
    // Poses that [`super::write`] has written keep their bits.
    Ok(if motion.is_rigid() {
        motion
    } else {
        RigidMotion { rotation: motion.rotation.map(|q| q / length), ..motion }
    })
}

/// The numbers of a row's seven cells.
pub(super) fn cells(motion: &RigidMotion) -> [f64; 7] {
    let ([x, y, z, w], [tx, ty, tz]) = (motion.rotation, motion.translation);
    [w, x, y, z, tx, ty, tz]
}
