//! The same frame in NumPy, Numba and C++, timed in turns with the CPU backend: `cargo xtask bench`.
//!
//! Each peer is a process that gets the rig's arrays as files. Its results must agree with Rhytid's before
//! its time is printed. Every ratio is of times measured side by side, with the same number of threads.
#![forbid(unsafe_code)]

mod compare;
mod folder;
mod ours;
mod peer;
mod quick;
mod rig;
mod table;
mod times;

use clap::Parser;
use compare::{Checker, Differences};
use ours::Ours;
use peer::{Implementation, Peer};
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Backend, BasisStorage, Result};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use times::Times;

/// Frames in a batch.
const FRAMES: usize = 32;

/// Times Rhytid's CPU backend beside the same frame in other languages.
#[derive(Parser)]
#[command(name = "rhytid-peers")]
struct Args {
    /// The rig. If it does not exist, the demo face is solved and stored there.
    rig: PathBuf,
    /// About how many vertices the demo face has.
    #[arg(long, value_name = "N", default_value_t = 530_000)]
    vertices: u32,
    /// The Python with the packages of xtask/requirements-peers.txt.
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: PathBuf,
    /// Time only this peer; can be given several times.
    #[arg(long, value_name = "NAME")]
    peer: Vec<Implementation>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Compare the ratios to Numba with the stored ones, and fail if one is lower by more than 15 %.
    #[arg(long, conflicts_with_all = ["peer", "json"])]
    quick: bool,
    /// Store the ratios to Numba instead.
    #[arg(long, requires = "quick")]
    store: bool,
}

/// The results and the machine.
#[derive(Serialize)]
struct Report {
    rig: String,
    vertices: usize,
    handles: usize,
    strain_edges: usize,
    centers: usize,
    influences: usize,
    machine: String,
    threads: usize,
    version: &'static str,
    peers: Vec<Row>,
}

/// One peer beside Rhytid.
#[derive(Serialize)]
struct Row {
    name: String,
    detail: String,
    /// The largest differences between the peer and Rhytid, over both kinds of evaluation.
    differences: Differences,
    frame: Measured,
    batch: Measured,
}

/// Medians of times that were measured in turns; milliseconds per frame.
#[derive(Serialize)]
struct Measured {
    peer: Times,
    rhytid_f32: Times,
    rhytid_f16: Times,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let chosen: &[Implementation] = match args.peer.as_slice() {
        _ if args.quick => &[Implementation::Numba],
        [] => &Implementation::ALL,
        some => some,
    };
    let report = measure(args, chosen)?;
    if args.quick {
        table::print(&report);
        return quick::run(&report, args.store);
    }
    if args.json {
        table::print_json(&report);
    } else {
        table::print(&report);
    }
    Ok(())
}

fn measure(args: &Args, chosen: &[Implementation]) -> Result<Report> {
    let rig = rig::at(&args.rig, args.vertices)?;
    let handles = rig::handles_over_time(&rig, FRAMES)?;
    let folder = folder::write(&rig, &handles)?;
    let mut f32s = Ours::new(&rig, &handles, BasisStorage::F32)?;
    let mut f16s = Ours::new(&rig, &handles, BasisStorage::F16)?;
    let checker = Checker::new(&rig, &mut f32s)?;
    let threads = rayon::current_num_threads();
    let mut peers = Vec::new();
    for &implementation in chosen {
        eprintln!("{}", implementation.shown());
        let mut peer = Peer::start(implementation, folder.path(), &args.python, threads)?;
        let differences = checker.check(&peer.name, folder.path())?;
        let frame = times::in_turns(&mut [&mut f32s, &mut f16s, &mut peer], times::FRAME)?;
        let batch = times::in_turns(&mut [&mut f32s, &mut f16s, &mut peer], times::BATCH)?;
        let measured = |[rhytid_f32, rhytid_f16, peer]: [Times; 3]| Measured { peer, rhytid_f32, rhytid_f16 };
        peers.push(Row {
            name: peer.name.clone(),
            detail: peer.detail.clone(),
            differences,
            frame: measured(frame),
            batch: measured(batch),
        });
    }
    Ok(Report {
        rig: args.rig.display().to_string(),
        vertices: rig.vertices(),
        handles: rig.handles().len(),
        strain_edges: rig.handles().strain_edges.len(),
        centers: rig.centers(),
        influences: rig.influences().per_vertex(),
        machine: Cpu::devices()?.into_iter().next().map_or_else(String::new, |device| device.name),
        threads,
        version: env!("CARGO_PKG_VERSION"),
        peers,
    })
}
