//! `rhytid verify`

use crate::args::{MissingChoice, TakeReading};
use crate::progress::Ui;
use crate::{args, exit, inputs, output};
use rhytid::formats::animation::{self, Format};
use rhytid::formats::animation_reader::{AnimationReader, Summary};
use rhytid::formats::export::{Frame, HeadMotion, OutputStage, Provenance};
use rhytid::formats::take::Missing;
use rhytid::human;
use rhytid::playback::{FrameRange, Playback, PlaybackOptions, Selection, scale_folds};
use rhytid::{Error, Progress, Result, Rig, RigidMotion, rig_file};
use serde::Serialize;
use std::process::ExitCode;

/// Two devices that conform differ by their rounding: at most by this part of the face's diagonal.
const DEVICES_DIFFER: f64 = 1e-5;

/// Compares and reports; the exit code says whether every vertex is where the file promises.
///
/// # Errors
/// [`Error::Input`] if the file does not say how it was made, or was made from another rig or take; as reading and
/// evaluating.
pub(super) fn run(args: &args::Verify, ui: &Ui) -> Result<ExitCode> {
    inputs::rig_and_take(&args.rig, &args.take, "rhytid verify OUT --rig RIG --take TAKE")?;
    let device = inputs::named_device(&args.device)?;
    let file = args.file.display();
    let mut reader = animation::open_within(&args.file, args.elsewhere.reach())?;
    let fail = |what: String| Err(Error::input(format!("{file}: {what}")));
    let Some(provenance) = reader.summary().provenance.clone() else {
        return fail("does not say how it was made; export it again with this program".into());
    };
    let request = Request::of(&provenance).map_err(|what| Error::input(format!("{file}: {what}")))?;
    let mut rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    if request.stage == OutputStage::Shell {
        rig = rig.shell();
    }
    if rig_file::hash(&args.rig)? != provenance.rig {
        return fail(format!(
            "was made from another rig than {}; give the rig that it was made from, or export it again",
            args.rig.display()
        ));
    }
    let reading = TakeReading {
        missing: request.missing,
        setup: args.setup.clone(),
        elsewhere: args.elsewhere,
        space: args.space.clone(),
    };
    let take = inputs::take(&args.take, &rig, &reading, ui)?;
    let (take, layers) = inputs::edited(take, &mut rig, args.edit.as_deref(), &reading)?;
    match (&provenance.edit_hash, &layers) {
        (None, None) => {}
        (Some(made), Some(layers)) if made == layers.hash() => {}
        (Some(_), None) => return fail("was made with edits; give the same with --edit EDIT.toml".into()),
        (None, Some(_)) => return fail("was made without edits; leave --edit out".into()),
        (Some(_), Some(_)) => {
            return fail(
                "was made with other edits, or with other files that they name; `rhytid info` shows which"
                    .into(),
            );
        }
    }
    let summary = reader.summary().clone();
    let range = request.frames.within(take.frames())?;
    let selection = Selection::new(take.clone(), range, request.fps, summary.velocities)?;
    for (what, found, expected) in [
        ("frames", summary.frames as f64, selection.inner.len() as f64),
        ("as the first time code", summary.first_time_code, selection.first as f64),
        ("frames per second", summary.rate, selection.rate),
        ("vertices", summary.vertices as f64, rig.vertices() as f64),
    ] {
        // Formats round the rate to 32 bits at most.
        if (found - expected).abs() > 1e-6 * expected.abs() {
            return fail(format!(
                "has {found} {what}, expected {expected} from {}; give the take that it was made from",
                args.take.display()
            ));
        }
    }

    let differences = differences(&summary, &provenance, &rig, Format::of(&args.file)?);
    let devices = inputs::devices(device, ui)?;
    let gains = regions(provenance.detail_of.as_deref().unwrap_or_default());
    rig.scale_folds(|_| provenance.detail.unwrap_or(1.0));
    scale_folds(&mut rig, &gains)?;
    let mut playback = Playback::new(&rig, &devices, selection.take.frames())?;
    if let Some(layers) = &layers {
        playback = playback.with_layers(layers, &take, ui)?;
    }
    let options = PlaybackOptions {
        stage: request.stage,
        normals: summary.normals,
        velocities: summary.velocities,
        sigma: false,
        strain: summary.strain,
        fade_detail: provenance.fade_detail,
        head: request.head,
        refine: provenance.refine.unwrap_or(false),
    };
    let mut compared = Compared::default();
    let mut buffer = Vec::new();
    let total = summary.frames as u64;
    ui.report("verify", 0, total);
    let head = selection.head().filter(|_| request.head == HeadMotion::Keep);
    playback.play(&selection, options, ui, |fresh| {
        let motion = head.map(|head| head[compared.frames]);
        compared.frame(reader.as_mut(), fresh, motion, &mut buffer)?;
        ui.report("verify", compared.frames as u64, total);
        Ok(())
    })?;
    ui.clear();
    let report = Comparison::new(compared, differences, &rig, &summary);
    if args.json {
        output::json(&report)?;
    } else if !ui.is_quiet() || !report.passed {
        output::say(&report.text(&file.to_string(), &playback.device().id()))?;
    }
    Ok(if report.passed { ExitCode::SUCCESS } else { ExitCode::from(exit::OURS) })
}

