//! `cargo xtask package`: packs every published crate, and checks that the packages compile by themselves and
//! work for a newcomer.
use crate::run::{Result, cargo, command, copy, output, root, run};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The unpublished members of the workspace. `xtask-kernels` is unpublished too, but packed. With it, the
/// packages' dependencies have the same features as in the tests.
const PRIVATE: [&str; 9] = [
    "rhytid-capi",
    "rhytid-examples",
    "rhytid-peers",
    "rhytid-player",
    "rhytid-python",
    "rhytid-test-support",
    "rhytid-web",
    "xtask",
    "xtask-web",
];

/// How a crate of the repository names the library, and how other crates do.
const LIBRARY: (&str, &str) = ("rhytid = { path = \"../../crates/rhytid\" }", "rhytid = \"*\"");

/// A newcomer's programs, and the largest number of lines of their `main`.
const NEWCOMERS: [(&str, usize); 2] = [("animate", 12), ("game", 15)];

/// Packs as `cargo publish --workspace` would.
///
/// Cargo's own check builds each package from nothing, which takes as long as everything else together. Here
/// the packages are unpacked side by side and built at once. In this workspace each package replaces the one
/// of its name on crates.io. `examples/outside` is built with them. It is a newcomer's crate that knows only
/// the library's name. It makes a file from a take, and plays a game.
pub(crate) fn package() -> Result {
    let target = root().join("target");
    let packages = target.join("package");
    // Packages of an older version would be unpacked too.
    remove(&packages)?;
    let mut pack = cargo(&["package", "--workspace", "--no-verify", "--allow-dirty"]);
    pack.args(PRIVATE.iter().flat_map(|name| ["--exclude", name])).arg("--target-dir").arg(&target);
    run(pack)?;

    let unpacked = packages.join("unpacked");
    let io = |e: std::io::Error| format!("{}: {e}", unpacked.display());
    fs::create_dir_all(&unpacked).map_err(io)?;
    for entry in fs::read_dir(&packages).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.extension().is_some_and(|extension| extension == "crate") {
            // Files get today's date. Packages have no dates, and cargo would take files of another version
            // for compiled ones.
            let mut unpack = command("tar", &["-m", "--extract", "--gzip", "--directory"]);
            unpack.arg(&unpacked).arg("--file").arg(&path);
            run(unpack)?;
        }
    }
    let manifest = manifest(&unpacked)?;
    newcomer(&unpacked)?;
    fs::write(unpacked.join("Cargo.toml"), manifest).map_err(io)?;
    copy(&root().join("Cargo.lock"), &unpacked.join("Cargo.lock"))?;
    // `--examples` gives the dependencies the features that the tests need, although the packages have no
    // examples.
    let targets = ["--lib", "--bins", "--examples"];
    let mut build = cargo(&[&["build", "--workspace"], &targets[..], &["--target-dir"]].concat());
    build.arg(&target).current_dir(&unpacked);
    run(build)?;
    play(&target.join("debug"))?;
    remove(&unpacked)
}

/// A workspace of all packages in `folder`. Each package replaces the one of its name on crates.io.
/// Dependencies use the repository's profile, and are therefore already compiled. The packages themselves are
/// compiled in the shortest time.
fn manifest(folder: &Path) -> Result<String> {
    let io = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut text = "[workspace]\nresolver = \"3\"\nmembers = [\"*\"]\n\n[patch.crates-io]\n".to_owned();
    let mut profile = development_profile()?;
    let folders: std::io::Result<Vec<_>> = fs::read_dir(folder).map_err(io)?.collect();
    for package in folders.map_err(io)? {
        let package = package.file_name().to_string_lossy().into_owned();
        let (name, _) = package.rsplit_once('-').ok_or_else(|| format!("{package} has no version"))?;
        writeln!(text, "{name} = {{ path = \"{package}\" }}").expect("writing to a string");
        writeln!(profile, "{name}.opt-level = 0").expect("writing to a string");
    }
    Ok(text + &profile)
}

