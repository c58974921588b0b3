//! The painter of the pictures: a wgpu device.

use crate::behind::behind;
use crate::shot::{Drawn, Numbers, Place, Shot};
use rhytid_core::{Faces, Result, Rig, UpAxis};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_render::{
    Camera, FrameBuffers, Heat, Look, Mark, Offscreen, Overlay, Picture, Renderer, Sphere, View,
    around_handles,
};

/// The lift of marks towards the viewer, as a part of the handles' radius.
///
/// A marker sits on the skin, or a little before or behind it. The lift keeps the skin from hiding it.
pub(crate) const LIFT: f32 = 0.05;

/// The painter of the pages' pictures: a device, which may be your own. The same pages have the same bytes on
/// the same device.
#[derive(Debug)]
pub struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Painter {
    /// A painter that draws with `device` and its `queue`.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self { device: device.clone(), queue: queue.clone() }
    }

    /// Draws pictures of `size` pixels of a rig's face, of which `triangles` are shown. The handles at rest
    /// determine the frame.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]. [`rhytid_core::Error::Input`] if the face or the pictures are too
    /// large for the device.
    pub(crate) fn draw(
        &self,
        rig: &Rig,
        triangles: &[[u32; 3]],
        size: [u32; 2],
        shots: &[Shot<'_>],
    ) -> Result<Vec<Drawn>> {
        let mut canvas = Canvas::new(self, &rig.surface().faces, triangles, rig.vertices(), size)?;
        let handles = &rig.handles().rest;
        let lift = LIFT * Sphere::around(handles).radius;
        let drawn = |shot: &Shot<'_>| {
            let camera = camera(handles, &rig.surface().rest, rig.surface().up_axis, shot.turn, size);
            let picture = canvas.draw(&camera, shot.positions, shot.heat, lift, &[])?;
            let points: Vec<[f32; 3]> = shot.points.iter().map(|p| p.map(|x| x as f32)).collect();
            let is_behind = behind(&camera, size, shot.positions, triangles, lift, &points);
            let places = points.iter().zip(is_behind).map(|(point, is_behind)| {
                let [x, y, _] = camera.project(size, *point);
                Place { at: [x, y], is_behind }
            });
            Ok(Drawn { png: picture.png()?, places: places.collect() })
        };
        shots.iter().map(drawn).collect()
    }

    /// The colour at a part of a heat map's scale, 0 to 1, in 8 bits of sRGB. The scale begins with white,
    /// which shows form where numbers are small.
    #[expect(clippy::unused_self, reason = "where nothing draws there is no scale")]
    pub(crate) fn colour(&self, part: f32) -> [u8; 3] {
        Heat::Signed(1.0).code(part)
    }

    /// The colour of what has no number, in 8 bits of sRGB.
    #[expect(clippy::unused_self, reason = "where nothing draws there is no scale")]
    pub(crate) fn grey(&self) -> [u8; 3] {
        Heat::grey()
    }
}

/// The camera that looks at the part of a face with `handles`. The face is at `rest`, and the camera is
/// turned by `turn` degrees towards its left.
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

/// A mesh that is drawn in pictures of one size.
pub(crate) struct Canvas<'a> {
    triangles: &'a [[u32; 3]],
    at_vertices: VertexTriangles,
    renderer: Renderer,
    overlay: Overlay,
    page: Offscreen,
    frame: FrameBuffers,
}

impl<'a> Canvas<'a> {
    /// A canvas for V `vertices`.
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

    /// Draws the mesh as `camera` sees it, on a transparent background.
    ///
    /// The mesh is lit, or has the colours of its numbers. Marks on it are lifted towards the viewer by
    /// `lift` mesh units.
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
            None => (&[][..], Look::Smooth),
            Some(Numbers { values, end }) => (values, Look::LitHeat(Heat::Signed(end))),
        };
        self.frame.set(positions.as_flattened(), normals.as_flattened(), numbers);
        self.renderer.show(camera, self.page.aspect(), look);
        self.overlay.show(camera, self.page.size(), lift, marks)?;
        self.page.draw([0; 4], |pass| {
            self.renderer.draw(pass, self.frame.vertices())?;
            self.overlay.draw(pass);
            Ok(())
        })
    }
}
