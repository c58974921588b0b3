//! Unknown drivers are tried in child processes. A driver that crashes, hangs or ends its process then ends
//! only that process.

use rhytid_core::{DeviceErrorKind, Error, Progress, Result};
use std::collections::BTreeMap;
use std::fs::DirEntry;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A child that is silent for this long is hanging. It is several times what a slow driver needs. On Linux,
/// the time in which the child waits for a processor does not count, so that a busy machine is no hanging
/// driver.
pub const PATIENCE: Duration = Duration::from_secs(6);

/// The last line of a child. Without it, the child ended early.
const END: &str = "rhytid: done";
/// The prefix of lines that are no answer, but say that work goes on.
const SIGN: &str = "rhytid: ";
/// The prefix of lines of the answer. Lines without a prefix come from a driver.
const ANSWER: &str = "rhytid| ";

/// The protection of this process from drivers.
#[derive(Debug, Clone, Copy)]
pub struct Guard {
    child: Option<fn() -> Command>,
}

impl Guard {
    /// Drivers are tried in this process, and can end it.
    pub const NONE: Self = Self { child: None };

    /// Drivers are tried in children that `command` starts. The command is this program again. Its `main`
    /// passes the arguments that are added there to [`crate::answer`], and prints nothing else on standard
    /// output.
    pub const fn new(command: fn() -> Command) -> Self {
        Self { child: Some(command) }
    }

    /// Whether drivers are tried in children.
    pub fn is_on(self) -> bool {
        self.child.is_some()
    }

