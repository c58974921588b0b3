//! Reads the files that a [`Project`] names, and makes a [`Face`] of them.
use super::prior;
use super::sculpted;
use super::sections::{Edges, ExampleSection, Method, PinsSection, Project, Units};
use rayon::prelude::*;
use rhytid_core::text::did_you_mean;
use rhytid_core::text::quoted;
use rhytid_core::{
    Error, Example, Face, Handles, InputErrorKind, Mesh, Pins, Reach, Result, Settings, StrainEdges,
    SurfacePoint, UpAxis, VertexId, named_file,
};
use rhytid_geometry::{Axes, Points};
use rhytid_meshes as mesh;
use rhytid_takes::tables;
use std::path::{Path, PathBuf};

/// Reads everything that `project` names within `reach`, except a prior that is a rig ([`super::prior_rig`]).
/// `path` is the project file: paths are relative to
/// its folder, and it is named in errors.
///
/// # Errors
/// [`Error::Input`]: a file that does not exist or is out of reach, an example that does not match the
/// neutral, or a handle past the neutral's last vertex. Also every error of the readers of meshes, handles
/// and strain edges. [`Error::Io`].
pub fn load(project: &Project, path: &Path, reach: Reach) -> Result<Face> {
    let neutral_path = existing(path, &project.mesh.neutral, "[mesh] neutral", reach)?;
    let handles_path = existing_table(path, &project.handles.vertices, "[handles] vertices", reach)?;
    let mut face = load_without_handles(project, path, reach)?;
    face.handles = tables::read_handles(&handles_path)?;
    check_vertices(&face.handles, &handles_path, face.neutral.positions.len(), &neutral_path)?;
    for (section, example) in project.examples.iter().zip(&mut face.examples) {
        if let (Some(take), Some(frame)) = (&section.take, section.frame) {
            let key = format!("[[example]] {:?}: take", section.name);
            let take = existing(path, take, &key, reach)?;
            let unit = face.metres_per_unit;
            let before = example.positions.clone();
            sculpted::place_handles(
                &mut example.positions,
                &face.handles,
                unit,
                &take,
                frame,
                &section.name,
            )?;
            if let Some(points) = points(project, &face.neutral, &before) {
                points.follow(&before, &mut example.positions);
            }
        }
    }
    if let Edges::File(edges) = &project.strain.edges {
        let edges_path = existing_table(path, edges, "[strain] edges", reach)?;
        face.settings.strain_edges =
            StrainEdges::Given(tables::read_strain_edges(&edges_path, &face.handles.labels)?);
    }
    Ok(face)
}

