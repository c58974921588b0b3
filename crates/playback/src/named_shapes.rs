//! Shapes with names, as displacements of a rig's handles.

use rhytid_core::{Error, Mesh, Reach, Result, Rig, SurfacePoint, rig_file};
use rhytid_formats::mesh::{self, Selection, Shapes, Space};
use rhytid_formats::{FileKind, project};
use std::path::{Path, PathBuf};

/// Neutrals of one face have equal places to within this part of the face's size.
const SAME_PLACE: f64 = 0.02;

/// Displacements that shapes of these names give to a rig's handles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NamedShapes {
    /// Where they are from, for messages.
    pub of: String,
    /// N names.
    pub names: Vec<String>,
    /// N × H displacements in the rig's unit and axes.
    pub at_handles: Vec<Vec<[f64; 3]>>,
}

/// The rig's own examples; `None` if it has none.
pub(crate) fn of_examples(rig: &Rig) -> Option<NamedShapes> {
    let examples = rig.examples();
    if examples.is_empty() {
        return None;
    }
    let rest = &rig.handles().rest;
    let of_example = |row: &[[f32; 3]]| {
        row.iter().zip(rest).map(|(at, rest)| difference(at.map(f64::from), rest.map(f64::from))).collect()
    };
    let rows = examples.handles.as_slice().chunks_exact(rest.len());
    Some(NamedShapes {
        of: "the rig".into(),
        names: examples.names.clone(),
        at_handles: rows.map(of_example).collect(),
    })
}

impl NamedShapes {
    /// Reads shapes of the rig's mesh: blend shapes of a glTF or USD file, the examples of a project file or
    /// of a rig, all meshes of a folder, or those whose names fit a pattern such as `poses/*.obj`. Meshes are
    /// named after their files.
    ///
    /// # Errors
    /// [`Error::Input`] if there are no shapes, or if they are of another mesh or in another place.
    /// [`Error::Io`].
    pub fn read(path: &Path, rig: &Rig) -> Result<Self> {
        let name = path.display().to_string();
        let found = match FileKind::detect(path) {
            Some(FileKind::Rig) => of_rig(path, rig)?,
            Some(FileKind::Project) => of_project(path, rig)?,
            _ if mesh::has_shapes(path) && !name.contains(['*', '#']) => of_file(path, rig)?,
            _ => of_meshes(path, rig)?,
        };
        if found.names.is_empty() {
            return Err(Error::empty(format!(
                "{name}: has no shapes, expected a file with blend shapes, a folder of meshes, or a project file or \
                 rig with examples"
            )));
        }
        Ok(Self { of: name, ..found })
    }
}

/// All files that [`NamedShapes::read`] reads, in their order.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>> {
    match FileKind::detect(path) {
        Some(FileKind::Project) => Ok(project::files(&project::read_project(path)?, path)),
        Some(_) => Ok(vec![path.to_owned()]),
        None => Ok(meshes(path)),
    }
}

fn of_rig(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let other = rig_file::read(path)?;
    if other.handles().labels != rig.handles().labels {
        return Err(Error::mismatch(format!(
            "{}: has other handles than the rig that plays the curves; give a rig of the same handles, or the shapes \
             as meshes",
            path.display()
        )));
    }
    Ok(of_examples(&other).unwrap_or_else(|| NamedShapes {
        of: String::new(),
        names: Vec::new(),
        at_handles: Vec::new(),
    }))
}

fn of_project(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let project = project::read_project(path)?;
    // The user names this file, as a mesh is named.
    let face = project::load_without_handles(&project, path, Reach::Anywhere)?;
    let shared = Surroundings { path, rig };
    let space = Space { metres_per_unit: Some(face.metres_per_unit), up: Some(face.up_axis) };
    let placed = shared.place(&face.neutral, space)?;
    let mut found = NamedShapes { of: String::new(), names: Vec::new(), at_handles: Vec::new() };
    for example in face.examples {
        found.names.push(example.name);
        found.at_handles.push(placed.displacements(&example.positions, &face.neutral.positions));
    }
    Ok(found)
}

