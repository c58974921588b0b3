//! The folder that C and C++ programs install: `include`, `lib`, `lib/pkgconfig` and `lib/cmake/Rhytid`. It
//! may be moved. `cargo xtask capi` and the tests of the C interface share this file.
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::Path;

/// The libraries of the system that the static library needs: what `rustc --print native-static-libs` says.
/// Known for Linux alone; elsewhere programs name them.
const SYSTEM: &[&str] = if cfg!(target_os = "linux") {
    &["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"]
} else {
    &[]
};

/// Lays out what is in `crate_folder` (`crates/capi`) and the libraries in `libraries` (such as
/// `target/release`) below `out`. Files that are there are overwritten. The static library may be absent.
pub(crate) fn lay_out(crate_folder: &Path, libraries: &Path, out: &Path) -> Result<(), String> {
    let wrong = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let copy = |from: &Path, to: &Path| fs::copy(from, to).map(drop).map_err(|e| wrong(from, e));
    let folders = ["include", "lib/pkgconfig", "lib/cmake/Rhytid"].map(|folder| out.join(folder));
    for folder in &folders {
        fs::create_dir_all(folder).map_err(|e| wrong(folder, e))?;
    }
    let [include, pkgconfig, cmake] = &folders;
    for header in ["rhytid.h", "rhytid.hpp"] {
        copy(&crate_folder.join("include").join(header), &include.join(header))?;
    }
    let shared = format!("{DLL_PREFIX}rhytid_c{DLL_SUFFIX}");
    copy(&libraries.join(&shared), &out.join("lib").join(&shared))?;
    for further in ["librhytid_c.a", "rhytid_c.lib", "rhytid_c.dll.lib"] {
        if libraries.join(further).is_file() {
            copy(&libraries.join(further), &out.join("lib").join(further))?;
        }
    }
    for (file, folder) in
        [("rhytid.pc", pkgconfig), ("RhytidConfig.cmake", cmake), ("RhytidConfigVersion.cmake", cmake)]
    {
        let from = crate_folder.join("install").join(file);
        let text = fs::read_to_string(&from).map_err(|e| wrong(&from, e))?;
        let separator = if file.ends_with(".pc") { " " } else { ";" };
        let text =
            text.replace("@VERSION@", env!("CARGO_PKG_VERSION")).replace("@SYSTEM@", &SYSTEM.join(separator));
        let to = folder.join(file);
        fs::write(&to, text).map_err(|e| wrong(&to, e))?;
    }
    Ok(())
}