/// The same without the handles and strain edges, whose files need not be there yet.
///
/// # Errors
/// As [`load`].
pub fn load_without_handles(project: &Project, path: &Path, reach: Reach) -> Result<Face> {
    let neutral_path = existing(path, &project.mesh.neutral, "[mesh] neutral", reach)?;
    let neutral = mesh::read(&neutral_path)?;

    let read_example = |example: &ExampleSection| {
        let key = format!("[[example]] {:?}: mesh", example.name);
        let example_path = existing(path, &example.mesh, &key, reach)?;
        let mut positions = mesh::read_like(&neutral, &neutral_path, &example_path)?;
        to_neutral(&mut positions, example, project);
        let has_map = example.displacement.is_some() || example.normal_map.is_some();
        let points = if has_map { points(project, &neutral, &positions) } else { None };
        if let (Some(map), Some(millimetres)) = (&example.displacement, example.millimetres) {
            let key = format!("[[example]] {:?}: displacement", example.name);
            let map = existing(path, map, &key, reach)?;
            let full = millimetres * 1e-3 / project.mesh.units.metres_per_unit();
            positions = sculpted::displaced(&neutral, &neutral_path, positions, &map, full)?;
        }
        if let Some(map) = &example.normal_map {
            let map = existing(path, map, &format!("[[example]] {:?}: normal_map", example.name), reach)?;
            let strength = example.strength.unwrap_or(1.0);
            positions =
                sculpted::with_normal_map(&neutral, &neutral_path, positions, &map, example.green, strength)?;
        }
        // A map has both sides of a seam, and the normals there differ.
        if let Some(points) = points {
            points.even_out(&mut positions);
        }
        Ok(Example { name: example.name.clone(), positions, mirror: example.mirror, noise: example.noise })
    };
    // Of several errors, the first in the order of the file is reported.
    let examples: Vec<Result<Example>> = project.examples.par_iter().map(read_example).collect();
    let examples = examples.into_iter().collect::<Result<_>>()?;

    let prior = match &project.prior {
        Some(section) => prior::read(section, path, &neutral, &neutral_path, reach)?,
        None => None,
    };
    let pins = Pins {
        auto: project.pins.auto,
        vertices: pinned_vertices(&project.pins, path, &neutral, &neutral_path, reach)?,
    };
    let stem = || path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    Ok(Face {
        name: project.mesh.name.clone().unwrap_or_else(stem),
        neutral,
        metres_per_unit: project.mesh.units.metres_per_unit(),
        up_axis: project.mesh.up,
        handles: Handles::default(),
        examples,
        prior,
        settings: Settings {
            weld: project.mesh.welds(),
            bending_length: project.large_scale.bending_length,
            rotations: project.large_scale.rotations,
            method: match project.method {
                Method::Learned => rhytid_core::Method::Learned(project.learned.settings()),
                Method::Chapter => rhytid_core::Method::Chapter,
            },
            bind: project.large_scale.bind,
            contact: project.contact,
            align: project.align,
            pins,
            strain_edges: StrainEdges::Auto,
            max_influences: project.fine_scale.max_influences,
        },
    })
}

/// The points of the neutral and of an example's positions, if the project joins vertices.
fn points(project: &Project, neutral: &Mesh, example: &[[f64; 3]]) -> Option<Points> {
    project.mesh.welds().then(|| Points::new(neutral, &[example])).flatten()
}

/// Takes an example's positions from the space of its file to the neutral's.
///
/// glTF is in metres, and its y points up. A project says what the space of its neutral is. So an example as
/// glTF is known to be in another space only beside a neutral of another format.
fn to_neutral(positions: &mut [[f64; 3]], example: &ExampleSection, project: &Project) {
    let is_gltf = |file: &Path| matches!(mesh::Format::from_extension(file), Ok(mesh::Format::Gltf));
    let differs = is_gltf(&example.mesh) && !is_gltf(&project.mesh.neutral);
    let of_file = if differs { Units::Metres } else { project.mesh.units };
    let unit = example.unit.unwrap_or(of_file).metres_per_unit();
    let factor = unit / project.mesh.units.metres_per_unit() * example.scale.unwrap_or(1.0);
    let axes = match project.mesh.up {
        UpAxis::Z if differs => Axes::Y_UP_TO_Z_UP,
        _ => Axes::SAME,
    };
    let axes = example.axes.unwrap_or(axes);
    if factor != 1.0 || axes != Axes::SAME {
        positions.iter_mut().for_each(|x| *x = axes.apply(*x).map(|x| factor * x));
    }
}

/// The files that a project is read from, that of the project first. They need not exist.
pub fn files(project: &Project, path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let edges = match &project.strain.edges {
        Edges::File(edges) => Some(edges),
        Edges::Auto => None,
    };
    let named = [&project.mesh.neutral, &project.handles.vertices].into_iter();
    let named = named.chain(project.examples.iter().flat_map(|example| {
        let maps = example.displacement.iter().chain(&example.normal_map);
        std::iter::once(&example.mesh).chain(&example.take).chain(maps)
    }));
    let named = named.chain(&project.pins.vertices).chain(edges);
    let of_prior = project.prior.iter().flat_map(|section| prior::files(section, path));
    let named = named.map(|file| folder.join(file)).chain(of_prior);
    std::iter::once(path.to_owned()).chain(named).collect()
}

