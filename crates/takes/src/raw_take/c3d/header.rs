//! The first block of a C3D file.
use super::processor::Processor;

/// The bytes of a block.
pub(super) const BLOCK: usize = 512;

/// The word before the number of events, if there are events.
const EVENTS_KEY: u16 = 12345;

/// The room for events.
const MOST_EVENTS: usize = 18;

/// The content of the header. The parameters state all of it too, and need not agree.
#[derive(Debug, Clone)]
pub(super) struct Header {
    pub(super) points: u16,
    /// Analog measurements in a frame, over all channels.
    pub(super) analog: u16,
    /// Numbers of the first and the last frame.
    pub(super) first: u16,
    pub(super) last: u16,
    /// Below 0 where points are floats.
    pub(super) scale: f64,
    /// The block, from 1, in which the points begin.
    pub(super) data_block: u16,
    /// Analog measurements in a frame of each channel.
    pub(super) analog_samples: u16,
    /// Frames per second.
    pub(super) rate: f64,
    /// The labels and seconds of up to 18 events.
    pub(super) events: Vec<([u8; 4], f64)>,
}

impl Header {
    pub(super) fn read(block: &[u8; BLOCK], processor: Processor) -> Self {
        // Words of 16 bits count from 1 in the format's description.
        let bytes = |word: usize| [block[2 * word - 2], block[2 * word - 1]];
        let word = |n: usize| processor.word(bytes(n));
        let float = |n: usize| {
            let ([a, b], [c, d]) = (bytes(n), bytes(n + 1));
            processor.float([a, b, c, d])
        };
        Self {
            points: word(2),
            analog: word(3),
            first: word(4),
            last: word(5),
            scale: float(7),
            data_block: word(9),
            analog_samples: word(10),
            rate: float(11),
            events: (0..usize::from(word(151)).min(MOST_EVENTS))
                .filter(|_| word(150) == EVENTS_KEY)
                .map(|event| {
                    let ([a, b], [c, d]) = (bytes(199 + 2 * event), bytes(200 + 2 * event));
                    ([a, b, c, d], float(153 + 2 * event))
                })
                .collect(),
        }
    }

    /// The number of frames by the first and the last frame number. `None` if the last comes before the
    /// first, which happens when numbers outgrow 16 bits.
    pub(super) fn frames(&self) -> Option<u32> {
        (u32::from(self.last) + 1).checked_sub(u32::from(self.first))
    }
}
