//! Files that are opened: a rig or a take. Their contents tell which.

use crate::document::{OpenTake, Reading, TimelineEvent};
#[cfg(not(target_arch = "wasm32"))]
use crate::edits::OpenEdits;
use crate::open_mesh::{self, OpenMesh};
use crate::problems::ProblemKind;
#[cfg(not(target_arch = "wasm32"))]
use crate::same::Same;
use crate::work::Task;
use eframe::egui;
use rhytid_capture::{Edit, Event, Kind, TakeSpace};
use rhytid_core::{Error, Progress, Remedy, Result, Rig, Take, input_file, rig_file};
use rhytid_formats::FileKind;
use rhytid_formats::mesh::{self, Numbers};
use rhytid_formats::take::Missing;
use rhytid_playback::{CleanUp, read_take, space_of_take};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The contents of a file.
#[derive(Debug)]
pub(crate) enum Opened {
    Rig(Arc<Rig>, String),
    /// A mesh without a rig.
    Mesh(OpenMesh),
    Take(OpenTake),
    /// A take that was not opened, since it is in another space.
    Elsewhere(Elsewhere),
    /// Numbers at the rig's vertices.
    Numbers(Vec<Numbers>),
    #[cfg(not(target_arch = "wasm32"))]
    Edits(OpenEdits),
}

/// A take that would fit the rig in another unit or with other axes.
#[derive(Debug)]
#[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "a page reads no file twice"))]
pub(crate) struct Elsewhere {
    /// The name of the file.
    pub name: String,
    pub space: TakeSpace,
    /// Why it was not opened.
    pub words: String,
}

/// The source of a file.
#[derive(Debug)]
pub(crate) struct Source {
    path: PathBuf,
    /// The contents, as long as they are read.
    #[cfg(target_arch = "wasm32")]
    _held: rhytid_core::HeldFile,
}

impl Source {
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn new(path: PathBuf) -> Self {
        Self { path }
    }

    /// A file that the page has read.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn new(name: &str, bytes: Vec<u8>) -> Self {
        Self { path: PathBuf::from(name), _held: rhytid_core::HeldFile::new(name, bytes.into()) }
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// The name without its folder.
    fn short_name(&self) -> String {
        let last = self.path.file_name().map(|last| last.to_string_lossy().into_owned());
        last.unwrap_or_else(|| self.name())
    }

    /// Whether the name ends so, in upper or lower case.
    fn ends_in(&self, ending: &str) -> bool {
        self.path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
    }

    /// Whether the name is that of a rig.
    fn is_rig(&self) -> bool {
        self.ends_in("safetensors")
    }

