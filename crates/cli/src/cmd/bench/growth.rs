//! The growth of a frame's time with a rig's sizes and with the batch.

use super::measure;
use crate::progress::Ui;
use rhytid::core::{DeviceInfo, Method};
use rhytid::{Error, Progress, Result, UploadOptions};
use rhytid_demo::{Size, sized_rig};
use serde::Serialize;

/// The vertex counts to try, as parts of the requested one: 10 k to 2 M for the chapter's 530,000.
const VERTICES: [f64; 6] = [0.02, 0.06, 0.2, 0.6, 2.0, 4.0];
const HANDLES: [usize; 5] = [30, 60, 100, 180, 300];
const EXAMPLES: [usize; 6] = [1, 3, 6, 10, 20, 40];
const FRAMES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];

/// The size that grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum What {
    Vertices,
    Handles,
    Examples,
    Frames,
}

impl What {
    pub(super) const ALL: [Self; 4] = [Self::Vertices, Self::Handles, Self::Examples, Self::Frames];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Handles => "handles",
            Self::Examples => "examples",
            Self::Frames => "frames in a batch",
        }
    }
}

/// A frame's time with one size changed.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Point {
    pub what: What,
    /// How large that size is.
    pub size: usize,
    /// Per frame; null where the device failed, usually for lack of memory.
    pub ms: Option<f64>,
}

/// The sizes to try: the size that changes, the rig and the batch.
fn sizes(usual: Size, frames: usize) -> Vec<(What, Size, usize)> {
    let mut sizes = Vec::new();
    for part in VERTICES {
        let vertices = ((usual.vertices as f64 * part) as usize).max(4 * usual.handles);
        sizes.push((What::Vertices, Size { vertices, ..usual }, frames));
    }
    for handles in HANDLES {
        let handles = handles.min(usual.vertices / 4);
        sizes.push((What::Handles, Size { handles, ..usual }, frames));
    }
    sizes.extend(EXAMPLES.map(|examples| (What::Examples, Size { examples, ..usual }, frames)));
    sizes.extend(FRAMES.map(|frames| (What::Frames, usual, frames)));
    sizes.dedup();
    sizes
}

/// Measures all devices at each size around the `usual` one, with rigs of this `method`. Returns the points
/// of each device.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn measure(
    devices: &[DeviceInfo],
    usual: Size,
    method: Method,
    options: UploadOptions,
    ui: &Ui,
) -> Result<Vec<Vec<Point>>> {
    let mut points = vec![Vec::new(); devices.len()];
    let sizes = sizes(usual, options.max_frames);
    let total = (sizes.len() * devices.len()) as u64;
    let mut last = None;
    for (i, (what, size, max_frames)) in sizes.into_iter().enumerate() {
        let rig = match last.take() {
            Some((made, rig)) if made == size => rig,
            _ => sized_rig(size, method),
        };
        for (d, (info, points)) in devices.iter().zip(&mut points).enumerate() {
            ui.report("measure how it grows", (i * devices.len() + d) as u64, total);
            if ui.cancelled() {
                return Err(Error::Cancelled);
            }
            let options = UploadOptions { max_frames, ..options };
            let ms = measure::whole_frame(info, &rig, options).ok();
            let size = match what {
                What::Vertices => rig.vertices(),
                What::Handles => rig.handles().len(),
                What::Examples => rig.centers() - 1,
                What::Frames => max_frames,
            };
            points.push(Point { what, size, ms });
        }
        last = Some((size, rig));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chapters_face_grows_to_two_million_vertices_and_no_size_comes_twice() {
        let sizes_of = |what, usual| {
            let all = sizes(usual, 1).into_iter().filter(move |size| size.0 == what);
            all.map(|(_, size, frames)| [size.vertices, size.handles, size.examples, frames])
                .collect::<Vec<_>>()
        };
        let vertices = sizes_of(What::Vertices, Size::CHAPTER);
        assert_eq!([vertices[0][0], vertices[5][0]], [10_600, 2_120_000]);
        assert_eq!(sizes_of(What::Frames, Size::CHAPTER).len(), 7);
        for what in What::ALL {
            let small = sizes_of(what, Size { vertices: 1_000, ..Size::CHAPTER });
            assert!(small.windows(2).all(|pair| pair[0] != pair[1]), "{small:?}");
            assert!(small.iter().all(|s| s[1] <= s[0] / 4), "{small:?}");
        }
    }
}