/// The repository's `[profile.dev]` and `[profile.dev.package]`, without entries for its own packages.
fn development_profile() -> Result<String> {
    let path = root().join("Cargo.toml");
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let tables =
        text.split_once("\n[profile.dev]\n").and_then(|(_, rest)| rest.split_once("\n[profile.release"));
    let (tables, _) = tables.ok_or("Cargo.toml has no [profile.dev] before a [profile.release]")?;
    let others = tables.lines().filter(|line| !line.starts_with("rhytid") && !line.starts_with("xtask"));
    Ok(format!("\n[profile.dev]\n{}\n", others.collect::<Vec<_>>().join("\n").trim_end()))
}

/// Copies `examples/outside` to the packages in `folder`, in the form that its author would have.
fn newcomer(folder: &Path) -> Result {
    let (ours, theirs) = (root().join("examples/outside"), folder.join("outside"));
    let io = |e: std::io::Error| format!("{}: {e}", ours.display());
    fs::create_dir_all(theirs.join("src/bin")).map_err(io)?;
    for (program, most_lines) in NEWCOMERS {
        let source = format!("src/bin/{program}.rs");
        copy(&ours.join(&source), &theirs.join(&source))?;
        let text = fs::read_to_string(ours.join(&source)).map_err(io)?;
        let lines = lines_of_main(&text).ok_or_else(|| format!("{source} has no main"))?;
        if lines > most_lines {
            return Err(format!("{source}: main has {lines} lines, expected at most {most_lines}"));
        }
    }
    let manifest = fs::read_to_string(ours.join("Cargo.toml")).map_err(io)?;
    if !manifest.contains("[workspace]\n") || !manifest.contains(LIBRARY.0) {
        return Err(format!("{}: Cargo.toml has no [workspace] or not “{}”", ours.display(), LIBRARY.0));
    }
    let manifest = manifest.replace("[workspace]\n", "").replace(LIBRARY.0, LIBRARY.1);
    fs::write(theirs.join("Cargo.toml"), manifest).map_err(io)
}

/// How many lines the body of `main` has.
fn lines_of_main(source: &str) -> Option<usize> {
    let (_, body) = source.split_once("fn main()")?;
    let (body, _) = body.split_once("\n}")?;
    Some(body.lines().count() - 1)
}

/// Lets the newcomer's programs among `programs` make a file and play a game. The packed program makes their
/// scans and take.
fn play(programs: &Path) -> Result {
    let demo = programs.join("demo");
    let io = |e: std::io::Error| format!("{}: {e}", demo.display());
    fs::create_dir_all(&demo).map_err(io)?;
    let mut make = command(programs.join("rhytid"), &["--quiet", "demo", "--vertices", "2000"]);
    make.arg(&demo);
    run(make)?;
    let said = |program: &str| {
        let mut newcomer = Command::new(programs.join(program));
        newcomer.current_dir(&demo);
        output(newcomer).ok_or_else(|| format!("examples/outside: {program} failed"))
    };
    remove_file(&demo.join("face.usd"))?;
    let made = said("animate")?;
    let bytes = fs::metadata(demo.join("face.usd")).map_err(io)?.len();
    if made != format!("face.usd has {bytes} bytes") {
        return Err(format!("examples/outside: animate wrote {bytes} bytes, and said “{made}”"));
    }
    // The packed program compares the newcomer's file with its own frames.
    let files = ["--rig", "face.safetensors", "--take", "performance.csv", "face.usd"];
    let mut verify = command(programs.join("rhytid"), &[&["--quiet", "verify"], &files[..]].concat());
    verify.current_dir(&demo);
    run(verify)?;
    let played = said("game")?;
    let mut places: Vec<&str> =
        played.lines().filter_map(|line| line.split_once(": ")).map(|(_, at)| at).collect();
    let frames = places.len();
    places.dedup();
    if frames == 60 && places.len() > 1 {
        return Ok(());
    }
    Err(format!("examples/outside: expected 60 frames that move, found “{played}”"))
}

/// Removes a file, if it is there.
fn remove_file(file: &Path) -> Result {
    match fs::remove_file(file) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {e}", file.display())),
        _ => Ok(()),
    }
}

/// Removes a folder, if it is there.
fn remove(folder: &Path) -> Result {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {e}", folder.display())),
        _ => Ok(()),
    }
}
