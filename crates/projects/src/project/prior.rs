//! The prior of a face: expressions of another neutral with the same vertices and faces.
use super::load::existing;
use super::sections::{PriorSection, Project};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{
    Error, Example, InputErrorKind, Mesh, Prior, Reach, Result, folder_of, named_file, named_folder,
};
use rhytid_geometry::registration;
use rhytid_meshes::{self as mesh, Shapes};
use std::path::{Path, PathBuf};

/// The stem of the mesh of a folder that is at rest.
const NEUTRAL: &str = "neutral";

/// The rig that a project's prior is, as a path from where the program runs. `None` if the prior is no rig.
///
/// # Errors
/// [`Error::Input`] if the file is out of reach or does not exist.
pub fn prior_rig(project: &Project, path: &Path, reach: Reach) -> Result<Option<PathBuf>> {
    match &project.prior {
        Some(prior) if is_rig(&prior.from) => existing(path, &prior.from, "[prior] from", reach).map(Some),
        _ => Ok(None),
    }
}

pub(super) fn is_rig(from: &Path) -> bool {
    from.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("safetensors"))
}

/// The files of a prior: its rig or its mesh with shapes, or the meshes of its folder. They need not exist.
pub(super) fn files(prior: &PriorSection, path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let from = folder.join(&prior.from);
    let is_file = is_rig(&from) || mesh::has_shapes(&from);
    let meshes = if is_file { vec![from] } else { meshes_in(&from).unwrap_or_default() };
    let named = prior.neutral.iter().chain(&prior.landmarks).map(|file| folder.join(file));
    meshes.into_iter().chain(named).collect()
}

/// Reads the expressions of a folder or a file and carries them to the face's neutral. `None` if the prior is
/// a rig.
///
/// The similarity that takes the other neutral to the face's turns and scales every displacement.
///
/// # Errors
/// [`Error::Input`] if the folder or its neutral is not there, if there is no expression, or if a mesh has
/// other vertices or faces than the neutral. Otherwise as the readers of meshes.
pub(super) fn read(
    section: &PriorSection,
    path: &Path,
    neutral: &Mesh,
    neutral_path: &Path,
    reach: Reach,
) -> Result<Option<Prior>> {
    if is_rig(&section.from) {
        return Ok(None);
    }
    let named = Named { section, path, neutral, neutral_path, reach };
    let other = if mesh::has_shapes(&section.from) { named.in_file()? } else { named.in_folder()? };
    let rest = points(&other.rest);
    let to = points(&neutral.positions);
    let motion = registration::fit(&rest, &to, &vec![1.0; rest.len()], true).ok_or_else(|| {
        Error::mismatch(format!(
            "{}: its vertices are on a line, so it cannot be laid over {}",
            other.rest_path.display(),
            neutral_path.display()
        ))
    })?;
    let carried = |(name, positions): (String, Vec<[f64; 3]>)| {
        let moved = points(&positions).into_iter().zip(&rest).zip(&to);
        let carried = |((x, rest), to): ((DVec3, &DVec3), &DVec3)| {
            (*to + motion.rotation * (motion.scale * (x - *rest))).to_array()
        };
        Example { name, positions: moved.map(carried).collect(), mirror: false, noise: None }
    };
    let expressions = other.expressions.into_par_iter().map(carried).collect();
    Ok(Some(Prior { expressions, weight: section.weight }))
}

/// Another face with its expressions.
struct OtherFace {
    rest_path: PathBuf,
    /// V.
    rest: Vec<[f64; 3]>,
    /// The names and V positions of the expressions.
    expressions: Vec<(String, Vec<[f64; 3]>)>,
}

fn points(positions: &[[f64; 3]]) -> Vec<DVec3> {
    positions.iter().copied().map(DVec3::from_array).collect()
}

/// Where a project names a prior, and the neutral whose vertices and faces it has to have.
#[derive(Clone, Copy)]
struct Named<'a> {
    section: &'a PriorSection,
    /// The project file.
    path: &'a Path,
    neutral: &'a Mesh,
    neutral_path: &'a Path,
    reach: Reach,
}

impl Named<'_> {
    /// The meshes of a folder.
    fn in_folder(&self) -> Result<OtherFace> {
        let Self { section, path, neutral, neutral_path, reach } = *self;
        let folder = named_folder(path, &section.from, "[prior] from", reach)?;
        let found = meshes_in(&folder).map_err(Error::io(&folder))?;
        let is_neutral =
            |file: &PathBuf| file.file_stem().is_some_and(|stem| stem.eq_ignore_ascii_case(NEUTRAL));
        let rest_path = match &section.neutral {
            Some(file) => existing(path, file, "[prior] neutral", reach)?,
            None => found.iter().find(|file| is_neutral(file)).cloned().ok_or_else(|| {
                Error::input(format!(
                "{}: [prior] from names {}, which has no mesh called {NEUTRAL}; name the face at rest that \
                 these expressions are of with neutral = FILE",
                path.display(),
                folder.display()
            ))
            .of_kind(InputErrorKind::NotThere { file: folder.join("neutral.obj") })
            })?,
        };
        let is_rest =
            |file: &PathBuf| is_neutral(file) || file.canonicalize().ok() == rest_path.canonicalize().ok();
        let files: Vec<PathBuf> = found.into_iter().filter(|file| !is_rest(file)).collect();
        if files.is_empty() {
            return Err(Error::empty(format!(
                "{}: [prior] from names {}, which has no expression in it; put meshes with the vertices of {} there",
                path.display(),
                folder.display(),
                neutral_path.display()
            )));
        }
        let rest = mesh::read_like(neutral, neutral_path, &rest_path)?;
        let expression = |file: &PathBuf| {
            let within = file.strip_prefix(folder_of(path)).unwrap_or(file);
            let file = named_file(path, within, "[prior] from", reach)?;
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            Ok((name, mesh::read_like(neutral, neutral_path, &file)?))
        };
        // Of several errors, the first in the order of the names is reported.
        let expressions: Vec<Result<_>> = files.par_iter().map(expression).collect();
        let expressions = expressions.into_iter().collect::<Result<_>>()?;
        Ok(OtherFace { rest_path, rest, expressions })
    }

    /// A mesh with its shapes.
    fn in_file(&self) -> Result<OtherFace> {
        let Self { section, path, neutral, neutral_path, reach } = *self;
        let rest_path = existing(path, &section.from, "[prior] from", reach)?;
        let Shapes { neutral: other, shapes, .. } = mesh::read_shapes(&rest_path)?;
        let order = mesh::order(&other, neutral, neutral_path, &rest_path)?;
        if shapes.is_empty() {
            return Err(Error::empty(format!(
                "{}: [prior] from names {}, which has no expression in it; export it with its blend shapes (morph \
             targets)",
                path.display(),
                rest_path.display()
            )));
        }
        let expressions = shapes.into_iter().map(|shape| {
            let positions = order.of_neutral(shape.on(&other.positions), &neutral.positions);
            (shape.name, positions)
        });
        let expressions = expressions.collect();
        let rest = order.of_neutral(other.positions, &neutral.positions);
        Ok(OtherFace { rest_path, rest, expressions })
    }
}

/// The meshes in a folder, in the order of their names.
fn meshes_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        files.push(entry?.path());
    }
    files.retain(|file| mesh::Format::from_extension(file).is_ok());
    files.sort();
    Ok(files)
}
