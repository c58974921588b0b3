//! Labels of a real take that change places again and again, in a ring or out of sight. What comes out is
//! compared with the truth: a mess is put right, or it is filled and not trusted.
use crate::real_take::{distances, rms, target, truth};
use rhytid_capture::{Cleaned, Kind, Settings, clean};
use rhytid_core::{NoProgress, RawTake};
use rhytid_formats::raw_take;
use rhytid_test_support::shared;
use std::io::Write;
use std::ops::Range;

fn raw() -> Option<RawTake> {
    Some(raw_take::read(&shared("data/takes/rom_3_raw.c3d")?, None).unwrap())
}

fn columns<const N: usize>(raw: &RawTake, labels: [&str; N]) -> [usize; N] {
    labels.map(|label| raw.tracks.labels.iter().position(|l| l == label).unwrap())
}

/// In frame `f` label `columns[k]` gets the position of label `columns[order[k]]`.
fn permute(raw: &mut RawTake, f: usize, columns: &[usize], order: &[usize]) {
    let frame = &mut raw.tracks.positions[f * raw.tracks.labels.len()..];
    let before: Vec<[f64; 3]> = columns.iter().map(|&c| frame[c]).collect();
    for (&column, &from) in columns.iter().zip(order) {
        frame[column] = before[from];
    }
}

fn hide(raw: &mut RawTake, column: usize, frames: Range<usize>) {
    let markers = raw.tracks.labels.len();
    frames.for_each(|f| raw.tracks.positions[f * markers + column] = RawTake::MISSING);
}

/// Reproducible whole numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

/// Another random order of `columns` every 5 to 20 frames.
fn shuffle(raw: &mut RawTake, columns: &[usize], frames: Range<usize>, seed: u64) {
    let mut random = Random(seed);
    let mut order: Vec<usize> = (0..columns.len()).collect();
    let mut next = frames.start;
    for f in frames {
        if f == next {
            for k in (1..order.len()).rev() {
                order.swap(k, random.below(k + 1));
            }
            next += 5 + random.below(16);
        }
        permute(raw, f, columns, &order);
    }
}

/// Cleans the take, and checks that nothing of the mess is played and that it is put right.
fn check(name: &str, raw: RawTake, messed: &[usize], frames: Range<usize>) -> Cleaned {
    check_within(1.5, name, raw, messed, frames)
}

/// Cleans the take, and checks that nothing of the mess is trusted. `most` is the largest RMS error in it, in
/// millimetres.
fn check_within(most: f64, name: &str, raw: RawTake, messed: &[usize], frames: Range<usize>) -> Cleaned {
    let target = target().unwrap();
    let found = clean(raw, &target, &Settings::default(), &NoProgress).unwrap();
    let off = distances(&found.take, &truth());
    let confidence = found.take.confidence.clone().unwrap();
    let samples = || {
        (frames.start - 30..(frames.end + 30).min(2400)).flat_map(|f| messed.iter().map(move |j| f * 89 + j))
    };
    let inside = rms(samples().map(|i| off[i]));
    let worst = samples().map(|i| off[i]).fold(0.0, f64::max);
    let trusted = samples().filter(|&i| confidence[i] > 0.5).map(|i| off[i]).fold(0.0, f64::max);
    let guessed = samples().filter(|&i| confidence[i] <= 0.5).count();
    let others = (0..off.len()).filter(|i| !messed.contains(&(i % 89)));
    let others = rms(others.map(|i| off[i]));
    let _ = writeln!(
        std::io::stderr(),
        "{name}: RMS {inside:.3} mm, worst {worst:.2}, worst trusted {trusted:.2}; {guessed} of {} guessed; \
         others {others:.4}",
        samples().count()
    );
    assert!(inside < most && trusted < 2.0 && others < 0.122, "{name}: {inside} {trusted} {others}");
    found
}

