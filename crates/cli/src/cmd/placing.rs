//! What `new` and `handles` share: the head of a mesh, handles on it, what is said of them, and the picture.

use crate::args::Placement;
use crate::drawing::with_pictures;
use crate::output;
use crate::progress::Ui;
use rhytid::capture::{Axes, HandleSettings, Misfit, PlacedHandles, Target, misfit, place_handles};
use rhytid::core::{Handles, Mesh, Settings, SurfacePoint, UpAxis, VertexId, human};
use rhytid::formats::mesh::{self, Shapes};
use rhytid::formats::raw_take::{self, Contents};
use rhytid::formats::tables;
use rhytid::formats::take::{self, Missing};
use rhytid::report::write_handles;
use rhytid::solve::Skin;
use rhytid::solve::head::{self, Part, Region};
use rhytid::{Error, Face, Result};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// A marker that was laid farther from its vertex than this, in millimetres, is red in the picture.
const DOUBTFUL_MM: f64 = 8.0;

/// Handles named in the summary, the farthest first.
const NAMED: usize = 5;

/// What a file says of its head.
pub(super) struct Avatar {
    /// The axis that points up, if the file states it.
    up: Option<UpAxis>,
    /// Its objects or groups.
    parts: Vec<Part>,
    /// The name of the part that is the head, if it was given.
    part: Option<String>,
}

impl Avatar {
    /// What the file `path` says of its head, as read. `part` is the name of the head, if it was given.
    ///
    /// # Errors
    /// As reading the groups of an OBJ file, except that it need not have any.
    pub(super) fn new(path: &Path, neutral: &Shapes, part: Option<String>) -> Result<Self> {
        let of_file = neutral.parts.iter();
        let mut parts: Vec<Part> = of_file
            .map(|part| Part { name: part.name.clone(), vertices: part.vertices.clone().collect() })
            .collect();
        if mesh::Format::from_extension(path)? == mesh::Format::Obj {
            // A file without groups has none; any other fault was found when the mesh was read.
            let groups = mesh::read_groups(&neutral.neutral, path, path).unwrap_or_default();
            parts.extend(groups.into_iter().map(|(name, vertices)| Part { name, vertices }));
        }
        Ok(Self { up: neutral.space.up, parts, part })
    }

    /// The same with an axis that points up for sure.
    pub(super) fn with_up(self, up: UpAxis) -> Self {
        Self { up: Some(up), ..self }
    }

