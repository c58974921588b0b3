//! The window's state, and its changes.

use crate::commands::Command;
#[cfg(not(target_arch = "wasm32"))]
use crate::dialog::Choosing;
use crate::document::Document;
#[cfg(not(target_arch = "wasm32"))]
use crate::export::Exporting;
use crate::gpu::Gpu;
#[cfg(not(target_arch = "wasm32"))]
use crate::leaving::Leaving;
#[cfg(not(target_arch = "wasm32"))]
use crate::live::{Listen, Live};
use crate::open::{Elsewhere, Opening};
use crate::orbit::Orbit;
#[cfg(not(target_arch = "wasm32"))]
use crate::recent::Recent;
use crate::scene::{News, Scene, Times};
use crate::settings::{Settings, Show};
use crate::slow_frames::SlowFrames;
use crate::theme;
use eframe::egui;
use eframe::egui_wgpu::RenderState;
use rhytid_core::{DeviceInfo, Error, Result};
#[cfg(not(target_arch = "wasm32"))]
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};
use web_time::{Duration, Instant};

/// How long the window waits for a picture before it goes on with the last one. A fast device has it by then.
const PATIENCE: Duration = Duration::from_millis(30);
/// The same, where every picture is wanted.
const ENDLESS: Duration = Duration::from_secs(3600);

/// In a window narrower than this, the panel is closed at first.
pub(crate) const NARROW: f32 = 640.0;

/// The message in the last line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Note {
    pub words: String,
    pub is_error: bool,
}

/// The viewer.
pub struct ViewApp {
    pub(crate) state: RenderState,
    pub(crate) gpu: Gpu,
    pub(crate) scene: Option<Scene>,
    pub(crate) settings: Settings,
    pub(crate) note: Option<Note>,
    /// A take that was not opened, since it is in another space.
    pub(crate) elsewhere: Option<Elsewhere>,
    /// What is likely wrong with the files that were opened last.
    pub(crate) warnings: Vec<String>,
    /// Whether the window waits for each picture, which is drawn in full.
    pub(crate) whole_pictures: bool,
    /// When the window was made.
    began: Instant,
    pub(crate) keys_shown: bool,
    /// The window's title.
    pub(crate) title: String,
    /// Whether the list of events is open.
    pub(crate) events_shown: bool,
    /// `None` until the user opens or closes it.
    panel_shown: Option<bool>,
    /// The devices that can evaluate a frame, and the chosen one. `None` for the device that draws.
    pub(crate) devices: Vec<DeviceInfo>,
    pub(crate) device: Option<DeviceInfo>,
    pub(crate) opening: Option<Opening>,
    /// The export that goes on.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) exporting: Option<Exporting>,
    /// What waits until the user has said what becomes of the pulls.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) leaving: Option<Leaving>,
    /// The system's dialog, while it is open.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) choosing: Option<Choosing>,
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) recent: Recent,
    /// The driver's message when the device is lost, until the user has been told.
    pub(crate) lost: Arc<Mutex<Option<String>>>,
    /// The time of the last move of the play head, on the window's clock, in seconds.
    pub(crate) clock: Option<f64>,
    pub(crate) context: egui::Context,
    #[cfg(target_arch = "wasm32")]
    pub(crate) inbox: crate::inbox::Inbox,
    /// It has an owner more for each result that is being read from the device.
    #[cfg(target_arch = "wasm32")]
    pub(crate) reading: std::rc::Rc<()>,
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) live: Option<Live>,
    /// Where to listen, for any open rig.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) listen_at: Option<Listen>,
}

