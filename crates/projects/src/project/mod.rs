//! The project file, FACE.toml: which files make up a face, and the choices of its solve. See
//! `docs/project-file.md`.
mod examples;
mod load;
mod named_parts;
mod parse;
mod prior;
mod sculpted;
mod sections;
mod space;

pub use crate::pattern::fits;
pub use examples::meshes_fitting;
pub use load::{files, load, load_without_handles};
pub use parse::parse;
pub use prior::prior_rig;
pub use sections::{
    Edges, ExampleSection, FineScaleSection, HandlesSection, LargeScaleSection, LearnedSection, MeshSection,
    Method, PinsSection, PriorSection, Project, StrainSection, Units,
};

use rhytid_core::{Error, Face, InputErrorKind, Reach, Result, input_file};
use rhytid_takes::tables::write_checked;
use std::path::Path;

/// Reads a project file and everything it names within `reach`.
///
/// # Errors
/// [`Error::Input`] as of [`parse()`] and [`load()`], and for a prior that is a rig. Only a transfer can
/// carry it over: `rhytid_transfer::read_face`. [`Error::Io`].
pub fn read(path: &Path, reach: Reach) -> Result<Face> {
    let project = read_project(path)?;
    if let Some(rig) = prior_rig(&project, path, reach)? {
        return Err(Error::input(format!(
            "{}: [prior] from names {}, a rig, which has to be transferred: read the project with \
             rhytid_transfer::read_face, or name a folder of meshes",
            path.display(),
            rig.display()
        ))
        .of_kind(InputErrorKind::Conflict));
    }
    load(&project, path, reach)
}

/// Reads a project file alone, without the files that it names.
///
/// # Errors
/// [`Error::Input`] as of [`parse()`]; [`Error::Io`].
pub fn read_project(path: &Path) -> Result<Project> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    let name = path.display().to_string();
    let text = std::str::from_utf8(&bytes).map_err(|e| {
        let line = rhytid_core::text::line_of(&bytes, e.valid_up_to());
        Error::malformed(format!("{name}, line {line}: not UTF-8 text, expected a project file in TOML"))
            .of_kind(InputErrorKind::Malformed { line: Some(line) })
    })?;
    parse(text, &name)
}

/// Writes a project file so that [`parse()`] reads the same project.
///
/// # Errors
/// [`Error::Input`] if [`parse()`] would not read it; [`Error::Io`].
pub fn write(path: &Path, project: &Project) -> Result<()> {
    let text = toml::to_string(project)
        .map_err(|e| Error::malformed(format!("{}: not written: {e}", path.display())))?;
    write_checked(path, text.as_bytes(), |name| Ok(parse(&text, name)? == *project))
}
