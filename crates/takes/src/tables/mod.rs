//! Tables as CSV:
//!
//! - the handles (`label,vertex`),
//! - the strain edges (`a,b`),
//! - the marker of each handle (`handle,marker`),
//! - the handles of two faces that are at the same place (`from,to`),
//! - curves.
mod landmarks;
mod markers;
pub(crate) mod rows;

pub use crate::curves::write_curves;
pub use landmarks::read_landmarks;
pub use markers::{MarkerRow, read_markers, write_markers};
use rhytid_core::text::did_you_mean;
use rhytid_core::text::quoted;
use rhytid_core::{
    AtomicFile, Error, HandleId, Handles, InputErrorKind, Result, SurfacePoint, VertexId, input_file,
};
use rows::Rows;
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

/// The column of how far each handle is from its marker.
const DISTANCE: &str = "distance_mm";

/// The columns of handles inside triangles: two more vertices of a face, and the weights of all three.
const INSIDE: [&str; 5] = ["vertex_2", "vertex_3", "weight", "weight_2", "weight_3"];

/// The weights of a handle have the sum 1 to within this, since people round them.
const SUM_WITHIN: f64 = 0.01;

/// Reads the handles from a CSV file with the header `label,vertex` (in any order).
///
/// `vertex` counts from 0. A handle inside a triangle needs the columns `vertex_2`, `vertex_3`, `weight`,
/// `weight_2` and `weight_3` as well: the three vertices of a face with their weights, whose sum is 1. These
/// cells are empty for a handle at a vertex. There may be a column `distance_mm` with the distance of each
/// handle from its marker when it was placed. Blanks around cells, blank lines and a byte order mark do not
/// count.
///
/// A vertex that occurs twice is not checked here; `rhytid_solve::examine` does that.
///
/// # Errors
/// [`Error::Input`]: another header, an empty label or one that occurs twice, a vertex that is not a whole
/// number, no rows at all. [`Error::Io`].
pub fn read_handles(path: &Path) -> Result<Handles> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    decode_handles(&bytes, &path.display().to_string())
}

/// As [`read_handles`], from the bytes of the file `name`.
///
/// # Errors
/// [`Error::Input`].
pub fn decode_handles(bytes: &[u8], name: &str) -> Result<Handles> {
    let mut rows = Rows::open(bytes, name)?;
    let has = |column: &str| rows.header().iter().any(|cell| cell == column);
    let [b, c, of_a, of_b, of_c] = INSIDE;
    let columns = match (has(b), has(DISTANCE)) {
        (true, true) => rows.columns(["label", "vertex", b, c, of_a, of_b, of_c, DISTANCE])?.to_vec(),
        (true, false) => rows.columns(["label", "vertex", b, c, of_a, of_b, of_c])?.to_vec(),
        (false, true) => rows.columns(["label", "vertex", DISTANCE])?.to_vec(),
        (false, false) => rows.columns(["label", "vertex"])?.to_vec(),
    };
    let inside = if has(b) { columns[2..7].try_into().ok() } else { None };
    let [label_column, vertex_column] = [columns[0], columns[1]];
    let mut handles = Handles::default();
    let mut seen = HashMap::new();
    while rows.next()? {
        let label = rows.text(label_column)?;
        if label.is_empty() {
            return Err(rows.error("the label is empty, expected the name of a marker"));
        }
        if let Some(first) = seen.insert(label.to_owned(), rows.offset()) {
            return Err(rows
                .error(&format!(
                    "the label {} was given in line {} already; every handle needs a label of its own",
                    quoted(label),
                    rows.line_at(first)
                ))
                .of_kind(InputErrorKind::Conflict));
        }
        handles.points.push(point(&rows, label, vertex_column, inside)?);
        handles.labels.push(label.to_owned());
    }
    if handles.labels.is_empty() {
        return Err(Error::empty(format!(
            "{name}: has no handles, expected a row label,vertex under the header for each"
        )));
    }
    Ok(handles)
}

