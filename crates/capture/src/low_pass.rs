//! A low-pass filter without delay: a second-order Butterworth filter, run forwards and backwards. Motion
//! that is too large to be noise stays.
use crate::tracks::Tracks;
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};

/// The filter takes at most so many standard deviations of a coordinate's noise from a moving marker.
const MOST: f64 = 2.0;
/// Frames before and after over which motion is told from noise.
const AROUND: usize = 4;
/// Between these multiples of the noise, the fast part is partly motion. From the second on, it is all
/// motion.
const MOVES: [f64; 2] = [1.25, 1.5];

/// Takes from all positions what is faster than `hz`. Without `noise` everything faster goes. `noise` is the
/// standard deviation of a coordinate; with it, only what is no larger than noise goes. A blink or a plosive
/// then loses at most [`MOST`] standard deviations of its height.
pub(crate) fn filter(tracks: &mut Tracks, hz: f64, noise: Option<f64>) {
    let rate = tracks.rate;
    tracks.columns.par_iter_mut().for_each(|column| {
        let mut fast = column.clone();
        for axis in 0..3 {
            let mut values: Vec<f64> = column.iter().map(|p| p[axis]).collect();
            low_pass(&mut values, hz, rate);
            fast.iter_mut().zip(values).for_each(|(p, slow)| p[axis] -= slow);
        }
        for (f, p) in column.iter_mut().enumerate() {
            *p -= fast[f];
            if let Some(noise) = noise {
                let around = &fast[f.saturating_sub(AROUND)..fast.len().min(f + AROUND + 1)];
                let mean = around.iter().map(|x| x.length_squared()).sum::<f64>() / around.len() as f64;
                let [some, all] = MOVES.map(|times| times * 3.0_f64.sqrt() * noise);
                let motion = ((mean.sqrt() - some) / (all - some)).clamp(0.0, 1.0);
                *p += motion * (fast[f] - fast[f].clamp_length_max(MOST * noise));
            }
        }
    });
}

/// Filters `values`, sampled `rate` times a second, so that a sine of `cutoff` Hz keeps 1/√2 of its height.
/// Constants and straight lines pass unchanged. A cut-off at or beyond 0.4 `rate` changes nothing, since
/// nothing is left to remove.
pub(crate) fn low_pass(values: &mut [f64], cutoff: f64, rate: f64) {
    if cutoff >= 0.4 * rate || values.len() < 2 {
        return;
    }
    // Two passes damp twice: each gets a cut-off at which it takes half as many decibels.
    let passes = (SQRT_2 - 1.0).powf(0.25);
    let k = (PI * cutoff / rate).tan() / passes;
    let norm = 1.0 / (1.0 + SQRT_2 * k + k * k);
    let b = k * k * norm;
    let a = [2.0 * (k * k - 1.0) * norm, (1.0 - SQRT_2 * k + k * k) * norm];

    // The signal is reflected through its ends, so that the filter has settled where the values begin.
    let n = values.len();
    let margin = ((3.0 * rate / cutoff).ceil() as usize).min(n - 1);
    let [first, last] = [values[0], values[n - 1]];
    let before = (1..=margin).rev().map(|i| 2.0 * first - values[i]);
    let after = (1..=margin).map(|i| 2.0 * last - values[n - 1 - i]);
    let mut padded: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        one_way(&mut padded, b, a);
        padded.reverse();
    }
    values.copy_from_slice(&padded[margin..margin + n]);
}

/// One pass of `y = b (x + 2 x₁ + x₂) − a₀ y₁ − a₁ y₂`, begun as if the first value had always been there.
fn one_way(values: &mut [f64], b: f64, a: [f64; 2]) {
    let mut x = [values[0]; 2];
    let mut y = x;
    for value in values {
        let out = b * (*value + 2.0 * x[0] + x[1]) - a[0] * y[0] - a[1] * y[1];
        x = [*value, x[0]];
        y = [out, y[0]];
        *value = out;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(hz: f64) -> Vec<f64> {
        (0..1200).map(|i| (2.0 * PI * hz * f64::from(i) / 120.0).sin()).collect()
    }

    #[test]
    fn the_gain_is_that_of_the_formula_and_nothing_is_delayed() {
        for (hz, cutoff) in [(2.0, 10.0), (10.0, 10.0), (20.0, 10.0), (6.0, 20.0)] {
            let mut found = sine(hz);
            low_pass(&mut found, cutoff, 120.0);
            // Butterworth's gain squared, with frequencies warped as the bilinear transform does.
            let warp = |f: f64| (PI * f / 120.0).tan();
            let ratio = warp(hz) / warp(cutoff) * (SQRT_2 - 1.0_f64).powf(0.25);
            let gain = 1.0 / (1.0 + ratio.powi(4));
            for (i, (a, b)) in found.iter().zip(sine(hz)).enumerate().skip(300).take(600) {
                assert!((a - gain * b).abs() < 1e-6, "{hz} {cutoff} {i}: {a} {b} {gain}");
            }
        }
        let mut half = sine(10.0);
        low_pass(&mut half, 10.0, 120.0);
        let top = half[300..900].iter().fold(0.0_f64, |m, x| m.max(*x));
        assert!((top - 0.5_f64.sqrt()).abs() < 1e-3, "{top}");
    }

    #[test]
    fn lines_pass_and_high_cut_offs_do_nothing() {
        let line: Vec<f64> = (0..50).map(|i| 3.0 - 0.25 * f64::from(i)).collect();
        let mut found = line.clone();
        low_pass(&mut found, 5.0, 60.0);
        for (a, b) in found.iter().zip(&line) {
            assert!((a - b).abs() < 0.02, "{a} {b}");
        }
        let mut same = sine(20.0);
        low_pass(&mut same, 20.0, 50.0);
        assert_eq!(same, sine(20.0));
        low_pass(&mut [], 1.0, 10.0);
        low_pass(&mut [1.0], 1.0, 10.0);
    }
}
