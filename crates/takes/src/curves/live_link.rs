//! Weights of shapes as the app Live Link Face writes them.
use super::names::Key;
use super::write::{save, write_curves};
use crate::tables::csv_of;
use crate::timecode::RATES;
use rhytid_core::{Error, Result};
use std::path::Path;

/// The columns of weights, in the app's order: ARKit's 52 shapes.
const WEIGHTS: [&str; 52] = [
    "EyeBlinkLeft",
    "EyeLookDownLeft",
    "EyeLookInLeft",
    "EyeLookOutLeft",
    "EyeLookUpLeft",
    "EyeSquintLeft",
    "EyeWideLeft",
    "EyeBlinkRight",
    "EyeLookDownRight",
    "EyeLookInRight",
    "EyeLookOutRight",
    "EyeLookUpRight",
    "EyeSquintRight",
    "EyeWideRight",
    "JawForward",
    "JawRight",
    "JawLeft",
    "JawOpen",
    "MouthClose",
    "MouthFunnel",
    "MouthPucker",
    "MouthRight",
    "MouthLeft",
    "MouthSmileLeft",
    "MouthSmileRight",
    "MouthFrownLeft",
    "MouthFrownRight",
    "MouthDimpleLeft",
    "MouthDimpleRight",
    "MouthStretchLeft",
    "MouthStretchRight",
    "MouthRollLower",
    "MouthRollUpper",
    "MouthShrugLower",
    "MouthShrugUpper",
    "MouthPressLeft",
    "MouthPressRight",
    "MouthLowerDownLeft",
    "MouthLowerDownRight",
    "MouthUpperUpLeft",
    "MouthUpperUpRight",
    "BrowDownLeft",
    "BrowDownRight",
    "BrowInnerUp",
    "BrowOuterUpLeft",
    "BrowOuterUpRight",
    "CheekPuff",
    "CheekSquintLeft",
    "CheekSquintRight",
    "NoseSneerLeft",
    "NoseSneerRight",
    "TongueOut",
];

/// The columns of angles, which are 0: weights of shapes say nothing of the head and the eyes.
const ANGLES: [&str; 9] = [
    "HeadYaw",
    "HeadPitch",
    "HeadRoll",
    "LeftEyeYaw",
    "LeftEyePitch",
    "LeftEyeRoll",
    "RightEyeYaw",
    "RightEyePitch",
    "RightEyeRoll",
];

/// The part by which the rate of rounded times may be off. 29.97 frames per second are another rate than 30.
const ROUNDING: f64 = 1e-4;

/// Writes weights of shapes as CSV, a row for each frame from the time code `first` on.
///
/// If all `names` are those of ARKit's shapes, in any spelling, and `rate` is one that time codes count in,
/// the columns are those of Live Link Face. Shapes that are not among the names are 0. Otherwise the file is
/// as [`write_curves`] writes it. `values` are frames × names.
///
/// # Errors
/// [`Error::Input`] if the folder does not exist; [`Error::Io`].
pub fn write_weights(path: &Path, names: &[String], first: usize, rate: f64, values: &[f32]) -> Result<()> {
    // Times in a table are rounded, and so is their rate.
    let counted = RATES.into_iter().find(|known| (rate / f64::from(*known) - 1.0).abs() < ROUNDING);
    match (places(names), counted) {
        (Some(places), Some(rate)) => write(path, &places, first, rate as usize, values, names.len()),
        _ => write_curves(path, names, first, rate, values),
    }
}

/// For each of the app's columns the number of its name; `None` if a name has no column, or two have the
/// same.
fn places(names: &[String]) -> Option<Vec<Option<usize>>> {
    let keys: Vec<Key> = names.iter().map(|name| Key::of(name)).collect();
    let place = |column: &&str| {
        let key = Key::of(column);
        keys.iter().position(|known| *known == key)
    };
    let places: Vec<Option<usize>> = WEIGHTS.iter().map(place).collect();
    let used = places.iter().flatten().count();
    (used == names.len() && used > 0).then_some(places)
}

fn write(
    path: &Path,
    places: &[Option<usize>],
    first: usize,
    rate: usize,
    values: &[f32],
    names: usize,
) -> Result<()> {
    let header = ["Timecode", "BlendShapeCount"].into_iter().chain(WEIGHTS).chain(ANGLES);
    let mut csv = csv_of(header.clone());
    let count = (WEIGHTS.len() + ANGLES.len()).to_string();
    let encode = || -> csv::Result<()> {
        csv.write_record(header)?;
        for (frame, row) in (first..).zip(values.chunks_exact(names)) {
            let seconds = frame / rate;
            let [hours, minutes] = [seconds / 3600 % 24, seconds / 60 % 60];
            let code = format!("{hours:02}:{minutes:02}:{:02}:{:02}.000", seconds % 60, frame % rate);
            let weights = places.iter().map(|place| place.map_or(0.0, |place| row[place]).to_string());
            let angles = ANGLES.iter().map(|_| "0".to_owned());
            csv.write_record([code, count.clone()].into_iter().chain(weights).chain(angles))?;
        }
        Ok(())
    };
    encode().map_err(|e| Error::Internal(e.to_string()))?;
    save(path, csv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curves::read;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn names_of_arkit_in_any_spelling_become_the_apps_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.csv");
        let given = names(&["jawOpen", "eyeBlink_L", "mouthSmileRight"]);
        // Two frames on each side of a whole second: 10 s are frame 300.
        let values = [0.5, 0.25, 0.0, 1.0, 0.0, 0.125, 0.0, 0.75, 1.0, 0.1, 0.2, 0.3];
        write_weights(&path, &given, 298, 30.0, &values).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!((rows.len(), rows[0].len()), (5, 63));
        assert_eq!(rows[0][..4], ["Timecode", "BlendShapeCount", "EyeBlinkLeft", "EyeLookDownLeft"]);
        assert_eq!(rows[1][..4], ["00:00:09:28.000", "61", "0.25", "0"]);
        assert_eq!(rows[3][0], "00:00:10:00.000");
        let found = read(&path, None).unwrap();
        assert_eq!(found.warnings, [""; 0]);
        let column = |name: &str| found.names.iter().position(|known| known == name).unwrap();
        let [jaw, blink, smile] = ["JawOpen", "EyeBlinkLeft", "MouthSmileRight"].map(column);
        for (row, expected) in found.weights.chunks(52).zip(values.as_chunks::<3>().0) {
            assert_eq!([row[jaw], row[blink], row[smile]], *expected);
            assert_eq!(row.iter().sum::<f32>(), expected.iter().sum::<f32>());
        }
        assert!((found.times[3] - 0.1).abs() < 1e-9, "{:?}", found.times);
    }

    #[test]
    fn other_names_and_rates_are_written_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("curves.csv");
        for (given, rate) in
            [(["jawOpen", "grin"], 30.0), (["jawOpen", "jaw_open"], 30.0), (["jawOpen", "tongueOut"], 29.97)]
        {
            write_weights(&path, &names(&given), 0, rate, &[0.5, 0.25, 1.0, 0.0]).unwrap();
            let found = read(&path, None).unwrap();
            assert_eq!((found.names, found.weights), (names(&given), vec![0.5, 0.25, 1.0, 0.0]));
            assert!((found.times[1] - 1.0 / rate).abs() < 1e-6);
        }
    }

    #[test]
    fn no_two_columns_are_of_one_shape() {
        let all = names(&WEIGHTS);
        let found = places(&all).unwrap();
        assert!(found.iter().enumerate().all(|(i, place)| *place == Some(i)));
    }
}
