//! Findings: what the doctor says, and how much it matters.

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

/// One thing that the doctor saw.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// A stable name, for programs: `components-without-handles`, …
    pub code: &'static str,
    /// One sentence: what, where, and what happens or what to do.
    pub message: String,
}

/// What the doctor saw.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Report {
    /// Worst first; in the order of the checks where equal.
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
