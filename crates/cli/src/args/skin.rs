//! The light and exposure of `rhytid render --show skin`.

use super::SHOW;
use clap::ValueEnum;
use rhytid::render::{Lights, Tone};

/// For `--show skin`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct SkinLight {
    /// The key light of --show skin, in degrees.
    ///
    /// It is the direction seen from the face: to the picture's right (negative: left), and up.
    #[arg(long, value_name = "RIGHT,UP", default_value = "-41,33", allow_hyphen_values = true, value_parser = parse_light, help_heading = SHOW)]
    pub light: From,

    /// Brightness of --show skin, in stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_stops, help_heading = SHOW)]
    pub exposure: f32,

    /// How --show skin shows bright colours.
    #[arg(long, value_enum, default_value_t = ToneChoice::Neutral, help_heading = SHOW)]
    pub tone: ToneChoice,
}

/// `--light`
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct From {
    right: f32,
    up: f32,
}

/// `--tone`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ToneChoice {
    /// Colours stay as they are, but for the brightest (Khronos PBR Neutral).
    Neutral,
    /// With more contrast, and what is bright becomes white sooner (AgX).
    Agx,
}

impl SkinLight {
    pub(crate) fn lights(&self) -> Lights {
        let [right, up] = [self.light.right, self.light.up].map(f32::to_radians);
        let lights = Lights::default();
        Lights {
            toward: [right.sin() * up.cos(), up.sin(), right.cos() * up.cos()],
            exposure: lights.exposure - self.exposure,
            tone: match self.tone {
                ToneChoice::Neutral => Tone::Neutral,
                ToneChoice::Agx => Tone::Agx,
            },
            ..lights
        }
    }
}

fn parse_light(text: &str) -> Result<From, String> {
    let angle = |text: &str, most: f32| text.trim().parse().ok().filter(|x: &f32| x.abs() <= most);
    text.split_once(',')
        .and_then(|(right, up)| Some(From { right: angle(right, 180.0)?, up: angle(up, 90.0)? }))
        .ok_or_else(|| {
            "expected degrees to the right (-180 to 180) and up (-90 to 90), such as -41,33".to_owned()
        })
}

fn parse_stops(text: &str) -> Result<f32, String> {
    let stops = text.parse().ok().filter(|x: &f32| x.abs() <= 10.0);
    stops.ok_or_else(|| "expected stops from -10 to 10".to_owned())
}
