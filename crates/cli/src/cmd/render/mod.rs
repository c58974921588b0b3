//! `rhytid render`

mod frames;
mod images;
mod pictures;
mod shape;
mod skin;
mod truth;

use crate::args::{Background, BeforeChoice, Show, StageChoice};
use crate::output::{FRAME, numbered};
use crate::progress::Ui;
use crate::{args, inputs, output};
use frames::{Before, Evaluated, Frames, Wanted};
use pictures::Pictures;
use rhytid::core::{AtomicFile, Backend, ChannelKind, DeviceInfo, human, rig_file};
use rhytid::devices::wgpu::Wgpu;
use rhytid::formats::export::{ChannelChoice, Recipe};
use rhytid::formats::{FileKind, refuse_inputs};
use rhytid::playback::{EditedTake, Layers, Selection, scale_wrinkles};
use rhytid::render::{AnimatedImage, AnimatedImageFormat, Picture, Sheet, hide_parts};
use rhytid::{Error, Progress, Result, Rig};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use truth::Truth;

const ON_A_SHEET: [u32; 2] = [300, 400];
const ALONE: [u32; 2] = [720, 960];

/// The result of drawing.
pub(super) struct Drawn {
    pub pictures: usize,
    /// The device that evaluated and the device that drew.
    pub devices: [DeviceInfo; 2],
    /// From the upload of the rig to the last file.
    pub time: Duration,
    /// The time's parts: evaluation, lighting skin and drawing.
    pub parts: Vec<(&'static str, Duration)>,
    /// Size of all files.
    pub bytes: u64,
}

impl Drawn {
    /// The device that drew, for people.
    pub(super) fn draws(&self) -> String {
        let [_, device] = &self.devices;
        format!("{} ({})", device.id(), device.name)
    }
}

/// Draws and says what was done.
///
/// # Errors
/// As [`draw`].
pub(super) fn run(args: &args::Render, ui: &Ui) -> Result<()> {
    let done = draw(args, ui)?;
    let [evaluates, draws] = &done.devices;
    let on = match evaluates == draws {
        true => String::new(),
        false => format!(" on {} ({})", evaluates.id(), evaluates.name),
    };
    let part = |(what, time): &(&str, Duration)| format!("{} {what}", human::duration(*time));
    let parts = done.parts.iter().map(part).collect::<Vec<_>>().join(", ");
    let parts = if ui.is_verbose() { format!(": {parts}") } else { String::new() };
    let summary = serde_json::json!({
        "file": args.output,
        "bytes": done.bytes,
        "pictures": done.pictures,
        "evaluated_on": evaluates.id(),
        "drawn_on": draws.id(),
        "seconds": done.time.as_secs_f64(),
    });
    output::done(args.json, ui, &summary, || {
        format!(
            "{}: {} evaluated{on} and drawn on {} in {}{parts}; {} a second, {}",
            args.output.display(),
            human::counted(done.pictures, "picture"),
            done.draws(),
            human::duration(done.time),
            human::number((done.pictures as f64 / done.time.as_secs_f64() * 10.0).round() / 10.0),
            human::bytes(done.bytes)
        )
    })
}

/// The kind of output.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sheet,
    Each,
    AnimatedImage(AnimatedImageFormat),
}

