//! Takes: marker tracks as CSV, `time,LABEL_x,LABEL_y,LABEL_z,…`, in seconds and mesh units. A take may have
//! the head's motion, and the confidence of markers that are filled rather than measured.
mod cells;
mod columns;
mod confidence;
mod head;
mod stream;

use crate::tables::rows::Rows;
use crate::tables::{csv_of, write_checked};
use cells::{in_frame, number, shown};
use columns::{AXES, match_columns};
use rhytid_core::text::listed;
use rhytid_core::text::quoted;
use rhytid_core::{Error, InputErrorKind, RawTake, Remedy, Result, Take, input_file};
use std::path::Path;

pub use rhytid_core::Missing;
pub use stream::TakeStream;

/// Reads a take. Columns are matched by name, in any order.
///
/// With `wanted` (distinct labels, such as a rig's handles), the take has these labels in this order. One
/// warning names everything else in the file. Without `wanted`, the take has all labels in the order of the
/// header. The take has confidences if a marker has a column of confidences that are not all 1.
///
/// # Errors
/// [`Error::Input`] in these cases; [`Error::Io`].
///
/// - There is no column `time`, or a column occurs twice.
/// - A label (with `wanted`: a wanted label) lacks one of its three columns.
/// - Without `wanted`, there is any other column.
/// - A row has more or fewer cells than the header, or there are no frames.
/// - A time does not increase, a cell is not a number, or a confidence is not from 0 to 1.
/// - A marker is missing from a frame, or with [`Missing::Hold`] from all frames.
pub fn read(path: &Path, wanted: Option<&[String]>, missing: Missing) -> Result<Take> {
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    decode(&bytes, &path.display().to_string(), wanted, missing)
}

/// As [`read`], from the bytes of the file `name`.
///
/// # Errors
/// [`Error::Input`].
pub fn decode(bytes: &[u8], name: &str, wanted: Option<&[String]>, missing: Missing) -> Result<Take> {
    let mut rows = Rows::open(bytes, name)?;
    let columns = match_columns(&rows, name, wanted)?;
    let m = columns.labels.len();
    let head = columns.head.map(|_| Vec::new());
    let confidence = columns.confidence.iter().any(Option::is_some).then(Vec::new);
    let mut take = Take { labels: columns.labels, head, confidence, ..Take::default() };
    let mut last_seen = vec![None; m];
    while rows.next()? {
        let frame = take.times.len();
        let time = read_time(&rows, columns.time, frame, take.times.last().copied())?;
        for (j, last) in last_seen.iter_mut().enumerate() {
            let seen = read_marker(&rows, columns.markers[j], frame, &take.labels[j], missing)?;
            if let (Some(first), None, Missing::Hold) = (seen, &last, missing) {
                for gap in 0..frame {
                    take.positions[gap * m + j] = first;
                }
            }
            *last = seen.or(*last);
            let kept = if missing == Missing::Leave { seen } else { *last };
            take.positions.push(kept.unwrap_or(RawTake::MISSING));
        }
        if let (Some(columns), Some(head)) = (columns.head, &mut take.head) {
            let motion = head::read(&rows, columns, frame, head.last().copied(), missing)?;
            head.push(motion);
        }
        if let Some(confidence) = &mut take.confidence {
            confidence::read(&rows, &columns.confidence, &take.labels, frame, confidence)?;
        }
        take.times.push(time);
    }
    if take.times.is_empty() {
        return Err(Error::empty(format!("{name}: has no frames, expected a row for each under the header")));
    }
    let unseen: Vec<&str> = take
        .labels
        .iter()
        .zip(&last_seen)
        .filter(|(_, last)| last.is_none())
        .map(|(l, _)| l.as_str())
        .collect();
    if !unseen.is_empty() && missing == Missing::Hold {
        return Err(Error::missing_samples(format!(
            "{name}: missing from every frame: {}; a marker must be seen at least once to be held",
            listed(unseen.into_iter())
        )));
    }
    take.confidence = confidence::below_one(take.confidence);
    Ok(take)
}

fn read_time(rows: &Rows<'_>, column: usize, frame: usize, before: Option<f64>) -> Result<f64> {
    let time = number(rows.cell(column)).filter(|time| time.is_finite()).ok_or_else(|| {
        in_frame(rows, frame, &format!("the time is {}, expected a number of seconds", shown(rows, column)))
    })?;
    match before {
        Some(before) if time <= before => Err(in_frame(
            rows,
            frame,
            &format!(
                "the time {time} does not come after the {before} of the frame before; times must increase"
            ),
        )),
        _ => Ok(time),
    }
}

