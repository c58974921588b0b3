//! The recipe of an animation: everything that decides its frames.

mod channel_choice;
mod stated;
mod wrinkles;

pub use channel_choice::ChannelChoice;
use rhytid_core::{ChannelKind, Missing};
use serde::Serialize;
pub use stated::StatedRecipe;
use std::fmt;
pub use wrinkles::{Gains, WrinkleGroup, WrinkleGroups};

/// Everything that decides each frame of an animation of a rig and a take, on every machine and device.
///
/// The recipe stands in the exported file under the key `rhytid`: in USD in `customData` of the default prim,
/// in glTF in `extras` of the scene. With it, parts can be compared, and the file can be made again.
///
/// Files leave out a field with its default value, except for the fields that they have always had.
#[derive(Debug, Clone, PartialEq, Serialize, serde::Deserialize)]
pub struct Recipe {
    /// The program's version.
    pub version: String,
    /// The rig file's hash, as [`rhytid_core::rig_file::hash`] gives it.
    pub rig: String,
    /// The stage of the evaluation that gives the positions.
    pub stage: OutputStage,
    /// The first exported frame of the take, counted from 0.
    pub first_frame: u64,
    /// The frame behind the last exported one; 0 for all that the take has.
    pub end_frame: u64,
    /// The frames per second of the export; `None` for the take's own, which files state as 0.
    #[serde(with = "rate")]
    pub fps: Option<f64>,
    /// The time code of the take's first frame; `None` for the take's place in its session.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_frame: Option<u64>,
    /// What was done where a marker was missing: [`Missing::Error`] or [`Missing::Hold`].
    pub missing: Missing,
    /// Whether detail fades where the take's confidence is below 1, and where the rig's confidence says that
    /// a frame is far outside its examples. It matters for [`OutputStage::Full`] alone.
    #[serde(default)]
    pub fade_detail: bool,
    /// How the head's motion was exported.
    #[serde(default)]
    pub head: HeadMotion,
    /// The gain of the detail, from 0 to 2.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub detail: f64,
    /// Further gains of the detail, by region.
    #[serde(default, with = "text", skip_serializing_if = "Gains::is_empty")]
    pub detail_of: Gains,
    /// The text of the edits that were applied to the take (`rhytid_projects::edits`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit: Option<String>,
    /// The hash of the edits. It also differs where the text is the same and the files that it names differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit_hash: Option<String>,
    /// The channels of each frame beside its positions.
    #[serde(flatten)]
    pub channels: ChannelChoice,
    /// Groups of examples whose wrinkles are one channel; by default each example is by itself.
    #[serde(default, with = "text", skip_serializing_if = "WrinkleGroups::is_empty")]
    pub wrinkle_groups: WrinkleGroups,
    /// Whether each frame is refined on the host, as rigidly as possible. Only a rig without examples can be
    /// refined.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub refine: bool,
    /// How the take was brought into the rig's space before anything else.
    #[serde(default, skip_serializing_if = "Treatment::is_none")]
    pub treatment: Treatment,
}

impl Default for Recipe {
    /// All frames of a take at its own rate: positions and normals of the whole face. They are in head space,
    /// and a known head motion stands beside them.
    fn default() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            rig: String::new(),
            stage: OutputStage::Full,
            first_frame: 0,
            end_frame: 0,
            fps: None,
            start_frame: None,
            missing: Missing::Error,
            fade_detail: false,
            head: HeadMotion::Keep,
            detail: 1.0,
            detail_of: Gains::default(),
            edit: None,
            edit_hash: None,
            channels: ChannelChoice::default(),
            wrinkle_groups: WrinkleGroups::default(),
            refine: false,
            treatment: Treatment::default(),
        }
    }
}

impl Recipe {
    /// Whether each frame has these channels.
    pub fn has(&self, kind: ChannelKind) -> bool {
        self.channels.has(kind)
    }
}

/// Which stage of the evaluation is exported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputStage {
    /// The whole face with its detail.
    #[default]
    Full,
    /// The smooth surface without detail.
    LargeScale,
    /// The thin shell alone, as it is before any example is seen.
    Shell,
}

/// What becomes of the head's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeadMotion {
    /// It is a transform in the file and moves the mesh as a whole.
    #[default]
    Keep,
    /// It is left out, as if the head never moved.
    Drop,
    /// It is in every position, normal and velocity; the file has no transform.
    Bake,
}

impl OutputStage {
    /// As it stands in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::LargeScale => "large-scale",
            Self::Shell => "shell",
        }
    }
}

impl HeadMotion {
    /// As it stands in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Keep => "keep",
            Self::Drop => "drop",
            Self::Bake => "bake",
        }
    }
}

impl fmt::Display for OutputStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for HeadMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How a take was treated before it was played, as far as the user said so. By default the take is in the
/// rig's unit, axes and seconds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, serde::Deserialize)]
pub struct Treatment {
    /// Metres in one unit of the take; `None` for the mesh's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metres_per_unit: Option<f64>,
    /// The take's axes that the mesh's x, y and z are, such as `+x+z-y`; `None` for the mesh's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<String>,
    /// Frames per second of the take, in place of its times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// The hash of the setup: the file that says how a raw take was cleaned, with the table of markers that
    /// it names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup_hash: Option<String>,
    /// The hash of the shapes that curves weighed; `None` for the rig's own examples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes_hash: Option<String>,
    /// Whether the noise of the markers was taken out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub soft_markers: bool,
}

