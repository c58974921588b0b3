//! A rig and a take in files, compilers, and the library that cargo has built.
use rhytid::{NoProgress, Rig, Take};
use rhytid_test_support::skip;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;

/// A small face in files.
pub(crate) struct Files {
    pub(crate) rig: Rig,
    pub(crate) take: Take,
    pub(crate) rig_file: PathBuf,
    pub(crate) take_file: PathBuf,
    /// The programs and what they write go here.
    pub(crate) folder: TempDir,
}

pub(crate) static FILES: LazyLock<Files> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let face = rhytid_demo::face(1_500);
    let take = rhytid_demo::performance(&face).slice(0..20);
    let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let (rig_file, take_file) = (folder.path().join("face.safetensors"), folder.path().join("take.csv"));
    rhytid::write_rig(&rig_file, &rig).unwrap();
    rhytid_takes::take::write(&take_file, &take).unwrap();
    Files { rig, take, rig_file, take_file, folder }
});

/// `crates/capi`.
pub(crate) fn own() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of the library, beside this test program.
pub(crate) fn libraries() -> PathBuf {
    let program = std::env::current_exe().unwrap();
    let folder = program.parent().unwrap().to_owned();
    assert!(folder.join("librhytid_c.so").is_file(), "{}: there is no librhytid_c.so", folder.display());
    folder
}

/// Whether these programs are installed. If not, the test is skipped.
#[track_caller]
pub(crate) fn has(programs: &[&str]) -> bool {
    let is_there = |program: &&&str| Command::new(program).arg("--version").output().is_ok();
    match programs.iter().find(|program| !is_there(program)) {
        Some(missing) => {
            skip(&format!("{missing} is not installed: `cargo xtask setup` installs it"));
            false
        }
        None => true,
    }
}

/// A compiler with its standard and flags. Every warning is an error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Compiler {
    pub(crate) program: &'static str,
    pub(crate) flags: &'static [&'static str],
}

const STRICT: &[&str] = &["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-g"];

pub(crate) const GCC: Compiler = Compiler { program: "gcc", flags: &["-std=gnu99"] };
pub(crate) const CLANG: Compiler = Compiler { program: "clang", flags: &["-std=gnu99"] };
pub(crate) const GXX: Compiler = Compiler { program: "g++", flags: &["-std=c++17"] };
pub(crate) const CLANGXX: Compiler = Compiler { program: "clang++", flags: &["-std=c++17"] };

impl Compiler {
    /// Compiles a program of `tests/capi/programs`, or an example, with these libraries and flags. `None`,
    /// with a skip, without the compiler.
    #[track_caller]
    pub(crate) fn build(self, source: &str, further: &[&str]) -> Option<PathBuf> {
        if !has(&[self.program]) {
            return None;
        }
        let libraries = libraries();
        let name = format!(
            "{}-{}-{}",
            source.replace(['/', '.'], "_"),
            self.program,
            further.concat().replace('/', "_")
        );
        let program = FILES.folder.path().join(name);
        let mut command = Command::new(self.program);
        command.args(self.flags).args(STRICT).arg("-I").arg(own().join("include"));
        command.arg(own().join(source)).arg("-o").arg(&program);
        command.arg("-L").arg(&libraries).arg("-lrhytid_c").arg("-pthread");
        command.arg(format!("-Wl,-rpath,{}", libraries.display())).args(further);
        said(&mut command);
        Some(program)
    }
}

/// Loaders find no driver with these: drivers keep memory that is not the library's fault.
const WITHOUT_DRIVERS: [(&str, &str); 3] = [
    ("VK_DRIVER_FILES", "/dev/null"),
    ("OCL_ICD_VENDORS", "/dev/null"),
    ("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null"),
];

/// As [`command`], in which the processor is the only device.
pub(crate) fn command_without_drivers(program: impl AsRef<OsStr>) -> Command {
    let mut command = command(program);
    command.envs(WITHOUT_DRIVERS);
    command
}

/// A program in the folder of the files, without a device that the user has chosen.
pub(crate) fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command
        .current_dir(FILES.folder.path())
        .env_remove("RHYTID_DEVICE")
        .env_remove("RHYTID_VULKAN_VALIDATION");
    command
}

/// Runs a command, and gives what it says.
///
/// # Panics
/// If it fails.
#[track_caller]
pub(crate) fn said(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{said}{errors}", output.status);
    said.into_owned()
}
