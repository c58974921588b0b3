//! `rhytid render`

mod marks;
mod pictures;

use crate::args::{Background, Show, StageChoice};
use crate::progress::Ui;
use crate::{args, inputs, output};
use pictures::{Evaluated, Pictures};
use rhytid::formats::export::OutputStage;
use rhytid::formats::refuse_inputs;
use rhytid::playback::{Playback, PlaybackOptions, Selection};
use rhytid::render::{Moving, MovingFormat, Picture, Sheet};
use rhytid::{AtomicFile, DeviceInfo, Error, Progress, Result, human, rig_file};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where a frame's number goes in a file's name.
const FRAME: &str = "{frame}";
const ON_A_SHEET: [u32; 2] = [300, 400];
const ALONE: [u32; 2] = [720, 960];
/// Frames whose large scale is kept until their detail is there.
const BATCH: usize = 16;

/// What pictures came to.
pub(super) struct Drawn {
    pub pictures: usize,
    /// The device that evaluated.
    pub device: DeviceInfo,
    /// What drew, for people.
    pub draws: String,
    /// From the upload of the rig to the last file, and of that what drawing took.
    pub time: Duration,
    pub drawing: Duration,
    /// Of all files.
    pub bytes: u64,
}

/// Draws and says what was done.
///
/// # Errors
/// As [`draw`].
pub(super) fn run(args: &args::Render, ui: &Ui) -> Result<()> {
    let done = draw(args, ui)?;
    if ui.is_quiet() {
        return Ok(());
    }
    output::say(&format!(
        "{}: {} evaluated on {} ({}) and drawn on {} in {}, of these {} drawing; {} a second, {}",
        args.output.display(),
        human::counted(done.pictures, "picture"),
        done.device.id(),
        done.device.name,
        done.draws,
        human::duration(done.time),
        human::duration(done.drawing),
        human::number((done.pictures as f64 / done.time.as_secs_f64() * 10.0).round() / 10.0),
        human::bytes(done.bytes)
    ))
}

/// What is written.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sheet,
    Each,
    Moving(MovingFormat),
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy();
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match (extension.as_deref(), extension.as_deref().and_then(MovingFormat::by_extension)) {
            (Some("png"), _) if name.contains(FRAME) => Ok(Self::Each),
            (Some("png"), _) => Ok(Self::Sheet),
            (_, Some(_)) if name.contains(FRAME) => {
                Err(Error::input(format!("{name}: {FRAME} is for .png, one picture a file; leave it out")))
            }
            (_, Some(format)) => Ok(Self::Moving(format)),
            (Some("mp4"), None) => Err(Error::input(format!(
                "{name}: this build writes no films (the feature film is off); expected .webp or .apng"
            ))),
            _ => Err(Error::input(format!(
                "{name}: expected .png for a sheet, or for a picture of each frame with {FRAME} in the name; or .mp4, .webp or .apng, \
                 which move"
            ))),
        }
    }
}

