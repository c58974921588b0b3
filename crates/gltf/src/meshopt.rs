//! The lossless compression of EXT_meshopt_compression.
//!
//! The extension fixes the versions of the codecs: 0 for vertices, 1 for indices. Of the two codecs for
//! indices, this module uses the one that keeps the order of the corners. The other codec may rotate
//! triangles.
//!
//! `meshopt-rs` is a port to Rust without a release since 2022. The maintained crate `meshopt` binds the
//! original in C++. Everyone who builds this project would need a C++ compiler for it, and one for wasm too.
//! It would also decode untrusted files in code without memory safety. The format is frozen, so the port has
//! nothing to keep up with. The tests decode its output with the original.

use meshopt_rs::index::IndexEncodingVersion;
use meshopt_rs::index::sequence::{
    decode_index_sequence, encode_index_sequence, encode_index_sequence_bound,
};
use meshopt_rs::vertex::VertexEncodingVersion;
use meshopt_rs::vertex::buffer::{decode_vertex_buffer, encode_vertex_buffer, encode_vertex_buffer_bound};
use rhytid_core::{Error, Result};

/// The extension's name.
pub(super) const EXTENSION: &str = "EXT_meshopt_compression";

/// The strides, in bytes, of the elements that are compressed.
macro_rules! with_stride {
    ($stride:expr, $codec:ident, $($argument:expr),+) => {
        match $stride {
            4 => Some($codec::<4>($($argument),+)),
            8 => Some($codec::<8>($($argument),+)),
            12 => Some($codec::<12>($($argument),+)),
            16 => Some($codec::<16>($($argument),+)),
            _ => None,
        }
    };
}

/// Compresses elements of `stride` bytes (4, 8, 12 or 16).
///
/// # Errors
/// [`Error::Internal`] for another stride.
pub(super) fn encode_elements(bytes: &[u8], stride: usize) -> Result<Vec<u8>> {
    with_stride!(stride, encode, bytes)
        .flatten()
        .ok_or_else(|| Error::Internal(format!("elements of {stride} bytes were to be compressed")))
}

fn encode<const N: usize>(bytes: &[u8]) -> Option<Vec<u8>> {
    let (elements, rest) = bytes.as_chunks::<N>();
    let mut out = vec![0; encode_vertex_buffer_bound(elements.len(), N)];
    let length = encode_vertex_buffer(&mut out, elements, VertexEncodingVersion::V0)?;
    out.truncate(length);
    rest.is_empty().then_some(out)
}

/// The `count` elements of `stride` bytes that `encoded` holds; `None` if it is damaged or the stride is not
/// supported.
pub(super) fn decode_elements(encoded: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    // At best, two bits stand for sixteen bytes.
    if count.checked_mul(stride)? / 64 > encoded.len() {
        return None;
    }
    with_stride!(stride, decode, encoded, count).flatten()
}

fn decode<const N: usize>(encoded: &[u8], count: usize) -> Option<Vec<u8>> {
    let mut out = vec![[0; N]; count];
    decode_vertex_buffer(&mut out, encoded).ok()?;
    Some(out.into_flattened())
}

/// Compresses indices of `vertices` vertices.
///
/// # Errors
/// [`Error::Internal`] if the codec fails.
pub(super) fn encode_indices(indices: &[u32], vertices: usize) -> Result<Vec<u8>> {
    let mut out = vec![0; encode_index_sequence_bound(indices.len(), vertices)];
    match encode_index_sequence(&mut out, indices, IndexEncodingVersion::V1) {
        0 => Err(Error::Internal(format!("{} indices could not be compressed", indices.len()))),
        length => {
            out.truncate(length);
            Ok(out)
        }
    }
}

/// The `count` indices that `encoded` holds; `None` if it is damaged.
pub(super) fn decode_indices(encoded: &[u8], count: usize) -> Option<Vec<u32>> {
    // Each index takes at least a byte.
    if count > encoded.len() {
        return None;
    }
    let mut out = vec![0_u32; count];
    decode_index_sequence(&mut out, encoded).ok()?;
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours that are alike, as those of a surface.
    fn smooth(count: usize, stride: usize) -> Vec<u8> {
        (0..count * stride).map(|i| (i / stride * (i % stride + 1) / 7) as u8).collect()
    }

    #[test]
    fn every_byte_comes_back_and_smooth_data_becomes_small() {
        for stride in [4, 8, 12, 16] {
            for count in [0, 1, 15, 16, 17, 255, 256, 257, 5000] {
                let bytes = smooth(count, stride);
                let encoded = encode_elements(&bytes, stride).unwrap();
                assert!(
                    decode_elements(&encoded, count, stride).as_ref() == Some(&bytes),
                    "{count} of {stride}"
                );
                assert!(count < 5000 || encoded.len() * 2 < bytes.len(), "{}", encoded.len());
                // As small as it gets.
                let zeros = encode_elements(&vec![0; count * stride], stride).unwrap();
                assert!(decode_elements(&zeros, count, stride) == Some(vec![0; count * stride]));
            }
        }
        let corners: Vec<u32> = (0..999).flat_map(|i| [i, i + 1, i * 37 % 1001]).collect();
        let encoded = encode_indices(&corners, 1001).unwrap();
        assert!(decode_indices(&encoded, corners.len()).as_ref() == Some(&corners));
    }

    #[test]
    fn what_is_damaged_gives_nothing_and_takes_no_memory() {
        let encoded = encode_elements(&smooth(500, 12), 12).unwrap();
        assert!(decode_elements(&encoded[..encoded.len() / 2], 500, 12).is_none());
        assert!(decode_elements(&encoded, 600, 12).is_none());
        assert!(decode_elements(&encoded, usize::MAX / 12, 12).is_none());
        assert!(decode_elements(&encoded, usize::MAX, 12).is_none());
        assert!(decode_elements(&encoded, 500, 7).is_none());
        assert!(decode_elements(&[], 0, 4).is_none());
        let encoded = encode_indices(&[0, 1, 2, 2, 1, 3], 4).unwrap();
        assert!(decode_indices(&encoded, 9).is_none());
        assert!(decode_indices(&encoded, 7).is_none());
        assert!(decode_indices(&encoded, usize::MAX).is_none());
        assert!(decode_indices(&[], 0).is_none());
    }
}