#[test]
fn lips_that_change_places_again_and_again_are_put_right() {
    let Some(whole) = raw() else { return };
    let lips = columns(&whole, ["mp50", "mp51", "mp52", "mp57"]);
    for (seed, first, frames) in [(1, 700, 120), (2, 1480, 240)] {
        let mut raw = whole.clone();
        shuffle(&mut raw, &lips, first..first + frames, seed);
        let found = check(&format!("lips {first}"), raw, &lips, first..first + frames);
        let shuffled = found.report.events.iter().filter(|e| e.kind == Kind::Shuffled);
        let is_there = |f: usize| f + 30 >= first && f <= first + frames + 30;
        assert!(shuffled.clone().count() >= 3);
        for event in shuffled {
            assert!(event.confidence < 1.0 && lips.contains(&event.marker.unwrap()), "{event:?}");
            assert!(is_there(event.first) && is_there(event.first + event.frames), "{event:?}");
        }
        let warnings = &found.report.warnings;
        assert!(warnings.iter().any(|w| w.sentence().contains("change places")), "{warnings:?}");
    }
}

#[test]
fn rings_pairs_and_exchanges_out_of_sight() {
    let Some(whole) = raw() else { return };
    let ring = columns(&whole, ["mp49", "mp50", "mp51"]);
    let mut raw = whole.clone();
    (1500..1560).for_each(|f| permute(&mut raw, f, &ring, &[1, 2, 0]));
    check("ring", raw, &ring, 1500..1560);

    let mut raw = whole.clone();
    for f in 1500..1680 {
        let order = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][(f / 11) % 3];
        permute(&mut raw, f, &ring, &order);
    }
    check("turning ring", raw, &ring, 1500..1680);

    let pair = columns(&whole, ["mp55", "mp56"]);
    let mut raw = whole.clone();
    (1500..1540).chain(1552..1600).for_each(|f| permute(&mut raw, f, &pair, &[1, 0]));
    check("a pair with a gap between", raw, &pair, 1500..1600);

    let other = columns(&whole, ["mp50", "mp51"]);
    let mut raw = whole.clone();
    (1500..1560).for_each(|f| permute(&mut raw, f, &pair, &[1, 0]));
    (1510..1550).for_each(|f| permute(&mut raw, f, &other, &[1, 0]));
    check("two pairs", raw, &[pair, other].concat(), 1500..1560);

    for hidden in [20, 80] {
        let mut raw = whole.clone();
        (1500..1700).for_each(|f| permute(&mut raw, f, &pair, &[1, 0]));
        hide(&mut raw, pair[0], 1500 - hidden / 2..1500 + hidden / 2);
        hide(&mut raw, pair[1], 1500 - hidden / 2..1500 + hidden / 2);
        check(&format!("both hidden for {hidden}"), raw, &pair, 1480..1700);
        let mut raw = whole.clone();
        (1500..1700).for_each(|f| permute(&mut raw, f, &pair, &[1, 0]));
        hide(&mut raw, pair[0], 1500 - hidden..1500);
        check(&format!("one hidden for {hidden}"), raw, &pair, 1480..1700);
    }

    // Until the end of the take. The model learns the last seconds as they are, so that these are not put
    // right. They are filled and not trusted.
    let mut raw = whole.clone();
    shuffle(&mut raw, &ring, 2100..2220, 7);
    (2220..2400).for_each(|f| permute(&mut raw, f, &ring, &[2, 0, 1]));
    check_within(4.0, "until the end", raw, &ring, 2100..2370);
}

#[test]
fn a_take_in_order_has_no_shuffle() {
    let (Some(raw), Some(target)) = (raw(), target()) else { return };
    let found = clean(raw, &target, &Settings::default(), &NoProgress).unwrap();
    let of = |kind: Kind| found.report.events.iter().filter(|e| e.kind == kind).count();
    assert_eq!((of(Kind::Shuffled), of(Kind::Swap), of(Kind::Slide)), (0, 1, 0));
    assert!(found.report.warnings.is_empty(), "{:?}", found.report.warnings);
}
