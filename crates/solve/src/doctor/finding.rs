//! Findings of the doctor, and their severity.

use rhytid_core::Error;

/// How much a [`Finding`] matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Worth knowing; nothing to do.
    Note,
    /// The solve works, but its result may not be what was meant.
    Warning,
    /// Makes the solve impossible.
    Error,
}

/// One finding of the doctor.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// A stable name, for programs: `components-without-handles`, …
    pub code: &'static str,
    /// One sentence: what, where, and what happens or what to do.
    pub message: String,
}

impl Finding {
    /// The finding as an [`Error::Input`], whose kind depends on the code.
    pub fn error(&self) -> Error {
        let message = &*self.message;
        match self.code {
            "no-faces" | "faces" | "uvs" | "no-area" | "no-mirror-image" => Error::bad_topology(message),
            "no-handles" => Error::empty(message),
            "handles" | "example" => Error::mismatch(message),
            "duplicate-handle" => Error::conflict(message),
            "not-finite"
            | "handle-out-of-range"
            | "pins"
            | "settings"
            | "far-from-origin"
            | "strain-edges" => Error::out_of_range(message),
            _ => Error::input(message),
        }
    }
}

/// The findings of the doctor.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Report {
    /// The worst findings come first. Equally bad ones are in the order of the checks.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Whether something makes the solve impossible.
    pub fn has_errors(&self) -> bool {
        self.findings.iter().any(|f| f.severity == Severity::Error)
    }

    pub(super) fn add(&mut self, severity: Severity, code: &'static str, message: String) {
        self.findings.push(Finding { severity, code, message });
    }
}
