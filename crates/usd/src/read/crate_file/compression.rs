//! The compression of crate files: bytes by LZ4, and integers as differences of few bytes each, then LZ4.

/// The most bytes that one byte of an LZ4 block can stand for.
const LZ4_MOST: usize = 255;

/// Undoes USD's compression; `None` if the bytes are damaged or longer than `most`.
///
/// The first byte is the number of chunks. Each chunk is an LZ4 block after its length. With 0 chunks, a
/// single block without a length follows.
pub(super) fn decompress(bytes: &[u8], most: usize) -> Option<Vec<u8>> {
    let most = most.min(bytes.len().saturating_mul(LZ4_MOST));
    let (&chunks, mut rest) = bytes.split_first()?;
    let mut out = vec![0; most];
    let mut done = 0;
    if chunks == 0 {
        done = lz4_flex::block::decompress_into(rest, &mut out).ok()?;
    }
    for _ in 0..chunks {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (block, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        done += lz4_flex::block::decompress_into(block, &mut out[done..]).ok()?;
        rest = after;
    }
    out.truncate(done);
    Some(out)
}

/// Decodes `count` integers; `None` if they are damaged.
///
/// First comes the most common difference of an integer to the one before. Then two bits for each integer
/// tell the size of its difference: 0 is the common difference, and 1, 2 and 3 are 1, 2 and 4 bytes. These
/// differences come last.
pub(super) fn integers(bytes: &[u8], count: usize) -> Option<Vec<i32>> {
    let codes_len = count.div_ceil(4);
    // Each is there or not before anything is allocated for it.
    if codes_len > bytes.len().saturating_mul(LZ4_MOST) {
        return None;
    }
    let encoded = decompress(bytes, count.checked_mul(4)?.checked_add(codes_len)?.checked_add(4)?)?;
    let (common, rest) = encoded.split_first_chunk::<4>()?;
    let (codes, mut rest) = rest.split_at_checked(codes_len)?;
    let mut take = |n: usize| {
        let (difference, after) = rest.split_at_checked(n)?;
        rest = after;
        Some(difference)
    };
    let mut last = 0_i32;
    let mut integers = Vec::with_capacity(count);
    for i in 0..count {
        let difference = match codes[i / 4] >> (i % 4 * 2) & 3 {
            0 => i32::from_le_bytes(*common),
            1 => i8::from_le_bytes(*take(1)?.first_chunk()?).into(),
            2 => i16::from_le_bytes(*take(2)?.first_chunk()?).into(),
            _ => i32::from_le_bytes(*take(4)?.first_chunk()?),
        };
        last = last.wrapping_add(difference);
        integers.push(last);
    }
    Some(integers)
}
