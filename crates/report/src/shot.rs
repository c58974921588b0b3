//! The pictures that a page asks for, and its text where nothing draws them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// A picture to draw of a rig's face.
#[cfg_attr(not(feature = "render"), expect(dead_code, reason = "nothing reads what nothing draws"))]
pub(crate) struct Shot<'a> {
    /// The angle of the camera around the face, in degrees: from the front towards the face's left (the
    /// mesh's +x).
    pub turn: f32,
    /// V positions.
    pub positions: &'a [[f32; 3]],
    /// The numbers for its colours; lit if there are none.
    pub heat: Option<Numbers<'a>>,
    /// Points whose places in the picture are wanted, in the mesh's space.
    pub points: Vec<[f64; 3]>,
}

/// Numbers for the colours of a face.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "render"), expect(dead_code, reason = "nothing reads what nothing draws"))]
pub(crate) struct Numbers<'a> {
    /// The numbers of the V vertices; NaN is grey.
    pub values: &'a [f32],
    /// The number above 0 with the last colour.
    pub end: f32,
}

/// A picture, transparent where there is no face.
pub(crate) struct Drawn {
    pub png: Vec<u8>,
    /// The places of the shot's points.
    pub places: Vec<Place>,
}

impl Drawn {
    /// The picture for an `href`.
    pub(crate) fn data(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(&self.png))
    }
}

/// The place of a point in a picture.
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

/// The text of a page in place of its pictures.
pub(crate) fn left_out() -> Markup {
    html! {
        p.left-out {
            "The pictures are left out, since "
            @if cfg!(feature = "render") {
                "no device here can draw. To get the pictures, install a driver for Vulkan, Metal, Direct3D 12 or OpenGL ES 3.1, and write the page "
                "again. A software driver such as Mesa’s llvmpipe is enough."
            } @else {
                "this program was built without wgpu. Build it with the feature " code { "wgpu" } ", and write the page again."
            }
        }
    }
}
