//! The CSV of OpenFace 2: 68 landmarks of a face in a video, in millimetres before the camera.
use super::{Found, check_room, no_frames, position};
use crate::stamps::{StampColumns, Stamps};
use crate::tables::rows::Rows;
use rhytid_core::{Error, RawTake, Result};
use std::collections::BTreeMap;

/// Landmarks of iBUG's scheme.
const LANDMARKS: usize = 68;

/// A tracker that is less sure than this has probably lost the face.
const SURE: f64 = 0.8;

/// Reads a file. The landmarks are `lm0` to `lm67`, after iBUG's scheme. They are turned so that y points up
/// and z to the camera. Where the tracker has no success, all landmarks are missing. A confidence below 0.8
/// is that of the frame's landmarks.
///
/// # Errors
/// [`Error::Input`]: landmarks without depth, no frames, or a cell that is no number.
pub(in super::super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let mut rows = Rows::separated(bytes, name)?;
    let place = |wanted: &str| rows.header().iter().position(|cell| cell == wanted);
    let landmark =
        |i: usize| Some([place(&format!("X_{i}"))?, place(&format!("Y_{i}"))?, place(&format!("Z_{i}"))?]);
    let Some(columns) = (0..LANDMARKS).map(landmark).collect::<Option<Vec<_>>>() else {
        return Err(Error::unsupported_format(format!(
            "{name}: is of OpenFace, but lacks the landmarks in millimetres, X_0 to Z_67; run OpenFace again with \
             its option -3Dfp"
        )));
    };
    let [success, confidence, face] = ["success", "confidence", "face_id"].map(place);
    let face = face.map_or_else(|| Ok(None), |face| main_face(bytes, name, face, success))?;
    let mut stamps = Stamps::new(StampColumns::of(rows.header()));
    let mut found = Found::new((0..LANDMARKS).map(|i| format!("lm{i}")).collect(), "mm".into());
    while rows.next_of_table(&mut found.warnings)? {
        if let Some(face) = &face
            && rows.cell(face.column) != face.id
        {
            continue;
        }
        stamps.push(&rows)?;
        check_room(&rows, found.positions.len() + LANDMARKS, bytes.len())?;
        let is_found = success.is_none_or(|column| rows.number(column) != Some(0.0));
        let sure = confidence.and_then(|column| rows.number(column)).unwrap_or(1.0);
        for &columns in &columns {
            let [x, y, z] = position(&rows, columns)?;
            found.positions.push(if is_found { [x, -y, -z] } else { RawTake::MISSING });
            found.confidence.push(if sure < SURE { sure.clamp(0.0, 1.0) as f32 } else { 1.0 });
        }
    }
    if found.positions.is_empty() {
        return Err(no_frames(name));
    }
    if let Some(face) = face.filter(|face| face.others > 0) {
        found.warnings.push(format!(
            "there are {} faces; the face {} is read, which is found in most frames",
            face.others + 1,
            String::from_utf8_lossy(&face.id)
        ));
    }
    let times = stamps.times(rate, &mut found.warnings).map_err(|error| error.in_file(name))?;
    let take = found.into_take(times);
    Ok(RawTake { is_video: true, ..take })
}

/// The face that is read.
struct MainFace {
    /// The column of the faces' numbers.
    column: usize,
    id: Vec<u8>,
    /// How many other faces there are.
    others: usize,
}

/// The face with the most rows of success; of equal ones, the first by its number.
fn main_face(bytes: &[u8], name: &str, column: usize, success: Option<usize>) -> Result<Option<MainFace>> {
    let mut rows = Rows::separated(bytes, name)?;
    let mut counts: BTreeMap<Vec<u8>, usize> = BTreeMap::new();
    while rows.advance()? {
        let is_found = success.is_none_or(|column| rows.number(column) != Some(0.0));
        *counts.entry(rows.cell(column).to_vec()).or_default() += usize::from(is_found);
    }
    let others = counts.len().saturating_sub(1);
    let most = counts.values().max().copied();
    let main = counts.into_iter().find(|(_, count)| Some(*count) == most);
    Ok(main.map(|(id, _)| MainFace { column, id, others }))
}
