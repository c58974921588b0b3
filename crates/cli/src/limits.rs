//! The system's limits for this process: its stack, the size of files, threads.

use crate::exit_code;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::sync::mpsc::{Sender, channel};

/// The stack of a main thread on most systems.
const STACK: usize = 8 << 20;

/// Runs the program on a stack that `ulimit -s` does not shrink. Files that `ulimit -f` forbids become errors
/// instead of ending the process.
pub(crate) fn run(program: fn() -> u8) -> u8 {
    errors_for_large_files();
    let (sender, jobs) = channel();
    let to_main = JOBS.get_or_init(|| sender).clone();
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        let _ended = Ended(to_main);
        program()
    });
    match thread {
        Ok(thread) => {
            while let Ok(Some(job)) = jobs.recv() {
                job();
            }
            thread.join().unwrap_or(exit_code::OURS)
        }
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", no_thread(&error.to_string()));
            exit_code::USER
        }
    }
}

/// A job for the main thread.
type Job = Box<dyn FnOnce() + Send>;

/// The main thread's jobs while the program runs; `None` ends it.
static JOBS: OnceLock<Sender<Option<Job>>> = OnceLock::new();

/// Sends the end of the program when dropped, also after a panic.
struct Ended(Sender<Option<Job>>);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.send(None);
    }
}

/// Does `job` on the main thread and waits for it. Some systems let a program open windows only there. `None`
/// if it panicked.
#[cfg(feature = "view")]
pub(crate) fn on_main_thread<T: Send + 'static>(job: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (sender, done) = channel();
    let job = move || {
        // The hook has already reported the panic.
        if let Ok(result) = std::panic::catch_unwind(std::panic::AssertUnwindSafe(job)) {
            let _ = sender.send(result);
        }
    };
    JOBS.get()?.send(Some(Box::new(job))).ok()?;
    done.recv().ok()
}

/// The sentence for a panic because a thread could not be started. Libraries offer no error for it.
pub(crate) fn of_panic(message: &str) -> Option<String> {
    let fault = message
        .strip_prefix("failed to spawn thread: ")
        .or_else(|| message.contains("ThreadPoolBuildError").then_some(message))?;
    // As Rust prints an error of the system.
    let said = fault.split_once("message: \"").and_then(|(_, after)| after.split_once('"'));
    Some(no_thread(said.map_or("the system refuses", |(said, _)| said)))
}

fn no_thread(said: &str) -> String {
    format!(
        "a thread cannot be started: {said}; this account may have too many processes (`ulimit -u`), or this \
         process too little memory (`ulimit -v`)"
    )
}

/// A handler that does nothing. The write then fails, and is reported like other errors of the disk.
fn errors_for_large_files() {
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_panics_are_understood() {
        let system = r#"Os { code: 11, kind: WouldBlock, message: "Resource temporarily unavailable" }"#;
        for message in [
            format!("failed to spawn thread: {system}"),
            format!(
                "The global thread pool has not been initialized.: ThreadPoolBuildError {{ kind: IOError({system}) }}"
            ),
        ] {
            let said = of_panic(&message).unwrap();
            assert!(
                said.starts_with("a thread cannot be started: Resource temporarily unavailable;"),
                "{said}"
            );
        }
        assert_eq!(of_panic("index out of bounds"), None);
    }
}
