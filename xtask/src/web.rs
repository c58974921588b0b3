//! `cargo xtask web` builds the browser's pages, and `cargo xtask player` the npm package. A program of its
//! own, `xtask/web`, does the work.
use crate::run::{Result, cargo, root, run};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What to do with the pages.
#[derive(clap::Args)]
pub(crate) struct Web {
    /// The folder to build into, which any static host serves [default: target/pages].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Serve the pages; only to this machine, unless another address is given.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8000")]
    serve: Option<SocketAddr>,
}

/// What to do with the npm package.
#[derive(clap::Args)]
pub(crate) struct Player {
    /// The folder to build into, which `npm publish` takes as it is [default: target/player].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Builds the npm package.
pub(crate) fn player(options: &Player) -> Result {
    run(build(options.out.as_deref(), "player", &["--player"])?)
}

/// Builds the pages, and serves them on request.
pub(crate) fn web(options: &Web) -> Result {
    let mut web = build(options.out.as_deref(), "pages", &[])?;
    if let Some(address) = options.serve {
        web.arg("--serve").arg(address.to_string());
    }
    run(web)
}

/// The program that builds into a folder, or into one of this name under `target`.
fn build(out: Option<&Path>, name: &str, options: &[&str]) -> Result<Command> {
    // A typed path is relative to the user's folder, but the chores run in the root.
    let out = match out {
        Some(out) => std::path::absolute(out).map_err(|e| format!("{}: {e}", out.display()))?,
        None => root().join("target").join(name),
    };
    let mut program = cargo(&["run", "--quiet", "--package", "xtask-web", "--"]);
    program.args(options).arg("--out").arg(out);
    Ok(program)
}