    /// The answer of a child to `request`. `device` is named in errors, and the child's environment gets
    /// these `variables`. The child may be silent for [`PATIENCE`]. After each [`Heartbeat`], it may be
    /// silent for as long as `sign` returns, which is called with the heartbeat.
    ///
    /// # Errors
    /// [`Error::Device`] says how the child ended without an answer; [`Error::Cancelled`].
    pub fn ask(
        self,
        request: &[&str],
        device: &str,
        variables: &[(&str, &Path)],
        progress: &dyn Progress,
        mut sign: impl FnMut(&str) -> Duration,
    ) -> Result<String> {
        let fault = |message: String| Error::Device {
            kind: DeviceErrorKind::Driver,
            device: device.to_owned(),
            message,
        };
        let command = self.child.ok_or_else(|| Error::Internal("no command for a child".into()))?;
        let mut child = command()
            .args(request)
            .envs(variables.iter().copied())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map(Killed)
            .map_err(|error| fault(format!("no process could be started to look at it: {error}")))?;
        let lines = lines(&mut child.0);
        let (mut answer, mut ended) = (String::new(), false);
        let process = child.0.id();
        let (mut silence, mut patience) = (Silence::begin(process), PATIENCE);
        loop {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            match lines.recv_timeout(Duration::from_millis(20)) {
                Ok(line) => {
                    silence = Silence::begin(process);
                    if line == END {
                        ended = true;
                    } else if let Some(text) = line.strip_prefix(SIGN) {
                        patience = sign(text);
                    } else if let Some(text) = line.strip_prefix(ANSWER) {
                        answer += text;
                        answer += "\n";
                    }
                }
                Err(RecvTimeoutError::Timeout) if silence.is_longer_than(patience) => {
                    let seconds = patience.as_secs();
                    return Err(fault(format!("its driver hangs: it did not answer for {seconds} s")));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        if ended {
            // A driver's fault at the end of its process does not matter.
            return Ok(answer);
        }
        while !silence.is_longer_than(patience) {
            if let Some(status) = child.0.try_wait().map_err(|error| fault(error.to_string()))? {
                return Err(fault(how(status)));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Err(fault("its driver hangs after closing its output".into()))
    }
}

/// The heartbeat of a child: signs of life for the process that waits.
#[derive(Debug, Clone, Copy)]
pub struct Heartbeat;

impl Heartbeat {
    /// Sends a sign of one line.
    pub fn tell(self, text: &str) {
        // A parent that no longer listens has ended this process, or will end it.
        let mut out = std::io::stdout().lock();
        let _ = writeln!(out, "{SIGN}{text}").and_then(|()| out.flush());
    }

    /// Sends the answer, and the mark that it is complete.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn answer(self, text: &str) -> Result<()> {
        let mut out = std::io::stdout().lock();
        let mut lines = text.lines();
        let told = lines.try_for_each(|line| writeln!(out, "{ANSWER}{line}"));
        let told = told.and_then(|()| writeln!(out, "{END}")).and_then(|()| out.flush());
        told.map_err(Error::io(Path::new("standard output")))
    }
}

/// The time since a child was heard.
struct Silence {
    process: u32,
    since: Instant,
    /// The time that each of its threads had waited for a processor at the beginning.
    waited: BTreeMap<String, Duration>,
}

impl Silence {
    fn begin(process: u32) -> Self {
        Self { process, since: Instant::now(), waited: waited(process) }
    }

    /// Whether it lasts longer than `patience`, less the time in which a thread of the child waited for a
    /// processor. The thread that waited longest counts.
    fn is_longer_than(&self, patience: Duration) -> bool {
        let lasted = self.since.elapsed();
        if lasted <= patience {
            return false;
        }
        let since = |(thread, now): (String, Duration)| {
            now.saturating_sub(self.waited.get(&thread).copied().unwrap_or_default())
        };
        let starved = waited(self.process).into_iter().map(since).max().unwrap_or_default();
        lasted.saturating_sub(starved) > patience
    }
}

/// The time that each thread of a process has been ready and without a processor. Empty except on Linux.
fn waited(process: u32) -> BTreeMap<String, Duration> {
    let threads = std::fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    let of_thread = |thread: DirEntry| {
        // Nanoseconds on a processor, nanoseconds ready, and the number of turns.
        let times = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        let ready = times.split_whitespace().nth(1)?.parse().ok()?;
        Some((thread.file_name().to_string_lossy().into_owned(), Duration::from_nanos(ready)))
    };
    threads.filter_map(of_thread).collect()
}

/// A child that is killed when the value that waits for it is dropped.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        // A child that has ended already need not be killed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The lines of a child's standard output, as they arrive.
fn lines(child: &mut Child) -> Receiver<String> {
    let (send, receive) = channel();
    if let Some(out) = child.stdout.take() {
        std::thread::spawn(move || {
            // No answer is longer than this.
            let mut out = BufReader::new(out.take(1 << 28));
            let mut line = String::new();
            while matches!(out.read_line(&mut line), Ok(read) if read > 0) {
                if send.send(line.trim_end_matches('\n').to_owned()).is_err() {
                    break;
                }
                line.clear();
            }
        });
    }
    receive
}

fn how(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        if let Some(signal) = status.signal() {
            let name = match signal {
                4 => "an illegal instruction, ",
                6 => "abort, ",
                7 => "a bus error: is the disk with its cache full?, ",
                8 => "a division by zero, ",
                9 => "killed: is there too little memory?, ",
                11 => "a wrong address, ",
                _ => "",
            };
            return format!("its driver crashes ({name}signal {signal})");
        }
    }
    match status.code() {
        Some(code) => format!("its driver ends the program that tries it, with exit code {code}"),
        None => "its driver ends the program that tries it".into(),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    fn shell() -> Command {
        let mut command = Command::new("sh");
        command.arg("-c");
        command
    }

    fn asked(script: &str) -> Result<(String, Vec<String>), String> {
        let mut signs = Vec::new();
        let guard = Guard::new(shell);
        let answer = guard.ask(&[script], "vulkan", &[], &NoProgress, |sign| {
            signs.push(sign.to_owned());
            Duration::from_secs(1)
        });
        answer.map(|answer| (answer, signs)).map_err(|error| error.to_string())
    }

    /// Three busy children for each processor: each waits for most of the time.
    #[test]
    #[cfg(target_os = "linux")]
    fn waiting_for_a_processor_is_no_silence() {
        let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let busy = || Command::new("sh").args(["-c", "while :; do :; done"]).spawn().map(Killed).unwrap();
        let children: Vec<Killed> = (0..3 * processors).map(|_| busy()).collect();
        let silences: Vec<Silence> = children.iter().map(|child| Silence::begin(child.0.id())).collect();
        std::thread::sleep(Duration::from_secs(1));
        let most = Duration::from_millis(900);
        assert!(silences.iter().any(|silence| !silence.is_longer_than(most)), "all had a processor");
        drop(children);
        // A child that sleeps waits for nothing.
        let asleep = Command::new("sleep").arg("60").spawn().map(Killed).unwrap();
        std::thread::sleep(Duration::from_millis(300));
        let silence = Silence::begin(asleep.0.id());
        std::thread::sleep(Duration::from_secs(1));
        assert!(silence.is_longer_than(most / 2));
    }

    #[test]
    fn an_answer_is_taken_only_if_it_is_whole() {
        let whole = asked("echo 'rhytid: 1'; echo 'rhytid| first'; echo chatter; echo 'rhytid| second'; echo 'rhytid: done'").unwrap();
        assert_eq!(whole, ("first\nsecond\n".into(), vec!["1".into()]));
        // A driver's fault at the end does not matter.
        asked("echo first; echo 'rhytid: done'; kill -SEGV $$").unwrap();
        for (script, why) in [
            ("echo first", "with exit code 0"),
            ("exit 3", "with exit code 3"),
            ("kill -SEGV $$", "crashes (a wrong address, signal 11)"),
            ("kill -BUS $$", "is the disk with its cache full"),
            ("echo 'rhytid: 1'; sleep 60", "hangs: it did not answer for 1 s"),
        ] {
            let said = asked(script).unwrap_err();
            assert!(said.contains(why) && said.starts_with("vulkan: "), "{script}: {said}");
        }
    }

    #[test]
    fn who_gives_signs_may_take_long() {
        let start = Instant::now();
        asked("for i in 1 2 3 4; do echo 'rhytid: still here'; sleep 0.5; done; echo 'rhytid: done'")
            .unwrap();
        assert!(start.elapsed() > Duration::from_secs(1));
    }

    #[test]
    fn a_stop_ends_the_child() {
        struct Stopped;
        impl Progress for Stopped {
            fn report(&self, _: &'static str, _: u64, _: u64) {}
            fn cancelled(&self) -> bool {
                true
            }
        }
        let start = Instant::now();
        let asked = Guard::new(shell).ask(&["sleep 60"], "vulkan", &[], &Stopped, |_| PATIENCE);
        assert!(matches!(asked, Err(Error::Cancelled)));
        assert!(start.elapsed() < PATIENCE);
    }
}
