//! `cargo xtask web`: builds the browser's pages. A program of its own, `xtask/web`, does the work.
use crate::run::{Result, cargo, root, run};
use std::net::SocketAddr;
use std::path::PathBuf;

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

/// Builds the pages, and serves them on request.
pub(crate) fn web(options: &Web) -> Result {
    // A typed path is relative to the user's folder, but the chores run in the root.
    let out = match &options.out {
        Some(out) => std::path::absolute(out).map_err(|e| format!("{}: {e}", out.display()))?,
        None => root().join("target/pages"),
    };
    let mut web = cargo(&["run", "--quiet", "--package", "xtask-web", "--", "--out"]);
    web.arg(out);
    if let Some(address) = options.serve {
        web.arg("--serve").arg(address.to_string());
    }
    run(web)
}
