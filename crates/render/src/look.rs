//! Looks, and the colours of skin and wires in them.

use crate::heat::Heat;
use rhytid_core::Tissue;

/// How a face is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Look {
    /// Lit at every pixel.
    Smooth,
    /// Lit at every vertex, as in the chapter's program.
    Gouraud,
    /// Lit for each triangle.
    Flat,
    /// The edges of the mesh's polygons that are in front.
    Wireframe,
    /// A colour for the number at each vertex, without light: exactly the legend's colours.
    Heat(Heat),
    /// The same colours lit at every pixel. Light shows the form, but changes the colours: this is for
    /// viewing, not for measuring.
    LitHeat(Heat),
    /// With the shading of a ball: each normal has the ball's colour at that normal. The ball is
    /// [`crate::Picture::clay`], or the one given to [`crate::Renderer::set_matcap`].
    Matcap,
    /// Lit at every pixel, in the colours of the images given to [`crate::Renderer::set_textures`].
    Textured,
}

/// Linear red, green and blue of light skin.
pub(crate) const SKIN: [f32; 3] = Tissue::Skin.look().base_color;
/// Linear red, green and blue of wires.
pub(crate) const WIRE: [f32; 3] = [0.75, 0.80, 0.85];
