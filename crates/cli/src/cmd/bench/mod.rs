//! `rhytid bench`

mod bytes;
mod growth;
mod measure;
mod plot;

use crate::guard::guard;
use crate::progress::Ui;
use crate::{args, output};
use bytes::Stored;
use growth::{Point, What};
use measure::{Chapter, Measured, Whole};
use rhytid::conformance::{COMMIT, Memory, StageTime};
use rhytid::core::human;
use rhytid::core::{AtomicFile, DeviceInfo, Method, rig_file};
use rhytid::devices::{devices, find_device};
use rhytid::formats::refuse_inputs;
use rhytid::{BasisStorage, Error, Progress, Result, Rig, UploadOptions};
use rhytid_demo::{Size, sized_rig};
use serde::Serialize;
use std::io::Write;

/// Milliseconds of the chapter's GeForce 8800 GTX for a face of 530,000 vertices: large scale, its normals,
/// fine scale, normals.
const CHAPTER: [f64; 4] = [4.0, 5.0, 13.0, 5.0];

/// The time of each stage for one frame at a time; empty where the device does not time stages.
///
/// # Errors
/// The device's.
pub(super) fn stage_times(info: &DeviceInfo, rig: &Rig, memory: &Memory) -> Result<Vec<StageTime>> {
    let options = UploadOptions::frames(1);
    let (_, stages, _) =
        measure::measure(info, rig, None, options, Stored::new(rig, options).stages, memory)?;
    let time =
        |stage: Measured| StageTime { stage: stage.stage, seconds: stage.ms / 1e3, bytes: stage.bytes };
    Ok(stages.into_iter().map(time).collect())
}

#[derive(Serialize)]
struct BenchReport {
    version: &'static str,
    commit: &'static str,
    threads: usize,
    vertices: usize,
    handles: usize,
    strain_edges: usize,
    influences: usize,
    centers: usize,
    storage: &'static str,
    frames: usize,
    /// What a frame moves with each storage, the measured one among them.
    bytes: [Stored; BasisStorage::ALL.len()],
    devices: Vec<DeviceTimes>,
}

#[derive(Serialize)]
struct DeviceTimes {
    device: String,
    name: String,
    driver: String,
    /// Why there are no times.
    error: Option<String>,
    whole: Option<Whole>,
    stages: Vec<Measured>,
    /// Only for a generated rig of the learned method.
    chapter: Option<Chapter>,
    /// Empty unless growth was requested.
    growth: Vec<Point>,
}

/// Times every stage and whole frames on the devices, and compares them with the time that their bytes take.
///
/// As reading a rig's; [`Error::Device`] if the requested device is absent or fails; [`Error::Cancelled`].
pub(super) fn run(args: &args::Bench, ui: &Ui) -> Result<()> {
    let devices = match args.device.as_str() {
        "all" => devices(guard()).devices,
        id => vec![find_device(id, guard())?],
    };
    // An absent folder is an error now, before minutes of measuring.
    if let Some(plot) = &args.plot {
        refuse_inputs(&[plot], args.rig.as_deref())?;
    }
    let chart = args.plot.as_deref().map(AtomicFile::create).transpose()?;
    let size = Size { vertices: args.vertices as usize, ..Size::CHAPTER };
    let method = Method::from(args.method);
    let (rig, chapter) = match &args.rig {
        Some(path) => (rig_file::read(path)?, None),
        None => {
            let make = |method| ui.timed("make a rig", || sized_rig(size, method)).0;
            (make(method), (method != Method::Chapter).then(|| make(Method::Chapter)))
        }
    };
    let memory = Memory::new();
    let options = UploadOptions { max_frames: args.frames as usize, basis: args.storage.into() };
    let stored = |basis| Stored::new(&rig, UploadOptions { basis, ..options });
    let mut report = BenchReport {
        version: env!("CARGO_PKG_VERSION"),
        commit: COMMIT,
        threads: rayon::current_num_threads(),
        vertices: rig.vertices(),
        handles: rig.handles().len(),
        strain_edges: rig.handles().strain_edges.len(),
        influences: rig.influences().per_vertex(),
        centers: rig.centers(),
        storage: options.basis.name(),
        frames: options.max_frames,
        bytes: ui.timed("count the bytes", || BasisStorage::ALL.map(stored)).0,
        devices: Vec::new(),
    };
    for info in &devices {
        if ui.cancelled() {
            return Err(Error::Cancelled);
        }
        let times =
            device_times(info, &rig, chapter.as_ref(), options, report.bytes_of_stages(), &memory, ui);
        match times {
            Err(error) if args.device != "all" => return Err(error),
            times => report.devices.push(times.unwrap_or_else(|error| DeviceTimes::failed(info, &error))),
        }
    }
    if args.growth {
        drop((rig, chapter));
        let measured = report.devices.iter().zip(&devices).filter(|(times, _)| times.whole.is_some());
        let devices: Vec<DeviceInfo> = measured.map(|(_, info)| info.clone()).collect();
        let points = growth::measure(&devices, size, method, options, ui)?;
        let measured = report.devices.iter_mut().filter(|times| times.whole.is_some());
        measured.zip(points).for_each(|(times, points)| times.growth = points);
    }
    ui.clear();
    if let Some(mut file) = chart {
        file.write_all(plot::svg(&report)?.as_bytes()).map_err(file.error())?;
        file.finish()?;
    }
    if args.json.wanted { output::json(&report) } else { output::say(&report.to_terminal()) }
}

