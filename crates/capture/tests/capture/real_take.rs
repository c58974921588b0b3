//! A real motion made difficult, compared with what a perfect clean-up returns. It needs `../shared/data`
//! beside the repository.
use glam::{DQuat, DVec3};
use rhytid_capture::{Cleaned, Kind, Settings, Target, clean};
use rhytid_core::{NoProgress, Take};
use rhytid_formats::{mesh, raw_take, tables, take};
use rhytid_test_support::shared;
use std::io::Write;

pub(crate) fn target() -> Option<Target> {
    let handles = tables::read_handles(&shared("data/markers.csv")?).unwrap();
    let neutral = mesh::read(&shared("data/face/neutral.obj")?).unwrap();
    let rest = handles.at(&neutral.positions).into_iter().map(DVec3::from_array).collect();
    Some(Target { labels: handles.labels, rest, metres_per_unit: 0.01, strains: vec![], examples: vec![] })
}

fn cleaned(file: &str) -> Option<Cleaned> {
    let (target, path) = (target()?, shared(file)?);
    let raw = raw_take::read(&path, None).unwrap();
    Some(clean(raw, &target, &Settings::default(), &NoProgress).unwrap())
}

/// frames × 89 positions in centimetres.
pub(crate) fn truth() -> Vec<DVec3> {
    let bytes = std::fs::read(shared("data/takes/rom_3_raw_truth.npy").unwrap()).unwrap();
    let numbers: Vec<f32> = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
    numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect()
}

/// Distances in millimetres.
pub(crate) fn distances(take: &Take, truth: &[DVec3]) -> Vec<f64> {
    assert_eq!(take.positions.len(), truth.len());
    take.positions.iter().zip(truth).map(|(p, q)| 10.0 * DVec3::from_array(*p).distance(*q)).collect()
}

pub(crate) fn rms(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = numbers.fold((0.0, 0), |(sum, n), x| (sum + x * x, n + 1));
    assert!(n > 0);
    (sum / f64::from(n)).sqrt()
}

#[test]
fn the_raw_take_comes_out_as_it_was() {
    let Some(Cleaned { take, report }) = cleaned("data/takes/rom_3_raw.c3d") else { return };
    let raw = raw_take::read(&shared("data/takes/rom_3_raw.c3d").unwrap(), None).unwrap().tracks;
    let distances = distances(&take, &truth());
    let missing: Vec<bool> =
        (0..distances.len()).map(|i| raw.positions[i / 89 * raw.labels.len() + i % 89][0].is_nan()).collect();
    let all = rms(distances.iter().copied());
    let filled = rms(distances.iter().zip(&missing).filter(|(_, missing)| **missing).map(|(d, _)| *d));
    let worst = distances.iter().copied().fold(0.0, f64::max);
    let _ = writeln!(
        std::io::stderr(),
        "RMS {all:.4} mm, {filled:.4} mm over what was missing, {worst:.3} mm at worst; scale {:.5}, noise {:.3} mm, \
         neutral {:?}, {} events",
        report.setup.scale,
        report.noise_mm,
        report.setup.neutral,
        report.events.len()
    );
    assert!(all <= 0.122 && filled <= 0.8 && worst <= 4.0, "{all} {filled} {worst}");
    assert!((report.setup.scale / 0.93 - 1.0).abs() < 0.002, "{}", report.setup.scale);
    assert!(
        report.setup.neutral.start < 10 && report.setup.neutral.len() == 60,
        "{:?}",
        report.setup.neutral
    );
    assert_eq!(report.setup.rigid, ["head0", "head1", "head2", "head3"]);
    assert_eq!((report.setup.axes.as_str(), report.setup.metres_per_unit), ("+x+z-y", 1e-3));
}

