//! Looks, and the colours of skin and wires in them.

use crate::heat::Heat;

/// What a face is drawn as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Look {
    /// Lit at every pixel.
    Smooth,
    /// Lit at every vertex, as the chapter's program does it.
    Gouraud,
    /// Lit by triangles.
    Flat,
    /// The edges of the mesh's polygons, those in front.
    Wireframe,
    /// A colour for the number at each vertex, without light: what the legend says.
    Heat(Heat),
    /// The same lit at every pixel, which shows form where a colour is light: a picture for people rather than for measuring.
    LitHeat(Heat),
    /// As a ball looks where its surface has the same direction: [`crate::Picture::clay`], or what [`crate::Renderer::set_matcap`] was given.
    Matcap,
    /// Lit at every pixel, in the colours of the images that [`crate::Renderer::set_textures`] was given.
    Textured,
}

/// Linear red, green and blue of a light skin.
pub(crate) const SKIN: [f32; 3] = [0.85, 0.56, 0.44];
/// The same of wires.
pub(crate) const WIRE: [f32; 3] = [0.75, 0.80, 0.85];