fn of_file(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let Shapes { neutral, shapes, space, .. } = mesh::read_file(path, &Selection::default(), true)?;
    let placed = Surroundings { path, rig }.place(&neutral, space)?;
    let mut found = NamedShapes { of: String::new(), names: Vec::new(), at_handles: Vec::new() };
    for shape in shapes {
        let positions = shape.on(&neutral.positions);
        found.names.push(shape.name);
        found.at_handles.push(placed.displacements(&positions, &neutral.positions));
    }
    Ok(found)
}

fn of_meshes(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let mut found = NamedShapes { of: String::new(), names: Vec::new(), at_handles: Vec::new() };
    let rest: Vec<[f64; 3]> = rig.surface().rest.iter().map(|x| x.map(f64::from)).collect();
    for file in meshes(path) {
        let read = mesh::read_file(&file, &Selection::default(), false)?;
        let surroundings = Surroundings { path: &file, rig };
        // A shape is in another place than the neutral. So only the order and the space are compared.
        let placed = surroundings.order(&read.neutral, read.space)?;
        let at_rest = placed.back(&rest);
        found.names.push(file.file_stem().unwrap_or_default().to_string_lossy().into_owned());
        found.at_handles.push(placed.displacements_of(&read.neutral.positions, &at_rest));
    }
    Ok(found)
}

/// The meshes of a folder or of a pattern, by name.
fn meshes(path: &Path) -> Vec<PathBuf> {
    let pattern = if path.is_dir() { path.join("*") } else { path.to_owned() };
    project::meshes_fitting(&pattern)
}

/// What a mesh of shapes is compared with.
struct Surroundings<'a> {
    /// The file of the mesh.
    path: &'a Path,
    rig: &'a Rig,
}

/// How the vertices of a mesh belong to a rig.
struct Placed<'a> {
    order: mesh::Order,
    /// The length of the mesh's unit in the rig's.
    scale: f64,
    /// Whether y and z of the mesh have to be exchanged, with a change of sign, for the rig's up axis.
    turn: Turn,
    rest: Vec<[f64; 3]>,
    points: &'a [SurfacePoint],
}

/// The turn from one up axis to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    None,
    YToZ,
    ZToY,
}

impl Turn {
    fn apply(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::None => [x, y, z],
            Self::YToZ => [x, -z, y],
            Self::ZToY => [x, z, -y],
        }
    }

    fn back(self) -> Self {
        match self {
            Self::None => Self::None,
            Self::YToZ => Self::ZToY,
            Self::ZToY => Self::YToZ,
        }
    }
}