    /// Whether it takes the place of the open rig. A PLY file has numbers for it.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn takes_the_rigs_place(&self) -> bool {
        self.is_rig() || self.is_project() || (self.is_mesh() && !self.ends_in("ply"))
    }

    /// Whether the name is that of a mesh or of an animation.
    fn is_mesh(&self) -> bool {
        mesh::Format::from_extension(&self.path).is_ok()
    }

    /// Whether another file names it and reads it.
    fn is_companion(&self) -> bool {
        ["bin", "mtl"].iter().any(|ending| self.ends_in(ending))
    }

    /// Whether it is a file of edits: TOML that is no project.
    pub(crate) fn is_edits(&self) -> bool {
        self.ends_in("toml") && !self.is_project()
    }

    /// Whether it is a project file, which names a neutral mesh.
    fn is_project(&self) -> bool {
        if !self.ends_in("toml") {
            return false;
        }
        let text = input_file::read(&self.path, input_file::LARGEST_TEXT).unwrap_or_default();
        let names_neutral = |line: &str| {
            line.trim_start().strip_prefix("neutral").is_some_and(|rest| rest.trim_start().starts_with('='))
        };
        String::from_utf8_lossy(&text).lines().any(names_neutral)
    }

    /// Reads the file. A take is read for `rig`, edits for `take`. `with_rig` says whether a rig is opened
    /// with the file.
    #[cfg_attr(target_arch = "wasm32", expect(unused_variables, reason = "pages open no edits"))]
    fn read(
        &self,
        rig: Option<&Rig>,
        take: Option<&Take>,
        with_rig: bool,
        progress: &dyn Progress,
    ) -> Result<Opened> {
        let (path, name) = (&*self.path, self.name());
        #[cfg(target_arch = "wasm32")]
        if self.ends_in("toml") {
            return Err(Error::unsupported_format(format!(
                "{name}: this page opens neither projects nor edits; the window on a computer does"
            )));
        }
        #[cfg(not(target_arch = "wasm32"))]
        if self.is_project() {
            return solved(path, name, progress);
        }
        #[cfg(not(target_arch = "wasm32"))]
        if self.is_edits() {
            let (Some(rig), Some(take)) = (rig, take) else {
                let then = "open a rig and a take first, then the edits for them";
                return Err(Error::empty(format!("{name}: {then}")));
            };
            return edits_in(path, rig, take, name, progress);
        }
        if self.is_rig() {
            progress.report("read the rig", 0, 1);
            let rig = rig_file::read(path)?;
            if rig.surface().triangles.is_empty() {
                return Err(Error::empty(format!("{name}: the rig has no triangles, expected a surface")));
            }
            return Ok(Opened::Rig(Arc::new(rig), name));
        }
        #[cfg(not(target_arch = "wasm32"))]
        if path.is_dir() {
            return Err(folder(path, &name));
        }
        // A PLY file with the rig's vertices has numbers for them.
        if let (Some(rig), true) = (rig, self.ends_in("ply")) {
            return Ok(Opened::Numbers(mesh::read_numbers(path, rig.vertices())?));
        }
        // Of a rig and a mesh that are opened together, the rig is shown.
        if self.is_mesh() && !with_rig {
            return Ok(Opened::Mesh(open_mesh::read(path, progress)?));
        }
        let rig = rig.ok_or_else(|| self.no_rig())?;
        take_in(path, rig, name, Reading::default(), progress)
    }

    /// The reason why nothing but a rig can be opened.
    fn no_rig(&self) -> Error {
        let then = "open a rig first, then a take for it";
        if let Err(error) = input_file::is_regular(&self.path) {
            return Error::io(&self.path)(error);
        }
        if let Err(error) = FileKind::expect(&self.path, &[FileKind::Rig]) {
            return error.reworded(|said| format!("{said}; {then}"));
        }
        Error::unsupported_format(format!("{}: is not a rig (.safetensors); {then}", self.name()))
    }
}

/// Why a folder is not opened.
#[cfg(not(target_arch = "wasm32"))]
fn folder(path: &Path, name: &str) -> Error {
    let files = std::fs::read_dir(path).into_iter().flatten().flatten();
    let meshes = files.filter(|file| mesh::Format::from_extension(&file.path()).is_ok()).count();
    Error::bad_path(match meshes {
        0 => format!("{name}: is a folder without meshes; open a file"),
        1 => format!("{name}: is a folder with 1 mesh; make a project of it, and open the project"),
        _ => {
            format!("{name}: is a folder with {meshes} meshes; make a project of them, and open the project")
        }
    })
}

/// The rig of a project, solved for this window.
#[cfg(not(target_arch = "wasm32"))]
fn solved(path: &Path, name: String, progress: &dyn Progress) -> Result<Opened> {
    progress.report("read the project", 0, 1);
    let face = rhytid_formats::project::read(path, rhytid_formats::Reach::Below)?;
    let rig: Rig = rhytid_solve::solve(&face, progress)?.rounded()?;
    let kept =
        "was solved for this window alone, and nothing was written; solve it into a file to keep the rig";
    progress.warn(&rhytid_core::Warning::from(kept.to_owned()).in_file(&name));
    Ok(Opened::Rig(Arc::new(rig), name))
}

