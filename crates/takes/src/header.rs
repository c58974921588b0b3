//! What kind of table a CSV file is, by its header.
use crate::curves;
use crate::raw_take::is_face_mesh;
use crate::stamps::StampColumns;
use crate::tables::rows::Rows;
use std::collections::{HashMap, HashSet};

/// The kinds of tables that tell positions or weights over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Table {
    /// The take's own CSV, or a table that is none of the others.
    Take,
    /// A row for each frame, and a column for each marker's x, y and z.
    Wide,
    /// A row for each frame and marker.
    Long,
    /// Landmarks that OpenFace found in a video.
    OpenFace,
    /// Weights of shapes.
    Curves,
}

impl Table {
    /// The kind of the table that begins with these bytes. The whole header should be in them.
    pub(crate) fn detect(start: &[u8]) -> Self {
        let Ok(rows) = Rows::separated(start, "") else { return Self::Take };
        let header = rows.header();
        let cells: HashSet<&str> = header.iter().map(String::as_str).collect();
        let own_triples = header.iter().filter_map(|cell| cell.strip_suffix("_x")).any(|label| {
            !label.is_empty() && ["_y", "_z"].iter().all(|axis| cells.contains(&*format!("{label}{axis}")))
        });
        let has = |name: &str| header.iter().any(|cell| cell.eq_ignore_ascii_case(name));
        let stamps = StampColumns::of(header);
        if has("confidence") && (has("success") || has("face")) && (has("x_0") || has("p_scale")) {
            return Self::OpenFace;
        }
        let wide = WideColumns::of(header);
        let is_face_mesh = is_face_mesh(wide.markers.iter().map(|marker| &*marker.label));
        let is_place = |cell: &String| axis_of(cell).is_some();
        // A table of weights may have the head's place beside them.
        let weights = header.iter().filter(|cell| curves::is_known(cell) && !is_place(cell)).count();
        if weights > wide.markers.len() {
            return Self::Curves;
        }
        if rows.is_separated_by_commas() && cells.contains("time") && own_triples && !is_face_mesh {
            return Self::Take;
        }
        if LongColumns::of(header).is_some() {
            return Self::Long;
        }
        let some_axis = header.iter().any(|cell| is_place(cell) || axis(cell).is_some());
        if !wide.markers.is_empty() {
            return Self::Wide;
        }
        let others = || (0..header.len()).filter(|&i| !stamps.has(i) && !header[i].is_empty());
        let is_table_of_names = stamps.any() && !some_axis && others().next().is_some();
        if is_table_of_names && !is_table_of_rhytid(header) {
            return Self::Curves;
        }
        Self::Take
    }
}

/// Whether a header is of a table that Rhytid reads for another purpose, such as a list of frames.
fn is_table_of_rhytid(header: &[String]) -> bool {
    const COLUMNS: [&str; 9] =
        ["vertex", "label", "handle", "marker", "from", "to", "edge", "candidate", "distance_mm"];
    header.iter().any(|cell| COLUMNS.contains(&&**cell)) || header.len() < 2
}

/// A label and which of its axes a column holds: 0 to 2.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Axis {
    pub(crate) label: String,
    pub(crate) axis: usize,
    /// The unit of length that the column's name ends with, such as `mm`; empty without one.
    pub(crate) unit: String,
}

/// The words that stand between a label and an axis and say that it is a place.
const PLACES: [&str; 10] = [
    "pos",
    "position",
    "loc",
    "location",
    "translate",
    "translation",
    "trans",
    "coord",
    "coords",
    "coordinate",
];

/// The words between a label and an axis that say that a column holds something else than a place.
const OTHERS: [&str; 10] = [
    "rot",
    "rotation",
    "rotate",
    "euler",
    "quat",
    "quaternion",
    "orientation",
    "scale",
    "velocity",
    "acceleration",
];

fn is_other(word: &str) -> bool {
    OTHERS.contains(&&*word.to_ascii_lowercase())
}

