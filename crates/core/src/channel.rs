//! Channels: the numbers that a frame has at each vertex, as data.
//!
//! [`ChannelKind`] is what a user asks for. [`ChannelKind::channels`] are the arrays that a kind consists of.
//! Readers, writers, comparisons and options use these values. So a new channel is described here, computed
//! in one place, and known everywhere.

use crate::listed::listed;
use std::borrow::Cow;
use std::fmt;

/// What the numbers of a channel are, and in which unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A place, in mesh units.
    Position,
    /// A vector in mesh units per second.
    Velocity,
    /// A vector of length 1; 0 where there is none.
    Direction,
    /// A length in mesh units.
    Length,
    /// A number without a unit.
    Ratio,
}

/// How far a number of a file may be from a fresh evaluation.
///
/// Two devices round differently: their positions differ by at most δ, which the caller knows. Let h be the
/// height of the thinnest triangle at a vertex. Then a difference of δ tilts and stretches triangles there by
/// about δ/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// δ, as a distance.
    Position,
    /// 2 δ times the frames per second: a velocity is the difference of two positions.
    Velocity,
    /// `within + 4 δ/h`, for a number that depends on the shapes of a vertex's triangles.
    Shape {
        /// What is allowed where no triangle is thin.
        within: f64,
    },
    /// [`Tolerance::Shape`] divided by the difference of the two principal strains, up to the sign. Where
    /// both strains are equal, any direction is right.
    PrincipalAxis {
        /// What is allowed where no triangle is thin, times the difference of the strains.
        within: f64,
    },
    /// `of_largest` times the largest number of the frame. Such numbers are computed from the markers alone,
    /// by the same program on every device.
    FromMarkers {
        /// A ratio.
        of_largest: f64,
    },
}

/// When a channel has numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timing {
    /// In each frame.
    PerFrame,
    /// Once for all frames.
    Constant,
}

/// What a channel's numbers belong to, as USD calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// One value for each vertex, varying linearly between them.
    Vertex,
    /// One value for each face.
    Uniform,
}

impl Interpolation {
    /// USD's word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Uniform => "uniform",
        }
    }
}

/// One array of a frame: a name, and what its numbers are.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The name, a letter and then letters, digits and `_`: what a USD primvar is called.
    pub name: Cow<'static, str>,
    /// What sentences call the channel, in the plural.
    pub words: Cow<'static, str>,
    /// The kind that it belongs to. `None` for positions, and for channels that another program has put into
    /// a file.
    pub kind: Option<ChannelKind>,
    /// Numbers at each vertex, at least 1.
    pub width: usize,
    /// What they are, and their unit.
    pub quantity: Quantity,
    /// How far the numbers may be from a fresh evaluation.
    pub tolerance: Tolerance,
    /// When the channel has numbers.
    pub timing: Timing,
    /// What the numbers belong to.
    pub interpolation: Interpolation,
}

const fn per_frame(
    name: &'static str,
    words: &'static str,
    kind: Option<ChannelKind>,
    width: usize,
    quantity: Quantity,
    tolerance: Tolerance,
) -> Channel {
    let (name, words) = (Cow::Borrowed(name), Cow::Borrowed(words));
    let (timing, interpolation) = (Timing::PerFrame, Interpolation::Vertex);
    Channel { name, words, kind, width, quantity, tolerance, timing, interpolation }
}

/// Where each vertex is: every frame has it.
pub static POSITIONS: Channel =
    per_frame("positions", "positions", None, 3, Quantity::Position, Tolerance::Position);

/// Area-weighted vertex normals, of length 1, or 0 at a vertex without area.
pub static NORMALS: Channel = per_frame(
    "normals",
    "normals",
    Some(ChannelKind::Normals),
    3,
    Quantity::Direction,
    Tolerance::Shape { within: 1e-3 },
);

/// The velocity of each vertex: the central difference of the frames before and after.
pub static VELOCITIES: Channel = per_frame(
    "velocities",
    "velocities",
    Some(ChannelKind::Velocities),
    3,
    Quantity::Velocity,
    Tolerance::Velocity,
);

/// The standard deviation σ of each vertex: how far the vertex may be from its position in a scan of the
/// frame.
pub static SIGMA: Channel = per_frame(
    "sigma",
    "standard deviations",
    Some(ChannelKind::Sigma),
    1,
    Quantity::Length,
    Tolerance::FromMarkers { of_largest: 1e-3 },
);

/// The two principal strains of each vertex, the larger first (`rhytid_geometry::StrainGauge`).
pub static STRAIN: Channel = per_frame(
    "strain",
    "strains",
    Some(ChannelKind::Strain),
    2,
    Quantity::Ratio,
    Tolerance::Shape { within: 1e-3 },
);

/// The line along which the larger principal strain stretches the skin.
pub static STRAIN_DIRECTION_1: Channel = per_frame(
    "strainDirection1",
    "first strain directions",
    Some(ChannelKind::Strain),
    3,
    Quantity::Direction,
    Tolerance::PrincipalAxis { within: 1e-3 },
);

/// The line along which the smaller principal strain stretches the skin.
pub static STRAIN_DIRECTION_2: Channel = per_frame(
    "strainDirection2",
    "second strain directions",
    Some(ChannelKind::Strain),
    3,
    Quantity::Direction,
    Tolerance::PrincipalAxis { within: 1e-3 },
);

/// What the names of the channels of [`ChannelKind::Wrinkles`] begin with.
const WRINKLE: &str = "wrinkle_";

