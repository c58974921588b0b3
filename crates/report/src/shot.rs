//! The pictures that a page asks for, and what it says where nothing draws them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// A picture to draw of a rig's face.
#[cfg_attr(not(feature = "render"), expect(dead_code, reason = "nothing reads what nothing draws"))]
pub(crate) struct Shot<'a> {
    /// Degrees by which the camera goes around the face, towards its left (the mesh's +x), from right before it.
    pub turn: f32,
    /// V places.
    pub positions: &'a [[f32; 3]],
    /// What to colour it by; lit where there is nothing.
    pub heat: Option<Numbers<'a>>,
    /// What is to be found in the picture, in the mesh's space.
    pub points: Vec<[f64; 3]>,
}

/// Numbers that a face is coloured by.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "render"), expect(dead_code, reason = "nothing reads what nothing draws"))]
pub(crate) struct Numbers<'a> {
    /// Of the V vertices.
    pub values: &'a [f32],
    /// The one above 0 that has the last colour.
    pub end: f32,
}

/// A picture, transparent where there is no face.
pub(crate) struct Drawn {
    pub png: Vec<u8>,
    /// Where the shot's points are.
    pub places: Vec<Place>,
}

impl Drawn {
    /// For an `href`.
    pub(crate) fn data(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(&self.png))
    }
}

/// Where a point is in a picture.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    /// In pixels: right and down from the upper left corner.
    pub at: [f32; 2],
    /// Whether the face hides it.
    pub is_behind: bool,
}

impl Place {
    /// Its two coordinates with one decimal.
    pub(crate) fn words(&self) -> [String; 2] {
        self.at.map(|x| format!("{x:.1}"))
    }
}

/// What a page says in place of its pictures.
pub(crate) fn left_out() -> Markup {
    html! {
        p.left-out {
            "The pictures are left out, since "
            @if cfg!(feature = "render") {
                "nothing here draws: install a driver for Vulkan, Metal, Direct3D 12 or OpenGL ES 3.1, which a software driver such as Mesa’s "
                "llvmpipe is, too, and write the page again."
            } @else {
                "this program was built without wgpu: build it with the feature " code { "wgpu" } ", and write the page again."
            }
        }
    }
}
