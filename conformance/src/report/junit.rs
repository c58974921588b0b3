//! The report as JUnit XML.
use super::contents::Report;
use crate::outcome::{Outcome, Verdict};
use quick_junit::{NonSuccessKind, SerializeError, TestCase, TestCaseStatus, TestSuite};
use std::time::Duration;

/// One test suite for each device, one test for each outcome.
pub(super) fn write(report: &Report) -> Result<String, SerializeError> {
    let mut junit = quick_junit::Report::new("rhytid conformance");
    for device in &report.devices {
        let mut suite = TestSuite::new(format!("[{}]", device.label));
        suite.set_time(Duration::from_secs_f64(device.wall_seconds));
        for (name, value) in [
            ("device", device.device.name.as_str()),
            ("driver", device.device.driver.as_str()),
            ("software_driver", if device.software_driver { "true" } else { "false" }),
            ("commit", report.commit),
        ] {
            suite.add_property((name, value));
        }
        suite.add_test_cases(device.outcomes.iter().map(test_case));
        junit.add_test_suite(suite);
    }
    if !report.without_device.is_empty() {
        let mut suite = TestSuite::new("without a device");
        suite.add_test_cases(report.without_device.iter().map(test_case));
        junit.add_test_suite(suite);
    }
    junit.to_string()
}

/// JUnit has only passed, failed and skipped. The verdict's own word is the type.
fn test_case(outcome: &Outcome) -> TestCase {
    let mut status = match outcome.verdict {
        Verdict::Pass => TestCaseStatus::success(),
        _ if !outcome.is_acceptable() => TestCaseStatus::non_success(NonSuccessKind::Failure),
        _ => TestCaseStatus::skipped(),
    };
    if outcome.verdict != Verdict::Pass {
        status.set_type(outcome.verdict.to_string()).set_message(outcome.reason.as_str());
    }
    let mut case = TestCase::new(outcome.name.as_str(), status);
    case.set_classname(outcome.device.as_str());
    if let Some(measured) = outcome.measured {
        case.add_property(("part_of_bound", measured.part_of_bound.to_string().as_str()));
    }
    case
}
