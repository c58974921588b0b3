//! The points of a C3D file.
use super::layout::{Layout, Storage};
use super::processor::Processor;
use rayon::prelude::*;
use rhytid_core::RawTake;

/// Frames × M positions. If the file says which were filled, also their confidence.
pub(super) struct Points {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) confidence: Option<Vec<f32>>,
}

/// What a file says of one marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Seen {
    Missing,
    Filled([f64; 3]),
    Measured([f64; 3]),
}

/// Reads the whole frames of `layout`, which lie within `bytes`.
pub(super) fn read(bytes: &[u8], layout: &Layout, processor: Processor) -> Points {
    let data = &bytes[layout.start..][..layout.frames * layout.frame_bytes()];
    let frames = data.par_chunks_exact(layout.frame_bytes()).with_min_len(64);
    let points = |frame| points(frame, layout, processor);
    let position = |seen| match seen {
        Seen::Missing => RawTake::MISSING,
        Seen::Filled(position) | Seen::Measured(position) => position,
    };
    // If no point was measured, the writer knew nothing of residuals and left them at zero.
    let any = |wanted: fn(&Seen) -> bool| frames.clone().any(|frame| points(frame).any(|seen| wanted(&seen)));
    let tells = any(|seen| matches!(seen, Seen::Measured(_))) && any(|seen| matches!(seen, Seen::Filled(_)));
    let confidence = |seen| if matches!(seen, Seen::Filled(_)) { RawTake::FILLED } else { 1.0 };
    let samples = layout.frames * layout.points;
    let mut out =
        Points { positions: vec![RawTake::MISSING; samples], confidence: tells.then(|| vec![1.0; samples]) };
    let rows = out.positions.par_chunks_exact_mut(layout.points).zip(frames.clone());
    rows.for_each(|(row, frame)| {
        row.iter_mut().zip(points(frame)).for_each(|(to, seen)| *to = position(seen));
    });
    if let Some(out) = &mut out.confidence {
        let rows = out.par_chunks_exact_mut(layout.points).zip(frames);
        rows.for_each(|(row, frame)| {
            row.iter_mut().zip(points(frame)).for_each(|(to, seen)| *to = confidence(seen));
        });
    }
    out
}

/// The points of a frame; its analog measurements, which follow them, are left out.
fn points(frame: &[u8], layout: &Layout, processor: Processor) -> impl Iterator<Item = Seen> {
    let storage = layout.storage;
    frame.chunks_exact(storage.point_bytes()).take(layout.points).map(move |point| match storage {
        Storage::Integer { scale } => {
            let [x, y, z, residual] = numbers(point, |word| f64::from(processor.word(word) as i16));
            seen([x, y, z].map(|x| x * scale), residual)
        }
        Storage::Float => {
            let [x, y, z, residual] = numbers(point, |float| processor.float(float));
            seen([x, y, z], residual)
        }
    })
}

/// The four numbers of a point.
fn numbers<const N: usize>(point: &[u8], number: impl Fn([u8; N]) -> f64) -> [f64; 4] {
    let (words, _) = point.as_chunks::<N>();
    std::array::from_fn(|i| words.get(i).map_or(f64::NAN, |&word| number(word)))
}

/// The fourth number is below zero for a point that was not seen. Otherwise one of its bytes is the residual,
/// and the other tells the cameras that saw the point. Writers do not agree on which byte is which. All
/// writers leave both at zero for a point that was filled.
fn seen(position: [f64; 3], fourth: f64) -> Seen {
    let is_position = position.iter().all(|x| x.abs() <= f64::from(f32::MAX));
    if !is_position || fourth < 0.0 {
        Seen::Missing
    } else if fourth == 0.0 {
        Seen::Filled(position)
    } else {
        Seen::Measured(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fourth_number_says_whether_a_point_was_seen() {
        let at = [1.0, 2.0, 3.0];
        for (fourth, expected) in [
            (-1.0, Seen::Missing),
            (-0.5, Seen::Missing),
            (0.0, Seen::Filled(at)),
            (f64::from(0x0300), Seen::Measured(at)),
            (f64::from(0x0005), Seen::Measured(at)),
            (0.4, Seen::Measured(at)),
            (f64::NAN, Seen::Measured(at)),
        ] {
            assert_eq!(seen(at, fourth), expected, "{fourth}");
        }
        assert_eq!(seen([1.0, f64::NAN, 3.0], 1.0), Seen::Missing);
        assert_eq!(seen([1.0, 2.0, f64::INFINITY], 1.0), Seen::Missing);
    }
}