    /// The head as far as the neutral alone shows it, without examples.
    ///
    /// # Errors
    /// [`Error::Input`] if the part that was given is not there.
    pub(super) fn head_alone(&self, neutral: &Mesh) -> Result<Option<Region>> {
        let mut face = Face {
            name: String::new(),
            neutral: neutral.clone(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            handles: Handles::default(),
            examples: Vec::new(),
            prior: None,
            settings: Settings::default(),
        };
        match self.heads(&mut face) {
            Ok(heads) => Ok(heads.into_iter().next().map(|head| head.region)),
            Err(error) if self.part.is_some() => Err(error),
            Err(_) => Ok(None),
        }
    }

    /// The head of a face by the axes that may point up: the one that the file states, else the one in which
    /// the head looks ahead, else each.
    ///
    /// # Errors
    /// As [`head::find`], if there is no head by any axis.
    fn heads(&self, face: &mut Face) -> Result<Vec<Head>> {
        let mut heads = Vec::new();
        let mut fault = None;
        for up in self.up.map_or_else(|| vec![UpAxis::Y, UpAxis::Z], |up| vec![up]) {
            face.up_axis = up;
            match head::find(face, &self.parts, self.part.as_deref()) {
                Ok(region) if region.looks_ahead() => return Ok(vec![Head { up, region }]),
                Ok(region) => heads.push(Head { up, region }),
                Err(error) => {
                    fault.get_or_insert(error);
                }
            }
        }
        match fault {
            Some(fault) if heads.is_empty() => Err(fault),
            _ => Ok(heads),
        }
    }
}

/// A head by an up axis.
struct Head {
    up: UpAxis,
    region: Region,
}

/// A face with its handles.
pub(super) struct Placed {
    pub(super) face: Face,
    pub(super) head: Region,
    /// The take whose markers they are, if they are any.
    pub(super) take: Option<FromTake>,
}

/// What a take says of handles.
pub(super) struct FromTake {
    pub(super) path: PathBuf,
    pub(super) found: PlacedHandles,
    /// The distance of each handle from its marker, in millimetres.
    pub(super) distances: Vec<f64>,
}

/// The face with handles at a take's markers, and its best up axis: the one in which the markers fit.
/// `metres` are those of the take's unit, if it was given.
///
/// # Errors
/// As reading and placing.
pub(super) fn at_markers(
    mut face: Face,
    avatar: &Avatar,
    take: &Path,
    metres: Option<f64>,
    options: &Placement,
    ui: &Ui,
) -> Result<Placed> {
    let raw = raw_take::read(take, options.rate)?;
    let mut best: Option<(Head, PlacedHandles)> = None;
    let mut fault = None;
    for head in avatar.heads(&mut face)? {
        face.up_axis = head.up;
        let settings = HandleSettings {
            frame: options.frame.0,
            metres_per_unit: metres,
            rigid: options.rigid.clone(),
            known: options.at.iter().map(|at| (at.label.clone(), VertexId(at.vertex).into())).collect(),
            subject: options.subject.clone(),
            head: Some(head.region.clone()),
        };
        match place_handles(&face, &raw, &settings, ui) {
            Ok(found) => {
                let is_better =
                    |before: &PlacedHandles| match (found.faults.is_empty(), before.faults.is_empty()) {
                        (true, false) => true,
                        (false, true) => false,
                        _ => found.cost < 0.8 * before.cost,
                    };
                if best.as_ref().is_none_or(|(_, before)| is_better(before)) {
                    best = Some((head, found));
                }
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                fault.get_or_insert(error.in_file(take.display()));
            }
        }
    }
    let Some((Head { up, region: head }, found)) = best else {
        return Err(fault.unwrap_or_else(|| Error::Internal("no axis was tried".to_owned())));
    };
    face.up_axis = up;
    face.handles = found.handles.clone();
    let millimetres = 1e3 * face.metres_per_unit;
    let distances = found.distances.iter().map(|distance| distance * millimetres).collect();
    Ok(Placed { face, head, take: Some(FromTake { path: take.to_owned(), found, distances }) })
}

/// The options with which the other commands read a clean take whose unit or axes are not the face's. None
/// for a raw take, which is laid onto the face when it is cleaned.
pub(super) fn space_options(face: &Face, take: &Path) -> Vec<String> {
    if raw_take::contents(take) != Contents::Take {
        return Vec::new();
    }
    // What is wrong with a take is said when it is played.
    let Ok(take) = take::read(take, Some(&face.handles.labels), Missing::Hold) else { return Vec::new() };
    let Some(Misfit::Space(space)) = misfit(&take, &Target::from_neutral(face)) else { return Vec::new() };
    let unit = space.unit().filter(|_| space.metres_per_unit != face.metres_per_unit);
    let unit = unit.into_iter().flat_map(|unit| ["--take-unit".to_owned(), unit.to_owned()]);
    unit.chain((space.axes != Axes::SAME).then(|| format!("--take-axes={}", space.axes))).collect()
}

/// The face with so many handles spread over it, besides those whose vertices were given.
///
/// # Errors
/// As finding the head; [`Error::Input`] for a vertex that the mesh does not have.
pub(super) fn spread(mut face: Face, avatar: &Avatar, count: usize, options: &Placement) -> Result<Placed> {
    let vertices = face.neutral.positions.len();
    if let Some(at) = options.at.iter().find(|at| at.vertex as usize >= vertices) {
        return Err(Error::out_of_range(format!(
            "--at {}={}: the mesh has {vertices} vertices, expected 0 to {}",
            at.label,
            at.vertex,
            vertices.saturating_sub(1)
        )));
    }
    let mut fault = None;
    let mut skins = Vec::new();
    for head in avatar.heads(&mut face)? {
        face.up_axis = head.up;
        match Skin::from_region(&face, &head.region) {
            Ok(skin) => skins.push((head, skin)),
            Err(error) => {
                fault.get_or_insert(error);
            }
        }
    }
    let Some((Head { up, region: head }, skin)) = skins.into_iter().next() else {
        return Err(fault.unwrap_or_else(|| Error::Internal("no axis was tried".to_owned())));
    };
    face.up_axis = up;
    let kept: Vec<VertexId> = options.at.iter().map(|at| VertexId(at.vertex)).collect();
    let vertices = skin.spread(count, &kept);
    let mut labels = skin.labels(&vertices);
    labels.iter_mut().zip(&options.at).for_each(|(label, at)| label.clone_from(&at.label));
    // A label that was given belongs to its vertex alone.
    let mut taken: HashSet<String> = options.at.iter().map(|at| at.label.clone()).collect();
    for label in labels.iter_mut().skip(options.at.len()) {
        while !taken.insert(label.clone()) {
            label.push('b');
        }
    }
    face.handles = Handles { labels, points: vertices.into_iter().map(SurfacePoint::from).collect() };
    Ok(Placed { face, head, take: None })
}

impl Placed {
    /// Writes the table of handles.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn write_table(&self, table: &Path) -> Result<()> {
        tables::write_handles(table, &self.face.handles, self.take.as_ref().map(|take| &take.distances[..]))
    }

