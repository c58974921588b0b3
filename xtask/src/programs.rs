//! Test programs: built by cargo in one go, and run, with their messages and times.
use crate::run::{Result, cannot_run, cargo, shown};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The prefix of a message on standard error about a test that does nothing here: `SKIPPED: name: why`.
const SKIPPED: &str = "SKIPPED: ";

/// The lines that are kept of a failed test.
const FAILURE_LINES: usize = 12;

/// The tests within a library's or a program's own code.
const UNIT_TESTS: &str = "unit tests";

/// A program that runs tests.
pub(crate) struct Program {
    pub package: String,
    /// `unit tests`, or the name of the file or folder under the package's `tests`.
    pub target: String,
    executable: PathBuf,
    /// The working folder that cargo would use: the package's own.
    folder: PathBuf,
}

/// Numbers of tests by outcome.
#[derive(Default)]
pub(crate) struct Counts {
    pub passed: u64,
    pub failed: u64,
    pub ignored: u64,
    pub filtered_out: u64,
    /// Skipped tests with their reasons. The harness counts them as passed.
    pub skipped: BTreeMap<String, String>,
    /// What failed, and the first lines that it said.
    pub failures: Vec<String>,
    /// Whether the lines are those of a failed test.
    is_failure: bool,
}

/// Messages and times of programs, in the order in which they ran.
#[derive(Default)]
pub(crate) struct Runs(Vec<(String, Counts, Spent)>);

/// The time of a piece of work.
#[derive(Clone, Copy)]
pub(crate) struct Spent {
    pub wall: Duration,
    /// Time of all processors in seconds; `None` if the system does not tell.
    pub processor: Option<f64>,
}

/// Runs `work` and returns its time.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Spent) {
    let start = Instant::now();
    let children = || Some(ProcessorSeconds::read("self")?.children);
    let before = children();
    let done = work();
    let processor = children().zip(before).map(|(after, before)| after - before);
    (done, Spent { wall: start.elapsed(), processor })
}

/// A process's time of all processors, in seconds.
struct ProcessorSeconds {
    own: f64,
    /// Time of its ended children, and of theirs.
    children: f64,
}

impl ProcessorSeconds {
    /// The times of a running process, by its number, on Linux.
    fn read(process: &str) -> Option<Self> {
        let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
        // Fields from the third one on. The second field is the program's name, which may contain blanks.
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        // Linux reports hundredths of seconds to programs, with any internal unit.
        let seconds = |field: usize| Some(fields.get(field - 3)?.parse::<f64>().ok()? / 100.0);
        Some(Self { own: seconds(14)? + seconds(15)?, children: seconds(16)? + seconds(17)? })
    }
}

/// Lets cargo build the test programs of these `options` of `cargo test`.
pub(crate) fn build(options: &[&str]) -> Result<Vec<Program>> {
    let options = [&["test", "--no-run", "--message-format=json-render-diagnostics"], options].concat();
    let mut command = cargo(&options);
    let shown = shown(&command);
    eprintln!("$ {shown}");
    let output = command.stderr(Stdio::inherit()).output().map_err(|e| cannot_run(&shown, &e))?;
    if !output.status.success() {
        return Err(format!("`{shown}` failed ({})", output.status));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter_map(|line| program(&serde_json::from_str(line).ok()?)).collect())
}

/// The test program of one of cargo's messages.
fn program(message: &Value) -> Option<Program> {
    let is_test = message["reason"] == "compiler-artifact" && message["profile"]["test"] == true;
    let executable = message["executable"].as_str().filter(|_| is_test)?;
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
    let target = &message["target"];
    let is_integration = target["kind"][0] == "test";
    Some(Program {
        package: package(message["package_id"].as_str()?, folder)?,
        target: if is_integration { target["name"].as_str()? } else { UNIT_TESTS }.to_owned(),
        executable: executable.into(),
        folder: folder.to_owned(),
    })
}

/// The name in `path+file:///…/crates/core#rhytid-core@0.1.0`. The identifier leaves the name out if it
/// equals the folder's.
fn package(id: &str, folder: &Path) -> Option<String> {
    let name = id.rsplit_once('#')?.1.split_once('@').map(|(name, _)| name);
    name.map_or_else(|| folder.file_name()?.to_str(), Some).map(str::to_owned)
}

impl Program {
    /// The package and the target.
    pub(crate) fn name(&self) -> String {
        format!("{} {}", self.package, self.target)
    }

    /// The program with `arguments`, as cargo would run it.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.executable);
        command.args(arguments).current_dir(&self.folder).env("CARGO_MANIFEST_DIR", &self.folder);
        command
    }
}

