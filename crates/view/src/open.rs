//! Files that are opened: a rig or a take. Their contents tell which.

use crate::document::OpenTake;
#[cfg(not(target_arch = "wasm32"))]
use crate::document::TimelineEvent;
#[cfg(not(target_arch = "wasm32"))]
use crate::edits::OpenEdits;
use rhytid_core::{Error, Result, Rig, Take, rig_file};
use rhytid_formats::mesh::{self, Numbers};
use rhytid_formats::take::{self, Missing};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// The contents of a file.
#[derive(Debug)]
pub(crate) enum Opened {
    Rig(Arc<Rig>, String),
    Take(OpenTake),
    /// Numbers at the rig's vertices.
    Numbers(Vec<Numbers>),
    #[cfg(not(target_arch = "wasm32"))]
    Edits(OpenEdits),
}

/// The source of a file.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    #[cfg(not(target_arch = "wasm32"))]
    Path(std::path::PathBuf),
    /// The name and the contents, as browsers have them.
    Bytes(String, Arc<[u8]>),
}

impl Source {
    pub(crate) fn name(&self) -> String {
        match self {
            #[cfg(not(target_arch = "wasm32"))]
            Self::Path(path) => path.display().to_string(),
            Self::Bytes(name, _) => name.clone(),
        }
    }

    /// Whether the name is that of a rig.
    fn is_rig(&self) -> bool {
        self.name().to_lowercase().ends_with(".safetensors")
    }

    /// Whether the name is that of edits.
    pub(crate) fn is_edits(&self) -> bool {
        self.name().to_lowercase().ends_with(".toml")
    }

    /// Reads the file. A take is read for `rig`, edits for `take`.
    fn read(&self, rig: Option<&Rig>, take: Option<&Take>) -> Result<Opened> {
        let name = self.name();
        if self.is_edits() {
            return match (self, rig, take) {
                #[cfg(not(target_arch = "wasm32"))]
                (Self::Path(path), Some(rig), Some(take)) => edits_in(path, rig, take, name),
                (Self::Bytes(..), ..) => Err(Error::unsupported_format(format!(
                    "{name}: this page cannot open edits; the window on a computer can"
                ))),
                #[cfg(not(target_arch = "wasm32"))]
                _ => {
                    Err(Error::empty(format!("{name}: open a rig and a take first, then the edits for them")))
                }
            };
        }
        if self.is_rig() {
            let rig = match self {
                #[cfg(not(target_arch = "wasm32"))]
                Self::Path(path) => rig_file::read(path)?,
                Self::Bytes(name, bytes) => rig_file::decode(bytes, name)?,
            };
            if rig.surface().triangles.is_empty() {
                return Err(Error::empty(format!("{name}: the rig has no triangles, expected a surface")));
            }
            return Ok(Opened::Rig(Arc::new(rig), name));
        }
        let rig = rig.ok_or_else(|| {
            Error::unsupported_format(format!(
                "{name}: is not a rig (.safetensors); open a rig first, then a take for it"
            ))
        })?;
        if name.to_lowercase().ends_with(".ply") {
            let vertices = rig.vertices();
            return Ok(Opened::Numbers(match self {
                #[cfg(not(target_arch = "wasm32"))]
                Self::Path(path) => mesh::read_numbers(path, vertices)?,
                Self::Bytes(name, bytes) => mesh::decode_numbers(bytes, name, vertices)?,
            }));
        }
        match self {
            #[cfg(not(target_arch = "wasm32"))]
            Self::Path(path) => take_in(path, rig, name),
            Self::Bytes(_, bytes) => {
                let take = take::decode(bytes, &name, Some(&rig.handles().labels), Missing::Hold)?;
                Ok(Opened::Take(OpenTake { name, take, incidents: Vec::new() }))
            }
        }
    }
}

/// A file of edits, and the edited take.
#[cfg(not(target_arch = "wasm32"))]
fn edits_in(path: &std::path::Path, rig: &Rig, take: &Take, name: String) -> Result<Opened> {
    use crate::edits::FrameEdits;
    use rhytid_core::{Backend, NoProgress};
    use rhytid_formats::Reach;
    use rhytid_playback::Layers;
    let layers = Layers::read(path, rig, Reach::Below)?;
    let edited = layers.edit(take.clone(), rig)?;
    let devices = rhytid_backend_cpu::Cpu::devices()?;
    let on_frames = FrameEdits::new(&layers, rig, &edited, &devices, &NoProgress)?;
    Ok(Opened::Edits(OpenEdits {
        name,
        positions: edited.take.handle_positions(&rig.handles().labels)?,
        on_frames,
    }))
}