    /// Draws the face with its handles, if a device can draw. Returns whether it did.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn draw(&self, picture: &Path) -> Result<bool> {
        let take = self.take.as_ref();
        let distances = take.map_or(&[][..], |take| &take.distances);
        let doubtful: Vec<bool> = distances.iter().map(|distance| *distance > DOUBTFUL_MM).collect();
        let markers = take.map_or(&[][..], |take| &take.found.markers);
        with_pictures(&format!("{} is", picture.display()), |painter| match painter {
            Some(painter) => write_handles(picture, &self.face, &doubtful, markers, painter),
            None => Ok(()),
        })
    }
}

impl FromTake {
    /// What is wrong with the handles, in one sentence that ends with a command that helps: one that places
    /// the same handles, without the options that the sentence asks for. `None` if nothing is wrong.
    pub(super) fn fault(&self, command: &str, picture: Option<&Path>) -> Option<String> {
        if self.found.faults.is_empty() {
            return None;
        }
        let look = picture.map_or_else(String::new, |picture| format!("look at {}, and ", picture.display()));
        Some(format!(
            "{}: {}; {look}choose another frame, or name the vertices of three markers: \
             {command} --frame N --at LABEL=VERTEX --at LABEL=VERTEX --at LABEL=VERTEX",
            self.path.display(),
            self.found.faults.join("; ")
        ))
    }

    /// Says what a person should look at.
    pub(super) fn warn(&self, ui: &Ui) {
        for warning in &self.found.warnings {
            ui.line(&format!("warning: {}: {warning}", self.path.display()));
        }
    }

    /// What was found, for a person to check.
    pub(super) fn rows(&self, ui: &Ui) -> Vec<[String; 2]> {
        let Self { found, distances, .. } = self;
        let number = |x: f64| human::number((x * 10.0).round() / 10.0);
        let mut sorted: Vec<(f64, &str)> =
            distances.iter().copied().zip(found.handles.labels.iter().map(String::as_str)).collect();
        sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let median = sorted.get(sorted.len() / 2).map_or(0.0, |(distance, _)| *distance);
        let farthest: Vec<String> = sorted
            .iter()
            .take(NAMED)
            .map(|(distance, label)| format!("{label} {}", number(*distance)))
            .collect();
        let mut rows = vec![
            ["frame".to_owned(), found.frame.to_string()],
            [
                "from its marker".to_owned(),
                format!("{} mm (median); the farthest: {} mm", number(median), farthest.join(", ")),
            ],
        ];
        for (name, labels, why) in [
            ("left out", &found.rigid, "off the skin, they keep their distances"),
            ("elsewhere", &found.elsewhere, "not on the face, no handle for them"),
            ("no label", &found.unlabelled, "without a label or hardly ever seen, no handle for them"),
            ("not seen", &found.unseen, "no handle for them"),
        ] {
            if !labels.is_empty() {
                rows.push([name.to_owned(), format!("{}: {why}", output::names(labels, ui))]);
            }
        }
        rows
    }
}
