//! A peer: a process that evaluates on request. `peer.py` describes the requests and the answers.
use crate::times::{Side, Times, What};
use clap::ValueEnum;
use rhytid_core::{Error, Result};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Where the peers' sources are.
const SOURCES: &str = env!("CARGO_MANIFEST_DIR");

/// The same frame, written for one language.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Implementation {
    Numpy,
    Numba,
    /// C++ and OpenMP with `-O3`.
    Cpp,
    /// The same with `-ffast-math`.
    CppFastMath,
}

impl Implementation {
    /// The slowest first.
    pub(crate) const ALL: [Self; 4] = [Self::Numpy, Self::Numba, Self::Cpp, Self::CppFastMath];

    /// The name for progress messages.
    pub(crate) fn shown(self) -> &'static str {
        match self {
            Self::Numpy => "NumPy …",
            Self::Numba => "Numba …",
            Self::Cpp => "C++ …",
            Self::CppFastMath => "C++ with -ffast-math …",
        }
    }

    /// The program to start. C++ peers are built first.
    fn command(self, folder: &Path, python: &Path) -> Result<Command> {
        let script = |name: &str| {
            let mut command = Command::new(python);
            command.arg(Path::new(SOURCES).join(name)).env("PYTHONDONTWRITEBYTECODE", "1");
            // Freed memory is kept for the next arrays. Otherwise NumPy is only half as fast.
            command.env("MALLOC_MMAP_THRESHOLD_", "4294967296").env("MALLOC_TRIM_THRESHOLD_", "8589934592");
            Ok(command)
        };
        match self {
            Self::Numpy => script("numpy_frame.py"),
            Self::Numba => script("numba_frame.py"),
            Self::Cpp => compiled(folder, &["-O3"]),
            Self::CppFastMath => compiled(folder, &["-O3", "-ffast-math"]),
        }
    }
}

/// Builds `frame.cpp` into `folder` with `options`.
fn compiled(folder: &Path, options: &[&str]) -> Result<Command> {
    let program = folder.join("frame");
    let build = format!("-DBUILD=\"{}\"", options.join(" "));
    let mut compiler = Command::new("g++");
    compiler.args(["-std=c++17", "-march=native", "-fopenmp", &build]).args(options);
    compiler.arg(Path::new(SOURCES).join("frame.cpp")).arg("-o").arg(&program);
    match compiler.status() {
        Ok(status) if status.success() => Ok(Command::new(program)),
        Ok(status) => Err(Error::Internal(format!("frame.cpp does not compile with g++ ({status})"))),
        Err(e) => {
            Err(Error::input(format!("g++ cannot be run ({e}); install it, or leave out the peers in C++")))
        }
    }
}

/// A running peer; it ends when this is dropped.
pub(crate) struct Peer {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// The peer's own name.
    pub name: String,
    /// Versions of its tools.
    pub detail: String,
}

/// The first line of a peer.
#[derive(Deserialize)]
struct Introduction {
    name: String,
    detail: String,
}

impl Peer {
    /// Starts the peer on the arrays in `folder`. Waits until it has evaluated once and written its results
    /// there.
    ///
    /// # Errors
    /// [`Error::Input`] if it cannot be started; [`Error::Internal`] if it fails, after a message on stderr.
    pub(crate) fn start(
        implementation: Implementation,
        folder: &Path,
        python: &Path,
        threads: usize,
    ) -> Result<Self> {
        let mut command = implementation.command(folder, python)?;
        command.arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
        for variable in ["OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"] {
            command.env(variable, threads.to_string());
        }
        Self::spawn(command)
    }

    fn spawn(mut command: Command) -> Result<Self> {
        let name = command.get_program().display().to_string();
        let mut process = command
            .spawn()
            .map_err(|e| Error::input(format!("{name} cannot be run ({e}); is it installed?")))?;
        let (Some(questions), Some(answers)) = (process.stdin.take(), process.stdout.take()) else {
            return Err(Error::Internal(format!("{name} was started without pipes")));
        };
        let answers = BufReader::new(answers);
        let mut peer = Self { process, questions, answers, name, detail: String::new() };
        let introduction: Introduction = peer.answer()?;
        peer.name = introduction.name;
        peer.detail = introduction.detail;
        Ok(peer)
    }

    /// The next line of the peer.
    fn answer<T: DeserializeOwned>(&mut self) -> Result<T> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line);
        if !matches!(read, Ok(bytes) if bytes > 0) {
            return Err(Error::Internal(format!(
                "the peer {} ended early; what it said is above",
                self.name
            )));
        }
        serde_json::from_str(&line)
            .map_err(|e| Error::Internal(format!("the peer {} said “{}” ({e})", self.name, line.trim())))
    }
}

impl Side for Peer {
    fn evaluate(&mut self, what: What) -> Result<Times> {
        let asked = writeln!(self.questions, "{}", what.name()).and_then(|()| self.questions.flush());
        asked.map_err(|e| Error::Internal(format!("the peer {} does not listen ({e})", self.name)))?;
        self.answer()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // The peer is idle and has nothing to clean up. It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Result<Peer> {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped());
        Peer::spawn(command)
    }

    #[test]
    fn a_peer_says_what_it_is_and_answers_each_question() {
        let times = r#"{"large_scale": 1, "large_scale_normals": 2, "detail": 3, "normals": 4, "whole": 10}"#;
        let introduction = r#"{"name": "a", "detail": "b"}"#;
        let script = format!("echo '{introduction}'; read what; echo '{times}'; read what; echo $what");
        let mut peer = shell(&script).unwrap();
        assert_eq!((peer.name.as_str(), peer.detail.as_str()), ("a", "b"));
        assert_eq!(peer.evaluate(What::Frame).unwrap().parts(), [1.0, 2.0, 3.0, 4.0, 0.0, 10.0]);
        let error = peer.evaluate(What::Batch).unwrap_err().to_string();
        assert!(error.contains("the peer a said “batch”"), "{error}");
        assert!(peer.evaluate(What::Batch).is_err());
    }

    #[test]
    fn a_peer_that_fails_is_an_error() {
        let error = shell("exit 1").err().unwrap().to_string();
        assert!(error.contains("ended early"), "{error}");
    }
}
