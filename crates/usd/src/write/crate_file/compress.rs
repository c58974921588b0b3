//! The two codings of a crate file: LZ4 in USD's framing, and integers as differences of few bits.

/// The largest input of one LZ4 block.
const BLOCK: usize = 0x7e00_0000;

/// `bytes` as USD frames LZ4: a zero and a single block, or the number of blocks and each block after its
/// size.
///
/// At most 127 blocks, 252 GiB, can be told; the tables and index arrays that come here are far smaller.
pub(super) fn compress(bytes: &[u8]) -> Vec<u8> {
    if bytes.len() <= BLOCK {
        let mut out = vec![0];
        append_block(&mut out, bytes);
        return out;
    }
    let mut out = vec![bytes.len().div_ceil(BLOCK) as u8];
    for block in bytes.chunks(BLOCK) {
        let at = out.len();
        out.extend([0; 4]);
        append_block(&mut out, block);
        let size = (out.len() - at - 4) as u32;
        out[at..at + 4].copy_from_slice(&size.to_le_bytes());
    }
    out
}

fn append_block(out: &mut Vec<u8>, block: &[u8]) {
    out.extend(lz4_flex::block::compress(block));
}

/// The size of the compressed integers in bytes, followed by the compressed integers.
///
/// Each integer is the sum of the differences up to it. First comes the most common difference. Then two bits
/// for each integer say whether its difference is the common one or has 8, 16 or 32 bits. The other
/// differences come last. All of it is compressed with LZ4.
pub(super) fn compress_integers(integers: impl ExactSizeIterator<Item = i32>) -> Vec<u8> {
    let mut before = 0_i32;
    let differences: Vec<i32> = integers.map(|x| x.wrapping_sub(std::mem::replace(&mut before, x))).collect();
    let common = commonest(&differences);
    let mut codes = vec![0_u8; differences.len().div_ceil(4)];
    let mut rest = Vec::new();
    for (i, &difference) in differences.iter().enumerate() {
        let code = if difference == common {
            0
        } else if let Ok(byte) = i8::try_from(difference) {
            rest.extend(byte.to_le_bytes());
            1
        } else if let Ok(short) = i16::try_from(difference) {
            rest.extend(short.to_le_bytes());
            2
        } else {
            rest.extend(difference.to_le_bytes());
            3
        };
        codes[i / 4] |= code << (2 * (i % 4));
    }
    let packed = compress(&[&common.to_le_bytes(), codes.as_slice(), &rest].concat());
    let mut out = (packed.len() as u64).to_le_bytes().to_vec();
    out.extend(packed);
    out
}

/// The most frequent number, the smallest of several; 0 if there is none.
fn commonest(numbers: &[i32]) -> i32 {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable();
    let mut best = (0, 0);
    for run in sorted.chunk_by(|a, b| a == b) {
        if run.len() > best.0 {
            best = (run.len(), run[0]);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commonest_number_is_the_smallest_of_those_that_are_there_equally_often() {
        assert_eq!(commonest(&[]), 0);
        assert_eq!(commonest(&[7]), 7);
        assert_eq!(commonest(&[3, -5, 3, 9, -5, i32::MAX]), -5);
    }

    #[test]
    fn integers_stand_as_the_format_says() {
        // Differences 1, 1, 1, 300, -1, 70000, 1: the commonest once, codes 0 0 0 2 | 1 3 0, then the others.
        let packed = compress_integers([1, 2, 3, 303, 302, 70302, 70303].into_iter());
        let mut expected = 1_i32.to_le_bytes().to_vec();
        expected.extend([0b10_00_00_00, 0b00_00_11_01]);
        expected.extend(300_i16.to_le_bytes());
        expected.extend((-1_i8).to_le_bytes());
        expected.extend(70_000_i32.to_le_bytes());
        assert_eq!(packed[..8], (packed.len() as u64 - 8).to_le_bytes());
        assert_eq!(packed[8], 0, "one block");
        assert_eq!(lz4_flex::block::decompress(&packed[9..], 100).unwrap(), expected);
    }
}