listed! {
    /// What a frame can have beside its positions, in the order of files. Each kind is one choice of a user
    /// and has one or more channels.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum ChannelKind {
        /// [`NORMALS`].
        Normals,
        /// [`VELOCITIES`].
        Velocities,
        /// [`SIGMA`].
        Sigma,
        /// [`STRAIN`], [`STRAIN_DIRECTION_1`] and [`STRAIN_DIRECTION_2`].
        Strain,
        /// How far the wrinkles of each example, or group of examples, are switched on: a channel for each.
        Wrinkles,
    }
}

impl ChannelKind {
    /// The name, as files and options have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normals => "normals",
            Self::Velocities => "velocities",
            Self::Sigma => "sigma",
            Self::Strain => "strain",
            Self::Wrinkles => "wrinkles",
        }
    }

    /// Whether frames have this kind by default.
    pub fn is_default(self) -> bool {
        self == Self::Normals
    }

    /// What the kind is, as a phrase that follows “write”. For a kind that is there by default, the phrase
    /// follows “leave”.
    pub fn description(self) -> &'static str {
        match self {
            Self::Normals => "the normals out",
            Self::Velocities => "velocities, for motion blur",
            Self::Sigma => "how uncertain each vertex is",
            Self::Strain => "how much skin is stretched and squeezed",
            Self::Wrinkles => "how strongly each example's wrinkles are on",
        }
    }

    /// The kind's names and units in a file, in whole sentences.
    pub fn details(self) -> &'static str {
        match self {
            Self::Normals => {
                "Without normals the file is half as large, and the program that opens it makes its own."
            }
            Self::Velocities => "Velocities are in mesh units per second.",
            Self::Sigma => {
                "The primvar sigma is how far a vertex may be from where a scan of the frame would have it, in \
                 mesh units; docs/coverage.md describes it."
            }
            Self::Strain => {
                "The primvars strain, strainDirection1 and strainDirection2 say how much and which way, for \
                 shaders; docs/strain.md describes them."
            }
            Self::Wrinkles => {
                "The primvars wrinkle_EXAMPLE have a number from 0 to 1 at each vertex, for wrinkle maps; \
                 docs/wrinkles.md describes them."
            }
        }
    }

    /// The channels. `wrinkles` are the names of the examples or of their groups.
    pub fn channels(self, wrinkles: &[String]) -> Vec<Channel> {
        match self {
            Self::Normals => vec![NORMALS.clone()],
            Self::Velocities => vec![VELOCITIES.clone()],
            Self::Sigma => vec![SIGMA.clone()],
            Self::Strain => {
                vec![STRAIN.clone(), STRAIN_DIRECTION_1.clone(), STRAIN_DIRECTION_2.clone()]
            }
            Self::Wrinkles => {
                let mut channels: Vec<Channel> = Vec::with_capacity(wrinkles.len());
                for wrinkle in wrinkles {
                    let mut name = format!("{WRINKLE}{}", identifier(wrinkle));
                    while channels.iter().any(|channel| channel.name == name) {
                        name.push('_');
                    }
                    channels.push(of_wrinkle(name, wrinkle));
                }
                channels
            }
        }
    }
}

impl fmt::Display for ChannelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Channel {
    /// How many numbers a frame of a mesh has.
    pub fn numbers(&self, vertices: usize, faces: usize) -> usize {
        self.width
            * match self.interpolation {
                Interpolation::Vertex => vertices,
                Interpolation::Uniform => faces,
            }
    }

    /// The channel of a file with this name and `width` numbers at each vertex. A channel with a name that
    /// Rhytid does not write is a ratio.
    pub fn of_file(name: &str, width: usize) -> Self {
        let known =
            ChannelKind::ALL.into_iter().flat_map(|kind| kind.channels(&[])).chain([POSITIONS.clone()]);
        let known = known.into_iter().find(|channel| channel.name == name && channel.width == width);
        match (known, name.strip_prefix(WRINKLE)) {
            (Some(channel), _) => channel,
            (None, Some(example)) if width == 1 => of_wrinkle(name.to_owned(), example),
            _ => Channel {
                name: name.to_owned().into(),
                words: name.to_owned().into(),
                kind: None,
                width,
                ..of_wrinkle(String::new(), "")
            },
        }
    }
}

fn of_wrinkle(name: String, example: &str) -> Channel {
    Channel {
        name: name.into(),
        words: format!("wrinkle activations of {example}").into(),
        kind: Some(ChannelKind::Wrinkles),
        width: 1,
        quantity: Quantity::Ratio,
        tolerance: Tolerance::FromMarkers { of_largest: 1e-3 },
        timing: Timing::PerFrame,
        interpolation: Interpolation::Vertex,
    }
}

/// The text with `_` in place of every character that a primvar's name cannot have.
fn identifier(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_gives_every_channel_back() {
        let examples = ["smile", "brow raise", "brow-raise", "Öffnen"].map(String::from);
        for kind in ChannelKind::ALL {
            let channels = kind.channels(&examples);
            assert!(!channels.is_empty(), "{kind}");
            for channel in &channels {
                let found = Channel::of_file(&channel.name, channel.width);
                assert_eq!(
                    (found.kind, found.width, found.tolerance),
                    (Some(kind), channel.width, channel.tolerance)
                );
                assert_eq!(
                    channels.iter().filter(|other| other.name == channel.name).count(),
                    1,
                    "{}",
                    channel.name
                );
            }
        }
        assert_eq!(Channel::of_file("positions", 3), POSITIONS);
        let foreign = Channel::of_file("pores", 1);
        assert_eq!((foreign.kind, foreign.width, &*foreign.name), (None, 1, "pores"));
        assert_eq!(Channel::of_file("strain", 1).kind, None, "of another width it is another channel");
    }
}
