//! Curves over time, thinned to what a plot can show.

/// A piece of a curve: time and value.
pub(crate) type Piece = Vec<[f64; 2]>;

/// The curve in pieces without gaps, thinned to at most two points in each of `columns` equal parts of
/// `span`.
///
/// These points are the least and the greatest of a part, in the order in time, so no peak is lost. Values
/// that are not finite are gaps. The times increase.
pub(crate) fn thin(samples: impl Iterator<Item = [f64; 2]>, span: [f64; 2], columns: usize) -> Vec<Piece> {
    let [start, end] = span;
    let per_second = columns as f64 / (end - start);
    let column_of = |time: f64| ((time - start) * per_second).clamp(0.0, columns as f64 - 1.0) as usize;
    let mut pieces = Vec::new();
    let mut piece = Piece::new();
    // The current column, and its least and greatest sample.
    let mut open: Option<(usize, [f64; 2], [f64; 2])> = None;
    for sample in samples {
        if !sample[1].is_finite() {
            flush(&mut piece, open.take());
            pieces.push(std::mem::take(&mut piece));
            continue;
        }
        let column = column_of(sample[0]);
        match &mut open {
            Some((at, least, greatest)) if *at == column => {
                if sample[1] < least[1] {
                    *least = sample;
                }
                if sample[1] > greatest[1] {
                    *greatest = sample;
                }
            }
            _ => flush(&mut piece, open.replace((column, sample, sample))),
        }
    }
    flush(&mut piece, open);
    pieces.push(piece);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

fn flush(piece: &mut Piece, open: Option<(usize, [f64; 2], [f64; 2])>) {
    let Some((_, least, greatest)) = open else { return };
    let (first, second) = if least[0] <= greatest[0] { (least, greatest) } else { (greatest, least) };
    piece.push(first);
    if second[0] > first[0] {
        piece.push(second);
    }
}

/// The spans of time in which a condition holds: the first and last time of each run. Runs that are closer
/// than `least` are joined.
pub(crate) fn stretches(samples: impl Iterator<Item = (f64, bool)>, least: f64) -> Vec<[f64; 2]> {
    let mut out: Vec<[f64; 2]> = Vec::new();
    for (time, holds) in samples {
        match out.last_mut() {
            _ if !holds => {}
            Some(last) if time - last[1] <= least => last[1] = time,
            _ => out.push([time, time]),
        }
    }
    out
}

/// Round times between `span`'s ends, about `count` of them: steps of 1, 2 or 5 times a power of ten.
pub(crate) fn ticks(span: [f64; 2], count: usize) -> Vec<f64> {
    let [start, end] = span;
    let rough = (end - start) / count as f64;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(10.0 * power);
    let first = (start / step).ceil();
    (0..=2 * count).map(|i| (first + i as f64) * step).take_while(|&t| t <= end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_of_one_sample_survives_in_its_place() {
        let spike = |i: usize| if i == 77_777 { 9.0 } else { (i as f64 * 0.01).sin() };
        let samples = (0..144_000).map(|i| [i as f64 / 240.0, spike(i)]);
        let pieces = thin(samples, [0.0, 600.0], 900);
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].len() <= 1800, "{}", pieces[0].len());
        assert!(pieces[0].contains(&[77_777.0 / 240.0, 9.0]));
        assert!(pieces[0].windows(2).all(|w| w[0][0] < w[1][0]));
    }

    #[test]
    fn few_samples_stay_and_gaps_part_the_curve() {
        let samples = [[0.0, 1.0], [1.0, 2.0], [2.0, f64::NAN], [3.0, f64::NAN], [4.0, 5.0]];
        let pieces = thin(samples.into_iter(), [0.0, 4.0], 100);
        assert_eq!(pieces, [vec![[0.0, 1.0], [1.0, 2.0]], vec![[4.0, 5.0]]]);
        assert!(thin([].into_iter(), [0.0, 1.0], 100).is_empty());
    }

    #[test]
    fn stretches_that_nearly_touch_are_one() {
        let holds = [true, true, false, true, false, false, false, true];
        let samples = holds.into_iter().enumerate().map(|(i, h)| (i as f64, h));
        assert_eq!(stretches(samples, 2.0), [[0.0, 3.0], [7.0, 7.0]]);
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(ticks([0.0, 20.0], 10), (0..=10).map(|i| 2.0 * f64::from(i)).collect::<Vec<_>>());
        assert_eq!(ticks([3.2, 4.1], 4), [3.5, 4.0]);
        assert!(ticks([1.0, 1.0], 10).is_empty() && ticks([0.0, f64::NAN], 10).is_empty());
    }
}
