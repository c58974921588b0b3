//! The project's chores, one file each.
//!
//! `cargo xtask check | setup | test | prose | kernels | web | player | capi | python | blender | package |
//! deny | fuzz | bench | heads | collections | clients`
#![forbid(unsafe_code)]

mod bench;
mod blender;
mod capi;
mod check;
mod clients;
mod collections;
mod debian;
mod deny;
mod fuzz;
mod heads;
mod kernels;
mod library;
mod package;
mod programs;
mod prose;
mod python;
mod run;
mod setup;
mod steps;
mod test;
mod web;
mod wheel;

use clap::Parser;
use std::process::ExitCode;

/// The project's chores.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Chore {
    /// Check formatting, lints and the tests that need no setup. It takes less than two minutes after a small
    /// change.
    Check,
    /// Install what the tests need: software GPU drivers, USD, Blender, a browser, a glTF validator.
    Setup,
    /// Set up, then check formatting, kernels, lints, tests and documentation.
    Test,
    /// Measure sentences, lines and tables of all pages and doc comments, and find words that only this
    /// project uses.
    Prose,
    /// Compile the Vulkan kernels' GLSL to the SPIR-V beside it.
    Kernels {
        /// Check that the SPIR-V is fresh and that the kernels of all languages agree with the table, and
        /// write nothing.
        #[arg(long)]
        check: bool,
    },
    /// Build the browser's pages into a folder that any static host serves.
    Web(web::Web),
    /// Build the npm package @rhytid/player, with which three.js draws faces.
    Player(web::Player),
    /// Build the C interface, and lay it out as a folder that C and C++ programs install.
    Capi(capi::Capi),
    /// Build the Python package as a wheel, and try it in empty environments.
    Python(wheel::Python),
    /// Pack the Blender extension with the wheel of the Python package, and check the zip.
    Blender(blender::Blender),
    /// Pack every published crate, and check that the packages compile and work for a newcomer.
    Package,
    /// Check licences, duplicate versions, sources and advisories of all dependencies with cargo-deny.
    Deny,
    /// Run every fuzz target for a while.
    Fuzz {
        /// How long each target runs.
        #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
        seconds: u32,
        /// Repeat the targets in turns, for this many hours in all.
        #[arg(long, value_name = "H", value_parser = clap::value_parser!(u32).range(1..))]
        hours: Option<u32>,
    },
    /// Time Rhytid beside the same computation in other languages.
    Bench(bench::Bench),
    /// Measure how far rigs are from the truth, on heads of different makers.
    Heads(heads::Heads),
    /// Read public collections of meshes with Rhytid and with other programs, and table the differences.
    Collections(collections::Collections),
    /// Open exports with other programs, and write the table of docs/clients.md.
    Clients(clients::Clients),
}

fn main() -> ExitCode {
    let outcome = match Chore::parse() {
        Chore::Check => check::check(),
        Chore::Setup => setup::setup(),
        Chore::Test => test::test(),
        Chore::Prose => prose::prose(),
        Chore::Kernels { check } => kernels::kernels(check),
        Chore::Web(options) => web::web(&options),
        Chore::Player(options) => web::player(&options),
        Chore::Capi(options) => capi::capi(&options),
        Chore::Python(options) => wheel::python(&options),
        Chore::Blender(options) => blender::blender(&options),
        Chore::Package => package::package(),
        Chore::Deny => deny::deny(),
        Chore::Fuzz { seconds, hours } => fuzz::fuzz(seconds, hours),
        Chore::Bench(options) => bench::bench(&options),
        Chore::Heads(options) => heads::heads(&options),
        Chore::Collections(options) => collections::collections(&options),
        Chore::Clients(options) => clients::clients(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
