//! The mesh doctor: what would hurt a solve, said before it starts.
mod capture;
mod impossible;
mod surface;

use rhytid_core::{Error, Face, Result};

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

    fn add(&mut self, severity: Severity, code: &'static str, message: String) {
        self.findings.push(Finding { severity, code, message });
    }
}

/// Looks at a face for everything that would hurt its solve. Errors are only what makes it impossible; where
/// there are some, the finer checks are left out, since they need a whole mesh.
pub fn examine(face: &Face) -> Report {
    let mut report = Report::default();
    impossible::examine(face, &mut report);
    if !report.has_errors() {
        surface::examine(face, &mut report);
        capture::examine(face, &mut report);
    }
    report.findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    report
}

/// Fails with the first error of [`examine`].
pub(crate) fn check(face: &Face) -> Result<()> {
    let mut report = Report::default();
    impossible::examine(face, &mut report);
    report.findings.into_iter().next().map_or(Ok(()), |finding| Err(Error::Input(finding.message)))
}

/// `1 vertex`, `2 vertices`: counts as a sentence has them.
fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// A length for a sentence: three significant digits, or whole.
fn length(x: f64) -> String {
    if x != 0.0 && !(1e-6..1e9).contains(&x.abs()) {
        return format!("{x:.2e}");
    }
    let digits = 2 - x.abs().max(1e-6).log10().floor() as i32;
    let rounded = format!("{x:.*}", digits.max(0) as usize);
    match rounded.contains('.') {
        true => rounded.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => rounded,
    }
}

/// The first few of a list, and how many more there are.
fn first_few<T: ToString>(items: &[T]) -> String {
    const FEW: usize = 5;
    let mut out = items.iter().take(FEW).map(T::to_string).collect::<Vec<_>>().join(", ");
    if items.len() > FEW {
        out += &format!(" and {} more", items.len() - FEW);
    }
    out
}
