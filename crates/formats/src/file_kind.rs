//! The kind of a file, by its name and its first bytes. It serves messages about two files that were given
//! the wrong way round.

use rhytid_core::{Error, Result, input_file};
use rhytid_takes::raw_take::{self, Contents};
use std::fmt;
use std::path::Path;

/// The kinds of files that Rhytid reads and writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileKind {
    /// A solved rig.
    Rig,
    /// A project file, or another TOML file.
    Project,
    /// A mesh that cannot be an animation.
    Mesh,
    /// glTF: a mesh or an animation.
    Gltf,
    /// USD: an animation or shapes.
    Usd,
    /// A clean take.
    Take,
    /// What a capture system wrote.
    RawTake,
    /// Weights of shapes over time.
    Curves,
    /// A table of handles.
    Handles,
    /// A report, as JSON.
    Json,
}

impl FileKind {
    /// The kind of a file; `None` for a folder, one that cannot be opened, and one of no known kind.
    pub fn detect(path: &Path) -> Option<Self> {
        let start = input_file::start(path, 4096).ok()?;
        let header = start.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let header = String::from_utf8_lossy(header);
        let has = |column: &str| header.split([',', ';', '\t']).any(|cell| cell.trim() == column);
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match ending.as_str() {
            _ if start.get(8) == Some(&b'{') && start[..8].iter().rev().take(4).all(|byte| *byte == 0) => {
                Some(Self::Rig)
            }
            _ if start.starts_with(b"PXR-USDC") || start.starts_with(b"#usda") => Some(Self::Usd),
            "usd" | "usda" | "usdc" | "usdz" => Some(Self::Usd),
            "toml" => Some(Self::Project),
            "obj" | "ply" => Some(Self::Mesh),
            "glb" | "gltf" | "vrm" => Some(Self::Gltf),
            "json" => Some(Self::Json),
            "csv" if has("vertex") => Some(Self::Handles),
            "csv" => Some(match raw_take::contents(path) {
                Contents::Take => Self::Take,
                Contents::Raw => Self::RawTake,
                Contents::Curves => Self::Curves,
            }),
            "c3d" | "trc" | "tsv" => Some(Self::RawTake),
            _ => None,
        }
    }

    /// Refuses a file that is plainly of another kind than those `expected`.
    ///
    /// # Errors
    /// [`Error::Input`].
    pub fn expect(path: &Path, expected: &[Self]) -> Result<()> {
        match Self::detect(path) {
            Some(found) if !expected.contains(&found) => Err(Error::unsupported_format(format!(
                "{}: is {found}, expected {}",
                path.display(),
                expected.first().map_or_else(String::new, ToString::to_string)
            ))),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rig => "a rig",
            Self::Project => "a project file",
            Self::Mesh => "a mesh",
            Self::Gltf => "a glTF file",
            Self::Usd => "a USD file",
            Self::Take => "a take",
            Self::RawTake => "a raw take",
            Self::Curves => "a table of curves",
            Self::Handles => "a table of handles",
            Self::Json => "a JSON file",
        })
    }
}
