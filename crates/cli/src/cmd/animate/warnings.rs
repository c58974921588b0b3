//! What is likely wrong with a take that is animated.

use crate::args;
use crate::args::HeadChoice;
use crate::progress::Ui;
use rhytid::core::human;
use rhytid::evaluate::{Regions, coverage};
use rhytid::formats::animation::Format;
use rhytid::formats::export::HeadMotion;
use rhytid::playback::Performance;
use rhytid::{Result, Rig, Take};
use std::ops::Range;
use std::path::Path;

/// The number of stretches that a warning lists.
const STRETCHES: usize = 4;

/// Says what is likely wrong with a take, and which options change nothing. `path` is the take's, if it has
/// one. Returns the frames that are far outside the examples.
pub(super) fn warn(
    args: &args::Animate,
    format: Format,
    performance: &Performance,
    path: Option<&Path>,
    ui: &Ui,
) -> Result<Vec<Range<usize>>> {
    let Performance { rig, take, recipe, .. } = performance;
    let range = recipe.first_frame as usize..recipe.end_frame as usize;
    let far = warn_far(rig, &take.take, &range, ui)?;
    say_what_changes_nothing(args, &take.take, path, !far.is_empty());
    warn_head_left_out(args, format, &take.take);
    Ok(far)
}

/// Warns once about all frames of `range` that are far outside the examples. Returns them, as frames of the
/// take.
fn warn_far(rig: &Rig, take: &Take, range: &Range<usize>, ui: &Ui) -> Result<Vec<Range<usize>>> {
    if rig.learned().is_none() || rig.examples().names.is_empty() {
        return Ok(Vec::new());
    }
    let asked = take.slice(range.clone());
    let far = coverage::take_sigma(rig, &asked, &Regions::by_handles(rig), ui)?.far;
    let Some(worst) = far.iter().max_by(|a, b| a.times.total_cmp(&b.times)) else { return Ok(Vec::new()) };
    let frames: usize = far.iter().map(|stretch| stretch.frames).sum();
    let first = |stretch: &coverage::Far| range.start + stretch.first;
    let stretches: Vec<String> = far
        .iter()
        .take(STRETCHES)
        .map(|stretch| match stretch.frames {
            1 => first(stretch).to_string(),
            n => format!("{}..{}", first(stretch), first(stretch) + n),
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
    Ok(far.iter().map(|stretch| first(stretch)..first(stretch) + stretch.frames).collect())
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
