//! One frame as one datagram, as a sender makes it: an OSC 1.0 bundle without other bundles in it.
//!
//! The messages are one `/rhytid/frame ,id NUMBER SECONDS`, and a `/rhytid/handle ,sfff LABEL X Y Z` for each
//! visible marker.

use crate::part::{BUNDLE, FRAME, HANDLE, Part};
use crate::pattern::Pattern;
use rhytid_core::{Error, Result};
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

/// The most bytes of a UDP datagram over IPv4.
pub const MAX_DATAGRAM: usize = 65_507;
/// The most bytes of a label.
pub const MAX_LABEL: usize = 255;

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
        if self.markers.iter().flat_map(|(_, position)| position).any(|x| x.is_nan()) {
            return Err(Error::out_of_range(
                "the frame cannot be sent: it has a position that is not finite; leave out markers that are not seen",
            ));
        }
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

    /// The frame in a datagram that is a whole frame by itself. A marker with NaN for a coordinate was not
    /// seen, and is left out. For any content, it uses no more memory than a small multiple of the datagram's
    /// size.
    ///
    /// # Errors
    /// What is wrong with it, as the rest of a sentence that begins with "the datagram".
    pub fn decode(datagram: &[u8]) -> Result<Self, &'static str> {
        if !datagram.starts_with(BUNDLE) {
            return Err("is no OSC bundle");
        }
        let part = Part::decode(datagram, &Pattern::default())?;
        let stamp = part.stamp.ok_or("has no /rhytid/frame")?;
        Ok(Self { number: stamp.number, seconds: stamp.seconds, markers: part.markers })
    }
}
