//! What one datagram has: a whole frame, or a part of one.
//!
//! A datagram is a bundle without other bundles in it, or a single message. Numbers may have any of OSC's
//! types `i`, `h`, `f` and `d`. A bundle's time tag is not read, because its clock may jump.

use crate::packet::{MAX_DATAGRAM, MAX_LABEL};
use crate::pattern::{Fits, Pattern};
use rosc::{OscMessage, OscPacket, OscType, decoder};
use std::collections::HashSet;

pub(crate) const FRAME: &str = "/rhytid/frame";
pub(crate) const HANDLE: &str = "/rhytid/handle";
/// The start of a bundle.
pub(crate) const BUNDLE: &[u8] = b"#bundle\0";
/// The start, and the time tag.
const HEAD: usize = 16;
/// The most bytes of a message that is read. It bounds the decoder's nesting and allocations.
const MAX_MESSAGE: usize = 512;
/// The largest time: nanoseconds of a clock that counts from 1970 are below it.
const MAX_SECONDS: f64 = 1e19;

/// What a `/rhytid/frame` says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stamp {
    /// The frame's number.
    pub number: i64,
    /// Its time, as it was sent.
    pub seconds: f64,
    /// Whether the time came as a 32-bit float.
    pub is_float: bool,
}

/// What a datagram has.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Part {
    /// The frame's number and time; `None` where a frame is sent in several datagrams, or has neither.
    pub stamp: Option<Stamp>,
    /// Distinct labels and positions.
    pub markers: Vec<(String, [f32; 3])>,
    /// Whether there is a marker without a position: NaN in place of a coordinate says that it is not seen.
    pub has_unseen: bool,
    /// The address of the first message that is none of these.
    pub other: Option<String>,
}

impl Part {
    /// What `datagram` has. For any content, it uses no more memory than a small multiple of the datagram's
    /// size.
    ///
    /// # Errors
    /// What is wrong with it, as the rest of a sentence that begins with "the datagram".
    pub(crate) fn decode(datagram: &[u8], pattern: &Pattern) -> Result<Self, &'static str> {
        if datagram.len() > MAX_DATAGRAM {
            return Err("is longer than a datagram can be");
        }
        let (mut part, mut labels) = (Self::default(), HashSet::new());
        if datagram.starts_with(b"/") {
            part.read(datagram, pattern, &mut labels)?;
            return Ok(part);
        }
        if datagram.len() < HEAD || !datagram.starts_with(BUNDLE) {
            return Err("is no OSC bundle");
        }
        let mut rest = &datagram[HEAD..];
        while !rest.is_empty() {
            let (size, behind) = rest.split_first_chunk::<4>().ok_or("ends within a message")?;
            let size = u32::from_be_bytes(*size) as usize;
            let (element, behind) = behind.split_at_checked(size).ok_or("ends within a message")?;
            rest = behind;
            if element.starts_with(BUNDLE) {
                return Err("has a bundle within the bundle");
            }
            part.read(element, pattern, &mut labels)?;
        }
        Ok(part)
    }

    /// Reads one message.
    fn read(
        &mut self,
        element: &[u8],
        pattern: &Pattern,
        labels: &mut HashSet<String>,
    ) -> Result<(), &'static str> {
        let Some(address) = address(element) else { return Ok(()) };
        let fits = if address == FRAME { Fits::No } else { pattern.fits(address) };
        if address != FRAME && fits == Fits::No {
            if self.other.is_none() {
                self.other = Some(address.to_owned());
            }
            return Ok(());
        }
        let OscMessage { args, .. } = message(element)?;
        let (label, position) = match (fits, args.as_slice()) {
            (Fits::No, [_, _]) if self.stamp.is_some() => return Err("has /rhytid/frame twice"),
            (Fits::No, [number, seconds]) => {
                self.stamp = Some(stamp(number, seconds)?);
                return Ok(());
            }
            (Fits::No, _) => return Err("has a /rhytid/frame that is not NUMBER SECONDS"),
            (Fits::LabelledByArgument, [OscType::String(label), x, y, z, ..]) => (label.as_str(), [x, y, z]),
            (Fits::LabelledByArgument, _) => {
                return Err("has a marker's message that is not LABEL X Y Z");
            }
            (Fits::Label(label), [x, y, z, ..]) => (label, [x, y, z]),
            (Fits::Label(_), _) => return Err("has a marker's message that is not X Y Z"),
        };
        if label.is_empty() || label.len() > MAX_LABEL {
            return Err("has a label that is empty, or longer than 255 bytes");
        }
        if !labels.insert(label.to_owned()) {
            return Err("has a label twice");
        }
        let [x, y, z] = position;
        let position = [real(x)? as f32, real(y)? as f32, real(z)? as f32];
        if position.iter().any(|x| x.is_nan()) {
            self.has_unseen = true;
            return Ok(());
        }
        if !position.iter().all(|x| x.is_finite()) {
            return Err("has a position that is not finite");
        }
        self.markers.push((label.to_owned(), position));
        Ok(())
    }
}

/// The address of a message; `None` if there is none.
fn address(element: &[u8]) -> Option<&str> {
    let end = element.iter().position(|byte| *byte == 0)?;
    std::str::from_utf8(&element[..end]).ok().filter(|address| address.starts_with('/'))
}

/// Decodes a message.
///
/// This crate splits bundles itself. The library would read nested bundles by recursion, like arrays in
/// arguments, and would accept a truncated bundle as a shorter one.
fn message(element: &[u8]) -> Result<OscMessage, &'static str> {
    if element.len() > MAX_MESSAGE {
        return Err("has a message of more than 512 bytes");
    }
    match decoder::decode_udp(element) {
        Ok(([], OscPacket::Message(message))) => Ok(message),
        _ => Err("has a message that is no OSC"),
    }
}

fn stamp(number: &OscType, seconds: &OscType) -> Result<Stamp, &'static str> {
    let stamp = Stamp {
        number: whole(number)?,
        seconds: real(seconds)?,
        is_float: matches!(seconds, OscType::Float(_)),
    };
    if !(-MAX_SECONDS..=MAX_SECONDS).contains(&stamp.seconds) {
        return Err("has a time that is not finite, or beyond all clocks");
    }
    Ok(stamp)
}

fn whole(number: &OscType) -> Result<i64, &'static str> {
    match *number {
        OscType::Int(n) => Ok(n.into()),
        OscType::Long(n) => Ok(n),
        OscType::Float(x) if x.fract() == 0.0 => Ok(x as i64),
        OscType::Double(x) if x.fract() == 0.0 => Ok(x as i64),
        _ => Err("has a frame number that is no whole number"),
    }
}

fn real(number: &OscType) -> Result<f64, &'static str> {
    match *number {
        OscType::Int(n) => Ok(n.into()),
        OscType::Long(n) => Ok(n as f64),
        OscType::Float(x) => Ok(x.into()),
        OscType::Double(x) => Ok(x),
        _ => Err("has text or another type where a number belongs"),
    }
}
