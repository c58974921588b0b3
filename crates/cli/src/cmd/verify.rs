//! `rhytid verify`

use super::animate::take_name;
use crate::args::{ShapesChoice, TakeReading};
use crate::progress::Ui;
use crate::{args, exit_code, inputs, output};
use rhytid::core::channel::Quantity;
use rhytid::core::human;
use rhytid::core::{ChannelKind, channel, rig_file};
use rhytid::formats::animation::{self, Format};
use rhytid::formats::export::Summary;
use rhytid::playback::{ChannelDifference, Performance, Verified, verify};
use rhytid::{Error, Result};
use serde::Serialize;
use serde_json::{Map, Value};

/// Compares and reports; the exit code says whether every vertex is where the file promises.
///
/// # Errors
/// [`Error::Input`] if the file does not say how it was made, or was made from another rig or take. Errors of
/// reading and evaluating.
pub(super) fn run(args: &args::Verify, ui: &Ui) -> Result<u8> {
    inputs::rig_and_take(&args.rig, &args.take, "rhytid verify OUT --rig RIG --take TAKE")?;
    let device = inputs::named_device(&args.device)?;
    let file = args.file.display();
    let clip = args.clip.clone().unwrap_or_else(|| take_name(&args.take));
    let mut reader = animation::open_clip(&args.file, args.elsewhere.reach(), Some(&clip))?;
    let in_file = |error: Error| error.in_file(&file);
    let fail = |what: String| Err(Error::mismatch(format!("{file}: {what}")));
    let summary = reader.summary().clone();
    if args.clip.is_some() && summary.clips.is_empty() {
        return fail("holds one take, so that --clip changes nothing; leave it out".into());
    }
    let Some(stated) = &summary.recipe else {
        return fail("does not say how it was made; export it again with this program".into());
    };
    let recipe = stated.recipe().map_err(in_file)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    if rig_file::hash(&args.rig)? != recipe.rig {
        return fail(format!(
            "was made from another rig than {}; give the rig that it was made from, or export it again",
            args.rig.display()
        ));
    }
    let reading = TakeReading {
        setup: args.setup.clone(),
        // Whether to go on was decided when the file was made.
        force: true,
        shapes: args.shapes.clone().map(ShapesChoice::Of).into_iter().collect(),
        elsewhere: args.elsewhere,
        space: args.space.clone(),
        ..TakeReading::default()
    };
    let reading = reading.with_stated(&args.take, recipe.missing, &recipe.treatment).map_err(in_file)?;
    let take = inputs::take(&args.take, &rig, &reading, ui)?;
    let layers = inputs::layers(args.edit.as_deref(), &rig, &reading)?;
    match (&recipe.edit_hash, &layers) {
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
    let performance = Performance::new(recipe, rig, take, layers);
    let performance = performance.map_err(|error| error.in_file(args.take.display()))?;
    let (rig, selection) = (&performance.rig, &performance.selection);
    for (what, found, expected) in [
        ("frames", summary.frames as f64, selection.inner.len() as f64),
        ("as the first time code", summary.first_time_code, performance.first_time_code as f64),
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
    let devices = inputs::devices(device, ui)?;
    let mut playback = performance.playback(&devices, ui)?;
    let found =
        verify(reader.as_mut(), Format::from_extension(&args.file)?, &performance, &mut playback, ui)?;
    ui.clear();
    let report = Comparison::new(&found, rig.surface().metres_per_unit, &summary);
    if args.json.wanted {
        output::json(&report)?;
    } else if !ui.is_quiet() || !report.passed {
        output::say(&report.text(
            &file.to_string(),
            &playback.device().id(),
            &found,
            rig.surface().metres_per_unit,
        ))?;
    }
    Ok(if report.passed { exit_code::DONE } else { exit_code::OURS })
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Comparison {
    passed: bool,
    /// How the file differs from what the rig and the take give, apart from the numbers below.
    differences: Vec<String>,
    frames: usize,
    vertices: usize,
    worst_mm: f64,
    rms_mm: f64,
    /// The frame of the worst position, counted from 0 in the file.
    frame: usize,
    vertex: usize,
    /// The file's stated error plus what two devices may differ by.
    allowed_mm: f64,
    stated_mm: Option<f64>,
    /// `NAME_worst` and `NAME_rms` of each channel, with the unit as a suffix if there is one.
    ///
    /// The first is the largest difference of a vertex's numbers, the second the RMS difference. Both are
    /// null if the file does not have the channel.
    #[serde(flatten)]
    channels: Map<String, Value>,
    /// Numbers that are farther off than their channel's tolerance.
    beyond: usize,
    /// The largest difference of two elements of the head's matrix, relative for elements above 1. The
    /// translation is in mesh units.
    head_worst: Option<f64>,
}

/// The factor that converts a channel's numbers for display, the unit's suffix in a key, and the unit in a
/// sentence.
fn unit(quantity: Quantity, metres_per_unit: f64) -> (f64, &'static str, &'static str) {
    let millimetres = 1e3 * metres_per_unit;
    match quantity {
        Quantity::Position | Quantity::Length => (millimetres, "_mm", " mm"),
        Quantity::Velocity => (millimetres, "_mm_per_s", " mm/s"),
        Quantity::Direction | Quantity::Ratio => (1.0, "", ""),
    }
}

impl Comparison {
    fn new(found: &Verified, metres_per_unit: f64, summary: &Summary) -> Self {
        let millimetres = 1e3 * metres_per_unit;
        let mut channels = Map::new();
        let known = ChannelKind::ALL.into_iter().flat_map(|kind| kind.channels(&[]));
        let found_here = found.others.iter().map(|other| other.channel.clone());
        for channel in known.chain(found_here) {
            let (scale, unit, _) = unit(channel.quantity, metres_per_unit);
            let difference = found.others.iter().find(|other| other.channel.name == channel.name);
            let number = |of: fn(&ChannelDifference) -> f64| {
                difference.map(|difference| scale * of(difference)).into()
            };
            channels.insert(format!("{}_worst{unit}", channel.name), number(|of| of.worst));
            channels.insert(format!("{}_rms{unit}", channel.name), number(|of| of.rms));
        }
        let all = std::iter::once(&found.positions).chain(&found.others);
        Self {
            passed: found.passed(),
            differences: found.differences.clone(),
            frames: found.frames,
            vertices: summary.vertices,
            worst_mm: found.positions.worst * millimetres,
            rms_mm: found.positions.rms * millimetres,
            frame: found.positions.at.0,
            vertex: found.positions.at.1,
            allowed_mm: found.allowed * millimetres,
            stated_mm: summary.stated_error.map(|error| error.worst * millimetres),
            channels,
            beyond: all.map(|channel| channel.beyond).sum(),
            head_worst: (summary.head || found.head > 0.0).then_some(found.head),
        }
    }

    fn text(&self, file: &str, device: &str, found: &Verified, metres_per_unit: f64) -> String {
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
        rows.extend(self.differences.iter().map(|what| row("differs", what.clone())));
        for difference in std::iter::once(&found.positions).chain(&found.others) {
            let (channel, beyond) = (&difference.channel, difference.beyond);
            if let Some((frame, vertex)) = difference.first_beyond {
                let what = if beyond == 1 {
                    "1 value is".to_owned()
                } else {
                    format!("{} values are", human::count(beyond))
                };
                rows.push(row(
                    "differs",
                    format!(
                        "{}: {what} beyond the tolerance, first in frame {frame}, vertex {vertex}",
                        channel.words
                    ),
                ));
            }
        }
        for ChannelDifference { channel, worst, rms, .. } in &found.others {
            let (scale, _, unit) = unit(channel.quantity, metres_per_unit);
            let off = |x: f64| format!("{:.6}{unit}", scale * x);
            let of = if channel.name == channel::NORMALS.name { " of their length" } else { "" };
            rows.push(row(&channel.name, format!("off by {}{of} at worst, RMS {}", off(*worst), off(*rms))));
        }
        let head = self.head_worst.map(|worst| format!("its matrix off by {worst:.2e} at worst"));
        rows.extend(head.map(|text| row("head", text)));
        let verdict = if self.passed { "sound" } else { "FAILS: it is not what the rig and the take give" };
        format!("{file}: {verdict}\n{}", output::table(&rows))
    }
}
