//! `cargo xtask python`: the Python package as a wheel and as sources, tried in environments of its own.
use crate::python;
use crate::run::{Result, command, output, root, run, succeeds};
use std::fs;
use std::path::{Path, PathBuf};

/// The Pythons that one wheel serves, the oldest first. Those that are installed are tried.
const PYTHONS: [&str; 5] = ["python3.10", "python3.11", "python3.12", "python3.13", "python3.14"];

/// What to do with the package.
#[derive(clap::Args)]
pub(crate) struct Python {
    /// Write the types of the commands' options (`python/rhytid/_commands.pyi`), and build nothing.
    #[arg(long)]
    stubs: bool,
    /// The folder to build into.
    #[arg(long, value_name = "DIR", default_value = WHEELS)]
    out: PathBuf,
}

/// Where wheels are built.
pub(crate) const WHEELS: &str = "target/wheels";

impl Default for Python {
    fn default() -> Self {
        Self { stubs: false, out: WHEELS.into() }
    }
}

/// Builds the wheel and the sources, and tries the wheel in an empty environment of each Python, without
/// Rust.
pub(crate) fn python(options: &Python) -> Result {
    let python = python::package()?;
    if options.stubs {
        return stubs(&python);
    }
    let out = root().join(&options.out);
    let _ = fs::remove_dir_all(&out);
    for arguments in [&["build", "--release", "--locked"][..], &["sdist"]] {
        let mut maturin = command(&python, &["-m", "maturin"]);
        maturin.args(arguments).arg("--out").arg(&out).current_dir(root().join("python"));
        run(maturin)?;
    }
    let wheel = wheel(&out)?;
    let mut tried = Vec::new();
    for name in PYTHONS {
        if succeeds(command(name, &["-c", "import venv, ensurepip"])) {
            try_in_empty_environment(name, &wheel)?;
            tried.push(name);
        }
    }
    match tried.is_empty() {
        true => Err(format!("none of {} is installed, so that the wheel was not tried", PYTHONS.join(", "))),
        false => {
            eprintln!("{} works with {}", wheel.display(), tried.join(", "));
            Ok(())
        }
    }
}

/// The wheel in a folder.
pub(crate) fn wheel(folder: &Path) -> Result<PathBuf> {
    let files = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files = files.flatten().map(|entry| entry.path());
    files
        .find(|path| path.extension().is_some_and(|extension| extension == "whl"))
        .ok_or_else(|| format!("{}: maturin left no wheel there", folder.display()))
}

/// Installs the wheel with NumPy alone, and goes from scans to a file: by the script, and by ten lines whose
/// file has to have the same bytes.
fn try_in_empty_environment(name: &str, wheel: &Path) -> Result {
    let folder = root().join("target/tmp/wheel").join(name);
    let _ = fs::remove_dir_all(&folder);
    let mut make = command(name, &["-m", "venv"]);
    make.arg(folder.join("venv"));
    run(make)?;
    let bin = folder.join("venv/bin");
    let mut install =
        command(bin.join("python"), &["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
    install.arg(wheel);
    run(install)?;
    // Neither Rust nor another Python can be found.
    let alone = |program: &str, arguments: &[&str]| {
        let mut command = command(bin.join(program), arguments);
        command.current_dir(&folder).env("PATH", &bin).env_remove("PYTHONPATH");
        command
    };
    run(alone("rhytid", &["demo", "--vertices", "2000", "face"]))?;
    run(alone("python", &["-c", TEN_LINES]))?;
    let words =
        ["animate", "face/face.safetensors", "face/performance.csv", "-o", "theirs.usd", "--device", "cpu:0"];
    run(alone("rhytid", &words))?;
    let read = |name: &str| fs::read(folder.join(name)).map_err(|e| format!("{name}: {e}"));
    if read("ours.usd")? != read("theirs.usd")? {
        return Err(format!("{name}: ours.usd and theirs.usd differ in {}", folder.display()));
    }
    let version = output(alone("python", &["-c", "import sys; print(sys.version.split()[0])"]));
    eprintln!("{}: ten lines, and the same bytes as the program", version.unwrap_or_default());
    Ok(())
}

/// From scans to a file.
const TEN_LINES: &str = "
import rhytid
face = rhytid.Face.open('face/face.toml')
rig = face.solve()
rig.save('ours.safetensors')
take = rhytid.Take.open('face/performance.csv', rig)
animation = rig.play(take, device='cpu:0')
assert animation[100].positions.shape == rig.vertices.shape
animation.write('ours.usd')
";

/// Writes the types, with the compiled half that is built for it.
fn stubs(python: &Path) -> Result {
    run(crate::run::cargo(&["build", "--package", "rhytid-python"]))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let folder = root().join("python/rhytid");
    let compiled = folder.join("_rhytid.abi3.so");
    let built = target.join("debug/lib_rhytid.so");
    fs::copy(&built, &compiled).map_err(|e| format!("{}: {e}", built.display()))?;
    let mut write = command(python, &["stubs.py"]);
    write.current_dir(root().join("python")).env("PYTHONDONTWRITEBYTECODE", "1");
    let written = run(write);
    let _ = fs::remove_file(compiled);
    written
}