impl Treatment {
    /// Whether everything is as by default.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

fn one() -> f64 {
    1.0
}

fn is_one<T: PartialEq<f64>>(x: &T) -> bool {
    *x == 1.0
}

/// Fields that files hold as text.
mod text {
    use serde::{Deserialize, Deserializer, Serializer, de};
    use std::fmt::Display;
    use std::str::FromStr;

    pub(super) fn serialize<T: Display, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(value)
    }

    pub(super) fn deserialize<'de, T: FromStr<Err = String>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

/// A rate that files hold as 0 if it is the take's own.
mod rate {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    #[expect(clippy::ref_option, reason = "serde's way to call it")]
    pub(super) fn serialize<S: Serializer>(fps: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        fps.unwrap_or(0.0).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        match f64::deserialize(deserializer)? {
            0.0 => Ok(None),
            rate if (0.01..=10_000.0).contains(&rate) => Ok(Some(rate)),
            rate => Err(de::Error::custom(format!(
                "the rate {rate}, expected a number per second, from 0.01 to 10000"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn all() -> Recipe {
        Recipe {
            version: "1.2.3".into(),
            rig: "0123".into(),
            stage: OutputStage::LargeScale,
            first_frame: 7,
            end_frame: 5_000_000_000,
            fps: Some(30.0 / 1.001),
            start_frame: Some(1001),
            missing: Missing::Hold,
            fade_detail: true,
            head: HeadMotion::Drop,
            detail: 0.5,
            detail_of: Gains(vec![("brows".into(), 0.5), ("a=b".into(), 2.0)]),
            edit: Some("[[gain]]\nby = 1.5\n".into()),
            edit_hash: Some("4567".into()),
            channels: ChannelKind::ALL
                .into_iter()
                .fold(ChannelChoice::NONE, ChannelChoice::with)
                .without(ChannelKind::Normals),
            wrinkle_groups: "brows=frown+raise;mouth=smile".parse().unwrap(),
            refine: true,
            treatment: Treatment {
                metres_per_unit: Some(1e-3),
                axes: Some("+x+z-y".into()),
                ..Treatment::default()
            },
        }
    }

    fn stated() -> StatedRecipe {
        StatedRecipe::from(&Recipe::default())
    }

    #[test]
    fn what_is_stated_is_the_recipe() {
        for recipe in [Recipe::default(), all()] {
            assert_eq!(StatedRecipe::from(&recipe).recipe().unwrap(), recipe);
        }
        let expected = json!({
            "version": env!("CARGO_PKG_VERSION"), "rig": "", "stage": "full", "first_frame": 0, "end_frame": 0, "fps": 0.0, "missing": "error", "fade_detail": false,
            "head": "keep",
        });
        assert_eq!(
            serde_json::to_value(stated()).unwrap(),
            expected,
            "a default that files did not state before"
        );
        assert_eq!(stated().0[2].0, "stage", "not in the order of the fields");
    }

    /// Each field by itself. A field that is forgotten where recipes are compared fails here.
    #[test]
    fn a_difference_in_any_field_is_a_difference() {
        let all = StatedRecipe::from(&all()).0;
        assert!(all.len() > stated().0.len() + 10, "{all:?}");
        for (name, value) in all {
            let other = stated().with(&name, value);
            assert_eq!(other.difference(&stated(), &[]).map(|[name, ..]| name), Some(name.clone()));
            assert!(other.difference(&stated(), &[&name]).is_none());
            other.recipe().unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }

    #[test]
    fn what_a_later_version_wrote_is_kept_and_not_guessed() {
        for (name, value, says) in [
            ("stage", json!("pores"), "stage = \"pores\""),
            ("missing", json!("guess"), "missing = \"guess\""),
            ("head", json!(3), "head = 3"),
            ("pores", json!(true), "pores = true"),
            ("sigma", json!("yes"), "sigma = \"yes\""),
            ("fps", json!(-3.0), "fps = -3"),
            ("detail_of", json!("brows"), "detail_of = \"brows\""),
        ] {
            let stated = stated().with(name, value.clone());
            let error = stated.recipe().unwrap_err().to_string();
            assert!(error.contains(says) && error.contains("export it again"), "{error}");
            assert_eq!(serde_json::to_value(&stated).unwrap()[name], value);
        }
    }

    /// The page on exports has a row for every field that files state.
    #[test]
    fn the_page_on_exports_has_every_field() {
        let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/export.md");
        let page = std::fs::read_to_string(page).unwrap();
        let table = page.split_once("The **recipe** is").unwrap().1;
        for (name, _) in StatedRecipe::from(&all()).0 {
            assert!(table.contains(&format!("`{name}`")), "docs/export.md has no {name}");
        }
    }
}