/// The point of the handle `label` in the current row. `inside` are the places of the columns [`INSIDE`].
fn point(rows: &Rows<'_>, label: &str, vertex: usize, inside: Option<[usize; 5]>) -> Result<SurfacePoint> {
    let vertex_in = |column: usize| {
        let text = rows.text(column)?;
        text.parse().map(VertexId).map_err(|_| {
            rows.error(&format!(
                "the vertex of handle {} is {}, expected a whole number from 0 to {}",
                quoted(label),
                quoted(text),
                u32::MAX
            ))
        })
    };
    let first = vertex_in(vertex)?;
    let Some(inside) = inside.filter(|columns| columns.iter().any(|&column| !rows.cell(column).is_empty()))
    else {
        return Ok(first.into());
    };
    let weight_in = |column: usize| {
        let text = rows.text(column)?;
        let weight: Option<f64> = text.parse().ok().filter(|weight| (0.0..=1.0).contains(weight));
        weight.ok_or_else(|| {
            rows.error(&format!(
                "a weight of handle {} is {}, expected a number from 0 to 1",
                quoted(label),
                quoted(text)
            ))
        })
    };
    let [b, c, of_a, of_b, of_c] = inside;
    let corners = [first, vertex_in(b)?, vertex_in(c)?];
    let weights = [weight_in(of_a)?, weight_in(of_b)?, weight_in(of_c)?];
    let sum: f64 = weights.iter().sum();
    SurfacePoint::new(corners, weights).filter(|_| (sum - 1.0).abs() <= SUM_WITHIN).ok_or_else(|| {
        rows.error(&format!(
            "the weights of handle {} have the sum {sum}, expected three weights of a sum of 1",
            quoted(label)
        ))
    })
}

/// Reads frame numbers of a take from a CSV file with a column `frame`, counted from 0. Other columns do not
/// matter.
///
/// # Errors
/// [`Error::Input`]: no such column, a frame that is not a whole number or not below `frames`, no rows.
/// [`Error::Io`].
pub fn read_frames(path: &Path, frames: usize) -> Result<Vec<usize>> {
    read_indices(path, "frame", frames, "the last frame of the take")
}

/// Whole numbers below `count` from the column `name_of`. `last` describes the last allowed number in
/// messages.
fn read_indices(path: &Path, name_of: &str, count: usize, last: &str) -> Result<Vec<usize>> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    let name = path.display().to_string();
    let mut rows = Rows::open(&bytes, &name)?;
    let Some(column) = rows.header().iter().position(|cell| cell == name_of) else {
        return Err(rows.error(&format!(
            "the header is {}, expected a column “{name_of}”",
            quoted(&rows.header().join(","))
        )));
    };
    let mut found = Vec::new();
    while rows.next()? {
        let text = rows.text(column)?;
        match text.parse() {
            Ok(index) if index < count => found.push(index),
            _ => {
                return Err(rows
                    .error(&format!(
                        "the {name_of} is {}, expected a whole number from 0 to {}, {last}",
                        quoted(text),
                        count.saturating_sub(1)
                    ))
                    .of_kind(InputErrorKind::OutOfRange));
            }
        }
    }
    if found.is_empty() {
        return Err(Error::empty(format!("{name}: has no {name_of}, expected one in each row")));
    }
    Ok(found)
}

/// Reads vertices from a CSV file with a column `vertex`, counted from 0; other columns do not matter.
///
/// # Errors
/// [`Error::Input`]: no such column, a vertex that is not a whole number or not below `count`, no rows.
/// [`Error::Io`].
pub fn read_vertices(path: &Path, count: usize) -> Result<Vec<VertexId>> {
    let vertices = read_indices(path, "vertex", count, "the mesh's last vertex")?;
    Ok(vertices.into_iter().map(VertexId::from_index).collect())
}

/// A table to write, with these labels in it.
///
/// Labels come from files of others. Where one of them could mean something else than text to a program that
/// opens the table, such as `=A1` to a spreadsheet, all texts of the table are in quotes.
pub(crate) fn csv_of<'a>(mut labels: impl Iterator<Item = &'a str>) -> csv::Writer<Vec<u8>> {
    let is_plain = |label: &str| {
        label.starts_with(|c: char| c.is_alphanumeric() || c == '_')
            && label.chars().all(|c| c.is_alphanumeric() || "_-.: ".contains(c))
    };
    let style = if labels.all(is_plain) { csv::QuoteStyle::Necessary } else { csv::QuoteStyle::NonNumeric };
    csv::WriterBuilder::new().quote_style(style).from_writer(Vec::new())
}