impl Runs {
    /// Runs a test program, or a cargo that runs some, under a name.
    pub(crate) fn run(&mut self, name: &str, command: Command) -> Result {
        eprintln!("\n$ {}", shown(&command));
        let start = Instant::now();
        let (counts, processor) = run(name, command)?;
        self.0.push((name.to_owned(), counts, Spent { wall: start.elapsed(), processor }));
        Ok(())
    }

    /// Does work that runs no tests, and keeps its time. Its processor time is unknown, because it may run
    /// beside other programs.
    pub(crate) fn time(&mut self, name: &str, work: impl FnOnce() -> Result) -> Result {
        let start = Instant::now();
        let outcome = work();
        let spent = Spent { wall: start.elapsed(), processor: None };
        self.0.push((name.to_owned(), Counts::default(), spent));
        outcome
    }

    /// Adds the results of programs that ran at the same time.
    pub(crate) fn append(&mut self, beside: &mut Runs) {
        self.0.append(&mut beside.0);
    }

    fn sum(&self, of: impl Fn(&Counts) -> u64) -> u64 {
        self.0.iter().map(|(_, counts, _)| of(counts)).sum()
    }

    pub(crate) fn passed(&self) -> u64 {
        self.sum(|counts| counts.passed.saturating_sub(counts.skipped.len() as u64))
    }

    pub(crate) fn failed(&self) -> u64 {
        self.sum(|counts| counts.failed)
    }

    pub(crate) fn skipped(&self) -> u64 {
        self.sum(|counts| counts.ignored + counts.skipped.len() as u64)
    }

    pub(crate) fn filtered_out(&self) -> u64 {
        self.sum(|counts| counts.filtered_out)
    }

    /// Prints the time of each program, the longest first, and the reasons of skipped tests.
    pub(crate) fn print(&self) {
        let mut runs: Vec<_> = self.0.iter().collect();
        runs.sort_by_key(|(_, _, spent)| std::cmp::Reverse(spent.wall));
        println!();
        for (name, counts, spent) in runs {
            println!("{spent}  {:6} tests  {name}", counts.passed + counts.failed + counts.ignored);
        }
        for (name, counts, _) in &self.0 {
            for (test, why) in &counts.skipped {
                println!("skipped: {name}: {test}: {why}");
            }
        }
    }

    /// Prints what failed, and the line that closes a run. They come last, because logs are cut at the front.
    pub(crate) fn print_counts(&self) {
        for (name, counts, _) in &self.0 {
            counts.failures.iter().for_each(|failure| println!("\nfailed: {name}: {failure}"));
        }
        println!("\ntests: {} passed, {} failed, {} skipped", self.passed(), self.failed(), self.skipped());
    }
}

impl std::fmt::Display for Spent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:7.1} s", self.wall.as_secs_f64())?;
        self.processor.map_or(Ok(()), |seconds| write!(f, "  {seconds:7.1} s of processors"))
    }
}

/// Runs `command`, passes its output on line by line behind its name, and counts. Also returns its time of
/// all processors.
fn run(name: &str, mut command: Command) -> Result<(Counts, Option<f64>)> {
    let shown = shown(&command);
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(|e| cannot_run(&shown, &e))?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    // Under the chores' own tests, the made-up output must not be counted.
    let (out, err): (Box<dyn Write + Send>, Box<dyn Write + Send>) = match cfg!(test) {
        true => (Box::new(std::io::sink()), Box::new(std::io::sink())),
        false => (Box::new(std::io::stdout()), Box::new(std::io::stderr())),
    };
    let mut counts = Counts::default();
    let mut skipped = BTreeMap::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            lines(name, stderr, err, |line| {
                if let Some((test, why)) = line.strip_prefix(SKIPPED).and_then(|said| said.split_once(": ")) {
                    skipped.insert(test.to_owned(), why.to_owned());
                }
            });
        });
        lines(name, stdout, out, |line| counts.add(line));
    });
    counts.skipped = skipped;
    // The child has closed its output. It stays readable until it is waited for.
    let seconds = ProcessorSeconds::read(&child.id().to_string());
    let status = child.wait().map_err(|e| format!("`{shown}`: {e}"))?;
    if !status.success() && counts.failed == 0 {
        counts.failures.push(format!("ended without a failed test, but with {status}"));
        counts.failed = 1;
    }
    Ok((counts, seconds.map(|seconds| seconds.own + seconds.children)))
}

/// Passes each line on behind `name`, since another program may run at the same time. Shows it to `look`.
fn lines(name: &str, from: Option<impl Read>, mut to: impl Write, mut look: impl FnMut(&str)) {
    let mut line = Vec::new();
    let mut from = from.map(BufReader::new);
    while from.as_mut().is_some_and(|from| from.read_until(b'\n', &mut line).is_ok_and(|length| length > 0)) {
        // If nobody reads the output any more, counting goes on.
        let _ = to.write_all(&[name.as_bytes(), b": ", &line].concat());
        look(String::from_utf8_lossy(&line).trim_end());
        line.clear();
    }
}

