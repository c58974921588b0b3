//! The memory and the processor time of a process, from Linux's `/proc`.

/// The bytes of this process that are in memory now.
///
/// # Panics
/// Where there is no `/proc`.
pub fn resident() -> u64 {
    status("self", "VmRSS:").expect("/proc/self/status should have VmRSS")
}

/// The most bytes that this process has had in memory.
///
/// # Panics
/// Where there is no `/proc`.
pub fn peak() -> u64 {
    status("self", "VmHWM:").expect("/proc/self/status should have VmHWM")
}

/// The same as [`peak`], for another process; `None` once it has ended.
pub fn peak_of(process: u32) -> Option<u64> {
    status(&process.to_string(), "VmHWM:")
}

/// The seconds that all threads of this process have computed.
///
/// # Panics
/// Where there is no `/proc`.
pub fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("/proc/self/stat");
    // The name, in parentheses, may have spaces. User and system time are the 12th and 13th word after it.
    let words = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: f64 = words.skip(11).take(2).map(|word| word.parse::<f64>().expect("ticks")).sum();
    ticks / 100.0
}

fn status(process: &str, key: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix(key))?;
    Some(kilobytes.trim().trim_end_matches(" kB").parse::<u64>().ok()? * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn what_is_allocated_is_seen() {
        let before = super::resident();
        let block = std::hint::black_box(vec![1_u8; 64 << 20]);
        let (now, peak) = (super::resident(), super::peak());
        assert!(now >= before + (60 << 20) && peak >= now, "{before}, {now}, {peak}: {}", block.len());
        assert!(super::peak_of(std::process::id()) >= Some(peak));
    }
}