/// The position of a marker in the current row; `None` if it is missing and may be.
fn read_marker(
    rows: &Rows<'_>,
    columns: [usize; 3],
    frame: usize,
    label: &str,
    missing: Missing,
) -> Result<Option<[f64; 3]>> {
    let mut position = [0.0; 3];
    let mut is_missing = false;
    for (value, column) in position.iter_mut().zip(columns) {
        let cell = rows.cell(column);
        match number(cell) {
            // The runtime computes in f32.
            Some(number) if number.abs() <= f64::from(f32::MAX) => *value = number,
            found if found.map_or(!cell.is_empty(), f64::is_finite) => {
                let message = format!(
                    "{} of marker {} is {}, expected a number in mesh units, below 3.4e38",
                    quoted(&rows.header()[column]),
                    quoted(label),
                    shown(rows, column)
                );
                return Err(in_frame(rows, frame, &message));
            }
            _ if missing != Missing::Error => is_missing = true,
            _ => {
                let message = format!(
                    "marker {} is missing: {} is {}, expected a finite number; \
                     it can be held where it was last seen",
                    quoted(label),
                    quoted(&rows.header()[column]),
                    shown(rows, column)
                );
                return Err(in_frame(rows, frame, &message)
                    .of_kind(InputErrorKind::MissingSamples)
                    .with_remedies(&[Remedy::HoldMissing]));
            }
        }
    }
    Ok((!is_missing).then_some(position))
}

/// Writes a take so that [`read`] returns the same bits. A marker at [`RawTake::MISSING`] has empty cells.
///
/// # Errors
/// [`Error::Input`] if [`read`] would not return the take; [`Error::Io`]. The take must not have:
///
/// - other numbers that are not finite, times that do not increase, or confidences outside of 0 to 1,
/// - labels that are empty, that begin or end with a blank, or that occur twice,
/// - no frames or no labels.
pub fn write(path: &Path, take: &Take) -> Result<()> {
    let m = take.labels.len();
    if take.positions.len() != take.frames().saturating_mul(m) || m == 0 {
        return Err(Error::mismatch(format!(
            "{}: not written: the take has {} positions, expected {} frames × {m} labels, at least one of each",
            path.display(),
            take.positions.len(),
            take.frames()
        )));
    }
    if let Some(head) = &take.head
        && head.len() != take.frames()
    {
        let (found, expected) = (head.len(), take.frames());
        return Err(Error::mismatch(format!(
            "{}: not written: the take has {found} head motions, expected {expected}",
            path.display()
        )));
    }
    check_positions(take, &path.display().to_string())?;
    let doubtful = confidence::written(take, &path.display().to_string())?;
    let mut csv = csv_of(take.labels.iter().map(String::as_str));
    let mut encode = || -> csv::Result<()> {
        csv.write_field("time")?;
        for label in &take.labels {
            for suffix in AXES {
                csv.write_field(format!("{label}{suffix}"))?;
            }
        }
        for name in head::COLUMNS.iter().filter(|_| take.head.is_some()) {
            csv.write_field(name)?;
        }
        for &j in &doubtful {
            csv.write_field(confidence::column(&take.labels[j]))?;
        }
        csv.write_record(None::<&[u8]>)?;
        let mut digits = ryu::Buffer::new();
        for (i, (time, frame)) in take.times.iter().zip(take.positions.chunks_exact(m)).enumerate() {
            csv.write_field(digits.format(*time))?;
            for &position in frame {
                let is_missing = position.iter().all(|x| x.is_nan());
                for x in position {
                    csv.write_field(if is_missing { "" } else { digits.format(x) })?;
                }
            }
            for value in take.head.iter().flat_map(|head| head::cells(&head[i])) {
                csv.write_field(digits.format(value))?;
            }
            for confidence in take.confidence.iter().flat_map(|all| doubtful.iter().map(|&j| all[i * m + j]))
            {
                csv.write_field(digits.format(confidence))?;
            }
            csv.write_record(None::<&[u8]>)?;
        }
        Ok(())
    };
    encode().map_err(|e| Error::Internal(e.to_string()))?;
    let bytes = csv.into_inner().map_err(|e| Error::Internal(e.to_string()))?;
    write_checked(path, &bytes, |name| {
        let mut found = decode(&bytes, name, None, Missing::Leave)?;
        if doubtful.is_empty() {
            found.confidence.clone_from(&take.confidence);
        }
        let is_same = same_positions(&found, take);
        Ok(is_same
            && found.labels == take.labels
            && found.times == take.times
            && found.head == take.head
            && found.confidence == take.confidence)
    })
}

/// A marker is missing where its position is NaN; the bits of the NaN do not matter.
fn same_positions(a: &Take, b: &Take) -> bool {
    let bits = |x: &f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
    a.positions.as_flattened().iter().map(bits).eq(b.positions.as_flattened().iter().map(bits))
}

fn check_positions(take: &Take, name: &str) -> Result<()> {
    let is_sound = |p: &[f64; 3]| p.iter().all(|x| x.is_finite()) || p.iter().all(|x| x.is_nan());
    let Some(at) = take.positions.iter().position(|p| !is_sound(p)) else { return Ok(()) };
    let m = take.labels.len();
    Err(Error::out_of_range(format!(
        "{name}: not written: frame {}: marker {} is at {:?}, expected finite numbers, or NaN alone where it is missing",
        at / m,
        quoted(&take.labels[at % m]),
        take.positions[at]
    )))
}