impl Kind {
    fn from_extension(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy();
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match (extension.as_deref(), extension.as_deref().and_then(AnimatedImageFormat::by_extension)) {
            (Some("png"), _) if name.contains(FRAME) => Ok(Self::Each),
            (Some("png"), _) => Ok(Self::Sheet),
            (_, Some(_)) if name.contains(FRAME) => {
                Err(Error::conflict(format!("{name}: {FRAME} is for .png, one picture a file; leave it out")))
            }
            (_, Some(format)) => Ok(Self::AnimatedImage(format)),
            (Some("mp4"), None) => Err(Error::unsupported_format(format!(
                "{name}: this build writes no films (the feature film is off); expected .webp"
            ))),
            _ => Err(Error::unsupported_format(format!(
                "{name}: expected .png for a sheet, or for a picture of each frame with {FRAME} in the name; or .mp4 or .webp, \
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
    let kind = Kind::from_extension(&args.output)?;
    check_options(args, kind)?;
    inputs::rig_and_take(&args.rig, &args.take, "rhytid render RIG TAKE -o OUT.png")?;
    let (draws, named) = frames::devices(args)?;
    let Loaded { rig, before, take, rate, first, layers, truth, mut frames } = load(args, kind, ui)?;
    // The camera goes around a single frame in as many steps as there are pictures.
    let steps = if args.turntable && frames.len() == 1 { args.count as usize } else { 1 };
    if kind == Kind::Sheet {
        frames = spread(frames.len(), args.count as usize).map(|i| frames[i]).collect();
    }
    let files = files(args, kind, frames.iter().map(|frame| first + frame), steps);
    check_files(args, &files)?;
    let mut whole = AtomicFile::create(&files[0])?;

    let size = args.size.unwrap_or(if kind == Kind::Sheet { ON_A_SHEET } else { ALONE });
    let wgpu = Wgpu::open(&draws)?;
    let mut pictures = Pictures::new(args, &rig, before.as_ref(), &wgpu, size)?;
    let count = frames.len() * steps;
    let to = To::new(kind, &pictures, count as u32, rate, &mut whole, &args.output)?;
    let mut output = Output { files: &files, to, done: 0, bytes: 0 };
    let wanted = wanted(args, layers, before.as_ref(), truth);
    let mut source = Frames::new(&rig, frames.len(), wanted, &wgpu, &draws, named, ui)?;
    let (start, mut drawing) = (Instant::now(), Duration::ZERO);
    let mut picture = |frame: &Evaluated<'_>| -> Result<()> {
        let begin = Instant::now();
        let turned = if args.turntable { 360.0 * output.done as f32 / count as f32 } else { 0.0 };
        let picture = pictures.draw(frame, turned)?;
        drawing += begin.elapsed();
        let frame = frames[output.done / steps];
        output.add(&picture, &format!("frame {}, {:.2} s", first + frame, take.take.times[frame]))?;
        ui.step("render", output.done as u64, count as u64)
    };
    ui.report("render", 0, count as u64);
    source.each(&take, &frames, ui, |frame| (0..steps).try_for_each(|_| picture(frame)))?;
    let bytes = match output.to {
        To::Sheet(sheet) => write(whole, &sheet.into_picture())?,
        To::AnimatedImage(moving) => {
            moving.finish().map_err(Error::io(&args.output))?;
            whole.finish()?;
            std::fs::metadata(&args.output).map_err(Error::io(&args.output))?.len()
        }
        To::Each => output.bytes,
    };
    let mut parts = vec![("evaluation", source.evaluation)];
    parts.extend(pictures.lighting().map(|lighting| ("skin", lighting)));
    parts.push(("drawing", drawing.saturating_sub(pictures.lighting().unwrap_or_default())));
    Ok(Drawn {
        pictures: count,
        devices: [source.device().clone(), draws],
        time: start.elapsed(),
        parts,
        bytes,
    })
}

/// An option that has no effect beside another one, or that needs a missing one, is a mistake.
fn check_options(args: &args::Render, kind: Kind) -> Result<()> {
    args.fine_detail.check()?;
    if args.fine_detail.stage != StageChoice::Full && args.show.contains(&Show::Detail) {
        return Err(Error::conflict("--show detail is for --stage full: the others have no detail"));
    }
    let is_opaque = matches!(kind, Kind::AnimatedImage(format) if !format.has_opacity());
    if is_opaque && args.background == Some(Background([0; 4])) {
        let film = args.output.display();
        return Err(Error::conflict(format!(
            "--background none: {film} would be a film, which has no transparency; write .webp or pictures instead"
        )));
    }
    if args.vertex.is_none() && args.show.contains(&Show::Influences) {
        return Err(Error::conflict("--show influences: say with --vertex N of which vertex"));
    }
    if args.compare.is_none() && args.show.contains(&Show::Error) {
        return Err(Error::conflict("--show error: say with --compare TRUTH how far from what"));
    }
    Ok(())
}

/// Everything to draw.
struct Loaded {
    rig: Rig,
    before: Option<Before>,
    /// Of a film or with `--fps`, the requested frames alone, and evenly spaced.
    take: EditedTake,
    /// Frames per second.
    rate: f64,
    /// The number of the first frame of `take`.
    first: usize,
    /// The effects of edits beyond the take's handles, and the edited take with all of its frames.
    layers: Option<(Layers, EditedTake)>,
    truth: Option<Truth>,
    /// The requested frames of `take`, rising; with a truth, only those that it has.
    frames: Vec<usize>,
}

/// Reads what is drawn.
fn load(args: &args::Render, kind: Kind, ui: &Ui) -> Result<Loaded> {
    let mut rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let before = args.before.as_ref().map(|before| before_the_result(before, args, &rig, ui)).transpose()?;
    if args.fine_detail.stage == StageChoice::Shell {
        rig = rig.shell()?;
    }
    let gains = inputs::gains(&args.fine_detail, &args.reading)?;
    rig = scale_wrinkles(rig.scale_wrinkles(|_| args.fine_detail.gain)?, &gains.0)?;
    if let Some(vertex) = args.vertex.filter(|vertex| *vertex >= rig.vertices()) {
        let last = rig.vertices() - 1;
        return Err(Error::out_of_range(format!("--vertex {vertex}: the rig's vertices are 0 to {last}")));
    }
    if let Some(vertex) = args.hide.iter().find(|vertex| **vertex >= rig.vertices()) {
        let last = rig.vertices() - 1;
        return Err(Error::out_of_range(format!("--hide {vertex}: the rig's vertices are 0 to {last}")));
    }
    let take = inputs::take(&args.take, &rig, &args.reading, ui)?;
    let inputs::Edited { rig, take, layers } =
        inputs::edited(take, rig, args.edit.as_deref(), &args.reading)?;
    let layers = layers.map(|layers| (layers, take.clone()));
    let rig = hide_parts(rig, &args.hide).map_err(|_| {
        Error::out_of_range(
            "--hide: nothing would be left; name vertices of the parts that are to be left out",
        )
    })?;
    let range = args.frames.within(take.frames())?;
    let mut truth = None;
    if let Some(path) = &args.compare {
        truth = Some(Truth::open(path, args, &rig, &take.take)?);
    }
    let is_film = matches!(kind, Kind::AnimatedImage(_));
    let rate = take.take.rate();
    let (take, rate, first, frames) = match &truth {
        Some(truth) => (take, rate, 0, truth.within(range)?),
        None if is_film || args.fps.is_some() => {
            let Selection { take, rate, first, .. } = Selection::new(take, range, args.fps, false)?;
            let frames = (0..take.frames()).collect();
            (take, rate, first, frames)
        }
        None => (take, rate, 0, range.collect()),
    };
    Ok(Loaded { rig, before, take, rate, first, layers, truth, frames })
}

/// The files to write: one, or one for each picture.
fn files(args: &args::Render, kind: Kind, frames: impl Iterator<Item = usize>, steps: usize) -> Vec<PathBuf> {
    let name = args.output.to_string_lossy();
    match kind {
        Kind::Each if steps > 1 => (0..steps).map(|step| numbered(&name, step)).collect(),
        Kind::Each => frames.map(|frame| numbered(&name, frame)).collect(),
        Kind::Sheet | Kind::AnimatedImage(_) => vec![args.output.clone()],
    }
}

/// Checks that no output is an input.
fn check_files(args: &args::Render, files: &[PathBuf]) -> Result<()> {
    let outputs: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let also_read = [&args.reading.setup, &args.compare, &args.truth_frames, &args.matcap, &args.texture];
    let also_read = also_read.into_iter().filter_map(Option::as_deref);
    let before_it = args.before.as_ref().and_then(BeforeChoice::rig);
    let edits = inputs::edit_files(args.edit.as_deref())?;
    let also_read = also_read.chain(edits.iter().map(PathBuf::as_path));
    refuse_inputs(&outputs, [&*args.rig, &*args.take].into_iter().chain(also_read).chain(before_it))
}

/// What the options ask of each frame.
fn wanted<'a>(
    args: &args::Render,
    layers: Option<(Layers, EditedTake)>,
    before: Option<&'a Before>,
    truth: Option<Truth>,
) -> Wanted<'a> {
    let mut channels = ChannelChoice::default();
    channels.set(ChannelKind::Sigma, args.show.contains(&Show::Sigma));
    let recipe = Recipe {
        stage: args.fine_detail.stage.into(),
        channels,
        fade_detail: args.fine_detail.fade,
        ..Recipe::default()
    };
    Wanted {
        recipe,
        layers,
        large_scale: args.show.contains(&Show::Detail),
        before,
        truth,
        on_host: args.show.iter().any(|show| show.is_made_on_the_host()),
    }
}

/// The destination of the pictures.
enum To<'a> {
    Sheet(Sheet),
    AnimatedImage(AnimatedImage<&'a mut AtomicFile>),
    /// Each picture is a file.
    Each,
}

impl<'a> To<'a> {
    /// For this number of pictures, `rate` a second. If they form one file, it is `whole` with this `name`.
    fn new(
        kind: Kind,
        pictures: &Pictures<'_>,
        count: u32,
        rate: f64,
        whole: &'a mut AtomicFile,
        name: &Path,
    ) -> Result<Self> {
        Ok(match kind {
            Kind::Sheet => {
                let titles = pictures.titles();
                let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
                Self::Sheet(Sheet::new(count, pictures.size(), &titles, &pictures.legends())?)
            }
            Kind::AnimatedImage(format) => {
                format.check(pictures.size(), name)?;
                let moving = AnimatedImage::new(format, whole, pictures.size(), count, rate);
                Self::AnimatedImage(moving.map_err(Error::io(name))?)
            }
            Kind::Each => Self::Each,
        })
    }
}

/// What has been written.
struct Output<'a> {
    /// One file, or one for each picture.
    files: &'a [PathBuf],
    to: To<'a>,
    /// Pictures so far.
    done: usize,
    /// Size of the pictures that are files of their own.
    bytes: u64,
}

impl Output<'_> {
    /// Adds a picture. On a sheet `words` stand below it.
    fn add(&mut self, picture: &Picture, words: &str) -> Result<()> {
        match &mut self.to {
            To::Sheet(sheet) => sheet.add(picture, words),
            To::AnimatedImage(moving) => moving.add(picture).map_err(Error::io(&self.files[0]))?,
            To::Each => self.bytes += write(AtomicFile::create(&self.files[self.done])?, picture)?,
        }
        self.done += 1;
        Ok(())
    }
}