/// A file of edits, and the edited take.
#[cfg(not(target_arch = "wasm32"))]
fn edits_in(path: &Path, rig: &Rig, take: &Take, name: String, progress: &dyn Progress) -> Result<Opened> {
    use crate::edits::FrameEdits;
    use rhytid_core::Backend;
    use rhytid_formats::Reach;
    use rhytid_playback::Layers;
    let layers = Layers::read(path, rig, Reach::Below)?;
    let edited = layers.edit(take.clone(), rig)?;
    let devices = rhytid_backend_cpu::Cpu::devices()?;
    let on_frames = Same::new(FrameEdits::new(&layers, rig, &edited, &devices, progress)?);
    Ok(Opened::Edits(OpenEdits {
        positions: edited.take.handle_positions(&rig.handles().labels)?,
        spans: crate::edits::spans(&rhytid_formats::edits::parse(layers.text(), &name)?, take.frames()),
        name,
        moved: rig.handles().labels.iter().map(|label| edited.is_edited(label)).collect(),
        layers: Same::new(layers),
        on_frames,
    }))
}

/// A take's CSV, curves, or the file of a capture system, which is cleaned up.
fn take_in(
    path: &Path,
    rig: &Rig,
    name: String,
    reading: Reading,
    progress: &dyn Progress,
) -> Result<Opened> {
    FileKind::expect(path, &[FileKind::Take, FileKind::RawTake, FileKind::Curves])?;
    let mut clean_up = CleanUp { space: reading.space, ..CleanUp::default() };
    clean_up.settings.edits.clone_from(&reading.repairs);
    let read = match read_take(path, rig, Missing::Hold, &clean_up, progress) {
        Err(error) => return elsewhere(path, rig, name, error),
        Ok(read) => read,
    };
    let is_filled = |event: &Event| matches!(event.kind, Kind::Spline | Kind::Model | Kind::FilledBefore);
    let words = |event: &Event| {
        let markers = event.marker.into_iter().chain(event.other);
        let names: Vec<&str> =
            markers.filter_map(|marker| rig.handles().labels.get(marker)).map(|label| &**label).collect();
        let names = if names.is_empty() { "head".to_owned() } else { names.join(" and ") };
        let what = if is_filled(event) { "gap filled, " } else { "" };
        format!("{what}{}: {names}", event.kind.name())
    };
    // What was exchanged by hand is no problem any more.
    let is_by_hand = |event: &Event| {
        let frames = event.first..event.first + event.frames;
        let is_it = |repair: &Edit| matches!(repair, Edit::Swap(_, there) if *there == frames);
        event.kind == Kind::Swap && reading.repairs.iter().any(is_it)
    };
    let incidents = read.events.iter().map(|event| TimelineEvent {
        first: event.first,
        frames: event.frames.max(1),
        words: words(event),
        confidence: event.confidence,
        is_filled_gap: is_filled(event),
        problem: ProblemKind::of(event.kind, event.confidence).filter(|_| !is_by_hand(event)),
        handles: event.marker.into_iter().chain(event.other).collect(),
    });
    let incidents = incidents.collect();
    Ok(Opened::Take(OpenTake { name, incidents, take: read.take, reading }))
}

/// Files that are being read. Each is handed over as soon as it has been read.
pub(crate) type Opening = Task<Result<Opened>>;

/// Begins to read a rig, takes and edits. Takes and edits belong to the rig and the take among these files,
/// or else to the open `rig` and `take`.
pub(crate) fn begin(
    sources: Vec<Source>,
    rig: Option<Arc<Rig>>,
    take: Option<Take>,
    context: &egui::Context,
) -> Opening {
    let names = sources.iter().map(Source::short_name).collect::<Vec<_>>().join(", ");
    Task::new(format!("reading {names}"), context, move |work, give| {
        if let Err(error) = read(sources, rig, take, work, give) {
            give(Err(error));
        }
    })
}

