//! Marker positions while they are captured, as UDP datagrams with OSC 1.0 bundles or messages
//! (`docs/live.md` has the pattern).
//!
//! A [`Receiver`] gives the frames of a [`Stream`], newest last. The stream puts together what belongs to one
//! frame. It has a fixed list of handles, or all markers. It counts the frames that were late, lost or bad
//! ([`Counts`]), and names what is likely wrong with a sender. The position of a marker that is missing from
//! a frame is held, and its confidence falls. [`record`] makes a take of the frames. A [`Sender`] plays a
//! take to a receiver at an even pace. No datagram causes a panic, and the receiver uses no more memory than
//! at the start.
//!
//! ```
//! use rhytid_live::{Frame, Receiver};
//! use std::{net::UdpSocket, time::Duration};
//!
//! let mut receiver = Receiver::bind("127.0.0.1:0".parse().unwrap(), &["chin".into()], &[[0.0, -1.0, 0.0]])?;
//! let frame = Frame { number: 0, seconds: 0.0, markers: vec![("chin".into(), [0.0, -1.5, 0.25])] };
//! let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
//! socket.send_to(&frame.encode()?, receiver.address()).unwrap();
//! let received = receiver.next(Duration::from_secs(5))?.expect("a frame");
//! assert_eq!(received.positions, [[0.0, -1.5, 0.25]]);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod clock;
mod counts;
mod labels;
mod latency;
mod packet;
mod part;
mod pattern;
mod pending;
mod receiver;
mod recorder;
mod sender;
mod stream;
mod warnings;

/// The default address of senders and receivers: on this machine alone.
pub const ADDRESS: std::net::SocketAddr =
    std::net::SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 9000);

pub use counts::Counts;
pub use packet::{Frame, MAX_DATAGRAM, MAX_LABEL};
pub use pattern::Pattern;
pub use receiver::Receiver;
pub use recorder::{Recording, record};
pub use sender::{Sender, Sent};
pub use stream::{FADE, LEARNING, LiveFrame, SILENCE, Stream};
