//! Debian's packages that the chores need.
use crate::run::{Result, command, output, run, succeeds};
use std::path::Path;

/// Packages that the tests run or are checked with, besides Python and Node.js.
const PACKAGES: [&str; 36] = [
    // fincore, which tells how much of a file is in memory.
    "util-linux-extra",
    // Vulkan: the loader, the lavapipe driver, the validation layers, `spirv-val`.
    "libvulkan1",
    "mesa-vulkan-drivers",
    "vulkan-validationlayers",
    "spirv-tools",
    // OpenCL: the loader, which `xtask/kernels` links, the PoCL driver, and a device that finds data races.
    "ocl-icd-opencl-dev",
    "pocl-opencl-icd",
    "oclgrind",
    // glslang is C++. The C interface is used with two compilers, CMake and pkg-config, and under valgrind.
    // Its example draws with Vulkan: headers, and a compiler for shaders.
    "g++",
    "clang",
    "cmake",
    "make",
    "pkg-config",
    "valgrind",
    "libvulkan-dev",
    "glslang-tools",
    // wgpu's OpenGL ES backend without a display.
    "libegl1",
    "libgles2",
    "libgl1-mesa-dri",
    // A browser for our own pages and for three.js. It also brings SwiftShader, a second Vulkan driver on the
    // CPU.
    "chromium",
    // Other programs that open films and moving pictures: `ffmpeg` and `ffprobe`; `webpinfo`, `webpmux` and
    // `dwebp`.
    "ffmpeg",
    "webp",
    // A library that many programs read glTF with.
    "libassimp5",
    // A scheduler of render farms, and `munged`, which its programs need to trust each other.
    "munge",
    "slurm-wlm",
    // A display in memory for the window, and a program that moves its pointer and presses its keys.
    "xvfb",
    "xdotool",
    // Libraries that a window loads, besides Blender's below.
    "libx11-xcb1",
    "libxcursor1",
    "libxkbcommon-x11-0",
    // Libraries that Blender's Python module is linked with, besides the OpenGL above. Each package brings
    // its own dependencies.
    "libgl1",
    "libxfixes3",
    "libxi6",
    "libxkbcommon0",
    "libxrender1",
    "libxt6",
];

/// Packages that the bench's peers are built with. Without OpenBLAS, CHOLMOD would use the reference BLAS,
/// which is many times slower.
pub(crate) const PEERS: [&str; 3] = ["g++", "libsuitesparse-dev", "libopenblas0-pthread"];

/// The SwiftShader driver of Debian's Chromium: its description for the Vulkan loader.
pub(crate) const SWIFTSHADER_ICD: &str = "/usr/lib/chromium/vk_swiftshader_icd.json";

/// The missing ones of [`PACKAGES`], as [`missing`] finds them.
pub(crate) fn missing_packages() -> Vec<&'static str> {
    missing(&PACKAGES)
}

/// The missing ones of `packages`. Without dpkg it prints the needs, and assumes that everything is
/// installed.
fn missing(packages: &[&'static str]) -> Vec<&'static str> {
    if !succeeds(command("dpkg-query", &["--version"])) {
        eprintln!("it cannot be told without dpkg whether these are installed, by Debian's names:");
        eprintln!("    {}", packages.join(" "));
        return Vec::new();
    }
    packages.iter().copied().filter(|package| !is_installed(package)).collect()
}

/// Installs the missing ones of `packages`.
pub(crate) fn install_missing(packages: &[&'static str]) -> Result {
    match missing(packages).as_slice() {
        [] => Ok(()),
        missing => install(missing),
    }
}

/// Returns no also for a removed package that left its settings.
fn is_installed(package: &str) -> bool {
    let status = output(command("dpkg-query", &["--show", "--showformat", "${db:Status-Status}\n", package]));
    status.is_some_and(|status| status.lines().any(|line| line == "installed"))
}

/// Installs `packages` without questions, with sudo unless this is root.
pub(crate) fn install(packages: &[&str]) -> Result {
    let list = packages.join(" ");
    let missing = |e| format!("{list} missing: {e}; install them by hand, then try again");
    apt_get(&["update", "-qq"]).map_err(missing)?;
    apt_get(&[&["install", "-y", "--no-install-recommends"], packages].concat()).map_err(missing)
}

/// Runs `apt-get` with `args` as root.
fn apt_get(args: &[&str]) -> Result {
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

/// An error if the SwiftShader driver is not where the tests look for it, as on a system other than Debian.
pub(crate) fn swiftshader() -> Result {
    if Path::new(SWIFTSHADER_ICD).is_file() {
        return Ok(());
    }
    Err(format!(
        "the tests need the SwiftShader Vulkan driver as {SWIFTSHADER_ICD}, where Debian's Chromium has it: put \
         vk_swiftshader_icd.json and libvk_swiftshader.so of a Chromium there, then try again"
    ))
}