/// Reads the name of a column: `chin_x`, `chin.X`, `chin (x)`, `chinX`, `X_chin`, `x12` or `chin_pos_x_mm`.
/// `None` if the name has no axis, is an axis alone, or names a rotation or the like, as `chin_rot_x` does.
pub(crate) fn axis_of(cell: &str) -> Option<Axis> {
    let mut words = words(cell);
    let unit = match words.last() {
        Some(word) if words.len() > 2 && crate::raw_take::metres(word.text).is_some() => word.text.to_owned(),
        _ => String::new(),
    };
    if !unit.is_empty() {
        words.pop();
    }
    if words.len() < 2 {
        return None;
    }
    let last = words.last().and_then(|word| axis(word.text));
    let (found, words) = match (last, axis(words[0].text)) {
        (Some(found), _) => (found, &words[..words.len() - 1]),
        (None, Some(found)) => (found, &words[1..]),
        (None, None) => return None,
    };
    if words.last().is_some_and(|word| is_other(word.text)) {
        return None;
    }
    let is_place = |word: &Word<'_>| PLACES.contains(&&*word.text.to_ascii_lowercase());
    let words = match words {
        [words @ .., last] if !words.is_empty() && is_place(last) => words,
        [first, words @ ..] if !words.is_empty() && is_place(first) => words,
        words => words,
    };
    let (first, last) = (words.first()?, words.last()?);
    Some(Axis { label: cell[first.start..last.end].to_owned(), axis: found, unit })
}

/// Reads `chinx` or `CHINX`, if its two other axes are among the names of all columns. A label of a letter or
/// two may be the name of a rotation, such as `RX`.
fn axis_of_three(cell: &str, cells: &HashSet<&str>) -> Option<Axis> {
    const SHORTEST: usize = 3;
    let is_upper = cell.ends_with(['X', 'Y', 'Z']);
    let axes = if is_upper { ["X", "Y", "Z"] } else { ["x", "y", "z"] };
    let axis = axes.iter().position(|axis| cell.ends_with(axis))?;
    let label = &cell[..cell.len() - 1];
    let is_label = label.len() >= SHORTEST && words(cell).len() == 1 && !is_other(label);
    let has_all = axes.iter().all(|axis| cells.contains(&*format!("{label}{axis}")));
    (is_label && has_all).then(|| Axis { label: label.to_owned(), axis, unit: String::new() })
}

fn axis(word: &str) -> Option<usize> {
    match word {
        "x" | "X" | "tx" | "Tx" | "TX" => Some(0),
        "y" | "Y" | "ty" | "Ty" | "TY" => Some(1),
        "z" | "Z" | "tz" | "Tz" | "TZ" => Some(2),
        _ => None,
    }
}

struct Word<'a> {
    text: &'a str,
    start: usize,
    end: usize,
}

/// The words of a column's name: runs of letters and runs of digits, with a new word at `X` in `chinX`.
fn words(cell: &str) -> Vec<Word<'_>> {
    let mut words: Vec<Word<'_>> = Vec::new();
    let mut before: Option<char> = None;
    for (start, c) in cell.char_indices() {
        let end = start + c.len_utf8();
        let begins = match before {
            Some(before) if before.is_alphanumeric() => {
                let is_hump = before.is_lowercase() && c.is_uppercase();
                is_hump || before.is_numeric() != c.is_numeric()
            }
            _ => true,
        };
        before = Some(c);
        if !c.is_alphanumeric() {
            continue;
        }
        match words.last_mut() {
            Some(word) if !begins => (word.end, word.text) = (end, &cell[word.start..end]),
            _ => words.push(Word { text: &cell[start..end], start, end }),
        }
    }
    words
}

/// The columns of a table with a row for each frame.
#[derive(Debug, Default)]
pub(crate) struct WideColumns {
    /// In the order of their first columns, those that have all three axes.
    pub(crate) markers: Vec<WideMarker>,
    /// Labels that lack an axis.
    pub(crate) incomplete: Vec<String>,
    /// The names of columns that are no positions, times or frames.
    pub(crate) others: Vec<String>,
    /// The unit that all columns name; empty where they name none or several.
    pub(crate) unit: String,
}

