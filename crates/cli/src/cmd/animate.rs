//! `rhytid animate`

use super::masks::{self, Masks};
use super::{clips, listen};
use crate::args::{FramesChoice, HeadChoice, MaterialsChoice};
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture;
use rhytid::core::human;
use rhytid::core::{AtomicFile, ChannelKind, DeviceInfo, Mesh, rig_file};
use rhytid::evaluate::{Regions, StrainCurves, coverage};
use rhytid::formats::animation::Format;
use rhytid::formats::export::{self, Deviation, HeadMotion, Recipe, ShapeSet, WrinkleGroups, Written};
use rhytid::formats::{FileKind, mesh, raw_take, refuse_inputs};
use rhytid::playback::{Correction, Layers, Performance, Selection, check_export, read_shape_set};
use rhytid::{Error, Result, Rig, Take};
use serde::Serialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The number of stretches that a warning lists.
const STRETCHES: usize = 4;

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

/// Animates and says what was done.
///
/// # Errors
/// As [`animate`].
pub(super) fn run(args: &args::Animate, ui: &Ui) -> Result<()> {
    let done = animate(args, ui)?;
    output::done(args.json, ui, &Summary::new(args, &done), || {
        let evaluated = format!(
            "evaluated on {} in {} ({} frames/s), {}{}",
            done.device.id(),
            human::duration(done.time),
            human::number((done.frames() as f64 / done.time.as_secs_f64() * 10.0).round() / 10.0),
            human::bytes(done.written.bytes),
            targets(&done.written),
        );
        let frames = |clip: &ClipOf| {
            let (frames, rate) = (human::counted(clip.frames, "frame"), human::number(clip.rate));
            format!("{frames} at {rate} frames per second")
        };
        let error = |i: usize| off(done.written.errors.get(i), done.metres_per_unit);
        let text = match &done.clips[..] {
            [clip] => format!("{}: {}, {evaluated}{}", args.output.display(), frames(clip), error(0)),
            clips => {
                let takes = human::counted(clips.len(), "take");
                let of_clip =
                    |(i, clip): (usize, &ClipOf)| format!("\n  {}: {}{}", clip.name, frames(clip), error(i));
                let of_clips: String = clips.iter().enumerate().map(of_clip).collect();
                format!("{}: {takes}, {evaluated}{of_clips}", args.output.display())
            }
        };
        text + &next(args, &done)
    })
}

/// The commands that come next: look at it, and check the file.
fn next(args: &args::Animate, done: &Animated) -> String {
    let Some(take) = args.takes.first().or(args.live.record.as_ref()) else { return String::new() };
    if args.live.sender.world {
        let words = std::env::args().skip(1).collect();
        return output::next(&[listen::prepare(words, &args.rig, take)]);
    }
    let [rig, file] = [&args.rig, &args.output].map(|path| output::word(path));
    let option = |name: &str, value: &Option<PathBuf>| {
        value.as_ref().map_or(String::new(), |path| format!(" {name} {}", output::word(path)))
    };
    let edit = option("--edit", &args.edit);
    let setup = option("--setup", &args.reading.setup);
    let shapes = option("--shapes", &args.reading.shapes_of_curves().map(Path::to_owned));
    let elsewhere = args.reading.elsewhere.again();
    let mut commands = Vec::new();
    // The window plays no other shapes than the rig's examples.
    if shapes.is_empty() {
        commands.push(format!("rhytid view {rig} {}{edit}", output::word(take)));
    }
    // A point cache says nothing about how it was made, and neither do curves.
    let is_stated = |format| !matches!(format, Format::Pc2 | Format::Csv);
    if Format::from_extension(&args.output).is_ok_and(is_stated) && args.live.listen.is_none() {
        commands.extend(args.takes.iter().zip(&done.clips).map(|(take, clip)| {
            // Two takes may have one name.
            let is_plain = done.clips.len() == 1 || clip.name == take_name(take);
            let clip = if is_plain {
                String::new()
            } else {
                format!(" --clip {}", output::word(clip.name.as_ref()))
            };
            let take = output::word(take);
            format!("rhytid verify {file} --rig {rig} --take {take}{clip}{edit}{setup}{shapes}{elsewhere}")
        }));
    }
    output::next(&commands)
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Summary<'a> {
    file: &'a Path,
    bytes: u64,
    frames: usize,
    frames_per_second: f64,
    device: String,
    device_name: &'a str,
    seconds: f64,
    /// Null where the file has no morph targets.
    morph_targets: Option<usize>,
    /// The largest distance of a vertex from its place; null where nothing is approximated.
    worst_mm: Option<f64>,
    rms_mm: Option<f64>,
    /// Null where there is one take.
    clips: Option<Vec<ClipSummary<'a>>>,
}

