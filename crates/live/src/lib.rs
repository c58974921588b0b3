//! Marker positions while they are captured: UDP datagrams, each a frame as an OSC 1.0 bundle (`docs/live.md` has the pattern).
//!
//! A [`Receiver`] gives frames of a fixed list of handles in their order, newest last, and says how many were late, lost or bad
//! ([`Counts`]); what a frame lacks is held and its confidence falls. [`record`] makes a take of them. A [`Sender`] plays a take
//! to a receiver at an even pace. Whatever is sent, nothing panics, and memory is what the receiver had at the start.
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

mod latency;
mod packet;
mod receiver;
mod recorder;
mod sender;
mod stream;

/// Where frames are sent and listened for unless another address is named: on this machine alone.
pub const ADDRESS: std::net::SocketAddr =
    std::net::SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 9000);

pub use packet::{Frame, MAX_DATAGRAM, MAX_LABEL};
pub use receiver::Receiver;
pub use recorder::{Recording, record};
pub use sender::{Sender, Sent};
pub use stream::{Counts, FADE, LiveFrame, SILENCE, Stream};
