//! Reading curves from CSV: a row for each frame, and a column for each name.
use super::{Curves, is_pose};
use crate::stamps::{StampColumns, Stamps};
use crate::tables::rows::Rows;
use crate::text::{says_missing, utf_8};
use rhytid_core::text::{listed, quoted};
use rhytid_core::{Error, InputErrorKind, Result, input_file};
use std::collections::HashMap;
use std::path::Path;

/// A larger weight is probably one of per cent.
const PER_CENT: f32 = 5.0;

/// An angle or a place that changes by more than this is worth a warning when it is left out.
const MOVES: f32 = 0.02;

/// Reads a table of curves, as of Live Link Face, ARKit or a MetaHuman. The header names the curves. Columns
/// of the time and the frame are found by their names. Cells are separated by commas, semicolons or tabs.
///
/// `rate`, in frames per second, replaces the times of the file.
///
/// # Errors
/// [`Error::Input`]: no curves or no frames, neither times nor a rate, a cell that is no number, or a name
/// that occurs twice. [`Error::Io`].
pub fn read(path: &Path, rate: Option<f64>) -> Result<Curves> {
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    decode(&bytes, &path.display().to_string(), rate)
}

/// As [`read`], from the bytes of the file `name`.
///
/// # Errors
/// [`Error::Input`].
pub fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<Curves> {
    let text = utf_8(bytes);
    let mut rows = Rows::separated(&text, name)?;
    let columns = Columns::of(&rows)?;
    let mut stamps = Stamps::new(columns.stamps.clone());
    let mut warnings = Vec::new();
    let n = columns.curves.len();
    let (mut weights, mut poses) = (Vec::new(), Vec::new());
    let mut empty_rows = 0;
    while rows.next_of_table(&mut warnings)? {
        stamps.push(&rows)?;
        // Rows without weights are short. With too many of them, the curves would be out of proportion.
        if weights.len() + n > 4 * bytes.len() {
            return Err(rows.error("the rows are far shorter than the header; the file may be damaged"));
        }
        let first = weights.len();
        for &column in &columns.curves {
            weights.push(weight(&rows, column)?);
        }
        empty_rows += usize::from(weights[first..].iter().all(|weight| weight.is_nan()));
        for &column in &columns.poses {
            poses.push(weight(&rows, column)?);
        }
    }
    let frames = weights.len() / n.max(1);
    if frames == empty_rows {
        return Err(Error::empty(format!(
            "{name}: has no frames with weights, expected a row for each frame under the header"
        )));
    }
    let times = stamps.times(rate, &mut warnings).map_err(|error| error.in_file(name))?;
    let names: Vec<String> = columns.curves.iter().map(|&column| rows.header()[column].clone()).collect();
    let mut curves =
        Curves { names, times: times.times, weights: rows_of(&weights, n, &times.kept), warnings };
    fill(&mut curves.weights, n);
    if empty_rows > 0 {
        curves.warnings.push(format!(
            "{empty_rows} of {frames} frames have no weights, as where the face was not seen; they are filled \
             from the frames around them"
        ));
    }
    warn_per_cent(&mut curves);
    let of_pose: Vec<&str> = columns.poses.iter().map(|&column| &*rows.header()[column]).collect();
    curves.warnings.extend(left_out(&of_pose, &poses));
    Ok(curves)
}

/// The meaning of the columns.
struct Columns {
    stamps: StampColumns,
    curves: Vec<usize>,
    /// The columns of angles and places of the head and the eyes.
    poses: Vec<usize>,
}

impl Columns {
    fn of(rows: &Rows<'_>) -> Result<Self> {
        let stamps = StampColumns::of(rows.header());
        let mut columns = Self { stamps, curves: Vec::new(), poses: Vec::new() };
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for (column, cell) in rows.header().iter().enumerate() {
            let is_count = cell.eq_ignore_ascii_case("BlendshapeCount");
            if cell.is_empty() || is_count || columns.stamps.has(column) {
                continue;
            }
            if let Some(first) = seen.insert(cell, column) {
                return Err(rows
                    .error(&format!(
                        "the columns {} and {} of the header are both {}; keep one of them",
                        first + 1,
                        column + 1,
                        quoted(cell)
                    ))
                    .of_kind(InputErrorKind::Conflict));
            }
            if is_pose(cell) { columns.poses.push(column) } else { columns.curves.push(column) }
        }
        if columns.curves.is_empty() {
            return Err(rows
                .error("the header names no curves, expected a column for each beside the time")
                .of_kind(InputErrorKind::Empty));
        }
        Ok(columns)
    }
}

