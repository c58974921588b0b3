//! Exports: the take with its edits and pulls as a file, and a film of what is seen. Each goes on beside the
//! window, and appears under its name only when it is whole.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::document::Document;
use crate::gpu::Gpu;
use crate::order::Order;
use crate::same::Same;
use crate::save;
use crate::settings::Show;
use crate::studio::Studio;
use crate::work::{DeviceTask, Next, Task, Work};
use rhytid_backend_cpu::Cpu;
use rhytid_capture::TakeSpace;
use rhytid_core::{
    AtomicFile, Backend, ChannelKind, DeviceInfo, Error, Missing, NoProgress, Progress, Reach, Result, Rig,
    Take, rig_file,
};
use rhytid_formats::animation::Format;
use rhytid_formats::export::{Options, Recipe, Treatment};
use rhytid_playback::{Layers, Performance};
use rhytid_render::{AnimatedImage, AnimatedImageFormat};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An export that goes on: the path of the file.
pub(crate) type Exporting = DeviceTask<Result<PathBuf>>;

/// The endings of films, the best first. Builds without films write animated pictures.
const FILMS: [&str; 2] = ["mp4", "webp"];

impl ViewApp {
    /// Begins the export of a command.
    pub(crate) fn export(&mut self, command: Command) {
        self.attempt(|app| {
            if app.exporting.is_some() {
                return Err(Error::conflict("another export goes on; wait for it, or stop it"));
            }
            let ending = match command {
                Command::ExportUsd => "usdc",
                Command::ExportGlb => "glb",
                _ => return app.begin_film(),
            };
            let Some(scene) = &app.scene else { return Ok(()) };
            let job = TakeJob::new(&scene.document, app.device.clone(), ending)?;
            let words = format!("writing {}", name_of(&job.path));
            let task = Task::new(words, &app.context, move |work, give| give(job.run(work)));
            app.exporting = Some(DeviceTask(task));
            Ok(())
        });
    }

    fn begin_film(&mut self) -> Result<()> {
        let Some(scene) = &self.scene else { return Ok(()) };
        let document = &scene.document;
        let take = document.take().ok_or_else(|| Error::empty("there is no take to film; open one first"))?;
        let (format, ending) = FILMS
            .into_iter()
            .find_map(|ending| Some((AnimatedImageFormat::by_extension(ending)?, ending)))
            .ok_or_else(|| Error::Internal("this build writes no films".to_owned()))?;
        let path = save::free(Path::new(&document.name), "film", ending)?;
        let job = FilmJob {
            rig: document.rig.clone(),
            gpu: self.gpu.clone(),
            device: self.device.clone(),
            orders: scene.orders()?,
            rate: take.take.rate(),
            format,
            path,
        };
        format.check(job.orders[0].size, &job.path)?;
        let words = format!("filming {}", name_of(&job.path));
        let task = Task::new(words, &self.context, move |work, give| give(job.run(work)));
        self.exporting = Some(DeviceTask(task));
        Ok(())
    }

    /// Says where an export is when it is done, or why it failed.
    pub(crate) fn take_exported(&mut self) {
        let Some(DeviceTask(task)) = &self.exporting else { return };
        self.warnings.extend(task.work.take_warnings());
        let result = match task.next() {
            Next::Waiting => return,
            Next::Result(result) => result,
            Next::Ended | Next::Broken => {
                Err(Error::Internal(format!("{} ended without a result", task.words)))
            }
        };
        self.exporting = None;
        match result {
            Ok(path) => self.saved(&path),
            Err(Error::Cancelled) => self.tell(Ok("the export was stopped; nothing was written".to_owned())),
            Err(error) => self.tell(Err(error)),
        }
    }

    /// Asks the export to stop. It ends at its next frame.
    pub(crate) fn stop_exporting(&mut self) {
        if let Some(DeviceTask(task)) = &self.exporting {
            task.work.stop();
        }
    }