/// What `animate` was request for.
struct Request {
    stage: OutputStage,
    missing: MissingChoice,
    head: HeadMotion,
    frames: FrameRange,
    fps: Option<f64>,
}

impl Request {
    fn of(provenance: &Provenance) -> std::result::Result<Self, String> {
        let unknown = |what: &str, found: &str| {
            format!("was made with the {what} “{found}”, which this program does not know; export it again")
        };
        let index = |frame: u64| usize::try_from(frame).map_err(|_| unknown("frame", &frame.to_string()));
        if let Some(fps) = provenance.fps.filter(|fps| !(0.01..=10_000.0).contains(fps)) {
            return Err(unknown("rate", &fps.to_string()));
        }
        let stage = provenance.stage.known().map_err(|word| unknown("stage", word))?;
        let missing = match provenance.missing.known() {
            Ok(Missing::Error) => MissingChoice::Error,
            Ok(Missing::Hold) => MissingChoice::Hold,
            Ok(Missing::Leave) | Err(_) => {
                return Err(unknown("way with missing markers", &provenance.missing.to_string()));
            }
        };
        let head = provenance.head.known().map_err(|word| unknown("way with the head's motion", word))?;
        Ok(Self {
            stage,
            missing,
            head,
            frames: FrameRange {
                start: Some(index(provenance.first_frame)?),
                end: Some(index(provenance.end_frame)?),
            },
            fps: provenance.fps,
        })
    }
}

/// In what the file differs from what `animate` writes of the rig, before its first frame.
fn differences(summary: &Summary, made: &Provenance, rig: &Rig, format: Format) -> Vec<String> {
    let is_usd = !matches!(format, Format::Glb | Format::Gltf);
    let has = |yes: bool| if yes { "has" } else { "lacks" };
    let mut found = Vec::new();
    let mut compare = |what: &str, found_here: String, expected: String| {
        if found_here != expected {
            found.push(format!("{what}: {found_here}, expected {expected}"));
        }
    };
    // glTF has it in 32 bits.
    let ratio = summary.metres_per_unit / rig.metres_per_unit;
    if ratio.is_nan() || (ratio - 1.0).abs() > 1e-6 {
        compare("metres per unit", summary.metres_per_unit.to_string(), rig.metres_per_unit.to_string());
    }
    if let Some(shown) = summary.frames_per_second {
        compare("framesPerSecond", shown.to_string(), summary.rate.to_string());
    }
    compare("up axis", format!("{:?}", summary.up_axis), format!("{:?}", rig.up_axis));
    let faces_are_right = match is_usd {
        true => summary.faces == rig.faces,
        false => rig.triangles.as_flattened() == summary.faces.indices,
    };
    compare("faces", if faces_are_right { "the rig's" } else { "others" }.into(), "the rig's".into());
    compare("normals", has(summary.normals).into(), has(made.normals.unwrap_or(true)).into());
    if made.velocities == Some(true) {
        compare("velocities", has(summary.velocities).into(), has(true).into());
    }
    if made.strain == Some(true) {
        compare("strain", has(summary.strain).into(), has(true).into());
    }
    // Shapes have none: where they are is known once they are mixed.
    compare("extents", has(summary.extents).into(), has(is_usd && summary.stated_error.is_none()).into());
    found
}

/// The most that normals of length 1 are apart, as a root mean square: around triangles without area two devices have any.
const NORMALS_DIFFER: f64 = 1e-3;