/// `count` of `frames` frames, the first and the last among them.
fn spread(frames: usize, count: usize) -> impl Iterator<Item = usize> {
    let count = count.min(frames);
    (0..count).map(move |i| (i * (frames - 1) + (count - 1) / 2) / (count - 1).max(1))
}

/// The shape to put beside the result.
fn before_the_result(before: &BeforeChoice, args: &args::Render, rig: &Rig, ui: &Ui) -> Result<Before> {
    let is_later = |stage: StageChoice| stage as usize >= args.fine_detail.stage as usize;
    match before {
        BeforeChoice::Stage(stage) if is_later(*stage) => Err(Error::conflict(format!(
            "--before {}: that is not before the --stage that is shown, expected an earlier one, or another rig",
            before.words()
        ))),
        BeforeChoice::Stage(stage) => Ok(Before {
            rig: (*stage == StageChoice::Shell).then(|| rig.clone().shell()).transpose()?,
            stage: (*stage).into(),
            words: [before.words(), "result".to_owned()],
        }),
        BeforeChoice::Rig(path) => {
            inputs::expect(path, &[FileKind::Rig], "rhytid render RIG TAKE -o OUT.png --before OTHER_RIG")?;
            let other = ui.timed("read the rig to put it beside", || rig_file::read(path)).0?;
            if other.surface().faces != rig.surface().faces {
                return Err(Error::mismatch(format!(
                    "{}: has other faces than {}, expected a rig of the same mesh",
                    path.display(),
                    args.rig.display()
                )));
            }
            let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let rig = if args.fine_detail.stage == StageChoice::Shell { other.shell()? } else { other };
            Ok(Before {
                rig: Some(rig),
                stage: args.fine_detail.stage.into(),
                words: [name(path), name(&args.rig)],
            })
        }
    }
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
        let spread = |frames, count| spread(frames, count).collect::<Vec<_>>();
        assert_eq!(spread(101, 5), [0, 25, 50, 75, 100]);
        assert_eq!(spread(4, 12), [0, 1, 2, 3]);
        assert_eq!(spread(1, 12), [0]);
        assert_eq!(spread(10, 1), [0]);
    }
}
