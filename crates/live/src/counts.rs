//! What came, in numbers.

use crate::part::FRAME;
use crate::pattern::Pattern;
use rhytid_core::text::quoted;

/// The counts of frames and datagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that were accepted.
    pub frames: u64,
    /// Datagrams of a frame that was given already, or of an older one. They were dropped.
    pub late: u64,
    /// Numbers that were skipped: frames that never came, or came late.
    pub lost: u64,
    /// Datagrams that are no part of a frame, or that are another sender's while one is heard.
    pub bad: u64,
    /// Datagrams that have nothing for the stream: messages with other addresses alone, or markers that are
    /// not seen or belong to no handle.
    pub other: u64,
}

/// The most addresses that are named.
const NAMED: usize = 3;

/// The addresses of messages that are not read.
#[derive(Debug, Default)]
pub(crate) struct Others {
    named: Vec<(String, u64)>,
    /// Datagrams with further addresses.
    further: u64,
}

impl Others {
    /// Counts a datagram with such a message.
    pub(crate) fn add(&mut self, address: &str) {
        if let Some((_, count)) = self.named.iter_mut().find(|(known, _)| known == address) {
            *count += 1;
        } else if self.named.len() < NAMED {
            self.named.push((address.to_owned(), 1));
        } else {
            self.further += 1;
        }
    }

    /// What came, and what `pattern` expects.
    pub(crate) fn words(&self, pattern: &Pattern) -> Option<String> {
        if self.named.is_empty() {
            return None;
        }
        let named =
            self.named.iter().map(|(address, count)| format!("{} ({count} of them)", quoted(address)));
        let named = named.collect::<Vec<_>>().join(", ");
        let further =
            if self.further > 0 { format!(" and others ({})", self.further) } else { String::new() };
        let expected =
            if pattern.is_foreign() { pattern.to_string() } else { format!("{FRAME} and {pattern}") };
        Some(format!("messages came with the address {named}{further}, expected {expected}"))
    }
}