/// The number in a cell; NaN where the cell is empty or says that it is no number.
fn weight(rows: &Rows<'_>, column: usize) -> Result<f32> {
    let found = match rows.number(column) {
        Some(number) => Some(number as f32),
        None => says_missing(rows.cell(column)).then_some(f32::NAN),
    };
    found.filter(|number| !number.is_infinite()).ok_or_else(|| {
        rows.error(&format!(
            "the weight of {} is {}, expected a number",
            quoted(&rows.header()[column]),
            quoted(&String::from_utf8_lossy(rows.cell(column)))
        ))
    })
}

/// The rows `kept` of a table with `n` columns.
fn rows_of(table: &[f32], n: usize, kept: &[usize]) -> Vec<f32> {
    kept.iter().flat_map(|&row| table[row * n..(row + 1) * n].iter().copied()).collect()
}

/// Fills the gaps of each column: between two weights evenly, and before the first and behind the last one
/// with that weight. A column without any number is 0.
fn fill(weights: &mut [f32], n: usize) {
    let frames = weights.len() / n;
    for column in 0..n {
        let mut last: Option<usize> = None;
        for frame in 0..frames {
            let here = weights[frame * n + column];
            if here.is_nan() {
                continue;
            }
            let first = last.map_or(0, |last| last + 1);
            let before = last.map_or(here, |last| weights[last * n + column]);
            for gap in first..frame {
                let s = (gap + 1 - first) as f32 / (frame + 1 - first) as f32;
                weights[gap * n + column] = before + s * (here - before);
            }
            last = Some(frame);
        }
        let held = last.map_or(0.0, |last| weights[last * n + column]);
        for frame in last.map_or(0, |last| last + 1)..frames {
            weights[frame * n + column] = held;
        }
    }
}

fn warn_per_cent(curves: &mut Curves) {
    let largest = (0..curves.names.len()).map(|i| (curves.largest(i), i));
    let Some((weight, i)) = largest.max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    if weight > PER_CENT {
        curves.warnings.push(format!(
            "the largest weight is {weight}, of {}, but 1 is the whole shape; if the table is in per cent, divide \
             its weights by 100",
            quoted(&curves.names[i])
        ));
    }
}

