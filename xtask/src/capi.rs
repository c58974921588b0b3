//! `cargo xtask capi`: the C interface as a folder that C and C++ programs install.
use crate::run::{Result, cargo, root, run};
use clap::Args;
use std::path::PathBuf;

#[path = "../../crates/capi/install/layout.rs"]
mod layout;

/// The options of the chore.
#[derive(Args)]
pub(crate) struct Capi {
    /// The folder that gets include and lib. A relative one is below the repository's root.
    #[arg(long, value_name = "FOLDER", default_value = "target/capi")]
    out: PathBuf,
    /// Build without optimization of the dependencies, which takes less time. The result is slow.
    #[arg(long)]
    dev: bool,
    /// The backends and "takes", separated by commas, instead of all.
    #[arg(long, value_name = "LIST")]
    features: Option<String>,
}

/// Builds the shared and the static library, and lays them out with the headers.
pub(crate) fn capi(options: &Capi) -> Result {
    let mut build =
        cargo(&["rustc", "--package", "rhytid-capi", "--lib", "--crate-type", "cdylib,staticlib"]);
    build.args((!options.dev).then_some("--release"));
    if let Some(features) = &options.features {
        build.args(["--no-default-features", "--features", features]);
    }
    run(build)?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let built = target.join(if options.dev { "debug" } else { "release" });
    let out = root().join(&options.out);
    layout::lay_out(&root().join("crates/capi"), &built, &out)?;
    println!(
        "{}: give it to CMake as CMAKE_PREFIX_PATH, or its lib/pkgconfig as PKG_CONFIG_PATH",
        out.display()
    );
    Ok(())
}
