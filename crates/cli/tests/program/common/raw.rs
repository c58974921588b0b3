//! The demo's performance as a capture system would have recorded it.
use super::{demo, rhytid, stderr};
use rhytid::Take;
use rhytid::formats::take::{Missing, read};
use std::fmt::Write;
use std::path::PathBuf;
use std::process::Output;
use tempfile::TempDir;

/// The position of marker `j` in frame `f`, in millimetres with Z up; `None` where it was not seen.
pub(crate) type Sample<'a> = &'a dyn Fn(usize, usize, [f64; 3]) -> Option<[f64; 3]>;

pub(crate) fn rig() -> PathBuf {
    demo().join("face.safetensors")
}

/// The true take from which the raw takes are made.
pub(crate) fn truth() -> Take {
    read(&demo().join("performance.csv"), None, Missing::Error).unwrap()
}

/// A TRC file's parts, to be spoilt before it is written.
pub(crate) struct Raw {
    pub folder: TempDir,
    pub labels: Vec<String>,
    pub rate: &'static str,
    pub units: &'static str,
    pub frames: usize,
}

impl Raw {
    /// The performance with a turning head. The four markers of a cap follow those of the handles.
    pub(crate) fn new() -> Self {
        let take = truth();
        let frames = take.frames();
        let labels = take.labels.into_iter().chain((0..4).map(|i| format!("cap{i}"))).collect();
        Self { folder: TempDir::new().unwrap(), labels, rate: "30", units: "mm", frames }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes `raw.trc`.
    pub(crate) fn write(&self, sample: Sample<'_>) {
        const CAP: [[f64; 3]; 4] =
            [[0.0, 14.0, 5.0], [7.0, 10.0, -1.0], [-7.0, 10.0, -1.0], [0.0, 16.0, -4.0]];
        let (take, frames) = (truth(), self.frames);
        let m = take.labels.len();
        let mut text = format!(
            "PathFileType\t4\t(X/Y/Z)\traw.trc\n\
             DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
             {rate}\t{rate}\t{frames}\t{}\t{}\t{rate}\t1\t{frames}\nFrame#\tTime\t{}\n\t\t\n\n",
            m + 4,
            self.units,
            self.labels.join("\t\t\t"),
            rate = self.rate,
        );
        for f in 0..frames {
            write!(text, "{}\t{:.6}", f + 1, f as f64 / 30.0).unwrap();
            let (sin, cos) = (0.2 * (f as f64 / 40.0).sin()).sin_cos();
            for (j, [x, y, z]) in take.positions[f * m..(f + 1) * m].iter().chain(&CAP).enumerate() {
                let [x, y] = [x * cos - y * sin, x * sin + y * cos];
                match sample(j, f, [10.0 * x, -10.0 * z, 1500.0 + 10.0 * y]) {
                    Some([x, y, z]) => write!(text, "\t{x:.5}\t{y:.5}\t{z:.5}").unwrap(),
                    None => text.push_str("\t\t\t"),
                }
            }
            text.push('\n');
        }
        std::fs::write(self.path("raw.trc"), text).unwrap();
    }

    /// Runs `prepare` on it with these options. The output is `clean.csv`.
    pub(crate) fn prepare(&self, options: &str) -> Output {
        let [raw, out] = ["raw.trc", "clean.csv"].map(|name| self.path(name).display().to_string());
        rhytid(&format!("prepare {raw} --rig {} -o {out} {options}", rig().display())).output().unwrap()
    }

    /// As [`Raw::prepare`], which must succeed. Returns the clean take, the warnings and the report.
    pub(crate) fn prepared(&self, options: &str) -> (Take, String, serde_json::Value) {
        let report = self.path("report");
        let output = self.prepare(&format!("{options} --report {}", report.display()));
        assert!(output.status.success(), "{}", stderr(&output));
        let take = read(&self.path("clean.csv"), Some(&truth().labels), Missing::Leave).unwrap();
        let json = serde_json::from_slice(&std::fs::read(report.join("report.json")).unwrap()).unwrap();
        (take, stderr(&output), json)
    }
}

/// By how many millimetres a marker is off in a frame.
pub(crate) fn off(found: &Take, truth: &Take, marker: usize, frame: usize) -> f64 {
    let i = frame * truth.labels.len() + marker;
    let pairs = found.positions[i].iter().zip(&truth.positions[i]);
    10.0 * pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
