//! Evaluates and draws what the window asks for.

use crate::canvas::{Canvas, Drawn, Shown, Took};
use crate::edits::EditedFrame;
use crate::frame_source::{FrameSource, OtherDevice, Wanted};
use crate::gpu::Gpu;
use crate::legend::Spread;
use crate::marker_dots;
use crate::open_mesh::MeshFrames;
use crate::order::Order;
use crate::pace::Fineness;
use crate::painter::{Answer, Job, Painted};
use crate::pick;
use crate::same::Same;
use crate::scene::Times;
use crate::settings::{Before, Settings, Show};
use rhytid_core::{DeviceInfo, Progress, Result, Rig};
use rhytid_render::{Heat, Lights, Look, Strains, distances, influence_marks, marker_marks};
use std::sync::Arc;
use web_time::Instant;

/// A rig on its devices, with everything that draws it.
pub(crate) struct Studio {
    rig: Arc<Rig>,
    canvas: Canvas,
    source: FrameSource,
    /// The same rig with the shell alone. It is made when it is first needed.
    shell: Option<FrameSource>,
    strains: Option<Strains>,
}

impl Studio {
    /// Puts a rig on `gpu`, which draws. If another `device` is chosen, it evaluates. A mesh without a rig
    /// has `frames`, which are not evaluated.
    ///
    /// # Errors
    /// As uploading the rig.
    pub(crate) fn new(
        rig: Arc<Rig>,
        gpu: &Gpu,
        device: Option<&DeviceInfo>,
        frames: Option<Same<MeshFrames>>,
    ) -> Result<Self> {
        let device = device.filter(|_| frames.is_none());
        Ok(Self {
            canvas: Canvas::new(&rig, gpu)?,
            source: FrameSource::new(rig.clone(), gpu, other(device, &rig)?, frames)?,
            rig,
            shell: None,
            strains: None,
        })
    }

    /// Does what was requested.
    ///
    /// # Errors
    /// As evaluating, drawing and writing. [`rhytid_core::Error::Cancelled`].
    pub(crate) fn work(&mut self, job: Job, progress: &dyn Progress) -> Result<Answer> {
        match job {
            Job::Paint(order, fineness) => {
                let painted = self.paint(*order, fineness, progress)?;
                Ok(Answer::Painted(Box::new(painted)))
            }
            Job::Pick { order, at, then } => Ok(Answer::Picked(self.pick(&order, at)?, then)),
            Job::Device(device) => {
                let frames = self.source.frames();
                let other = other(device.as_ref().filter(|_| frames.is_none()), &self.rig)?;
                self.source = FrameSource::new(self.rig.clone(), &self.source.gpu().clone(), other, frames)?;
                Ok(Answer::Device(device))
            }
            #[cfg(not(target_arch = "wasm32"))]
            Job::SaveMesh(order, rig_file) => {
                progress.report("write the mesh", 0, 1);
                let rig = self.rig.clone();
                let mesh = crate::document::as_mesh(&rig, self.on_host(&order)?[0]);
                crate::save::mesh(&rig_file, &mesh).map(Answer::Saved)
            }
            #[cfg(not(target_arch = "wasm32"))]
            Job::SavePicture(order, rig_file) => {
                let picture = self.picture(*order, progress)?;
                crate::save::picture(&rig_file, &picture).map(Answer::Saved)
            }
        }
    }