/// A take that fits in another space, or else the `error`.
fn elsewhere(path: &Path, rig: &Rig, name: String, error: Error) -> Result<Opened> {
    let has_space =
        matches!(&error, Error::Input(input) if input.remedies().contains(&Remedy::GiveTakeSpace));
    let space = if has_space { space_of_take(path, rig, Missing::Hold)? } else { None };
    space.map(|space| Opened::Elsewhere(Elsewhere { name, space, words: error.to_string() })).ok_or(error)
}

/// Begins to read the take in a file again, in another way.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn begin_again(name: String, rig: Arc<Rig>, reading: Reading, context: &egui::Context) -> Opening {
    Task::new(format!("reading {name} again"), context, move |work, give| {
        give(take_in(Path::new(&name), &rig, name.clone(), reading, work));
    })
}

fn read(
    mut sources: Vec<Source>,
    mut rig: Option<Arc<Rig>>,
    mut take: Option<Take>,
    progress: &dyn Progress,
    give: &dyn Fn(Result<Opened>),
) -> Result<()> {
    sources.sort_by_key(|source| (!(source.is_rig() || source.is_project()), source.is_edits()));
    let (companions, sources): (Vec<_>, Vec<_>) = sources.into_iter().partition(Source::is_companion);
    if let (Some(companion), true) = (companions.first(), sources.is_empty()) {
        return Err(companion.no_rig());
    }
    let needs_take = sources.iter().any(Source::is_edits);
    let with_rig = sources.iter().any(|source| source.is_rig() || source.is_project());
    for source in &sources {
        let found = source.read(rig.as_deref(), take.as_ref(), with_rig, progress)?;
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        match &found {
            Opened::Rig(found, _) => (rig, take) = (Some(found.clone()), None),
            Opened::Take(found) if needs_take => take = Some(found.take.clone()),
            Opened::Mesh(_) => (rig, take) = (None, None),
            Opened::Take(_) | Opened::Elsewhere(_) | Opened::Numbers(_) => {}
            #[cfg(not(target_arch = "wasm32"))]
            Opened::Edits(_) => {}
        }
        give(Ok(found));
    }
    Ok(())
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::work::Next;
    use rhytid_core::NoProgress;
    use rhytid_formats::take;
    use std::time::Duration;

    fn open(paths: &[PathBuf]) -> Result<Vec<Opened>> {
        let sources = paths.iter().cloned().map(Source::new).collect();
        let opening = begin(sources, None, None, &egui::Context::default());
        let mut opened = Vec::new();
        loop {
            match opening.wait(Duration::from_secs(60)) {
                Next::Result(result) => opened.push(result?),
                Next::Ended => return Ok(opened),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_rig_and_its_take_in_any_order() {
        let face = rhytid_demo::face(1_000);
        let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let paths = ["take.csv", "face.safetensors"].map(|name| folder.path().join(name));
        take::write(&paths[0], &rhytid_demo::performance(&face)).unwrap();
        rig_file::write(&paths[1], &rig).unwrap();
        match &open(&paths).unwrap()[..] {
            [Opened::Rig(found, _), Opened::Take(take)] => {
                assert_eq!(**found, rig);
                assert_eq!(take.take, rhytid_demo::performance(&face));
            }
            other => panic!("{} things", other.len()),
        }
        let alone = open(&paths[..1]).unwrap_err().to_string();
        assert!(alone.contains("open a rig first"), "{alone}");
    }

    #[test]
    fn broken_files_are_a_sentence() {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in [("a.safetensors", &b"{"[..]), ("a.safetensors", b""), ("a.csv", b"")] {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let error = open(&[path]).unwrap_err();
            assert!(matches!(error, Error::Input(_)) && error.to_string().contains(name), "{error}");
        }
        assert!(matches!(open(&["nowhere.safetensors".into()]), Err(Error::Io { .. })));
    }
}
