//! The commands, one file each.

pub(crate) mod animate;
mod bench;
mod completions;
mod conform;
mod correct;
mod coverage;
mod demo;
mod devices;
mod doctor;
mod evaluate;
mod explain;
mod export_shapes;
mod farm;
mod handles;
mod info;
mod listen;
mod lod;
mod man;
mod new;
mod pack;
mod placing;
mod prepare;
mod recording_file;
#[cfg(feature = "wgpu")]
mod render;
mod send;
mod solve;
mod stitch;
mod transfer;
mod verify;
#[cfg(feature = "view")]
mod view;

use crate::args::{Args, Command};
use crate::exit_code;
use crate::progress::Ui;
use rhytid::Result;

/// Runs the command.
///
/// # Errors
/// As the command's.
pub(crate) fn run(args: &Args, ui: &Ui) -> Result<u8> {
    rhytid::core::set_most_pixels(args.max_pixels);
    match &args.command {
        Command::New(args) => new::run(args, ui)?,
        Command::Solve(args) => solve::run(args, ui)?,
        Command::Animate(args) => return animate::run(args, ui),
        #[cfg(feature = "wgpu")]
        Command::Render(args) => render::run(args, ui)?,
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args)?,
        Command::Send(args) => send::run(args, ui)?,
        Command::Transfer(args) => transfer::run(args, ui)?,
        Command::Pack(args) => pack::run(args, ui)?,
        Command::Lod(args) => lod::run(args, ui)?,
        Command::Farm(args) => return farm::run(args, ui),
        Command::FarmTask(args) => return farm::task(args, ui),
        Command::Stitch(args) => stitch::run(args, ui)?,
        Command::ExportShapes(args) => export_shapes::run(args, ui)?,
        Command::Verify(args) => return verify::run(args, ui),
        Command::Handles(args) => handles::run(args, ui)?,
        Command::Prepare(args) => prepare::run(args, ui)?,
        Command::Evaluate(args) => evaluate::run(args, ui)?,
        Command::Coverage(args) => coverage::run(args, ui)?,
        Command::Correct(args) => correct::run(args, ui)?,
        Command::Explain(args) => explain::run(args, ui)?,
        Command::Info(args) => info::run(args)?,
        Command::Devices(args) => devices::run(args)?,
        Command::Conform(args) => return conform::run(args, ui),
        Command::Bench(args) => bench::run(args, ui)?,
        Command::Doctor(args) => return doctor::run(args, ui),
        Command::Demo(args) => demo::run(args, ui)?,
        Command::Completions(args) => completions::run(args)?,
        Command::Man(args) => man::run(args, ui)?,
        Command::Look(args) => conform::look(&args.request)?,
    }
    Ok(exit_code::DONE)
}
