//! The ratios to Numba, compared with the stored ones.
use crate::{Measured, Report, Row};
use rhytid_core::{AtomicFile, Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// Where the ratios are kept.
const STORED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/ratios.json");

/// How far a ratio may be below the stored one.
const ALLOWED_LOSS: f64 = 0.15;

/// How many times as fast as Numba Rhytid is, and on which machine.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Ratios {
    machine: String,
    threads: usize,
    date: String,
    vertices: usize,
    peer: String,
    /// Ratios by the evaluation and the storage of the basis.
    ratios: BTreeMap<String, f64>,
}

/// Compares `report`, which has only Numba, with the stored ratios. With `store` it stores them instead.
///
/// # Errors
/// [`Error::Input`] if nothing comparable is stored, or a ratio is lower than allowed.
pub(crate) fn run(report: &Report, store: bool) -> Result<()> {
    let path = Path::new(STORED);
    let found = Ratios::new(report)?;
    if store {
        found.write(path)?;
        println!("\nstored in {STORED}");
        return Ok(());
    }
    let unreadable =
        |e: &dyn Display| Error::malformed(format!("{STORED}: {e}; make it anew with --quick --store"));
    let text = std::fs::read_to_string(path).map_err(|e| unreadable(&e))?;
    let stored = serde_json::from_str(&text).map_err(|e| unreadable(&e))?;
    println!("\n{}", compare(&found, &stored)?);
    Ok(())
}

impl Ratios {
    fn new(report: &Report) -> Result<Self> {
        let [Row { name, detail, frame, batch, .. }] = report.peers.as_slice() else {
            return Err(Error::Internal("the quick comparison is with one peer".into()));
        };
        let ratios = [("frame", frame), ("batch", batch)].into_iter().flat_map(|(what, measured)| {
            let Measured { peer, rhytid_f32, rhytid_f16 } = measured;
            [("f32", rhytid_f32), ("f16", rhytid_f16)].map(|(storage, rhytid)| {
                let ratio = peer.whole / rhytid.whole;
                (format!("{what} {storage}"), (ratio * 100.0).round() / 100.0)
            })
        });
        Ok(Self {
            machine: report.machine.clone(),
            threads: report.threads,
            date: today()?,
            vertices: report.vertices,
            peer: format!("{name} ({detail})"),
            ratios: ratios.collect(),
        })
    }

    fn write(&self, path: &Path) -> Result<()> {
        let json = serde_json::to_string_pretty(self).map_err(|e| Error::Internal(e.to_string()))?;
        let mut file = AtomicFile::create(path)?;
        writeln!(file, "{json}").map_err(file.error())?;
        file.finish()
    }
}

/// A table of both. The error names the first ratio that is too low.
fn compare(found: &Ratios, stored: &Ratios) -> Result<String> {
    if (found.threads, found.vertices) != (stored.threads, stored.vertices) {
        return Err(Error::mismatch(format!(
            "the stored ratios are of {} threads and {} vertices, found {} and {}: set RAYON_NUM_THREADS, or store them \
             anew with --quick --store",
            stored.threads, stored.vertices, found.threads, found.vertices
        )));
    }
    let mut table = format!("times as fast as {}; stored on {}, {}", found.peer, stored.date, stored.machine);
    for (what, before) in &stored.ratios {
        let now = found.ratios.get(what).copied().unwrap_or(f64::NAN);
        table += &format!("\n{what:>12} {now:6.2}   stored {before:6.2}");
        let lowest = before * (1.0 - ALLOWED_LOSS);
        if now.is_nan() || now < lowest {
            return Err(Error::out_of_range(format!(
                "Rhytid is {now:.2} times as fast as {} for a {what}, expected at least {lowest:.2}, which is 15 % below \
                 the {before:.2} stored on {}: run it again on a quiet machine; if it stays, something became slower",
                found.peer, stored.date
            )));
        }
    }
    Ok(table)
}

/// Today's date, such as 2026-01-31.
fn today() -> Result<String> {
    let failed = || Error::Internal("`date` does not tell the day".into());
    let output = Command::new("date").args(["-u", "+%F"]).output().map_err(|_| failed())?;
    let date = String::from_utf8(output.stdout).map_err(|_| failed())?;
    if output.status.success() { Ok(date.trim().to_owned()) } else { Err(failed()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratios(frame: f64, batch: f64) -> Ratios {
        Ratios {
            machine: "m".into(),
            threads: 2,
            date: "2026-01-31".into(),
            vertices: 100,
            peer: "Numba".into(),
            ratios: [("frame f32".to_owned(), frame), ("batch f32".to_owned(), batch)].into(),
        }
    }

    #[test]
    fn only_what_is_much_slower_fails() {
        let stored = ratios(2.0, 4.0);
        assert!(compare(&ratios(1.71, 3.41), &stored).is_ok());
        assert!(compare(&ratios(9.0, 9.0), &stored).is_ok());
        let error = compare(&ratios(2.0, 3.39), &stored).unwrap_err().to_string();
        assert!(
            error.contains("3.39 times as fast as Numba for a batch f32, expected at least 3.40"),
            "{error}"
        );
        assert!(compare(&ratios(1.69, 4.0), &stored).is_err());
        assert!(compare(&ratios(f64::NAN, 4.0), &stored).is_err());
        assert!(compare(&Ratios { ratios: BTreeMap::new(), ..ratios(2.0, 4.0) }, &stored).is_err());
    }

    #[test]
    fn other_conditions_are_not_compared() {
        let error = compare(&Ratios { threads: 8, ..ratios(2.0, 4.0) }, &ratios(2.0, 4.0)).unwrap_err();
        assert!(error.to_string().contains("2 threads and 100 vertices, found 8 and 100"), "{error}");
        assert!(compare(&Ratios { vertices: 99, ..ratios(2.0, 4.0) }, &ratios(2.0, 4.0)).is_err());
    }

    #[test]
    fn what_is_stored_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ratios.json");
        ratios(2.5, 4.0).write(&path).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert_eq!(serde_json::from_str::<Ratios>(&text).unwrap(), ratios(2.5, 4.0));
    }
}
