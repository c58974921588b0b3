//! The datagram's bytes.

use crate::frame;
use proptest::prelude::*;
use rhytid_live::{Frame, MAX_DATAGRAM, MAX_LABEL};

/// Bytes by the rules of OSC 1.0, without the library: text with its zeros.
pub(crate) fn text(s: &str) -> Vec<u8> {
    let mut bytes = s.as_bytes().to_vec();
    bytes.resize(s.len() / 4 * 4 + 4, 0);
    bytes
}

pub(crate) fn message(address: &str, tags: &str, arguments: &[&[u8]]) -> Vec<u8> {
    [text(address), text(tags), arguments.concat()].concat()
}

pub(crate) fn bundle(messages: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = [text("#bundle"), vec![0, 0, 0, 0, 0, 0, 0, 1]].concat();
    for message in messages {
        bytes.extend((message.len() as u32).to_be_bytes());
        bytes.extend(message);
    }
    bytes
}

pub(crate) fn head(number: i32, seconds: f64) -> Vec<u8> {
    message("/rhytid/frame", ",id", &[&number.to_be_bytes(), &seconds.to_be_bytes()])
}

pub(crate) fn handle(label: &str, position: [f32; 3]) -> Vec<u8> {
    let [x, y, z] = position.map(f32::to_be_bytes);
    message("/rhytid/handle", ",sfff", &[&text(label), &x, &y, &z])
}

fn refused(datagram: &[u8], why: &str) {
    let found = Frame::decode(datagram).unwrap_err();
    assert!(found.contains(why), "{found:?}, expected {why:?}");
}

#[test]
fn a_frame_is_the_bytes_that_the_pattern_says() {
    let frame = Frame {
        number: 7,
        seconds: 1.25,
        markers: vec![("chin".into(), [0.1, -2.0, 3e-8]), ("Öhr 2".into(), [0.0, -0.0, f32::MAX])],
    };
    let bytes =
        bundle(&[head(7, 1.25), handle("chin", [0.1, -2.0, 3e-8]), handle("Öhr 2", [0.0, -0.0, f32::MAX])]);
    assert_eq!(frame.encode().unwrap(), bytes);
    assert_eq!(Frame::decode(&bytes).unwrap(), frame);
}

#[test]
fn numbers_have_any_type_and_messages_any_order() {
    let seconds = message("/rhytid/frame", ",hf", &[&5_i64.to_be_bytes(), &0.5_f32.to_be_bytes()]);
    let mixed = message(
        "/rhytid/handle",
        ",sidh",
        &[&text("a"), &3_i32.to_be_bytes(), &0.5_f64.to_be_bytes(), &(-1_i64).to_be_bytes()],
    );
    let other = message("/other/thing", ",[[[", &[]);
    let ours = message("/rhytid/later", ",", &[]);
    let frame = Frame::decode(&bundle(&[mixed, other, seconds, ours])).unwrap();
    assert_eq!(frame, Frame { number: 5, seconds: 0.5, markers: vec![("a".into(), [3.0, 0.5, -1.0])] });
}

#[test]
fn what_is_no_frame_is_refused_with_a_reason() {
    let good = [head(1, 1.0), handle("a", [0.0; 3])];
    refused(b"", "no OSC bundle");
    refused(&head(1, 1.0), "no OSC bundle");
    refused(&bundle(&[]), "no /rhytid/frame");
    refused(&bundle(&good[1..]), "no /rhytid/frame");
    refused(&bundle(&[good[0].clone(), good[0].clone()]), "/rhytid/frame twice");
    refused(&bundle(&[good[0].clone(), good[1].clone(), good[1].clone()]), "a label twice");
    refused(&bundle(&[good[0].clone(), bundle(&good)]), "bundle within the bundle");
    refused(&bundle(&[good[0].clone(), handle("", [0.0; 3])]), "a label that is empty");
    refused(&bundle(&[good[0].clone(), handle(&"x".repeat(MAX_LABEL + 1), [0.0; 3])]), "255 bytes");
    refused(&bundle(&[good[0].clone(), handle(&"x".repeat(600), [0.0; 3])]), "512 bytes");
    refused(
        &bundle(&[good[0].clone(), handle("a", [0.0, f32::INFINITY, 0.0])]),
        "position that is not finite",
    );
    let beyond = 1e39_f64.to_be_bytes();
    let large = message("/rhytid/handle", ",sddd", &[&text("a"), &beyond, &beyond, &beyond]);
    refused(&bundle(&[good[0].clone(), large]), "position that is not finite");
    for seconds in [f64::NAN, f64::INFINITY, 1e20] {
        refused(&bundle(&[head(1, seconds)]), "a time that is not finite");
    }
    let half = message("/rhytid/frame", ",dd", &[&0.5_f64.to_be_bytes(), &0.5_f64.to_be_bytes()]);
    refused(&bundle(&[half]), "no whole number");
    let arrays = format!(",{}{}", "[".repeat(200), "]".repeat(200));
    refused(&bundle(&[message("/rhytid/frame", &arrays, &[])]), "NUMBER SECONDS");
    let words = message("/rhytid/handle", ",ssss", &[&text("a"), &text("b"), &text("c"), &text("d")]);
    refused(&bundle(&[good[0].clone(), words]), "where a number belongs");
    // A bundle that is cut after a message is a frame without the rest. A bundle that is cut anywhere else is
    // none.
    let whole = bundle(&good);
    for end in 0..whole.len() {
        if let Ok(cut) = Frame::decode(&whole[..end]) {
            assert_eq!((end, cut.markers.len()), (16 + 4 + good[0].len(), 0));
        }
    }
    let mut behind = good[1].clone();
    behind.extend([0; 4]);
    refused(&bundle(&[good[0].clone(), behind]), "no OSC");
}