/// One of several takes.
#[derive(Serialize)]
struct ClipSummary<'a> {
    take: &'a Path,
    frames: usize,
    frames_per_second: f64,
    worst_mm: Option<f64>,
    rms_mm: Option<f64>,
}

impl<'a> Summary<'a> {
    fn new(args: &'a args::Animate, done: &'a Animated) -> Self {
        let millimetres = |length: f64| length * done.metres_per_unit * 1e3;
        Self {
            file: &args.output,
            bytes: done.written.bytes,
            frames: done.frames(),
            frames_per_second: done.clips.first().map_or(0.0, |clip| clip.rate),
            device: done.device.id(),
            device_name: &done.device.name,
            seconds: done.time.as_secs_f64(),
            morph_targets: done.written.targets,
            worst_mm: done.error().map(|error| millimetres(error.worst)),
            rms_mm: done.error().map(|error| millimetres(error.rms)),
            clips: (done.clips.len() > 1).then(|| {
                let clips = args.takes.iter().zip(&done.clips).enumerate();
                let summary = clips.map(|(i, (take, clip))| ClipSummary {
                    take,
                    frames: clip.frames,
                    frames_per_second: clip.rate,
                    worst_mm: done.written.errors.get(i).map(|error| millimetres(error.worst)),
                    rms_mm: done.written.errors.get(i).map(|error| millimetres(error.rms)),
                });
                summary.collect()
            }),
        }
    }
}

/// The words about morph targets, if there are any.
fn targets(written: &Written) -> String {
    written.targets.map_or(String::new(), |n| format!(", {}", human::counted(n, "morph target")))
}

/// The words about the error of a clip, if it has one.
fn off(error: Option<&Deviation>, metres_per_unit: f64) -> String {
    let Some(error) = error else { return String::new() };
    let millimetres = |length: f64| human::number(length * metres_per_unit * 1e3);
    let (frame, vertex) = error.at;
    format!(
        "; at most {} mm off (frame {frame}, vertex {vertex}), RMS {} mm",
        millimetres(error.worst),
        millimetres(error.rms)
    )
}

