//! The open document and its picture.

use crate::document::Document;
use crate::gpu::Gpu;
use crate::legend::Spread;
use crate::open_mesh::MeshFrames;
use crate::orbit::Orbit;
use crate::order::Order;
use crate::pace::{Fineness, Pace};
use crate::painter::{Answer, Done, Job, JobKind, Painted, Painter, Then};
use crate::pick;
use crate::same::Same;
use crate::screen::Screen;
use crate::settings::{Settings, Show};
use crate::soft_selection::Drag;
use crate::studio::Studio;
use crate::work::{DeviceTask, Next, Task, Work};
use eframe::egui;
use eframe::egui_wgpu::RenderState;
use glam::Vec3;
use rhytid_core::{DeviceInfo, Error, Explanation, Result, Rig};
use rhytid_render::SkinRenderer;
#[cfg(not(target_arch = "wasm32"))]
use std::path::PathBuf;
use std::sync::Arc;
use web_time::Duration;

/// A picture that takes longer is stopped if it is out of date.
const LONG: Duration = Duration::from_millis(60);

/// The times of the last picture, by parts.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// From handle positions to a frame.
    pub evaluation: Duration,
    /// Lighting skin.
    pub lighting: Duration,
    /// The rest of drawing.
    pub drawing: Duration,
}

impl std::ops::Add for Times {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            evaluation: self.evaluation + other.evaluation,
            lighting: self.lighting + other.lighting,
            drawing: self.drawing + other.drawing,
        }
    }
}

/// The light of skin for the rig, as far as it is prepared.
enum SkinState {
    None,
    Preparing(DeviceTask<Result<SkinRenderer>>),
    Ready(Same<SkinRenderer>),
    /// It could not be prepared.
    Failed,
}

/// How the window sees its pictures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub size: [u32; 2],
    /// Pixels in a point.
    pub scale: f32,
    pub background: [u8; 4],
    /// The time, in seconds since the window was made.
    pub now: f64,
    /// How long the window waits for a picture before it goes on with the last one.
    pub patience: Duration,
}

/// What the window has to hear of the scene's work.
#[derive(Debug)]
pub(crate) enum News {
    /// The device that evaluates from now on.
    Device(Option<DeviceInfo>),
    /// The chosen device was refused. The one before stays.
    DeviceRefused(Error),
    #[cfg(not(target_arch = "wasm32"))]
    Saved(PathBuf),
    Failed(Error),
}

/// An open rig and its picture.
pub(crate) struct Scene {
    pub document: Document,
    pub orbit: Orbit,
    /// The selected markers, which are dragged together.
    pub selected: Vec<usize>,
    /// The marker under the pointer.
    pub under: Option<usize>,
    /// The vertex that was picked.
    pub vertex: Option<usize>,
    pub times: Times,
    /// H unit vectors: the normals of the skin at the handles, at rest.
    pub normals: Vec<Vec3>,
    /// The numbers of the map that is shown.
    pub spread: Option<Spread>,
    /// The place of the picture in the window, in points.
    pub place: Option<egui::Rect>,
    /// The number of pictures since the rig was opened.
    pub drawn: u64,
    pub pace: Pace,
    gpu: Gpu,
    context: egui::Context,
    painter: Painter,
    screen: Screen,
    skin: SkinState,
    /// The size of the picture in pixels.
    size: [u32; 2],
    /// What the window wants to be shown.
    wanted: Option<Order>,
    /// What is being drawn.
    asked: Option<(Order, Fineness)>,
    /// What is shown.
    shown: Option<(Order, Fineness)>,
    /// What could not be drawn, or was stopped. It is not tried again.
    given_up: Option<Order>,
}