/// The same where a file states an error, which says nothing of normals: what is told apart is right from wrong.
const STATED_NORMALS_DIFFER: f64 = 0.3;

/// The most that principal strains are apart, as a root mean square: where triangles are small, rounded positions have others.
const STRAINS_DIFFER: f64 = 1e-3;

/// The largest and the mean square distance of two fields of vectors.
#[derive(Default)]
struct Distances {
    worst: f64,
    at: (usize, usize),
    squares: f64,
    count: usize,
}

impl Distances {
    /// Of so many numbers for each vertex.
    fn add<const N: usize>(&mut self, frame: usize, found: &[f32], expected: &[f32]) {
        let pairs = found.as_chunks::<N>().0.iter().zip(expected.as_chunks::<N>().0);
        for (vertex, (found, expected)) in pairs.enumerate() {
            let square: f64 =
                found.iter().zip(expected).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
            self.squares += square;
            let distance = square.sqrt();
            // Also if it is no number, which stays the worst.
            if distance > self.worst || distance.is_nan() {
                (self.worst, self.at) = (distance, (frame, vertex));
            }
        }
        self.count += expected.len() / N;
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

/// The gains by region that a file states.
fn regions(stated: &str) -> Vec<(String, f64)> {
    let gain = |part: &str| {
        let (region, gain) = part.rsplit_once('=')?;
        Some((region.to_owned(), gain.parse().ok()?))
    };
    stated.split(';').filter_map(gain).collect()
}

/// What the frames so far have come to.
#[derive(Default)]
struct Compared {
    frames: usize,
    positions: Distances,
    normals: Distances,
    velocities: Distances,
    strain: Distances,
    head: f64,
    /// Frames whose extent is not that of their positions.
    wrong_extents: usize,
}

impl Compared {
    fn frame(
        &mut self,
        reader: &mut dyn AnimationReader,
        fresh: Frame<'_>,
        head: Option<RigidMotion>,
        buffer: &mut Vec<f32>,
    ) -> Result<()> {
        let frame = self.frames;
        reader.positions(frame, buffer)?;
        self.positions.add::<3>(frame, buffer, fresh.positions);
        if let Some(normals) = fresh.normals {
            reader.normals(frame, buffer)?;
            self.normals.add::<3>(frame, buffer, normals);
        }
        if let Some(velocities) = fresh.velocities {
            reader.velocities(frame, buffer)?;
            self.velocities.add::<3>(frame, buffer, velocities);
        }
        if let Some(strain) = fresh.strain {
            reader.strain(frame, buffer)?;
            self.strain.add::<2>(frame, buffer, strain.strains.as_flattened());
        }
        if let Some(extent) = reader.extent(frame)? {
            reader.positions(frame, buffer)?;
            self.wrong_extents += usize::from(extent != extent_of(buffer));
        }
        // A head that never moves need not be in the file.
        let expected = head.unwrap_or(RigidMotion::IDENTITY).matrix();
        let found = reader.head(frame)?.unwrap_or(RigidMotion::IDENTITY.matrix());
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            let difference = (found - expected).abs() / expected.abs().max(1.0);
            if difference > self.head || difference.is_nan() {
                self.head = difference;
            }
        }
        self.frames += 1;
        Ok(())
    }
}

/// The box around positions.
fn extent_of(positions: &[f32]) -> [[f32; 3]; 2] {
    positions.as_chunks::<3>().0.iter().fold([[f32::MAX; 3], [f32::MIN; 3]], |[low, high], x| {
        [[0, 1, 2].map(|c| low[c].min(x[c])), [0, 1, 2].map(|c| high[c].max(x[c]))]
    })
}

/// What is printed.
#[derive(Serialize)]
struct Comparison {
    passed: bool,
    /// In what the file is not what the rig and the take give, beside the numbers below.
    differences: Vec<String>,
    frames: usize,
    vertices: usize,
    worst_mm: f64,
    rms_mm: f64,
    /// Of the worst position, counted from 0 in the file.
    frame: usize,
    vertex: usize,
    /// What the file states and what two devices may differ by.
    allowed_mm: f64,
    stated_mm: Option<f64>,
    /// The longest difference of two normals of length 1.
    normals_worst: Option<f64>,
    normals_rms: Option<f64>,
    velocities_worst_mm_per_s: Option<f64>,
    /// The largest difference of two principal strains.
    strain_worst: Option<f64>,
    strain_rms: Option<f64>,
    /// The largest difference of two elements of the head's matrix, relative to those above 1; the translation is in
    /// mesh units.
    head_worst: Option<f64>,
}

impl Comparison {
    fn new(compared: Compared, mut differences: Vec<String>, rig: &Rig, summary: &Summary) -> Self {
        let millimetres = 1e3 * rig.metres_per_unit;
        let diagonal = diagonal(rig);
        let allowed = summary.stated_error.unwrap_or(0.0) + DEVICES_DIFFER * diagonal;
        if compared.wrong_extents > 0 {
            differences
                .push(format!("extents: wrong in {} of {} frames", compared.wrong_extents, compared.frames));
        }
        let normals = if summary.stated_error.is_some() { STATED_NORMALS_DIFFER } else { NORMALS_DIFFER };
        let head = (summary.head || compared.head > 0.0).then_some(compared.head);
        Self {
            // A velocity is the difference of two positions. glTF has a head's motion in 32 bits.
            passed: compared.positions.worst <= allowed
                && compared.velocities.worst <= 2.0 * allowed * summary.rate
                && compared.strain.rms() <= summary.stated_strain_error.unwrap_or(0.0) + STRAINS_DIFFER
                && compared.head <= 1e-6
                && compared.normals.rms() <= normals
                && differences.is_empty(),
            differences,
            frames: compared.frames,
            vertices: summary.vertices,
            worst_mm: compared.positions.worst * millimetres,
            rms_mm: compared.positions.rms() * millimetres,
            frame: compared.positions.at.0,
            vertex: compared.positions.at.1,
            allowed_mm: allowed * millimetres,
            stated_mm: summary.stated_error.map(|error| error * millimetres),
            normals_worst: summary.normals.then_some(compared.normals.worst),
            normals_rms: summary.normals.then_some(compared.normals.rms()),
            velocities_worst_mm_per_s: summary.velocities.then_some(compared.velocities.worst * millimetres),
            strain_worst: summary.strain.then_some(compared.strain.worst),
            strain_rms: summary.strain.then_some(compared.strain.rms()),
            head_worst: head,
        }
    }

