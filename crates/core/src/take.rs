//! The take: marker tracks in head space, with the head's motion and the confidence of each position.
use crate::{Error, InputErrorKind, Result, RigidMotion};

/// Marker tracks: positions of labelled markers over time, in mesh units and head space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Take {
    /// M distinct labels.
    pub labels: Vec<String>,
    /// One time per frame, in seconds, strictly increasing.
    pub times: Vec<f64>,
    /// frames × M positions.
    pub positions: Vec<[f64; 3]>,
    /// The head pose in the world in each frame; `None` where it is not known.
    pub head: Option<Vec<RigidMotion>>,
    /// frames × M: the confidence of each position, from 0 (a guess) to 1 (measured). `None` where all are 1.
    pub confidence: Option<Vec<f32>>,
}

/// A take becomes longer than this, and also this many times its own length, only because of a gap by
/// mistake.
const LEAST_TOO_MANY: usize = 1_000;
const TOO_MANY_TIMES: usize = 1_000;

impl Take {
    /// More frames than this come from a mistake in the times or the rate: nine hours at 30 frames per
    /// second.
    pub const MAX_RESAMPLED: usize = 1_000_000;

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// The take's own rate in frames per second. It comes from the mean of the steps that are no gaps: those
    /// within about a half of the median, since files round their times. A rate of rounded times is set to a
    /// whole number, to a multiple of 1000/1001 or to a number of few digits if that is within 0.04 %, and
    /// within the rounding. The rate is 30 where it cannot be told, as from one frame.
    pub fn rate(&self) -> f64 {
        let mut steps: Vec<f64> = self.times.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied().unwrap_or(f64::NAN);
        // Hundredths of a second leave steps of 1 and 2 to a rate of 60.
        steps.retain(|step| (step / median - 1.0).abs() < 0.51);
        let rate = steps.len() as f64 / steps.iter().sum::<f64>();
        if !(rate.is_finite() && rate > 0.0) {
            return 30.0;
        }
        // How far rounding moves a step. A clock that trembles may also run a little fast or slow.
        let rounding = steps.iter().map(|step| (step * rate - 1.0).abs()).fold(1e-9, f64::max);
        let whole = rate.round();
        let ntsc = (rate * 1.001).round() * 1000.0 / 1001.0;
        let most = rounding.min(4e-4);
        let near = |candidate: f64| candidate >= 0.9 && (rate / candidate - 1.0).abs() <= most;
        // Sums of exact times are off in their last digits.
        let shorter = [1e3, 1e6].map(|tens| (rate * tens).round() / tens);
        [whole, ntsc].into_iter().chain(shorter).find(|&candidate| near(candidate)).unwrap_or(rate)
    }

