//! `cargo xtask check`: the most useful checks, as early as possible after a change. It needs no setup, and
//! lists the tests that it leaves out.
use crate::programs::{Runs, build};
use crate::prose;
use crate::run::{Result, cargo, output};
use crate::steps::Steps;
use crate::test::{WORKSPACE, documentation, format, lints, outcome};
use serde_json::Value;

/// Tests that only `cargo xtask test` runs.
struct LeftOut {
    package: &'static str,
    /// The folder or file under the package's `tests`; `None` for all tests of the package.
    target: Option<&'static str>,
    /// The beginnings of the tests' names; empty for all tests of the target.
    tests: &'static [&'static str],
    why: &'static str,
}

const LEFT_OUT: &[LeftOut] = &[
    package("rhytid-backend-vulkan", "needs drivers"),
    package("rhytid-backend-opencl", "needs drivers"),
    package("rhytid-backend-wgpu", "needs drivers"),
    package("rhytid-cli", "starts the whole program some thousand times"),
    package("rhytid-peers", "the bench's peers"),
    package("rhytid-python", "needs Python's packages, which `cargo xtask setup` installs"),
    package("xtask", "the chores themselves"),
    package("xtask-kernels", "needs a C++ compiler; kernels are checked by `cargo xtask kernels --check`"),
    package("xtask-web", "opens the browser's pages in Chromium"),
    target("rhytid-conformance", "devices", "needs drivers; the CPU is conformance's in this check"),
    target("rhytid-conformance", "sessions", "needs drivers, and makes thousands of sessions"),
    target(
        "rhytid-capi",
        "capi",
        "needs C compilers, valgrind and CMake, which `cargo xtask setup` installs",
    ),
    target("rhytid-formats", "gltf_memory", "writes much"),
    tests(
        "rhytid-conformance",
        "conformance",
        &["real_data::", "coverage::", "other_data::", "other_topology::"],
        "real faces: solved many times",
    ),
    tests("rhytid-capture", "capture", &["real_take::", "handles::"], "a real take, cleaned many times"),
    tests(
        "rhytid-formats",
        "formats",
        &[
            "clips::",
            "export::usd",
            "gltf::files",
            "gltf::motion",
            "gltf::shapes",
            "gltf::surface",
            "gltf::validator",
        ],
        "asks USD's library, Khronos' validator or three.js, which `cargo xtask setup` installs",
    ),
    tests(
        "rhytid-formats",
        "formats",
        &["raw_take::ezc3d", "stitch::", "usd_read::"],
        "asks ezc3d or USD's library, which `cargo xtask setup` installs",
    ),
];

const fn package(package: &'static str, why: &'static str) -> LeftOut {
    LeftOut { package, target: None, tests: &[], why }
}

const fn target(package: &'static str, target: &'static str, why: &'static str) -> LeftOut {
    tests(package, target, &[], why)
}

const fn tests(
    package: &'static str,
    target: &'static str,
    tests: &'static [&'static str],
    why: &'static str,
) -> LeftOut {
    LeftOut { package, target: Some(target), tests, why }
}

/// Formatting, lints, documentation, and all tests but [`LEFT_OUT`]; stops at the first step that fails.
pub(crate) fn check() -> Result {
    let mut steps = Steps::default();
    let mut runs = Runs::default();
    let outcome = all(&mut steps, &mut runs);
    steps.print();
    runs.print();
    println!(
        "\nleft for `cargo xtask test`, beside the kernels' freshness, the runtime alone and in browsers, a newcomer's crate and the \
         packages:"
    );
    for left_out in LEFT_OUT {
        println!("  {left_out}: {}", left_out.why);
    }
    println!("  with them {} tests of the programs that ran", runs.filtered_out());
    runs.print_counts();
    outcome
}

fn all(steps: &mut Steps, runs: &mut Runs) -> Result {
    steps.step("format", format)?;
    steps.step("prose", prose::prose)?;
    steps.step("lints", lints)?;
    steps.step("documentation", documentation)?;
    let programs =
        steps.step("build tests", || build(&options()?.iter().map(String::as_str).collect::<Vec<_>>()))?;
    steps.step("tests", || {
        for program in &programs {
            let of_program =
                || LEFT_OUT.iter().filter(|left_out| left_out.is_about(&program.package, &program.target));
            if !of_program().any(|left_out| left_out.tests.is_empty()) {
                let skip = of_program().flat_map(|left_out| left_out.tests).flat_map(|test| ["--skip", test]);
                runs.run(&program.name(), program.command(&skip.collect::<Vec<_>>()))?;
            }
        }
        outcome(runs)
    })
}

/// The options of `cargo test` that build little more than the programs. The features are those of `cargo
/// xtask test`, so that both share compiled crates.
fn options() -> Result<Vec<String>> {
    let metadata = output(cargo(&["metadata", "--no-deps", "--format-version", "1"]));
    let metadata: Value = serde_json::from_str(&metadata.ok_or("`cargo metadata` failed")?)
        .map_err(|e| format!("`cargo metadata` is not understood: {e}"))?;
    let targets = targets(&metadata);
    for left_out in LEFT_OUT {
        if !targets.iter().any(|(package, target)| left_out.package == *package && left_out.target == *target)
        {
            return Err(format!("xtask/src/check.rs leaves out {left_out}, which is not there"));
        }
    }
    let runs = |package: &str, target: &str| {
        let mut of_target = LEFT_OUT.iter().filter(|left_out| left_out.is_about(package, target));
        of_target.all(|left_out| !left_out.tests.is_empty())
    };
    let mut options: Vec<String> = WORKSPACE.map(str::to_owned).to_vec();
    options.push("--lib".into());
    let integration = targets.iter().filter_map(|&(package, target)| Some((package, target?)));
    for (_, target) in integration.filter(|(package, target)| runs(package, target)) {
        options.extend(["--test".into(), target.to_owned()]);
    }
    Ok(options)
}

/// A package of the workspace, and one of its integration tests; `None` for the package itself.
type Target<'a> = (&'a str, Option<&'a str>);

fn targets(metadata: &Value) -> Vec<Target<'_>> {
    metadata["packages"].as_array().into_iter().flatten().filter_map(targets_of).flatten().collect()
}

fn targets_of(package: &Value) -> Option<Vec<Target<'_>>> {
    let name = package["name"].as_str()?;
    let tests = package["targets"].as_array()?.iter().filter(|target| target["kind"][0] == "test");
    Some(tests.map(|test| (name, test["name"].as_str())).chain([(name, None)]).collect())
}

impl LeftOut {
    fn is_about(&self, package: &str, target: &str) -> bool {
        self.package == package && self.target.is_none_or(|own| own == target)
    }
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.package)?;
        self.target.map_or(Ok(()), |target| write!(f, " {target}"))?;
        if self.tests.is_empty() { Ok(()) } else { write!(f, " ({})", self.tests.join(", ")) }
    }
}
