//! One frame as one datagram: an OSC 1.0 bundle without other bundles in it.
//!
//! The messages are one `/rhytid/frame ,id NUMBER SECONDS`, and a `/rhytid/handle ,sfff LABEL X Y Z` for each
//! visible marker, in any order. Numbers may have any of OSC's types `i`, `h`, `f` and `d`. Messages with
//! other addresses are ignored. The bundle's time tag is not read, because its clock may jump.

use rhytid_core::{Error, Result};
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, decoder, encoder};
use std::collections::HashSet;

/// The most bytes of a UDP datagram over IPv4.
pub const MAX_DATAGRAM: usize = 65_507;
/// The most bytes of a label.
pub const MAX_LABEL: usize = 255;

const FRAME: &str = "/rhytid/frame";
const HANDLE: &str = "/rhytid/handle";
/// The start of both addresses.
const OURS: &[u8] = b"/rhytid/";
/// "#bundle", a zero and the time tag.
const HEAD: usize = 16;
/// The most bytes of a Rhytid message. It bounds the decoder's nesting and allocations.
const MAX_MESSAGE: usize = 512;
/// The largest time: beyond it, the resolution of seconds is too coarse for frames.
const MAX_SECONDS: f64 = 1e10;
/// OSC's "immediately".
const NOW: OscTime = OscTime { seconds: 0, fractional: 1 };

/// A frame as it is sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its number, higher than that of the frame before. Gaps are lost frames.
    pub number: i64,
    /// Its time in seconds on the sender's clock, which may start at any moment. It is later than that of the
    /// frame before.
    pub seconds: f64,
    /// Distinct labels of markers and their positions: mesh units, head space. Markers that are not seen are
    /// left out.
    pub markers: Vec<(String, [f32; 3])>,
}

impl Frame {
    /// The frame as a datagram.
    ///
    /// # Errors
    /// [`Error::Input`] if [`decode`](Self::decode) would not give the same frame. This is so for more than
    /// [`MAX_DATAGRAM`] bytes, and for numbers that are not finite. It is also so for labels that are empty,
    /// longer than [`MAX_LABEL`], repeated, or have a zero byte.
    pub fn encode(&self) -> Result<Vec<u8>> {
        let message = |addr: &str, args| OscPacket::Message(OscMessage { addr: addr.to_owned(), args });
        let number = i32::try_from(self.number).map_or(OscType::Long(self.number), OscType::Int);
        let mut content = vec![message(FRAME, vec![number, OscType::Double(self.seconds)])];
        content.extend(self.markers.iter().map(|(label, position)| {
            let args = std::iter::once(OscType::String(label.clone()));
            message(HANDLE, args.chain(position.map(OscType::Float)).collect())
        }));
        let bytes = encoder::encode(&OscPacket::Bundle(OscBundle { timetag: NOW, content }))
            .map_err(|_| Error::Internal("an OSC bundle was not encoded".into()))?;
        match Self::decode(&bytes) {
            Ok(decoded) if decoded == *self => Ok(bytes),
            Ok(_) => Err(Error::out_of_range(
                "a label of the frame has a zero byte in it, expected text; rename the marker",
            )),
            Err(_) if bytes.len() > MAX_DATAGRAM => Err(Error::too_large(format!(
                "a frame of {} markers takes {} bytes, and a datagram has at most {MAX_DATAGRAM}; send fewer \
                 markers, such as only the handles of a rig",
                self.markers.len(),
                bytes.len()
            ))),
            Err(why) => Err(Error::out_of_range(format!("the frame cannot be sent: it {why}"))),
        }
    }

    /// The frame in a datagram. For any content, it uses no more memory than a small multiple of the
    /// datagram's size.
    ///
    /// # Errors
    /// What is wrong with it, as the rest of a sentence that begins with "the datagram".
    pub fn decode(datagram: &[u8]) -> Result<Self, &'static str> {
        if datagram.len() > MAX_DATAGRAM {
            return Err("is longer than a datagram can be");
        }
        if datagram.len() < HEAD || !datagram.starts_with(b"#bundle\0") {
            return Err("is no OSC bundle");
        }
        let (mut head, mut markers, mut labels) = (None, Vec::new(), HashSet::new());
        let mut rest = &datagram[HEAD..];
        while !rest.is_empty() {
            let (size, behind) = rest.split_first_chunk::<4>().ok_or("ends within a message")?;
            let size = u32::from_be_bytes(*size) as usize;
            let (element, behind) = behind.split_at_checked(size).ok_or("ends within a message")?;
            rest = behind;
            if element.starts_with(b"#bundle\0") {
                return Err("has a bundle within the bundle");
            }
            if !element.starts_with(OURS) {
                continue;
            }
            let OscMessage { addr, args } = message(element)?;
            match (addr.as_str(), args.as_slice()) {
                (FRAME, [number, seconds]) if head.is_none() => {
                    head = Some((whole(number)?, real(seconds)?));
                }
                (FRAME, [_, _]) => return Err("has /rhytid/frame twice"),
                (FRAME, _) => return Err("has a /rhytid/frame that is not NUMBER SECONDS"),
                (HANDLE, [OscType::String(label), x, y, z]) => {
                    if label.is_empty() || label.len() > MAX_LABEL {
                        return Err("has a label that is empty, or longer than 255 bytes");
                    }
                    if !labels.insert(label.clone()) {
                        return Err("has a label twice");
                    }
                    let position = [real(x)? as f32, real(y)? as f32, real(z)? as f32];
                    if !position.iter().all(|x| x.is_finite()) {
                        return Err("has a position that is not finite");
                    }
                    markers.push((label.clone(), position));
                }
                (HANDLE, _) => return Err("has a /rhytid/handle that is not LABEL X Y Z"),
                _ => {}
            }
        }
        let (number, seconds) = head.ok_or("has no /rhytid/frame")?;
        if !(-MAX_SECONDS..=MAX_SECONDS).contains(&seconds) {
            return Err("has a time that is not finite, or above 10,000,000,000 s");
        }
        Ok(Self { number, seconds, markers })
    }
}

/// Decodes a Rhytid message.
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
