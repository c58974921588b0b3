//! `cargo xtask web`: builds the browser's pages, prints their sizes, and serves them on request.
//! `cargo xtask player` builds the npm package instead.
#![forbid(unsafe_code)]

use clap::Parser;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use xtask_web::{Result, Server, Size, Warnings, build, build_player};

/// The same options as in `xtask/src/web.rs`, which passes them on. `player` stands for `cargo xtask player`.
#[derive(Parser)]
struct Web {
    #[arg(long)]
    out: PathBuf,
    #[arg(long)]
    serve: Option<SocketAddr>,
    #[arg(long)]
    player: bool,
}

fn main() -> ExitCode {
    match web(&Web::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn web(options: &Web) -> Result {
    let files = if options.player {
        build_player(&options.out, Warnings::Show)?
    } else {
        build(&options.out, Warnings::Show)?
    };
    let kilobytes = |bytes: u64| bytes as f64 / 1e3;
    println!("{}:", options.out.display());
    for Size { name, bytes, is_data } in &files {
        println!("{:9.1} kB  {name}{}", kilobytes(*bytes), if *is_data { "  (data)" } else { "" });
    }
    let program: u64 = files.iter().filter(|file| !file.is_data).map(|file| file.bytes).sum();
    println!("{:9.1} kB  without data", kilobytes(program));
    let Some(address) = options.serve else { return Ok(()) };
    let server = Server::new(address, &options.out)?;
    println!("http://{}/ until Ctrl-C", server.address()?);
    server.run();
    Ok(())
}