/// Writes handles so that [`read_handles`] reads the same. If there are as many distances, also writes the
/// distance of each handle from its marker in millimetres.
///
/// # Errors
/// [`Error::Input`] if [`read_handles`] would not read them: labels that are empty, begin or end with a blank
/// or occur twice, or no handles at all. [`Error::Io`].
pub fn write_handles(path: &Path, handles: &Handles, distances: Option<&[f64]>) -> Result<()> {
    let mut csv = csv_of(handles.labels.iter().map(String::as_str));
    let some_inside = handles.points.iter().any(|point| point.vertex().is_none());
    let mut encode = || -> csv::Result<()> {
        let inside = INSIDE.iter().filter(|_| some_inside);
        let header = ["label", "vertex"].iter().chain(inside).chain(distances.map(|_| &DISTANCE));
        csv.write_record(header)?;
        for (i, (label, point)) in handles.labels.iter().zip(&handles.points).enumerate() {
            let mut row = vec![label.clone(), point.triangle()[0].to_string()];
            if some_inside {
                row.extend(cells_inside(point));
            }
            let distance = distances.and_then(|distances| distances.get(i));
            row.extend(distance.map(|distance| format!("{distance:.2}")));
            csv.write_record(row)?;
        }
        Ok(())
    };
    encode().map_err(|e| Error::Internal(e.to_string()))?;
    let bytes = csv.into_inner().map_err(|e| Error::Internal(e.to_string()))?;
    write_checked(path, &bytes, |name| Ok(decode_handles(&bytes, name)? == *handles))
}

/// The cells of the columns [`INSIDE`].
fn cells_inside(point: &SurfacePoint) -> [String; 5] {
    if point.vertex().is_some() {
        return Default::default();
    }
    let [_, b, c] = point.triangle();
    let [of_a, of_b, of_c] = point.weights().map(|weight| weight as f32);
    [b.to_string(), c.to_string(), of_a.to_string(), of_b.to_string(), of_c.to_string()]
}

/// Writes `bytes` if `reads_back` finds the same content in them. `reads_back` receives the name of the file.
pub fn write_checked(path: &Path, bytes: &[u8], reads_back: impl FnOnce(&str) -> Result<bool>) -> Result<()> {
    let refused =
        |reason: &str| Error::malformed(format!("not written, as it could not be read back: {reason}"));
    let name = path.display().to_string();
    match reads_back(&name) {
        Ok(true) => {}
        Ok(false) => {
            return Err(refused(&format!(
                "{name}: labels begin or end with a blank, or the lists have different lengths"
            )));
        }
        Err(e) => return Err(refused(&e.to_string())),
    }
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes).map_err(file.error())?;
    file.finish()
}

/// Reads strain edges from a CSV file with the header `a,b`: pairs of `labels`, returned as indices into
/// them.
///
/// # Errors
/// [`Error::Input`]: another header, an unknown label, an edge from a handle to itself, an edge that occurs
/// twice (in either direction), no rows at all. [`Error::Io`].
pub fn read_strain_edges(path: &Path, labels: &[String]) -> Result<Vec<[HandleId; 2]>> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    decode_strain_edges(&bytes, &path.display().to_string(), labels)
}

/// As [`read_strain_edges`], from the bytes of the file `name`.
///
/// # Errors
/// [`Error::Input`].
pub fn decode_strain_edges(bytes: &[u8], name: &str, labels: &[String]) -> Result<Vec<[HandleId; 2]>> {
    let ids = (0..).map(HandleId);
    let index: HashMap<&str, HandleId> = labels.iter().map(String::as_str).zip(ids).collect();
    let mut rows = Rows::open(bytes, name)?;
    let columns = rows.columns(["a", "b"])?;
    let mut edges = Vec::new();
    let mut seen = HashMap::new();
    while rows.next()? {
        let mut edge = [HandleId(0); 2];
        for (end, column) in edge.iter_mut().zip(columns) {
            let label = rows.text(column)?;
            *end = *index.get(label).ok_or_else(|| {
                rows.error(&format!(
                    "no handle is called {}{}, expected the label of one",
                    quoted(label),
                    did_you_mean(label, labels.iter().map(String::as_str))
                ))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.to_owned()] })
            })?;
        }
        let [a, b] = edge;
        if a == b {
            return Err(rows
                .error(&format!(
                    "the edge joins {} to itself, expected two different handles",
                    quoted(rows.text(columns[0])?)
                ))
                .of_kind(InputErrorKind::Conflict));
        }
        if let Some(first) = seen.insert((a.min(b), a.max(b)), rows.offset()) {
            return Err(rows.error(&format!(
                "the edge from {} to {} was given in line {} already; give each pair once, in either order",
                quoted(rows.text(columns[0])?),
                quoted(rows.text(columns[1])?),
                rows.line_at(first)
            )).of_kind(InputErrorKind::Conflict));
        }
        edges.push(edge);
    }
    if edges.is_empty() {
        return Err(Error::empty(format!(
            "{name}: has no edges, expected a row a,b under the header for each; \
             edges = \"auto\" in the project file finds them"
        )));
    }
    Ok(edges)
}
