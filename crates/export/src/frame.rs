//! One frame of an animation: its channels.

use rhytid_core::channel::{self, Channel};

/// One frame of an animation: positions, and other channels that the scene has.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame<'a> {
    values: Vec<(&'a Channel, &'a [f32])>,
}

impl<'a> Frame<'a> {
    /// A frame of 3V positions in mesh units, without other channels.
    pub fn new(positions: &'a [f32]) -> Self {
        Self { values: vec![(&channel::POSITIONS, positions)] }
    }

    /// The same frame with V × [`Channel::width`] numbers of a channel, which replace earlier ones of that
    /// channel.
    #[must_use]
    pub fn with(mut self, channel: &'a Channel, numbers: &'a [f32]) -> Self {
        match self.values.iter_mut().find(|(known, _)| known.name == channel.name) {
            Some(known) => *known = (channel, numbers),
            None => self.values.push((channel, numbers)),
        }
        self
    }

    /// The same without a channel.
    #[must_use]
    pub fn without(mut self, channel: &Channel) -> Self {
        self.values.retain(|(known, _)| known.name != channel.name);
        self
    }

    /// 3V positions in mesh units.
    pub fn positions(&self) -> &'a [f32] {
        self.get(&channel::POSITIONS).unwrap_or_default()
    }

    /// V × [`Channel::width`] numbers; `None` where the frame does not have the channel.
    pub fn get(&self, channel: &Channel) -> Option<&'a [f32]> {
        self.channels().find(|(known, _)| known.name == channel.name).map(|(_, numbers)| numbers)
    }

    /// All channels with their numbers, positions first.
    pub fn channels(&self) -> impl Iterator<Item = (&'a Channel, &'a [f32])> + '_ {
        self.values.iter().copied()
    }
}
