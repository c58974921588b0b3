//! The edits of a take, EDIT.toml: changes that an artist makes to a take without touching the rig or the
//! take. See `docs/edits.md`.

mod curve;
mod parse;

pub use curve::{Curve, Ease};
pub use parse::parse;

use rhytid_core::{Error, InputErrorKind, Result, input_file};
use rhytid_takes::tables::write_checked;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The content of a file of edits. Paths are relative to the file.
///
/// The edited displacement of a marker from rest is `Π gains · (p − rest) + Σ offsets + Σ added`; the order
/// in the file does not matter. Then the holds, one after the other, keep the marker where it is. The
/// wrinkles are multiplied by all gains of the detail. Corrections come last. Each one starts from the frame
/// that those before it have made.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Edits {
    /// `[region.NAME]`, by their names.
    #[serde(rename = "region", skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, Region>,
    /// Each `[[gain]]`.
    #[serde(rename = "gain", skip_serializing_if = "Vec::is_empty")]
    pub gains: Vec<Gain>,
    /// Each `[[offset]]`.
    #[serde(rename = "offset", skip_serializing_if = "Vec::is_empty")]
    pub offsets: Vec<Offset>,
    /// Each `[[add]]`.
    #[serde(rename = "add", skip_serializing_if = "Vec::is_empty")]
    pub added: Vec<Added>,
    /// Each `[[hold]]`.
    #[serde(rename = "hold", skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<Hold>,
    /// Each `[[correction]]`.
    #[serde(rename = "correction", skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<Correction>,
    /// Each `[[detail]]`.
    #[serde(rename = "detail", skip_serializing_if = "Vec::is_empty")]
    pub details: Vec<Gain>,
}

/// `[region.NAME]`: a part of the face, given in one of three ways: by markers, by groups or by painted
/// weights.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Region {
    /// Labels of handles, or the words that labels contain (lips, brows …). `*` stands for any letters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<String>,
    /// Names of groups in the mesh `of`, an OBJ.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<String>,
    /// The OBJ with the groups: a mesh like the rig's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<PathBuf>,
    /// A PLY or USD file with the rig's vertices, which has been painted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
    /// The property or primvar of its vertices that has the weights: from 0 to 1, or whole numbers from 0 to
    /// 255.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub property: Option<String>,
}

/// `[[gain]]` and `[[detail]]`: a factor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gain {
    /// The place; `None` is the whole face. It is the name of a region, or else a word or label as in
    /// [`Region::markers`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// The factor, from 0; 1 changes nothing.
    pub by: Curve,
    /// The easing of `by`.
    #[serde(skip_serializing_if = "is_default")]
    pub ease: Ease,
}

/// `[[offset]]`: markers moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Offset {
    /// The place, as in [`Gain`]; given with `millimetres` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// The movement along the mesh's axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub millimetres: Option<[f64; 3]>,
    /// Instead, a movement for each of these handles, in millimetres: a pose.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub markers: BTreeMap<String, [f64; 3]>,
    /// The factor.
    #[serde(skip_serializing_if = "is_one")]
    pub amount: Curve,
    /// The easing of `amount`.
    #[serde(skip_serializing_if = "is_default")]
    pub ease: Ease,
}

/// `[[add]]`: another take's displacements from rest on top.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Added {
    /// The other take's CSV. Markers that it lacks stay as they are.
    pub take: PathBuf,
    /// The frame of this take at which the other one begins. From there on, the other take plays at its own
    /// times. Its first and last frames hold before its start and after its end.
    pub frame: f64,
    /// The place, as in [`Gain`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// The factor.
    #[serde(skip_serializing_if = "is_one")]
    pub amount: Curve,
    /// The easing of `amount`.
    #[serde(skip_serializing_if = "is_default")]
    pub ease: Ease,
}

/// `[[hold]]`: markers that stay where they are, without any noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hold {
    /// The place, as in [`Gain`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// The first frame and the frame behind the last; written as `"A..B"`.
    #[serde(serialize_with = "as_range")]
    pub frames: Range<usize>,
    /// The frame whose positions are held; by default the first of `frames`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<usize>,
    /// The number of frames before and behind, over which the hold blends in and out smoothly.
    pub ease: usize,
}

/// `[[correction]]`: a frame that was sculpted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correction {
    /// The sculpted mesh, with the rig's vertices and polygons.
    pub mesh: PathBuf,
    /// The frame of the take that was sculpted.
    pub frame: usize,
    /// The place, as in [`Gain`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// The factor.
    #[serde(skip_serializing_if = "is_one")]
    pub amount: Curve,
    /// The easing of `amount`.
    #[serde(skip_serializing_if = "is_default")]
    pub ease: Ease,
    /// How far a frame's strains may be from those of the sculpted frame, a ratio. `None` is half the
    /// distance of the strains of the rest pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
}

impl Edits {
    /// The files that the edits name, as written, each with its key.
    pub fn named_files(&self) -> impl Iterator<Item = (String, &Path)> {
        let takes = self.added.iter().map(|added| ("[[add]] take".to_owned(), &*added.take));
        let sculpted = self.corrections.iter().map(|c| ("[[correction]] mesh".to_owned(), &*c.mesh));
        let regions = self.regions.iter().flat_map(|(name, region)| {
            let of = region.of.iter().map(move |file| (format!("[region.{name}] of"), &**file));
            of.chain(region.weights.iter().map(move |file| (format!("[region.{name}] weights"), &**file)))
        });
        takes.chain(regions).chain(sculpted)
    }
}

fn is_default(ease: &Ease) -> bool {
    *ease == Ease::default()
}

fn is_one(curve: &Curve) -> bool {
    curve.is_constantly(1.0)
}

fn as_range<S: serde::Serializer>(frames: &Range<usize>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{}..{}", frames.start, frames.end))
}

/// Reads a file of edits and returns its text too. The files that it names are not read.
///
/// # Errors
/// [`Error::Input`] as of [`parse()`]; [`Error::Io`].
pub fn read(path: &Path) -> Result<(Edits, String)> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    let name = path.display().to_string();
    let text = String::from_utf8(bytes).map_err(|e| {
        let line = rhytid_core::text::line_of(e.as_bytes(), e.utf8_error().valid_up_to());
        Error::malformed(format!("{name}, line {line}: not UTF-8 text, expected edits in TOML"))
            .of_kind(InputErrorKind::Malformed { line: Some(line) })
    })?;
    Ok((parse(&text, &name)?, text))
}

/// The text of edits, as [`write()`] writes it. It is not checked.
///
/// # Errors
/// [`Error::Input`] if TOML cannot have them.
pub fn text(edits: &Edits) -> Result<String> {
    toml::to_string(edits).map_err(|e| Error::malformed(format!("the edits cannot be written: {e}")))
}

/// Writes a file of edits so that [`parse()`] reads the same edits.
///
/// # Errors
/// [`Error::Input`] if [`parse()`] would not read them; [`Error::Io`].
pub fn write(path: &Path, edits: &Edits) -> Result<()> {
    let text = text(edits).map_err(|error| error.in_file(path.display()))?;
    write_checked(path, text.as_bytes(), |name| Ok(parse(&text, name)? == *edits))
}
