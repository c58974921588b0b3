//! Output on a thread of its own.

use rhytid_core::buffer_ring::{Filler, buffer_ring};
use std::io::{self, Write};
use std::thread::{Builder, JoinHandle};

/// Bytes that are handed over at once.
const BLOCK: usize = 1 << 20;
/// Blocks that go round: one is filled while the others are written.
const BLOCKS: usize = 4;

/// Writes on a thread of its own, while the next values are examined. It keeps a few blocks in memory.
pub(super) struct BackgroundWriter<W> {
    /// Bytes that have not been handed over.
    block: Vec<u8>,
    /// Where full blocks go and empty ones come from; `None` once the thread was told to end.
    blocks: Option<Filler<Vec<u8>>>,
    thread: Option<JoinHandle<io::Result<W>>>,
}

impl<W: Write + Send + 'static> BackgroundWriter<W> {
    pub(super) fn new(mut out: W) -> io::Result<Self> {
        let block = || Vec::with_capacity(BLOCK);
        let (filler, emptier) = buffer_ring((1..BLOCKS).map(|_| block()));
        let write = move || {
            while let Some(mut block) = emptier.full() {
                out.write_all(&block)?;
                block.clear();
                emptier.give_back(block);
            }
            Ok(out)
        };
        let thread = Builder::new().name("usd writer".into()).spawn(write)?;
        Ok(Self { block: block(), blocks: Some(filler), thread: Some(thread) })
    }

    /// Takes `bytes`. An error may be that of an earlier call.
    pub(super) fn write_all(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        loop {
            let (now, later) = bytes.split_at(bytes.len().min(BLOCK - self.block.len()));
            self.block.extend_from_slice(now);
            if later.is_empty() {
                return Ok(());
            }
            bytes = later;
            let next = self.blocks.as_ref().and_then(Filler::empty);
            let Some(next) = next else { return Err(self.fault()) };
            let block = std::mem::replace(&mut self.block, next);
            self.hand_over(block)?;
        }
    }

    /// Waits until everything is written, and returns the output.
    pub(super) fn finish(mut self) -> io::Result<W> {
        let block = std::mem::take(&mut self.block);
        self.hand_over(block)?;
        self.end().unwrap_or_else(|| Err(ended()))
    }

    fn hand_over(&mut self, block: Vec<u8>) -> io::Result<()> {
        match self.blocks.as_ref().is_some_and(|blocks| blocks.hand_over(block)) {
            true => Ok(()),
            false => Err(self.fault()),
        }
    }

    /// Why the thread has ended before it was told to.
    fn fault(&mut self) -> io::Error {
        self.end().and_then(Result::err).unwrap_or_else(ended)
    }
}

impl<W> BackgroundWriter<W> {
    /// Tells the thread to end, once, and returns its result.
    fn end(&mut self) -> Option<io::Result<W>> {
        self.blocks = None;
        Some(self.thread.take()?.join().unwrap_or_else(|_| Err(ended())))
    }
}

impl<W> Drop for BackgroundWriter<W> {
    /// After the drop, the file is closed.
    fn drop(&mut self) {
        self.end();
    }
}

fn ended() -> io::Error {
    io::Error::other("the thread that writes has ended")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_arrives_in_order() {
        for length in [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 9 * BLOCK + 5] {
            let bytes: Vec<u8> = (0..length).map(|i| (i * 7 + i / 251) as u8).collect();
            let mut writer = BackgroundWriter::new(Vec::new()).unwrap();
            for part in bytes.chunks(BLOCK / 3 + 11) {
                writer.write_all(part).unwrap();
            }
            assert!(writer.finish().unwrap() == bytes, "{length}");
        }
    }

    /// A disk with room for so many bytes.
    struct Disk(usize);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_told_at_the_latest_when_it_ends() {
        for room in [0, BLOCK, 3 * BLOCK] {
            let mut writer = BackgroundWriter::new(Disk(room)).unwrap();
            let part = vec![1; BLOCK / 2];
            let told = (0..50).find_map(|_| writer.write_all(&part).err());
            assert_eq!(told.unwrap().kind(), io::ErrorKind::StorageFull);
        }
        let mut writer = BackgroundWriter::new(Disk(10)).unwrap();
        writer.write_all(&[1; 11]).unwrap();
        assert_eq!(writer.finish().err().unwrap().kind(), io::ErrorKind::StorageFull);
    }
}
