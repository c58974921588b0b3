//! How long the whole clean-up takes: ten minutes of 150 markers at 240 Hz, noisy, with gaps, ghosts and a
//! swap every minute: `cargo bench -p rhytid-capture --bench clean`. Each step's time, beside that of going
//! through all positions once.
use glam::{DQuat, DVec3};
use rhytid_capture::{Settings, Target, clean};
use rhytid_core::{Progress, RawTake, Result, Take};
use std::sync::Mutex;
use std::time::Instant;

const HANDLES: usize = 146;
const CAP: usize = 4;
const MARKERS: usize = HANDLES + CAP;
const RATE: usize = 240;
const FRAMES: usize = 600 * RATE;
/// Independent motions of the face.
const MOTIONS: usize = 14;

/// A deterministic number from -1 to 1.
fn random(i: usize) -> f64 {
    let mut x = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 29)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn vector(i: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| random(3 * i + axis)))
}

/// Where the markers are at rest, in millimetres: half a cylinder of a face's size with a cap on top.
fn rest() -> Vec<DVec3> {
    let face = (0..HANDLES).map(|j| {
        let (row, column) = ((j / 12) as f64, (j % 12) as f64);
        let angle = (column - 5.5) * 0.24;
        DVec3::new(80.0 * angle.sin(), 16.0 * row - 100.0, 80.0 * angle.cos()) + 2.0 * vector(j)
    });
    let cap = (0..CAP).map(|i| {
        let angle = 1.1 * i as f64;
        DVec3::new(60.0 * angle.cos(), 130.0 + 9.0 * i as f64, 60.0 * angle.sin())
    });
    face.chain(cap).collect()
}

fn raw_take(rest: &[DVec3]) -> RawTake {
    let shapes: Vec<DVec3> = (0..MOTIONS * HANDLES)
        .map(|i| {
            let (k, at) = (i / HANDLES, rest[i % HANDLES]);
            let away = at.distance_squared(rest[k * 10 + 3]) / (40.0 * 40.0);
            vector(1000 + k) * 9.0 * (-away).exp()
        })
        .collect();
    let mut positions = Vec::with_capacity(FRAMES * MARKERS);
    for f in 0..FRAMES {
        let t = f as f64 / RATE as f64;
        // Nothing moves in the first second.
        let begins = (t - 1.0).clamp(0.0, 1.0);
        let weights: Vec<f64> = (0..MOTIONS)
            .map(|k| begins * (t * (1.0 + 0.31 * k as f64)).sin().powi(2) * (0.13 * t + k as f64).cos())
            .collect();
        let turn = DQuat::from_euler(
            glam::EulerRot::XYZ,
            0.2 * (0.7 * t).sin(),
            0.3 * (0.4 * t).cos(),
            0.1 * t.sin(),
        );
        let at = DVec3::new(100.0 * (0.2 * t).sin(), 1500.0, 50.0 * (0.3 * t).cos());
        for j in 0..MARKERS {
            let mut local = rest[j];
            if j < HANDLES {
                local += (0..MOTIONS).map(|k| shapes[k * HANDLES + j] * weights[k]).sum::<DVec3>();
            }
            let seed = f * MARKERS + j;
            let mut p = turn * local + at + 0.15 * vector(seed);
            // Every second marker is hidden twice a minute, for a twentieth of a second to two.
            let hidden = (f + 977 * j) % (30 * RATE);
            if j % 2 == 1 && hidden < 12 + (j * 37) % 468 {
                p = DVec3::NAN;
            }
            if random(seed + 77).abs() > 0.999_99 {
                p += 40.0 * vector(seed + 5);
            }
            positions.push(p.to_array());
        }
        if f % (60 * RATE) > 60 * RATE - 300 {
            positions.swap(f * MARKERS + 30, f * MARKERS + 31);
        }
    }
    let labels = (0..MARKERS).map(|j| format!("m{j}")).collect();
    let times = (0..FRAMES).map(|f| f as f64 / RATE as f64).collect();
    let tracks = Take { labels, times, positions, ..Take::default() };
    RawTake { tracks, metres_per_unit: Some(1e-3), ..RawTake::default() }
}

/// Prints how long each step took.
struct Steps(Mutex<Instant>);

impl Progress for Steps {
    fn report(&self, _step: &'static str, done: u64, _total: u64) {
        let names = ["", "columns", "head", "place", "swaps, outliers", "gaps", "filter, results"];
        let mut since = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if done > 0 {
            println!("{:>16} {:6.2} s", names[done as usize], since.elapsed().as_secs_f64());
        }
        *since = Instant::now();
    }
}

fn main() -> Result<()> {
    let rest = rest();
    println!("{FRAMES} frames of {MARKERS} markers, on {} threads", rayon::current_num_threads());
    let raw = raw_take(&rest);
    let start = Instant::now();
    let sum: f64 = raw.tracks.positions.as_flattened().iter().filter(|x| !x.is_nan()).sum();
    let once = start.elapsed();
    std::hint::black_box(sum);
    let target = Target {
        labels: raw.tracks.labels[..HANDLES].to_vec(),
        rest: rest[..HANDLES].iter().map(|p| *p / 10.0).collect(),
        metres_per_unit: 0.01,
        strains: Vec::new(),
        examples: Vec::new(),
    };
    let start = Instant::now();
    let cleaned = clean(raw, &target, &Settings::default(), &Steps(Mutex::new(start)))?;
    let time = start.elapsed().as_secs_f64();
    println!(
        "{:>16} {time:6.2} s, {} events; all positions once: {once:.2?}",
        "whole",
        cleaned.report.events.len()
    );
    Ok(())
}
