//! What draws the pictures: a device of wgpu's.

use crate::behind::behind;
use crate::shot::{Drawn, Numbers, Place, Shot};
use rhytid_core::{Faces, Result, Rig, UpAxis};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_render::{
    Camera, FrameBuffers, Heat, Look, Mark, Offscreen, Overlay, Picture, Renderer, Sphere, View,
    around_handles,
};

/// Marks are nearer to the viewer than they are by this part of the handles' radius: a marker sits on the skin or a little before or behind
/// it, which does not hide it.
pub(crate) const LIFT: f32 = 0.05;

/// What draws the pictures of pages: a device, which may be your own. The same pages have the same bytes on the same device.
#[derive(Debug)]
pub struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Painter {
    /// Draws with `device`, and `queue`, which is its.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self { device: device.clone(), queue: queue.clone() }
    }

    /// Draws pictures of `size` pixels of a rig's face, at rest framed about its handles.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]; [`rhytid_core::Error::Input`] if the face or the pictures are too large for it.
    pub(crate) fn draw(&self, rig: &Rig, size: [u32; 2], shots: &[Shot<'_>]) -> Result<Vec<Drawn>> {
        let surface = rig.surface();
        let mut canvas = Canvas::new(self, &surface.faces, &surface.triangles, rig.vertices(), size)?;
        let handles = &rig.handles().rest;
        let lift = LIFT * Sphere::around(handles).radius;
        let drawn = |shot: &Shot<'_>| {
            let camera = camera(handles, &rig.surface().rest, rig.surface().up_axis, shot.turn, size);
            let picture = canvas.draw(&camera, shot.positions, shot.heat, lift, &[])?;
            let points: Vec<[f32; 3]> = shot.points.iter().map(|p| p.map(|x| x as f32)).collect();
            let is_behind = behind(&camera, size, shot.positions, &rig.surface().triangles, lift, &points);
            let places = points.iter().zip(is_behind).map(|(point, is_behind)| {
                let [x, y, _] = camera.project(size, *point);
                Place { at: [x, y], is_behind }
            });
            Ok(Drawn { png: picture.png()?, places: places.collect() })
        };
        shots.iter().map(drawn).collect()
    }

    /// The colour at a part of a heat map's scale, 0 to 1, in 8 bits of sRGB: from white, which shows form where numbers are small.
    #[expect(clippy::unused_self, reason = "where nothing draws there is no scale")]
    pub(crate) fn colour(&self, part: f32) -> [u8; 3] {
        Heat::Signed(1.0).code(part)
    }
}

/// Looks at the part of a face, at `rest`, that has `handles`, turned by `turn` degrees towards its left.
pub(crate) fn camera(
    handles: &[[f32; 3]],
    rest: &[[f32; 3]],
    up: UpAxis,
    turn: f32,
    [width, height]: [u32; 2],
) -> Camera {
    let view = View { turn, ..View::default() };
    Camera::framing(&around_handles(handles, rest), up, view, width as f32 / height as f32)
}

/// A mesh, to be drawn in pictures of one size.
pub(crate) struct Canvas<'a> {
    triangles: &'a [[u32; 3]],
    at_vertices: VertexTriangles,
    renderer: Renderer,
    overlay: Overlay,
    page: Offscreen,
    frame: FrameBuffers,
}

impl<'a> Canvas<'a> {
    /// For V `vertices`.
    ///
    /// # Errors
    /// As [`Painter::draw`].
    pub(crate) fn new(
        Painter { device, queue }: &Painter,
        faces: &Faces,
        triangles: &'a [[u32; 3]],
        vertices: usize,
        size: [u32; 2],
    ) -> Result<Self> {
        Ok(Self {
            triangles,
            at_vertices: VertexTriangles::new(vertices, triangles),
            renderer: Renderer::new(device, queue, faces, triangles, Offscreen::TARGET)?,
            overlay: Overlay::new(device, queue, Offscreen::TARGET)?,
            page: Offscreen::new(device, queue, size)?,
            frame: FrameBuffers::new(device, queue, vertices)?,
        })
    }

    /// Draws it as `camera` sees it, over nothing: lit, or in the colours of its numbers; and marks on it,
    /// which are nearer than they are by `lift` mesh units.
    ///
    /// # Errors
    /// As [`Painter::draw`].
    pub(crate) fn draw(
        &mut self,
        camera: &Camera,
        positions: &[[f32; 3]],
        heat: Option<Numbers<'_>>,
        lift: f32,
        marks: &[Mark],
    ) -> Result<Picture> {
        let normal = |v| vertex_normal(positions, self.triangles, self.at_vertices.at(v));
        let normals: Vec<[f32; 3]> = (0..positions.len()).map(normal).collect();
        let (numbers, look) = match heat {
            None => (Vec::new(), Look::Smooth),
            // What is no number is the worst.
            Some(Numbers { values, end }) => {
                let number = |x: &f32| if x.is_nan() { end } else { *x };
                (values.iter().map(number).collect(), Look::LitHeat(Heat::Signed(end)))
            }
        };
        self.frame.set(positions.as_flattened(), normals.as_flattened(), &numbers);
        self.renderer.show(camera, self.page.aspect(), look);
        self.overlay.show(camera, self.page.size(), lift, marks)?;
        self.page.draw([0; 4], |pass| {
            self.renderer.draw(pass, self.frame.vertices())?;
            self.overlay.draw(pass);
            Ok(())
        })
    }
}
