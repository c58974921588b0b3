//! `rhytid animate`

mod clips;
mod folder;
mod masks;
pub(crate) mod options;
mod report;
mod warnings;

use super::listen;
use crate::args::FramesChoice;
use crate::progress::Ui;
use crate::{args, exit_code, inputs, output};
use masks::Masks;
use rhytid::capture;
use rhytid::core::{ChannelKind, DeviceInfo, Mesh, rig_file};
use rhytid::evaluate::{Regions, StrainCurves};
use rhytid::formats::animation::Format;
use rhytid::formats::export::{Deviation, Recipe, ShapeSet, Written};
use rhytid::formats::mesh;
use rhytid::playback::{Layers, Performance, check_export, read_shape_set};
use rhytid::{Result, Rig, Take};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The result of an animation.
pub(super) struct Animated {
    /// What was written of each take.
    pub clips: Vec<ClipOf>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The device that evaluated the frames.
    pub device: DeviceInfo,
    /// Time from the upload of the rig to the finished file.
    pub time: Duration,
    /// The file.
    pub written: Written,
}

/// What was written of one take.
pub(super) struct ClipOf {
    /// The take's name; none for what came over the network.
    pub name: String,
    /// Frames written.
    pub frames: usize,
    /// Frames per second of the animation.
    pub rate: f64,
}

impl Animated {
    /// The frames of all takes.
    pub(super) fn frames(&self) -> usize {
        self.clips.iter().map(|clip| clip.frames).sum()
    }

    /// The largest deviation of all takes, and the RMS over all frames.
    fn error(&self) -> Option<Deviation> {
        let errors = &self.written.errors;
        let worst = errors.iter().max_by(|a, b| a.worst.total_cmp(&b.worst))?;
        let of_clip = |(clip, error): (&ClipOf, &Deviation)| clip.frames as f64 * error.rms * error.rms;
        let squares: f64 = self.clips.iter().zip(errors).map(of_clip).sum();
        Some(Deviation { rms: (squares / self.frames() as f64).sqrt(), ..*worst })
    }
}

/// Animates and says what was done. Returns the exit code.
///
/// # Errors
/// As [`animate`] and [`folder::run`].
pub(super) fn run(args: &args::Animate, ui: &Ui) -> Result<u8> {
    if folder::is_for(&args.output) {
        return folder::run(args, ui);
    }
    let done = animate(args, ui)?;
    output::done(args.json, ui, &report::Summary::new(args, &done), || {
        report::words(args, &done) + &report::next(args, &done)
    })?;
    Ok(exit_code::DONE)
}