/// A take's CSV, or the file of a capture system, which is cleaned up.
#[cfg(not(target_arch = "wasm32"))]
fn take_in(path: &std::path::Path, rig: &Rig, name: String) -> Result<Opened> {
    use rhytid_core::NoProgress;
    use rhytid_formats::raw_take::Contents;
    use rhytid_playback::{CleanUp, read_raw_take, read_take};
    if rhytid_formats::raw_take::is_take_csv(path) {
        let take = take::read(path, Some(&rig.handles().labels), Missing::Hold)?;
        return Ok(Opened::Take(OpenTake { name, take, incidents: Vec::new() }));
    }
    if rhytid_formats::raw_take::contents(path) == Contents::Curves {
        let take = read_take(path, rig, Missing::Hold, &CleanUp::default(), &NoProgress)?;
        return Ok(Opened::Take(OpenTake { name, take, incidents: Vec::new() }));
    }
    let (cleaned, _) = read_raw_take(path, rig, &CleanUp::default(), &NoProgress)?;
    let label = |marker: Option<usize>| {
        marker.and_then(|marker| rig.handles().labels.get(marker)).map_or("head", |l| l)
    };
    let incidents = cleaned.report.events.iter().map(|event| TimelineEvent {
        first: event.first,
        frames: event.frames.max(1),
        words: format!("{}: {}", event.kind.name(), label(event.marker)),
        confidence: event.confidence,
    });
    Ok(Opened::Take(OpenTake { name, incidents: incidents.collect(), take: cleaned.take }))
}

/// Files that are being read, on a thread where the system has threads.
#[derive(Debug)]
pub(crate) struct Opening {
    /// The names of the files.
    pub name: String,
    result: Receiver<Result<Vec<Opened>>>,
}

impl Opening {
    /// Reads a rig, takes and edits. Takes and edits belong to the rig and the take among these files, or
    /// else to the open `rig` and `take`. `done` is called at the end.
    pub(crate) fn new(
        sources: Vec<Source>,
        rig: Option<Arc<Rig>>,
        take: Option<Take>,
        done: impl FnOnce() + Send + 'static,
    ) -> Self {
        let (sender, result) = channel();
        let name = sources.iter().map(Source::name).collect::<Vec<_>>().join(", ");
        let read = move || {
            // The receiver may be gone.
            let _ = sender.send(read(sources, rig, take));
            done();
        };
        #[cfg(not(target_arch = "wasm32"))]
        std::thread::spawn(read);
        #[cfg(target_arch = "wasm32")]
        read();
        Self { name, result }
    }

    /// The contents. `None` while they are being read.
    pub(crate) fn result(&self) -> Option<Result<Vec<Opened>>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err(Error::Internal(format!("reading {} ended without a result", self.name))))
            }
        }
    }
}

fn read(mut sources: Vec<Source>, mut rig: Option<Arc<Rig>>, mut take: Option<Take>) -> Result<Vec<Opened>> {
    sources.sort_by_key(|source| (!source.is_rig(), source.is_edits()));
    let mut opened = Vec::new();
    for source in sources {
        let found = source.read(rig.as_deref(), take.as_ref())?;
        match &found {
            Opened::Rig(found, _) => (rig, take) = (Some(found.clone()), None),
            Opened::Take(found) => take = Some(found.take.clone()),
            Opened::Numbers(_) => {}
            #[cfg(not(target_arch = "wasm32"))]
            Opened::Edits(_) => {}
        }
        opened.push(found);
    }
    Ok(opened)
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    fn open(sources: Vec<Source>) -> Result<Vec<Opened>> {
        let opening = Opening::new(sources, None, None, || ());
        opening.result.recv_timeout(std::time::Duration::from_secs(60)).unwrap()
    }

    #[test]
    fn a_rig_and_its_take_in_any_order_from_files_and_from_bytes() {
        let face = rhytid_demo::face(1_000);
        let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let paths = ["take.csv", "face.safetensors"].map(|name| folder.path().join(name));
        take::write(&paths[0], &rhytid_demo::performance(&face)).unwrap();
        rig_file::write(&paths[1], &rig).unwrap();
        let bytes = paths.clone().map(|path| {
            let bytes = std::fs::read(&path).unwrap();
            Source::Bytes(path.display().to_string(), bytes.into())
        });
        for sources in [paths.map(Source::Path), bytes] {
            match &open(sources.to_vec()).unwrap()[..] {
                [Opened::Rig(found, _), Opened::Take(take)] => {
                    assert_eq!(**found, rig);
                    assert_eq!(take.take, rhytid_demo::performance(&face));
                }
                other => panic!("{} things", other.len()),
            }
            let alone = open(vec![sources[0].clone()]).unwrap_err().to_string();
            assert!(alone.contains("open a rig first"), "{alone}");
        }
    }

    #[test]
    fn broken_files_are_a_sentence() {
        for (name, bytes) in [("a.safetensors", &b"{"[..]), ("a.safetensors", b""), ("a.csv", b"")] {
            let error = open(vec![Source::Bytes(name.to_owned(), bytes.into())]).unwrap_err();
            assert!(matches!(error, Error::Input(_)) && error.to_string().contains(name), "{error}");
        }
        assert!(matches!(open(vec![Source::Path("nowhere.safetensors".into())]), Err(Error::Io { .. })));
    }
}
