//! The examples that a project's sections stand for: a mesh each, shapes of one file, or the files that a
//! pattern fits.
use super::load::{existing, points};
use super::sculpted;
use super::sections::{ExampleSection, Project};
use super::space::NeutralSpace;
use crate::pattern::{fits, is_pattern};
use rayon::prelude::*;
use rhytid_core::text::{did_you_mean, quoted};
use rhytid_core::{Error, Example, InputErrorKind, Mesh, Reach, Result, named_file};
use rhytid_meshes::{self as mesh, Selection, Shape, Shapes};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A project and the neutral that its examples are of.
#[derive(Clone, Copy)]
pub(super) struct Of<'a> {
    pub(super) project: &'a Project,
    /// The project file.
    pub(super) path: &'a Path,
    pub(super) reach: Reach,
    pub(super) neutral: &'a Mesh,
    pub(super) neutral_path: &'a Path,
    pub(super) space: NeutralSpace,
}

/// An example and the number of the section that it comes from.
pub(super) struct OfSection {
    pub(super) section: usize,
    pub(super) example: Example,
}

/// A section with one of its files.
struct Source<'a> {
    number: usize,
    section: &'a ExampleSection,
    file: PathBuf,
}

/// Reads all examples of a project, in the order of its sections.
///
/// # Errors
/// [`Error::Input`] if a file or shape is not there or does not match the neutral, or if two examples have
/// the same name; [`Error::Io`].
pub(super) fn read(of: Of<'_>) -> Result<Vec<OfSection>> {
    let mut sources = Vec::new();
    for (number, section) in of.project.examples.iter().enumerate() {
        for file in files(section, of)? {
            sources.push(Source { number, section, file });
        }
    }
    // A file that many sections name is read once.
    let mut groups: Vec<Vec<&Source<'_>>> = Vec::new();
    for source in &sources {
        let is_same = |group: &&mut Vec<&Source<'_>>| {
            group[0].file == source.file && selection(group[0].section) == selection(source.section)
        };
        match groups.iter_mut().find(is_same) {
            Some(group) => group.push(source),
            None => groups.push(vec![source]),
        }
    }
    let read: Vec<Result<Vec<OfSection>>> = groups.par_iter().map(|group| of_file(group, of)).collect();
    // Of several errors, the first in the order of the sections is reported.
    let mut examples = Vec::new();
    for group in read {
        examples.extend(group?);
    }
    examples.sort_by_key(|example| example.section);
    check_names(&examples, of.path)?;
    Ok(examples)
}

/// Refuses two examples of one name.
fn check_names(examples: &[OfSection], path: &Path) -> Result<()> {
    let mut sections: HashMap<&str, usize> = HashMap::new();
    for OfSection { section, example } in examples {
        if let Some(first) = sections.insert(&example.name, *section) {
            return Err(Error::conflict(format!(
                "{}: two examples are called {}, of [[example]] {} and {} (counted from 1); give one of them another \
                 name",
                path.display(),
                quoted(&example.name),
                first + 1,
                section + 1
            )));
        }
    }
    Ok(())
}

/// What of its file a section means.
fn selection(section: &ExampleSection) -> Selection {
    Selection { prim: section.prim.clone(), time: section.time }
}

/// How messages name a key of a section.
fn key_of(section: &ExampleSection, key: &str) -> String {
    match &section.name {
        Some(name) => format!("[[example]] {name:?}: {key}"),
        None => format!("[[example]] {key}"),
    }
}

/// The files of a section: the one that it names, or those that its pattern fits.
fn files(section: &ExampleSection, of: Of<'_>) -> Result<Vec<PathBuf>> {
    let key = key_of(section, "mesh");
    if !section.names_files() {
        return Ok(vec![existing(of.path, &section.mesh, &key, of.reach)?]);
    }
    let mut files = Vec::new();
    for file in fitting(&section.mesh, of.path) {
        files.push(named_file(of.path, &file, &key, of.reach)?);
    }
    // The neutral may be among the files that a pattern fits.
    let neutral = of.neutral_path.canonicalize().ok();
    files.retain(|file| file.canonicalize().ok() != neutral);
    if files.is_empty() {
        return Err(Error::input(format!(
            "{}: {key} is {}, which fits no file; paths are relative to the project file, # stands for a digit and * \
             for anything",
            of.path.display(),
            quoted(&section.mesh.to_string_lossy())
        ))
        .of_kind(InputErrorKind::NotThere { file: section.mesh.clone() }));
    }
    Ok(files)
}

/// The meshes whose names fit a pattern such as `poses/*.obj`, by name. A name without a `*` fits itself.
pub fn meshes_fitting(pattern: &Path) -> Vec<PathBuf> {
    fitting(pattern, Path::new(""))
}

/// The meshes whose names fit a pattern, relative to the folder of the project file `path`, by name.
pub(super) fn fitting(pattern: &Path, path: &Path) -> Vec<PathBuf> {
    let within = pattern.parent().unwrap_or(Path::new(""));
    let wanted = pattern.file_name().unwrap_or_default().to_string_lossy();
    let folder = path.parent().unwrap_or(Path::new("")).join(within);
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_mesh = mesh::Format::from_extension(Path::new(&name)).is_ok();
        if is_mesh && fits(&wanted, &name.to_string_lossy()) {
            found.push(within.join(name));
        }
    }
    found.sort();
    found
}

