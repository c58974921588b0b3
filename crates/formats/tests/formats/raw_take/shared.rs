//! The real raw take, where `../shared/data` lies beside the repository.
use super::is_missing;
use rhytid_formats::raw_take::{is_take_csv, read};
use rhytid_test_support::shared;

#[test]
fn the_real_c3d_and_trc_are_one_take() {
    let (Some(c3d), Some(trc)) = (shared("data/takes/rom_3_raw.c3d"), shared("data/takes/rom_3_raw.trc"))
    else {
        return;
    };
    assert!(!is_take_csv(&c3d) && !is_take_csv(&trc));
    let [c3d, trc] = [c3d, trc].map(|path| read(&path, None).unwrap());
    assert_eq!((c3d.warnings.as_slice(), trc.warnings.as_slice()), (&[][..], &[][..]));
    assert_eq!((c3d.metres_per_unit, trc.metres_per_unit), (Some(0.001), Some(0.001)));
    let (a, b) = (&c3d.tracks, &trc.tracks);
    assert_eq!((a.labels.len(), a.frames(), a.rate()), (93, 2400, 120.0));
    assert_eq!((&a.labels, &a.times), (&b.labels, &b.times));
    assert_eq!((&a.confidence, &b.confidence), (&None, &None));
    let gaps = a.positions.iter().filter(|p| is_missing(p)).count();
    assert_eq!(gaps, 12_657 / 3);
    for (i, (p, q)) in a.positions.iter().zip(&b.positions).enumerate() {
        // The text has five digits behind the point, the binary file single precision.
        let step = |x: f64| 0.501e-5 + f64::from(f32::EPSILON) / 2.0 * x.abs();
        let near = p.iter().zip(q).all(|(x, y)| (x - y).abs() <= step(*y));
        assert!(is_missing(p) == is_missing(q) && (near || is_missing(p)), "{i}: {p:?} {q:?}");
    }
}

#[test]
fn the_clean_take_is_the_takes_own_csv() {
    let Some(clean) = shared("data/takes/rom_3_clean.csv") else { return };
    assert!(is_take_csv(&clean));
    let take = read(&clean, None).unwrap();
    assert!(take.in_head_space && take.metres_per_unit.is_none());
    assert_eq!((take.tracks.labels.len(), take.tracks.frames()), (89, 4030));
}