/// Many programs send NaN for what no camera sees.
#[test]
fn a_marker_with_nan_is_left_out_of_its_frame() {
    let found = Frame::decode(&bundle(&[
        head(1, 1.0),
        handle("a", [0.0, f32::NAN, 0.0]),
        handle("b", [1.0, 2.0, 3.0]),
    ]));
    assert_eq!(found.unwrap().markers, [("b".to_owned(), [1.0, 2.0, 3.0])]);
}

#[test]
fn bundles_within_bundles_as_deep_as_a_datagram_can_have_them() {
    let depth = MAX_DATAGRAM / 20;
    let mut bytes = Vec::new();
    for i in 0..depth {
        bytes.extend(bundle(&[]));
        let left = (20 * (depth - i - 1)) as u32;
        bytes.extend(left.to_be_bytes());
    }
    refused(&bytes, "bundle within the bundle");
    let arrays = message("/x", &format!(",{}{}", "[".repeat(30_000), "]".repeat(30_000)), &[]);
    refused(&bundle(&[arrays]), "no /rhytid/frame");
}

#[test]
fn what_no_datagram_can_hold_is_an_error_of_the_sender() {
    let most = frame(0, 0.0, 1_200);
    assert!(most.encode().unwrap().len() <= MAX_DATAGRAM);
    let said = |frame: &Frame| frame.encode().unwrap_err().to_string();
    assert!(said(&frame(0, 0.0, 1_600)).contains("1600 markers takes"));
    let mut other = frame(0, 0.0, 2);
    other.markers[1].1[0] = f32::NAN;
    assert!(said(&other).contains("not finite"));
    other = frame(0, 0.0, 2);
    other.markers[1].0 = "a\0b".into();
    assert!(other.encode().is_err());
}

proptest! {
    #[test]
    fn a_frame_comes_back(
        number in any::<i64>(),
        seconds in -1e10..1e10_f64,
        markers in prop::collection::btree_map("[a-zA-Z0-9_ äß顔.,;]{1,40}", prop::array::uniform3(-1e30_f32..1e30), 0..100),
    ) {
        let frame = Frame { number, seconds, markers: markers.into_iter().collect() };
        prop_assert_eq!(Frame::decode(&frame.encode().unwrap()).unwrap(), frame);
    }

    /// Any bytes, and a sound datagram with some bytes of it changed, give a bounded frame or a reason.
    #[test]
    fn any_bytes_are_a_sound_frame_or_none(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let _ = Frame::decode(&bytes);
        let bundled = [b"#bundle\0\0\0\0\0\0\0\0\x01", &bytes[..]].concat();
        let mut sound = frame(3, 0.5, 4).encode().unwrap();
        for (at, byte) in changes {
            *at.get_mut(&mut sound) = byte;
        }
        let end = cut.index(sound.len() + 1);
        for datagram in [&bundled[..], &sound, &sound[..end]] {
            if let Ok(frame) = Frame::decode(datagram) {
                prop_assert!(44 * frame.markers.len() <= datagram.len());
                prop_assert!(frame.seconds.is_finite());
                prop_assert!(frame.markers.iter().all(|(label, position)|
                    !label.is_empty() && label.len() <= MAX_LABEL && position.iter().all(|x| x.is_finite())));
            }
        }
    }
}