#[derive(Debug)]
pub(crate) struct WideMarker {
    pub(crate) label: String,
    /// The columns of x, y and z.
    pub(crate) columns: [usize; 3],
    /// The column of its confidence or visibility.
    pub(crate) confidence: Option<usize>,
}

/// The words behind a label that name how sure a position is.
const CONFIDENCES: [&str; 6] = ["confidence", "conf", "visibility", "presence", "score", "likelihood"];

impl WideColumns {
    pub(crate) fn of(header: &[String]) -> Self {
        let stamps = StampColumns::of(header);
        let mut found = Self::default();
        let mut order: Vec<(String, [Option<usize>; 3])> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut confidences: HashMap<String, usize> = HashMap::new();
        let mut units: Vec<String> = Vec::new();
        let cells: HashSet<&str> = header.iter().map(String::as_str).collect();
        for (column, cell) in header.iter().enumerate().filter(|(column, _)| !stamps.has(*column)) {
            if let Some(Axis { label, axis, unit }) = axis_of(cell).or_else(|| axis_of_three(cell, &cells)) {
                let place = *places.entry(label.clone()).or_insert_with(|| {
                    order.push((label, [None; 3]));
                    order.len() - 1
                });
                order[place].1[axis].get_or_insert(column);
                units.push(unit);
            } else if let Some(label) = confidence_of(cell) {
                confidences.entry(label).or_insert(column);
            } else if !cell.is_empty() {
                found.others.push(cell.clone());
            }
        }
        for (label, columns) in order {
            match columns {
                [Some(x), Some(y), Some(z)] => {
                    let confidence = confidences.get(&label).copied();
                    found.markers.push(WideMarker { label, columns: [x, y, z], confidence });
                }
                _ => found.incomplete.push(label),
            }
        }
        units.dedup();
        if let [unit] = &units[..] {
            found.unit.clone_from(unit);
        }
        found
    }
}

/// The label whose confidence a column of this name holds.
fn confidence_of(cell: &str) -> Option<String> {
    let words = words(cell);
    let (last, before) = words.split_last()?;
    let is_confidence = CONFIDENCES.contains(&&*last.text.to_ascii_lowercase());
    let (first, end) = (before.first()?, before.last()?);
    is_confidence.then(|| cell[first.start..end.end].to_owned())
}

/// The columns of a table with a row for each frame and marker.
#[derive(Debug)]
pub(crate) struct LongColumns {
    pub(crate) label: usize,
    pub(crate) axes: [usize; 3],
    pub(crate) confidence: Option<usize>,
    /// The unit that the columns name; empty where they name none.
    pub(crate) unit: String,
}

