//! The outcome of a case on a device, as one of five words.
use rhytid_core::{DeviceInfo, Stage};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// The five words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Verdict {
    /// Every number was within its rounding, and every repetition gave the same bits.
    Pass,
    /// A number was beyond its bound, bits differed, or the device failed.
    Fail,
    /// The device lacks a limit or the memory for the case, and reported it.
    NotSupported,
    /// It failed as `expectations.toml` lists it.
    Waived,
    /// The backend has no device here.
    NoDevice,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// How far a stage is from its reference, at its farthest number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The largest difference as a part of its bound: at most 1 passes. Infinite for a NaN.
    pub part_of_bound: f64,
    /// The largest difference in units in the last place (f32) of the stage's size.
    /// The size is the stage's largest number. For normals it is 1. For strains, which are differences of
    /// ratios around 1, it is at least 1. `None` where the stage is zero.
    ///
    /// Numbers whose bound is above a hundredth of the stage's size are compared, but not counted here.
    /// Rounding leaves them undetermined, such as the normal of a triangle without area.
    pub ulp: Option<f64>,
    /// The same difference in millimetres, where the stage is a length.
    pub mm: Option<f64>,
}

/// A name as [`stage_name`] gives it. With `&'static str` written out, serde would borrow it from its input.
pub type StageName = &'static str;

/// The outcome of one stage of one case on one device, or of another check of the suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The device's [`device_label`], or a backend's name if it has no device.
    pub device: String,
    /// `stage/case`, such as `normals/holes`.
    pub name: String,
    /// How it went.
    pub verdict: Verdict,
    /// What failed, is not supported or was waived, in a sentence; empty for [`Verdict::Pass`].
    pub reason: String,
    /// The stage, if the outcome is about one.
    #[serde(default, deserialize_with = "some_stage_name")]
    pub stage: Option<StageName>,
    /// The distance from its reference; `None` where nothing was compared.
    pub measured: Option<Measured>,
    /// Whether every device can hold the case. Then [`Verdict::NotSupported`] is no excuse.
    pub required: bool,
}

impl Outcome {
    pub(crate) fn new(device: &str, name: String, verdict: Verdict, reason: String) -> Self {
        Self { device: device.to_owned(), name, verdict, reason, stage: None, measured: None, required: true }
    }

    /// `normals/holes`.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// `[vulkan/llvmpipe/0] normals/holes`.
    pub fn full_name(&self) -> String {
        format!("[{}] {}", self.device, self.name)
    }

    /// Whether a device may be trusted in spite of this outcome. A [`Verdict::NoDevice`] is acceptable unless
    /// the backend is required. A [`Verdict::NotSupported`] is acceptable for a case that some devices cannot
    /// hold.
    pub fn is_acceptable(&self) -> bool {
        match self.verdict {
            Verdict::Pass | Verdict::Waived => true,
            Verdict::Fail => false,
            Verdict::NotSupported | Verdict::NoDevice => !self.required,
        }
    }
}

/// The name of a stage's result, for test names.
pub fn stage_name(stage: Stage) -> &'static str {
    stage.name()
}

pub(crate) fn read_stage_name<'de, D: Deserializer<'de>>(from: D) -> Result<&'static str, D::Error> {
    let text = String::deserialize(from)?;
    let name = Stage::ALL.map(stage_name).into_iter().find(|name| **name == text);
    name.ok_or_else(|| serde::de::Error::custom(format!("there is no stage {text}")))
}

fn some_stage_name<'de, D: Deserializer<'de>>(from: D) -> Result<Option<&'static str>, D::Error> {
    read_stage_name(from).map(Some)
}

/// The kernel that computes a stage.
pub fn kernel_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Strain => "strain",
        Stage::LargeScale => "large_scale",
        Stage::LargeScaleNormals | Stage::Normals => "normals",
        Stage::Detail => "detail",
        Stage::Positions => "fine_scale",
    }
}

/// `vulkan/llvmpipe/0`: backend, the device's name without what is in brackets, index.
pub fn device_label(info: &DeviceInfo) -> String {
    let name = info.name.replace("(R)", "").replace("(TM)", "").replace('/', "-");
    let name = name.split(" (").next().unwrap_or_default();
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    format!("{}/{name}/{}", info.backend, info.index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::DeviceKind;

    #[test]
    fn labels_are_short() {
        let label = |backend, name: &str| {
            device_label(&DeviceInfo {
                backend,
                index: 1,
                name: name.into(),
                driver: String::new(),
                kind: DeviceKind::Other,
                memory_bytes: None,
                max_binding_bytes: None,
            })
        };
        assert_eq!(label("vulkan", "llvmpipe (LLVM 15.0.6, 256 bits)"), "vulkan/llvmpipe/1");
        assert_eq!(label("cpu", "Intel(R) Xeon(R) CPU @ 2.20GHz"), "cpu/Intel Xeon CPU @ 2.20GHz/1");
    }

    #[test]
    fn an_excuse_counts_only_where_it_can() {
        let acceptable = |verdict, required| {
            let mut outcome = Outcome::new("cpu/x/0", "normals/holes".into(), verdict, String::new());
            outcome.required = required;
            outcome.is_acceptable()
        };
        assert!(acceptable(Verdict::Pass, true) && acceptable(Verdict::Waived, true));
        assert!(!acceptable(Verdict::Fail, false));
        assert!(acceptable(Verdict::NotSupported, false) && !acceptable(Verdict::NotSupported, true));
        assert!(acceptable(Verdict::NoDevice, false) && !acceptable(Verdict::NoDevice, true));
    }
}