impl Scene {
    /// Opens a rig in the window of `state` and `context`, whose device is `gpu`. If a `device` is
    /// given, it evaluates. A mesh without a rig has `frames`. The scene `before` makes room first.
    pub(crate) fn new(
        rig: Arc<Rig>,
        name: &str,
        gpu: &Gpu,
        window: (&RenderState, &egui::Context),
        device: Option<DeviceInfo>,
        frames: Option<Same<MeshFrames>>,
        before: Option<Self>,
    ) -> Self {
        let (state, context) = window;
        let (before, skin) = before.map_or((None, None), |b| (Some(b.painter), Some(b.skin)));
        if let Some(SkinState::Preparing(DeviceTask(task))) = &skin {
            task.work.stop();
        }
        let make = {
            let (rig, gpu, frames) = (rig.clone(), gpu.clone(), frames.clone());
            move || {
                drop(skin);
                Studio::new(rig, &gpu, device.as_ref(), frames)
            }
        };
        Self {
            painter: Painter::new(context, before, make),
            screen: Screen::new(state),
            normals: crate::marker_guides::normals(&rig),
            spread: None,
            orbit: if frames.is_some() { Orbit::around(&rig, 1.0) } else { Orbit::new(&rig, 1.0) },
            document: match frames {
                Some(frames) => Document::of_mesh(rig, name, frames),
                None => Document::new(rig, name),
            },
            gpu: gpu.clone(),
            context: context.clone(),
            selected: Vec::new(),
            under: None,
            vertex: None,
            times: Times::default(),
            place: None,
            drawn: 0,
            pace: Pace::default(),
            skin: SkinState::None,
            size: [1; 2],
            wanted: None,
            asked: None,
            shown: None,
            given_up: None,
        }
    }

    /// Has the picture drawn if anything of it has changed, and shows what has been drawn. The result is what
    /// the window has to hear of.
    pub(crate) fn draw(&mut self, settings: &Settings, view: View) -> Vec<News> {
        let mut news = Vec::new();
        self.size = view.size;
        self.prepare_skin(settings, view.patience, &mut news);
        self.hear(Duration::ZERO, &mut news);
        let order = self.order(settings, view);
        if self.wanted.as_ref() != Some(&order) {
            self.pace.change(view.now);
            self.wanted = Some(order.clone());
        }
        self.stop_what_is_old(&order);
        let fineness = self.pace.fineness(view.now);
        let is_shown = |(shown, how): &(Order, Fineness)| {
            *shown == order && (*how == Fineness::Whole || fineness != Fineness::Whole)
        };
        let is_due = self.asked.is_none()
            && self.given_up.as_ref() != Some(&order)
            && !self.shown.as_ref().is_some_and(is_shown);
        if is_due && self.painter.is_alive() {
            self.asked = Some((order.clone(), fineness));
            self.painter.request(Job::Paint(Box::new(order), fineness));
        }
        // A picture that takes long wakes the window when it is there.
        let waits = is_due || self.pace.always_whole;
        self.hear(if waits { view.patience } else { Duration::ZERO }, &mut news);
        if fineness != Fineness::Whole
            && let Some(wait) = self.pace.until_rest(view.now)
        {
            self.context.request_repaint_after(wait);
        }
        news
    }

    /// Stops a whole picture that is long in the making and out of date.
    fn stop_what_is_old(&mut self, order: &Order) {
        let Some((asked, Fineness::Whole)) = &self.asked else { return };
        let Some(work) = self.painter.work() else { return };
        let age = work.age();
        if *asked != *order && age > LONG && !self.pace.always_whole {
            work.stop();
            self.pace.measured(Times { lighting: age, ..self.times });
        }
    }

    /// Everything that the picture depends on.
    fn order(&self, settings: &Settings, view: View) -> Order {
        // These settings do not change a picture.
        let Settings { wipe, reach, mirrored, names, .. } = Settings::default();
        let is_mesh = self.document.is_mesh();
        let order = Order {
            frame: 0,
            handles: Vec::new(),
            undragged: None,
            edits: None,
            problems: Vec::new(),
            camera: self.orbit.camera(),
            settings: Settings {
                wipe,
                reach,
                mirrored,
                names,
                markers: settings.markers && !is_mesh,
                ..settings.clone()
            },
            size: view.size,
            scale: view.scale,
            background: view.background,
            selected: self.selected.clone(),
            pinned: self.document.pose().pinned.clone(),
            confidence: self.document.live_confidence().to_vec(),
            under: self.under,
            follows: if settings.markers { self.follows(settings) } else { Vec::new() },
            vertex: self.vertex,
            numbers: self.document.shared_numbers(),
            skin: match &self.skin {
                SkinState::Ready(skin) if settings.show == Show::Skin => Some(skin.clone()),
                _ => None,
            },
        };
        order.of_frame(&self.document, self.document.transport.frame())
    }