/// From a rig file and a take to an animated file.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading and writing; [`Error::Device`]; [`Error::Cancelled`].
pub(super) fn animate(args: &args::Animate, ui: &Ui) -> Result<Animated> {
    // An unknown format is an error before the long work.
    let format = Format::from_extension(&args.output)?;
    check_options(args, format)?;
    clips::check(args)?;
    let count = listen::count(args)?;
    check_files(args)?;
    let device = inputs::named_device(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let layers = inputs::layers(args.edit.as_deref(), &rig, &args.reading)?;
    let recipe = recipe(args, format, layers.as_ref())?;
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
    let options = export_options(args, prepared.rig.surface().metres_per_unit, prepared.onto.clone());
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
pub(super) struct Prepared {
    pub rig: Rig,
    pub layers: Option<Layers>,
    /// The recipe of the first take.
    pub recipe: Recipe,
    /// The shapes whose weights are to be found.
    pub onto: Option<ShapeSet>,
    /// The regions of the strain curves.
    pub regions: Option<Regions>,
    /// The device that was named.
    pub device: Option<DeviceInfo>,
    pub format: Format,
}

/// The shapes of `--onto`.
fn onto(args: &args::Animate, rig: &Rig, recipe: &Recipe, ui: &Ui) -> Result<Option<ShapeSet>> {
    let Some(path) = &args.onto else { return Ok(None) };
    let processor = [inputs::processor()?];
    read_shape_set(path, rig, recipe.has(ChannelKind::Normals), &processor, ui).map(Some)
}

/// The animated file of a take.
fn make(args: &args::Animate, prepared: Prepared, take: Take, ui: &Ui) -> Result<Animated> {
    let Prepared { rig, layers, recipe, onto, regions, device, format } = prepared;
    let performance = perform(args, rig, layers, recipe, take)?;
    let Performance { rig, selection, .. } = &performance;
    warn(args, format, &performance, args.takes.first().map(PathBuf::as_path), ui)?;
    let options = export_options(args, rig.surface().metres_per_unit, onto);
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
        let of_frame =
            |(correction, moved)| corrected(correction, moved, selection, rig.surface().metres_per_unit);
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
pub(super) fn perform(
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

/// Says what is likely wrong with a take, and which options change nothing. `path` is the take's, if it has
/// one.
pub(super) fn warn(
    args: &args::Animate,
    format: Format,
    performance: &Performance,
    path: Option<&Path>,
    ui: &Ui,
) -> Result<()> {
    let Performance { rig, take, recipe, .. } = performance;
    let range = recipe.first_frame as usize..recipe.end_frame as usize;
    let is_far = warn_far(rig, &take.take, &range, ui)?;
    say_what_changes_nothing(args, &take.take, path, is_far);
    warn_head_left_out(args, format, &take.take);
    Ok(())
}

/// Checks that the inputs are of the right kinds, and that every output can be written and is no input.
fn check_files(args: &args::Animate) -> Result<()> {
    for take in &args.takes {
        inputs::rig_and_take(&args.rig, take, "rhytid animate RIG TAKE -o OUT.usd")?;
    }
    if args.takes.is_empty() {
        inputs::expect(&args.rig, &[FileKind::Rig], "rhytid animate RIG --listen --frames N -o OUT.usd")?;
    }
    let edits = inputs::edit_files(args.edit.as_deref())?;
    let inputs = [Some(&args.rig), args.reading.setup.as_ref(), args.groups.as_ref(), args.onto.as_ref()];
    let inputs = inputs.into_iter().flatten().chain(&args.takes).chain(&edits).map(PathBuf::as_path);
    let inputs = inputs.chain(args.reading.shapes_of_curves());
    let masks = masks::outputs(args);
    let others = args.live.record.iter().chain(&args.strain_curves).chain(&masks);
    let outputs: Vec<&Path> = std::iter::once(&args.output).chain(others).map(PathBuf::as_path).collect();
    refuse_inputs(&outputs, inputs)?;
    for output in outputs {
        drop(AtomicFile::create(output)?);
    }
    Ok(())
}

pub(super) fn export_options(
    args: &args::Animate,
    metres_per_unit: f64,
    onto: Option<ShapeSet>,
) -> export::Options {
    export::Options {
        max_error: args.compressed.then_some(args.max_error * 1e-3 / metres_per_unit),
        quantize: args.quantize,
        meshopt: args.meshopt,
        most_targets: args.targets.map(usize::from),
        force: args.reading.force,
        shapes: args.reading.shapes_to_write(),
        vertex_ids: args.vertex_ids,
        one_material: args.materials == MaterialsChoice::One,
        clips: args.takes.iter().chain(&args.live.record).map(|take| take_name(take)).collect(),
        onto,
        textures: args.textures.map(Into::into),
        prim_path: args.layer.prim_path.clone(),
        mesh_name: args.layer.mesh_name.clone(),
        metres: args.layer.metres,
        over: args.over,
        subdivision: args.layer.subdivision.into(),
    }
}

/// The name of the take, which the animation has: that of its file.
pub(super) fn take_name(take: &Path) -> String {
    take.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn warn_head_left_out(args: &args::Animate, format: Format, take: &Take) {
    if format == Format::Csv && args.head == HeadChoice::Keep && take.head.is_some() {
        log::warn!(
            "{}: weights of shapes say nothing of the head's motion, which is left out; write .glb or .usd for it",
            args.output.display()
        );
    }
    if format == Format::Pc2 && args.head == HeadChoice::Keep && take.head.is_some() {
        log::warn!(
            "{}: a point cache has no place for the head's motion, which is left out; --head bake puts it into the vertices",
            args.output.display()
        );
    }
}

/// The recipe of the options. The frames are known only with the take.
fn recipe(args: &args::Animate, format: Format, layers: Option<&Layers>) -> Result<Recipe> {
    let mut channels = args.channels.0.clone();
    // A default channel is left out if the format has no place for it.
    let lacks = |kind: &ChannelKind| kind.is_default() && !format.carries(*kind);
    ChannelKind::ALL.into_iter().filter(lacks).for_each(|kind| channels.set(kind, false));
    Ok(Recipe {
        rig: rig_file::hash(&args.rig)?,
        stage: args.fine_detail.stage.into(),
        fps: args.fps,
        start_frame: args.start_frame,
        missing: args.reading.missing.into(),
        fade_detail: args.fine_detail.fade,
        head: args.head.into(),
        detail: args.fine_detail.gain,
        detail_of: inputs::gains(&args.fine_detail, &args.reading)?,
        edit: layers.map(|layers| layers.text().to_owned()),
        edit_hash: layers.map(|layers| layers.hash().to_owned()),
        channels,
        wrinkle_groups: WrinkleGroups(args.wrinkle_group.clone()),
        refine: args.refine,
        treatment: args.reading.treatment(args.takes.first().map(PathBuf::as_path))?,
        ..Recipe::default()
    })
}

/// A smaller motion, in millimetres, cannot be seen.
const SEEN_MM: f64 = 0.1;

/// What a correction did in the frames of a selection.
fn corrected(correction: &Correction, moved: &[f64], selection: &Selection, metres_per_unit: f64) -> String {
    let millimetres = |x: f64| human::number((x * metres_per_unit * 1e5).round() / 1e2);
    let moved = moved.get(selection.inner.clone()).unwrap_or_default();
    let seen: Vec<usize> = (0..moved.len()).filter(|&i| moved[i] * metres_per_unit * 1e3 > SEEN_MM).collect();
    let touched = moved.iter().filter(|by| **by > 0.0).count();
    let between = match (seen.first(), seen.last()) {
        (Some(first), Some(last)) => {
            format!(" between {} and {}", first + selection.first, last + selection.first)
        }
        _ => String::new(),
    };
    format!(
        "correction of frame {}: {} vertices by up to {} mm; more than {SEEN_MM} mm in {}{between}, nothing in {}: its reach is {}, as a ratio of strains",
        correction.frame(),
        human::count(correction.vertices()),
        millimetres(correction.largest()),
        human::counted(seen.len(), "frame"),
        human::count(moved.len() - touched),
        human::number((correction.reach() * 1e4).round() / 1e4)
    )
}

/// Warns once about all frames of `range` that are far outside the examples. Returns whether there are any.
fn warn_far(rig: &Rig, take: &Take, range: &Range<usize>, ui: &Ui) -> Result<bool> {
    if rig.learned().is_none() || rig.examples().names.is_empty() {
        return Ok(false);
    }
    let asked = take.slice(range.clone());
    let far = coverage::take_sigma(rig, &asked, &Regions::by_handles(rig), ui)?.far;
    let Some(worst) = far.iter().max_by(|a, b| a.times.total_cmp(&b.times)) else { return Ok(false) };
    let frames: usize = far.iter().map(|stretch| stretch.frames).sum();
    let stretches: Vec<String> = far
        .iter()
        .take(STRETCHES)
        .map(|stretch| match stretch.frames {
            1 => (range.start + stretch.first).to_string(),
            n => format!("{}..{}", range.start + stretch.first, range.start + stretch.first + n),
        })
        .collect();
    let more = if far.len() > STRETCHES {
        format!(" and {} more stretches", far.len() - STRETCHES)
    } else {
        String::new()
    };
    log::warn!(
        "the take goes far outside what the examples show in {} ({}{more}), most in frame {} ({:.2} s) in the region {}: \
         {} as {}; look at these frames, scan such an expression (`rhytid coverage` plans it), or let the wrinkles \
         fade there with --fade-detail",
        human::counted(frames, "frame"),
        stretches.join(", "),
        range.start + worst.farthest,
        worst.time,
        worst.region,
        human::times(worst.times),
        worst.of
    );
    Ok(true)
}

/// The regions of the curves.
fn regions(args: &args::Animate, rig: &Rig) -> Result<Regions> {
    let Some(path) = &args.groups else { return Ok(Regions::by_handles(rig)) };
    let neutral = Mesh {
        positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
        faces: rig.surface().faces.clone(),
        uvs: None,
        materials: None,
    };
    Regions::by_groups(rig.vertices(), &mesh::read_groups(&neutral, &args.rig, path)?)
}

/// Reports options that have no effect on this take. That is no error, since scripts give them to every take.
fn say_what_changes_nothing(args: &args::Animate, take: &Take, path: Option<&Path>, is_far: bool) {
    let take_path = path.unwrap_or(Path::new("what came")).display();
    if args.fine_detail.fade && take.confidence.is_none() && !is_far {
        log::info!(
            "{take_path}: has no confidence below 1 and goes nowhere far from the examples, so --fade-detail changes nothing"
        );
    }
    if args.head != HeadChoice::Keep && take.head.is_none() {
        log::info!(
            "{take_path}: does not say how the head moves, so --head {} changes nothing",
            HeadMotion::from(args.head)
        );
    }
}

/// An option that the stage or the format would ignore is a mistake.
fn check_options(args: &args::Animate, format: Format) -> Result<()> {
    args.fine_detail.check()?;
    // A raw take may need it for its clean-up, whatever the format.
    let is_raw = args.live.sender.world || args.takes.iter().any(|take| !raw_take::is_take_csv(take));
    let for_gltf = [
        (args.compressed, "--compressed"),
        (args.quantize, "--quantize"),
        (args.meshopt, "--meshopt"),
        (args.targets.is_some(), "--targets"),
        (args.vertex_ids, "--vertex-ids"),
        (args.materials != MaterialsChoice::default(), "--materials"),
        (args.reading.force && !is_raw, "--force"),
    ];
    if args.compressed && args.reading.shapes_to_write().is_some() {
        return Err(Error::conflict(
            "--compressed and --shapes N are two ways to write few shapes; give one",
        ));
    }
    if args.onto.is_some() && args.reading.shapes_to_write().is_some() {
        return Err(Error::conflict("--onto fits given shapes, and --shapes N makes new ones; give one"));
    }
    if format == Format::Csv && args.onto.is_none() {
        return Err(Error::conflict(format!(
            "{}: a .csv holds weights of shapes; give the shapes with --onto SHAPES, or write .usd or .glb",
            args.output.display()
        )));
    }
    if let Some(shapes) = args.reading.shapes_of_curves().filter(|_| args.live.listen.is_some()) {
        return Err(Error::conflict(format!(
            "--listen receives positions, so that --shapes {} changes nothing; leave it out",
            shapes.display()
        )));
    }
    let kinds = args.channels.0.kinds().filter(|kind| !kind.is_default() && !format.carries(*kind));
    if let Some(kind) = kinds.into_iter().next() {
        return Err(Error::conflict(format!(
            "{}: --{} is for {}; leave it out, or choose such a file",
            args.output.display(),
            args::option(kind),
            args::formats(kind)
        )));
    }
    const GLTF: &str = "glTF (.glb or .gltf)";
    let for_both =
        [(args.reading.shapes_to_write().is_some(), "--shapes"), (args.textures.is_some(), "--textures")];
    const USD: &str = "USD (.usd, .usdc, .usda or .usdz)";
    let mut for_usd = args.layer.given().to_vec();
    for_usd.push((args.over, "--over"));
    if format == Format::Pc2 && args.onto.is_some() {
        return Err(Error::conflict(format!(
            "{}: --onto is for USD, glTF and .csv; leave it out, or choose such a file",
            args.output.display()
        )));
    }
    let of_others = match format {
        Format::Usdc | Format::Usda | Format::Usdz => vec![(&for_gltf[..], GLTF)],
        Format::Glb | Format::Gltf => vec![(&for_usd[..], USD)],
        Format::Csv | Format::Pc2 => {
            vec![(&for_gltf[..], GLTF), (&for_both, "USD and glTF"), (&for_usd[..], USD)]
        }
    };
    let mut given = of_others.iter().flat_map(|(options, of)| options.iter().map(move |option| (option, of)));
    match given.find(|((given, _), _)| *given) {
        Some(((_, option), of)) => Err(Error::conflict(format!(
            "{}: {option} is for {of}; leave it out, or choose such a file",
            Path::new(&args.output).display()
        ))),
        None => Ok(()),
    }
}
