//! The lossless compression of EXT_meshopt_compression, and of KHR_meshopt_compression, which has the same
//! layout.
//!
//! Rhytid writes the first, which fixes the versions of the codecs: 0 for vertices, 1 for indices. Of the
//! two codecs for indices, it writes the one that keeps the order of the corners. The other codec may rotate
//! triangles. All codecs, versions and filters of both extensions are read, except for the filter of colours.
//!
//! `meshoptimizer-rs` is a port to Rust. The crate `meshopt` binds the original in C++. Everyone who builds
//! this project would need a C++ compiler for it, and one for wasm too. It would also decode untrusted files
//! in code without memory safety. The tests decode the port's output with the original.

use ::gltf::json::buffer::{Buffer, View};
use meshoptimizer_rs::codec::{
    IndexEncoding, VertexEncoding, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer, encode_index_sequence,
    encode_vertex_buffer,
};
use meshoptimizer_rs::{Limits, Workspace};
use rhytid_core::{Error, Result};
use serde::Deserialize;

/// The name of the extension that Rhytid writes.
pub(super) const EXTENSION: &str = "EXT_meshopt_compression";

/// The names of the extensions that are read.
pub const EXTENSIONS: [&str; 2] = [EXTENSION, "KHR_meshopt_compression"];

/// The most decoded bytes for each encoded byte, as far as they are more than [`SMALL`]. Version 0 cannot
/// exceed it.
const MOST_UNFOLDED: u64 = 64;

/// So many decoded bytes are never too many. Version 1 needs next to nothing for elements that are all alike.
const SMALL: u64 = 16 << 20;

/// Compresses elements of `stride` bytes: a multiple of 4, at most 256.
///
/// # Errors
/// [`Error::Internal`] for another stride.
pub(super) fn encode_elements(bytes: &[u8], stride: usize) -> Result<Vec<u8>> {
    let encoding = VertexEncoding::new(0, 0);
    encoding
        .and_then(|encoding| {
            let count = bytes.len().checked_div(stride).unwrap_or(0);
            encode_vertex_buffer(bytes, count, stride, encoding, &mut workspace())
        })
        .map_err(|e| Error::Internal(format!("elements of {stride} bytes were to be compressed: {e}")))
}

/// Compresses indices of vertices.
///
/// # Errors
/// [`Error::Internal`] if the codec fails.
pub(super) fn encode_indices(indices: &[u32]) -> Result<Vec<u8>> {
    encode_index_sequence(indices, IndexEncoding::DEFAULT, &mut workspace())
        .map_err(|e| Error::Internal(format!("{} indices could not be compressed: {e}", indices.len())))
}

/// What the extension says of a buffer view.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CompressedView {
    /// The buffer with the encoded bytes.
    pub buffer: usize,
    /// Where they begin in the buffer.
    #[serde(default)]
    pub byte_offset: u64,
    /// The number of encoded bytes.
    pub byte_length: u64,
    /// Bytes of a decoded element.
    byte_stride: usize,
    /// Number of elements.
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

impl CompressedView {
    /// What the extension says of `view`; `None` if the view is stored in the plain way.
    ///
    /// # Errors
    /// What is wrong with the view, as words that follow its name.
    pub fn of(view: &View) -> std::result::Result<Option<Self>, String> {
        let extensions = view.extensions.as_ref();
        let Some(found) = extensions.and_then(|e| EXTENSIONS.iter().find_map(|name| e.others.get(*name)))
        else {
            return Ok(None);
        };
        Self::deserialize(found)
            .map(Some)
            .map_err(|e| format!("is compressed in an unknown way ({e}); export it without compression"))
    }

    /// The number of decoded bytes, as the file announces it.
    pub fn decoded_length(&self) -> u64 {
        (self.count as u64).saturating_mul(self.byte_stride as u64)
    }

    /// The elements that `encoded` holds. They are at most 64 times as many bytes, or 16 MiB.
    ///
    /// # Errors
    /// What is wrong with the view, as words that follow its name.
    pub fn decode(&self, encoded: &[u8]) -> std::result::Result<Vec<u8>, String> {
        let (count, stride) = (self.count, self.byte_stride);
        let damaged = |why: &str| {
            format!(
                "cannot be unfolded to {count} elements of {stride} bytes ({why}); the file may be damaged"
            )
        };
        if self.decoded_length() > MOST_UNFOLDED.saturating_mul(encoded.len() as u64).max(SMALL) {
            return Err(damaged("too few bytes"));
        }
        let workspace = &mut workspace();
        let decoded = match self.mode.as_str() {
            "ATTRIBUTES" => decode_vertex_buffer(count, stride, encoded, workspace),
            "TRIANGLES" => decode_index_buffer(count, stride, encoded, workspace),
            "INDICES" => decode_index_sequence(count, stride, encoded, workspace),
            other => return Err(format!("is compressed in the unknown mode {other}; export it again")),
        };
        let mut bytes = decoded.map_err(|e| damaged(&e.to_string()))?;
        match self.filter.as_deref() {
            None | Some("NONE") => Ok(()),
            Some("OCTAHEDRAL") => decode_filter_oct(&mut bytes, count, stride, workspace),
            Some("QUATERNION") => decode_filter_quat(&mut bytes, count, stride, workspace),
            Some("EXPONENTIAL") => decode_filter_exp(&mut bytes, count, stride, workspace),
            Some(other) => {
                return Err(format!("has the filter {other}, which is not supported; export it without"));
            }
        }
        .map_err(|e| damaged(&e.to_string()))?;
        Ok(bytes)
    }
}