    fn text(&self, file: &str, device: &str) -> String {
        let row = |name: &str, value: String| [name.to_owned(), value];
        let stated = match self.stated_mm {
            Some(stated) => format!("at most {stated:.6} mm"),
            None => "every bit".into(),
        };
        let mut rows = vec![
            row(
                "compared",
                format!(
                    "{} of {} vertices",
                    human::counted(self.frames, "frame"),
                    human::count(self.vertices)
                ),
            ),
            row("with", format!("a fresh evaluation on {device}")),
            row("worst", format!("{:.6} mm, frame {}, vertex {}", self.worst_mm, self.frame, self.vertex)),
            row("RMS", format!("{:.6} mm", self.rms_mm)),
            row("stated", stated),
            row("allowed", format!("{:.6} mm: that, and what two devices may differ by", self.allowed_mm)),
        ];
        let further = [
            (
                "normals",
                self.normals_worst
                    .zip(self.normals_rms)
                    .map(|(worst, rms)| format!("off by {worst:.6} of their length at worst, RMS {rms:.6}")),
            ),
            ("velocities", self.velocities_worst_mm_per_s.map(|worst| format!("{worst:.6} mm/s at worst"))),
            (
                "strain",
                self.strain_worst
                    .zip(self.strain_rms)
                    .map(|(worst, rms)| format!("off by {worst:.6} at worst, RMS {rms:.6}")),
            ),
            ("head", self.head_worst.map(|worst| format!("its matrix off by {worst:.2e} at worst"))),
        ];
        rows.extend(self.differences.iter().map(|what| row("differs", what.clone())));
        rows.extend(further.into_iter().filter_map(|(name, text)| Some(row(name, text?))));
        let verdict = if self.passed { "sound" } else { "FAILS: it is not what the rig and the take give" };
        format!("{file}: {verdict}\n{}", output::table(&rows))
    }
}

/// Of the rest pose's bounding box, in mesh units.
fn diagonal(rig: &Rig) -> f64 {
    let extent = |c: usize| {
        let along = || rig.rest.iter().map(|p| f64::from(p[c]));
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
    };
    (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt()
}
