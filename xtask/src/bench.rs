//! `cargo xtask bench`: Rhytid beside its peers. It is never a test. It installs its needs at first use.
use crate::run::{Result, cargo, root, run};
use crate::{debian, python};

/// What to time; `--peers` or `--quick`.
#[derive(clap::Args)]
pub(crate) struct Bench {
    /// Time one frame and a batch of 32 beside NumPy, Numba and C++, and the solve's linear system beside
    /// CHOLMOD, once their results agree.
    #[arg(long, required_unless_present = "quick", conflicts_with = "quick")]
    peers: bool,
    /// Compare the ratio to Numba with the one in benches/peers/ratios.json. Fail if it is 15 % lower.
    #[arg(long)]
    quick: bool,
    /// Store that ratio instead.
    #[arg(long, requires = "quick")]
    store: bool,
    /// About how many vertices the face has.
    #[arg(long, value_name = "N", default_value_t = 530_000, value_parser = clap::value_parser!(u32).range(2_000..=4_000_000), conflicts_with = "quick")]
    vertices: u32,
    /// Print JSON, of the frames alone.
    #[arg(long, requires = "peers")]
    json: bool,
}

/// Installs the peers, then runs them on the demo face, which is solved once and kept under `target/bench`.
pub(crate) fn bench(options: &Bench) -> Result {
    debian::install_missing(&debian::PEERS)?;
    let python = python::peers()?;
    let vertices = options.vertices.to_string();
    let rig = root().join("target/bench").join(format!("face-{vertices}.safetensors"));
    let mut peers = cargo(&["run", "--quiet", "--release", "--package", "rhytid-peers", "--"]);
    peers.arg(&rig).args(["--vertices", &vertices, "--python"]).arg(&python);
    for (flag, is_set) in [("--quick", options.quick), ("--store", options.store), ("--json", options.json)] {
        if is_set {
            peers.arg(flag);
        }
    }
    run(peers)?;
    if options.peers && !options.json {
        let mut solve = cargo(&["bench", "--quiet", "--package", "rhytid-solve", "--bench", "solve", "--"]);
        solve.arg("--rig").arg(rig).arg("--peer").arg(python);
        run(solve)?;
    }
    Ok(())
}
