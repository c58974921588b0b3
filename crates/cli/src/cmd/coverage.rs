//! `rhytid coverage`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture::coverage::{self, Coverage, Difference, Edge, Expression};
use rhytid::human;
use rhytid::{Result, rig_file};

/// Prints what of the take no example shows.
///
/// # Errors
/// As reading the rig and the take, and as [`coverage::coverage`].
pub(super) fn run(args: &args::Coverage, ui: &Ui) -> Result<()> {
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let take = inputs::take(&args.take, &rig, args.missing, args.setup.as_deref(), ui)?;
    let top = args.top as usize;
    let found = ui.timed("compare", || coverage::coverage(&rig.cast(), &take, top)).0?;
    ui.clear();
    if args.json {
        output::json(&found)
    } else {
        output::say(&text(&found, &args.take.display().to_string()))
    }
}

fn text(found: &Coverage, take: &str) -> String {
    let share = |frames: usize| format!("{:.1} %", frames as f64 / found.frames.max(1) as f64 * 100.0);
    let mut text = format!(
        "{take}: {} of {} {} covered by the examples",
        share(found.covered),
        human::counted(found.frames, "frame"),
        if found.frames == 1 { "is" } else { "are" }
    );
    if let Some(spacing) = found.spacing {
        text += &format!(", which are typically {} RMS strain apart", percent(spacing));
    }
    if found.expressions.is_empty() {
        text += "\n\nNo expression is worth a scan of its own.";
    } else {
        let header = ["", "frame", "time", "distance", "from", "covered then", "what differs most"];
        let rows = found.expressions.iter().enumerate().map(|(i, e)| expression(i, e, &share));
        let rows: Vec<[String; 7]> = std::iter::once(header.map(str::to_owned)).chain(rows).collect();
        text += &format!(
            "\n\nTo be scanned next, the farthest from all examples first:\n{}",
            output::table(&rows)
        );
    }
    if found.edges.is_empty() {
        text += "\n\nNo strain edge goes beyond the examples.";
    } else {
        let header = ["edge", "beyond", "", "in the examples", "at frame", "time", "frames beyond"];
        let rows = found.edges.iter().map(|e| edge(e, &share));
        let rows: Vec<[String; 7]> = std::iter::once(header.map(str::to_owned)).chain(rows).collect();
        text += &format!(
            "\n\n{} {} beyond every example, the farthest first:\n{}",
            human::counted(found.edges_beyond, "strain edge"),
            if found.edges_beyond == 1 { "goes" } else { "go" },
            output::table(&rows)
        );
    }
    text
}

fn expression(i: usize, e: &Expression, share: &dyn Fn(usize) -> String) -> [String; 7] {
    [
        (i + 1).to_string(),
        e.frame.to_string(),
        seconds(e.time),
        e.relative.map_or_else(|| percent(e.distance), |relative| format!("{relative:.2}")),
        e.nearest.clone(),
        share(e.covered),
        e.edges.iter().map(difference).collect::<Vec<_>>().join(", "),
    ]
}

fn difference(d: &Difference) -> String {
    format!("{} {}", names(&d.handles), change(d.difference, d.difference_mm))
}

fn edge(e: &Edge, share: &dyn Fn(usize) -> String) -> [String; 7] {
    let [low, high] = e.examples;
    [
        names(&e.handles),
        change(e.beyond, e.beyond_mm),
        percent(e.beyond.abs()),
        format!("{} to {}", percent(low), percent(high)),
        e.frame.to_string(),
        seconds(e.time),
        share(e.frames_beyond),
    ]
}

fn names([a, b]: &[String; 2]) -> String {
    format!("{a}–{b}")
}

fn change(strain: f64, millimetres: f64) -> String {
    format!("{:.1} mm {}", millimetres.abs(), if strain > 0.0 { "longer" } else { "shorter" })
}

fn percent(strain: f64) -> String {
    format!("{:.1} %", strain * 100.0)
}

fn seconds(time: f64) -> String {
    format!("{time:.2} s")
}
