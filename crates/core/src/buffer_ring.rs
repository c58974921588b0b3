//! Buffers that go round between two threads. One thread fills them; the other one empties them and returns
//! them. So memory does not grow with the amount of data. When one end is dropped, the other one ends too.
//!
//! ```
//! use rhytid_core::buffer_ring::buffer_ring;
//! let (filler, emptier) = buffer_ring([Vec::new(), Vec::new()]);
//! let filling = std::thread::spawn(move || {
//!     for number in 0..10 {
//!         let Some(mut buffer) = filler.empty() else { return };
//!         buffer.push(number);
//!         filler.hand_over(buffer);
//!     }
//! });
//! let mut sum = 0;
//! while let Some(mut buffer) = emptier.full() {
//!     sum += buffer.drain(..).sum::<i32>();
//!     emptier.give_back(buffer);
//! }
//! assert_eq!(sum, 45);
//! # filling.join().unwrap();
//! ```

use std::sync::mpsc::{Receiver, Sender, channel};

/// The end that fills buffers.
#[derive(Debug)]
pub struct Filler<Buffer> {
    full: Sender<Buffer>,
    empty: Receiver<Buffer>,
}

/// The end that empties buffers.
#[derive(Debug)]
pub struct Emptier<Buffer> {
    full: Receiver<Buffer>,
    empty: Sender<Buffer>,
}

/// The two ends between which these empty `buffers` go round. The filler gets ahead by at most as many
/// buffers as there are.
pub fn buffer_ring<Buffer>(buffers: impl IntoIterator<Item = Buffer>) -> (Filler<Buffer>, Emptier<Buffer>) {
    let (to_empty, full) = channel();
    let (to_fill, empty) = channel();
    // The other end is still here.
    buffers.into_iter().for_each(|buffer| drop(to_fill.send(buffer)));
    (Filler { full: to_empty, empty }, Emptier { full, empty: to_fill })
}

impl<Buffer> Filler<Buffer> {
    /// Waits for a buffer to fill. `None` once the other end is gone and no buffer is left.
    pub fn empty(&self) -> Option<Buffer> {
        self.empty.recv().ok()
    }

    /// Hands a full buffer over. False if the other end is gone, and the buffer with it.
    pub fn hand_over(&self, buffer: Buffer) -> bool {
        self.full.send(buffer).is_ok()
    }
}

impl<Buffer> Emptier<Buffer> {
    /// Waits for the next full buffer, in the order in which buffers were handed over. `None` once the other
    /// end is gone and no full buffer is left.
    pub fn full(&self) -> Option<Buffer> {
        self.full.recv().ok()
    }

    /// Returns an empty buffer. Where the other end is gone, the buffer is dropped.
    pub fn give_back(&self, buffer: Buffer) {
        let _ = self.empty.send(buffer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_come_in_order_and_go_round() {
        let (filler, emptier) = buffer_ring([10, 20]);
        assert_eq!((filler.empty(), filler.empty()), (Some(10), Some(20)));
        assert!(filler.hand_over(1) && filler.hand_over(2));
        assert_eq!((emptier.full(), emptier.full()), (Some(1), Some(2)));
        emptier.give_back(30);
        assert_eq!(filler.empty(), Some(30));
    }

    #[test]
    fn what_was_handed_over_is_emptied_also_after_the_filler_is_gone() {
        let (filler, emptier) = buffer_ring([0]);
        filler.empty();
        filler.hand_over(7);
        drop(filler);
        assert_eq!(emptier.full(), Some(7));
        emptier.give_back(0);
        assert_eq!(emptier.full(), None);
    }

    #[test]
    fn the_filler_ends_when_the_emptier_is_gone() {
        let (filler, emptier) = buffer_ring([0]);
        drop(emptier);
        assert_eq!(filler.empty(), Some(0), "it has been there all along");
        assert!(!filler.hand_over(0));
        assert_eq!(filler.empty(), None);
    }
}