    /// The pictures of the range of the take, a frame each, as the window would draw them now.
    ///
    /// # Errors
    /// [`Error::Input`] before the first picture.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn orders(&self) -> Result<Vec<Order>> {
        let like = self.wanted.as_ref().ok_or_else(|| Error::empty("nothing was drawn yet"))?;
        // What the pointer is on is no part of a film.
        let like = match like.under {
            Some(_) => Order { under: None, follows: Vec::new(), ..like.clone() },
            None => like.clone(),
        };
        let [first, last] = self.document.transport.range();
        Ok((first..=last).map(|frame| like.clone().of_frame(&self.document, frame)).collect())
    }

    /// Prepares the light of skin when it is first shown.
    fn prepare_skin(&mut self, settings: &Settings, patience: Duration, news: &mut Vec<News>) {
        let is_wanted = settings.show == Show::Skin;
        if let (SkinState::None, true) = (&self.skin, is_wanted) {
            let (rig, gpu) = (self.document.rig.clone(), self.gpu.clone());
            let words = "preparing the light in the skin".to_owned();
            let task = Task::new(words, &self.context, move |work, give| {
                give(crate::canvas::skin(&rig, &gpu, work));
            });
            self.skin = SkinState::Preparing(DeviceTask(task));
        }
        let SkinState::Preparing(DeviceTask(task)) = &self.skin else { return };
        self.skin = match task.wait(if is_wanted { patience } else { Duration::ZERO }) {
            Next::Waiting => return,
            Next::Result(Ok(skin)) => SkinState::Ready(Same::new(skin)),
            Next::Result(Err(Error::Cancelled)) => SkinState::None,
            Next::Result(Err(error)) => {
                news.push(News::Failed(error));
                SkinState::Failed
            }
            Next::Ended | Next::Broken => {
                news.push(News::Failed(Error::Internal("preparing skin ended without a result".into())));
                SkinState::Failed
            }
        };
    }

    /// Takes what the painter has done. Waits for the picture up to `patience`.
    fn hear(&mut self, patience: Duration, news: &mut Vec<News>) {
        while let Some(Done { job, result }) = self.painter.answer(patience) {
            let asked = if job == Some(JobKind::Paint) { self.asked.take() } else { None };
            match (result, job) {
                (Ok(Answer::Ready), _) => {}
                (Ok(Answer::Painted(painted)), _) => self.show(*painted),
                (Ok(Answer::Picked(found, Then::Explain)), _) => self.vertex = found.map(|found| found.0),
                (Ok(Answer::Picked(found, Then::Focus)), _) => {
                    if let Some((_, point)) = found {
                        self.orbit.focus(point);
                    }
                }
                (Ok(Answer::Device(device)), _) => {
                    self.shown = None;
                    news.push(News::Device(device));
                }
                #[cfg(not(target_arch = "wasm32"))]
                (Ok(Answer::Saved(path)), _) => news.push(News::Saved(path)),
                (Err(Error::Cancelled), Some(_)) => {}
                (Err(error), Some(JobKind::Device)) => news.push(News::DeviceRefused(error)),
                (Err(error), _) => {
                    self.given_up = asked.map(|(order, _)| order);
                    news.push(News::Failed(error));
                }
            }
        }
    }

    fn show(&mut self, painted: Painted) {
        self.screen.show(&painted.textures, painted.fineness.parts() > 1);
        if painted.fineness == Fineness::Whole {
            self.pace.measured(painted.times);
        }
        self.times = painted.times;
        if self.spread != painted.spread {
            self.spread = painted.spread;
            // The panel shows it, and comes before the picture.
            self.context.request_repaint();
        }
        self.drawn += 1;
        self.shown = Some((painted.order, painted.fineness));
    }

    /// The work that the user may want to know of, with its words.
    pub(crate) fn work(&self, settings: &Settings) -> Option<(String, &Work)> {
        if let SkinState::Preparing(DeviceTask(task)) = &self.skin
            && settings.show == Show::Skin
        {
            return Some((task.in_words(), &task.work));
        }
        let work = self.painter.work()?;
        let step = work.step_in_words();
        let words = if step.is_empty() { "putting the face on the device".to_owned() } else { step };
        Some((words, work))
    }

    /// Stops the work. A picture that was stopped stays as it is until something changes.
    pub(crate) fn stop(&mut self, settings: &mut Settings) {
        if let SkinState::Preparing(DeviceTask(task)) = &self.skin
            && settings.show == Show::Skin
        {
            task.work.stop();
            settings.show = Show::default();
            return;
        }
        self.given_up = self.asked.as_ref().map(|(order, _)| order.clone());
        if let Some(work) = self.painter.work() {
            work.stop();
        }
    }

    /// Whether the picture is out of date, or coarse.
    pub(crate) fn is_drawing(&self) -> bool {
        let is_shown = |wanted: &Order| {
            let is_whole = |(shown, how): &(Order, Fineness)| shown == wanted && *how == Fineness::Whole;
            self.shown.as_ref().is_some_and(is_whole) || self.given_up.as_ref() == Some(wanted)
        };
        let shows_skin = self.wanted.as_ref().is_some_and(|order| order.settings.show == Show::Skin);
        let is_preparing = shows_skin && matches!(self.skin, SkinState::Preparing(_));
        let is_done = self.wanted.as_ref().is_some_and(is_shown) && self.painter.work().is_none();
        self.painter.is_alive() && (is_preparing || !is_done)
    }

    /// Evaluates on another device from now on. `None` for the device that draws.
    pub(crate) fn set_device(&mut self, device: Option<DeviceInfo>) {
        self.painter.request(Job::Device(device));
    }

    /// Saves what is shown by a `job`.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn save(&mut self, job: impl FnOnce(Box<Order>) -> Job) -> Result<()> {
        let order = self.wanted.clone().ok_or_else(|| Error::empty("nothing was drawn yet"))?;
        self.painter.request(job(Box::new(order)));
        Ok(())
    }

    /// The texture of a side in the window: 0 is the result, 1 the side that it is compared with.
    pub(crate) fn texture(&self, side: usize) -> Option<egui::TextureId> {
        self.screen.texture(side)
    }

    /// The size of the picture in pixels. Before the first picture it is 1 × 1.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The marker at a place of the picture, in pixels.
    pub(crate) fn marker_at(&self, at: [f32; 2], reach: f32) -> Option<usize> {
        if self.document.is_mesh() {
            return None;
        }
        let handles = self.document.handles(true);
        pick::marker(&handles, &self.orbit.camera(), self.size(), at, reach)
    }

    /// The markers that a drag would move by itself: the one under the pointer, or else those that are
    /// selected. Any of several selected markers stands for them all.
    pub(crate) fn held(&self) -> Vec<usize> {
        match self.under {
            Some(under) if !self.selected.contains(&under) => vec![under],
            _ => self.selected.clone(),
        }
    }

    /// H: how far each handle would follow a drag of the held markers, from 0 to 1. Empty without such.
    fn follows(&self, settings: &Settings) -> Vec<f32> {
        let held = self.held();
        if held.is_empty() {
            return Vec::new();
        }
        let drag = Drag {
            grabbed: &held,
            by: [0.0, 1.0, 0.0],
            reach: settings.reach / self.millimetres(),
            mirrored: settings.mirrored,
            pinned: &self.document.pose().pinned,
        };
        self.document.soft_selection().drag(drag).into_iter().map(|[_, y, _]| y).collect()
    }

    /// Looks for the vertex at a place of the picture, in pixels.
    pub(crate) fn pick(&mut self, settings: &Settings, view: View, at: [f32; 2], then: Then) {
        let order = Box::new(self.order(settings, view));
        self.painter.request(Job::Pick { order, at, then });
    }

    /// The explanation of the vertex that was picked.
    ///
    /// # Errors
    /// As [`Rig::explain`].
    pub(crate) fn explanation(&self) -> Result<Option<Explanation>> {
        let handles = self.document.handles(true);
        self.vertex.map(|vertex| self.document.rig.explain(vertex, &handles)).transpose()
    }

    /// The painter's studio.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn studio(&self) -> Option<&Studio> {
        self.painter.studio()
    }

    /// Millimetres in one mesh unit.
    pub(crate) fn millimetres(&self) -> f32 {
        1e3 * self.document.rig.surface().metres_per_unit as f32
    }
}
