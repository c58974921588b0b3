//! The report of a run, in four forms: a table for the terminal, JUnit XML, JSON, and a page in Markdown.
mod contents;
mod junit;
mod markdown;
mod terminal;

pub use contents::{Report, StageSummary};

use rhytid_core::{AtomicFile, Error, Result};
use std::io::Write;
use std::path::Path;

impl Report {
    /// The table for the terminal.
    pub fn to_terminal(&self) -> String {
        terminal::write(self)
    }

    /// The page.
    pub fn to_markdown(&self) -> String {
        markdown::write(self)
    }

    /// The whole report as JSON, for programs.
    ///
    /// # Errors
    /// [`Error::Internal`] if it cannot be written as JSON.
    pub fn to_json(&self) -> Result<String> {
        serde_json::to_string_pretty(self).map_err(|e| Error::Internal(format!("the report as JSON: {e}")))
    }

    /// The report as JUnit XML, for a build server.
    ///
    /// # Errors
    /// [`Error::Internal`] if it cannot be written as XML.
    pub fn to_junit(&self) -> Result<String> {
        junit::write(self).map_err(|e| Error::Internal(format!("the report as JUnit XML: {e}")))
    }

    /// Writes `report.md`, `report.json` and `junit.xml` into `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Internal`] as [`Report::to_json`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        let texts = [
            ("report.md", self.to_markdown()),
            ("report.json", self.to_json()?),
            ("junit.xml", self.to_junit()?),
        ];
        for (name, text) in texts {
            let path = folder.join(name);
            let mut file = AtomicFile::create(&path)?;
            file.write_all(text.as_bytes()).map_err(Error::io(&path))?;
            file.finish()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{COMMIT, DeviceReport, Measured, Outcome, StageTime, Suite, Verdict, stage_name};
    use quick_junit::TestCaseStatus;
    use rhytid_core::{DeviceInfo, DeviceKind, Stage};

    fn outcome(verdict: Verdict, name: &str, reason: &str) -> Outcome {
        let mut outcome = Outcome::new("vulkan/llvmpipe/0", name.into(), verdict, reason.into());
        outcome.stage = name.split_once('/').map(|(stage, _)| stage_name(stage_called(stage)));
        outcome.required = false;
        outcome
    }

    fn stage_called(name: &str) -> Stage {
        Stage::ALL.into_iter().find(|stage| stage_name(*stage) == name).unwrap()
    }

    /// One outcome of each kind.
    fn report(failing: bool) -> Report {
        let mut passed = outcome(Verdict::Pass, "normals/holes", "");
        passed.measured = Some(Measured { part_of_bound: 0.25, ulp: Some(3.5), mm: None });
        let mut positions = outcome(Verdict::Pass, "positions/chapter", "");
        positions.measured = Some(Measured { part_of_bound: 0.5, ulp: Some(1.5), mm: Some(1.25e-4) });
        let mut mutant = outcome(Verdict::Pass, "positions/mutant", "");
        mutant.measured = Some(Measured { part_of_bound: 99.0, ulp: Some(99.0), mm: Some(99.0) });
        let mut outcomes = vec![
            passed,
            positions,
            mutant,
            outcome(Verdict::NotSupported, "strain/chapter", "too large"),
            outcome(Verdict::Waived, "detail/fan", "known (https://example.org)"),
        ];
        if failing {
            outcomes.push(outcome(Verdict::Fail, "normals/fan", "off by <2> | more"));
        }
        let device = DeviceInfo {
            backend: "vulkan",
            index: 0,
            name: "llvmpipe (LLVM 15)".into(),
            driver: "Mesa 22.3.6".into(),
            kind: DeviceKind::Cpu,
            memory_bytes: Some(1 << 30),
            max_binding_bytes: Some(128 << 20),
        };
        let times = vec![StageTime { stage: "positions", seconds: 0.002, bytes: 2e7 }];
        let absent = crate::no_device("opencl", "no device was found", &[]);
        Report::new(
            Suite::Full,
            12e9,
            vec![DeviceReport::new(&device, outcomes, 3.0).with_times(times)],
            vec![absent],
        )
    }

    #[test]
    fn the_summary_has_the_worst_of_each_stage_without_the_mutants() {
        let summary = &report(false).devices[0].summary();
        let positions = &summary[Stage::Positions as usize];
        assert_eq!(
            *positions,
            StageSummary {
                stage: "positions",
                kernel: "fine_scale",
                cases: 1,
                part_of_bound: 0.5,
                ulp: Some(1.5),
                mm: Some(1.25e-4),
                seconds: Some(0.002),
                bandwidth: Some(1e10),
            }
        );
        assert_eq!(summary[Stage::Strain as usize].cases, 0);
    }

    #[test]
    fn every_form_says_which_words_fell() {
        for failing in [false, true] {
            let report = report(failing);
            assert_eq!(report.passed(), !failing);
            for text in [report.to_terminal(), report.to_markdown(), report.to_json().unwrap()] {
                for word in ["NotSupported", "Waived", "NoDevice", "Mesa 22.3.6", "llvmpipe", "opencl"] {
                    assert!(text.contains(word), "{word} is missing in:\n{text}");
                }
                assert_eq!(text.contains("normals/fan"), failing, "{text}");
            }
            let markdown = report.to_markdown();
            assert!(markdown.contains("**This is a software driver.**"), "{markdown}");
            assert!(markdown.contains(COMMIT) && markdown.contains("12.0 GB/s"), "{markdown}");
            assert!(
                markdown.contains("| positions | fine_scale | 1 | 0.500 | 1.50 | 1.3e-4 | 2.000 | 10.0 |")
            );
            assert_eq!(markdown.contains("off by <2> \\| more"), failing, "{markdown}");
        }
    }

    #[test]
    fn junit_is_read_back_by_its_own_reader() {
        let junit = quick_junit::Report::deserialize_from_str(&report(true).to_junit().unwrap()).unwrap();
        let device = &junit.test_suites[0];
        assert_eq!(device.name.as_str(), "[vulkan/llvmpipe/0]");
        assert_eq!((device.tests, device.failures), (6, 1));
        let words = |suite: &quick_junit::TestSuite| {
            let cases = suite.test_cases.iter();
            cases
                .filter_map(|case| match &case.status {
                    TestCaseStatus::Skipped { ty, .. } => ty.as_ref().map(|ty| ty.as_str().to_owned()),
                    _ => None,
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(words(device), ["NotSupported", "Waived"]);
        assert_eq!(words(&junit.test_suites[1]), ["NoDevice"]);
    }

    #[test]
    fn all_files_are_written() {
        let folder = std::env::temp_dir().join(format!("rhytid-report-{}", std::process::id()));
        report(true).write(&folder).unwrap();
        let mut names: Vec<String> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(names, ["junit.xml", "report.json", "report.md"]);
    }

    #[test]
    fn nothing_run_is_not_passed() {
        assert!(!Report::new(Suite::Quick, 1e9, Vec::new(), Vec::new()).passed());
        let required = crate::no_device("opencl", "no device was found", &["opencl".into()]);
        let mut report = report(false);
        report.without_device = vec![required];
        assert!(!report.passed());
    }
}