impl<'a> Surroundings<'a> {
    /// Finds the rig's vertices in a mesh of this space.
    fn order(&self, neutral: &Mesh, space: Space) -> Result<Placed<'a>> {
        use rhytid_core::UpAxis::{Y, Z};
        let surface = self.rig.surface();
        let rest: Vec<[f64; 3]> = surface.rest.iter().map(|x| x.map(f64::from)).collect();
        let of_rig =
            Mesh { positions: rest.clone(), faces: surface.faces.clone(), uvs: None, materials: None };
        // The rig has no path of its own here.
        let order = mesh::order(neutral, &of_rig, Path::new("the rig's mesh"), self.path)?;
        let scale = space.metres_per_unit.map_or(1.0, |metres| metres / surface.metres_per_unit);
        let turn = match (space.up, surface.up_axis) {
            (Some(Y), Z) => Turn::YToZ,
            (Some(Z), Y) => Turn::ZToY,
            _ => Turn::None,
        };
        let placed = Placed { order, scale, turn, rest, points: &self.rig.handles().points };
        // A mesh that states no space may be in the unit of the rig all the same, and one that states it may lie.
        let sizes = [size(&neutral.positions), size(&placed.rest)];
        let ratio = placed.scale * sizes[0] / sizes[1];
        if !(0.5..2.0).contains(&ratio) && (0.5..2.0).contains(&(sizes[0] / sizes[1])) {
            return Ok(Placed { scale: 1.0, ..placed });
        }
        if !(0.5..2.0).contains(&ratio) {
            return Err(Error::mismatch(format!(
                "{}: is {ratio:.3} times as large as the rig's mesh; export the shapes in the unit of the rig",
                self.path.display()
            )));
        }
        Ok(placed)
    }

    /// The same, for a mesh that is the neutral and has to be where the rig's is.
    fn place(&self, neutral: &Mesh, space: Space) -> Result<Placed<'a>> {
        let mut placed = self.order(neutral, space)?;
        let off = |placed: &Placed<'_>| {
            let found = placed.order.of_neutral(neutral.positions.clone(), &placed.back(&placed.rest));
            let moved: Vec<[f64; 3]> = found.into_iter().map(|x| placed.forth(x)).collect();
            let (a, b) = (centred(&moved), centred(&placed.rest));
            let squared = a.iter().zip(&b).map(|(a, b)| norm(difference(*a, *b)).powi(2)).sum::<f64>();
            (squared / a.len().max(1) as f64).sqrt() / size(&placed.rest)
        };
        if off(&placed) > SAME_PLACE {
            // What a file says of its axes may be wrong.
            let best = [Turn::None, Turn::YToZ, Turn::ZToY].into_iter().find(|&turn| {
                placed.turn = turn;
                off(&placed) <= SAME_PLACE
            });
            if best.is_none() {
                return Err(Error::mismatch(format!(
                    "{}: its mesh without shapes is not the rig's mesh at rest; give shapes of the mesh that the rig was \
                     solved from",
                    self.path.display()
                )));
            }
        }
        Ok(placed)
    }
}

impl Placed<'_> {
    /// A place of the mesh's space in the rig's.
    fn forth(&self, x: [f64; 3]) -> [f64; 3] {
        self.turn.apply(x).map(|x| x * self.scale)
    }

    /// Places of the rig's space in the mesh's.
    fn back(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let turn = self.turn.back();
        positions.iter().map(|x| turn.apply(*x).map(|x| x / self.scale)).collect()
    }

    /// What a shape of the mesh does to the rig's handles. `rest` are the mesh's own places without it.
    fn displacements(&self, positions: &[[f64; 3]], rest: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut moved = self.order.of_neutral(positions.to_vec(), &self.back(&self.rest));
        let rest = self.order.of_neutral(rest.to_vec(), &self.back(&self.rest));
        moved.iter_mut().zip(&rest).for_each(|(x, rest)| *x = difference(*x, *rest));
        self.at_points(&moved)
    }

    /// The same, with the places without the shape in the rig's order.
    fn displacements_of(&self, positions: &[[f64; 3]], rest: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut moved = self.order.of_neutral(positions.to_vec(), rest);
        moved.iter_mut().zip(rest).for_each(|(x, rest)| *x = difference(*x, *rest));
        self.at_points(&moved)
    }

    fn at_points(&self, moved: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.points.iter().map(|point| self.forth(point.mean(|v| moved[v.index()]))).collect()
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

fn norm(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The positions around their mean, since exporters move a mesh as a whole.
fn centred(positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let count = positions.len().max(1) as f64;
    let mean: [f64; 3] =
        std::array::from_fn(|c| positions.iter().map(|position| position[c]).sum::<f64>() / count);
    positions.iter().map(|position| difference(*position, mean)).collect()
}

/// The diagonal of the box around positions.
fn size(positions: &[[f64; 3]]) -> f64 {
    let range = |c: usize| {
        let low = positions.iter().map(|x| x[c]).fold(f64::INFINITY, f64::min);
        positions.iter().map(|x| x[c]).fold(f64::NEG_INFINITY, f64::max) - low
    };
    norm([range(0), range(1), range(2)])
}