/// The warning about columns of the head and the eyes that move.
fn left_out(names: &[&str], values: &[f32]) -> Option<String> {
    let range = |i: usize| {
        let column = || values.iter().skip(i).step_by(names.len()).copied().filter(|x| !x.is_nan());
        column().fold(f32::MIN, f32::max) - column().fold(f32::MAX, f32::min)
    };
    let moving: Vec<&str> = (0..names.len()).filter(|&i| range(i) > MOVES).map(|i| names[i]).collect();
    if moving.is_empty() {
        return None;
    }
    Some(format!(
        "angles and places of the head and the eyes are no weights and are left out, so that the head keeps \
         still: {}",
        listed(moving.into_iter())
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn live_link_face_is_read_with_its_gaps_and_without_its_angles() {
        let csv = "Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,HeadYaw,LeftEyeYaw\n\
                   18:57:50:28.500,61,0.5,0.25,0.1,0\n\
                   18:57:50:29.500,0\n\
                   18:57:51:00.500,61,0.7,1.25,-0.2,0\n\
                   18:57:52:00.500,61,0.7,-0.5,-0.2,0\n";
        let found = decode(csv.as_bytes(), "take.csv", None).unwrap();
        assert_eq!(found.names, ["EyeBlinkLeft", "JawOpen"]);
        assert_eq!(found.weights, [0.5, 0.25, 0.6, 0.75, 0.7, 1.25, 0.7, -0.5]);
        let expected = [0.0, 1.0 / 30.0, 2.0 / 30.0, 1.0 + 2.0 / 30.0];
        assert!(found.times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", found.times);
        let warnings = found.warnings.join("\n");
        assert!(warnings.contains("1 of 4 frames have no weights"), "{warnings}");
        assert!(warnings.contains("the head keeps still: \"HeadYaw\""), "{warnings}");
        assert!(!warnings.contains("LeftEyeYaw"), "{warnings}");
    }

    #[test]
    fn other_separators_decimal_commas_and_frames_with_a_rate() {
        let semicolons = "\u{feff}Frame;jawOpen;tongueOut\n10;0,5;0\n11;1;0,25\n";
        let found = decode(semicolons.as_bytes(), "a.csv", Some(50.0)).unwrap();
        assert_eq!((found.weights, found.times), (vec![0.5, 0.0, 1.0, 0.25], vec![0.0, 0.02]));
        let tabs = "time (ms)\tjawOpen\n0\t0.5\n40\t1\n";
        let found = decode(tabs.as_bytes(), "a.csv", None).unwrap();
        assert_eq!((found.weights, found.times), (vec![0.5, 1.0], vec![0.0, 0.04]));
        let error = decode(semicolons.as_bytes(), "a.csv", None).unwrap_err().to_string();
        assert!(error.starts_with("a.csv: gives no frame rate"), "{error}");
    }

    #[test]
    fn faults_are_named() {
        for (csv, expected) in [
            ("time,jawOpen\n0,wide\n", "a.csv, line 2: the weight of \"jawOpen\" is \"wide\""),
            ("time,jawOpen,jawOpen\n0,1,1\n", "the columns 2 and 3 of the header are both \"jawOpen\""),
            ("time,jawOpen\n", "a.csv: has no frames with weights"),
            ("time,BlendshapeCount\n0,0\n", "the header names no curves"),
            ("time,jawOpen\n0,1,2\n", "line 2: the row has 3 cells, expected 2"),
        ] {
            let error = decode(csv.as_bytes(), "a.csv", None).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let cut = decode(b"time,jawOpen,tongueOut\n0,1,0\n0.1,0", "a.csv", None).unwrap();
        assert_eq!(cut.times, [0.0]);
        let lost = decode(b"time,jawOpen,tongueOut\n0,1,0\n0.1,nan,null\n0.2,0,1\n", "a.csv", None).unwrap();
        assert_eq!(lost.weights, [1.0, 0.0, 0.5, 0.5, 0.0, 1.0]);
        assert!(lost.warnings[0].contains("1 of 3 frames have no weights"), "{:?}", lost.warnings);
        let late =
            decode(b"time,jawOpen,tongueOut,smile\n0,,1,\n0.1,,,\n0.2,0.5,,\n0.3,1,,\n", "a.csv", None);
        let late = late.unwrap().weights;
        assert_eq!(late, [0.5, 1.0, 0.0, 0.5, 1.0, 0.0, 0.5, 1.0, 0.0, 1.0, 1.0, 0.0]);
        let wide = format!("time{}\n", (0..5_000).map(|i| format!(",jawOpen{i}")).collect::<String>());
        let hostile = wide + &(0..20_000).map(|i| format!("{i}\n")).collect::<String>();
        let error = decode(hostile.as_bytes(), "a.csv", None).unwrap_err().to_string();
        assert!(error.contains("the rows are far shorter than the header"), "{error}");
        let per_cent = decode(b"time,jawOpen\n0,80\n", "a.csv", None).unwrap();
        assert!(per_cent.warnings[0].contains("per cent"), "{:?}", per_cent.warnings);
    }

    #[test]
    fn written_curves_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.csv");
        let names = ["jaw".to_owned(), "brow".to_owned()];
        crate::curves::write_curves(&path, &names, 3, 25.0, &[0.1, 0.2, 0.3, 0.4]).unwrap();
        let found = read(&path, None).unwrap();
        assert_eq!((found.names, found.weights), (names.to_vec(), vec![0.1, 0.2, 0.3, 0.4]));
        assert_eq!(found.times, [0.12, 0.16]);
    }
}