impl ViewApp {
    /// The viewer in a window that eframe has made.
    ///
    /// # Errors
    /// [`Error::Device`] if the window's device cannot run the kernels; [`Error::Internal`] if the window has
    /// no device.
    pub fn new(context: &eframe::CreationContext<'_>) -> Result<Self> {
        let state = context.wgpu_render_state.clone();
        let state = state.ok_or_else(|| Error::Internal("the window has no device to draw with".into()))?;
        context.egui_ctx.set_fonts(fonts());
        theme::set(&context.egui_ctx);
        context.egui_ctx.add_plugin(SlowFrames::default());
        // A finger that rests on a marker before it drags it is no long press, which would open a menu.
        context.egui_ctx.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
        let lost = Arc::new(Mutex::new(None));
        let (to, egui) = (lost.clone(), context.egui_ctx.clone());
        state.device.set_device_lost_callback(move |reason, message| {
            // The device is destroyed with the window, which is not a loss.
            if reason != wgpu::DeviceLostReason::Destroyed {
                *to.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
                egui.request_repaint();
            }
        });
        Ok(Self {
            lost,
            gpu: Gpu::new(state.device.clone(), state.queue.clone())?,
            state,
            scene: None,
            settings: Settings::default(),
            note: None,
            elsewhere: None,
            warnings: Vec::new(),
            whole_pictures: false,
            began: Instant::now(),
            keys_shown: false,
            title: String::new(),
            events_shown: false,
            panel_shown: None,
            devices: Vec::new(),
            device: None,
            opening: None,
            #[cfg(not(target_arch = "wasm32"))]
            exporting: None,
            #[cfg(not(target_arch = "wasm32"))]
            leaving: None,
            #[cfg(not(target_arch = "wasm32"))]
            choosing: None,
            #[cfg(not(target_arch = "wasm32"))]
            recent: Recent::default(),
            clock: None,
            context: context.egui_ctx.clone(),
            #[cfg(target_arch = "wasm32")]
            inbox: crate::inbox::Inbox::new(&context.egui_ctx),
            #[cfg(target_arch = "wasm32")]
            reading: std::rc::Rc::default(),
            #[cfg(not(target_arch = "wasm32"))]
            live: None,
            #[cfg(not(target_arch = "wasm32"))]
            listen_at: None,
        })
    }

    /// The name of the device that draws.
    pub fn device_name(&self) -> String {
        self.gpu.name()
    }

    /// Names the device that draws, for browsers that do not tell it to the program.
    #[cfg(target_arch = "wasm32")]
    pub fn name_device(&mut self, name: String) {
        self.gpu.set_name(name);
    }

    /// Offers other devices for evaluation.
    #[must_use]
    pub fn with_devices(mut self, devices: Vec<DeviceInfo>) -> Self {
        self.devices = devices;
        self
    }

    /// Evaluates rigs that are opened from now on on this device. `None` for the device that draws.
    #[must_use]
    pub fn with_device(mut self, device: Option<DeviceInfo>) -> Self {
        self.device = device;
        self
    }

    /// Waits for each picture and draws it in full, however long it takes. This is for programs that look at
    /// the pictures. For people, the window goes on, and is coarse while something moves.
    #[must_use]
    pub fn with_whole_pictures(mut self) -> Self {
        self.whole_pictures = true;
        self
    }

    /// Seconds since the window was made. Its own clock stands still while it draws.
    pub(crate) fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// How long the window waits for a picture.
    pub(crate) fn patience(&self) -> Duration {
        if self.whole_pictures { ENDLESS } else { PATIENCE }
    }

    /// The place where a page puts files that it has fetched.
    #[cfg(target_arch = "wasm32")]
    pub fn inbox(&self) -> crate::inbox::Inbox {
        self.inbox.clone()
    }

    /// Keeps the names of the files that are opened in this file, and offers those that it has.
    #[cfg(not(target_arch = "wasm32"))]
    #[must_use]
    pub fn with_recent_files(mut self, file: std::path::PathBuf) -> Self {
        self.recent = Recent::kept_in(file);
        self
    }

    /// The open document.
    pub fn document(&self) -> Option<&Document> {
        self.scene.as_ref().map(|scene| &scene.document)
    }

    /// Shows a frame of the take, and stops there. Beyond the last frame it is the last.
    #[cfg(target_arch = "wasm32")]
    pub fn seek(&mut self, frame: usize) {
        if let Some(scene) = &mut self.scene {
            scene.document.transport.playing = false;
            scene.document.transport.seek(frame);
        }
        self.context.request_repaint();
    }

    /// The camera.
    pub fn orbit(&self) -> Option<&Orbit> {
        self.scene.as_ref().map(|scene| &scene.orbit)
    }

    /// The settings: what is shown, and how markers are dragged.
    pub fn settings_mut(&mut self) -> &mut Settings {
        &mut self.settings
    }