/// From a rig file and a take to pictures.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading and writing; [`Error::Device`]; [`Error::Cancelled`].
pub(super) fn draw(args: &args::Render, ui: &Ui) -> Result<Drawn> {
    let kind = Kind::of(&args.output)?;
    if args.stage != StageChoice::Full && args.show.contains(&Show::Detail) {
        return Err(Error::input("--show detail is for --stage full: the others have no detail"));
    }
    let format = if let Kind::Moving(format) = kind { Some(format) } else { None };
    if format.is_some_and(|format| !format.has_opacity()) && args.background == Some(Background([0; 4])) {
        let film = args.output.display();
        return Err(Error::input(format!(
            "--background none: {film} would be a film, which has no transparency; write .webp, .apng or pictures instead"
        )));
    }
    if args.vertex.is_none() && args.show.contains(&Show::Influences) {
        return Err(Error::input("--show influences: say with --vertex N of which vertex"));
    }
    inputs::rig_and_take(&args.rig, &args.take, "rhytid render RIG TAKE -o OUT.png")?;
    let device = inputs::named_device(&args.device)?;
    let mut rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    if args.stage == StageChoice::Shell {
        rig = rig.shell();
    }
    if let Some(vertex) = args.vertex.filter(|vertex| *vertex >= rig.vertices()) {
        let last = rig.vertices() - 1;
        return Err(Error::input(format!("--vertex {vertex}: the rig's vertices are 0 to {last}")));
    }
    let setup = (args.setup.as_deref(), args.elsewhere.reach());
    let take = inputs::take(&args.take, &rig, args.missing, setup, &args.space, ui)?;
    let range = args.frames.within(take.frames())?;
    // The camera goes around one frame in as many steps as there are to be pictures.
    let steps = if args.turntable && range.len() == 1 { args.count as usize } else { 1 };
    let frames: Vec<usize> = match kind {
        Kind::Sheet => spread(range.start, range.len(), args.count as usize),
        Kind::Each | Kind::Moving(_) => range.collect(),
    };
    let name = args.output.to_string_lossy();
    let files: Vec<PathBuf> = match kind {
        Kind::Each if steps > 1 => (0..steps).map(|step| numbered(&name, step)).collect(),
        Kind::Each => frames.iter().map(|&frame| numbered(&name, frame)).collect(),
        Kind::Sheet | Kind::Moving(_) => vec![args.output.clone()],
    };
    let outputs: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    refuse_inputs(&outputs, [&*args.rig, &*args.take].into_iter().chain(args.setup.as_deref()))?;
    let mut whole = AtomicFile::create(outputs[0])?;

    let size = args.size.unwrap_or(if kind == Kind::Sheet { ON_A_SHEET } else { ALONE });
    let mut pictures = Pictures::new(args, &rig, size)?;
    let count = frames.len() * steps;
    let mut sheet = match kind {
        Kind::Sheet => Some(Sheet::new(count as u32, pictures.size(), &pictures.legends())?),
        Kind::Each | Kind::Moving(_) => None,
    };
    let mut moving = match format {
        Some(format) => {
            format.check(pictures.size(), &args.output)?;
            let moving = Moving::new(format, &mut whole, pictures.size(), count as u32, take.rate());
            Some(moving.map_err(Error::io(&args.output))?)
        }
        None => None,
    };
    let devices = inputs::devices(device, ui)?;
    let mut playback = Playback::new(&rig, &devices, frames.len())?;
    let (start, mut drawing, mut bytes, mut done) = (Instant::now(), Duration::ZERO, 0, 0);
    let mut picture = |frame: &Evaluated<'_>| -> Result<()> {
        let begin = Instant::now();
        let turned = if args.turntable { 360.0 * done as f32 / count as f32 } else { 0.0 };
        let picture = pictures.draw(frame, turned)?;
        drawing += begin.elapsed();
        if let Some(sheet) = &mut sheet {
            let frame = frames[done / steps];
            sheet.add(&picture, &format!("{frame}   {:.2} s", take.times[frame]));
        } else if let Some(moving) = &mut moving {
            moving.add(&picture).map_err(Error::io(&args.output))?;
        } else {
            bytes += write(AtomicFile::create(outputs[done])?, &picture)?;
        }
        done += 1;
        ui.step("render", done as u64, count as u64)
    };
    ui.report("render", 0, count as u64);
    let wanted = PlaybackOptions {
        stage: args.stage.into(),
        sigma: args.show.contains(&Show::Sigma),
        fade_detail: args.fade_detail,
        detail: args.detail,
        ..PlaybackOptions::default()
    };
    let large_scale =
        PlaybackOptions { stage: OutputStage::LargeScale, normals: false, ..PlaybackOptions::default() };
    let has_detail = args.show.contains(&Show::Detail);
    for frames in frames.chunks(if has_detail { BATCH } else { usize::MAX }) {
        let (take, inner) = (take.pick(frames), 0..frames.len());
        let selection = Selection { rate: take.rate(), take, inner, first: 0 };
        let mut smooth = Vec::new();
        if has_detail {
            playback.play(&selection, large_scale, ui, |frame| {
                smooth.extend_from_slice(frame.positions);
                Ok(())
            })?;
        }
        let mut smooth = smooth.chunks_exact(3 * rig.vertices());
        playback.play(&selection, wanted, ui, |frame| {
            let frame = Evaluated {
                positions: frame.positions,
                normals: frame.normals.unwrap_or_default(),
                sigma: frame.sigma.unwrap_or_default(),
                large_scale: smooth.next().unwrap_or_default(),
            };
            (0..steps).try_for_each(|_| picture(&frame))
        })?;
    }
    moving.map_or(Ok(()), Moving::finish).map_err(Error::io(&args.output))?;
    match (kind, sheet) {
        (Kind::Moving(_), _) => {
            whole.finish()?;
            bytes = std::fs::metadata(&args.output).map_err(Error::io(&args.output))?.len();
        }
        (_, Some(sheet)) => bytes = write(whole, &sheet.into_picture())?,
        (_, None) => {}
    }
    let device = playback.device().clone();
    Ok(Drawn { pictures: count, device, draws: pictures.device, time: start.elapsed(), drawing, bytes })
}

fn numbered(name: &str, number: usize) -> PathBuf {
    PathBuf::from(name.replace(FRAME, &format!("{number:05}")))
}

/// `count` of `frames` frames from `first` on, the first and the last among them.
fn spread(first: usize, frames: usize, count: usize) -> Vec<usize> {
    let count = count.min(frames);
    (0..count).map(|i| first + (i * (frames - 1) + (count - 1) / 2) / (count - 1).max(1)).collect()
}

fn write(mut file: AtomicFile, picture: &Picture) -> Result<u64> {
    let bytes = picture.png()?;
    file.write_all(&bytes).map_err(file.error())?;
    file.finish()?;
    Ok(bytes.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_evenly_from_the_first_to_the_last() {
        assert_eq!(spread(10, 101, 5), [10, 35, 60, 85, 110]);
        assert_eq!(spread(3, 4, 12), [3, 4, 5, 6]);
        assert_eq!(spread(7, 1, 12), [7]);
        assert_eq!(spread(0, 10, 1), [0]);
    }
}