impl LongColumns {
    pub(crate) fn of(header: &[String]) -> Option<Self> {
        const LABELS: [&str; 23] = [
            "marker",
            "label",
            "name",
            "point",
            "landmark",
            "joint",
            "markername",
            "markerlabel",
            "markerid",
            "landmarkid",
            "landmarkindex",
            "landmarkname",
            "pointid",
            "pointname",
            "keypoint",
            "bodypart",
            "landmarkidx",
            "pointindex",
            "pointidx",
            "lm",
            "idx",
            "index",
            "id",
        ];
        let plain = |cell: &String| -> String {
            cell.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
        };
        let names: Vec<String> = header.iter().map(plain).collect();
        // The more telling names come first in the list.
        let label = LABELS.iter().find_map(|label| names.iter().position(|name| name == label))?;
        StampColumns::of(header).key()?;
        let mut unit = String::new();
        let mut axes = [None; 3];
        for (column, cell) in header.iter().enumerate() {
            let words = words(cell);
            let mut words: Vec<&str> = words.iter().map(|word| word.text).collect();
            if words.len() > 1 && words.last().is_some_and(|word| crate::raw_take::metres(word).is_some()) {
                unit = words.pop().unwrap_or_default().to_owned();
            }
            let found = match words[..] {
                [word] => axis(word),
                [place, word] if PLACES.contains(&&*place.to_ascii_lowercase()) => axis(word),
                [word, place] if PLACES.contains(&&*place.to_ascii_lowercase()) => axis(word),
                _ => None,
            };
            if let Some(axis) = found {
                axes[axis].get_or_insert(column);
            }
        }
        let [Some(x), Some(y), Some(z)] = axes else { return None };
        let confidence = names.iter().position(|name| CONFIDENCES.contains(&&**name));
        Some(Self { label, axes: [x, y, z], confidence, unit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read_in_many_spellings() {
        let found = |cell: &str| axis_of(cell).map(|found| (found.label, found.axis, found.unit));
        let of = |label: &str, axis, unit: &str| Some((label.to_owned(), axis, unit.to_owned()));
        for cell in
            ["chin_x", "chin.x", "chin X", "X_chin", "chin:X", "chin-x", "chin (x)", "chin[x]", "chinX"]
        {
            assert_eq!(found(cell), of("chin", 0, ""), "{cell}");
        }
        assert_eq!(found("brow_left_y"), of("brow_left", 1, ""));
        assert_eq!(found("x12"), of("12", 0, ""));
        assert_eq!(found("landmark_12_z"), of("landmark_12", 2, ""));
        assert_eq!(found("chin_pos_z"), of("chin", 2, ""));
        assert_eq!(found("chin.translateX"), of("chin", 0, ""));
        assert_eq!(found("chin_tx"), of("chin", 0, ""));
        assert_eq!(found("chin_x_mm"), of("chin", 0, "mm"));
        assert_eq!(found("chin y (cm)"), of("chin", 1, "cm"));
        assert_eq!(found("rotor_x"), of("rotor", 0, ""));
        for cell in
            ["x", "jawOpen", "", "chin", "MAX", "matrix", "time", "chin_rot_x", "headRotX", "chin.rotation.z"]
        {
            assert_eq!(found(cell), None, "{cell}");
        }
    }

    #[test]
    fn tables_are_told_apart_by_their_headers() {
        for (header, expected) in [
            ("time,chin_x,chin_y,chin_z", Table::Take),
            ("time,chin_x,chin_y", Table::Take),
            ("tim,chin_x,chin_y,chin_z", Table::Wide),
            ("frame,chin_x,chin_y,chin_z", Table::Wide),
            ("time;chin_x;chin_y;chin_z", Table::Wide),
            ("Frame\tchin X\tchin Y\tchin Z", Table::Wide),
            ("marker,x,y,z,frame", Table::Long),
            ("Time,Name,Pos_X,Pos_Y,Pos_Z", Table::Long),
            ("Timecode,BlendShapeCount,EyeBlinkLeft", Table::Curves),
            ("Frame,CTRL_expressions_jawOpen", Table::Curves),
            ("jawOpen,eyeBlink_L", Table::Curves),
            ("time,smile,anger", Table::Curves),
            // The head's place is beside the weights.
            ("time,jawOpen,eyeBlinkLeft,head_x,head_y,head_z", Table::Curves),
            ("frame,jawOpen,a.x,a.y,a.z,b.x,b.y,b.z", Table::Wide),
            ("frame,chinx,chiny,chinz", Table::Wide),
            ("Frame,CHINX,CHINY,CHINZ", Table::Wide),
            ("frame,chinx,chiny", Table::Curves),
            ("frame,RX,RY,RZ", Table::Curves),
            ("frame,rotx,roty,rotz", Table::Curves),
            ("x.jaw,y.jaw,z.jaw,frame", Table::Wide),
            ("timestamp,idx,x,y,z", Table::Long),
            // One point without a label is nothing that is known.
            ("timestamp,x,y,z", Table::Take),
            ("time,a_rot_x,a_rot_y,a_rot_z,a_pos_x,a_pos_y,a_pos_z,jaw", Table::Take),
            ("frame, face_id, timestamp, confidence, success, x_0, X_0", Table::OpenFace),
            ("a,b", Table::Take),
            ("frame,vertex", Table::Take),
            ("frame", Table::Take),
        ] {
            assert_eq!(Table::detect(header.as_bytes()), expected, "{header}");
        }
    }
}