/// The examples of sections that mean the same of the same file.
fn of_file(group: &[&Source<'_>], of: Of<'_>) -> Result<Vec<OfSection>> {
    let file = &group[0].file;
    let with_shapes = group.iter().any(|source| source.section.has_shapes());
    if with_shapes && !mesh::has_shapes(file) {
        let source = group.iter().find(|source| source.section.has_shapes()).unwrap_or(&group[0]);
        return Err(Error::unsupported_format(format!(
            "{}: {} names {}, a file without shapes; name a glTF or USD file that has blend shapes",
            of.path.display(),
            key_of(source.section, "mesh"),
            file.display()
        )));
    }
    let read = mesh::read_file(file, &selection(group[0].section), with_shapes)?;
    let Shapes { neutral: rest, shapes, space, .. } = read;
    let order = mesh::order(&rest, of.neutral, of.neutral_path, file)?;
    let mut examples = Vec::new();
    for source in group {
        let section = source.section;
        for Pose { name, positions } in poses(section, file, &rest.positions, &shapes, of.path)? {
            let mut positions = order.of_neutral(positions, &of.neutral.positions);
            of.space.take_in(&mut positions, space, section);
            let positions = with_map(positions, section, of)?;
            let example = Example { name, positions, mirror: section.mirror, noise: section.noise };
            examples.push(OfSection { section: source.number, example });
        }
    }
    Ok(examples)
}

/// A pose in the space of its file.
struct Pose {
    name: String,
    positions: Vec<[f64; 3]>,
}

/// The poses that a section takes of a file: the mesh itself, one pose of some shapes, or one pose for each
/// shape.
fn poses(
    section: &ExampleSection,
    file: &Path,
    rest: &[[f64; 3]],
    shapes: &[Shape],
    path: &Path,
) -> Result<Vec<Pose>> {
    let weight = section.weight.unwrap_or(1.0);
    let stem = || file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if !section.has_shapes() {
        let name = section.name.clone().unwrap_or_else(stem);
        return Ok(vec![Pose { name, positions: rest.to_vec() }]);
    }
    let known = || shapes.iter().map(|shape| shape.name.as_str());
    if section.shapes.is_empty() {
        let mut positions = rest.to_vec();
        for wanted in &section.shape {
            let Some(shape) = shapes.iter().find(|shape| shape.name == *wanted) else {
                return Err(unknown_shape(section, "shape", wanted, file, known(), path));
            };
            add(&mut positions, shape, weight);
        }
        let name = section.name_of_one().unwrap_or_default();
        return Ok(vec![Pose { name, positions }]);
    }
    for wanted in &section.shapes {
        if !shapes.iter().any(|shape| fits(wanted, &shape.name)) {
            return Err(unknown_shape(section, "shapes", wanted, file, known(), path));
        }
    }
    let mut poses = Vec::new();
    for shape in shapes.iter().filter(|shape| section.shapes.iter().any(|wanted| fits(wanted, &shape.name))) {
        if shape.moved.is_empty() {
            log::warn!(
                "{}: the shape {} moves nothing, so it is left out",
                file.display(),
                quoted(&shape.name)
            );
            continue;
        }
        let mut positions = rest.to_vec();
        add(&mut positions, shape, weight);
        poses.push(Pose { name: shape.name.clone(), positions });
    }
    Ok(poses)
}

fn add(positions: &mut [[f64; 3]], shape: &Shape, weight: f64) {
    for (v, by) in &shape.moved {
        positions[*v as usize].iter_mut().zip(by).for_each(|(x, by)| *x += weight * by);
    }
}

fn unknown_shape<'a>(
    section: &ExampleSection,
    key: &str,
    wanted: &str,
    file: &Path,
    known: impl Iterator<Item = &'a str> + Clone,
    path: &Path,
) -> Error {
    const SHOWN: usize = 12;
    let count = known.clone().count();
    let names: Vec<&str> = known.clone().take(SHOWN).collect();
    let found = match count {
        0 => "no shapes; export it with its blend shapes (shape keys, morph targets)".to_owned(),
        count if count > SHOWN => format!("{} and {} more", names.join(", "), count - SHOWN),
        _ => names.join(", "),
    };
    let of_kind = InputErrorKind::UnknownName { name: wanted.to_owned() };
    let near = if is_pattern(wanted) { String::new() } else { did_you_mean(wanted, known) };
    Error::input(format!(
        "{}: {} has {}{near}, but {} has {found}",
        path.display(),
        key_of(section, key),
        quoted(wanted),
        file.display()
    ))
    .of_kind(of_kind)
}

/// The positions with the section's map on them.
fn with_map(positions: Vec<[f64; 3]>, section: &ExampleSection, of: Of<'_>) -> Result<Vec<[f64; 3]>> {
    let Of { project, path, reach, neutral, neutral_path, space } = of;
    if section.displacement.is_none() && section.normal_map.is_none() {
        return Ok(positions);
    }
    let points = points(project, neutral, &positions);
    let mut mapped = if let (Some(map), Some(millimetres)) = (&section.displacement, section.millimetres) {
        let map = existing(path, map, &key_of(section, "displacement"), reach)?;
        let full = millimetres * 1e-3 / space.metres_per_unit;
        sculpted::displaced(neutral, neutral_path, positions, &map, full)?
    } else if let Some(map) = &section.normal_map {
        let map = existing(path, map, &key_of(section, "normal_map"), reach)?;
        let strength = section.strength.unwrap_or(1.0);
        sculpted::with_normal_map(neutral, neutral_path, positions, &map, section.green, strength)?
    } else {
        positions
    };
    // A map has both sides of a seam, and the normals there differ.
    if let Some(points) = points {
        points.even_out(&mut mapped);
    }
    Ok(mapped)
}
