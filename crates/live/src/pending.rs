//! A frame of which more may come.

use crate::part::Stamp;
use std::net::SocketAddr;

/// A frame, and where it came from.
#[derive(Debug)]
pub(crate) struct Pending {
    /// What its first datagram says of it; `None` for frames without a number.
    pub stamp: Option<Stamp>,
    pub from: SocketAddr,
    /// Whether a sender begins with it.
    pub is_anew: bool,
    /// When its first and its last datagram came.
    pub first_arrived: f64,
    pub last_arrived: f64,
    /// The number of datagrams that brought a marker.
    pub parts: usize,
    /// The position of each marker that came, by its place.
    markers: Vec<Option<[f32; 3]>>,
}

impl Pending {
    pub(crate) fn new(stamp: Option<Stamp>, from: SocketAddr, is_anew: bool, arrived: f64) -> Self {
        let (first_arrived, last_arrived) = (arrived, arrived);
        Self { stamp, from, is_anew, first_arrived, last_arrived, parts: 0, markers: Vec::new() }
    }

    fn at(&self, place: usize) -> Option<[f32; 3]> {
        self.markers.get(place).copied().flatten()
    }

    /// Whether one of these markers is there already.
    pub(crate) fn repeats(&self, markers: &[(usize, [f32; 3])]) -> bool {
        markers.iter().any(|(place, _)| self.at(*place).is_some())
    }

    /// Whether one of these markers is there already, elsewhere.
    pub(crate) fn differs(&self, markers: &[(usize, [f32; 3])]) -> bool {
        markers.iter().any(|(place, position)| self.at(*place).is_some_and(|known| known != *position))
    }

    /// Whether it has all markers of another frame.
    pub(crate) fn has_all_of(&self, other: &Self) -> bool {
        other.positions().all(|(place, _)| self.at(place).is_some())
    }

    /// Adds the markers of a datagram.
    pub(crate) fn add(&mut self, markers: &[(usize, [f32; 3])]) {
        let mut is_more = false;
        for &(place, position) in markers {
            if place >= self.markers.len() {
                self.markers.resize(place + 1, None);
            }
            is_more |= self.markers[place].is_none();
            self.markers[place] = Some(position);
        }
        self.parts += usize::from(is_more);
    }

    /// The places and positions of its markers.
    pub(crate) fn positions(&self) -> impl Iterator<Item = (usize, [f32; 3])> {
        self.markers.iter().enumerate().filter_map(|(place, position)| Some((place, (*position)?)))
    }
}