    /// The frames `range`, as a take of their own with unchanged times.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Take {
        let samples = range.start * self.labels.len()..range.end * self.labels.len();
        Take {
            labels: self.labels.clone(),
            times: self.times[range.clone()].to_vec(),
            positions: self.positions[samples.clone()].to_vec(),
            head: self.head.as_ref().map(|head| head[range].to_vec()),
            confidence: self.confidence.as_ref().map(|confidence| confidence[samples].to_vec()),
        }
    }

    /// The frames with these numbers, which are in rising order.
    ///
    /// # Panics
    /// If the take has no such frame.
    #[must_use]
    pub fn pick(&self, frames: &[usize]) -> Take {
        let markers = self.labels.len();
        let samples = || frames.iter().flat_map(move |frame| frame * markers..(frame + 1) * markers);
        Take {
            labels: self.labels.clone(),
            times: frames.iter().map(|&frame| self.times[frame]).collect(),
            positions: samples().map(|i| self.positions[i]).collect(),
            head: self.head.as_ref().map(|head| frames.iter().map(|&frame| head[frame]).collect()),
            confidence: self.confidence.as_ref().map(|confidence| samples().map(|i| confidence[i]).collect()),
        }
    }

    /// The take sampled at `fps` frames per second from its first time to its last. Positions and confidence
    /// are linear between frames, and the head turns evenly.
    ///
    /// # Errors
    /// [`Error::Input`] if `fps` is not finite and positive. [`Error::Input`] also if the result would have
    /// more than [`Take::MAX_RESAMPLED`] frames, or far more frames than the take.
    pub fn resample(&self, fps: f64) -> Result<Take> {
        if !(fps.is_finite() && fps > 0.0) {
            return Err(Error::out_of_range(format!("the frame rate is {fps}, expected a number above 0")));
        }
        let (Some(&start), Some(&end)) = (self.times.first(), self.times.last()) else {
            return Ok(self.clone());
        };
        let m = self.labels.len();
        // Files round their times, which can put the last sample just beyond the end. It still counts.
        let count = ((end - start) * fps + 0.01).floor() as usize + 1;
        if count > Self::MAX_RESAMPLED {
            return Err(Error::too_large(format!(
                "the take runs from {start} to {end} s, which is {count} frames at {fps} per second, expected at \
                 most {}; check its times",
                Self::MAX_RESAMPLED
            )));
        }
        if count > LEAST_TOO_MANY + TOO_MANY_TIMES * self.frames() {
            let steps = self.times.windows(2).map(|times| times[1] - times[0]).enumerate();
            let (before, step) = steps.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
            return Err(Error::too_large(format!(
                "the take has {} frames, but would have {count} at {fps} per second, because frame {} comes \
                 {step:.1} s after the frame before it; cut the take there, or check its times",
                self.frames(),
                before + 1
            )));
        }
        let head = self.head.as_ref().map(|_| Vec::with_capacity(count));
        let confidence = self.confidence.as_ref().map(|_| Vec::with_capacity(count * m));
        let mut out = Take { labels: self.labels.clone(), head, confidence, ..Take::default() };
        let mut k = 0;
        for i in 0..count {
            let time = (start + i as f64 / fps).min(end);
            while k + 2 < self.times.len() && self.times[k + 1] <= time {
                k += 1;
            }
            let next = (k + 1).min(self.times.len() - 1);
            let step = self.times[next] - self.times[k];
            let s = if step > 0.0 { (time - self.times[k]) / step } else { 0.0 };
            out.times.push(start + i as f64 / fps);
            if let (Some(head), Some(out)) = (&self.head, &mut out.head) {
                out.push(head[k].between(&head[next], s));
            }
            if let (Some(confidence), Some(out)) = (&self.confidence, &mut out.confidence) {
                let between = |j: usize| {
                    let (a, b) = (f64::from(confidence[k * m + j]), f64::from(confidence[next * m + j]));
                    (a + s * (b - a)) as f32
                };
                out.extend((0..m).map(between));
            }
            for j in 0..m {
                let (a, b) = (self.positions[k * m + j], self.positions[next * m + j]);
                out.positions.push(if s == 1.0 {
                    b
                } else {
                    std::array::from_fn(|c| a[c] + s * (b[c] - a[c]))
                });
            }
        }
        Ok(out)
    }

    /// The positions of `labels`, frame after frame and in their order, rounded to `f32`: frames × H × 3,
    /// what [`crate::Animator::evaluate`] takes. Labels that are not asked for are left out.
    ///
    /// # Errors
    /// [`Error::Input`] names every label that the take lacks.
    pub fn handle_positions(&self, labels: &[String]) -> Result<Vec<f32>> {
        let columns: Vec<Option<usize>> =
            labels.iter().map(|l| self.labels.iter().position(|m| m == l)).collect();
        let missing: Vec<&str> = labels
            .iter()
            .zip(&columns)
            .filter(|(_, column)| column.is_none())
            .map(|(label, _)| label.as_str())
            .collect();
        if !missing.is_empty() {
            let kind =
                InputErrorKind::MissingMarkers { labels: missing.iter().map(|&l| l.to_owned()).collect() };
            return Err(Error::input(format!(
                "the take lacks {} of the rig's {} handles: {}; every handle needs its three columns",
                missing.len(),
                labels.len(),
                missing.join(", ")
            ))
            .of_kind(kind));
        }
        let m = self.labels.len();
        let columns: Vec<usize> = columns.into_iter().flatten().collect();
        let mut out = Vec::with_capacity(self.frames() * columns.len() * 3);
        for frame in self.positions.chunks_exact(m.max(1)) {
            out.extend(columns.iter().flat_map(|&c| frame[c]).map(|x| x as f32));
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(times: &[f64]) -> Take {
        Take {
            labels: vec!["a".into()],
            times: times.to_vec(),
            positions: times.iter().map(|t| [*t, 2.0 * t, 1.0]).collect(),
            ..Take::default()
        }
    }

    #[test]
    fn the_rate_survives_rounded_times_and_gaps() {
        let rounded = |rate: f64, digits: f64| -> Vec<f64> {
            (0..200).map(|i| (f64::from(i) / rate * digits).round() / digits).collect()
        };
        assert_eq!(take(&rounded(30.0, 1e4)).rate(), 30.0);
        assert_eq!(take(&rounded(30.0, 1e3)).rate(), 30.0);
        assert_eq!(take(&rounded(120.0, 1e4)).rate(), 120.0);
        assert_eq!(take(&rounded(30000.0 / 1001.0, 1e6)).rate(), 30.0 * 1000.0 / 1001.0);
        assert!((take(&rounded(12.5, 1e6)).rate() - 12.5).abs() < 1e-9);
        // Milliseconds leave steps of 8 and 9 to a rate of 120.
        let milliseconds: Vec<f64> = (0..600).map(|i| (f64::from(i) / 0.12).round() / 1e3).collect();
        assert_eq!(take(&milliseconds).rate(), 120.0);
        let hundredths: Vec<f64> = (0..=1200).map(|i| (f64::from(i) / 0.6).round() / 1e2).collect();
        assert_eq!(take(&hundredths).rate(), 60.0);
        // Exact times leave no choice.
        for rate in [119.96, 59.94, 119.88, 29.97] {
            let exact: Vec<f64> = (0..2400).map(|i| f64::from(i) / rate).collect();
            assert_eq!(take(&exact).rate(), rate);
        }
        let mut gap = rounded(30.0, 1e4);
        gap.remove(57);
        assert_eq!(take(&gap).rate(), 30.0);
        assert_eq!(take(&[0.0]).rate(), 30.0);
        assert_eq!(take(&[-1.7e308, 1.7e308]).rate(), 30.0);
    }

    #[test]
    fn frames_are_picked_with_all_that_is_known_of_them() {
        let head = |angle: f64| RigidMotion { translation: [angle, 0.0, 0.0], ..RigidMotion::IDENTITY };
        let take = Take {
            labels: vec!["a".into(), "b".into()],
            times: vec![0.0, 0.1, 0.2, 0.3],
            positions: (0..8).map(|i| [f64::from(i); 3]).collect(),
            head: Some((0..4).map(|i| head(f64::from(i))).collect()),
            confidence: Some((0..8).map(|i| i as f32 / 8.0).collect()),
        };
        assert_eq!(take.pick(&[1, 2]), take.slice(1..3));
        let picked = take.pick(&[0, 3]);
        assert_eq!((picked.times, picked.positions[2]), (vec![0.0, 0.3], [6.0; 3]));
        assert_eq!(picked.confidence.unwrap(), [0.0, 0.125, 0.75, 0.875]);
        assert_eq!(picked.head.unwrap()[1], head(3.0));
    }

    #[test]
    fn resampling_is_linear_and_keeps_the_last_frame() {
        let times: Vec<f64> = (0..31).map(|i| (f64::from(i) / 30.0 * 1e4).round() / 1e4).collect();
        for (fps, count) in [(30.0, 31), (60.0, 61), (24.0, 25), (7.0, 8)] {
            let got = take(&times).resample(fps).unwrap();
            assert_eq!(got.frames(), count, "{fps}");
            for (time, p) in got.times.iter().zip(&got.positions) {
                // The last sample stays at the take's end, which the file rounded.
                assert!((p[0] - time).abs() < 1e-4 && (p[1] - 2.0 * p[0]).abs() < 1e-12);
            }
        }
        assert!(take(&times).resample(f64::NAN).is_err() && take(&times).resample(0.0).is_err());
    }

    #[test]
    fn handles_are_found_by_label_and_the_missing_ones_are_named() {
        let take = Take {
            labels: ["a", "b", "c"].map(String::from).to_vec(),
            times: vec![0.0],
            positions: vec![[1.0; 3], [2.0; 3], [3.0; 3]],
            ..Take::default()
        };
        let labels = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        assert_eq!(take.handle_positions(&labels(&["c", "a"])).unwrap(), [3.0, 3.0, 3.0, 1.0, 1.0, 1.0]);
        let message = take.handle_positions(&labels(&["a", "nose", "chin"])).unwrap_err().to_string();
        assert!(message.contains("2 of the rig's 3 handles: nose, chin"), "{message}");
    }
}
