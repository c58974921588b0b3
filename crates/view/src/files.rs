//! The files that the user opens.

use crate::app::{Note, ViewApp};
#[cfg(not(target_arch = "wasm32"))]
use crate::dialog;
use crate::document::Document;
use crate::open::{self, Opened, Source};
use crate::open_mesh::{MeshFrames, OpenMesh};
use crate::same::Same;
use crate::scene::Scene;
use crate::settings::{Before, Show};
use crate::work::Next;
use rhytid_core::{Error, Result, Rig};
use std::sync::Arc;

impl ViewApp {
    /// Begins to read files: a rig, and takes for this rig or for the open one.
    pub(crate) fn open(&mut self, sources: Vec<Source>) {
        if sources.is_empty() {
            return;
        }
        #[cfg(not(target_arch = "wasm32"))]
        if self.has_unsaved_pulls() && sources.iter().any(Source::takes_the_rigs_place) {
            self.leaving = Some(crate::leaving::Leaving::Open(sources));
            return;
        }
        let document = self.document();
        let rig = document.filter(|document| !document.is_mesh()).map(|document| document.rig.clone());
        // Only a file of edits needs a copy of the take.
        let take = document.and_then(Document::take).filter(|_| sources.iter().any(Source::is_edits));
        let take = take.map(|open| open.take.clone());
        self.warnings.clear();
        self.elsewhere = None;
        self.opening = Some(open::begin(sources, rig, take, &self.context));
    }

    /// Shows the system's dialog for opening files.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn choose(&mut self) {
        if self.choosing.is_none() {
            self.choosing = Some(dialog::begin(&self.context));
        }
    }

    /// Opens the files that were chosen in the dialog.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn take_chosen(&mut self) {
        let Some(choosing) = &self.choosing else { return };
        let chosen = match choosing.next() {
            Next::Waiting => return,
            Next::Result(chosen) => chosen,
            Next::Ended | Next::Broken => Ok(Vec::new()),
        };
        self.choosing = None;
        match chosen {
            Ok(files) => self.open_paths(&files),
            Err(error) => self.tell(Err(error)),
        }
    }

    /// Takes note of a file that was opened.
    #[cfg(not(target_arch = "wasm32"))]
    fn remember(&mut self, name: &str) {
        // A list that cannot be written is no reason to bother anybody.
        if let Err(error) = self.recent.add(std::path::Path::new(name)) {
            log::warn!("the list of recent files: {error}");
        }
    }

    #[cfg(target_arch = "wasm32")]
    fn remember(&mut self, _: &str) {}

    /// Begins to read files.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open_paths(&mut self, paths: &[std::path::PathBuf]) {
        self.open(paths.iter().cloned().map(Source::new).collect());
    }

    /// Opens the files that have been read.
    pub(crate) fn take_opened(&mut self) {
        while let Some(opening) = &self.opening {
            self.warnings.extend(opening.work.take_warnings());
            match opening.next() {
                Next::Waiting => return,
                Next::Result(Err(Error::Cancelled)) => self.opening = None,
                Next::Result(opened) => self.attempt(|app| app.take_one(opened?)),
                Next::Ended => self.opening = None,
                Next::Broken => {
                    let fault = format!("{} ended without a result", opening.words);
                    self.opening = None;
                    self.tell(Err(Error::Internal(fault)));
                }
            }
        }
    }

    /// Stops reading files.
    pub(crate) fn stop_opening(&mut self) {
        self.opening = None;
    }

    /// Shows a rig, or a mesh with its frames, in place of what was open.
    fn show(&mut self, rig: Arc<Rig>, name: &str, frames: Option<Same<MeshFrames>>) {
        let before = self.scene.take();
        let window = (&self.state, &self.context);
        let mut scene = Scene::new(rig, name, &self.gpu, window, self.device.clone(), frames, before);
        scene.pace.always_whole = self.whole_pictures;
        self.scene = Some(scene);
        self.remember(name);
    }

    fn take_one(&mut self, opened: Opened) -> Result<()> {
        match opened {
            Opened::Rig(rig, name) => {
                if self.settings.show == Show::Numbers {
                    self.settings.show = Show::default();
                }
                self.show(rig, &name, None);
                self.note = None;
                #[cfg(not(target_arch = "wasm32"))]
                self.listen_again();
            }
            Opened::Mesh(OpenMesh { name, rig, frames, words }) => {
                self.settings.before = Before::Off;
                if self.settings.show.needs_rig() {
                    self.settings.show = Show::default();
                }
                self.show(rig, &name, Some(frames));
                #[cfg(not(target_arch = "wasm32"))]
                {
                    self.live = None;
                }
                self.tell(Ok(words));
            }
            Opened::Take(take) => {
                self.remember(&take.name);
                if let Some(scene) = &mut self.scene {
                    let is_open = scene.document.take().is_some_and(|before| before.name == take.name);
                    scene.document.set_take(take)?;
                    // A take that was read again stays where it was.
                    scene.document.transport.playing |= !is_open;
                    self.note = None;
                }
            }
            Opened::Elsewhere(elsewhere) => {
                self.note = Some(Note { words: elsewhere.words.clone(), is_error: true });
                self.elsewhere = Some(elsewhere);
            }
            Opened::Numbers(numbers) => {
                if let (Some(scene), Some((_, first))) = (&mut self.scene, numbers.first()) {
                    self.settings.show_numbers(0, first);
                    scene.document.set_numbers(numbers);
                    self.note = None;
                }
            }
            #[cfg(not(target_arch = "wasm32"))]
            Opened::Edits(edits) => {
                if let Some(scene) = &mut self.scene {
                    scene.document.set_edits(edits);
                    self.note = None;
                }
            }
        }
        Ok(())
    }
}
