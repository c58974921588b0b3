//! The open document, evaluated and drawn.

use crate::canvas::{Canvas, Drawn, Shown, Took};
use crate::document::Document;
use crate::frame_source::{FrameSource, OtherDevice, Wanted};
use crate::orbit::Orbit;
use crate::pick;
use crate::settings::{Before, Settings, Show};
use eframe::egui_wgpu::RenderState;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Explanation, Result, Rig};
use rhytid_render::{Camera, Heat, Lights, Mark, Strains, distances, influence_marks, marker_marks};
use std::sync::Arc;
use web_time::{Duration, Instant};

const MARKER: [f32; 3] = [0.02, 0.02, 0.02];
const TAKEN: [f32; 3] = [1.0, 0.35, 0.0];
const PINNED: [f32; 3] = [0.05, 0.2, 0.9];
const RIM: [f32; 3] = [1.0, 1.0, 1.0];

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

/// Everything that a picture depends on. If nothing of it has changed, the picture is not drawn again.
#[derive(PartialEq)]
struct Seen {
    handles: Vec<[f32; 3]>,
    undragged: Option<Vec<[f32; 3]>>,
    /// The time of the frame, if edits depend on it.
    edited: Option<f64>,
    camera: Camera,
    settings: Settings,
    size: [u32; 2],
    background: [u8; 4],
    selected: Vec<usize>,
    pinned: Vec<bool>,
    /// The confidence of a live frame's markers.
    confidence: Vec<f32>,
    under: Option<usize>,
    vertex: Option<usize>,
}

/// An open rig with everything that draws it.
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
    /// The place of the picture in the window, in points.
    pub place: Option<eframe::egui::Rect>,
    /// The number of pictures since the rig was opened.
    pub drawn: u64,
    canvas: Canvas,
    source: FrameSource,
    /// The same rig with the shell alone. It is made when it is first needed.
    shell: Option<FrameSource>,
    strains: Option<Strains>,
    seen: Option<Seen>,
}

impl Scene {
    /// Opens a rig in the window of `state`, whose device `wgpu` shares. An `other` device evaluates it, if
    /// one is given.
    ///
    /// # Errors
    /// As uploading the rig.
    pub(crate) fn new(
        rig: Arc<Rig>,
        name: &str,
        wgpu: &Wgpu,
        state: &RenderState,
        other: Option<OtherDevice>,
    ) -> Result<Self> {
        Ok(Self {
            canvas: Canvas::new(&rig, wgpu, state)?,
            source: FrameSource::new(rig.clone(), wgpu, other)?,
            orbit: Orbit::new(&rig, 1.0),
            document: Document::new(rig, name),
            selected: Vec::new(),
            under: None,
            vertex: None,
            times: Times::default(),
            place: None,
            drawn: 0,
            shell: None,
            strains: None,
            seen: None,
        })
    }

    /// Evaluates on another device from now on. `None` for the device that draws.
    ///
    /// # Errors
    /// As uploading the rig.
    pub(crate) fn set_device(&mut self, other: Option<OtherDevice>) -> Result<()> {
        let (rig, wgpu) = (self.source.rig().clone(), self.source.wgpu().clone());
        self.source = FrameSource::new(rig, &wgpu, other)?;
        self.seen = None;
        Ok(())
    }