    /// The times of the last picture, and the number of pictures since the rig was opened.
    pub fn times(&self) -> Option<(Times, u64)> {
        self.scene.as_ref().map(|scene| (scene.times, scene.drawn))
    }

    /// The size of the face's picture in pixels; `None` while no rig is open.
    pub fn picture_size(&self) -> Option<[u32; 2]> {
        self.scene.as_ref().map(Scene::size)
    }

    /// The markers that are selected, as handles of the rig.
    pub fn selected(&self) -> &[usize] {
        self.scene.as_ref().map_or(&[], |scene| &scene.selected)
    }

    /// The vertex that was picked.
    pub fn vertex(&self) -> Option<usize> {
        self.scene.as_ref()?.vertex
    }

    /// The window's title, which names the open files.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The message in the last line, and whether it is an error.
    pub fn note(&self) -> Option<(&str, bool)> {
        self.note.as_ref().map(|note| (&*note.words, note.is_error))
    }

    /// The place of a handle in the window, in points from the upper left corner. `None` before the first
    /// picture.
    pub fn handle_in_window(&self, handle: usize) -> Option<[f32; 2]> {
        let scene = self.scene.as_ref()?;
        let place = scene.place.filter(|_| scene.drawn > 0)?;
        let at = scene.document.handles(true).get(handle).copied()?;
        let scale = self.context.pixels_per_point();
        let [x, y, _] = scene.orbit.camera().project(scene.size(), at);
        Some([place.left() + x / scale, place.top() + y / scale])
    }

    /// The picture of the face, without the window around it. `None` before the first picture.
    #[cfg(target_arch = "wasm32")]
    pub fn read_picture(&self) -> Option<impl Future<Output = Result<rhytid_render::Picture>> + use<>> {
        let texture = self.scene.as_ref()?.studio()?.drawn_texture()?.clone();
        let (device, queue) = (self.state.device.clone(), self.state.queue.clone());
        let reading = self.reading.clone();
        self.context.request_repaint();
        Some(async move {
            let picture = rhytid_render::Picture::read_async(&device, &queue, &texture).await;
            drop(reading);
            picture
        })
    }

    /// V × 3 positions of the frame that is shown, from the device that evaluated it. `None` before the first
    /// frame.
    #[cfg(target_arch = "wasm32")]
    pub fn read_positions(&self) -> Option<impl Future<Output = Result<Vec<f32>>> + use<>> {
        let scene = self.scene.as_ref().filter(|scene| scene.drawn > 0)?;
        let vertices = scene.studio()?.vertices().ok()?;
        let slice = vertices.positions;
        let (buffer, bytes) = (slice.buffer().clone(), slice.offset()..slice.offset() + slice.size());
        let (device, queue) = (self.state.device.clone(), self.state.queue.clone());
        let reading = self.reading.clone();
        self.context.request_repaint();
        Some(async move {
            let positions = rhytid_render::read_floats(&device, &queue, &buffer, bytes).await;
            drop(reading);
            positions
        })
    }

    /// Whether files are being read.
    pub fn is_opening(&self) -> bool {
        self.opening.is_some()
    }

    /// Whether the picture is behind what is wanted, or is drawn coarsely for the moment.
    pub fn is_drawing(&self) -> bool {
        self.scene.as_ref().is_some_and(Scene::is_drawing)
    }

    /// What is likely wrong with the files that were opened last.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Shows a message in the last line. An error stays until it is closed.
    pub(crate) fn tell(&mut self, result: Result<String>) {
        self.note = Some(match result {
            Ok(words) => Note { words, is_error: false },
            Err(error) => Note { words: error.to_string(), is_error: true },
        });
    }

    /// Does `what`, and shows its error if it fails.
    pub(crate) fn attempt(&mut self, what: impl FnOnce(&mut Self) -> Result<()>) {
        if let Err(error) = what(self) {
            self.tell(Err(error));
        }
    }

    /// Tells the user what the scene's work has come to.
    pub(crate) fn hear(&mut self, news: Vec<News>) {
        for news in news {
            match news {
                News::Device(device) => self.device = device,
                #[cfg(not(target_arch = "wasm32"))]
                News::Saved(path) => self.saved(&path),
                News::DeviceRefused(error) | News::Failed(error) => self.tell(Err(error)),
            }
        }
    }

