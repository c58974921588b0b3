//! `cargo xtask web`: builds the browser's pages. The work is done by a program of its own, `xtask/web`.
use crate::run::{Result, cargo, root, run};
use std::net::SocketAddr;
use std::path::PathBuf;

/// What to do with the pages.
#[derive(clap::Args)]
pub(crate) struct Web {
    /// The folder to build into, which any static host serves [default: target/pages].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Serve it, to this machine alone unless another address is named.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8000")]
    serve: Option<SocketAddr>,
}

/// Builds the pages, and serves them if asked to.
pub(crate) fn web(options: &Web) -> Result {
    // What is typed is meant from where it is typed, and the chores run in the root.
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