impl Counts {
    /// Adds the numbers of a line that closes a run: `test result: ok. 12 passed; 0 failed; 1 ignored; …`.
    ///
    /// The lines of a failed test come between `---- its name stdout ----` and the list of names.
    fn add(&mut self, line: &str) {
        if let Some(test) = line.strip_prefix("---- ").and_then(|line| line.strip_suffix(" stdout ----")) {
            self.failures.push(test.to_owned());
            self.is_failure = true;
        } else if line == "failures:" {
            self.is_failure = false;
        } else if self.is_failure
            && let Some(failure) = self.failures.last_mut()
            && failure.lines().count() < FAILURE_LINES
        {
            *failure += &format!("\n    {line}");
        }
        let Some(summary) = line.strip_prefix("test result: ") else { return };
        let words: Vec<&str> = summary.split([' ', ';']).filter(|word| !word.is_empty()).collect();
        let count = |word: &str| {
            let pair = words.windows(2).find(|pair| pair[1] == word);
            pair.and_then(|pair| pair[0].parse().ok()).unwrap_or(0)
        };
        self.passed += count("passed");
        self.failed += count("failed");
        self.ignored += count("ignored");
        self.filtered_out += count("filtered");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read_from_a_closing_line() {
        let mut counts = Counts::default();
        counts.add("test result: FAILED. 12 passed; 3 failed; 1 ignored; 0 measured; 7 filtered out; finished in 0.52s");
        counts.add("test result: ok.");
        assert_eq!([counts.passed, counts.failed, counts.ignored, counts.filtered_out], [12, 3, 1, 7]);
    }

    #[test]
    fn what_a_failed_test_said_is_kept() {
        let mut counts = Counts::default();
        let lines = [
            "failures:",
            "",
            "---- a::b stdout ----",
            "thread panicked:",
            "1, not 2",
            "",
            "failures:",
            "    a::b",
        ];
        lines.iter().for_each(|line| counts.add(line));
        assert_eq!(counts.failures, ["a::b\n    thread panicked:\n    1, not 2\n    "]);
    }

    /// Runs a shell's script as if it were a test program.
    fn runs(script: &str) -> Runs {
        let mut runs = Runs::default();
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        runs.run("script", command).unwrap();
        runs
    }

    #[test]
    #[cfg(unix)]
    fn a_test_that_does_nothing_is_skipped_and_has_not_passed() {
        let skip = "echo 'SKIPPED: a::b: no data here' >&2";
        let runs = runs(&format!("{skip}; {skip}; echo 'test result: ok. 3 passed; 0 failed; 1 ignored;'"));
        assert_eq!([runs.passed(), runs.failed(), runs.skipped()], [2, 0, 2]);
    }

    #[test]
    #[cfg(unix)]
    fn a_program_that_crashes_has_failed() {
        let runs = runs("kill -9 $$");
        assert_eq!(runs.failed(), 1);
        assert!(runs.0[0].1.failures[0].contains("signal: 9"), "{:?}", runs.0[0].1.failures);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn processor_time_is_that_of_children() {
        let busy = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        let (_, spent) = timed(|| Command::new("sh").args(["-c", busy]).status());
        let is_plausible = |spent: &Spent| {
            let seconds = spent.processor.unwrap();
            assert!(seconds > 0.01 && seconds <= spent.wall.as_secs_f64() + 0.05, "{seconds}");
        };
        is_plausible(&spent);
        is_plausible(&runs(busy).0[0].2);
    }

    #[test]
    fn programs_are_found_in_what_cargo_says() {
        let message = |kind: &str, is_test: bool| {
            serde_json::json!({
                "reason": "compiler-artifact", "package_id": "path+file:///r/crates/core#rhytid-core@0.1.0",
                "manifest_path": "/r/crates/core/Cargo.toml", "target": { "kind": [kind], "name": "plan" },
                "profile": { "test": is_test }, "executable": "/r/target/debug/deps/plan-1",
            })
        };
        let name = |kind, is_test| program(&message(kind, is_test)).map(|program| program.name());
        assert_eq!(name("test", true).unwrap(), "rhytid-core plan");
        assert_eq!(name("lib", true).unwrap(), "rhytid-core unit tests");
        assert_eq!(name("bin", false), None);
        assert_eq!(package("path+file:///r/xtask#0.1.0", Path::new("/r/xtask")).unwrap(), "xtask");
    }
}