    /// Evaluates and draws everything that has changed since the last picture. The picture has `size` pixels.
    /// The result is whether anything has changed.
    ///
    /// # Errors
    /// As evaluating and drawing.
    pub(crate) fn draw(&mut self, settings: &Settings, size: [u32; 2], background: [u8; 4]) -> Result<bool> {
        let seen = Seen {
            handles: self.document.handles(true),
            undragged: (settings.before == Before::Take).then(|| self.document.handles(false)),
            edited: self.document.frame_edits().map(|edits| edits.time),
            camera: self.orbit.camera(),
            settings: settings.clone(),
            size,
            background,
            selected: self.selected.clone(),
            pinned: self.document.pose().pinned.clone(),
            confidence: self.document.live_confidence().to_vec(),
            under: self.under,
            vertex: self.vertex,
        };
        if self.seen.as_ref() == Some(&seen) {
            return Ok(false);
        }
        self.seen = None;
        self.canvas.resize(size)?;
        *self.canvas.lights() = lights(settings);
        self.times = Times::default();
        match settings.before {
            Before::Off => {}
            Before::Shell => self.side(1, &seen, &seen.handles, 1.0, true)?,
            Before::LargeScale => self.side(1, &seen, &seen.handles, 0.0, false)?,
            Before::Take => {
                let undragged = seen.undragged.as_deref().unwrap_or(&seen.handles);
                self.side(1, &seen, undragged, settings.gain, false)?;
            }
        }
        self.side(0, &seen, &seen.handles, settings.gain, false)?;
        self.drawn += 1;
        self.seen = Some(seen);
        Ok(true)
    }

    /// Draws one side, of the shell's rig or of the rig itself. `gain` is the factor of the wrinkles.
    fn side(
        &mut self,
        side: usize,
        seen: &Seen,
        handles: &[[f32; 3]],
        gain: f32,
        of_shell: bool,
    ) -> Result<()> {
        let settings = &seen.settings;
        let rig = self.document.rig.clone();
        let source = match (of_shell, &mut self.shell) {
            (false, _) => &mut self.source,
            (true, Some(shell)) => shell,
            (true, none) => {
                let shell = Arc::new((*rig).clone().shell()?);
                none.insert(FrameSource::new(shell, self.source.wgpu(), None)?)
            }
        };
        let begin = Instant::now();
        let on_host = settings.show.is_made_on_the_host();
        // The other side of the comparison has no edits either.
        let edits = self.document.frame_edits().filter(|_| side == 0);
        source.evaluate(handles.as_flattened(), Wanted { gain, on_host }, edits.as_ref())?;
        self.times.evaluation += begin.elapsed();
        let begin = Instant::now();
        let mut marks = Vec::new();
        if on_host {
            let [positions, large_scale] = source.last_on_host();
            match settings.show {
                Show::Strain => {
                    let strains = self
                        .strains
                        .get_or_insert_with(|| Strains::new(&rig.surface().faces, &rig.surface().rest));
                    source.set_numbers(&strains.measure(positions));
                }
                Show::Detail => {
                    let millimetres = 1e3 * rig.surface().metres_per_unit as f32;
                    source.set_numbers(&distances(positions, large_scale, millimetres));
                }
                Show::Numbers => {
                    // A vertex without a number has the colour of the largest ones, so that it is noticed.
                    let most = settings.numbers_range.0;
                    let number = |x: &f32| if x.is_nan() { most } else { *x };
                    let numbers = self.document.numbers().get(settings.numbers);
                    let none = vec![0.0; rig.vertices()];
                    let numbers = numbers.map_or(none, |(_, list)| list.iter().map(number).collect());
                    source.set_numbers(&numbers);
                }
                Show::Influences => {
                    marks.extend(seen.vertex.iter().flat_map(|&v| influence_marks(&rig, positions, v)));
                }
                _ => marks.extend(marker_marks(&rig, positions, Heat::Signed(settings.strain_range))),
            }
        }
        if settings.markers {
            marks.extend(dots(seen, handles));
        }
        let drawn = settings.look().map_or(Drawn::Skin, Drawn::Look);
        let shown = Shown { camera: &seen.camera, drawn, marks: &marks, background: seen.background };
        let took = self.canvas.draw(side, &rig, source.vertices()?, shown)?;
        let Took { lighting, drawing } = took;
        self.times.lighting += lighting;
        self.times.drawing += drawing + begin.elapsed().saturating_sub(lighting + drawing);
        Ok(())
    }

    /// The texture of a side in the window: 0 is the result, 1 the side that it is compared with.
    pub(crate) fn texture(&self, side: usize) -> Option<eframe::egui::TextureId> {
        self.canvas.texture(side)
    }

