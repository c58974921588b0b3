//! What is shown, and how markers are dragged.

use rhytid_render::{Heat, Look};

/// What the face is drawn as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Show {
    /// Lit at every pixel.
    #[default]
    Shaded,
    /// Light that spreads in skin, shadows, a surface that shines.
    Skin,
    /// As a ball of clay looks where its surface has the same direction.
    Clay,
    /// The edges of the mesh's polygons.
    Wireframe,
    /// Lit by triangles.
    Flat,
    /// Shaded, with the strain edges in the colours of their strains.
    Edges,
    /// Shaded, with what drives the vertex that was picked.
    Influences,
    /// How much longer or shorter the skin is than at rest.
    Strain,
    /// How far the folds move each vertex.
    Detail,
    /// Numbers of a file.
    Numbers,
}

impl Show {
    /// All but the numbers of a file, in the order of the keys F1 to F9.
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

    /// What it is called.
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

    /// Whether it is made of a frame on the host.
    pub(crate) fn is_made_on_the_host(self) -> bool {
        !matches!(self, Self::Shaded | Self::Skin | Self::Clay | Self::Wireframe | Self::Flat)
    }
}

/// What the result is put beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Before {
    /// Nothing.
    #[default]
    Off,
    /// The shell alone, without what was learned.
    Shell,
    /// Without the folds.
    LargeScale,
    /// As the take has it, without what was pulled.
    Take,
}

impl Before {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Off, Self::Shell, Self::LargeScale, Self::Take];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "nothing",
            Self::Shell => "the shell",
            Self::LargeScale => "the large scale",
            Self::Take => "the take",
        }
    }
}

/// What a person chose.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// What the face is drawn as.
    pub show: Show,
    /// What it is put beside.
    pub before: Before,
    /// Where before ends and the result begins: a part of the picture's width.
    pub wipe: f32,
    /// The folds times this, 0 to 2.
    pub gain: f32,
    /// Whether there are dots at the markers.
    pub markers: bool,
    /// How far along strain edges neighbours follow what is dragged, in millimetres.
    pub reach: f32,
    /// Whether the other side does the same in the mirror.
    pub mirrored: bool,
    /// The strain that has the last colour.
    pub strain_range: f32,
    /// The detail that has the last colour, in millimetres.
    pub detail_range: f32,
    /// Which numbers of a file are shown.
    pub numbers: usize,
    /// The number that has the last colour; below 0 are others where it is `true`.
    pub numbers_range: (f32, bool),
    /// From where the key light comes: degrees to the viewer's right and up.
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
    /// The colours of the numbers that are shown, and what they are called.
    pub fn heat(&self) -> Option<(Heat, &'static str)> {
        match self.show {
            Show::Strain | Show::Edges => Some((Heat::Signed(self.strain_range), "strain")),
            Show::Detail => Some((Heat::From0(self.detail_range), "detail, mm")),
            Show::Numbers => Some((self.numbers_heat(), "numbers")),
            _ => None,
        }
    }

    fn numbers_heat(&self) -> Heat {
        match self.numbers_range {
            (most, true) => Heat::Signed(most),
            (most, false) => Heat::From0(most),
        }
    }

    /// Shows these numbers, from 0 or around it, up to where all but the largest are.
    pub(crate) fn show_numbers(&mut self, which: usize, numbers: &[f32]) {
        let mut sizes: Vec<f32> = numbers.iter().map(|x| x.abs()).filter(|x| x.is_finite()).collect();
        sizes.sort_by(f32::total_cmp);
        let most = sizes.get(sizes.len() * 98 / 100).copied().filter(|most| *most > 0.0).unwrap_or(1.0);
        (self.show, self.numbers) = (Show::Numbers, which);
        self.numbers_range = (most, numbers.iter().any(|x| *x < 0.0));
    }

    /// `None` for skin.
    pub(crate) fn look(&self) -> Option<Look> {
        match self.show {
            Show::Shaded | Show::Edges | Show::Influences => Some(Look::Smooth),
            Show::Clay => Some(Look::Matcap),
            Show::Wireframe => Some(Look::Wireframe),
            Show::Flat => Some(Look::Flat),
            Show::Strain => Some(Look::Heat(Heat::Signed(self.strain_range))),
            Show::Detail => Some(Look::Heat(Heat::From0(self.detail_range))),
            Show::Numbers => Some(Look::LitHeat(self.numbers_heat())),
            Show::Skin => None,
        }
    }
}
