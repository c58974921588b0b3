//! Any bytes as the PNG of a displacement map, and of a normal map, move a mesh by sound numbers, or give an
//! error. The memory that a map takes is bounded, however large its header says that it is.
#![no_main]
use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use mutation::mutate;
use rhytid_core::{Error, Mesh, Result};
use rhytid_formats::mesh::{DisplacementMap, Format, NormalMap, NormalMapConvention, decode};
use std::sync::OnceLock;

#[path = "mutation/mod.rs"]
mod mutation;

const SQUARE: &[u8] =
    b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

fuzz_target!(|bytes: &[u8]| {
    static SET: OnceLock<()> = OnceLock::new();
    SET.get_or_init(|| rhytid_core::set_most_pixels(1 << 16));
    // The reader needs a file on disk.
    let path = std::env::temp_dir().join(format!("rhytid-fuzz-{}.png", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    sound(DisplacementMap::read(&path).and_then(|map| moved(|mesh| map.displace(mesh, 2.0))));
    let normals =
        |mesh: &mut Mesh, map: &NormalMap| map.displace(mesh, NormalMapConvention::Up, 1.0).map(drop);
    sound(NormalMap::read(&path).and_then(|map| moved(|mesh| normals(mesh, &map))));
});

fn moved(displace: impl FnOnce(&mut Mesh) -> Result<()>) -> Result<Mesh> {
    let mut mesh = decode(SQUARE, Format::Obj, "square").unwrap();
    displace(&mut mesh).map(|()| mesh)
}

fn sound(mesh: Result<Mesh>) {
    match mesh {
        Ok(mesh) => assert!(mesh.positions.as_flattened().iter().all(|x| x.abs() < 1e6)),
        Err(Error::Input(_)) => {}
        Err(other) => panic!("expected an input error, found {other:?}"),
    }
}

// Changes what a part of the file holds, and mends its length and checksum. Most of these files get past the
// parts' checks, which plain bytes hardly do.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutation::replace(changed(&data[..size], seed as usize), data, size, max_size)
});

fn changed(file: &[u8], seed: usize) -> Option<Vec<u8>> {
    let (signature, mut rest) = file.split_at_checked(8)?;
    let mut parts = Vec::new();
    while let Some((length, behind)) = rest.split_first_chunk::<4>() {
        let (kind, behind) = behind.split_at_checked(4)?;
        let (bytes, behind) = behind.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        parts.push((kind.to_vec(), bytes.to_vec()));
        rest = behind.get(4..)?;
    }
    if parts.is_empty() || seed % 8 == 0 {
        return None;
    }
    let chosen = seed / 8 % parts.len();
    let (kind, bytes) = &mut parts[chosen];
    match (seed % 8, &kind[..]) {
        // Pixels are compressed. The mutation is in what they unpack to.
        (1..4, b"IDAT") => {
            let mut pixels = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(bytes, 1 << 20).ok()?;
            mutate(&mut pixels);
            *bytes = miniz_oxide::deflate::compress_to_vec_zlib(&pixels, 1);
        }
        (4, _) => drop(parts.remove(chosen)),
        (5, _) => parts.swap(chosen, 0),
        _ => mutate(bytes),
    }
    let mut file = signature.to_vec();
    for (kind, bytes) in parts {
        file.extend((bytes.len() as u32).to_be_bytes());
        let at = file.len();
        file.extend(kind);
        file.extend(bytes);
        let sum = crc32fast::hash(&file[at..]);
        file.extend(sum.to_be_bytes());
    }
    Some(file)
}