    /// The size of the picture in pixels. Before the first picture it is 1 × 1.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.seen.as_ref().map_or([1; 2], |seen| seen.size)
    }

    /// The marker at a place of the picture, in pixels.
    pub(crate) fn marker_at(&self, at: [f32; 2], reach: f32) -> Option<usize> {
        let handles = self.document.handles(true);
        pick::marker(&handles, &self.orbit.camera(), self.size(), at, reach)
    }

    /// The vertex at a place of the picture, and its position.
    ///
    /// # Errors
    /// As evaluating on the host.
    pub(crate) fn vertex_at(&mut self, at: [f32; 2], gain: f32) -> Result<Option<(usize, [f32; 3])>> {
        let (camera, size) = (self.orbit.camera(), self.size());
        let rig = self.document.rig.clone();
        let [positions, _] = self.on_host(gain)?;
        let vertex = pick::vertex(positions, &rig.surface().triangles, &camera, size, at);
        Ok(vertex.map(|v| (v, positions.as_chunks::<3>().0[v])))
    }

    /// V × 3 positions of the frame, and those of its large scale.
    ///
    /// # Errors
    /// As evaluating.
    pub(crate) fn on_host(&mut self, gain: f32) -> Result<[&[f32]; 2]> {
        // The next picture is evaluated again.
        self.seen = None;
        let handles = self.document.handles(true);
        let edits = self.document.frame_edits();
        self.source.on_host(handles.as_flattened(), gain, edits.as_ref())
    }

    /// The explanation of the vertex that was picked.
    ///
    /// # Errors
    /// As [`Rig::explain`].
    pub(crate) fn explanation(&self) -> Result<Option<Explanation>> {
        let handles = self.document.handles(true);
        self.vertex.map(|vertex| self.document.rig.explain(vertex, &handles)).transpose()
    }

    /// The picture that was drawn last.
    ///
    /// # Errors
    /// As reading it.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn picture(&self) -> Result<Option<rhytid_render::Picture>> {
        self.canvas.picture()
    }

    /// The texture into which the result was drawn.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn drawn_texture(&self) -> Option<&wgpu::Texture> {
        self.canvas.drawn_texture()
    }

    /// The last frame, on the device that evaluated it.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Internal`] if there is none.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn vertices(&self) -> Result<rhytid_render::Vertices<'_>> {
        self.source.vertices()
    }

    /// Millimetres in one mesh unit.
    pub(crate) fn millimetres(&self) -> f32 {
        1e3 * self.document.rig.surface().metres_per_unit as f32
    }
}

/// The dots of the markers. Selected markers and the one under the pointer are larger. Pinned ones are blue.
/// Live markers that are not seen fade into their rims.
fn dots(seen: &Seen, handles: &[[f32; 3]]) -> Vec<Mark> {
    let mut marks = Vec::with_capacity(2 * handles.len());
    for (handle, &at) in handles.iter().enumerate() {
        let is_taken = seen.selected.contains(&handle);
        let width = if is_taken || seen.under == Some(handle) { 11.0 } else { 7.0 };
        let colour = match (is_taken, seen.pinned[handle]) {
            (true, _) => TAKEN,
            (false, true) => PINNED,
            (false, false) => MARKER,
        };
        marks.push(Mark::dot(at, RIM, width + 3.0));
        let faded = 1.0 - seen.confidence.get(handle).copied().unwrap_or(1.0);
        let colour = std::array::from_fn(|c| colour[c] + faded * (RIM[c] - colour[c]));
        marks.push(Mark::dot(at, colour, width));
    }
    marks
}

/// The lights, with the key light at the chosen direction.
fn lights(settings: &Settings) -> Lights {
    let [right, up] = settings.light.map(f32::to_radians);
    Lights { toward: [up.cos() * right.sin(), up.sin(), up.cos() * right.cos()], ..Lights::default() }
}
