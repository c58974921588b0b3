//! Any bytes as a GLB file like ours give an animation or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_formats::animation;

fuzz_target!(|bytes: &[u8]| {
    // The reader needs a file on disk.
    let path = std::env::temp_dir().join(format!("rhytid-fuzz-{}.glb", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    let Ok(mut reader) = animation::open(&path) else { return };
    let summary = reader.summary().clone();
    assert!(summary.faces.fault(summary.vertices).is_none());
    let mut numbers = Vec::new();
    for frame in 0..summary.frames.min(4) {
        for channel in &summary.channels {
            if reader.channel(channel, frame, &mut numbers).is_ok() {
                assert_eq!(numbers.len(), channel.width * summary.vertices);
            }
        }
        let head = reader.head(frame);
        assert!(head.is_err() || head.is_ok_and(|head| head.is_some() == summary.head));
    }
});
