//! `cargo xtask kernels`: compiles the Vulkan kernels, or checks that the kernels of all languages agree.
use crate::run::{Result, cargo, root, run};
use std::fs;

/// Makes each kernel's `NAME.spv` from its `NAME.comp`. With `check`, compares every kernel with the table in
/// `crates/kernels/src/table.rs` instead. A program of its own does the work; `setup` installs its needs.
pub(crate) fn kernels(check: bool) -> Result {
    if check {
        return run(cargo(&["run", "--quiet", "--package", "xtask-kernels", "--", "--check"]));
    }
    place_holders()?;
    run(cargo(&["run", "--quiet", "--package", "xtask-kernels"]))
}

/// The table includes every `.spv`, so a new kernel's file must exist before it can be made.
fn place_holders() -> Result {
    let kernels = root().join("crates/kernels/src");
    let folders = fs::read_dir(&kernels).map_err(|e| format!("{}: {e}", kernels.display()))?;
    for folder in folders.filter_map(std::result::Result::ok).map(|entry| entry.path()) {
        let Some(name) = folder.file_name().map(|name| folder.join(name)) else { continue };
        let spv = name.with_extension("spv");
        if name.with_extension("comp").is_file() && !spv.exists() {
            fs::write(&spv, []).map_err(|e| format!("{}: {e}", spv.display()))?;
        }
    }
    Ok(())
}