    /// The picture of an order, drawn in full, with the legend of its map.
    ///
    /// # Errors
    /// As evaluating and drawing.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn picture(
        &mut self,
        order: Order,
        progress: &dyn Progress,
    ) -> Result<rhytid_render::Picture> {
        let painted = self.paint(order, Fineness::Whole, progress)?;
        let picture = self.canvas.picture()?;
        let mut picture =
            picture.ok_or_else(|| rhytid_core::Error::Internal("nothing was drawn".to_owned()))?;
        crate::save::write_legend(&mut picture, &painted.order);
        Ok(picture)
    }

    fn paint(&mut self, order: Order, fineness: Fineness, progress: &dyn Progress) -> Result<Painted> {
        progress.report("draw the face", 0, 1);
        self.canvas.resize(order.size.map(|n| n.div_ceil(fineness.parts())))?;
        *self.canvas.lights() = lights(&order.settings);
        let mut times = Times::default();
        let mut spread = None;
        let mut textures = [None, None];
        let gain = order.settings.gain;
        let compared = match order.settings.before {
            Before::Off => None,
            Before::Shell => Some((&order.handles, 1.0, true)),
            Before::LargeScale => Some((&order.handles, 0.0, false)),
            Before::Take => Some((order.undragged.as_ref().unwrap_or(&order.handles), gain, false)),
        };
        let sides = [compared.map(|side| (1, side)), Some((0, (&order.handles, gain, false)))];
        for (side, (handles, gain, of_shell)) in sides.into_iter().flatten() {
            let drawn = self.side(side, &order, Side { handles, gain, of_shell, fineness }, progress)?;
            textures[side] = Some(drawn.texture);
            times = times + drawn.times;
            // The result comes last.
            spread = drawn.spread;
        }
        progress.report("draw the face", 1, 1);
        Ok(Painted { order, fineness, times, spread, textures })
    }

    /// Draws one side, of the shell's rig or of the rig itself.
    fn side(
        &mut self,
        index: usize,
        order: &Order,
        side: Side<'_>,
        progress: &dyn Progress,
    ) -> Result<DrawnSide> {
        let Side { handles, gain, of_shell, fineness } = side;
        let settings = &order.settings;
        let rig = self.rig.clone();
        let source = match (of_shell, &mut self.shell) {
            (false, _) => &mut self.source,
            (true, Some(shell)) => shell,
            (true, none) => {
                let shell = Arc::new((*rig).clone().shell()?);
                none.insert(FrameSource::new(shell, self.source.gpu(), None, None)?)
            }
        };
        let mut times = Times::default();
        let begin = Instant::now();
        let on_host = settings.show.is_made_on_the_host();
        // The other side of the comparison has no edits either. A coarse picture has no falloff of pulls.
        let is_due =
            |edits: &&EditedFrame| index == 0 && (fineness == Fineness::Whole || edits.edits.is_some());
        let edits = order.edits.as_ref().filter(is_due);
        source.evaluate(handles.as_flattened(), Wanted { gain, on_host, frame: order.frame }, edits)?;
        times.evaluation = begin.elapsed();
        let begin = Instant::now();
        let mut marks = Vec::new();
        let mut spread = None;
        let mut set = |numbers: &[f32]| {
            spread = settings.map("").map(|map| Spread::of(numbers, map.heat.range()));
            source.set_numbers(numbers);
        };
        if on_host {
            let [positions, large_scale] = source.last_on_host();
            match settings.show {
                Show::Strain => {
                    let strains = self
                        .strains
                        .get_or_insert_with(|| Strains::new(&rig.surface().faces, &rig.surface().rest));
                    set(&strains.measure(positions));
                }
                Show::Detail => {
                    let millimetres = 1e3 * rig.surface().metres_per_unit as f32;
                    set(&distances(positions, large_scale, millimetres));
                }
                Show::Numbers => {
                    let numbers = order.numbers.get(settings.numbers);
                    let none = vec![0.0; rig.vertices()];
                    set(numbers.map_or(&none, |(_, list)| list));
                }
                Show::Influences => {
                    marks.extend(order.vertex.iter().flat_map(|&v| influence_marks(&rig, positions, v)));
                }
                _ => marks.extend(marker_marks(&rig, positions, Heat::Signed(settings.strain_range))),
            }
        }
        if settings.markers {
            marks.extend(marker_dots::marks(order, handles, &rig.handles().strain_edges));
        }
        let pixels = order.scale / fineness.parts() as f32;
        marks.iter_mut().for_each(|mark| mark.width *= pixels);
        let drawn = match (settings.look(), &order.skin) {
            (Some(look), _) => Drawn::Look(look),
            (None, Some(skin)) => Drawn::Skin(&skin.0, fineness),
            (None, None) => Drawn::Look(Look::Smooth),
        };
        let shown = Shown { camera: &order.camera, drawn, marks: &marks, background: order.background };
        let (Took { lighting, drawing }, texture) =
            self.canvas.draw(index, source.vertices()?, shown, progress)?;
        times.lighting = lighting;
        times.drawing = begin.elapsed().saturating_sub(lighting).max(drawing);
        Ok(DrawnSide { times, spread, texture })
    }

    fn pick(&mut self, order: &Order, at: [f32; 2]) -> Result<Option<(usize, [f32; 3])>> {
        let rig = self.rig.clone();
        let [positions, _] = self.on_host(order)?;
        let vertex = pick::vertex(positions, &rig.surface().triangles, &order.camera, order.size, at);
        Ok(vertex.map(|v| (v, positions.as_chunks::<3>().0[v])))
    }

    /// V × 3 positions of the frame, and those of its large scale.
    fn on_host(&mut self, order: &Order) -> Result<[&[f32]; 2]> {
        let wanted = Wanted { gain: order.settings.gain, on_host: true, frame: order.frame };
        self.source.on_host(order.handles.as_flattened(), wanted, order.edits.as_ref())
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
}

/// A side that was drawn.
struct DrawnSide {
    times: Times,
    /// The numbers of its map.
    spread: Option<Spread>,
    texture: wgpu::Texture,
}

/// One side of a picture.
struct Side<'a> {
    handles: &'a [[f32; 3]],
    /// The factor of the wrinkles.
    gain: f32,
    of_shell: bool,
    fineness: Fineness,
}

/// The chosen device, with the rig on it.
#[cfg(not(target_arch = "wasm32"))]
fn other(device: Option<&DeviceInfo>, rig: &Rig) -> Result<Option<OtherDevice>> {
    use rhytid_core::UploadOptions;
    let open = |info| rhytid_devices::backends::open(info)?.upload(rig, UploadOptions::frames(1));
    device.map(open).transpose()
}

#[cfg(target_arch = "wasm32")]
fn other(_: Option<&DeviceInfo>, _: &Rig) -> Result<Option<OtherDevice>> {
    Ok(None)
}

/// The lights, with the key light at the chosen direction.
fn lights(settings: &Settings) -> Lights {
    let [right, up] = settings.light.map(f32::to_radians);
    Lights { toward: [up.cos() * right.sin(), up.sin(), up.cos() * right.cos()], ..Lights::default() }
}
