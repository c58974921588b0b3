//! `rhytid animate`

use crate::evaluator::Evaluator;
use crate::progress::Ui;
use crate::{args, device_choice, frames, human, memory, output};
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig, Stage, UploadOptions, WriteBeside, rig_file};
use rhytid_formats::{export, take};
use std::time::{Duration, Instant};

/// What an animation came to.
pub struct Animated {
    /// Frames written.
    pub frames: usize,
    /// Frames per second of the animation.
    pub rate: f64,
    /// The device that evaluated them.
    pub device: DeviceInfo,
    /// Time from the upload of the rig to the finished file.
    pub time: Duration,
    /// Size of the file.
    pub bytes: u64,
}

/// Animates and says what was done.
///
/// # Errors
/// As [`animate`].
pub fn run(args: &args::Animate, ui: &Ui) -> Result<()> {
    let done = animate(args, ui)?;
    if ui.is_quiet() {
        return Ok(());
    }
    output::say(&format!(
        "{}: {} at {} frames per second, evaluated on {} ({}) in {}, {} frames/s, {}",
        args.output.display(),
        human::counted(done.frames, "frame"),
        human::number(done.rate),
        done.device.id(),
        done.device.name,
        human::duration(done.time),
        human::number((done.frames as f64 / done.time.as_secs_f64() * 10.0).round() / 10.0),
        human::bytes(done.bytes)
    ))
}

/// From a rig file and a take to an animated file.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading and writing; [`Error::Device`]; [`Error::Cancelled`].
pub fn animate(args: &args::Animate, ui: &Ui) -> Result<Animated> {
    // Known before the long work rather than after it: whether the file can be written.
    export::Format::of(&args.output)?;
    drop(WriteBeside::create(&args.output)?);
    let named = device_choice::named(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let take =
        ui.timed("read the take", || take::read(&args.take, Some(&rig.labels), args.missing.into())).0?;
    let selection = frames::select(take, args.frames, args.fps)?;
    let handles = selection.take.handle_positions(&rig.labels)?;
    let frames = selection.take.frames();

    let devices = match named {
        Some(device) => vec![device],
        None => device_choice::auto(ui)?,
    };
    let start = Instant::now();
    let batch = memory::batch_frames(&rig).min(frames);
    let options = UploadOptions::frames(batch);
    let mut evaluator = Evaluator::new(&rig, options, &devices, &rhytid_backends::open)?;
    let triangle_corners = rig.faces.triangle_corners(&rig.triangles);
    let triangle_corners = triangle_corners
        .ok_or_else(|| Error::Internal("a checked rig has other triangles than faces".into()))?;
    let scene = export::Scene {
        name: &rig.name,
        rest: &rig.rest,
        rest_normals: &rest_normals(&rig, &mut evaluator)?,
        faces: &rig.faces,
        triangle_corners: &triangle_corners,
        uvs: rig.uvs.as_ref(),
        metres_per_unit: rig.metres_per_unit,
        up_axis: rig.up_axis,
        frames,
        rate: selection.rate,
        first_time_code: selection.first as f64,
    };
    let mut exporter = export::create(&args.output, &scene)?;
    let handles = handles.chunks(batch * rig.handles.len() * 3);
    play(handles, &mut evaluator, args.stage.stages(), rig.vertices(), frames, exporter.as_mut(), ui)?;
    exporter.finish()?;
    let time = start.elapsed();
    let device = evaluator.device().clone();
    let bytes = std::fs::metadata(&args.output).map_err(Error::io(&args.output))?.len();
    Ok(Animated { frames, rate: selection.rate, device, time, bytes })
}

/// The normals of the rest mesh: those of the large scale where no handle moves.
fn rest_normals(rig: &Rig, evaluator: &mut Evaluator<'_>) -> Result<Vec<[f32; 3]>> {
    let handles: Vec<f32> = rig.handles.iter().flat_map(|&v| rig.rest[v as usize]).collect();
    let mut results = [Vec::new()];
    evaluator.evaluate(&handles, [Stage::LargeScaleNormals], &mut results)?;
    let [normals] = results;
    Ok(normals.as_chunks().0.to_vec())
}

/// Evaluates `batches` of handle positions one after the other and hands every frame to the exporter.
fn play<'a>(
    batches: impl Iterator<Item = &'a [f32]>,
    evaluator: &mut Evaluator<'_>,
    stages: [Stage; 2],
    vertices: usize,
    frames: usize,
    exporter: &mut dyn export::Exporter,
    ui: &Ui,
) -> Result<()> {
    let mut results = [Vec::new(), Vec::new()];
    let mut done = 0;
    ui.report("animate", 0, frames as u64);
    for handles in batches {
        evaluator.evaluate(handles, stages, &mut results)?;
        let [positions, normals] = &results;
        let frame = vertices * 3;
        for (positions, normals) in positions.chunks_exact(frame).zip(normals.chunks_exact(frame)) {
            if ui.cancelled() {
                return Err(Error::Cancelled);
            }
            exporter.frame(positions, normals)?;
            done += 1;
            ui.report("animate", done, frames as u64);
        }
    }
    if ui.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}