/// From a rig file and a take to an animated file.
///
/// # Errors
/// `Input` and `Io` from reading and writing; `Device`; `Cancelled`.
pub(super) fn animate(args: &args::Animate, ui: &Ui) -> Result<Animated> {
    // An unknown format is an error before the long work.
    let format = Format::from_extension(&args.output)?;
    options::check(args, format)?;
    clips::check(args)?;
    let count = listen::count(args)?;
    options::check_files(args)?;
    let device = inputs::named_device(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let layers = inputs::layers(args.edit.as_deref(), &rig, &args.reading)?;
    let recipe = options::recipe(args, rig_file::hash(&args.rig)?, format, layers.as_ref())?;
    let onto = onto(args, &rig, &recipe, ui)?;
    // An error here must come before a recording, which would be lost.
    Performance::check(&recipe, &rig).map_err(|error| error.in_file(args.rig.display()))?;
    masks::check(args, &rig, &recipe)?;
    let regions = args.strain_curves.as_ref().map(|_| regions(args, &rig)).transpose()?;
    let prepared = Prepared { rig, layers, recipe, onto, regions, device, format };
    let Some(frames) = count else {
        let [take] = &args.takes[..] else { return clips::make(args, prepared, ui) };
        let take = inputs::take(take, &prepared.rig, &args.reading, ui)?;
        return make(args, prepared, take, ui);
    };
    let options =
        options::export_options(args, prepared.rig.surface().metres_per_unit, prepared.onto.clone());
    check_export(&prepared.rig, &prepared.recipe, frames, &args.output, &options)?;
    let (mut take, kept) = listen::take(args, &prepared.rig, frames, ui)?;
    let softened = if args.reading.soft_markers { capture::soften(&mut take).map(|_| ()) } else { Ok(()) };
    let made = softened.and_then(|()| make(args, prepared, take, ui));
    match made {
        Ok(_) => kept.remove(),
        Err(_) => ui.line(&format!("note: {}", kept.advice())),
    }
    made
}

/// Everything that is known before the take.
struct Prepared {
    rig: Rig,
    layers: Option<Layers>,
    /// The recipe of the first take.
    recipe: Recipe,
    /// The shapes whose weights are to be found.
    onto: Option<ShapeSet>,
    /// The regions of the strain curves.
    regions: Option<Regions>,
    /// The device that was named.
    device: Option<DeviceInfo>,
    format: Format,
}

/// The shapes of `--onto`.
pub(crate) fn onto(args: &args::Animate, rig: &Rig, recipe: &Recipe, ui: &Ui) -> Result<Option<ShapeSet>> {
    let Some(path) = &args.onto else { return Ok(None) };
    let processor = [inputs::processor()?];
    read_shape_set(path, rig, recipe.has(ChannelKind::Normals), &processor, ui).map(Some)
}

/// The animated file of a take.
fn make(args: &args::Animate, prepared: Prepared, take: Take, ui: &Ui) -> Result<Animated> {
    let Prepared { rig, layers, recipe, onto, regions, device, format } = prepared;
    let performance = perform(args, rig, layers, recipe, take)?;
    let Performance { rig, selection, .. } = &performance;
    warnings::warn(args, format, &performance, args.takes.first().map(PathBuf::as_path), ui)?;
    let options = options::export_options(args, rig.surface().metres_per_unit, onto);
    let devices = inputs::devices(device, ui)?;
    let mut playback = performance.playback(&devices, ui)?;
    let start = Instant::now();
    let curves = args.strain_curves.as_ref().zip(regions.as_ref());
    let mut curves = curves.map(|(path, regions)| (path, StrainCurves::new(rig, regions)));
    let mut masks = Masks::new(args, &performance, &mut playback, ui)?;
    let written = playback.export_seen(&performance, &args.output, &options, ui, |frame| {
        curves.iter_mut().for_each(|(_, curves)| curves.frame(frame));
        masks.iter_mut().try_for_each(|masks| masks.frame(frame))
    })?;
    if let Some((path, curves)) = curves {
        curves.write(path, performance.first_time_code, selection.rate)?;
    }
    let masks = masks.map(|masks| masks.finish(&performance)).transpose()?;
    if !ui.is_quiet() {
        masks.iter().for_each(|words| ui.line(words));
        let of_frame = |(correction, moved)| {
            report::corrected(correction, moved, selection, rig.surface().metres_per_unit)
        };
        playback.corrections().map(of_frame).for_each(|words| ui.line(&words));
    }
    Ok(Animated {
        clips: vec![ClipOf { name: String::new(), frames: selection.inner.len(), rate: selection.rate }],
        metres_per_unit: rig.surface().metres_per_unit,
        device: playback.device().clone(),
        time: start.elapsed(),
        written,
    })
}

/// The frames of a take that are asked for, as a performance.
pub(crate) fn perform(
    args: &args::Animate,
    rig: Rig,
    layers: Option<Layers>,
    recipe: Recipe,
    take: Take,
) -> Result<Performance> {
    let range = match args.frames {
        FramesChoice::Range(range) => range.within(take.frames())?,
        FramesChoice::Count(_) => 0..take.frames(),
    };
    let recipe = Recipe { first_frame: range.start as u64, end_frame: range.end as u64, ..recipe };
    Performance::new(recipe, rig, take, layers)
}

/// The name of the take, which the animation has: that of its file.
pub(super) fn take_name(take: &Path) -> String {
    take.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The regions of the curves.
fn regions(args: &args::Animate, rig: &Rig) -> Result<Regions> {
    let Some(path) = &args.groups else { return Ok(Regions::by_labels(rig)) };
    let neutral = Mesh {
        positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
        faces: rig.surface().faces.clone(),
        uvs: None,
        materials: None,
    };
    Regions::by_groups(rig.vertices(), &mesh::read_groups(&neutral, &args.rig, path)?)
}