#[test]
fn every_fault_of_the_raw_take_is_listed_and_few_others() {
    let Some(Cleaned { report, .. }) = cleaned("data/takes/rom_3_raw.c3d") else { return };
    let raw = raw_take::read(&shared("data/takes/rom_3_raw.c3d").unwrap(), None).unwrap().tracks;
    // The faults, from the truth: the head's true motion puts every position where it should be.
    let truth = truth();
    let head = std::fs::read_to_string(shared("data/takes/rom_3_raw_head.csv").unwrap()).unwrap();
    let label = |name: &str| report.labels.iter().position(|l| l == name).unwrap();
    let mut ghosts = Vec::new();
    let mut gaps = vec![Vec::new(); 89];
    for (f, line) in head.lines().skip(1).enumerate() {
        let n: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (turn, move_by) = (DQuat::from_xyzw(n[2], n[3], n[4], n[1]), DVec3::new(n[5], n[6], n[7]));
        for (j, gaps) in gaps.iter_mut().enumerate() {
            let [x, y, z] = raw.positions[f * raw.labels.len() + j];
            let expected = 10.0 * (0.93 * (turn * truth[f * 89 + j]) + move_by);
            let off = DVec3::new(x, z, -y).distance(expected);
            if off.is_nan() {
                gaps.push(f);
            } else if off > 3.0 && !(900..940).contains(&f) {
                ghosts.push((j, f));
            }
        }
    }
    assert_eq!(ghosts.len(), 12);
    let of = |kind: Kind| report.events.iter().filter(move |event| event.kind == kind);
    let swap: Vec<_> = of(Kind::Swap).map(|e| (e.marker, e.other, e.first, e.frames)).collect();
    assert_eq!(swap, [(Some(label("jaw03")), Some(label("jaw04")), 900, 40)]);
    let is_outlier =
        |j: usize, f: usize| of(Kind::Outlier).any(|e| e.marker == Some(j) && e.first == f && e.frames == 1);
    assert!(
        ghosts.iter().all(|&(j, f)| is_outlier(j, f)),
        "{ghosts:?} {:?}",
        of(Kind::Outlier).collect::<Vec<_>>()
    );
    let filling = [Kind::Spline, Kind::Model, Kind::Lost];
    let is_listed = |j: usize, f: usize| {
        report.events.iter().any(|e| {
            filling.contains(&e.kind) && e.marker == Some(j) && (e.first..e.first + e.frames).contains(&f)
        })
    };
    for (j, gaps) in gaps.iter().enumerate() {
        assert!(gaps.iter().all(|&f| is_listed(j, f)), "{j}");
    }
    // A measured sample that is called filled without being a ghost is a false alarm. So is every other
    // finding.
    let false_outliers = of(Kind::Outlier).count() - 12;
    let others = of(Kind::Head).count() + of(Kind::Lost).count() + of(Kind::NeverSeen).count();
    let false_fills = report
        .events
        .iter()
        .filter(|e| filling.contains(&e.kind))
        .filter(|e| {
            let j = e.marker.unwrap();
            !(e.first..e.first + e.frames).any(|f| gaps[j].contains(&f) || is_outlier(j, f))
        })
        .count();
    assert!(false_outliers + others + false_fills <= 4, "{false_outliers} {others} {false_fills}");
}

#[test]
fn the_heads_motion_is_the_true_one() {
    let Some(Cleaned { take, report }) = cleaned("data/takes/rom_3_raw.c3d") else { return };
    let text = std::fs::read_to_string(shared("data/takes/rom_3_raw_head.csv").unwrap()).unwrap();
    let truth: Vec<(DQuat, DVec3)> = text
        .lines()
        .skip(1)
        .map(|line| {
            let n: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            (DQuat::from_xyzw(n[2], n[3], n[4], n[1]).normalize(), DVec3::new(n[5], n[6], n[7]))
        })
        .collect();
    let head: Vec<(DQuat, DVec3)> = take
        .head
        .unwrap()
        .iter()
        .map(|m| (DQuat::from_array(m.rotation), DVec3::from_array(m.translation)))
        .collect();
    // Relative to the neutral frames: to the mean there.
    let relative = |motions: &[(DQuat, DVec3)]| -> Vec<(DQuat, DVec3)> {
        let neutral = &motions[report.setup.neutral.clone()];
        let first = neutral[0].0;
        let sum = neutral
            .iter()
            .fold(glam::DVec4::ZERO, |sum, (q, _)| sum + glam::DVec4::from(*q) * first.dot(*q).signum());
        let turn = DQuat::from_vec4(sum.normalize()).conjugate();
        let place = neutral.iter().map(|(_, t)| *t).sum::<DVec3>() / neutral.len() as f64;
        motions.iter().map(|(q, t)| (*q * turn, *t - place)).collect()
    };
    let pairs: Vec<_> = relative(&head).into_iter().zip(relative(&truth)).collect();
    let degrees = rms(pairs.iter().map(|((a, _), (b, _))| a.angle_between(*b).to_degrees()));
    let millimetres = rms(pairs.iter().map(|((_, a), (_, b))| 10.0 * a.distance(*b)));
    let _ = writeln!(std::io::stderr(), "head: {degrees:.4} degrees, {millimetres:.4} mm");
    assert!(degrees <= 0.1 && millimetres <= 0.3, "{degrees} {millimetres}");
}

#[test]
fn c3d_and_trc_give_the_same_take() {
    let (Some(c3d), Some(trc)) = (cleaned("data/takes/rom_3_raw.c3d"), cleaned("data/takes/rom_3_raw.trc"))
    else {
        return;
    };
    assert_eq!(c3d.take.labels, trc.take.labels);
    assert_eq!(c3d.take.confidence, trc.take.confidence);
    let worst = c3d
        .take
        .positions
        .iter()
        .zip(&trc.take.positions)
        .map(|(a, b)| 10.0 * DVec3::from_array(*a).distance(DVec3::from_array(*b)));
    let worst = worst.fold(0.0, f64::max);
    let times = c3d.take.times.iter().zip(&trc.take.times).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-3 && times < 1e-9, "{worst} {times}");
}

#[test]
fn a_clean_take_comes_back_unchanged() {
    let Some(Cleaned { take, report }) = cleaned("data/takes/rom_3_clean.csv") else { return };
    let clean =
        take::read(&shared("data/takes/rom_3_clean.csv").unwrap(), None, take::Missing::Error).unwrap();
    assert_eq!((&take.labels, &take.times), (&clean.labels, &clean.times));
    let truth: Vec<DVec3> = clean.positions.iter().map(|p| DVec3::from_array(*p)).collect();
    let worst = distances(&take, &truth).into_iter().fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst} {:?}", report.events);
    assert!(report.events.is_empty() && take.confidence.is_none());
}
