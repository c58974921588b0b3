//! `cargo xtask kernels`: compiles the Vulkan kernels, or checks that the kernels of all languages agree.
use crate::run::{Result, cargo, root, run};
use std::fs;

/// Makes each kernel's `NAME.spv` from its `NAME.comp`, or with `check` checks every kernel against the table in
/// `crates/kernels/src/table.rs`. The work is done by a program of its own, which needs what `setup` installs.
pub(crate) fn kernels(check: bool) -> Result {
    if check {
        return run(cargo(&["run", "--quiet", "--package", "xtask-kernels", "--", "--check"]));
    }
    place_holders()?;
    run(cargo(&["run", "--quiet", "--package", "xtask-kernels"]))
}

/// The table includes every `.spv`, so that a new kernel's must be there before it can be made.
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