    pub(crate) fn is_panel_shown(&self, width: f32) -> bool {
        self.panel_shown.unwrap_or(width >= NARROW)
    }

    pub(crate) fn run(&mut self, command: Command, ui: &egui::Ui) {
        let width = ui.ctx().content_rect().width();
        match command {
            #[cfg(not(target_arch = "wasm32"))]
            Command::Close => self.close(ui.ctx()),
            #[cfg(not(target_arch = "wasm32"))]
            Command::Open => self.choose(),
            Command::Keys => self.keys_shown = !self.keys_shown,
            Command::Events => self.events_shown = !self.events_shown,
            Command::Deselect if self.keys_shown => self.keys_shown = false,
            Command::Panels => self.panel_shown = Some(!self.is_panel_shown(width)),
            Command::Mirror => self.settings.mirrored = !self.settings.mirrored,
            Command::Names => self.settings.names = !self.settings.names,
            Command::Look(i) => {
                let show = Show::ALL.get(usize::from(i)).copied().unwrap_or(self.settings.show);
                match show.needs_rig() && self.document().is_some_and(Document::is_mesh) {
                    true => self.tell(Ok(format!("“{}” would need a rig, and a mesh is open", show.name()))),
                    false => self.settings.show = show,
                }
            }
            #[cfg(not(target_arch = "wasm32"))]
            Command::Screenshot | Command::SaveFrame | Command::SaveExample | Command::SaveEdits => {
                self.save(command);
            }
            #[cfg(not(target_arch = "wasm32"))]
            Command::ExportUsd | Command::ExportGlb | Command::ExportFilm => self.export(command),
            _ => {
                if let Some(scene) = &mut self.scene {
                    scene.run(command, &self.settings);
                }
            }
        }
    }
}

/// Live frames over the network.
#[cfg(not(target_arch = "wasm32"))]
impl ViewApp {
    /// Listens at `address`, instead of the present address.
    pub fn listen(&mut self, address: SocketAddr) {
        self.listen_for(Listen { address, ..Listen::default() });
    }

    /// Listens as `listen` says, instead of as before.
    pub fn listen_for(&mut self, listen: Listen) {
        self.live = None;
        self.listen_at = Some(listen);
        self.listen_again();
    }

    /// The address where it listens. For port 0, it has the port that the system chose. `None` while it does
    /// not listen, or no rig is open.
    pub fn listens_at(&self) -> Option<SocketAddr> {
        self.live.as_ref().map(Live::address)
    }

    /// Listens for the handles of the open rig.
    pub(crate) fn listen_again(&mut self) {
        let Some(listen) = self.listen_at.clone() else { return };
        self.live = None;
        let Some(scene) = self.scene.as_ref().filter(|scene| !scene.document.is_mesh()) else { return };
        match Live::new(&listen, &scene.document.rig, &self.context) {
            Ok(live) => {
                // Port 0 means any free port. The next rig listens at the same port.
                self.listen_at = Some(Listen { address: live.address(), ..listen });
                self.live = Some(live);
            }
            Err(error) => {
                self.listen_at = None;
                self.tell(Err(error));
            }
        }
    }

    /// Stops listening, and shows the take again.
    pub(crate) fn stop_listening(&mut self) {
        (self.live, self.listen_at) = (None, None);
        if let Some(scene) = &mut self.scene {
            scene.document.set_live(None);
        }
    }

    /// Shows the newest live frame.
    pub(crate) fn take_live(&mut self) {
        if let (Some(live), Some(scene)) = (&self.live, &mut self.scene)
            && let Some(frame) = live.frame()
        {
            scene.document.set_live(Some(frame));
        }
    }
}

/// One font for all text. Without the other fonts, a page is smaller to load.
fn fonts() -> egui::FontDefinitions {
    const NAME: &str = "Ubuntu-Light";
    let mut fonts = egui::FontDefinitions::empty();
    let data = egui::FontData::from_static(epaint_default_fonts::UBUNTU_LIGHT);
    fonts.font_data.insert(NAME.to_owned(), Arc::new(data));
    fonts.families.values_mut().for_each(|family| family.push(NAME.to_owned()));
    fonts
}
