//! Marker tracks in the form that the steps use.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::Take;
use rhytid_core::numbers::median;
use std::ops::Range;

/// Marker tracks, one column a marker: all steps but the head's run along time. A position that is NaN was
/// not seen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tracks {
    /// M columns with one position per frame.
    pub columns: Vec<Vec<DVec3>>,
    /// Frames per second.
    pub rate: f64,
}

impl Tracks {
    /// Takes the positions out of a take.
    pub(crate) fn new(take: &mut Take) -> Self {
        let (positions, m) = (std::mem::take(&mut take.positions), take.labels.len());
        let column = |c: usize| positions.iter().skip(c).step_by(m).copied().map(DVec3::from_array).collect();
        Self { columns: (0..m).into_par_iter().map(column).collect(), rate: take.rate() }
    }

    /// Number of frames.
    pub(crate) fn frames(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// Number of frames in `seconds`, at least 1.
    pub(crate) fn frames_in(&self, seconds: f64) -> usize {
        ((seconds * self.rate).round() as usize).max(1)
    }
}

/// Whether a marker was seen there.
pub(crate) fn seen(position: DVec3) -> bool {
    !position.is_nan()
}

/// The runs of frames in which a marker was not seen.
pub(crate) fn gaps(column: &[DVec3]) -> Vec<Range<usize>> {
    let mut gaps: Vec<Range<usize>> = Vec::new();
    for (f, _) in column.iter().enumerate().filter(|(_, p)| !seen(**p)) {
        match gaps.last_mut() {
            Some(gap) if gap.end == f => gap.end += 1,
            _ => gaps.push(f..f + 1),
        }
    }
    gaps
}

/// The median of each coordinate; NaN where there is no point.
pub(crate) fn median_point(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let mut coordinates: [Vec<f64>; 3] = Default::default();
    for point in points {
        point.to_array().iter().zip(&mut coordinates).for_each(|(x, list)| list.push(*x));
    }
    DVec3::from_array(coordinates.map(|mut list| median(&mut list)))
}

/// The diagonal of the box around the points that were seen; 0 where there is none.
pub(crate) fn extent(points: impl Iterator<Item = DVec3>) -> f64 {
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for p in points.filter(|p| seen(*p)) {
        let (low, high) = bounds.unwrap_or((p, p));
        bounds = Some((low.min(p), high.max(p)));
    }
    bounds.map_or(0.0, |(low, high)| low.distance(high))
}

/// The median extent of the columns over the take, in the file's unit; 0 where none was ever seen.
pub(crate) fn typical_extent(tracks: &Tracks, columns: &[usize]) -> f64 {
    let step = tracks.frames().div_ceil(200).max(1);
    let extents =
        (0..tracks.frames()).step_by(step).map(|f| extent(columns.iter().map(|&c| tracks.columns[c][f])));
    let mut extents: Vec<f64> = extents.filter(|e| *e > 0.0).collect();
    if extents.is_empty() { 0.0 } else { median(&mut extents) }
}

/// The mean of the seen positions; `None` if nothing was seen.
pub(crate) fn mean(column: &[DVec3], frames: &Range<usize>) -> Option<DVec3> {
    let points = || column[frames.clone()].iter().filter(|p| seen(**p));
    let n = points().count();
    (n > 0).then(|| points().sum::<DVec3>() / n as f64)
}

/// The standard deviation of a coordinate's noise, from the median of the second differences. Hardly any
/// motion has large second differences.
pub(crate) fn noise(tracks: &Tracks) -> f64 {
    /// As many frames of each marker are enough.
    const FRAMES: usize = 2000;
    let step = (tracks.frames() / FRAMES).max(1);
    let mut seconds: Vec<f64> = Vec::new();
    for column in &tracks.columns {
        for f in (1..tracks.frames().saturating_sub(1)).step_by(step) {
            let second = column[f - 1] - 2.0 * column[f] + column[f + 1];
            if seen(second) {
                seconds.extend(second.to_array().map(f64::abs));
            }
        }
    }
    // Half of a normal distribution lies within 0.6745 σ. The variance of a second difference is 1 + 4 + 1
    // times a sample's.
    if seconds.is_empty() { 0.0 } else { median(&mut seconds) / (0.674_489_75 * 6.0_f64.sqrt()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_runs() {
        let column = |text: &str| -> Vec<DVec3> {
            text.chars().map(|c| if c == '.' { DVec3::NAN } else { DVec3::ONE }).collect()
        };
        assert_eq!(gaps(&column("..x..x.")), [0..2, 3..5, 6..7]);
        assert!(gaps(&column("xx")).is_empty() && gaps(&[]).is_empty());
    }

    #[test]
    fn medians_of_even_and_odd_counts() {
        let points = [DVec3::new(0.0, 5.0, 1.0), DVec3::new(1.0, 0.0, 1.0), DVec3::new(9.0, 1.0, 1.0)];
        assert_eq!(median_point(points.into_iter()), DVec3::ONE);
    }
}
