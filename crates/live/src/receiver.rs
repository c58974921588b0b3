//! A socket behind a [`Stream`].

use crate::counts::Counts;
use crate::stream::{LiveFrame, Stream};
use rhytid_core::{Error, Result};
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

/// The most datagrams that [`Receiver::newest`] reads before it returns.
const AT_ONCE: usize = 1_024;
/// The bytes of the system's buffer that are asked for: some 400 frames of 90 markers.
const BUFFER: usize = 4 << 20;
/// The shortest wait for a datagram, in seconds. A wait of 0 would have no end.
const SHORTEST: f64 = 1e-4;

/// A receiver that listens at an address. Datagrams wait in the system's buffer, of a fixed size, until a
/// call reads them. There is no thread.
#[derive(Debug)]
pub struct Receiver {
    socket: UdpSocket,
    address: SocketAddr,
    /// The start of the times of arrival.
    start: Instant,
    stream: Stream,
    datagram: Box<[u8]>,
}

impl Receiver {
    /// Listens at `address` for H `labels`, which are at `rest` until they are seen. Port 0 is any free port.
    ///
    /// # Errors
    /// [`Error::Input`] if the port is in use, if the address is not this machine's, or if this user may not
    /// listen at it. [`Error::Io`].
    ///
    /// # Panics
    /// If there are not as many positions as labels.
    pub fn bind(address: SocketAddr, labels: &[String], rest: &[[f32; 3]]) -> Result<Self> {
        Self::listen(address, Stream::new(labels, rest))
    }

    /// Listens at `address` for what `stream` takes. Port 0 is any free port.
    ///
    /// # Errors
    /// As [`bind`](Self::bind).
    pub fn listen(address: SocketAddr, stream: Stream) -> Result<Self> {
        let socket = UdpSocket::bind(address).map_err(|error| match error.kind() {
            ErrorKind::AddrInUse => Error::network(format!(
                "{address}: another program listens there; end it, or name another port"
            )),
            ErrorKind::AddrNotAvailable => Error::network(format!(
                "{address}: is no address of this machine, expected one, or 0.0.0.0 for all it has"
            )),
            ErrorKind::PermissionDenied => {
                Error::network(format!("{address}: permission denied; name a port from 1024 on"))
            }
            _ => io(address)(error),
        })?;
        let address = socket.local_addr().map_err(io(address))?;
        widen(&socket);
        // More than a datagram can have, on any system.
        let datagram = vec![0; 1 << 16].into();
        Ok(Self { socket, address, start: Instant::now(), stream, datagram })
    }

    /// The address at which it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits for the next frame, at most for `wait`. Only a new frame ends the wait early.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn next(&mut self, wait: Duration) -> Result<Option<LiveFrame<'_>>> {
        self.socket.set_nonblocking(false).map_err(io(self.address))?;
        let start = Instant::now();
        loop {
            if self.stream.due().is_some_and(|due| due <= self.now()) {
                // What has come while this thread was stopped may make the frame whole.
                if self.read_waiting(true)? || self.stream.close(self.now()) {
                    return Ok(self.stream.newest());
                }
                self.socket.set_nonblocking(false).map_err(io(self.address))?;
            }
            let Some(left) = wait.checked_sub(start.elapsed()).filter(|left| !left.is_zero()) else {
                return Ok(None);
            };
            let due = self.stream.due().map_or(left.as_secs_f64(), |due| due - self.now());
            let left = left.min(Duration::from_secs_f64(due.max(SHORTEST)));
            self.socket.set_read_timeout(Some(left)).map_err(io(self.address))?;
            if self.read()? == Some(true) {
                return Ok(self.stream.newest());
            }
        }
    }

    /// Reads all datagrams that have come, without waiting. The result is the newest frame so far, or `None`
    /// before the first. If datagrams come faster than they are read, it returns after a fixed number of
    /// them.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn newest(&mut self) -> Result<Option<LiveFrame<'_>>> {
        self.read_waiting(false)?;
        self.stream.close(self.now());
        Ok(self.stream.newest())
    }

    /// Reads the datagrams that have come, without waiting: those of one frame, or at most a fixed number of
    /// them. The result is whether there is a new newest frame. The socket does not block afterwards.
    fn read_waiting(&mut self, of_one_frame: bool) -> Result<bool> {
        self.socket.set_nonblocking(true).map_err(io(self.address))?;
        let mut is_new = false;
        for _ in 0..AT_ONCE {
            match self.read()? {
                None => break,
                Some(is_newer) => is_new |= is_newer,
            }
            if is_new && of_one_frame {
                break;
            }
        }
        Ok(is_new)
    }

    /// The state of what comes.
    pub fn stream(&self) -> &Stream {
        &self.stream
    }

    /// The counts of the datagrams so far.
    pub fn counts(&self) -> Counts {
        self.stream.counts()
    }

    /// The time since the start, in seconds.
    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Reads a datagram. The result is whether it was the newest frame, or `None` if none came.
    fn read(&mut self) -> Result<Option<bool>> {
        match self.socket.recv_from(&mut self.datagram) {
            Ok((size, from)) => {
                let arrived = self.now();
                Ok(Some(self.stream.accept(&self.datagram[..size], from, arrived)))
            }
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(None),
                _ => Err(io(self.address)(error)),
            },
        }
    }
}

/// Asks for room for datagrams that come while this program or the sender is stopped for a moment. A system
/// gives as much as its administrator allows, so the answer does not matter.
fn widen(socket: &UdpSocket) {
    #[cfg(unix)]
    let _ = rustix::net::sockopt::set_socket_recv_buffer_size(socket, BUFFER);
    #[cfg(not(unix))]
    let _ = (socket, BUFFER);
}

/// For `map_err`: an error that names the address.
pub(crate) fn io(address: SocketAddr) -> impl FnOnce(std::io::Error) -> Error {
    Error::io(Path::new(&address.to_string()))
}
