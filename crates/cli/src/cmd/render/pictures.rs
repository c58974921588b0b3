//! A frame as a picture, once for each thing to show.

use super::marks;
use crate::args::{self, Show};
use crate::guard::guard;
use rhytid::backends::wgpu::Wgpu;
use rhytid::playback::find_device;
use rhytid::render::{
    Camera, FrameBuffers, Heat, Look, Mark, Offscreen, Overlay, Picture, Renderer, Sheet, Sphere, Strains,
    View, distances,
};
use rhytid::{Backend, DeviceErrorKind, Error, Result, Rig};

/// What draws.
pub(super) struct Pictures<'a> {
    rig: &'a Rig,
    /// For people.
    pub device: String,
    shown: Vec<(Show, Option<Heat>)>,
    renderer: Renderer,
    overlay: Overlay,
    /// By how much marks are nearer than they are, in mesh units: the chord between two markers runs below the skin.
    lift: f32,
    /// Whose influences are shown.
    vertex: Option<usize>,
    page: Offscreen,
    frame: FrameBuffers,
    view: View,
    background: [u8; 4],
    /// What the picture is of; `None` for a camera that goes around.
    framed: Option<Vec<[f32; 3]>>,
    strains: Option<Strains>,
    millimetres: f32,
}

/// What there is of a frame: V × 3 each but for one, the large scale only where it was asked for.
pub(super) struct Evaluated<'a> {
    pub positions: &'a [f32],
    pub normals: &'a [f32],
    pub large_scale: &'a [f32],
    /// V, where it was asked for.
    pub sigma: &'a [f32],
}

impl<'a> Pictures<'a> {
    /// Pictures of `size` pixels for each thing to show.
    pub(super) fn new(args: &args::Render, rig: &'a Rig, size: [u32; 2]) -> Result<Self> {
        let info = find_device(&args.draw_on, guard()).map_err(|error| match error {
            Error::Device { kind: DeviceErrorKind::NotFound, device, .. } => Error::Device {
                kind: DeviceErrorKind::NotFound,
                device,
                message: "there is none to draw with; `rhytid devices` lists those of the backend wgpu, which a driver for \
                          Vulkan, Metal, Direct3D 12 or OpenGL ES 3.1 brings"
                    .to_owned(),
            },
            other => other,
        })?;
        if info.backend != Wgpu::NAME {
            return Err(Error::input(format!(
                "--draw-on {}: expected a device of the backend wgpu, as `rhytid devices` lists them",
                args.draw_on
            )));
        }
        let wgpu = Wgpu::open(&info)?;
        let (device, queue) = (wgpu.device(), wgpu.queue());
        let heat = |show| match show {
            Show::Strain | Show::Markers => Some(Heat::Signed(args.strain_range)),
            Show::Detail => Some(Heat::From0(args.detail_range)),
            Show::Sigma => Some(Heat::From0(args.sigma_range)),
            _ => None,
        };
        Ok(Self {
            rig,
            device: format!("{} ({})", info.id(), info.name),
            shown: args.show.iter().map(|&show| (show, heat(show))).collect(),
            renderer: Renderer::new(device, queue, &rig.faces, &rig.triangles, Offscreen::TARGET)?,
            overlay: Overlay::new(device, queue, Offscreen::TARGET)?,
            lift: 0.1 * Sphere::around(&marks::at_rest(rig)).radius,
            vertex: args.vertex,
            page: Offscreen::new(device, queue, size)?,
            frame: FrameBuffers::new(device, queue, rig.vertices())?,
            view: View { turn: args.turn, raise: args.raise, lens: args.lens },
            background: args.background.map_or(Sheet::PAPER, |background| background.0),
            framed: match (args.turntable, args.whole) {
                (true, _) => None,
                (false, true) => Some(rig.rest.clone()),
                (false, false) => Some(about_the_handles(rig)),
            },
            strains: args.show.contains(&Show::Strain).then(|| Strains::new(&rig.faces, &rig.rest)),
            millimetres: 1e3 * rig.metres_per_unit as f32,
        })
    }

