//! The head of a neutral, and handles on it.

use crate::args;
use crate::progress::Ui;
use rhytid::capture::{HandleSettings, PlacedHandles, place_handles};
use rhytid::core::{Handles, Mesh, Settings, SurfacePoint, UpAxis};
use rhytid::formats::mesh::{self, Shapes};
use rhytid::formats::{FileKind, raw_take};
use rhytid::solve::Skin;
use rhytid::solve::head::{self, Part, Region};
use rhytid::{Error, Face, Result};
use std::path::{Path, PathBuf};

/// The number of handles without a take.
const HANDLES: usize = 90;

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
    /// # Errors
    /// As reading the groups of an OBJ file, except that it need not have any.
    pub(super) fn new(args: &args::New, neutral: &Shapes) -> Result<Self> {
        let of_file = neutral.parts.iter();
        let mut parts: Vec<Part> = of_file
            .map(|part| Part { name: part.name.clone(), vertices: part.vertices.clone().collect() })
            .collect();
        if mesh::Format::from_extension(&args.neutral)? == mesh::Format::Obj {
            // A file without groups has none; any other fault was found when the mesh was read.
            let groups =
                mesh::read_groups(&neutral.neutral, &args.neutral, &args.neutral).unwrap_or_default();
            parts.extend(groups.into_iter().map(|(name, vertices)| Part { name, vertices }));
        }
        Ok(Self { up: neutral.space.up, parts, part: args.part.clone() })
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
    pub(super) take: Option<PathBuf>,
    /// The distance of each handle from its marker, in mesh units.
    pub(super) distances: Option<Vec<f64>>,
}

/// Places the handles at the markers of a take: the one that was given, else the first beside the neutral
/// whose markers fit the face. A warning names the tables that are passed over. Without a take, handles are
/// spread over the face.
pub(super) fn find_handles(face: Face, avatar: &Avatar, args: &args::New, ui: &Ui) -> Result<Placed> {
    if let Some(take) = &args.take {
        return at_markers(face, avatar, take, ui);
    }
    for take in takes_beside(&args.neutral) {
        match at_markers(face.clone(), avatar, &take, ui) {
            Err(error @ Error::Input(_)) => ui.line(&format!(
                "warning: {}: is passed over, since it is no take of this face ({error}); name a take with --take",
                take.display()
            )),
            found => return found,
        }
    }
    spread(face, avatar)
}

/// The takes in the neutral's folder, by name.
fn takes_beside(neutral: &Path) -> Vec<PathBuf> {
    let folder = neutral.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files.retain(|path| matches!(FileKind::detect(path), Some(FileKind::RawTake | FileKind::Take)));
    files
}

fn spread(mut face: Face, avatar: &Avatar) -> Result<Placed> {
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
    let vertices = skin.spread(HANDLES, &[]);
    let labels = skin.labels(&vertices);
    face.handles = Handles { labels, points: vertices.into_iter().map(SurfacePoint::from).collect() };
    Ok(Placed { face, head, take: None, distances: None })
}

/// The face with handles at a take's markers, and its best up axis: the one in which the markers fit.
fn at_markers(mut face: Face, avatar: &Avatar, take: &Path, ui: &Ui) -> Result<Placed> {
    let raw = raw_take::read(take, None)?;
    let mut best: Option<(Head, PlacedHandles)> = None;
    let mut fault = None;
    for head in avatar.heads(&mut face)? {
        face.up_axis = head.up;
        let settings = HandleSettings { head: Some(head.region.clone()), ..HandleSettings::default() };
        match place_handles(&face, &raw, &settings) {
            Ok(found) => {
                if best.as_ref().is_none_or(|(_, before)| found.cost < 0.8 * before.cost) {
                    best = Some((head, found));
                }
            }
            Err(error) => {
                fault.get_or_insert(error);
            }
        }
    }
    let Some((Head { up, region: head }, found)) = best else {
        return Err(fault.unwrap_or_else(|| Error::Internal("no axis was tried".to_owned())));
    };
    for warning in &found.warnings {
        ui.line(&format!("warning: {}: {warning}", take.display()));
    }
    face.up_axis = up;
    face.handles = found.handles;
    Ok(Placed { face, head, take: Some(take.to_owned()), distances: Some(found.distances) })
}
