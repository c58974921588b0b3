//! Any datagrams, one after another, leave streams with sound frames and without more memory. A frame that
//! was received can be sent on and decoded again.
//!
//! The input is cut into datagrams, each after two bytes with its length. The first byte of a length also
//! chooses the sender and advances the time. The streams take a rig's handles, all markers, and positions of
//! another program.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_live::{Frame, Stream};

fuzz_target!(|bytes: &[u8]| {
    let labels = ["brow".to_owned(), "lip_up".to_owned()];
    let handles = || Stream::new(&labels, &[[0.0; 3]; 2]);
    let other = "/m/{label}".parse().expect("a pattern");
    for mut stream in [handles(), Stream::of_all_markers(), handles().with_pattern(other)] {
        feed(&mut stream, bytes);
    }
});

fn feed(stream: &mut Stream, bytes: &[u8]) {
    let (mut rest, mut arrived, mut datagrams) = (bytes, 0.0, 0);
    let mut last: Option<f64> = None;
    while let Some(([high, low], behind)) = rest.split_first_chunk::<2>() {
        let size = usize::from(u16::from_be_bytes([high & 0x3f, *low])).min(behind.len());
        let datagram;
        (datagram, rest) = behind.split_at(size);
        let port = 1 + u16::from(high >> 7);
        arrived += if high & 0x40 == 0 { 0.004 } else { 1.5 };
        datagrams += 1;
        if let Ok(frame) = Frame::decode(datagram) {
            assert!(44 * frame.markers.len() <= datagram.len());
            // A frame of this length fits into a datagram again, independently of its numbers' types.
            assert_eq!(Frame::decode(&frame.encode().expect("a sound frame")), Ok(frame));
        }
        let mut is_new = stream.accept(datagram, ([127, 0, 0, 1], port).into(), arrived);
        assert!(!is_new || stream.newest().is_some());
        loop {
            if let Some(frame) = stream.newest() {
                assert_eq!(frame.positions.len(), frame.confidence.len());
                assert!(frame.positions.len() <= stream.labels().len());
                assert!(frame.positions.as_flattened().iter().all(|x| x.is_finite()));
                assert!(frame.confidence.iter().all(|c| (0.0..=1.0).contains(c)));
                assert!(frame.time.is_finite() && frame.latency >= 0.0);
                assert!(!is_new || last.is_none_or(|last| last < frame.time));
                last = Some(frame.time);
            }
            if !is_new {
                break;
            }
            is_new = stream.close(arrived);
        }
    }
    let counts = stream.counts();
    assert!(counts.frames + counts.late + counts.bad <= datagrams);
    assert!(stream.warnings().len() <= 8 && stream.labels().len() <= 1_024);
}
