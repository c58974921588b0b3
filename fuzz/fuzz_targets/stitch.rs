//! Any two files as parts of an animation. The result is a file that plays them and can be opened, or an
//! error that leaves no file. The input is the size of the first part in 4 bytes, the first part, and the
//! second one.
#![no_main]
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use rhytid_core::Error;
use rhytid_formats::{animation, usd};

#[path = "usdc_sections/mod.rs"]
mod usdc_sections;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, second)) = parts(bytes) else { return };
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-stitch-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let paths = [folder.join("a.usd"), folder.join("b.usd")];
    std::fs::write(&paths[0], first).unwrap();
    std::fs::write(&paths[1], second).unwrap();
    let whole = folder.join("whole.usd");
    match usd::stitch(&paths, &whole) {
        Ok(stitched) => {
            let reader = animation::open(&whole).expect("what was stitched can be opened");
            assert_eq!(reader.summary().frames, stitched.frames);
        }
        Err(error) => {
            assert!(matches!(error, Error::Input(_)), "{error:?}");
            assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
        }
    }
});

// Only the second part changes, in one field or index or in any bytes. The first part must be readable before
// it.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let file = parts(&data[..size])
        .and_then(|(first, second)| Some((first.len() + 4, usdc_sections::changed(second, seed / 4)?)))
        .filter(|(at, file)| seed % 4 > 0 && at + file.len() <= max_size);
    let Some((at, file)) = file else { return fuzzer_mutate(data, size, max_size) };
    data[at..at + file.len()].copy_from_slice(&file);
    at + file.len()
});

fn parts(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (size, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*size) as usize)
}