fn device_times(
    info: &DeviceInfo,
    rig: &Rig,
    chapter: Option<&Rig>,
    options: UploadOptions,
    bytes: [f64; 6],
    memory: &Memory,
    ui: &Ui,
) -> Result<DeviceTimes> {
    ui.report("measure", 0, 1);
    let (whole, stages, chapter) = measure::measure(info, rig, chapter, options, bytes, memory)?;
    Ok(DeviceTimes { error: None, whole: Some(whole), stages, chapter, ..DeviceTimes::new(info) })
}

impl DeviceTimes {
    fn new(info: &DeviceInfo) -> Self {
        let (name, driver) = (info.name.clone(), info.driver.clone());
        Self {
            device: info.id(),
            name,
            driver,
            error: None,
            whole: None,
            stages: Vec::new(),
            chapter: None,
            growth: Vec::new(),
        }
    }

    fn failed(info: &DeviceInfo, error: &Error) -> Self {
        Self { error: Some(error.to_string()), ..Self::new(info) }
    }
}

impl BenchReport {
    /// What the stages move with the measured storage.
    fn bytes_of_stages(&self) -> [f64; 6] {
        let measured = self.bytes.iter().find(|stored| stored.storage == self.storage);
        measured.map_or([0.0; 6], |stored| stored.stages)
    }

    fn to_terminal(&self) -> String {
        let batch = if self.frames == 1 {
            "one frame".to_owned()
        } else {
            format!("batches of {}, per frame", human::count(self.frames))
        };
        let mut text = format!(
            "{} vertices, {} handles, {} strain edges, {} centres, {} influences; basis in {}; {batch}\n",
            human::count(self.vertices),
            self.handles,
            self.strain_edges,
            self.centers,
            self.influences,
            self.storage,
        );
        for device in &self.devices {
            text += &format!("\n{} ({}; {})\n", device.device, device.name, device.driver);
            text += &device.to_terminal(self.threads);
        }
        let [large_scale, its_normals, fine_scale, normals] = CHAPTER;
        text + "\n"
            + &bytes::table(&self.bytes)
            + &format!(
                "\n\nThe chapter's GeForce 8800 GTX (2010; 530,000 vertices): {large_scale} ms large scale, {its_normals} its normals, \
             {fine_scale} detail and positions, {normals} normals; 30 fps, drawing included."
            )
    }
}

impl DeviceTimes {
    fn to_terminal(&self, threads: usize) -> String {
        if let Some(error) = &self.error {
            return format!("  {error}\n");
        }
        let heading = ["  stage", "ms", "MB", "GB/s", "of the memory"].map(str::to_owned);
        let row = |name: &str, ms: f64, bytes: f64, share: Option<f64>| {
            [
                format!("  {name}"),
                format!("{ms:.2}"),
                format!("{:.1}", bytes / 1e6),
                format!("{:.1}", bytes / ms / 1e6),
                share.map_or("–".into(), |share| format!("{:.0} %", 100.0 * share)),
            ]
        };
        let stages = self.stages.iter().map(|s| row(s.stage, s.ms, s.bytes, s.share_of_bandwidth));
        let mut rows: Vec<_> = std::iter::once(heading).chain(stages).collect();
        let mut text = String::new();
        if let Some(whole) = &self.whole {
            rows.push(row("whole frame", whole.ms, whole.bytes, whole.share_of_bandwidth));
            text = format!(
                "  {:.0} frames a second; memory, in turns with them, at {:.1} GB/s with {threads} threads\n",
                whole.fps, whole.read_bandwidth_gb_s
            );
        }
        if let Some(Chapter { ms, ratio }) = self.chapter {
            text += &format!(
                "  {ratio:.2} times as long as the chapter's method, which in turns with it takes {ms:.2} ms\n"
            );
        }
        text.insert_str(0, &(output::table(&rows) + "\n"));
        for what in What::ALL {
            let of_it = || self.growth.iter().filter(|point| point.what == what);
            if of_it().next().is_some() {
                let heading = [format!("\n  {}", what.name()), "ms per frame".into()];
                let row = |point: &Point| {
                    let ms = point.ms.map_or("–".into(), |ms| format!("{ms:.3}"));
                    [format!("  {}", human::count(point.size)), ms]
                };
                let rows: Vec<_> = std::iter::once(heading).chain(of_it().map(row)).collect();
                text += &(output::table(&rows) + "\n");
            }
        }
        text
    }
}