/// Whether a buffer only has a place in the file: its views hold their bytes elsewhere, encoded. A file may
/// keep the same bytes there for programs that cannot decode them.
pub fn is_placeholder(buffer: &Buffer) -> bool {
    let extensions = buffer.extensions.as_ref();
    let found = extensions.and_then(|e| EXTENSIONS.iter().find_map(|name| e.others.get(*name)));
    found.is_some_and(|said| said.get("fallback").is_some_and(|fallback| fallback == true))
}

/// Scratch memory. What callers ask for is bounded by them.
fn workspace() -> Workspace {
    Workspace::new(Limits { max_bytes: usize::MAX, max_work: u64::MAX })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(mode: &str, count: usize, byte_stride: usize) -> CompressedView {
        let mode = mode.to_owned();
        CompressedView { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode, filter: None }
    }

    /// Neighbours that are alike, as those of a surface.
    fn smooth(count: usize, stride: usize) -> Vec<u8> {
        (0..count * stride).map(|i| (i / stride * (i % stride + 1) / 7) as u8).collect()
    }

    #[test]
    fn every_byte_comes_back_and_smooth_data_becomes_small() {
        for stride in [4, 8, 12, 16] {
            for count in [1, 15, 16, 17, 255, 256, 257, 5000] {
                let bytes = smooth(count, stride);
                let encoded = encode_elements(&bytes, stride).unwrap();
                let view = view("ATTRIBUTES", count, stride);
                assert!(view.decode(&encoded).as_ref() == Ok(&bytes), "{count} of {stride}");
                assert!(count < 5000 || encoded.len() * 2 < bytes.len(), "{}", encoded.len());
                // As small as it gets.
                let zeros = encode_elements(&vec![0; count * stride], stride).unwrap();
                assert!(view.decode(&zeros) == Ok(vec![0; count * stride]));
            }
        }
        let corners: Vec<u32> = (0..999).flat_map(|i| [i, i + 1, i * 37 % 1001]).collect();
        let encoded = encode_indices(&corners).unwrap();
        let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
        assert!(view("INDICES", corners.len(), 4).decode(&encoded) == Ok(bytes));
    }

    #[test]
    fn what_is_damaged_gives_nothing_and_takes_no_memory() {
        let encoded = encode_elements(&smooth(500, 12), 12).unwrap();
        let refused = |mode, count, stride, encoded: &[u8]| {
            let said = view(mode, count, stride).decode(encoded).unwrap_err();
            assert!(said.contains("cannot be unfolded"), "{said}");
        };
        refused("ATTRIBUTES", 500, 12, &encoded[..encoded.len() / 2]);
        refused("ATTRIBUTES", 600, 12, &encoded);
        refused("ATTRIBUTES", usize::MAX / 12, 12, &encoded);
        refused("ATTRIBUTES", usize::MAX, 12, &encoded);
        refused("ATTRIBUTES", 500, 7, &encoded);
        refused("ATTRIBUTES", 0, 4, &[]);
        let encoded = encode_indices(&[0, 1, 2, 2, 1, 3]).unwrap();
        refused("INDICES", 9, 4, &encoded);
        refused("INDICES", 7, 4, &encoded);
        refused("INDICES", 6, 3, &encoded);
        refused("TRIANGLES", 6, 4, &encoded);
        refused("INDICES", usize::MAX, 4, &encoded);
        refused("INDICES", 0, 4, &[]);
        assert!(view("LINES", 6, 4).decode(&encoded).unwrap_err().contains("unknown mode LINES"));
    }

    #[test]
    fn a_filter_gives_the_numbers_of_its_formula() {
        // 2^exponent times mantissa: -3 · 2^-1, 5 · 2^4, -1 · 2^0, 0.
        let packed = |exponent: i32, mantissa: i32| (exponent << 24 | mantissa & 0xff_ffff).to_le_bytes();
        let bytes = [packed(-1, -3), packed(4, 5), packed(0, -1), packed(7, 0)].concat();
        let mut view = view("ATTRIBUTES", 1, 16);
        view.filter = Some("EXPONENTIAL".into());
        let decoded = view.decode(&encode_elements(&bytes, 16).unwrap()).unwrap();
        let numbers: Vec<f32> =
            decoded.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        assert_eq!(numbers, [-1.5, 80.0, -1.0, 0.0]);
        view.filter = Some("COLOR".into());
        let said = view.decode(&encode_elements(&bytes, 16).unwrap()).unwrap_err();
        assert!(said.contains("has the filter COLOR, which is not supported"), "{said}");
    }
}
