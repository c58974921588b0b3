//! What `setup` installs by Debian's names: the system's packages, and a driver out of one of them.
use crate::run::{Result, command, output, root, run, succeeds};
use std::fs;
use std::path::{Path, PathBuf};

/// What the GPU backends are built, run and checked with, on the CPU.
const GPU_PACKAGES: [&str; 11] = [
    // Vulkan: the loader, the lavapipe driver, the validation layers, `spirv-val`.
    "libvulkan1",
    "mesa-vulkan-drivers",
    "vulkan-validationlayers",
    "spirv-tools",
    // OpenCL: the loader to link with, the PoCL driver, and a device that finds data races.
    "ocl-icd-opencl-dev",
    "pocl-opencl-icd",
    "oclgrind",
    // glslang is C++.
    "g++",
    // wgpu's OpenGL ES backend without a display.
    "libegl1",
    "libgles2",
    "libgl1-mesa-dri",
];

/// The package that has the SwiftShader driver, and the driver in it.
const SWIFTSHADER_PACKAGE: &str = "chromium-common";
const SWIFTSHADER_FILES: [&str; 2] = ["libvk_swiftshader.so", "vk_swiftshader_icd.json"];

/// Those of [`GPU_PACKAGES`] that are not installed. Where there is no dpkg to ask, it says what is needed, and
/// takes it as being there.
pub fn missing_gpu_packages() -> Vec<&'static str> {
    if !succeeds(command("dpkg-query", &["--version"])) {
        eprintln!("setup cannot tell without dpkg whether these are installed, by Debian's names:");
        eprintln!("    {}", GPU_PACKAGES.join(" "));
        return Vec::new();
    }
    GPU_PACKAGES.into_iter().filter(|package| !is_installed(package)).collect()
}

/// Also says no to what was removed and has left its settings.
fn is_installed(package: &str) -> bool {
    let status = output(command("dpkg-query", &["--show", "--showformat", "${db:Status-Status}\n", package]));
    status.is_some_and(|status| status.lines().any(|line| line == "installed"))
}

/// Installs `packages` without questions, by sudo where this is not root.
pub fn install(packages: &[&str]) -> Result {
    let list = packages.join(" ");
    let missing = |e| format!("{list} missing: {e}; install them by hand, then try again");
    update_lists().map_err(missing)?;
    as_root(&[&["install", "-y", "--no-install-recommends"], packages].concat()).map_err(missing)
}

/// Fetches the lists of packages.
fn update_lists() -> Result {
    as_root(&["update", "-qq"])
}

/// Runs `apt-get` with `args`.
fn as_root(args: &[&str]) -> Result {
    if !succeeds(command("apt-get", &["--version"])) {
        return Err("there is no apt-get here".into());
    }
    let is_root = output(command("id", &["-u"])).as_deref() == Some("0");
    if !is_root && !succeeds(command("sudo", &["--version"])) {
        return Err("this is neither root nor a user with sudo".into());
    }
    let (program, first) = if is_root { ("env", None) } else { ("sudo", Some("env")) };
    let mut command = command(program, &[]);
    command.args(first).arg("DEBIAN_FRONTEND=noninteractive").arg("apt-get").args(args);
    run(command)
}

/// Where the SwiftShader driver is once it is there: its description for the Vulkan loader.
pub fn swiftshader_icd() -> PathBuf {
    root().join("target/swiftshader/vk_swiftshader_icd.json")
}

/// Takes the SwiftShader driver, a second Vulkan on the CPU, out of Debian's Chromium into `target/swiftshader`.
/// Chromium itself, with all that it depends on, is not installed.
pub fn swiftshader() -> Result {
    let kept = root().join("target/swiftshader");
    if SWIFTSHADER_FILES.iter().all(|name| kept.join(name).is_file()) {
        return Ok(());
    }
    for program in ["apt-get", "dpkg-deb"] {
        if !succeeds(command(program, &["--version"])) {
            return Err(format!(
                "the tests need the SwiftShader Vulkan driver, and there is no {program} here to get it: put {} \
                 of a Chromium into {}, then try again",
                SWIFTSHADER_FILES.join(" and "),
                kept.display()
            ));
        }
    }
    let unpacked = root().join("target/swiftshader.unpacked");
    let outcome = unpack_swiftshader(&unpacked, &kept);
    // The rest of the package: some 100 MB.
    let removed = fs::remove_dir_all(&unpacked).map_err(|e| format!("{}: {e}", unpacked.display()));
    outcome.and(removed)
}

fn unpack_swiftshader(unpacked: &Path, kept: &Path) -> Result {
    let made = |folder: &Path| fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()));
    // What a run that was stopped has left would be taken for the package.
    let _ = fs::remove_dir_all(unpacked);
    made(unpacked)?;
    made(kept)?;
    let download = || {
        let mut download = command("apt-get", &["download", "-qq", SWIFTSHADER_PACKAGE]);
        download.current_dir(unpacked);
        run(download)
    };
    // Where nothing had to be installed, the lists may be old or not there.
    download().or_else(|_| update_lists().and_then(|()| download())).map_err(|e| {
        format!("{e}: {SWIFTSHADER_PACKAGE}, which has the SwiftShader Vulkan driver, could not be fetched")
    })?;
    let entries = fs::read_dir(unpacked).map_err(|e| format!("{}: {e}", unpacked.display()))?;
    let mut paths = entries.filter_map(std::result::Result::ok).map(|entry| entry.path());
    let package = paths
        .find(|path| path.extension().is_some_and(|extension| extension == "deb"))
        .ok_or(format!("`apt-get download {SWIFTSHADER_PACKAGE}` has left no package"))?;
    let mut extract = command("dpkg-deb", &["--extract"]);
    extract.arg(&package).arg(unpacked);
    run(extract)?;
    for name in SWIFTSHADER_FILES {
        let from = unpacked.join("usr/lib/chromium").join(name);
        fs::copy(&from, kept.join(name))
            .map_err(|e| format!("{SWIFTSHADER_PACKAGE} has no usr/lib/chromium/{name}: {e}"))?;
    }
    Ok(())
}
