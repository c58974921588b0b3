//! Files that reach the disk while they are written.
use crate::temporary::Temporary;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};

/// After this many bytes the disk has to catch up.
const STRETCH: u64 = 64 << 20;

/// A file whose bytes go to the disk while it is written. Without this, the operating system would first fill
/// its memory with gigabytes of them. This would push out what other programs keep there, need new memory for
/// every page, and end with a long wait. A fault of the disk would show only then.
#[derive(Debug)]
pub(crate) struct SteadyFile {
    file: Temporary,
    /// Bytes written since the disk last had everything.
    waiting: u64,
}

impl SteadyFile {
    pub(crate) fn new(file: Temporary) -> Self {
        Self { file, waiting: 0 }
    }

    /// Waits until the disk has everything.
    pub(crate) fn finish(self) -> io::Result<Temporary> {
        self.file.file().sync_all()?;
        Ok(self.file)
    }
}

impl Write for SteadyFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.file().write(bytes)?;
        self.waiting += written as u64;
        if self.waiting >= STRETCH {
            self.file.file().sync_data()?;
            forget(self.file.file());
            self.waiting = 0;
        }
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.file().flush()
    }
}

impl Seek for SteadyFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.file().seek(to)
    }
}

/// Tells the system that bytes on the disk need not stay in memory. It is only advice: a system may ignore
/// it.
fn forget(file: &File) {
    #[cfg(target_os = "linux")]
    let _ = rustix::fs::fadvise(file, 0, None, rustix::fs::Advice::DontNeed);
    #[cfg(not(target_os = "linux"))]
    let _ = file;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use tempfile::NamedTempFile;

    #[test]
    fn every_byte_arrives() {
        let block = block();
        let mut out = SteadyFile::new(Temporary::Named(NamedTempFile::new().unwrap()));
        let blocks = 2 * STRETCH as usize / block.len();
        (0..blocks).for_each(|_| out.write_all(&block).unwrap());
        out.write_all(b"the end").unwrap();
        out.seek(SeekFrom::Start(5)).unwrap();
        out.write_all(b"the beginning").unwrap();

        let mut expected = block.repeat(blocks);
        expected.extend(b"the end");
        expected[5..18].copy_from_slice(b"the beginning");
        let mut found = Vec::new();
        let file = out.finish().unwrap();
        file.file().rewind().unwrap();
        file.file().read_to_end(&mut found).unwrap();
        assert!(found == expected);
    }

    /// First a plain file is written and its memory is released. If even this file stays in memory, as in a
    /// temporary folder that is itself in memory, there is nothing to test.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_the_disk_has_leaves_memory() {
        let block = block();
        let blocks = STRETCH as usize / block.len();
        let mut plain = NamedTempFile::new().unwrap();
        (0..blocks).for_each(|_| plain.write_all(&block).unwrap());
        plain.as_file().sync_data().unwrap();
        rustix::fs::fadvise(plain.as_file(), 0, None, rustix::fs::Advice::DontNeed).unwrap();
        if in_memory(plain.path()) > STRETCH / 2 {
            rhytid_test_support::skip("temporary files stay in memory here");
            return;
        }

        let file = NamedTempFile::new().unwrap();
        let path = file.path().to_owned();
        let mut out = SteadyFile::new(Temporary::Named(file));
        (0..2 * blocks).for_each(|_| out.write_all(&block).unwrap());
        let kept = in_memory(&path);
        assert!(kept <= STRETCH / 2, "{kept} bytes of two stretches of {STRETCH} are still in memory");
    }

    /// One mebibyte.
    fn block() -> Vec<u8> {
        (0..1 << 20).map(|i: u32| (i ^ i >> 9) as u8).collect()
    }

    /// Bytes of a file that are in memory. Reading the file would not tell, since it fetches the bytes.
    #[cfg(target_os = "linux")]
    fn in_memory(path: &std::path::Path) -> u64 {
        let arguments = ["--bytes", "--noheadings", "--output", "RES"];
        let out = std::process::Command::new("fincore").args(arguments).arg(path).output();
        let out =
            out.expect("fincore should be there: `cargo xtask setup` installs it, with util-linux-extra");
        let text = String::from_utf8_lossy(&out.stdout);
        text.trim().parse().unwrap_or_else(|e| panic!("fincore printed {out:?}: {e}"))
    }
}
