//! Findings of the doctor, and their severity.

use rhytid_core::{Error, VertexId};

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
    /// The vertices of the neutral that the sentence is about, rising. Empty where it is about none, or all.
    pub vertices: Vec<VertexId>,
}

impl Finding {
    pub(super) fn new(severity: Severity, code: &'static str, message: String) -> Self {
        Self { severity, code, message, vertices: Vec::new() }
    }

    /// The finding with the vertices that it is about, in any order.
    pub(super) fn at(mut self, vertices: impl IntoIterator<Item = VertexId>) -> Self {
        self.vertices.extend(vertices);
        self.vertices.sort_unstable();
        self.vertices.dedup();
        self
    }

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
        self.findings.push(Finding::new(severity, code, message));
    }

    /// Adds a finding about `vertices`.
    pub(super) fn add_at(
        &mut self,
        severity: Severity,
        code: &'static str,
        vertices: impl IntoIterator<Item = VertexId>,
        message: String,
    ) {
        self.findings.push(Finding::new(severity, code, message).at(vertices));
    }
}
