//! Unknown drivers are tried in child processes. A driver that crashes, hangs or ends its process then ends
//! only that process.

use rhytid_core::{DeviceErrorKind, Error, Progress, Result};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A child that is silent for this long is hanging. It is several times what a slow driver needs on a busy
/// machine.
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
        let (mut heard, mut patience) = (Instant::now(), PATIENCE);
        loop {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            match lines.recv_timeout(Duration::from_millis(20)) {
                Ok(line) => {
                    heard = Instant::now();
                    if line == END {
                        ended = true;
                    } else if let Some(text) = line.strip_prefix(SIGN) {
                        patience = sign(text);
                    } else if let Some(text) = line.strip_prefix(ANSWER) {
                        answer += text;
                        answer += "\n";
                    }
                }
                Err(RecvTimeoutError::Timeout) if heard.elapsed() > patience => {
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
        while heard.elapsed() <= patience {
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
