//! Any two files as parts of an animation: a file that plays them and can be opened, or an error that leaves nothing.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::{animation, usd};

fuzz_target!(|parts: (&[u8], &[u8])| {
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-stitch-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let paths = [folder.join("a.usd"), folder.join("b.usd")];
    std::fs::write(&paths[0], parts.0).unwrap();
    std::fs::write(&paths[1], parts.1).unwrap();
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