/// The vertices that the section names, ascending.
fn pinned_vertices(
    pins: &PinsSection,
    path: &Path,
    neutral: &Mesh,
    neutral_path: &Path,
    reach: Reach,
) -> Result<Vec<VertexId>> {
    let mut pinned = Vec::new();
    if let Some(file) = &pins.vertices {
        let file = existing_table(path, file, "[pins] vertices", reach)?;
        pinned.extend(tables::read_vertices(&file, neutral.positions.len())?);
    }
    let refused =
        |key: &str, what: &str| Err(Error::out_of_range(format!("{}: [pins] {key} {what}", path.display())));
    if let Some([low, high]) = pins.bounds {
        let is_in = |x: &[f64; 3]| (0..3).all(|c| (low[c]..=high[c]).contains(&x[c]));
        let vertices = (0..).map(VertexId);
        let inside = neutral.positions.iter().zip(vertices).filter(|(x, _)| is_in(x)).map(|(_, v)| v);
        let before = pinned.len();
        pinned.extend(inside);
        if pinned.len() == before {
            let [low, high] = neutral.bounds().unwrap_or_default();
            return refused(
                "box",
                &format!(
                    "has no vertex of the neutral in it, which reaches from {low:?} to {high:?}; check that \
                     the box is in mesh units"
                ),
            );
        }
    }
    if !pins.groups.is_empty() {
        let groups = mesh::read_groups(neutral, neutral_path, neutral_path)?;
        for name in &pins.groups {
            let Some((_, vertices)) = groups.iter().find(|(known, _)| known == name) else {
                let unknown = InputErrorKind::UnknownName { name: name.clone() };
                return refused(
                    "groups",
                    &format!(
                        "has {}{}, expected names of groups in {}",
                        quoted(name),
                        did_you_mean(name, groups.iter().map(|(name, _)| name.as_str())),
                        neutral_path.display()
                    ),
                )
                .map_err(|error| error.of_kind(unknown));
            };
            pinned.extend(vertices.iter().copied().map(VertexId));
        }
    }
    pinned.sort_unstable();
    pinned.dedup();
    Ok(pinned)
}

/// The extensions of tables.
const TABLES: [&str; 3] = ["csv", "tsv", "txt"];

/// As [`existing`], for a table.
fn existing_table(project: &Path, file: &Path, key: &str, reach: Reach) -> Result<PathBuf> {
    let extension = file.extension().unwrap_or_default();
    if !TABLES.iter().any(|known| extension.eq_ignore_ascii_case(known)) {
        return Err(Error::bad_path(format!(
            "{}: {key} names {}, expected a table that ends in .csv, .tsv or .txt",
            project.display(),
            file.display()
        )));
    }
    existing(project, file, key, reach)
}

/// `file` as seen from the project file, if it is there and within reach.
pub(super) fn existing(project: &Path, file: &Path, key: &str, reach: Reach) -> Result<PathBuf> {
    let path = named_file(project, file, key, reach)?;
    match path.metadata() {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err(Error::input(format!(
            "{}: {key} names {}, which does not exist; paths are relative to the project file",
            project.display(),
            path.display()
        ))
        .of_kind(InputErrorKind::NotThere { file: path.clone() })),
        _ => Ok(path),
    }
}

fn check_vertices(handles: &Handles, path: &Path, count: usize, neutral: &Path) -> Result<()> {
    let beyond = |point: &SurfacePoint| point.triangle().into_iter().find(|v| v.index() >= count);
    let mut found = handles.labels.iter().zip(&handles.points);
    match found.find_map(|(label, point)| Some((label, beyond(point)?))) {
        None => Ok(()),
        Some((label, vertex)) => Err(Error::out_of_range(format!(
            "{}: handle {label:?} is at vertex {vertex}, but {} has {count} vertices, expected 0 to {}",
            path.display(),
            neutral.display(),
            count.saturating_sub(1)
        ))),
    }
}