    /// Of what is shown, beside each other.
    pub(super) fn size(&self) -> [u32; 2] {
        let [width, height] = self.page.size();
        [width.saturating_mul(self.shown.len() as u32), height]
    }

    pub(super) fn legends(&self) -> Vec<(Heat, &'static str)> {
        let title = |show: Show| match show {
            Show::Strain | Show::Markers => "strain",
            Show::Sigma => "sigma, mm",
            _ => "detail, mm",
        };
        let mut legends: Vec<_> =
            self.shown.iter().filter_map(|(show, heat)| Some(((*heat)?, title(*show)))).collect();
        legends.dedup();
        legends
    }

    /// Draws a frame, the camera turned by so many degrees more.
    pub(super) fn draw(&mut self, frame: &Evaluated<'_>, turned: f32) -> Result<Picture> {
        let [width, _] = self.page.size();
        let view = View { turn: self.view.turn + turned, ..self.view };
        let aspect = self.page.aspect();
        let camera = match &self.framed {
            Some(points) => Camera::framing(points, self.rig.up_axis, view, aspect),
            None => Camera::around(Sphere::around(&self.rig.rest), self.rig.up_axis, view, aspect),
        };
        let mut picture = Picture::filled(self.size(), [0; 4]);
        for (i, (show, heat)) in (0..).zip(&self.shown) {
            let numbers = match show {
                Show::Strain => {
                    self.strains.as_ref().map(|strains| strains.of(frame.positions)).unwrap_or_default()
                }
                Show::Detail => distances(frame.positions, frame.large_scale, self.millimetres),
                Show::Sigma => frame.sigma.iter().map(|sigma| sigma * self.millimetres).collect(),
                _ => Vec::new(),
            };
            self.frame.set(frame.positions, frame.normals, &numbers);
            let look = show.look().or(heat.map(Look::Heat)).unwrap_or(Look::Smooth);
            self.renderer.show(&camera, aspect, look);
            let marks = self.marks(*show, *heat, frame);
            if let Some(marks) = &marks {
                self.overlay.show(&camera, self.page.size(), self.lift, marks)?;
            }
            let part = self.page.draw(self.background, |pass| {
                self.renderer.draw(pass, self.frame.vertices())?;
                if marks.is_some() {
                    self.overlay.draw(pass);
                }
                Ok(())
            })?;
            picture.put(&part, [i * width, 0]);
        }
        Ok(picture)
    }

    /// What is over the face.
    fn marks(&self, show: Show, heat: Option<Heat>, frame: &Evaluated<'_>) -> Option<Vec<Mark>> {
        match show {
            Show::Markers => Some(marks::markers(self.rig, frame.positions, heat?)),
            Show::Influences => Some(marks::influences(self.rig, frame.positions, self.vertex?)),
            Show::Frames => Some(marks::frames(self.rig, frame.positions, frame.normals, 0.3 * self.lift)),
            _ => None,
        }
    }
}

/// Where handles are at rest, and as far again beyond them as a face goes on, where there is any mesh.
fn about_the_handles(rig: &Rig) -> Vec<[f32; 3]> {
    const BEYOND: f32 = 1.4;
    let points = marks::at_rest(rig);
    let center = Sphere::around(&points).center;
    let [low, high] = [f32::min, f32::max].map(|pick| {
        let all = rig.rest.iter().copied();
        all.reduce(|a, b| std::array::from_fn(|c| pick(a[c], b[c]))).unwrap_or_default()
    });
    let beyond = |p: &[f32; 3], c: usize| center[c] + BEYOND * (p[c] - center[c]);
    points.iter().map(|p| std::array::from_fn(|c| beyond(p, c).clamp(low[c], high[c]))).collect()
}
