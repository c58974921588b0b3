//! Known failures. `expectations.toml` lists them, with their reasons and where they are dealt with.
use crate::outcome::{Outcome, Verdict};
use rhytid_core::{DeviceInfo, Error, Result};
use serde::Deserialize;
use std::sync::LazyLock;
use wildmatch::WildMatch;

/// A list of known failures.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectations {
    /// In any order.
    #[serde(default)]
    pub expectation: Vec<Expectation>,
}

/// One known failure. Patterns have `*` for any text and `?` for any letter.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// A pattern for [`crate::device_label`]: `vulkan/llvmpipe/*`.
    pub device: String,
    /// A pattern for [`DeviceInfo::driver`].
    pub driver: String,
    /// A pattern for [`Outcome::name`]: `normals/holes`.
    pub case: String,
    /// Why it fails.
    pub reason: String,
    /// Where the failure is dealt with.
    pub link: String,
}

/// The project's own list, part of the program.
pub fn embedded() -> &'static Expectations {
    static EMBEDDED: LazyLock<Expectations> = LazyLock::new(|| {
        let text = include_str!("../expectations.toml");
        Expectations::parse(text).unwrap_or_else(|e| unreachable!("a test says it is sound: {e}"))
    });
    &EMBEDDED
}

impl Expectations {
    /// Reads a list.
    ///
    /// # Errors
    /// [`Error::Input`] if it is not TOML, a key is missing or unknown, or a reason or link is empty.
    pub fn parse(text: &str) -> Result<Self> {
        let list: Self = toml::from_str(text).map_err(|e| Error::malformed(format!("expectations: {e}")))?;
        for e in &list.expectation {
            if e.reason.trim().is_empty() || e.link.trim().is_empty() {
                return Err(Error::malformed(format!(
                    "expectations: {} on {} has no reason or no link; say both",
                    e.case, e.device
                )));
            }
        }
        Ok(list)
    }

    /// Waives a failure that is listed. A listed pass fails, so that the list stays true.
    pub fn apply(&self, device: &DeviceInfo, outcome: &mut Outcome) {
        let matches = |pattern: &str, text: &str| WildMatch::new(pattern).matches(text);
        let listed = self.expectation.iter().find(|e| {
            matches(&e.device, &outcome.device)
                && matches(&e.driver, &device.driver)
                && matches(&e.case, &outcome.name)
        });
        let Some(Expectation { reason, link, .. }) = listed else { return };
        match outcome.verdict {
            Verdict::Fail => {
                outcome.verdict = Verdict::Waived;
                outcome.reason = format!("{reason} ({link}): {}", outcome.reason);
            }
            Verdict::Pass => {
                outcome.verdict = Verdict::Fail;
                outcome.reason = format!(
                    "passes, though expectations.toml has it as a failure ({reason}, {link}): take the entry out"
                );
            }
            Verdict::NotSupported | Verdict::Waived | Verdict::NoDevice => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::DeviceKind;

    fn applied(verdict: Verdict, driver: &str) -> Outcome {
        let list = Expectations::parse(
            r#"
            [[expectation]]
            device = "vulkan/llvmpipe/*"
            driver = "Mesa 22.*"
            case = "normals/ho?es"
            reason = "rounds twice"
            link = "https://example.org/1"
            "#,
        )
        .unwrap();
        let device = DeviceInfo {
            backend: "vulkan",
            index: 0,
            name: "llvmpipe (LLVM 15)".into(),
            driver: driver.into(),
            kind: DeviceKind::Cpu,
            memory_bytes: None,
            max_binding_bytes: None,
        };
        let mut outcome = Outcome::new("vulkan/llvmpipe/0", "normals/holes".into(), verdict, "off".into());
        list.apply(&device, &mut outcome);
        outcome
    }

    #[test]
    fn a_known_failure_is_waived_and_an_unexpected_pass_fails() {
        let waived = applied(Verdict::Fail, "Mesa 22.3.6");
        assert_eq!(waived.verdict, Verdict::Waived);
        assert_eq!(waived.reason, "rounds twice (https://example.org/1): off");
        let passed = applied(Verdict::Pass, "Mesa 22.3.6");
        assert_eq!(passed.verdict, Verdict::Fail);
        assert!(passed.reason.contains("take the entry out"));
        assert_eq!(applied(Verdict::NotSupported, "Mesa 22.3.6").verdict, Verdict::NotSupported);
        // A new driver is a new device.
        assert_eq!(applied(Verdict::Fail, "Mesa 23.1.0").verdict, Verdict::Fail);
        assert_eq!(applied(Verdict::Pass, "Mesa 23.1.0").verdict, Verdict::Pass);
    }

    #[test]
    fn the_projects_own_list_is_sound() {
        Expectations::parse(include_str!("../expectations.toml")).unwrap();
        embedded();
    }

    #[test]
    fn an_entry_says_everything() {
        let entry = |reason: &str, more: &str| {
            Expectations::parse(&format!(
                "[[expectation]]\ndevice = \"*\"\ndriver = \"*\"\ncase = \"*\"\nreason = \"{reason}\"\nlink = \"x\"\n{more}"
            ))
        };
        assert!(entry("y", "").is_ok());
        assert!(entry(" ", "").is_err());
        assert!(entry("y", "until = 3").is_err());
    }
}
