//! A [`Project`] and the files it names to a [`Face`].
use super::sections::{Edges, ExampleSection, Method, Project};
use crate::{mesh, tables};
use rayon::prelude::*;
use rhytid_core::{Error, Example, Face, Handles, Result, Settings, StrainEdges};
use std::path::{Path, PathBuf};

/// Reads everything that `project` names. `path` is the project file: paths are relative to its folder, and it
/// is named in errors.
///
/// # Errors
/// [`Error::Input`]: a file that does not exist, whatever the readers of meshes, handles and strain edges find
/// wrong, an example that does not match the neutral, a handle past the neutral's last vertex. [`Error::Io`].
pub fn load(project: &Project, path: &Path) -> Result<Face> {
    let neutral_path = existing(path, &project.mesh.neutral, "[mesh] neutral")?;
    let neutral = mesh::read(&neutral_path)?;

    let handles_path = existing(path, &project.handles.vertices, "[handles] vertices")?;
    let handles = tables::read_handles(&handles_path)?;
    check_vertices(&handles, &handles_path, neutral.positions.len(), &neutral_path)?;

    let strain_edges = match &project.strain.edges {
        Edges::Auto => StrainEdges::Auto,
        Edges::File(edges) => {
            let edges_path = existing(path, edges, "[strain] edges")?;
            StrainEdges::Given(tables::read_strain_edges(&edges_path, &handles.labels)?)
        }
    };

    let read_example = |example: &ExampleSection| {
        let key = format!("[[example]] {:?}: mesh", example.name);
        let example_path = existing(path, &example.mesh, &key)?;
        let positions = mesh::read_like(&neutral, &neutral_path, &example_path)?;
        Ok(Example { name: example.name.clone(), positions, mirror: example.mirror })
    };
    // Of several errors the first in the file's order is told.
    let examples: Vec<Result<Example>> = project.examples.par_iter().map(read_example).collect();
    let examples = examples.into_iter().collect::<Result<_>>()?;

    let stem = || path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Ok(Face {
        name: project.mesh.name.clone().unwrap_or_else(stem),
        neutral,
        metres_per_unit: project.mesh.units.metres_per_unit(),
        up_axis: project.mesh.up,
        handles,
        examples,
        settings: Settings {
            bending_length: project.large_scale.bending_length,
            method: match project.method {
                Method::Learned => rhytid_core::Method::Learned(project.learned.settings()),
                Method::Chapter => rhytid_core::Method::Chapter,
            },
            bind: project.large_scale.bind,
            strain_edges,
            max_influences: project.fine_scale.max_influences,
        },
    })
}

/// `file` as seen from the project file, if it is there.
fn existing(project: &Path, file: &Path, key: &str) -> Result<PathBuf> {
    let path = project.parent().unwrap_or(Path::new("")).join(file);
    let complaint = match path.metadata() {
        Ok(metadata) if metadata.is_dir() => "is a folder, expected a file",
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            "does not exist; paths are relative to the project file"
        }
        _ => return Ok(path),
    };
    Err(Error::input(format!("{}: {key} names {}, which {complaint}", project.display(), path.display())))
}

fn check_vertices(handles: &Handles, path: &Path, count: usize, neutral: &Path) -> Result<()> {
    match handles.labels.iter().zip(&handles.vertices).find(|&(_, &vertex)| vertex as usize >= count) {
        None => Ok(()),
        Some((label, vertex)) => Err(Error::input(format!(
            "{}: handle {label:?} is at vertex {vertex}, but {} has {count} vertices, expected 0 to {}",
            path.display(),
            neutral.display(),
            count.saturating_sub(1)
        ))),
    }
}
