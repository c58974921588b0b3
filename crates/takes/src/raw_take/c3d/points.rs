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
    /// No position.
    Missing,
    /// A position of which the file says that it was not seen.
    Unseen([f64; 3]),
    Filled([f64; 3]),
    Measured([f64; 3]),
}

/// Reads the whole frames of `layout`, which lie within `bytes`.
pub(super) fn read(
    bytes: &[u8],
    layout: &Layout,
    processor: Processor,
    warnings: &mut Vec<String>,
) -> Points {
    let data = &bytes[layout.start..][..layout.frames * layout.frame_bytes()];
    let frames = data.par_chunks_exact(layout.frame_bytes()).with_min_len(64);
    let points = |frame| points(frame, layout, processor);
    let position = |seen| match seen {
        Seen::Missing | Seen::Unseen(_) => RawTake::MISSING,
        Seen::Filled(position) | Seen::Measured(position) => position,
    };
    // If no point was measured, the writer knew nothing of residuals and left them at zero.
    let any = |wanted: fn(&Seen) -> bool| frames.clone().any(|frame| points(frame).any(|seen| wanted(&seen)));
    let has_measured = any(|seen| matches!(seen, Seen::Measured(_)));
    let has_filled = any(|seen| matches!(seen, Seen::Filled(_)));
    let tells = has_measured && has_filled;
    let confidence = |seen| if matches!(seen, Seen::Filled(_)) { RawTake::FILLED } else { 1.0 };
    let samples = layout.frames * layout.points;
    let has_positions = || any(|seen| matches!(seen, Seen::Unseen(position) if *position != [0.0; 3]));
    if !has_measured && !has_filled && has_positions() {
        warnings.push(
            "every point has a residual below 0 and counts as not seen, though there are positions; if they are \
             right, export the file anew with residuals"
                .into(),
        );
    }
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
            // A point outside of what the integers reach, on all axes.
            if [x, y, z].iter().all(|word| word.abs() >= f64::from(i16::MAX)) {
                return Seen::Missing;
            }
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
    if !is_position {
        Seen::Missing
    } else if fourth < 0.0 || is_negative_word(fourth) {
        Seen::Unseen(position)
    } else if fourth == 0.0 {
        Seen::Filled(position)
    } else {
        Seen::Measured(position)
    }
}

/// Whether a float holds the bits of a 16-bit integer below 0, as some programs write them: 65535.0 for −1.
fn is_negative_word(fourth: f64) -> bool {
    const SIGN: u16 = 1 << 15;
    fourth.fract() == 0.0 && (f64::from(SIGN)..=f64::from(u16::MAX)).contains(&fourth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fourth_number_says_whether_a_point_was_seen() {
        let at = [1.0, 2.0, 3.0];
        for (fourth, expected) in [
            (-1.0, Seen::Unseen(at)),
            (-0.5, Seen::Unseen(at)),
            (65535.0, Seen::Unseen(at)),
            (f64::from(0x8000), Seen::Unseen(at)),
            (f64::from(0x7FFF), Seen::Measured(at)),
            (40000.5, Seen::Measured(at)),
            (70000.0, Seen::Measured(at)),
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
