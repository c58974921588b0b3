//! Crate files taken apart and put together again: values, then sections of compressed tables, then the table
//! of contents.
use libfuzzer_sys::fuzzer_mutate;

/// Where the values begin.
const HEADER: usize = 88;
/// Sections: the number of 8-byte numbers before the tables, and the tables.
const SECTIONS: [(&[u8], usize, &[Table]); 6] = [
    (b"TOKENS", 2, &[Table::Bytes]),
    (b"STRINGS", 0, &[]),
    (b"FIELDS", 1, &[Table::Integers, Table::Bytes]),
    (b"FIELDSETS", 1, &[Table::Integers]),
    (b"PATHS", 2, &[Table::Integers, Table::Integers, Table::Integers]),
    (b"SPECS", 1, &[Table::Integers, Table::Integers, Table::Integers]),
];

#[derive(Clone, Copy)]
enum Table {
    Bytes,
    /// Differences of few bytes each.
    Integers,
}

/// The file with one thing changed, which `seed` chooses; `None` if it is no crate file.
pub fn changed(file: &[u8], seed: u32) -> Option<Vec<u8>> {
    let contents = word(file, 16)?;
    let count = word(file, contents)?.min(SECTIONS.len());
    let entries: Vec<(&[u8], usize, usize)> = (0..count)
        .map(|i| {
            let entry = file.get(contents + 8 + 32 * i..)?.get(..32)?;
            Some((&entry[..16], word(entry, 16)?, word(entry, 24)?))
        })
        .collect::<Option<_>>()?;
    let values_end = entries.iter().map(|entry| entry.1).min()?;
    let mut values = file.get(HEADER..values_end)?.to_vec();
    // The sections are five sixths of the choices, and the values are the rest. Values keep their places.
    let chosen = seed as usize % (count + 1);
    if chosen == count {
        let size = values.len();
        mutate(&mut values);
        values.resize(size, 0);
    }
    let mut out = file.get(..HEADER)?.to_vec();
    out.extend(values);
    let mut table = (count as u64).to_le_bytes().to_vec();
    for (i, (name, at, size)) in entries.into_iter().enumerate() {
        let section = file.get(at..at.checked_add(size)?)?;
        let start = out.len();
        match i == chosen {
            true => out.extend(changed_section(name, section, seed as usize / (count + 1))?),
            false => out.extend(section),
        }
        table.extend(name);
        table.extend([start as u64, (out.len() - start) as u64].map(u64::to_le_bytes).as_flattened());
    }
    let contents = out.len() as u64;
    out[16..24].copy_from_slice(&contents.to_le_bytes());
    out.extend(table);
    Some(out)
}

fn changed_section(name: &[u8], section: &[u8], seed: usize) -> Option<Vec<u8>> {
    let (_, head, tables) =
        SECTIONS.into_iter().find(|(n, ..)| name.strip_prefix(*n).is_some_and(|end| end[0] == 0))?;
    let Some(chosen) = seed.checked_rem(tables.len()) else {
        let mut section = section.to_vec();
        mutate(&mut section);
        return Some(section);
    };
    let mut out = section.get(..8 * head)?.to_vec();
    let mut rest = section.get(8 * head..)?;
    for (i, table) in tables.iter().enumerate() {
        // Tokens have their size between the numbers and the bytes, like the others.
        let size = word(rest, 0)?;
        let packed = rest.get(8..size.checked_add(8)?)?;
        rest = &rest[8 + size..];
        let packed = match i == chosen {
            true => changed_table(*table, word(section, 0)?, packed)?,
            false => packed.to_vec(),
        };
        out.extend((packed.len() as u64).to_le_bytes());
        out.extend(packed);
    }
    Some(out)
}

/// One block of LZ4. All files that are small enough to be fuzzed have one block.
fn changed_table(table: Table, count: usize, packed: &[u8]) -> Option<Vec<u8>> {
    let block = packed.strip_prefix(&[0])?;
    let mut bytes = lz4_flex::block::decompress(block, 1 << 20).ok()?;
    match table {
        Table::Bytes => {
            let size = bytes.len();
            mutate(&mut bytes);
            bytes.resize(size, 0);
        }
        Table::Integers => {
            let mut integers: Vec<u8> =
                integers(&bytes, count)?.into_iter().flat_map(i32::to_le_bytes).collect();
            mutate(&mut integers);
            integers.resize(4 * count, 0);
            bytes = differences(integers.as_chunks().0.iter().map(|bytes| i32::from_le_bytes(*bytes)), count);
        }
    }
    Some([vec![0], lz4_flex::block::compress(&bytes)].concat())
}

/// From the commonest difference, two bits for each integer, and the differences unlike it.
fn integers(bytes: &[u8], count: usize) -> Option<Vec<i32>> {
    let common = i32::from_le_bytes(*bytes.first_chunk()?);
    let codes = bytes.get(4..)?.get(..count.div_ceil(4))?;
    let mut rest = &bytes[4 + codes.len()..];
    let mut take = |size: usize| {
        let mut wide = [0; 4];
        wide[..size].copy_from_slice(rest.get(..size)?);
        rest = &rest[size..];
        let unused = 32 - 8 * size as u32;
        Some(i32::from_le_bytes(wide) << unused >> unused)
    };
    let mut last = 0_i32;
    (0..count)
        .map(|i| {
            let difference = match codes[i / 4] >> (i % 4 * 2) & 3 {
                0 => common,
                code => take([1, 2, 4][code as usize - 1])?,
            };
            last = last.wrapping_add(difference);
            Some(last)
        })
        .collect()
}

/// Every difference in 4 bytes: the format does not require the shortest form.
fn differences(integers: impl Iterator<Item = i32>, count: usize) -> Vec<u8> {
    let mut out = vec![0; 4];
    out.extend(vec![0xff; count.div_ceil(4)]);
    let mut last = 0_i32;
    for integer in integers {
        out.extend(integer.wrapping_sub(last).to_le_bytes());
        last = integer;
    }
    out
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    usize::try_from(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?)).ok()
}

/// Changes `bytes`. Their number may grow by a few.
fn mutate(bytes: &mut Vec<u8>) {
    let size = bytes.len();
    bytes.resize(size + 16, 0);
    let size = fuzzer_mutate(bytes, size, size + 16);
    bytes.truncate(size);
}
