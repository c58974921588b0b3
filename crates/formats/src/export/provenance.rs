//! The provenance of an animation: what it was made from, and how.

use crate::take::Missing;
use serde::de::value::{Error as Unfit, StrDeserializer};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, IntoDeserializer};
use serde::{Serialize, Serializer};
use std::fmt;

/// How an animation was made. It stands in the file (USD: `customData` of the default prim, glTF: `extras` of the
/// scene, both under the key `rhytid`), so that the file can be made again and compared.
#[derive(Debug, Clone, PartialEq, Default, Serialize, serde::Deserialize)]
pub struct Provenance {
    /// The program's version.
    pub version: String,
    /// The rig file's hash, as [`rhytid_core::rig_file::hash`] gives it.
    pub rig: String,
    /// Which stage of the evaluation the positions are of.
    pub stage: Word<OutputStage>,
    /// The first frame of the take that was asked for.
    pub first_frame: u64,
    /// The frame behind the last one that was asked for.
    pub end_frame: u64,
    /// The frames per second that were asked for; `None` for the take's own, which files have as 0.
    #[serde(serialize_with = "write_rate", deserialize_with = "read_rate")]
    pub fps: Option<f64>,
    /// What was done where a marker was missing: [`Missing::Error`] or [`Missing::Hold`].
    pub missing: Word<Missing>,
    /// Whether detail fades where the take's confidence is below 1. Files from before there was this choice do not say:
    /// it was false.
    #[serde(default)]
    pub fade_detail: bool,
    /// By how much detail is multiplied, from 0 to 2; `None` for 1, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<f64>,
    /// By how much it is multiplied by region besides, such as `brows=0.5;chin=1.2`; `None` where it is not, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail_of: Option<String>,
    /// The text of the edits that were applied to the take ([`crate::edits`]); `None` where there were none, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit: Option<String>,
    /// What tells them from others, also those whose text is the same and that name other files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit_hash: Option<String>,
    /// Whether there are normals; `None` for yes, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normals: Option<bool>,
    /// Whether there are velocities; `None` for no, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocities: Option<bool>,
    /// Whether there are principal strains; `None` for no, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<bool>,
    /// Whether frames were refined; `None` for no, which files do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refine: Option<bool>,
    /// What became of the head's motion. Files from before there was this choice do not say: it was
    /// [`HeadMotion::Keep`].
    #[serde(default = "keep")]
    pub head: Word<HeadMotion>,
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
    /// It is a transform in the file, which the mesh moves with as a whole.
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

/// A choice as a file states it. A word that is not known, perhaps that of a later version, is kept as it is: only who
/// needs the choice cannot do without it. The default is the empty word, which stands where there was nothing to choose.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Word<T> {
    /// One of the choices.
    Known(T),
    /// Anything else.
    Unknown(String),
}

impl<T: DeserializeOwned> Word<T> {
    /// The choice that `text` names.
    pub fn of(text: &str) -> Self {
        let word: StrDeserializer<'_, Unfit> = text.into_deserializer();
        T::deserialize(word).map_or_else(|_| Self::Unknown(text.to_owned()), Self::Known)
    }
}

impl<T: Copy> Word<T> {
    /// The choice.
    ///
    /// # Errors
    /// The word, if it is not known.
    pub fn known(&self) -> Result<T, &str> {
        match self {
            Self::Known(choice) => Ok(*choice),
            Self::Unknown(word) => Err(word),
        }
    }
}

impl<T> Default for Word<T> {
    fn default() -> Self {
        Self::Unknown(String::new())
    }
}

impl<T> From<T> for Word<T> {
    fn from(choice: T) -> Self {
        Self::Known(choice)
    }
}

impl<T: fmt::Display> fmt::Display for Word<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(choice) => choice.fmt(f),
            Self::Unknown(word) => f.write_str(word),
        }
    }
}

impl<T: fmt::Display> Serialize for Word<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de, T: DeserializeOwned> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|text| Self::of(&text))
    }
}

/// What older files do not say.
fn keep() -> Word<HeadMotion> {
    HeadMotion::Keep.into()
}

impl Provenance {
    /// [`Provenance::fps`] from the number in a file.
    pub(crate) fn rate(stored: f64) -> Option<f64> {
        (stored != 0.0).then_some(stored)
    }

    /// [`Provenance::fps`] as the number in a file.
    pub(crate) fn stored_rate(&self) -> f64 {
        self.fps.unwrap_or(0.0)
    }
}

#[expect(clippy::ref_option, reason = "serde's way to call it")]
fn write_rate<S: Serializer>(fps: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    fps.unwrap_or(0.0).serialize(serializer)
}

fn read_rate<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    f64::deserialize(deserializer).map(Provenance::rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<T>(choice: T, name: &str)
    where
        T: Copy + PartialEq + fmt::Debug + fmt::Display + DeserializeOwned,
    {
        assert_eq!(choice.to_string(), name);
        assert_eq!(Word::of(name), Word::Known(choice));
        assert_eq!(serde_json::to_value(Word::from(choice)).unwrap(), name);
    }

    #[test]
    fn every_choice_is_known_by_its_name_again() {
        check(OutputStage::Full, "full");
        check(OutputStage::LargeScale, "large-scale");
        check(OutputStage::Shell, "shell");
        check(HeadMotion::Keep, "keep");
        check(HeadMotion::Drop, "drop");
        check(HeadMotion::Bake, "bake");
        check(Missing::Error, "error");
        check(Missing::Hold, "hold");
    }

    #[test]
    fn a_word_of_a_later_version_is_kept() {
        let text = r#"{"version":"9","rig":"","stage":"pores","first_frame":3,"end_frame":4,"fps":0.0,"missing":"leave"}"#;
        let found: Provenance = serde_json::from_str(text).unwrap();
        assert_eq!(found.stage.known(), Err("pores"));
        assert_eq!(found.missing.known(), Err("leave"), "no animation is made so");
        assert_eq!((found.fps, found.head.known(), found.fade_detail), (None, Ok(HeadMotion::Keep), false));
        let again = serde_json::to_string(&found).unwrap();
        assert!(again.contains(r#""stage":"pores""#) && again.contains(r#""fps":0.0"#), "{again}");
    }
}
