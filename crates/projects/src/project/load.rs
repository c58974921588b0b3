//! Reads the files that a [`Project`] names, and makes a [`Face`] of them.
use super::examples::{self, Of, OfSection};
use super::named_parts;
use super::prior;
use super::sculpted;
use super::sections::{Edges, ExampleSection, Method, PinsSection, Project};
use super::space::NeutralSpace;
use rhytid_core::text::did_you_mean;
use rhytid_core::text::quoted;
use rhytid_core::{
    Error, Face, Handles, InputErrorKind, Mesh, Pins, Reach, Result, Settings, StrainEdges, SurfacePoint,
    VertexId, named_file,
};
use rhytid_geometry::Points;
use rhytid_meshes::{self as mesh, Selection, Shapes};
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
    let Loaded { mut face, sections } = loaded(project, path, reach)?;
    face.handles = tables::read_handles(&handles_path)?;
    check_vertices(&face.handles, &handles_path, face.neutral.positions.len(), &neutral_path)?;
    for (section, example) in sections.iter().map(|i| &project.examples[*i]).zip(&mut face.examples) {
        if let (Some(take), Some(frame)) = (&section.take, section.frame) {
            let key = format!("[[example]] {:?}: take", example.name);
            let take = existing(path, take, &key, reach)?;
            let unit = face.metres_per_unit;
            let before = example.positions.clone();
            sculpted::place_handles(
                &mut example.positions,
                &face.handles,
                unit,
                &take,
                frame,
                &example.name,
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
    Ok(loaded(project, path, reach)?.face)
}

/// A face without handles.
struct Loaded {
    face: Face,
    /// The number of each example's section.
    sections: Vec<usize>,
}

fn loaded(project: &Project, path: &Path, reach: Reach) -> Result<Loaded> {
    let neutral_path = existing(path, &project.mesh.neutral, "[mesh] neutral", reach)?;
    let selection = Selection { prim: project.mesh.prim.clone(), time: None };
    let Shapes { mut neutral, space, parts, .. } = mesh::read_file(&neutral_path, &selection, false)?;
    if let Some(materials) = &mut neutral.materials {
        let looks = mesh::read_looks(&neutral_path, reach)?;
        let looks = if project.mesh.textures == Some(false) { looks.without_textures() } else { looks };
        looks.give_to(materials);
        if neutral.uvs.is_none() && !materials.textures.is_empty() {
            log::warn!(
                "{}: has images and no texture coordinates, so that no image is shown; unwrap the mesh and export \
                 it again",
                neutral_path.display()
            );
        }
    } else {
        neutral.materials = named_parts::materials(&neutral, &neutral_path, &parts)?;
    }
    let space = NeutralSpace::new(&project.mesh, space, path)?;
    let of = Of { project, path, reach, neutral: &neutral, neutral_path: &neutral_path, space };
    let mut sections = Vec::new();
    let mut examples = Vec::new();
    for OfSection { section, example } in examples::read(of)? {
        sections.push(section);
        examples.push(example);
    }

    let prior = match &project.prior {
        Some(section) => prior::read(section, path, &neutral, &neutral_path, reach)?,
        None => None,
    };
    let pins = Pins {
        auto: project.pins.auto,
        vertices: pinned_vertices(&project.pins, path, &neutral, &neutral_path, reach)?,
    };
    let stem = || path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let face = Face {
        name: project.mesh.name.clone().unwrap_or_else(stem),
        neutral,
        metres_per_unit: space.metres_per_unit,
        up_axis: space.up,
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
    };
    Ok(Loaded { face, sections })
}

/// The points of the neutral and of an example's positions, if the project joins vertices.
pub(super) fn points(project: &Project, neutral: &Mesh, example: &[[f64; 3]]) -> Option<Points> {
    project.mesh.welds().then(|| Points::new(neutral, &[example])).flatten()
}

/// The files that a project is read from, that of the project first. They need not exist.
pub fn files(project: &Project, path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let edges = match &project.strain.edges {
        Edges::File(edges) => Some(edges),
        Edges::Auto => None,
    };
    let named = [&project.mesh.neutral, &project.handles.vertices].into_iter();
    let of_example = |example: &ExampleSection| {
        let mut files = match example.names_files() {
            true => examples::fitting(&example.mesh, path),
            false => vec![example.mesh.clone()],
        };
        files.extend(example.take.iter().chain(&example.displacement).chain(&example.normal_map).cloned());
        files
    };
    let named = named.cloned().chain(project.examples.iter().flat_map(of_example));
    let named = named.chain(project.pins.vertices.iter().chain(edges).cloned());
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
