use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Bytes that are handed over at once.
const BLOCK: usize = 1 << 20;
/// Blocks that go round: one is filled while the others are written.
const BLOCKS: usize = 4;

/// Writes on a thread of its own, so that the next values are examined meanwhile. Memory is that of a few blocks.
pub(super) struct Behind<W> {
    /// What has not been handed over.
    block: Vec<u8>,
    full: Option<SyncSender<Vec<u8>>>,
    empty: Receiver<Vec<u8>>,
    thread: Option<JoinHandle<io::Result<W>>>,
}

impl<W: Write + Send + 'static> Behind<W> {
    pub(super) fn new(mut out: W) -> io::Result<Self> {
        let (full, to_write) = sync_channel::<Vec<u8>>(BLOCKS);
        let (written, empty) = channel();
        for _ in 1..BLOCKS {
            // The other end is still here.
            let _ = written.send(Vec::with_capacity(BLOCK));
        }
        let write = move || {
            for mut block in to_write {
                out.write_all(&block)?;
                block.clear();
                // Nobody wants it when the last ones are written.
                let _ = written.send(block);
            }
            Ok(out)
        };
        let thread = Builder::new().name("usd writer".into()).spawn(write)?;
        Ok(Self { block: Vec::with_capacity(BLOCK), full: Some(full), empty, thread: Some(thread) })
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
            let Ok(next) = self.empty.recv() else { return Err(self.fault()) };
            let block = std::mem::replace(&mut self.block, next);
            self.hand_over(block)?;
        }
    }

    /// Waits until all is written, and gives back where to.
    pub(super) fn finish(mut self) -> io::Result<W> {
        let block = std::mem::take(&mut self.block);
        self.hand_over(block)?;
        self.end().unwrap_or_else(|| Err(ended()))
    }

    fn hand_over(&mut self, block: Vec<u8>) -> io::Result<()> {
        match self.full.as_ref().map(|full| full.send(block)) {
            Some(Ok(())) => Ok(()),
            _ => Err(self.fault()),
        }
    }

    /// Why the thread has ended before it was told to.
    fn fault(&mut self) -> io::Error {
        self.end().and_then(Result::err).unwrap_or_else(ended)
    }
}

impl<W> Behind<W> {
    /// Tells the thread to end, and what it ended with, once.
    fn end(&mut self) -> Option<io::Result<W>> {
        self.full = None;
        Some(self.thread.take()?.join().unwrap_or_else(|_| Err(ended())))
    }
}

impl<W> Drop for Behind<W> {
    /// Whoever drops it finds the file closed.
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
            let mut behind = Behind::new(Vec::new()).unwrap();
            for part in bytes.chunks(BLOCK / 3 + 11) {
                behind.write_all(part).unwrap();
            }
            assert!(behind.finish().unwrap() == bytes, "{length}");
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
            let mut behind = Behind::new(Disk(room)).unwrap();
            let part = vec![1; BLOCK / 2];
            let told = (0..50).find_map(|_| behind.write_all(&part).err());
            assert_eq!(told.unwrap().kind(), io::ErrorKind::StorageFull);
        }
        let mut behind = Behind::new(Disk(10)).unwrap();
        behind.write_all(&[1; 11]).unwrap();
        assert_eq!(behind.finish().err().unwrap().kind(), io::ErrorKind::StorageFull);
    }
}
