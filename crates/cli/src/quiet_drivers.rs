//! Drivers that write on standard error as if they were this program.

/// The folder of a desktop's sockets. Without it libwayland writes lines that begin with `error: ` when
/// OpenGL's loader asks for a display.
#[cfg(target_os = "linux")]
const RUNTIME_DIR: &str = "XDG_RUNTIME_DIR";

/// Starts the executable of this process anew with `XDG_RUNTIME_DIR` set, if that is not set. Without it,
/// some drivers write errors of their own. A process cannot safely change its own environment once threads
/// may read it. So this comes first in `main`, before anything is read or written.
#[cfg(target_os = "linux")]
pub fn restart_if_needed() {
    use std::os::unix::process::CommandExt;
    if std::env::var_os(RUNTIME_DIR).is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut anew = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        anew.arg0(name);
    }
    // This line is reached only if the start fails. Some drivers' lines are then seen.
    let _ = anew.args(arguments).env(RUNTIME_DIR, std::env::temp_dir()).exec();
}

/// Does nothing on this system.
#[cfg(not(target_os = "linux"))]
pub fn restart_if_needed() {}