    /// Whether an export goes on.
    pub fn is_exporting(&self) -> bool {
        self.exporting.is_some()
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The export of a take.
struct TakeJob {
    rig: Arc<Rig>,
    take: Take,
    /// The name of the take.
    name: String,
    /// The space that it was read in, if it was another than the rig's.
    space: Option<TakeSpace>,
    /// The text of the edits and pulls, and the file that its paths are relative to.
    edits: Option<(String, PathBuf)>,
    frames: [usize; 2],
    device: Option<DeviceInfo>,
    path: PathBuf,
}

impl TakeJob {
    fn new(document: &Document, device: Option<DeviceInfo>, ending: &str) -> Result<Self> {
        let open =
            document.take().ok_or_else(|| Error::empty("there is no take to write; open one first"))?;
        let stem = Path::new(&open.name).file_stem().unwrap_or_default();
        Ok(Self {
            rig: document.rig.clone(),
            take: open.take.clone(),
            name: stem.to_string_lossy().into_owned(),
            space: open.reading.space,
            edits: save::edits_of(document)?,
            frames: document.transport.range(),
            device,
            path: save::free(Path::new(&document.name), "take", ending)?,
        })
    }

    /// # Errors
    /// As [`Performance::new`], [`rhytid_playback::Playback::export`] and [`Layers::of_text`].
    fn run(self, work: &Work) -> Result<PathBuf> {
        let layers = self.edits.map(|(text, path)| Layers::of_text(text, &path, &self.rig, Reach::Below));
        let layers = layers.transpose()?;
        let format = Format::from_extension(&self.path)?;
        let mut recipe = Recipe {
            rig: rig_file::hash_of(&self.rig)?,
            first_frame: self.frames[0] as u64,
            end_frame: self.frames[1] as u64 + 1,
            missing: Missing::Hold,
            edit: layers.as_ref().map(|layers| layers.text().to_owned()),
            edit_hash: layers.as_ref().map(|layers| layers.hash().to_owned()),
            treatment: Treatment {
                metres_per_unit: self.space.map(|space| space.metres_per_unit),
                axes: self.space.map(|space| space.axes.to_string()),
                ..Treatment::default()
            },
            ..Recipe::default()
        };
        let lacks = |kind: &ChannelKind| kind.is_default() && !format.carries(*kind);
        ChannelKind::ALL.into_iter().filter(lacks).for_each(|kind| recipe.channels.set(kind, false));
        let performance = Performance::new(recipe, (*self.rig).clone(), self.take, layers)?;
        let devices = self.device.map_or_else(Cpu::devices, |device| Ok(vec![device]))?;
        let options = Options { clips: vec![self.name], ..Options::default() };
        performance.playback(&devices, work)?.export(&performance, &self.path, &options, work)?;
        Ok(self.path)
    }
}

/// A film of what is seen.
struct FilmJob {
    rig: Arc<Rig>,
    gpu: Gpu,
    device: Option<DeviceInfo>,
    /// A picture each.
    orders: Vec<Order>,
    /// Pictures a second.
    rate: f64,
    format: AnimatedImageFormat,
    path: PathBuf,
}

impl FilmJob {
    /// # Errors
    /// As uploading the rig, evaluating, drawing and writing.
    fn run(self, work: &Work) -> Result<PathBuf> {
        let count = self.orders.len() as u64;
        let Some(first) = self.orders.first() else {
            return Err(Error::empty("there are no frames to film"));
        };
        let mut file = AtomicFile::create(&self.path)?;
        // The film has light of its own, since the window goes on drawing with the other.
        let skin = match first.settings.show {
            Show::Skin => Some(Same::new(crate::canvas::skin(&self.rig, &self.gpu, work)?)),
            _ => None,
        };
        let mut studio = Studio::new(self.rig, &self.gpu, self.device.as_ref(), None)?;
        let io = |error| Error::io(&self.path)(error);
        let film = AnimatedImage::new(self.format, &mut file, first.size, count as u32, self.rate);
        let mut film = film.map_err(io)?;
        for (done, order) in (0..).zip(self.orders) {
            work.step("film", done, count)?;
            let picture = studio.picture(Order { skin: skin.clone(), ..order }, &NoProgress)?;
            film.add(&picture).map_err(io)?;
        }
        work.step("film", count, count)?;
        film.finish().map_err(io)?;
        file.finish()?;
        Ok(self.path)
    }
}
