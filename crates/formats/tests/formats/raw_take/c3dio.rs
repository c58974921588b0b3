//! c3dio reads the files that the tests write as this reader does, in all six encodings. c3dio shares no code
//! with this reader or with ezc3d, and also knows the encodings of SGI, which ezc3d does not.
use super::c3d_writer::{C3d, PROCESSORS, trial};
use super::{is_missing, read};
use rhytid_core::RawTake;

#[test]
fn c3dio_reads_what_the_tests_write_as_this_reader_does() {
    for (name, processor) in PROCESSORS {
        let float = C3d { processor, ..trial(7, 40) };
        for written in [float.clone().integer(0.1), float] {
            let bytes = written.bytes();
            let oracle = c3dio::C3d::from_bytes(&bytes).unwrap();
            let take = read(&bytes, "trial.c3d").tracks;
            assert_eq!(take.labels, oracle.points.labels, "{name}");
            assert_eq!((take.frames(), take.labels.len()), oracle.points.points.size(), "{name}");
            let confidence = take.confidence.unwrap();
            for (i, position) in take.positions.iter().enumerate() {
                let point = oracle.points.points.get(i / 7, i % 7).unwrap();
                assert_eq!(is_missing(position), point.residual < 0.0, "{name}: {i}");
                // c3dio multiplies by the step in single precision.
                let near = |(a, b): (&f64, &f32)| (a - f64::from(*b)).abs() <= 1e-7 * a.abs();
                assert!(is_missing(position) || position.iter().zip(&point.point).all(near), "{name}: {i}");
                assert_eq!(confidence[i] == RawTake::FILLED, point.residual == 0.0, "{name}: {i}");
            }
        }
    }
}
