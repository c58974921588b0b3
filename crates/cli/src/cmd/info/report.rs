//! `rhytid info` of the JSON that Rhytid writes: which report it is, and its keys at the top level.

use super::shape::row;
use rhytid::core::human;
use rhytid::core::input_file;
use rhytid::{Error, Result};
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// The reports by keys that only they have, and the page written beside each.
const REPORTS: [(&str, &[&str], Option<&str>); 10] = [
    ("clean-up", &["setup", "events", "summary"], Some("report.html")),
    ("conformance", &["suite", "without_device"], Some("report.md")),
    ("plan of scans", &["scans", "sigma"], Some("plan.html")),
    ("evaluation", &["leave_one_out"], Some("evaluation.html")),
    ("transfer", &["landmarks", "covered"], Some("transfer.html")),
    ("benchmark", &["storage", "devices"], None),
    ("devices", &["devices", "left_out"], None),
    ("findings of the doctor", &["solvable", "findings"], None),
    ("verification", &["allowed_mm", "worst_mm"], None),
    ("description of a file", &["kind", "file_bytes"], None),
];

#[derive(Serialize)]
pub(super) struct ReportInfo {
    /// Which report.
    pub of: &'static str,
    /// Its keys at the top.
    keys: Vec<String>,
    /// The page that should be beside it but is missing.
    missing: Option<&'static str>,
    #[serde(skip)]
    top: Map<String, Value>,
}

impl ReportInfo {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
        let refused = |what: String| Error::malformed(format!("{}: {what}", path.display()));
        let top: Map<String, Value> = serde_json::from_slice(&bytes)
            .map_err(|error| refused(format!("is no JSON object, as Rhytid's reports are: {error}")))?;
        let found = REPORTS.iter().find(|(_, keys, _)| keys.iter().all(|key| top.contains_key(*key)));
        let Some((of, _, page)) = found else {
            let keys: Vec<&str> = top.keys().map(String::as_str).collect();
            return Err(refused(format!("is none of Rhytid's reports; its keys are {}", keys.join(", "))));
        };
        let beside = |page: &&str| Path::new(page).file_stem() == path.file_stem();
        let missing = page.filter(beside).filter(|page| !path.with_file_name(page).is_file());
        Ok(Self { of, keys: top.keys().cloned().collect(), missing, top })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let value = |(key, value): (&String, &Value)| {
            let shown = match value {
                Value::String(text) => text.clone(),
                Value::Bool(_) | Value::Number(_) => value.to_string(),
                Value::Array(items) => human::counted(items.len(), "item"),
                Value::Object(_) | Value::Null => return None,
            };
            Some(row(&key.replace('_', " "), shown))
        };
        let mut rows: Vec<[String; 2]> = self.top.iter().filter_map(value).collect();
        if let Some(page) = self.missing {
            rows.push(row("missing", format!("{page}, which is written beside it")));
        }
        rows
    }
}
