//! The settings: what is shown, and how markers are dragged.

use rhytid_core::scale;
use rhytid_render::{Heat, Look};

/// How the face is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Show {
    /// Lit at every pixel.
    #[default]
    Shaded,
    /// Skin: light spreads in it, wrinkles cast shadows, and the surface shines.
    Skin,
    /// Clay: each normal has the colour of a ball of clay at that normal.
    Clay,
    /// The edges of the mesh's polygons.
    Wireframe,
    /// Lit for each triangle.
    Flat,
    /// Shaded, with the strain edges in the colours of their strains.
    Edges,
    /// Shaded, with the influences of the vertex that was picked.
    Influences,
    /// How much longer or shorter the skin is than at rest.
    Strain,
    /// How far the wrinkles move each vertex.
    Detail,
    /// Numbers of a file.
    Numbers,
}

impl Show {
    /// All except the numbers of a file, in the order of the keys F1 to F9.
    pub const ALL: [Self; 9] = [
        Self::Shaded,
        Self::Skin,
        Self::Clay,
        Self::Wireframe,
        Self::Flat,
        Self::Edges,
        Self::Influences,
        Self::Strain,
        Self::Detail,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Skin => "skin",
            Self::Clay => "clay",
            Self::Wireframe => "wireframe",
            Self::Flat => "flat",
            Self::Edges => "strain edges",
            Self::Influences => "influences",
            Self::Strain => "strain",
            Self::Detail => "detail",
            Self::Numbers => "numbers",
        }
    }

    /// Whether it shows something of a rig. A mesh alone does not have it.
    pub(crate) fn needs_rig(self) -> bool {
        matches!(self, Self::Edges | Self::Influences | Self::Detail)
    }

    /// Whether it needs a frame on the host.
    pub(crate) fn is_made_on_the_host(self) -> bool {
        !matches!(self, Self::Shaded | Self::Skin | Self::Clay | Self::Wireframe | Self::Flat)
    }
}

/// What the result is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Before {
    /// Nothing.
    #[default]
    Off,
    /// The shell alone, without the fine detail.
    Shell,
    /// The result without the wrinkles.
    LargeScale,
    /// The take, without drags.
    Take,
}

impl Before {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Off, Self::Shell, Self::LargeScale, Self::Take];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "nothing",
            Self::Shell => "the shell",
            Self::LargeScale => "the large scale",
            Self::Take => "the take",
        }
    }
}

/// Numbers on the face, shown as colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Map<'a> {
    pub heat: Heat,
    pub title: &'a str,
    /// The unit in which people read the numbers, which are multiplied by `factor` for that.
    pub unit: &'static str,
    pub factor: f32,
}

/// The user's choices.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How the face is drawn.
    pub show: Show,
    /// What the result is compared with.
    pub before: Before,
    /// The place between the two sides, as a part of the picture's width.
    pub wipe: f32,
    /// The factor of the wrinkles, 0 to 2.
    pub gain: f32,
    /// Whether markers have dots.
    pub markers: bool,
    /// Whether the markers that are seen have their names beside them.
    pub names: bool,
    /// Whether maps are lit. Light shows the form, and changes the colours.
    pub lit_maps: bool,
    /// The reach of the soft selection along strain edges, in millimetres.
    pub reach: f32,
    /// Whether the other side of the face moves too, mirrored.
    pub mirrored: bool,
    /// The strain that has the last colour.
    pub strain_range: f32,
    /// The detail that has the last colour, in millimetres.
    pub detail_range: f32,
    /// The set of numbers that is shown.
    pub numbers: usize,
    /// The number that has the last colour. `true` means that numbers below 0 have colours of their own.
    pub numbers_range: (f32, bool),
    /// The direction of the key light: degrees to the viewer's right and up.
    pub light: [f32; 2],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            show: Show::default(),
            before: Before::default(),
            wipe: 0.5,
            gain: 1.0,
            markers: true,
            names: false,
            lit_maps: true,
            reach: 25.0,
            mirrored: false,
            strain_range: 0.3,
            detail_range: 1.0,
            numbers: 0,
            numbers_range: (1.0, false),
            light: [-41.0, 33.0],
        }
    }
}

impl Settings {
    /// The map that is shown. `numbers` is the name of the numbers of a file.
    pub(crate) fn map<'a>(&self, numbers: &'a str) -> Option<Map<'a>> {
        let strain = Heat::Signed(self.strain_range);
        Some(match self.show {
            Show::Strain => Map { heat: strain, title: "strain of the skin", unit: "%", factor: 100.0 },
            Show::Edges => Map { heat: strain, title: "strain of the edges", unit: "%", factor: 100.0 },
            Show::Detail => {
                let heat = Heat::From0(self.detail_range);
                Map { heat, title: "detail of the wrinkles", unit: "mm", factor: 1.0 }
            }
            Show::Numbers => Map { heat: self.numbers_heat(), title: numbers, unit: "", factor: 1.0 },
            _ => return None,
        })
    }

    /// The number that has the last colour of the map that is shown.
    pub(crate) fn map_end(&mut self) -> Option<&mut f32> {
        match self.show {
            Show::Strain | Show::Edges => Some(&mut self.strain_range),
            Show::Detail => Some(&mut self.detail_range),
            Show::Numbers => Some(&mut self.numbers_range.0),
            _ => None,
        }
    }

    fn numbers_heat(&self) -> Heat {
        match self.numbers_range {
            (most, true) => Heat::Signed(most),
            (most, false) => Heat::From0(most),
        }
    }

    /// Shows these numbers. The range begins at 0 or is symmetric about 0. It ends at a round number, and
    /// contains all numbers except the largest.
    pub(crate) fn show_numbers(&mut self, which: usize, numbers: &[f32]) {
        let sizes: Vec<f32> = numbers.iter().map(|x| x.abs()).collect();
        (self.show, self.numbers) = (Show::Numbers, which);
        self.numbers_range =
            (scale::end(std::iter::once(sizes.as_slice())), numbers.iter().any(|x| *x < 0.0));
    }

    fn coloured(&self, heat: Heat) -> Look {
        if self.lit_maps { Look::LitHeat(heat) } else { Look::Heat(heat) }
    }

    /// `None` for skin.
    pub(crate) fn look(&self) -> Option<Look> {
        match self.show {
            Show::Shaded | Show::Edges | Show::Influences => Some(Look::Smooth),
            Show::Clay => Some(Look::Matcap),
            Show::Wireframe => Some(Look::Wireframe),
            Show::Flat => Some(Look::Flat),
            Show::Strain => Some(self.coloured(Heat::Signed(self.strain_range))),
            Show::Detail => Some(self.coloured(Heat::From0(self.detail_range))),
            Show::Numbers => Some(self.coloured(self.numbers_heat())),
            Show::Skin => None,
        }
    }
}
