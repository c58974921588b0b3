//! `rhytid animate` of several takes: one mesh with one set of shapes, and a clip for each take.

use super::options::export_options;
use super::warnings::warn;
use super::{Animated, ClipOf, Prepared, perform, take_name};
use crate::progress::Ui;
use crate::{args, inputs};
use rhytid::formats::animation;
use rhytid::formats::export::{Recipe, ShapeSet, unique_names};
use rhytid::playback::{Performance, export_clips};
use rhytid::{Error, Result};
use std::time::Instant;

/// The animated file of all takes.
///
/// # Errors
/// As [`export_clips`] and reading the takes.
pub(super) fn make(args: &args::Animate, prepared: Prepared, ui: &Ui) -> Result<Animated> {
    let Prepared { rig, layers: _, recipe, onto, regions: _, device, format } = prepared;
    let mut performances: Vec<Performance> = Vec::with_capacity(args.takes.len());
    for path in &args.takes {
        let in_file = |error: Error| error.in_file(path.display());
        let take = inputs::take(path, &rig, &args.reading, ui)?;
        let recipe = Recipe { treatment: args.reading.treatment(Some(path))?, ..recipe.clone() };
        let performance = perform(args, rig.clone(), None, recipe, take).map_err(in_file)?;
        warn(args, format, &performance, Some(path), ui)?;
        performances.push(performance);
    }
    let metres_per_unit = rig.surface().metres_per_unit;
    let options = export_options(args, metres_per_unit, onto);
    let devices = inputs::devices(device, ui)?;
    let start = Instant::now();
    let (written, device) = export_clips(&performances, &devices, &args.output, &options, ui)?;
    let of_take = |(name, performance): (String, &Performance)| ClipOf {
        name,
        frames: performance.selection.inner.len(),
        rate: performance.selection.rate,
    };
    let names = args.takes.iter().map(|take| take_name(take)).collect::<Vec<_>>();
    let names = unique_names(names.iter().map(String::as_str));
    let clips = names.into_iter().zip(&performances).map(of_take).collect();
    Ok(Animated { clips, metres_per_unit, device, time: start.elapsed(), written })
}

/// An option that is for one take is a mistake, and so is a format.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn check(args: &args::Animate) -> Result<()> {
    if args.takes.len() < 2 {
        return Ok(());
    }
    let onto = args.onto.as_ref().map(|_| ShapeSet::default());
    animation::check_clips(&args.output, args.takes.len(), &export_options(args, 1.0, onto))?;
    let given = [
        (args.edit.is_some(), "--edit"),
        (args.masks.is_some(), "--masks"),
        (args.strain_curves.is_some(), "--strain-curves"),
    ];
    match given.into_iter().find(|(given, _)| *given) {
        Some((_, option)) => Err(Error::conflict(format!(
            "{option} is for one take, found {}; leave it out, or animate the takes one by one",
            args.takes.len()
        ))),
        None => Ok(()),
    }
}
